"""Gas models, validation, the reference of scene keys, the viewer in a notebook."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Any, NamedTuple, cast

from . import _zonal
from ._progress import Progress, observed
from ._types import Path, VoxelValues
from .solution import Solution

__all__ = ["Gas", "Key", "gas_properties", "keys", "show", "validate"]


def Gas(  # noqa: N802
    model: str,
    *,
    h2o: VoxelValues = 0.0,
    co2: VoxelValues = 0.0,
    soot: VoxelValues = 0.0,
    pressure: VoxelValues = 101325.0,
) -> dict[str, Any]:
    """A gas for :meth:`Scene.medium` and :meth:`Scene.region`.

    Parameters
    ----------
    model : str
        Name of the model, such as ``"wsgg-bordbar-2020"``; ``gas_properties()`` lists them.
    h2o, co2 : float or array
        Mole fractions of water vapour and carbon dioxide, 0 to 1.
    soot : float or array
        Volume fraction of soot, 0 to 1.
    pressure : float or array
        Total pressure, Pa.

    Examples
    --------
    >>> import zonal as zn
    >>> zn.Gas("wsgg-bordbar-2020", h2o=0.2, co2=0.1)["co2"]
    0.1
    """
    return {"model": model, "h2o": h2o, "co2": co2, "soot": soot, "pressure": pressure}


def gas_properties(
    model: str | None = None,
    *,
    h2o: float = 0.0,
    co2: float = 0.0,
    soot: float = 0.0,
    temperature: float = 1000.0,
    pressure: float = 101325.0,
    lengths: Sequence[float] = (),
) -> Any:
    """The grey gases and the total emissivity of a gas model, as ``zonal gas --json``; without a model the list of models.

    Parameters
    ----------
    model : str, optional
        Name of the model.
    h2o, co2, soot : float
        Mole fractions, volume fraction.
    temperature, pressure : float
        K, Pa.
    lengths : list of float
        Path lengths, m; 0.01 to 100 by default.

    Returns
    -------
    dict or list
        ``gases`` (``absorption`` in 1/m, ``weight``), ``emissivity`` by ``length``, ``planck_mean``, ``notes``, ``source``; or the models.

    Raises
    ------
    InputError
        If the model is not known or a value is out of range.

    Examples
    --------
    >>> import zonal as zn
    >>> mixture = zn.gas_properties("wsgg-bordbar-2020", h2o=0.2, co2=0.1, temperature=1500, lengths=[1.0])
    >>> 0.1 < mixture["emissivity"][0]["emissivity"] < 0.4
    True
    """
    settings = {"h2o": h2o, "co2": co2, "soot": soot, "temperature": temperature, "pressure": pressure, "lengths": [float(x) for x in lengths]}
    return json.loads(_zonal.gas(model, settings))


def validate(
    only: Sequence[str] = (),
    *,
    quick: bool = False,
    list_only: bool = False,
    output: Path | None = None,
    reference: Path | None = None,
    scenes: Path | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> Any:
    """Runs cases with known answers, as ``zonal validate --json``.

    Parameters
    ----------
    only : list of str
        Cases by name or pattern with * and ?; all by default.
    quick : bool
        Only cases that take at most a few seconds each.
    list_only : bool
        Lists the cases without running them.
    output : path, optional
        Folder of the page and its plots.
    reference : path, optional
        Folder of reference files; cases whose files are missing are skipped.
    scenes : path, optional
        Folder for the solved scenes.
    threads, progress : optional
        As of :meth:`Scene.solve`.

    Returns
    -------
    dict or list
        The verdicts, as the command writes them, with ``passed``: whether all hold.
    """
    page, files, solved = (None if p is None else os.fspath(p) for p in (output, reference, scenes))
    if output is None and not only and not quick and not list_only:
        # All cases of the command write the page of the manual; here only on request.
        only = ["*"]
    settings = {"only": list(only), "quick": quick, "list": list_only, "output": page, "reference": files, "scenes": solved}
    with observed(progress) as function:
        text, passed = _zonal.validate(settings, function, threads)
    results: Any = json.loads(text)
    if isinstance(results, dict):
        return {**cast("dict[str, Any]", results), "passed": passed}
    return results


class Key(NamedTuple):
    """A key of scene files."""

    path: str
    """Dotted path; ``[]`` marks the entries of a list."""
    type: str
    unit: str
    default: str
    description: str


def keys(search: str = "") -> list[Key]:
    """The keys of scene files, which are those of :attr:`Scene.document`.

    Parameters
    ----------
    search : str
        A part of the paths.

    Examples
    --------
    >>> import zonal as zn
    >>> zn.keys("solve.tolerance")[0].default
    '0.01'
    """
    return [Key(*k) for k in _zonal.keys() if search in k[0]]


class Page:
    """The viewer of a solution, shown in a notebook in a frame."""

    def __init__(self, text: str, height: int) -> None:
        self.text = text
        """The page: one HTML text that makes no request."""
        self.height = height

    def _repr_html_(self) -> str:
        import html

        source = html.escape(self.text, quote=True)
        return f'<iframe srcdoc="{source}" width="100%" height="{self.height}" style="border: 0"></iframe>'


def show(
    solution: Solution,
    *,
    height: int = 600,
    max_vertices: int = 100_000,
    first_band: int = 0,
    threads: int | None = None,
    progress: Progress = None,
) -> Page:
    """The viewer of ``zonal view`` in a cell of a notebook: walk through the solution, scale its lights, probe its zones.

    Parameters
    ----------
    solution : Solution
        A solution of light.
    height : int
        Height of the frame, pixels.
    max_vertices : int
        Largest number of vertices of the baked light; more are sharper and larger.
    first_band : int
        The first of the three bands that stand for red, green and blue, where the solution has other bands: 0, 3, 6, ….
    threads, progress : optional
        As of :meth:`Scene.solve`.

    Returns
    -------
    Page
        What notebooks display; its ``text`` is the page.

    Raises
    ------
    InputError
        For solutions of thermal mode, of bands that are no colours, and with reflectances by face.
    """
    with observed(progress) as function:
        native = solution._native  # pyright: ignore[reportPrivateUsage]
        return Page(_zonal.page(native, max_vertices, first_band, function, threads), height)
