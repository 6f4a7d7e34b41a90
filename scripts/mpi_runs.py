#!/usr/bin/env python3
"""Solves scenes on several ranks of MPI and compares the bytes of the solutions with those of one process.

    scripts/mpi_runs.py ranks [--quick] [--zonal target/release/zonal] [--mpi target/release/zonal-mpi] [--mpirun mpirun]
    scripts/mpi_runs.py kills [--times 30] [--scene scene.toml] ...

`ranks` solves scenes of all engines, light and heat, on 1, 2, 3, 4 and 7 ranks with one or two threads each; `--quick` takes some of them on 2
and 3 ranks. `kills` kills one of four ranks at a random moment of a solve with a checkpoint, and resumes on three: every run must end by
itself, with one line `error:` of zonal where it was killed. Python 3 without packages.
"""
import argparse
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

# Longest time of a run, s: one that takes longer hangs.
LIMIT = 300

ROOM = """[[surface]]
name = "room"
room = { min = [0, 0, 0], max = [2, 2, 2] }
omit = ["z1"]
reflectance = 0.5
[[surface]]
name = "block"
box = { min = [0.7, 0.6, 0], max = [1.3, 1.4, 0.9], rotate_z_degrees = 20 }
reflectance = 0.6
[[surface]]
name = "lamp"
rectangle = { origin = [0.6, 0.7, 1.95], edge1 = [0, 0.6, 0], edge2 = [0.8, 0, 0] }
emission = 10
[[light]]
kind = "emitter"
surface = "lamp"
[surroundings]
radiance = 2
"""
HAZE = """[medium]
min = [0, 0, 0]
max = [2, 2, 2]
cells = [5, 5, 5]
extinction = 0.4
albedo = 0.5
"""
SUN = """[[light]]
kind = "sun"
direction = [0.3, 0.2, -1]
irradiance = 100
angular_diameter = 2
"""
GLASS = """[[pane]]
name = "glass"
polygon = [[0.2, 0.1, 1.6], [1.6, 0.1, 1.6], [1.6, 1.6, 1.6], [0.2, 1.6, 1.6]]
thickness = 0.01
extinction = [20, 40, 80]
albedo = 0.1
"""


def box(cells, omit="", medium="extinction = 0.5\nalbedo = 0.7\n", walls="reflectance = 0.5\nfaces.z1 = { emission = 10 }\n"):
    """A box on the grid of its medium."""
    size = [c / 8 for c in cells]
    return (
        f'[[surface]]\nname = "room"\nroom = {{ min = [0, 0, 0], max = {size} }}\n{omit}{walls}'
        f"[medium]\nmin = [0, 0, 0]\nmax = {size}\ncells = {cells}\n{medium}"
    )


def light(engine, text, more=""):
    return f'[solve]\ntolerance = 0.1\npatch_size = 0.4\nengine = "{engine}"\n{more}{text}'


def heat(engine, text, more=""):
    return f'mode = "thermal"\n[solve]\ntolerance = 0.05\npatch_size = 0.5\nengine = "{engine}"\n{more}{text}'


