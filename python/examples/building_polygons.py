#!/usr/bin/env python3
"""building_polygons.py: from a list of polygons of a room to view factors, total exchange factors and mean radiant temperatures.

The room has the shape of an L, a window in a wall, and a person as a box in the middle. Polygons may have any number of corners, counter-clockwise seen from
inside. The wall around the window is cut into rectangles.
"""

import numpy as np

import zonal as zn

SIGMA = 5.670374419e-8
L = [[0, 0], [6, 0], [6, 3], [3, 3], [3, 6], [0, 6]]
HEIGHT = 2.7


def surfaces():
    """Name, corners, temperature in degrees Celsius, emissivity."""
    floor = [[x, y, 0.0] for x, y in L]
    out = [("floor", floor, 22.0, 0.9), ("ceiling", [[x, y, HEIGHT] for x, y in L][::-1], 20.0, 0.9)]
    for k in range(1, 6):
        (x0, y0), (x1, y1) = L[k], L[(k + 1) % 6]
        out.append((f"wall {k}", [[x0, y0, 0], [x0, y0, HEIGHT], [x1, y1, HEIGHT], [x1, y1, 0]], 18.0, 0.9))
    # The wall y = 0 with its window.
    xs, zs = [0.0, 1.5, 4.5, 6.0], [0.0, 0.9, 2.2, HEIGHT]
    for i in range(3):
        for j in range(3):
            x, z = xs[i : i + 2], zs[j : j + 2]
            window = (i, j) == (1, 1)
            corners = [[x[0], 0, z[0]], [x[0], 0, z[1]], [x[1], 0, z[1]], [x[1], 0, z[0]]]
            out.append(("window" if window else "wall 0", corners, 5.0 if window else 18.0, 0.84 if window else 0.9))
    return out


def person(x=2.0, y=1.5, size=(0.3, 0.3, 1.1), above=0.1):
    """The six faces of a box, outwards."""
    low = np.array([x, y, above])
    corner = [low + np.array([k & 1, k >> 1 & 1, k >> 2]) * size for k in range(8)]
    return [[corner[v] for v in face] for face in ([0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5])]


def main():
    listed = surfaces() + [("person", corners, 32.0, 0.95) for corners in person()]
    corners = [c for _, polygon, _, _ in listed for c in polygon]
    starts = np.cumsum([0, *[len(polygon) for _, polygon, _, _ in listed]])
    faces = [list(range(a, b)) for a, b in zip(starts[:-1], starts[1:])]

    factors = zn.view_factors((np.array(corners, dtype=float), faces), surroundings=False)
    rooms = factors.combined([name for name, *_ in listed])
    print(f"{len(factors)} polygons, {len(rooms)} surfaces, row sums {factors.row_sums.min():.9f} to {factors.row_sums.max():.9f}")

    first = {name: (t + 273.15, e) for name, _, t, e in reversed(listed)}
    kelvin, emissivity = (np.array([first[name][k] for name in rooms.names]) for k in (0, 1))
    script, radii = rooms.script_f(emissivity)
    power = rooms.areas * ((script * SIGMA * kelvin[:, None] ** 4).sum(axis=1) - script @ (SIGMA * kelvin**4))
    # Mean radiant temperature of a surface: that of a black enclosure with the same radiation, reflections included.
    matrix = rooms.matrix.toarray()
    radiosity = np.linalg.solve(np.eye(len(rooms)) - (1 - emissivity)[:, None] * matrix, emissivity * SIGMA * kelvin**4)
    others = 1 - np.diag(matrix)
    seen = (matrix @ radiosity - np.diag(matrix) * radiosity) / others
    radiant = (seen / SIGMA) ** 0.25 - 273.15
    print(f"{'surface':10} {'area m2':>8} {'T C':>6} {'MRT C':>7} {'net W':>8} {'F to window':>12} {'script F':>9} {'radius':>8}")
    window = rooms.names.index("window")
    for k, name in enumerate(rooms.names):
        columns = (rooms.areas[k], kelvin[k] - 273.15, radiant[k], power[k], matrix[k, window], script[k, window], radii[k, window])
        print("{:10} {:8.2f} {:6.1f} {:7.2f} {:8.1f} {:12.5f} {:9.5f} {:8.1e}".format(name, *columns))
    print(f"mean radiant temperature of the person {radiant[rooms.names.index('person')]:.2f} C")


if __name__ == "__main__":
    main()
