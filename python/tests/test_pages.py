"""The Python blocks of the pages run."""

from __future__ import annotations

import re

import pytest
from conftest import ROOT

import zonal as zn

PAGES = ("README.md", "python/README.md", "docs/tutorials/python.md", "docs/how-to/view-factors.md")


@pytest.mark.parametrize("page", PAGES)
def test_blocks_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```$", (ROOT / page).read_text(encoding="utf-8"), re.M | re.S)
    assert blocks
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, page, "exec"), names)  # noqa: S102


def test_a_pyvista_sphere_in_a_box():
    pytest.importorskip("pyvista")
    (block,) = re.findall(r"^```py\n(.*?)^```$", (ROOT / "docs/how-to/view-factors.md").read_text(encoding="utf-8"), re.M | re.S)
    names: dict[str, object] = {}
    exec(compile("import zonal as zn\n" + block, "sphere", "exec"), names)  # noqa: S102
    factors = names["F"]
    assert isinstance(factors, zn.ViewFactors)
    assert abs(factors.row_sums - 1).max() < 1e-9 and 0 < factors.radius.data.max() < 1e-3
