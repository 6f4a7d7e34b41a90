"""Threads, interruption, memory, forks."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from conftest import ROOT, room

import zonal as zn


def long_scene(engine: str) -> zn.Scene:
    """A scene whose solve takes minutes."""
    scene = zn.Scene()
    scene.surface(room=([0, 0, 0], [4, 3, 2.5]), name="walls", reflectance=0.5, patch_size=0.12)
    scene.surface(box=([1, 1, 0], [2, 2, 1]), name="box", reflectance=0.5, patch_size=0.12)
    scene.surface(rectangle=([1.8, 1.3, 2.4], [0, 0.4, 0], [0.4, 0, 0]), name="lamp", emission=500.0)
    scene.medium([0, 0, 0], [4, 3, 2.5], cells=[24, 18, 15], extinction=0.2, albedo=0.9)
    scene.settings(engine=engine, tolerance=1e-4)  # type: ignore[arg-type]
    return scene


INTERRUPTED = """
import sys, threading, time, os, signal
# A shell starts background jobs with SIGINT ignored, and Python then keeps it so.
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.path.insert(0, {tests!r})
from test_processes import long_scene
scene = long_scene({engine!r})
main = os.getpid()
def interrupt():
    time.sleep(2.0)
    global sent
    sent = time.perf_counter()
    os.kill(main, signal.SIGINT)
threading.Thread(target=interrupt, daemon=True).start()
try:
    scene.solve()
    print("finished")
except KeyboardInterrupt:
    print("interrupted", time.perf_counter() - sent)
