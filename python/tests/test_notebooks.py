"""The notebooks and the examples run."""

# Guards (python): notebooks and examples run.

from __future__ import annotations

import ast
import csv
import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

import zonal as zn

NOTEBOOKS = sorted((ROOT / "python/notebooks").glob("*.ipynb"))
# What a notebook uses where it is installed.
OPTIONAL = {"ipywidgets"}


def code_of(path) -> str:
    """The code cells of a notebook as one program."""
    document = json.loads(path.read_text(encoding="utf-8"))
    return "\n\n".join("".join(cell["source"]) for cell in document["cells"] if cell["cell_type"] == "code")


def modules_of(code: str) -> set[str]:
    """The packages that a program imports."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Import):
            names |= {a.name.split(".")[0] for a in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module.split(".")[0])
    return names


def environment() -> dict[str, str]:
    """Without a display, with the package under test."""
    package = str(Path(zn.__file__).parents[1])
    return {**os.environ, "MPLBACKEND": "Agg", "ZONAL_ROOT": str(ROOT), "PYTHONPATH": package}


def test_there_are_notebooks_of_their_sources():
    assert len(NOTEBOOKS) >= 12
    done = subprocess.run([sys.executable, str(ROOT / "scripts/notebooks.py"), "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert all("outputs" not in c or c["outputs"] == [] for p in NOTEBOOKS for c in json.loads(p.read_text(encoding="utf-8"))["cells"])


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)
def test_notebooks_run(path, tmp_path):
    code = code_of(path)
    missing = sorted(m for m in modules_of(code) - OPTIONAL if importlib.util.find_spec(m) is None)
    if missing:
        pytest.skip(f"not installed: {', '.join(missing)}")
    if importlib.util.find_spec("nbclient") and importlib.util.find_spec("ipykernel"):
        program = f"import nbformat, nbclient; nbclient.NotebookClient(nbformat.read({str(path)!r}, 4), timeout=100, kernel_name='python3').execute()"
    else:
        program = code
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=150)
    assert done.returncode == 0, done.stderr


def run_example(name, tmp_path, *arguments) -> str:
    words = [sys.executable, str(ROOT / "python/examples" / name), *map(str, arguments)]
    done = subprocess.run(words, cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=100)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_factors_by_side_set(tmp_path):
    run_example("side_set_view_factors.py", tmp_path)
    with open(tmp_path / "view_factors.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    names = sorted({row["from"] for row in rows})
    assert names == ["inner", "left", "outer", "right"] and len(rows) == 16
    for name in names:
        assert abs(sum(float(r["view_factor"]) for r in rows if r["from"] == name) - 1) < 1e-9
    area = {r["from"]: float(r["area"]) for r in rows}
    factor = {(r["from"], r["to"]): float(r["view_factor"]) for r in rows}
    assert all(abs(area[a] * factor[a, b] - area[b] * factor[b, a]) < 1e-9 for a in names for b in names)
    # The inner cylinder is convex.
    assert factor["inner", "inner"] == 0 < factor["outer", "outer"]


def test_factors_by_side_set_of_a_file(tmp_path):
    corners = [[k & 1, k >> 1 & 1, k >> 2] for k in range(8)]
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    walls = {"bottom": [[1, 2, 4, 3]], "top": [[5, 7, 8, 6]], "sides": [[1, 5, 6, 2], [3, 4, 8, 7], [1, 3, 7, 5], [2, 6, 8, 4]]}
    for name, faces in walls.items():
        lines += [f"usemtl {name}", *["f " + " ".join(map(str, f)) for f in faces]]
    (tmp_path / "room.obj").write_text("\n".join(lines))
    run_example("side_set_view_factors.py", tmp_path, "room.obj", "factors.csv")
    with open(tmp_path / "factors.csv", newline="") as file:
        factor = {(r["from"], r["to"]): float(r["view_factor"]) for r in csv.DictReader(file)}
    assert abs(factor["bottom", "top"] - 0.1998249) < 1e-5


def test_polygons_of_a_building(tmp_path):
    out = run_example("building_polygons.py", tmp_path)
    assert "row sums 1.000000000 to 1.000000000" in out
    temperature = float(out.split("mean radiant temperature of the person")[1].split()[0])
    # Between the coldest and the warmest surface.
    assert 5.0 < temperature < 32.0
