#!/usr/bin/env python3
"""A box that warms up: transient_box.py [ZONAL]. Needs numpy and the command zonal.

C_i dT_i/dt = P_i - Q_i: walls of heat capacity C_i, a heater in one wall, net radiative powers Q_i by `zonal update` in each step (explicit
midpoint rule). The exchange areas are computed once. The stored energy equals the energy of the heater, because net powers sum to zero.
"""
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ZONAL = sys.argv[1] if len(sys.argv) > 1 else "zonal"
NAMES = ["x0", "x1", "y0", "y1", "z0", "z1"]
AREA, CAPACITY, HEATER = 1.0, 4000.0, 2000.0  # m2, J/(m2 K), W in z0
STEP, STEPS = 120.0, 8  # s

SCENE = """mode = "thermal"
[solve]
patch_size = 0.5
[[surface]]
name = "box"
room = { min = [0, 0, 0], max = [1, 1, 1] }
temperature = 300
emissivity = 0.8
"""


def run(*args):
    subprocess.run([ZONAL, *args], check=True, stdout=subprocess.DEVNULL)


with tempfile.TemporaryDirectory() as folder:
    folder = Path(folder)
    (folder / "box.toml").write_text(SCENE)
    run("exchange", str(folder / "box.toml"), "--direct-only", "-o", str(folder / "box.npz"))

    def net_powers(t):
        """W that leave each wall."""
        (folder / "t.csv").write_text("name,T\n" + "".join(f"box.{n},{x}\n" for n, x in zip(NAMES, t)))
        run("update", str(folder / "box.npz"), "--temperatures", str(folder / "t.csv"), "-o", str(folder / "q.npy"))
        return np.load(folder / "q.npy")[:, 1]

    heat = np.array([HEATER if n == "z0" else 0.0 for n in NAMES])
    t = np.full(6, 300.0)
    for _ in range(STEPS):
        middle = t + 0.5 * STEP * (heat - net_powers(t)) / (CAPACITY * AREA)
        t = t + STEP * (heat - net_powers(middle)) / (CAPACITY * AREA)

stored, given = (CAPACITY * AREA * (t - 300.0)).sum(), HEATER * STEP * STEPS
print(f"after {STEP * STEPS:.0f} s: heater {t[4]:.1f} K, lid {t[5]:.1f} K, side {t[0]:.1f} K; stored {stored:.0f} J of {given:.0f} J")
assert abs(stored / given - 1) < 1e-9 and t[4] > t[0] and t[4] > t[5] > 300
