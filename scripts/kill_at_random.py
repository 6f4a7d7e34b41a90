#!/usr/bin/env python3
"""Kills solve, render, export and animate at random moments and looks what they leave.

    scripts/kill_at_random.py [--zonal target/release/zonal] [--kills 100] [--seed 1]

Each kill (SIGKILL, at a moment drawn evenly from the time that the command takes) is followed by the same command, which must succeed; a
solve goes on from its checkpoint. Then the output must be that of an undisturbed run to the byte, and no temporary file may be left: neither
`.*.partial` nor a checkpoint. After the kill itself the output must be whole: the old file, the new one, or none. Python 3 without packages.
"""
import argparse
import collections
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

SCENE = """[solve]
patch_rule = "voxels"
[[surface]]
name = "room"
room = { min = [0, 0, 0], max = [1, 1, 1] }
reflectance = 0.5
faces.z1 = { emission = 1 }
[medium]
min = [0, 0, 0]
max = [1, 1, 1]
cells = [10, 10, 10]
extinction = 2
albedo = 0.9
[[camera]]
name = "c"
origin = [0.5, 0.1, 0.5]
target = [0.5, 1, 0.4]
"""
FLIGHT = """frames_per_second = 4
exposure = 1
[[key]]
time = 0
camera = "c"
[[key]]
time = 1
origin = [0.5, 0.3, 0.5]
target = [0.5, 1, 0.4]
"""
FORMS = ["csv", "html", "glb", "vtu", "vti"]


def command(kind, out):
    if kind == "solve":
        return ["solve", "scene.toml", "-o", f"{out}/x.npz", "--checkpoint", "--resume"]
    if kind == "render":
        return ["render", "run.npz", "--size", "160x120", "-o", f"{out}/x.png"]
    if kind == "animate":
        return ["render", "run.npz", "--animate", "flight.toml", "--size", "48x36", "-o", f"{out}/frames"]
    return ["export", "run.npz", "-o", f"{out}/x.{kind}"]


def listing(folder):
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def temporary(names):
    return [n for n in names if ".partial" in n or ".checkpoint" in n or "zonal-probe" in n]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--zonal", default="target/release/zonal")
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    zonal = str(pathlib.Path(args.zonal).resolve())
    dice = random.Random(args.seed)
    work = pathlib.Path(tempfile.mkdtemp(prefix="zonal-kills-"))
    wrong, tally = [], collections.Counter()

    def run(words):
        return subprocess.run([zonal, *words], cwd=work, capture_output=True, text=True)

    try:
        (work / "scene.toml").write_text(SCENE)
        (work / "flight.toml").write_text(FLIGHT)
        (work / "whole").mkdir()
        first = run(["solve", "scene.toml", "-o", "run.npz"])
        if first.returncode:
            sys.exit(first.stderr)
        whole, seconds = {}, {}
        kinds = ["solve", "render", "animate", *FORMS]
        for kind in kinds:
            begin = time.monotonic()
            done = run(command(kind, "whole"))
            seconds[kind] = time.monotonic() - begin
            if done.returncode:
                sys.exit(f"{kind}: {done.stderr}")
            whole[kind] = listing(work / "whole")
            shutil.rmtree(work / "whole")
            (work / "whole").mkdir()
        for k in range(args.kills):
            # Half of the kills meet solve and animate, which leave most behind.
            kind = ["solve", "animate", "render", FORMS[k // 4 % len(FORMS)]][k % 4]
            out = work / f"out{k}"
            out.mkdir()
            if k % 3 == 0 and kind not in ("solve", "animate"):
                run(command(kind, out.name))  # An old file to be replaced.
            process = subprocess.Popen(
                [zonal, *command(kind, out.name)], cwd=work, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
            )
            time.sleep(dice.uniform(0, 1.1 * seconds[kind]))
            process.kill()
            killed = process.wait() < 0
            tally["killed" if killed else "done before the kill"] += 1
            left = listing(out)
            torn = temporary(left)
            tally["left a temporary file or a checkpoint"] += bool(torn)
            plain = {n: b for n, b in left.items() if n not in torn}
            if any(whole[kind].get(n) != b for n, b in plain.items() if not n.endswith(".mp4")):
                wrong.append(f"kill {k}, {kind}: a file is torn")
            again = run(command(kind, out.name))
            after = listing(out)
            if again.returncode:
                wrong.append(f"kill {k}, {kind}: {again.stderr.strip()}")
            elif temporary(after):
                wrong.append(f"kill {k}, {kind}: left {temporary(after)}")
            elif after != whole[kind]:
                wrong.append(f"kill {k}, {kind}: differs from an undisturbed run")
            shutil.rmtree(out)
    finally:
        shutil.rmtree(work, ignore_errors=True)
    print(", ".join(f"{n} {what}" for what, n in sorted(tally.items())))
    print("\n".join(wrong) or f"{args.kills} kills: all whole, the next run as if undisturbed, nothing left")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
