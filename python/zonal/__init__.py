"""Radiative exchange between surfaces and participating media by the zonal method.

A scene is cut into zones (patches of surfaces, voxels of the medium), the exchange area of every pair of zones is computed with an error bound, and one linear
system gives the radiosity of all zones.

>>> import zonal as zn
>>> scene = zn.Scene(mode="thermal")
>>> scene.surface(room=([0, 0, 0], [2, 2, 4]), name="wall", emissivity=0.7, temperature=900)
>>> scene.medium([0, 0, 0], [2, 2, 4], cells=[2, 2, 4], extinction=0.5, heat_source=5000)
>>> solution = scene.solve()
>>> solution.table["net_power"].sum().round(3)  # nothing is lost
np.float64(...)

Units: metres; 1/m for extinction; W/m2 for radiosity, irradiance, fluence and emission; W/(m2 sr) for radiance; W/m3 for sources; kelvin.

After a fork the child starts threads of its own, and its results have the same bits; objects that a thread of the parent was using at the fork are not usable.
"""

from __future__ import annotations

from . import _zonal
from ._progress import Phase, Timings
from .dataset import Dataset, load_dataset
from .diagnostics import Diagnostic
from .errors import Error, FileError, InputError, Interrupted, MemoryLimitError
from .exchange import ExchangeAreas, StateSolver, ThermalState, update
from .scene import Scene, load_scene
from .solution import Camera, Solution, encode_png, load_solution
from .tools import Gas, Key, gas_properties, keys, show, validate
from .factors import CompressedRows, ViewFactors, view_factors

__version__: str = _zonal.version()

__all__ = [
    "Camera",
    "CompressedRows",
    "Dataset",
    "Diagnostic",
    "Error",
    "ExchangeAreas",
    "FileError",
    "Gas",
    "InputError",
    "Interrupted",
    "Key",
    "MemoryLimitError",
    "Phase",
    "Scene",
    "Solution",
    "StateSolver",
    "ThermalState",
    "Timings",
    "ViewFactors",
    "encode_png",
    "gas_properties",
    "keys",
    "load_dataset",
    "load_scene",
    "load_solution",
    "show",
    "update",
    "validate",
    "view_factors",
]
