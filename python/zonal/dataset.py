"""Data sets: many solves of one scene with sampled numbers, for surrogate models."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from ._types import Floats, Path
from .errors import FileError, InputError

__all__ = ["Dataset", "load_dataset"]

Distribution: TypeAlias = tuple[float, float] | Sequence[float] | str | float
"""``(low, high)`` uniform, a list of numbers of which one is taken, a number, or the text of the command: ``"log:1:100"``, ``"normal:5:2"``."""

_STATUS = ("converged", "not converged", "refused")


class Dataset:
    """Inputs and results of many solves of one scene; arrays have a row for each sample.

    Made by :meth:`Scene.dataset` and :func:`load_dataset`. Objects can be pickled.
    """

    def __init__(self, arrays: Mapping[str, Any], about: Mapping[str, Any]) -> None:
        self.arrays: dict[str, Any] = dict(arrays)
        """Results by name, (samples, …): ``temperature`` (K), ``net_flux`` (W/m2, W/m3), ``named_power`` (W) and their errors in thermal mode (of names ``named_power_exchange_error``; with
        ``discretization_error=True`` also ``named_power_discretization_error``, and the sum of both as ``named_power_error``); ``radiosity``,
        ``incident`` and ``incident_error`` (W/m2, (samples, zones, bands)) in light mode. Also ``zone_centre`` (m), ``zone_size`` (m2, m3)."""
        self.about: dict[str, Any] = dict(about)
        """What the file states: ``keys``, ``names``, ``units``, ``seed``, ``patches``, ``voxel_zones``, ``cells``, ``version``."""

    def __len__(self) -> int:
        return len(self.inputs)

    def __getitem__(self, name: str) -> Any:
        try:
            return self.arrays[name]
        except KeyError:
            raise InputError(f"'{name}': the data set has no such array; there are {', '.join(self.arrays)}") from None

    @property
    def keys(self) -> list[str]:
        """The varied numbers of the scene."""
        return list(self.about["keys"])

    @property
    def names(self) -> list[str]:
        """Names of the columns of ``named_power`` and ``named_temperature``."""
        return list(self.about["names"])

    @property
    def inputs(self) -> Floats:
        """The values of the varied numbers, (samples, keys)."""
        return self.arrays["inputs"]

    @property
    def status(self) -> list[str]:
        """How each sample ended: ``converged``, ``not converged`` or ``refused``; refused samples have NaN for results."""
        return [_STATUS[int(s)] for s in self.arrays["status"]]

    @property
    def energy_residual(self) -> Floats:
        """Power that the balance of each sample misses over the power exchanged, (samples,)."""
        return self.arrays["energy_residual"]

    @property
    def table(self) -> dict[str, Any]:
        """A row for each sample, for ``pandas.DataFrame(dataset.table)``: inputs, status, residual, and net powers by name (W) in thermal mode."""
        columns: dict[str, Any] = {key: self.inputs[:, k] for k, key in enumerate(self.keys)}
        columns |= {"status": self.status, "energy_residual": self.energy_residual}
        if "named_power" in self.arrays:
            columns |= {f"net_power {name}": self.arrays["named_power"][:, k] for k, name in enumerate(self.names)}
        return columns

    def __repr__(self) -> str:
        return f"<zonal.Dataset: {len(self)} samples of {', '.join(self.keys)}>"


def load_dataset(path: Path) -> Dataset:
    """Reads a data set that :meth:`Scene.dataset` or ``zonal dataset`` wrote.

    Parameters
    ----------
    path : path
        Data set (``.npz``).

    Returns
    -------
    Dataset

    Raises
    ------
    FileError
        If the file cannot be read or is no data set.
    """
    source = os.fspath(path)
    try:
        with np.load(source, allow_pickle=False) as file:
            about: dict[str, Any] = json.loads(bytes(file["about"]))
            arrays = {name: file[name] for name in file.files if name != "about"}
        found = Dataset(arrays, about)
        _ = (found.keys, found.names, found.status, found.inputs.shape[1])
    except OSError as e:
        raise FileError(f"{source}: cannot be read ({e}); give a data set", source) from e
    except (KeyError, ValueError, TypeError, IndexError, AttributeError) as e:
        reason = f" ({e})" if isinstance(e, KeyError) else ""
        raise FileError(f"{source}: this is no data set{reason}; write it again", source) from e
    return found


def distribution(key: str, given: Distribution) -> str:
    """The text of a distribution."""
    if isinstance(given, str):
        return given
    if isinstance(given, (int, float)):
        return repr(float(given))
    numbers = [repr(float(x)) for x in given]
    if isinstance(given, tuple):
        if len(numbers) != 2:
            raise InputError(f"vary: '{key}' has {len(numbers)} numbers in a tuple; give (low, high), or a list of numbers of which one is taken")
        return ":".join(numbers)
    if not numbers:
        raise InputError(f"vary: '{key}' has no numbers; give (low, high), or a list of numbers of which one is taken")
    return ",".join(numbers)
