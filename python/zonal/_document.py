"""Documents of scenes: nested dictionaries with the keys of scene files, in which arrays and meshes may stand in place of files.

A document becomes TOML text; its arrays get names, under which the native reader finds them. Everything else, checks and messages included, is that of
scene files.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from ._meshes import MeshArrays, is_path, mesh_arrays, write_obj
from .errors import InputError

# Keys of surfaces that may have a value for each face of a mesh.
FACE_VALUE_KEYS = ("temperature", "heat_flux", "net_power", "emissivity", "reflectance", "emission")
# Keys that name files.
_FILE_KEYS = ("file", "texture", "spectrum", "image")

Array = npt.NDArray[Any]


class Arrays:
    """The arrays of a document by their names."""

    def __init__(self) -> None:
        self.values: dict[str, Array | MeshArrays] = {}

    def add(self, value: Array | MeshArrays) -> str:
        """Adds an array; returns its name, which messages have."""
        shape = f"of {value.face_count} faces" if isinstance(value, MeshArrays) else f"of shape {value.shape}"
        kind = "mesh" if isinstance(value, MeshArrays) else "array"
        name = f"{kind} {len(self.values) + 1} {shape}"
        self.values[name] = value
        return name


def grid_array(key: str, value: Any) -> Array:
    """An array of three axes in a layout that needs no copy where possible."""
    array = np.asarray(value)
    if array.ndim != 3:
        raise InputError(f"{key}: the array has the shape {array.shape}; give one of shape (nx, ny, nz)")
    if array.dtype.kind not in "fiub":
        raise InputError(f"{key}: the array of shape {array.shape} has elements of type {array.dtype}; give numbers")
    if array.dtype.kind != "f" or array.dtype.itemsize not in (4, 8) or not array.dtype.isnative:
        array = array.astype(np.float64)
    if not (array.flags.c_contiguous or array.flags.f_contiguous):
        array = np.ascontiguousarray(array)
    return array


def face_array(key: str, value: Array) -> Array:
    """An array of one value for each face."""
    if value.dtype.kind not in "fiub":
        raise InputError(f"{key}: the array of shape {value.shape} has elements of type {value.dtype}; give numbers")
    return np.ascontiguousarray(value, dtype=np.float64)


def labelled_grid(key: str, value: Any) -> tuple[Array, tuple[list[float], list[float]] | None]:
    """The array of an xarray.DataArray with its axes in the order x, y, z, and its box, where it has coordinates of the centres of cells."""
    if sorted(str(d) for d in value.dims) == ["x", "y", "z"]:
        value = value.transpose("x", "y", "z")
    array = grid_array(key, value.values)
    low: list[float] = []
    high: list[float] = []
    for dim, count in zip(value.dims, array.shape, strict=True):
        if dim not in value.coords or count < 2:
            return array, None
        centres = np.asarray(value.coords[dim].values, dtype=np.float64)
        steps = np.diff(centres)
        if not np.allclose(steps, steps[0], rtol=1e-6) or steps[0] <= 0:
            raise InputError(f"{key}: the coordinates along {dim} are not evenly spaced and ascending; interpolate onto even steps")
        low.append(float(centres[0] - 0.5 * steps[0]))
        high.append(float(centres[-1] + 0.5 * steps[0]))
    return array, (low, high)


def is_labelled(value: Any) -> bool:
    """True for an xarray.DataArray."""
    return hasattr(value, "dims") and hasattr(value, "coords") and hasattr(value, "values")


class Writer:
    """Turns a document into values of TOML, and gathers its arrays."""

    def __init__(self) -> None:
        self.arrays = Arrays()

    def plain(self, value: Any, path: str, key: str) -> Any:
        """A value of TOML for a value of a document."""
        if isinstance(value, Mapping):
            items = cast("Mapping[str, Any]", value).items()
            prefix = f"{path}." if path else ""
            return {str(k): self.plain(v, f"{prefix}{k}", str(k)) for k, v in items if v is not None}
        if key == "mesh":
            return {"file": self.mesh(value, path)}
        if path.endswith("mesh.file"):
            return self.mesh(value, path)
        if is_labelled(value):
            return self.labelled(value, path, key)
        if isinstance(value, np.ndarray):
            return self.array(cast("Array", value), path, key)
        if isinstance(value, np.generic):
            return cast("Any", value).item()
        if isinstance(value, (list, tuple)):
            entries = enumerate(cast("list[Any]", value))
            return [self.plain(v, f"{path}[{k}]", "") for k, v in entries]
        if isinstance(value, os.PathLike):
            return os.fspath(cast("os.PathLike[str]", value))
        return value

    def mesh(self, value: Any, path: str) -> str:
        if is_path(value):
            return cast("str", os.fspath(value))
        return self.arrays.add(mesh_arrays(value))

    def labelled(self, value: Any, path: str, key: str) -> Any:
        if value.ndim == 1:
            return self.array(np.asarray(value.values), path, key)
        array, box = labelled_grid(path, value)
        name = self.arrays.add(array)
        if key == "file":
            return name
        return {"file": name} if box is None else {"file": name, "min": box[0], "max": box[1]}

    def array(self, value: Array, path: str, key: str) -> Any:
        if value.ndim == 3:
            name = self.arrays.add(grid_array(path, value))
            return name if key == "file" else {"file": name}
        by_face = path.startswith("surface") and (key in FACE_VALUE_KEYS or key == "file")
        if value.ndim == 1 and by_face:
            name = self.arrays.add(face_array(path, value))
            return name if key == "file" else {"file": name}
        if value.ndim > 2:
            raise InputError(f"{path}: the array has the shape {value.shape}; give one of shape (nx, ny, nz)")
        return value.tolist()


def _number(x: float) -> str:
    if math.isnan(x):
        return "nan"
    return repr(x) if math.isfinite(x) else ("inf" if x > 0 else "-inf")


def _text(s: str) -> str:
    return json.dumps(s, ensure_ascii=False).replace("\x7f", "\\u007f")


def _key(name: str) -> str:
    is_bare = bool(name) and all(c.isascii() and (c.isalnum() or c in "_-") for c in name)
    return name if is_bare else _text(name)


def _inline(value: Any, path: str) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return _number(value)
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, list):
        return "[" + ", ".join(_inline(v, path) for v in cast("list[Any]", value)) + "]"
    if isinstance(value, dict):
        items = cast("dict[str, Any]", value).items()
        inner = ", ".join(f"{_key(k)} = {_inline(v, f'{path}.{k}')}" for k, v in items)
        return f"{{ {inner} }}" if inner else "{}"
    raise InputError(f"{path}: a {type(value).__name__} has no place in a scene; give a number, a text, a list, a table or an array")


def _is_list_of_tables(value: Any) -> bool:
    if not isinstance(value, list) or not value:
        return False
    return all(isinstance(v, dict) for v in cast("list[Any]", value))


def _table(values: dict[str, Any], header: str, lines: list[str]) -> None:
    """Numbers and texts first, then tables, then lists of tables."""
    for k, v in values.items():
        is_table = isinstance(v, dict) and not header
        if not is_table and not (_is_list_of_tables(v) and not header.startswith("[[")):
            lines.append(f"{_key(k)} = {_inline(v, k)}")
    for k, v in values.items():
        if isinstance(v, dict) and not header:
            lines += ["", f"[{_key(k)}]"]
            _table(cast("dict[str, Any]", v), _key(k), lines)
    for k, v in values.items():
        if _is_list_of_tables(v) and not header.startswith("[["):
            name = f"{header}.{_key(k)}" if header else _key(k)
            for entry in v:
                lines += ["", f"[[{name}]]"]
                _table(entry, f"[[{name}]]", lines)


def toml_text(values: dict[str, Any]) -> str:
    """TOML text of plain values."""
    lines: list[str] = []
    _table(values, "", lines)
    return "\n".join(lines).lstrip("\n") + "\n"


def save_arrays(values: Any, arrays: Arrays, folder: Path, stem: str) -> Any:
    """Writes arrays beside a scene file; returns the values with the names of the files."""
    files: dict[str, str] = {}
    for number, (name, array) in enumerate(arrays.values.items(), start=1):
        if isinstance(array, MeshArrays):
            files[name] = f"{stem}.mesh-{number}.obj"
            write_obj(str(folder / files[name]), array)
        else:
            files[name] = f"{stem}.array-{number}.npy"
            np.save(folder / files[name], array)
    return renamed(values, files)


def renamed(values: Any, names: Mapping[str, str]) -> Any:
    """Values with other names of files."""
    if isinstance(values, dict):
        return {k: renamed(v, names) for k, v in cast("dict[str, Any]", values).items()}
    if isinstance(values, list):
        return [renamed(v, names) for v in cast("list[Any]", values)]
    return names.get(values, values) if isinstance(values, str) else values


def moved(values: Any, base: Path, arrays: Arrays, key: str = "") -> Any:
    """Values whose relative names of files are relative to another folder: they become absolute."""
    if isinstance(values, dict):
        return {k: moved(v, base, arrays, k) for k, v in cast("dict[str, Any]", values).items()}
    if isinstance(values, list):
        return [moved(v, base, arrays) for v in cast("list[Any]", values)]
    if key in _FILE_KEYS and isinstance(values, str) and values not in arrays.values:
        return str((base / values).resolve())
    return values
