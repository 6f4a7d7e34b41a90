"""Types of arguments."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

Vector: TypeAlias = Sequence[float] | npt.NDArray[Any]
"""Three numbers: a point or a direction, m."""

Bands: TypeAlias = float | Sequence[float] | Mapping[str, Any]
"""One number for all bands, a list of one for each, or a spectrum, such as ``{"black_body": 5800, "total": 1000}``."""

FaceValues: TypeAlias = Bands | npt.NDArray[Any]
"""Bands; or an array of one value for each face of a mesh; or ``{"file": …}`` as in scene files."""

VoxelValues: TypeAlias = Any
"""A number or bands; or an array of shape (nx, ny, nz), an ``xarray.DataArray`` with the dimensions x, y, z, or ``{"file": …, "scale": …}``."""

Mesh: TypeAlias = Any
"""``(vertices, faces)``; the corners of faces, (faces, corners, 3); a mesh of pyvista, trimesh or meshio; or the path of a mesh file."""

Path: TypeAlias = str | os.PathLike[str]

Engine: TypeAlias = Literal["auto", "dense", "rays", "spectral", "layered"]
LightGroups: TypeAlias = Literal["auto", "each", "all"]
ZoneBasis: TypeAlias = Literal["auto", "linear", "constant"]
Closure: TypeAlias = Literal["measure", "restore"]
PatchRule: TypeAlias = Literal["edge", "area", "voxels"]
Factors: TypeAlias = Literal["exact", "series", "prop1", "point"]
Quantity: TypeAlias = Literal["temperature", "net_flux", "radiosity", "irradiance"]
Boundary: TypeAlias = Literal["symmetry", "periodic", "scene"]
BoundaryEnd: TypeAlias = Literal["symmetry", "scene"]
Sides: TypeAlias = Literal["front", "both"]
OpenSides: TypeAlias = Literal["file", "both"]

Floats: TypeAlias = npt.NDArray[np.float64]
Integers: TypeAlias = npt.NDArray[np.int64]
