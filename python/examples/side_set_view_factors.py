#!/usr/bin/env python3
"""side_set_view_factors.py [MESH [OUTPUT.csv]]: view factors between the named parts of a mesh, as CSV keyed by the names.

MESH is a file with named parts: OBJ (`usemtl`), glTF (materials), or any file that meshio reads with physical groups of gmsh (`.msh`). Faces look into the
cavity. Without one, the cavity between two coaxial cylinders with end plates is used. The columns are `from, to, view_factor, error_radius, area`; a finite
element code reads one line for each pair of side sets. Factors are from the first to the second name, `area` is that of the first.
"""

import csv
import sys

import numpy as np

import zonal as zn


def coaxial_cylinders(radii=(0.3, 1.0), length=2.0, sectors=16, layers=4):
    """The cavity between two cylinders of quadrilaterals: vertices, faces, and the name of each face."""
    vertices, faces, names = [], [], []

    def add(corners, name):
        faces.append(list(range(len(vertices), len(vertices) + 4)))
        vertices.extend(corners)
        names.append(name)

    def point(radius, k, z):
        return [radius * np.cos(2 * np.pi * k / sectors), radius * np.sin(2 * np.pi * k / sectors), z]

    inner, outer = radii
    for k in range(sectors):
        for j in range(layers):
            low, high = length * j / layers, length * (j + 1) / layers
            add([point(inner, k, low), point(inner, k + 1, low), point(inner, k + 1, high), point(inner, k, high)], "inner")
            add([point(outer, k, low), point(outer, k, high), point(outer, k + 1, high), point(outer, k + 1, low)], "outer")
        add([point(inner, k, 0), point(outer, k, 0), point(outer, k + 1, 0), point(inner, k + 1, 0)], "left")
        add([point(inner, k, length), point(inner, k + 1, length), point(outer, k + 1, length), point(outer, k, length)], "right")
    return np.array(vertices), np.array(faces), names


def main():
    if len(sys.argv) > 1:
        mesh = sys.argv[1]
        if mesh.endswith(".msh"):
            import meshio

            mesh = meshio.read(mesh)
        factors = zn.view_factors(mesh, surroundings=False)
        names = factors.materials
    else:
        vertices, faces, names = coaxial_cylinders()
        factors = zn.view_factors((vertices, faces), surroundings=False)
    sides = factors.combined(names)
    values, radii = sides.matrix.toarray(), sides.radius.toarray()
    with open(sys.argv[2] if len(sys.argv) > 2 else "view_factors.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["from", "to", "view_factor", "error_radius", "area"])
        for i, a in enumerate(sides.names):
            for j, b in enumerate(sides.names):
                writer.writerow([a, b, repr(float(values[i, j])), f"{radii[i, j]:.2e}", repr(float(sides.areas[i]))])
    print(f"{len(factors)} faces, {len(sides)} side sets: {', '.join(sides.names)}; largest defect before closing {np.abs(factors.defect).max():.1e}")


if __name__ == "__main__":
    main()
