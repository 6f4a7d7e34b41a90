#!/usr/bin/env python3
"""View factors of a small city by View3D and by zonal, in one run: processor time, memory, largest factor, sums of rows.

    cargo build --release
    python peers/view3d/compare.py --view3d PATH/view3d [--blocks 3 3] [--zonal target/release/zonal]

View3D (github.com/jasondegraw/View3D, public domain) is built by its own makefile. Both read the same .vs3 file and write View3D's text format.
"""

import pathlib
import sys
import tempfile

import numpy as np

from city import city, write_vs3

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from shared import cost, head, parser, row  # noqa: E402


def factors(path):
    """The matrix of a text file of View3D."""
    lines = path.read_text().splitlines()
    n = len(lines[1].split())
    return np.array([[float(x) for x in line.split()] for line in lines[2 : 2 + n]])


def main():
    p = parser(__doc__)
    p.add_argument("--view3d", required=True)
    p.add_argument("--blocks", type=int, nargs=2, default=(3, 3))
    args = p.parse_args()
    triangles = city(*args.blocks)
    with tempfile.TemporaryDirectory() as folder:
        scene = pathlib.Path(folder, "city.vs3")
        write_vs3(scene, triangles, output=0)
        rows = []
        for name, command in (
            ("View3D", [args.view3d, scene, pathlib.Path(folder, "a.txt")]),
            ("zonal", [args.zonal, "view-factors", scene, "-o", pathlib.Path(folder, "b.txt"), "--quiet"]),
        ):
            rows.append((name, *cost(command)))
        # Read afterwards: the peak memory of a child includes this process before it starts.
        rows = [(*r, factors(pathlib.Path(folder, file))) for r, file in zip(rows, ("a.txt", "b.txt"))]
    print(f"{len(triangles)} triangles\n")
    head("", "processor time, s", "memory, MiB", "largest factor", "largest sum of a row")
    for name, seconds, memory, f in rows:
        row(name, f"{seconds:.2f}", f"{memory:.0f}", f"{f.max():.4f}", f"{f.sum(1).max():.4f}")
    a, b = rows[0][3], rows[1][3]
    print(f"\nlargest difference of a factor {abs(a - b).max():.1e}, root mean square {np.sqrt(((a - b) ** 2).mean()):.1e}")


if __name__ == "__main__":
    main()
