#!/usr/bin/env python3
"""Times the phases of solves on several numbers of threads, and shows where only one thread works.

    scripts/scaling.py [--zonal target/release/zonal] [--threads 1,2] [--cases box,gallery] [--rounds 1]
                       [--limit SECONDS] [--against OTHER/zonal] [--phases] [--json FILE]

A line for each case and number of threads has the wall time, its ratio to one thread, the processor time, the largest memory and the serial time:
the wall time in which one thread works alone, summed over the phases of `zonal --timings` as (n wall - processor)/(n - 1) on n threads, and over
the wall time on one thread as a share. `--phases` prints the phases too. `--against` runs another binary in turn and prints the ratio of wall times.
`--limit` ends before the run that would pass it. The default on 16 threads takes about four minutes. Solutions are written to a temporary folder and
removed. Cases that need ../shared are left out without it. Python 3 without packages.
"""
import argparse
import json
import os
import pathlib
import random
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent

CUBE = """[solve]
patch_rule = "voxels"
residual = 1e-8
engine = "spectral"
[medium]
min = [0, 0, 0]
max = [1, 1, 1]
cells = [{n}, {n}, {n}]
extinction = {extinction}
albedo = 0.9
[[surface]]
name = "cube"
room = {{ min = [0, 0, 0], max = [1, 1, 1] }}
reflectance = 0.5
faces.z0 = {{ emission = 1 }}
"""

FURNACE = """mode = "thermal"
[solve]
engine = "spectral"
patch_rule = "voxels"
discretization_error = false
[[surface]]
name = "furnace"
room = { min = [0, 0, 0], max = [2, 2, 4] }
emissivity = 0.8
faces.z0 = { temperature = 1200 }
faces.z1 = { emissivity = 0.7, temperature = 400 }
faces.x0 = { temperature = 800 }
faces.x1 = { temperature = 800 }
faces.y0 = { temperature = 800 }
faces.y1 = { temperature = 800 }
[medium]
min = [0, 0, 0]
max = [2, 2, 4]
cells = [32, 32, 64]
gas = { model = "wsgg-bordbar-2020", h2o = 0.2, co2 = 0.1 }
heat_source = 5000
"""


def city():
    """An OBJ of 7 x 6 blocks of 40 m, each with a building: 3,696 triangles."""
    numbers = random.Random(1)
    vertices, faces = [], []

    def divide(at, edges, n, m):
        first = len(vertices) + 1
        for i in range(n + 1):
            for j in range(m + 1):
                vertices.append([at[c] + edges[0][c] * i / n + edges[1][c] * j / m for c in range(3)])
        for i in range(n):
            for j in range(m):
                p, q = first + i * (m + 1) + j, first + (i + 1) * (m + 1) + j
                faces.extend([(p, q, q + 1), (p, q + 1, p + 1)])

    for k in range(42):
        x, y = 40.0 * (k // 6), 40.0 * (k % 6)
        u = [numbers.random() for _ in range(5)]
        xs, ys = [x, x + 6 + 4 * u[0], x + 30 + 4 * u[2], x + 40], [y, y + 6 + 4 * u[1], y + 30 + 4 * u[3], y + 40]
        h = 10 + 30 * u[4] ** 2
        for a in range(3):
            for b in range(3):
                if (a, b) != (1, 1):
                    divide([xs[a], ys[b], 0], [[xs[a + 1] - xs[a], 0, 0], [0, ys[b + 1] - ys[b], 0]], 1, 1)
        dx, dy = [xs[2] - xs[1], 0, 0], [0, ys[2] - ys[1], 0]
        back = [-dx[0], 0, 0], [0, -dy[1], 0]
        for at, along in [((xs[1], ys[1]), dx), ((xs[2], ys[1]), dy), ((xs[2], ys[2]), back[0]), ((xs[1], ys[2]), back[1])]:
            divide([*at, 0], [along, [0, 0, h]], 2, 4)
        divide([xs[1], ys[1], h], [dx, dy], 2, 2)
    lines = ["v %.17g %.17g %.17g" % tuple(v) for v in vertices] + ["f %d %d %d" % f for f in faces]
    return "\n".join(lines) + "\n"


def shared_scene(name, replacements):
    """The text of a scene of scenes/, with absolute paths of its files and other settings; none without its files."""
    text = (ROOT / "scenes" / name).read_text().replace("../../shared", str(ROOT.parent / "shared"))
    for old, new in replacements:
        assert old in text, (name, old)
        text = text.replace(old, new)
    return text if (ROOT.parent / "shared" / "data").is_dir() else None


class Case:
    """A run of the command: its scene, and the numbers of threads that it is worth."""

    def __init__(self, text, suffix=".toml", arguments=("solve",), fewest=1):
        self.text, self.suffix, self.arguments, self.fewest = text, suffix, arguments, fewest


def cases():
    return {
        "box": Case(CUBE.format(n=115, extinction="2")),
        "bands": Case(CUBE.format(n=115, extinction="[2, 2.3, 1.7]")),
        "large": Case(CUBE.format(n=256, extinction="2")),
        "city": Case(city(), ".obj", ("view-factors",)),
        "gallery": Case(shared_scene("vr-gallery.toml", [("tolerance = 0.02", "tolerance = 0.05")])),
        "bays": Case("", "", ("demo", "bays", "--size", "small")),
        "furnace": Case(FURNACE),
        "sponza": Case(shared_scene("sponza.toml", [("tolerance = 0.11", "tolerance = 0.3")]), fewest=4),
    }


def run(binary, case, name, threads, folder):
    """Wall time, processor time, memory (s, s, bytes) and the phases of one run."""
    command = [str(binary), *case.arguments, "--threads", str(threads), "--json", "--quiet"]
    if case.suffix:
        scene = folder / (name + case.suffix)
        scene.write_text(case.text)
        command += [str(scene), "-o", str(folder / "out.npz")]
    else:
        command += ["-o", str(folder / "out")]
    if timings_of(binary):
        command.append("--timings")
    begin = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.PIPE)
    report = process.stdout.read()
    _, status, used = os.wait4(process.pid, 0)
    wall = time.monotonic() - begin
    if status:
        sys.exit(f"{name}: {' '.join(command)} ended with status {status}")
    phases = json.loads(report).get("timings", {}).get("phases", []) if timings_of(binary) else []
    return wall, used.ru_utime + used.ru_stime, used.ru_maxrss * 1024, phases


