"""The Python blocks of the pages run."""

from __future__ import annotations

import re

import pytest
from conftest import ROOT

PAGES = ("README.md", "python/README.md", "docs/tutorials/python.md", "docs/how-to/view-factors.md")


@pytest.mark.parametrize("page", PAGES)
def test_blocks_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```$", (ROOT / page).read_text(encoding="utf-8"), re.M | re.S)
    assert blocks
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, page, "exec"), names)  # noqa: S102
