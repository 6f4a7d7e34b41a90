#!/usr/bin/env python3
"""A fin with conduction and radiation: fin.py [ZONAL]. Needs numpy and the command zonal.

k t T'' = 2 eps sigma (T^4 - T_s^4) with T = T_b at the base and T' = 0 at the tip. The exchange areas are computed once; each iteration gives
`zonal update` the temperatures of the faces and solves the linearized conduction for new ones. The heat at the base is compared with the first
integral  T'^2 = 4 eps sigma / (5 k t) (T_b^5 - T_L^5 - 5 T_s^4 (T_b - T_L)).
"""
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ZONAL = sys.argv[1] if len(sys.argv) > 1 else "zonal"
SIGMA = 5.670374419e-8
N, LENGTH, WIDTH = 80, 0.2, 1.0  # cells, m, m
K, THICKNESS, EPS = 200.0, 1e-3, 0.9  # W/(m K), m
T_BASE, T_SURROUNDINGS = 800.0, 300.0  # K

SCENE = f"""mode = "thermal"
[solve]
patch_size = 1
[surroundings]
temperature = {T_SURROUNDINGS}
[[surface]]
name = "fin"
mesh = {{ file = "fin.obj" }}
temperature = {T_BASE}
emissivity = {EPS}
"""


def run(*args):
    subprocess.run([ZONAL, *args], check=True, stdout=subprocess.DEVNULL)


with tempfile.TemporaryDirectory() as folder:
    folder = Path(folder)
    x = np.linspace(0, LENGTH, N + 1)
    points = "".join(f"v {a} 0 0\nv {a} {WIDTH} 0\n" for a in x)
    faces = "".join(f"f {2 * i + 1} {2 * i + 3} {2 * i + 4} {2 * i + 2}\n" for i in range(N))
    (folder / "fin.obj").write_text(points + faces)
    (folder / "fin.toml").write_text(SCENE)
    run("exchange", str(folder / "fin.toml"), "--direct-only", "-o", str(folder / "fin.npz"))

    dx = LENGTH / N
    g = K * THICKNESS * WIDTH / dx  # conductance between cells, W/K
    conduction = np.diag(np.full(N, -2.0 * g)) + np.diag(np.full(N - 1, g), 1) + np.diag(np.full(N - 1, g), -1)
    conduction[0, 0] = -3.0 * g  # half a cell to the base
    conduction[-1, -1] = -g  # adiabatic tip
    base = np.zeros(N)
    base[0] = 2.0 * g * T_BASE
    t = np.full(N, T_BASE)
    for step in range(30):
        np.save(folder / "t.npy", t)
        run("update", str(folder / "fin.npz"), "--temperatures", str(folder / "t.npy"), "--by", "face", "-o", str(folder / "q.npy"))
        power = np.load(folder / "q.npy")[:, 1]  # W that leave each face, both sides
        slope = 8.0 * EPS * SIGMA * t**3 * dx * WIDTH  # its derivative
        new = np.linalg.solve(conduction - np.diag(slope), power - slope * t - base)
        change, t = np.abs(new - t).max(), new
        if change < 1e-8:
            break

heat = 2.0 * g * (T_BASE - t[0])
tip = t[-1] - (t[-2] - t[-1]) / 8.0
integral = T_BASE**5 - tip**5 - 5 * T_SURROUNDINGS**4 * (T_BASE - tip)
exact = K * THICKNESS * WIDTH * np.sqrt(4 * EPS * SIGMA / (5 * K * THICKNESS) * integral)
print(f"{step + 1} iterations, tip {t[-1]:.2f} K, heat {heat:.2f} W, by the first integral {exact:.2f} W")
assert change < 1e-8 and abs(heat - power.sum()) < 1e-6 * heat and abs(heat / exact - 1) < 1e-3