VOXELS = 'patch_rule = "voxels"\n'
WALLS = "emissivity = 0.6\ntemperature = 500\nfaces.z1 = { temperature = 1200 }\n"
SOURCE = "extinction = 0.5\nheat_source = 100\n"
SCENES = {
    "rays": light("rays", ROOM + HAZE),
    "panes": light("rays", ROOM + GLASS + SUN),
    "pairs": light("dense", ROOM + HAZE + SUN),
    "box": light("spectral", box([16, 9, 8]), VOXELS),
    "coloured": light("spectral", box([11, 8, 9], medium="extinction = [0.5, 0.5, 0.9]\nalbedo = 0.7\n"), VOXELS),
    # Blocks of voxels correct the iteration.
    "blocks": light("spectral", box([64, 64, 32]), VOXELS),
    "open": light("spectral", box([9, 12, 8], 'omit = ["x0"]\n') + "[surroundings]\nradiance = 2\n" + SUN, VOXELS),
    "thick": light("spectral", box([10, 8, 8], medium="extinction = 9\nalbedo = 0.7\n"), VOXELS),
    "periodic": light("spectral", '[boundary]\ny = "periodic"\n' + box([10, 5, 8], 'omit = ["y0", "y1"]\n'), VOXELS),
    "layers": light(
        "layered",
        '[boundary]\nx = "periodic"\ny = "periodic"\n'
        + box([2, 2, 20], 'omit = ["x0", "x1", "y0", "y1"]\n', "extinction = 0.5\nalbedo = 0.7\n")
        + '[[medium.region]]\nbox = { min = [0, 0, 1], max = [1, 1, 2] }\nextinction = 2\nalbedo = 0.7\n',
        VOXELS,
    ),
    "heat": heat("dense", box([4, 4, 4], walls=WALLS, medium=SOURCE)),
    "furnace": heat("spectral", box([12, 8, 9], walls=WALLS, medium=SOURCE), VOXELS),
    "quarter": heat(
        "spectral",
        '[boundary]\nx0 = "symmetry"\n' + box([8, 8, 8], 'omit = ["x0"]\n', SOURCE, WALLS),
        VOXELS + "discretization_error = false\n",
    ),
    "gas": heat(
        "auto",
        box(
            [5, 5, 5],
            walls=WALLS,
            medium='gas = { model = "wsgg-bordbar-2020", h2o = 0.2, co2 = 0.1, pressure = 101325 }\nheat_source = 5000\n',
        ),
    ),
    "bodies": heat(
        "rays",
        '[[node]]\nname = "plate"\nnet_power = 50\n[[surface]]\nname = "plate"\n'
        "box = { min = [0.2, 0.2, 0.2], max = [0.4, 0.4, 0.25] }\nemissivity = 0.5\nnode = \"plate\"\n"
        + box([4, 4, 4], walls=WALLS, medium=SOURCE),
        "discretization_error = true\n",
    ),
}
QUICK = ["rays", "pairs", "coloured", "blocks", "open", "furnace"]


def last_line(text):
    lines = [line for line in text.splitlines() if line.startswith("error:")] or text.strip().splitlines()
    return lines[-1] if lines else "no message"


class Runs:
    def __init__(self, arguments, folder):
        self.zonal, self.mpi = (str(pathlib.Path(p).resolve()) for p in (arguments.zonal, arguments.mpi))
        version = subprocess.run([arguments.mpirun, "--version"], capture_output=True, text=True).stdout
        # Both variables: Open MPI refuses the superuser otherwise.
        self.environment = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
        self.mpirun = [arguments.mpirun] + (["--oversubscribe"] if "Open" in version else [])
        self.kills_at_once = "HYDRA" in version
        self.folder = folder

    def one(self, scene, out):
        words = [self.zonal, "--quiet", "solve", scene, "-o", out]
        done = subprocess.run(words, capture_output=True, text=True, timeout=LIMIT)
        if done.returncode:
            sys.exit(f"{scene}: {done.stderr.strip()}")
        return pathlib.Path(out).read_bytes()

    def words(self, ranks, threads, scene, out, *options):
        return [*self.mpirun, "-n", str(ranks), self.mpi, "--quiet", "--threads", str(threads), "solve", scene, "-o", out, *options]

    def many(self, *words):
        """The bytes of a solution on several ranks, or what went wrong."""
        try:
            done = subprocess.run(self.words(*words), capture_output=True, text=True, timeout=LIMIT, env=self.environment)
        except subprocess.TimeoutExpired:
            return "hangs"
        return pathlib.Path(words[3]).read_bytes() if done.returncode == 0 else f"fails: {last_line(done.stderr)}"


def compare_ranks(runs, quick):
    failed = 0
    for name in QUICK if quick else SCENES:
        scene, out = f"{runs.folder}/{name}.toml", f"{runs.folder}/many.npz"
        pathlib.Path(scene).write_text(f'name = "{name}"\n{SCENES[name]}')
        one = runs.one(scene, f"{runs.folder}/one.npz")
        found = []
        for ranks in (2, 3) if quick else (1, 2, 3, 4, 7):
            pathlib.Path(out).unlink(missing_ok=True)
            many = runs.many(ranks, ranks % 2 + 1, scene, out)
            if many != one:
                failed += 1
                print(f"{name}: {many if isinstance(many, str) else 'other bytes'} on {ranks} ranks", flush=True)
            else:
                found.append(str(ranks))
        print(f"{name}: the same bytes on {', '.join(found)} ranks", flush=True)
    return failed