# The package still works.
from conftest import room
print(room().solve(threads=1).zone_count > 0)
"""


# Guards (python): Ctrl-C ends a call of the Python package at once.
@pytest.mark.parametrize("engine", ["dense", "rays"])
def test_ctrl_c_ends_a_solve_at_once(engine):
    code = INTERRUPTED.format(tests=str(ROOT / "python/tests"), engine=engine)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=100)
    words = done.stdout.split()
    assert words[0] == "interrupted" and words[2] == "True", done
    # No worker thread reported a panic.
    assert done.stderr == ""


def test_progress_is_reported_and_may_end_the_solve():
    seen: list[tuple[str, int, int]] = []
    long = long_scene("rays")

    class Enough(Exception):
        pass

    def progress(stage: str, done: int, total: int) -> None:
        seen.append((stage, done, total))
        if len(seen) > 3:
            raise Enough

    with pytest.raises(Enough):
        long.solve(progress=progress)
    assert len(seen) == 4 and all(0 <= done <= total for _, done, total in seen)


def test_timings_of_a_call_add_up():
    timings = zn.Timings()
    solution = room(0.5).solve(progress=timings)
    names = [phase.name for phase in timings.phases]
    assert "zones" in names and names[-1] == "other"
    assert all(phase.wall >= 0 and phase.count >= 1 for phase in timings.phases)
    assert timings.wall == pytest.approx(sum(phase.wall for phase in timings.phases))
    assert str(timings).splitlines()[-1].split()[0] == "total"
    # Another progress is shown as well, and the result does not depend on either.
    seen: list[str] = []
    timed = zn.Timings(lambda stage, done, total: seen.append(stage))
    again = room(0.5).solve(progress=timed)
    assert (again.radiosity == solution.radiosity).all() and timed.phases


def test_progress_bars(capsys):
    pytest.importorskip("tqdm")
    long_enough = room(0.2)
    long_enough.solve(progress=True)
    assert "%" in capsys.readouterr().err


def test_threads_run_meanwhile_and_bits_do_not_depend_on_them():
    counted = 0
    done = threading.Event()

    def count() -> None:
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0.001)

    other = threading.Thread(target=count)
    other.start()
    scene = room(0.25)
    begin = time.perf_counter()
    first = scene.solve(threads=1).radiosity
    elapsed = time.perf_counter() - begin
    done.set()
    other.join()
    assert counted > 10 * elapsed, (counted, elapsed)
    assert np.array_equal(scene.solve(threads=3).radiosity, first)


def test_one_solution_serves_several_threads():
    solution = room().solve()
    wanted = solution.render(size=(24, 18))
    pictures: list[np.ndarray] = []

    def draw() -> None:
        pictures.append(solution.render(size=(24, 18), threads=2))

    workers = [threading.Thread(target=draw) for _ in range(4)]
    for w in workers:
        w.start()
    for w in workers:
        w.join()
    assert len(pictures) == 4 and all(np.array_equal(p, wanted) for p in pictures)


# Guards (python): a forked child has its own threads.
@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")
def test_a_forked_child_solves_with_threads_of_its_own():
    wanted = room().solve().radiosity
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        signal.alarm(60)
        try:
            found = room().solve(threads=2).radiosity
            os.write(writer, b"same" if np.array_equal(found, wanted) else b"other")
        finally:
            os._exit(0)
    os.close(writer)
    os.waitpid(child, 0)
    with os.fdopen(reader, "rb") as pipe:
        assert pipe.read() == b"same"
    # The parent goes on.
    assert np.array_equal(room().solve().radiosity, wanted)


def peak_and_current() -> tuple[int, int]:
    """Largest and present resident memory, bytes."""
    with open("/proc/self/status") as status:
        fields = dict(line.split(":", 1) for line in status)
    kib = {k: int(fields[k].split()[0]) for k in ("VmHWM", "VmRSS")}
    return kib["VmHWM"] * 1024, kib["VmRSS"] * 1024


MEMORY = """
import sys
sys.path.insert(0, {tests!r})
import numpy as np
from test_processes import peak_and_current
import zonal as zn
big = np.full((512, 256, 256), 0.5, dtype=np.{dtype})
scene = zn.Scene()
scene.medium([0, 0, 0], [1, 1, 1], cells=[2, 2, 2], extinction=big, emission=1.0)
before = peak_and_current()[1]
scene.check()
print(peak_and_current()[0] - before, big.nbytes)
"""


# Guards (python): large arrays are not copied, measured by memory.
@pytest.mark.skipif(not os.path.exists("/proc/self/status"), reason="the system does not report its memory")
@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_large_inputs_are_not_copied(dtype):
    code = MEMORY.format(tests=str(ROOT / "python/tests"), dtype=dtype)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    growth, size = map(int, done.stdout.split())
    assert size >= 128 << 20 and growth < size // 4, (growth, size)


OUTPUT = """
import sys
sys.path.insert(0, {tests!r})
import numpy as np
from test_processes import peak_and_current
import zonal as zn
scene = zn.Scene()
scene.surface(room=([0, 0, 0], [1, 1, 1]), reflectance=0.5, emission=1.0)
scene.medium([0, 0, 0], [1, 1, 1], cells=[64, 64, 64], extinction=1.0, albedo=0.5)
scene.settings(patch_rule="voxels", engine="spectral", tolerance=0.01)
solution = scene.solve()
before = peak_and_current()[1]
size = sum(solution.array(n).nbytes for n in ("radiosity", "incident", "error"))
print(peak_and_current()[1] - before, size, float(solution.radiosity.sum() + solution.incident.sum()))
"""


# Guards (python): large arrays are not copied, measured by memory.
@pytest.mark.skipif(not os.path.exists("/proc/self/status"), reason="the system does not report its memory")
def test_fields_are_not_copied():
    code = OUTPUT.format(tests=str(ROOT / "python/tests"))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    growth, size, _ = map(float, done.stdout.split())
    assert size > 16 << 20 and growth < size / 8, (growth, size)


def test_checkpoints_resume_with_the_same_bits(tmp_path):
    scene = room(0.2)
    wanted = scene.solve().radiosity
    folder = tmp_path / "stages"

    class Enough(Exception):
        pass

    def progress(stage: str, done: int, total: int) -> None:
        if stage == "exchange areas":
            raise Enough

    with pytest.raises(Enough):
        scene.solve(checkpoint=folder, progress=progress)
    assert any(folder.iterdir())
    assert np.array_equal(scene.solve(checkpoint=folder, resume=True).radiosity, wanted)
    assert not folder.exists()


def test_import_needs_only_numpy():
    code = "import sys, zonal; print(sorted({m.split('.')[0] for m in sys.modules} & {'pandas','tqdm','rich','xarray','pyvista','trimesh','meshio'}))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