def timings_of(binary, known={}):
    """Whether a binary has the option --timings."""
    if binary not in known:
        known[binary] = b"--timings" in subprocess.run([binary, "solve", "--help"], capture_output=True).stdout
    return known[binary]


def serial_time(phases, threads):
    """The wall time in which one thread works alone, s."""
    idle = (threads * p["wall_s"] - p["processor_s"] for p in phases)
    return sum(max(0.0, t) for t in idle) / (threads - 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--zonal", type=pathlib.Path, default=ROOT / "target/release/zonal")
    parser.add_argument("--threads", default=None, help="numbers of threads, by commas (default: 1 and all; Sponza from 4)")
    parser.add_argument("--cases", default=None, help="cases, by commas: " + ", ".join(cases()))
    parser.add_argument("--rounds", type=int, default=1, help="runs of each kind; medians are printed")
    parser.add_argument("--limit", type=float, default=float("inf"), help="seconds for all runs")
    parser.add_argument("--against", type=pathlib.Path, default=None, help="another binary, which runs in turn")
    parser.add_argument("--phases", action="store_true", help="print the phases")
    parser.add_argument("--json", type=pathlib.Path, default=None, help="file for all figures")
    options = parser.parse_args()
    cores = len(os.sched_getaffinity(0))
    threads = [int(t) for t in options.threads.split(",")] if options.threads else sorted({1, cores})
    chosen = options.cases.split(",") if options.cases else list(cases())
    begin, figures = time.monotonic(), []
    print(f"{'case':10}{'threads':>8}{'wall s':>9}{'speed-up':>10}{'processor s':>13}{'memory GB':>11}{'serial s':>10}{'share':>9}" + ("   to other" if options.against else ""))
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for name in chosen:
            case, first = cases()[name], None
            if case.text is None:
                print(f"{name:10} left out: needs ../shared")
                continue
            own = threads
            if case.fewest > 1 and not options.threads:
                own = sorted({min(case.fewest, cores), cores})
            for n in own:
                if first is not None and time.monotonic() - begin + 1.2 * first[0] * first[1] / n > options.limit:
                    print(f"{name:10}{n:8} left out: --limit")
                    continue
                runs, other = [], []
                for _ in range(options.rounds):
                    runs.append(run(options.zonal, case, name, n, folder))
                    if options.against:
                        other.append(run(options.against, case, name, n, folder)[0])
                wall, processor, memory = (statistics.median(r[i] for r in runs) for i in range(3))
                first = first or (wall, n)
                phases = runs[-1][3]
                serial = serial_time(phases, n) if n > 1 and phases else None
                line = f"{name:10}{n:8}{wall:9.2f}{first[0] / wall:10.2f}{processor:13.2f}{memory / 1e9:11.2f}"
                share = serial / (first[0] * first[1]) if serial is not None else None
                line += f"{serial:10.2f}{100 * share:8.1f}%" if serial is not None else ""
                if other:
                    ratio = statistics.median(r[0] / o for r, o in zip(runs, other))
                    line += f"{ratio:11.3f}"
                print(line, flush=True)
                if options.phases:
                    for p in phases:
                        print(f"    {p['name']:38}{p['wall_s']:9.3f} s{p['processor_s'] / max(p['wall_s'], 1e-9):7.2f} threads")
                figures.append({"case": name, "threads": n, "wall_s": wall, "processor_s": processor, "memory_bytes": memory, "serial_s": serial, "phases": phases})
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1))
    print(f"total {time.monotonic() - begin:.0f} s")


if __name__ == "__main__":
    main()
