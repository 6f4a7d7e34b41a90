#!/usr/bin/env python3
"""View factors of a small city by View3D and by zonal, in one run: processor time, memory, largest factor, sums of rows.

    cargo build --release
    python benches/peers/view3d/compare.py --view3d PATH/view3d [--blocks 3 3] [--zonal target/release/zonal]

View3D (github.com/jasondegraw/View3D, public domain) is built by its own makefile. Both read the same .vs3 file and write View3D's text format.
"""

import argparse
import os
import pathlib
import subprocess
import tempfile

import numpy as np

from city import city, write_vs3


def measured(command):
    """Processor seconds and peak memory in MiB of a command."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        raise SystemExit(f"{command[0]} ended with status {status}")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def factors(path):
    """The matrix of a text file of View3D."""
    lines = path.read_text().splitlines()
    n = len(lines[1].split())
    return np.array([[float(x) for x in line.split()] for line in lines[2 : 2 + n]])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--view3d", required=True)
    parser.add_argument("--zonal", default="target/release/zonal")
    parser.add_argument("--blocks", type=int, nargs=2, default=(3, 3))
    args = parser.parse_args()
    triangles = city(*args.blocks)
    with tempfile.TemporaryDirectory() as folder:
        scene = pathlib.Path(folder, "city.vs3")
        write_vs3(scene, triangles, output=0)
        rows = []
        for name, command in (
            ("View3D", [args.view3d, scene, pathlib.Path(folder, "a.txt")]),
            ("zonal", [args.zonal, "view-factors", scene, "-o", pathlib.Path(folder, "b.txt"), "--quiet"]),
        ):
            rows.append((name, *measured(command)))
        # Read afterwards: the peak memory of a child includes this process before it starts.
        rows = [(*row, factors(pathlib.Path(folder, file))) for row, file in zip(rows, ("a.txt", "b.txt"))]
    print(f"{len(triangles)} triangles\n\n| | processor time, s | memory, MiB | largest factor | largest sum of a row |\n|---|---|---|---|---|")
    for name, seconds, memory, f in rows:
        print(f"| {name} | {seconds:.2f} | {memory:.0f} | {f.max():.4f} | {f.sum(1).max():.4f} |")
    a, b = rows[0][3], rows[1][3]
    print(f"\nlargest difference of a factor {abs(a - b).max():.1e}, root mean square {np.sqrt(((a - b) ** 2).mean()):.1e}")


if __name__ == "__main__":
    main()