FLIGHT = """frames_per_second = 4
exposure = 1
[[key]]
time = 0
origin = [0.2, 0.3, 0.5]
target = [1, 1, 0.4]
[[key]]
time = 1
origin = [0.5, 0.3, 0.5]
target = [1, 1, 0.4]
"""


def compare_animation(runs):
    """Frames that three ranks draw, against those of one process."""
    scene, flight, run = (f"{runs.folder}/{name}" for name in ("box.toml", "flight.toml", "one.npz"))
    pathlib.Path(scene).write_text(f'name = "box"\n{SCENES["box"]}')
    pathlib.Path(flight).write_text(FLIGHT)
    runs.one(scene, run)
    words = ["--quiet", "render", run, "--animate", flight, "--size", "48x36", "-o"]
    starts = [[runs.zonal], [*runs.mpirun, "-n", "3", runs.mpi]]
    frames = []
    for start, folder in zip(starts, ("one", "many")):
        done = subprocess.run(
            [*start, *words, f"{runs.folder}/{folder}"], capture_output=True, text=True, timeout=LIMIT, env=runs.environment
        )
        if done.returncode:
            print(f"animation: fails: {last_line(done.stderr)}")
            return 1
        frames.append([p.read_bytes() for p in sorted(pathlib.Path(runs.folder, folder).glob("*.png"))])
    same = frames[0] == frames[1] and len(frames[0]) == 5
    print(f"animation: {'the same' if same else 'other'} frames on 3 ranks")
    return int(not same)


def kill_ranks(runs, scene, times, seed):
    dice, failed, killed = random.Random(seed), 0, 0
    begin = time.monotonic()
    one = runs.one(scene, f"{runs.folder}/one.npz")
    whole = time.monotonic() - begin
    for k in range(times):
        out = f"{runs.folder}/run-{k}.npz"
        process = subprocess.Popen(
            runs.words(4, 1, scene, out, "--checkpoint"),
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=runs.environment,
        )
        time.sleep(dice.uniform(0.2, 1.2 * whole + 0.4))
        found = subprocess.run(["pgrep", "-f", f"^{runs.mpi} .* -o {out}"], capture_output=True, text=True).stdout.split()
        if found:
            try:
                os.kill(int(dice.choice(found)), signal.SIGKILL)
            except ProcessLookupError:
                pass
        try:
            _, text = process.communicate(timeout=LIMIT)
        except subprocess.TimeoutExpired:
            process.kill()
            text = process.communicate()[1]
            failed += 1
            print(f"{k}: hangs")
        lines = [line for line in text.splitlines() if line.startswith("error:")]
        if process.returncode:
            killed += 1
            # The mpirun of MPICH kills all other ranks at once, which cannot say anything.
            # A rank that is killed after the solution was written leaves nobody to say anything either.
            is_complete = pathlib.Path(out).exists() and pathlib.Path(out).read_bytes() == one
            if runs.kills_at_once or is_complete:
                lines = lines or ["error: of mpirun"]
            if len(lines) != 1:
                failed += 1
                print(f"{k}: {len(lines)} lines 'error:' in {text[-400:]!r}")
        resumed = runs.many(3, 1, scene, out, "--resume")
        if resumed != one:
            failed += 1
            print(f"{k}: the resumed solve {resumed if isinstance(resumed, str) else 'has other bytes'}")
        pathlib.Path(out).unlink(missing_ok=True)
    print(f"{killed} of {times} runs were killed, {failed} went wrong")
    return failed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["ranks", "kills"])
    parser.add_argument("--zonal", default="target/release/zonal")
    parser.add_argument("--mpi", default="target/release/zonal-mpi")
    parser.add_argument("--mpirun", default="mpirun")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--scene")
    parser.add_argument("--times", type=int, default=30)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="zonal-mpi-") as folder:
        runs = Runs(arguments, folder)
        if arguments.what == "ranks":
            failed = compare_ranks(runs, arguments.quick) + compare_animation(runs)
        else:
            scene = arguments.scene or f"{folder}/box.toml"
            if not arguments.scene:
                pathlib.Path(scene).write_text('name = "box"\n' + light("spectral", box([80, 64, 64], medium="extinction = 2\nalbedo = 0.99\n"), VOXELS + 'zone_basis = "constant"\n'))
            failed = kill_ranks(runs, scene, arguments.times, arguments.seed)
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
