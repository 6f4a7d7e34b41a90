"""Writes mixed.vdb beside this file, with OpenVDB 10.0.1 (format 224, Blosc); CC0.

Grids: vel (vectors), half (saved as half floats), density (floats). The last two hold the same values: 14 x 7 x 9 voxels with
every third left out, and an active tile of 128 voxels an edge.
"""
import pathlib
import pyopenvdb as vdb


def cloud(name):
    grid = vdb.FloatGrid(0.0)
    voxels = grid.getAccessor()
    for x in range(-5, 9):
        for y in range(7):
            for z in range(3, 12):
                if (x * y + z) % 3:
                    voxels.setValueOn((x, y, z), ((x * x + 3 * y + z) % 17) * 0.125)
    grid.fill((128, 0, 0), (255, 127, 127), 0.25)
    grid.transform = vdb.createLinearTransform([[0.5, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 0.25, 0], [1, 2, 3, 1]])
    grid.name = name
    return grid


vectors = vdb.Vec3SGrid()
vectors.name = "vel"
vectors.getAccessor().setValueOn((1, 2, 3), (1, 2, 3))
half = cloud("half")
half.saveFloatAsHalf = True
vdb.write(str(pathlib.Path(__file__).with_suffix(".vdb")), grids=[vectors, half, cloud("density")])
