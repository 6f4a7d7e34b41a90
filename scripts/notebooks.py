#!/usr/bin/env python3
"""notebooks.py [--check]: python/notebooks/*.ipynb from python/notebooks/sources/*.py.

In a source `# %%` begins a cell of code and `# %% [markdown]` a cell of text, whose lines are comments. Notebooks are written without outputs. --check ends
with 1 where a notebook differs from its source.
"""

import json
import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[1] / "python/notebooks"


def notebook(source):
    """The text of the notebook of a source."""
    cells = []
    for k, part in enumerate(("\n" + source).split("\n# %%")[1:], start=1):
        head, _, body = part.partition("\n")
        lines = body.strip("\n").split("\n")
        cell = {"cell_type": "code", "execution_count": None, "id": f"cell-{k}", "metadata": {}, "outputs": []}
        if head.strip() == "[markdown]":
            lines = [line.removeprefix("#").removeprefix(" ") for line in lines]
            cell = {"cell_type": "markdown", "id": f"cell-{k}", "metadata": {}}
        cell["source"] = [line + "\n" for line in lines[:-1]] + lines[-1:]
        cells.append(cell)
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    document = {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"


def main():
    sources = {p.stem: notebook(p.read_text(encoding="utf-8")) for p in sorted((FOLDER / "sources").glob("*.py"))}
    if sys.argv[1:] != ["--check"]:
        for name, text in sources.items():
            (FOLDER / f"{name}.ipynb").write_text(text, encoding="utf-8")
        return 0
    present = {p.stem: p.read_text(encoding="utf-8") for p in FOLDER.glob("*.ipynb")}
    wrong = sorted(name for name in present.keys() | sources.keys() if present.get(name) != sources.get(name))
    for name in wrong:
        print(f"{name}.ipynb differs from its source; run scripts/notebooks.py", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
