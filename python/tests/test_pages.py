"""Every block of code of the documentation runs, in order, in an empty folder."""

# Guards (documents): every block of code of the manual runs, in order and in an empty folder, or says why not.

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT
from pages import SHELL, TEXT, Block, blocks_of

import zonal as zn

PAGES = sorted([ROOT / "README.md", ROOT / "python/README.md", *(ROOT / "docs").rglob("*.md")])
# Written from the docstrings, whose examples pytest runs with --doctest-modules.
GENERATED = {"docs/reference/python.md"}
WITH_BLOCKS = [p for p in PAGES if str(p.relative_to(ROOT)) not in GENERATED and blocks_of(p)]


@pytest.fixture(scope="session")
def shell(command, tmp_path_factory):
    """Environment of the blocks of the shell: the programs zonal and python of the tests, one folder for all caches."""
    folder = tmp_path_factory.mktemp("bin")
    for name, words in (("zonal", command), ("python", [sys.executable])):
        program = folder / name
        program.write_text("#!/bin/sh\nexec " + " ".join(f"'{w}'" for w in words) + ' "$@"\n')
        program.chmod(0o755)
    package = str(Path(zn.__file__).parents[1])
    path = f"{folder}{os.pathsep}{os.environ['PATH']}"
    return {**os.environ, "PATH": path, "PYTHONPATH": package, "ZONAL_ROOT": str(ROOT), "MPLBACKEND": "Agg"}


def run_shell(block: Block, where: str, shell: dict[str, str]) -> None:
    code = block.code
    for mark in block.marks:
        skipped = re.fullmatch(r"skip lines (.+?): (.+)", mark)
        assert skipped, f"{where}: '{mark}' is no mark of a block of the shell"
        lines = code.splitlines()
        assert any(re.search(skipped[1], line) for line in lines), f"{where}: no line matches '{skipped[1]}'"
        code = "\n".join(line for line in lines if not re.search(skipped[1], line))
    done = subprocess.run(["bash", "-eu", "-c", code], env=shell, capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=300)
    assert done.returncode == 0, f"{where}: {done.stderr or done.stdout}"


def run_toml(block: Block, where: str) -> None:
    """Writes a scene, or a part of one, and checks it."""
    mark = block.marks[0] if block.marks else "file scene.toml"
    given = re.fullmatch(r"(file|add to) (\S+)", mark)
    assert given and len(block.marks) <= 1, f"{where}: '{mark}' is no mark of a block of TOML"
    path = Path(given[2])
    before = path.read_text(encoding="utf-8") if given[1] == "add to" else ""
    path.write_text(before + block.code, encoding="utf-8")
    try:
        zn.load_scene(path).check()
    except zn.Error as error:
        pytest.fail(f"{where}: {error}")


@pytest.mark.parametrize("page", WITH_BLOCKS, ids=lambda p: str(p.relative_to(ROOT)))
def test_blocks_run(page, tmp_path, monkeypatch, shell):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", shell["PATH"])
    names: dict[str, object] = {}
    for block in blocks_of(page):
        where = f"{page.relative_to(ROOT)}:{block.line}"
        text = [mark.removeprefix("text file ") for mark in block.marks if mark.startswith("text file ")]
        if any(mark.startswith("skip: ") for mark in block.marks):
            assert len(block.marks) == 1 and len(block.marks[0]) > 20, f"{where}: give one mark, with the reason"
        elif text:
            Path(text[0]).write_text(block.code, encoding="utf-8")
        elif block.language == "python":
            missing = sorted(m for m in modules_of(block.code) if not importable(m))
            if missing:
                pytest.skip(f"{where}: not installed: {', '.join(missing)}")
            exec(compile("\n" * block.line + block.code, where, "exec"), names)  # noqa: S102
        elif block.language == "toml":
            run_toml(block, where)
        elif block.language in SHELL:
            run_shell(block, where, shell)
        else:
            assert block.language in TEXT, f"{where}: a block in '{block.language}' is not run; mark it with the reason"


def modules_of(code: str) -> set[str]:
    """The packages that a block imports."""
    names = [a.name for n in ast.walk(ast.parse(code)) if isinstance(n, ast.Import) for a in n.names]
    return {name.split(".")[0] for name in names}


def importable(module: str) -> bool:
    import importlib.util

    return importlib.util.find_spec(module) is not None


def test_most_blocks_are_run():
    found = [b for p in WITH_BLOCKS for b in blocks_of(p)]
    for language, least in (("python", 20), ("toml", 25), ("sh", 30)):
        run = [b for b in found if b.language == language and not any(m.startswith("skip:") for m in b.marks)]
        assert len(run) >= least, (language, len(run))


def test_the_tutorial_prints_the_errors_of_the_command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    first = next(b for b in blocks_of(ROOT / "docs/tutorials/python.md") if b.language == "python")
    exec(compile(first.code, "tutorial", "exec"), {})  # noqa: S102
    assert "wall.z0: 215675 ± 227 W" in capsys.readouterr().out


def test_a_pyvista_sphere_in_a_box(tmp_path, monkeypatch):
    pytest.importorskip("pyvista")
    monkeypatch.chdir(tmp_path)
    blocks = [b for b in blocks_of(ROOT / "docs/how-to/view-factors.md") if "import pyvista" in b.code]
    names: dict[str, object] = {}
    exec(compile("import zonal as zn\n" + blocks[0].code, "sphere", "exec"), names)  # noqa: S102
    factors = names["B"]
    assert isinstance(factors, zn.ViewFactors)
    assert abs(factors.row_sums - 1).max() < 1e-9 and 0 < factors.radius.data.max() < 1e-3
