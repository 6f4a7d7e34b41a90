"""Paths and scenes of the tests."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import zonal as zn

ROOT = Path(os.environ.get("ZONAL_ROOT", Path(__file__).resolve().parents[2]))
"""The checkout, for scenes and pages."""


@pytest.fixture(scope="session")
def command() -> list[str]:
    """The program `zonal` (``ZONAL``), or the command of this package without one."""
    program = os.environ.get("ZONAL") or shutil.which("zonal", path=str(ROOT / "target/debug"))
    return [program] if program else [sys.executable, "-m", "zonal"]


@pytest.fixture(scope="session")
def run(command: list[str]):
    """Runs the command; returns the finished process."""

    def run(*arguments: object, check: bool = True) -> subprocess.CompletedProcess[str]:
        words = [*command, *map(str, arguments)]
        return subprocess.run(words, capture_output=True, text=True, check=check)

    return run


def room(patch_size: float = 1.0) -> zn.Scene:
    """A room with a lamp and thin smoke, by exchange areas: their factors are kept, and light groups add up to rounding."""
    scene = zn.Scene("room")
    scene.settings(engine="dense")
    scene.surface(room=([0, 0, 0], [4, 3, 2.5]), name="walls", reflectance=0.5, patch_size=patch_size)
    scene.surface(rectangle=([1.8, 1.3, 2.4], [0, 0.4, 0], [0.4, 0, 0]), name="lamp", emission=500.0)
    scene.medium([0, 0, 0], [4, 3, 2.5], cells=[4, 3, 3], extinction=0.1, albedo=0.9)
    scene.camera([0.3, 0.3, 1.5], [3, 2, 1], name="corner")
    return scene


def furnace() -> zn.Scene:
    """Walls of known temperature and a gas with a heat source."""
    scene = zn.Scene("furnace", mode="thermal")
    hot = {"emissivity": 0.85, "temperature": 1200}
    scene.surface(room=([0, 0, 0], [2, 2, 4]), name="wall", emissivity=0.7, temperature=900, faces={"z0": hot, "z1": {"temperature": 400}}, patch_size=1.0)
    scene.medium([0, 0, 0], [2, 2, 4], cells=[2, 2, 4], extinction=0.5, heat_source=5000)
    return scene


def sphere(n: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """A unit sphere of triangles."""
    vertices, faces = [[0.0, 0.0, 1.0]], []
    for i in range(1, n):
        for j in range(2 * n):
            a, b = np.pi * i / n, np.pi * j / n
            vertices.append([np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)])
    vertices.append([0.0, 0.0, -1.0])
    at = lambda i, j: 1 + (i - 1) * 2 * n + j % (2 * n)  # noqa: E731
    last = len(vertices) - 1
    for j in range(2 * n):
        faces.append([0, at(1, j), at(1, j + 1)])
        faces += [t for i in range(1, n - 1) for t in ([at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)])]
        faces.append([last, at(n - 1, j + 1), at(n - 1, j)])
    return np.array(vertices), np.array(faces)
