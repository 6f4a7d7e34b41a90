#!/usr/bin/env python3
"""Writes a city of boxes on a plane as a binary STL and as an input file of View3D.

    python peers/view3d/city.py 18 14 city            # city.stl and city.vs3 with 22,176 triangles

Each block of 40 m has 16 triangles of ground and one building with 64 triangles of walls and 8 of roof. Buildings are about 24 m wide and 10 to 40 m high
(repeatable by their seed).
"""

import argparse
import pathlib

import numpy as np

BLOCK = 40.0


def cells(at, e, f, n, m):
    """Triangles of a parallelogram in n × m cells."""
    u, v = np.arange(n + 1)[:, None, None] / n, np.arange(m + 1)[None, :, None] / m
    p = np.asarray(at) + u * np.asarray(e) + v * np.asarray(f)
    a, b, c, d = p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]
    return np.stack([np.stack([a, b, c], -2), np.stack([a, c, d], -2)], 2).reshape(-1, 3, 3)


def city(columns, rows, seed=1):
    """Triangles of the city, shape (n, 3, 3), fronts outwards."""
    random = np.random.default_rng(seed)
    out = []
    for i in range(columns):
        for j in range(rows):
            x, y = i * BLOCK, j * BLOCK
            x0, y0 = x + 6 + 4 * random.random(), y + 6 + 4 * random.random()
            x1, y1 = x + 30 + 4 * random.random(), y + 30 + 4 * random.random()
            height = 10 + 30 * random.random() * random.random()
            xs, ys = [x, x0, x1, x + BLOCK], [y, y0, y1, y + BLOCK]
            for u in range(3):
                for v in range(3):
                    if (u, v) != (1, 1):
                        out.append(cells([xs[u], ys[v], 0], [xs[u + 1] - xs[u], 0, 0], [0, ys[v + 1] - ys[v], 0], 1, 1))
            dx, dy, up = np.array([x1 - x0, 0, 0]), np.array([0, y1 - y0, 0]), [0, 0, height]
            for at, along in (([x0, y0, 0], dx), ([x1, y0, 0], dy), ([x1, y1, 0], -dx), ([x0, y1, 0], -dy)):
                out.append(cells(at, along, up, 2, 4))
            out.append(cells([x0, y0, height], dx, dy, 2, 2))
    return np.concatenate(out).astype(np.float32)


def write_stl(path, triangles):
    record = np.zeros(len(triangles), np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("pad", "<u2")]))
    record["corners"] = triangles
    path.write_bytes(bytes(80) + np.uint32(len(triangles)).tobytes() + record.tobytes())


def write_vs3(path, triangles, output=2):
    points, faces = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    faces = faces.reshape(-1, 3) + 1
    lines = ["T", f"C out={output} row=0 col=0", "F 3"]
    lines += [f"V {k} {p[0]:.6f} {p[1]:.6f} {p[2]:.6f}" for k, p in enumerate(points, 1)]
    lines += [f"S {k} {f[0]} {f[1]} {f[2]} 0 0 0 0.9 {k}" for k, f in enumerate(faces, 1)]
    path.write_text("\n".join(lines) + "\nEnd of Data\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("columns", type=int)
    parser.add_argument("rows", type=int)
    parser.add_argument("name")
    args = parser.parse_args()
    triangles = city(args.columns, args.rows)
    write_stl(pathlib.Path(args.name + ".stl"), triangles)
    write_vs3(pathlib.Path(args.name + ".vs3"), triangles)
    print(f"{len(triangles)} triangles")


if __name__ == "__main__":
    main()
