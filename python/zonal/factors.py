"""View factors of the faces of a mesh, with error radii."""

from __future__ import annotations

import html
import importlib
import os
import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal, TypeAlias, cast

import numpy as np
import numpy.typing as npt

from . import _zonal
from ._meshes import is_path, mesh_arrays
from ._progress import Progress, observed
from ._types import Floats, Integers, Mesh, Path
from .diagnostics import Diagnostic, of_rows
from .errors import FileError, InputError
from .solution import memory_limit

__all__ = ["CompressedRows", "ViewFactors", "view_factors"]

Groups: TypeAlias = Sequence[str] | Integers | Mapping[str, Any]
"""A name or a number for each face; or a mapping from names to the faces of each."""

# Of a product, relative.
_ROUNDING = float(np.finfo(np.float64).eps)


class CompressedRows:
    """A sparse matrix by compressed rows, for use without scipy.

    Attributes
    ----------
    data : numpy.ndarray
        Values of the stored entries, row by row.
    indices : numpy.ndarray
        Their columns, ascending within a row.
    indptr : numpy.ndarray
        First entry of each row, and the number of all at the end.
    shape : tuple of int
        Rows and columns.

    Examples
    --------
    >>> import numpy as np, zonal as zn
    >>> m = zn.CompressedRows(np.array([2.0, 3.0]), np.array([1, 0]), np.array([0, 1, 2]), (2, 2))
    >>> m.toarray().tolist(), (m @ np.array([1.0, 10.0])).tolist()
    ([[0.0, 2.0], [3.0, 0.0]], [20.0, 3.0])
    >>> float(m[0, 1]), np.asarray(m).sum()
    (2.0, np.float64(5.0))
    """

    def __init__(
        self, data: npt.NDArray[Any], indices: npt.NDArray[Any], indptr: npt.NDArray[Any], shape: tuple[int, int]
    ) -> None:
        self.data = data
        self.indices = indices
        self.indptr = indptr
        self.shape = shape

    @property
    def nnz(self) -> int:
        """Number of stored entries."""
        return len(self.data)

    def toarray(self) -> npt.NDArray[Any]:
        """The whole matrix, zeros included."""
        out = np.zeros(self.shape, dtype=self.data.dtype)
        out[self._rows(), self.indices] = self.data
        return out

    def sum(self, axis: int) -> npt.NDArray[Any]:
        """Sums of the columns (``axis=0``) or of the rows (``axis=1``)."""
        keys = self.indices if axis == 0 else self._rows()
        return np.bincount(keys, weights=self.data, minlength=self.shape[1 - axis])

    def __matmul__(self, x: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """The product with a vector of shape (columns,)."""
        return np.bincount(self._rows(), weights=self.data * np.asarray(x)[self.indices], minlength=self.shape[0])

    def __getitem__(self, place: tuple[int, int]) -> Any:
        """The entry of a row and a column."""
        row, column = (int(np.arange(n)[k]) for n, k in zip(self.shape, place, strict=True))
        start, end = self.indptr[row], self.indptr[row + 1]
        k = start + np.searchsorted(self.indices[start:end], column)
        return self.data[k] if k < end and self.indices[k] == column else self.data.dtype.type(0)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        return self.toarray().astype(dtype or self.data.dtype, copy=False)

    def _rows(self) -> npt.NDArray[Any]:
        return np.repeat(np.arange(self.shape[0]), np.diff(self.indptr))

    def __repr__(self) -> str:
        return f"<zonal.CompressedRows: {self.shape[0]} x {self.shape[1]}, {self.nnz} entries; toarray() has all>"


class ViewFactors:
    """View factors F of n faces: sparse rows with an error radius for each factor, and factors to the surroundings.

    ``F[i, j]`` is the share of the diffuse power of face i that arrives at face j. Each row with :attr:`sky` and :attr:`ground` sums to 1 if rows were closed.
    The matrices are of ``scipy.sparse.csr_array`` if scipy is installed, otherwise :class:`CompressedRows`.

    Made by :func:`view_factors`. Objects can be pickled.
    """

    def __init__(self, arrays: Mapping[str, Any], names: Sequence[str] = ()) -> None:
        self._arrays = dict(arrays)
        self._names = [str(n) for n in names]
        self._made: dict[str, Any] = {}

    def __len__(self) -> int:
        return len(self._arrays["areas"])

    def __getstate__(self) -> dict[str, Any]:
        return {"_arrays": self._arrays, "_names": self._names, "_made": {}}

    # Matrices.

    def _csr(self, name: str, values: npt.NDArray[Any]) -> Any:
        if name not in self._made:
            indices = cast("npt.NDArray[np.uint32]", self._arrays["columns"]).view(np.int32)
            indptr = cast("npt.NDArray[np.uint64]", self._arrays["row_starts"]).view(np.int64)
            shape = (len(self), len(self))
            try:
                sparse: Any = importlib.import_module("scipy.sparse")
            except ImportError:
                self._made[name] = CompressedRows(values, indices, indptr, shape)
            else:
                self._made[name] = sparse.csr_array((values, indices, indptr), shape=shape)
        return self._made[name]

    def _per_area(self) -> Floats:
        areas = self.areas
        return np.divide(1.0, areas, out=np.zeros_like(areas), where=areas > 0)

    def _per_area_of_entries(self) -> Floats:
        return np.repeat(self._per_area(), np.diff(self._arrays["row_starts"].view(np.int64)))

    @property
    def matrix(self) -> Any:
        """F, (faces, faces), sparse."""
        if "matrix" in self._made:
            return self._made["matrix"]
        return self._csr("matrix", self._arrays["exchange_areas"] * self._per_area_of_entries())

    @property
    def radius(self) -> Any:
        """Error radii of :attr:`matrix`, (faces, faces), sparse, with the same entries."""
        if "radius" in self._made:
            return self._made["radius"]
        scale = self._per_area_of_entries()
        rounding = self._arrays["exchange_areas"] * scale * _ROUNDING
        return self._csr("radius", self._arrays["radii"].astype(np.float64) * scale * (1 + 2 * _ROUNDING) + rounding)

    @property
    def exchange_areas(self) -> Any:
        """A_i F_ij, (faces, faces), sparse, symmetric to the bit; m2."""
        return self._csr("exchange_areas", self._arrays["exchange_areas"])

    @property
    def exchange_radius(self) -> Any:
        """Error radii of :attr:`exchange_areas`, single precision, m2."""
        return self._csr("exchange_radius", self._arrays["radii"])

    # Rows.

    @property
    def areas(self) -> Floats:
        """Areas of the faces, (faces,), m2."""
        return self._arrays["areas"]

    @property
    def sky(self) -> Floats:
        """F to directions above the horizon that meet nothing, (faces,); 0 in an enclosure."""
        return self._arrays["sky"][:, 0] * self._per_area()

    @property
    def sky_radius(self) -> Floats:
        """Error radii of :attr:`sky`, (faces,)."""
        return self._arrays["sky"][:, 1] * self._per_area() * (1 + 2 * _ROUNDING) + self.sky * _ROUNDING

    @property
    def ground(self) -> Floats:
        """F to directions below the horizon that meet nothing, (faces,)."""
        return self._arrays["ground"][:, 0] * self._per_area()

    @property
    def ground_radius(self) -> Floats:
        """Error radii of :attr:`ground`, (faces,)."""
        return self._arrays["ground"][:, 1] * self._per_area() * (1 + 2 * _ROUNDING) + self.ground * _ROUNDING

    @property
    def row_sums(self) -> Floats:
        """Sums of the rows with sky and ground, (faces,)."""
        return np.asarray(self.matrix.sum(axis=1)).reshape(-1) + self.sky + self.ground

    @property
    def defect(self) -> Floats:
        """Row sums minus 1 before rows were closed, (faces,)."""
        return self._arrays["defects"]

    @property
    def remaining_defect(self) -> float:
        """Largest defect after rows were closed, without the open rows."""
        return float(self._arrays["remaining_defect"])

    @property
    def open_rows(self) -> Integers:
        """Faces whose row is not closed, since its defect is larger than its errors explain: faces inside a solid, or that see backs of others or obstacles."""
        return self._arrays["open_rows"]

    @property
    def grade(self) -> Literal["proved", "estimated"]:
        """Evidence for the radii."""
        return self._arrays["grade"]

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of pairs of faces by treatment, and of occluders."""
        names = ("facets", "occluders", "solids", "examined", "unobstructed", "hidden", "partial")
        return dict(zip(names, map(int, self._arrays["counts"]), strict=True))

    @property
    def names(self) -> list[str]:
        """Names of the rows of combined factors; otherwise numbers of the faces as text."""
        return list(self._names) or [str(i) for i in range(len(self))]

    @property
    def materials(self) -> list[str]:
        """The material of each face as its mesh names it (physical groups of gmsh, ``usemtl`` of OBJ), for :meth:`combined`; empty for combined factors."""
        if "material" not in self._arrays:
            return []
        names = self._arrays["materials"]
        return [names[k] for k in self._arrays["material"]]

    @property
    def emissivities(self) -> Floats:
        """Emissivities of the faces as an input file of View3D states them, (faces,); 1 of others."""
        return self._arrays.get("emissivities", np.ones(len(self)))

    @property
    def warnings(self) -> list[Diagnostic]:
        """Warnings of the computation: rows that stay open, and radii above the tolerance. Combined factors have none."""
        return of_rows(self._arrays.get("diagnostics", ()), "warning")

    @property
    def notes(self) -> list[Diagnostic]:
        """Notes of the computation: repairs of the mesh, contents that have no effect, and faces without area. Combined factors have none."""
        return of_rows(self._arrays.get("diagnostics", ()), "note")

    @property
    def table(self) -> dict[str, Any]:
        """Columns by face, for ``pandas.DataFrame(factors.table)``."""
        starts = self._arrays["row_starts"].view(np.int64)
        return {
            "name": self.names,
            "area": self.areas,
            "faces_seen": np.diff(starts),
            "row_sum": self.row_sums,
            "sky": self.sky,
            "sky_radius": self.sky_radius,
            "ground": self.ground,
            "ground_radius": self.ground_radius,
            "defect": self.defect,
        }

    # Results of results.

    def combined(self, groups: Groups) -> ViewFactors:
        """The factors of unions of faces, such as the walls of a room.

        Parameters
        ----------
        groups : list of str, array of int or dict
            A name or a number (0, 1, …) for each face; or a dictionary from names to the numbers of the faces of each, which must name every face once.

        Returns
        -------
        ViewFactors
            With :attr:`names`, in the order of their first face.

        Raises
        ------
        InputError
            If a face is in no group or in several.

        Examples
        --------
        >>> import zonal as zn
        >>> corners = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]
        >>> walls = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        >>> cube = zn.view_factors((corners, walls), surroundings=False)
        >>> cube.combined(["floor", "roof", "side", "side", "side", "side"]).matrix.toarray().round(4)
        array([[0.    , 0.1998, 0.8002],
               [0.1998, 0.    , 0.8002],
               [0.2   , 0.2   , 0.5999]])
        """
        names, index = self._groups(groups)
        made = _zonal.combined_view_factors(self._arrays, index, len(names))
        made["enclosure"] = self._arrays.get("enclosure", False)
        return ViewFactors(made, names)

    def _groups(self, groups: Groups) -> tuple[list[str], Integers]:
        n = len(self)
        if isinstance(groups, Mapping):
            mapping = groups
            index = np.full(n, -1, dtype=np.int64)
            for k, (name, faces) in enumerate(mapping.items()):
                faces = np.atleast_1d(np.asarray(faces, dtype=np.int64))
                if len(faces) and (faces.min() < 0 or faces.max() >= n):
                    raise InputError(f"groups: '{name}' names a face out of range; there are {n}")
                if (index[faces] >= 0).any() or len(np.unique(faces)) != len(faces):
                    raise InputError(f"groups: a face of '{name}' is in two groups; name every face once")
                index[faces] = k
            if (index < 0).any():
                raise InputError(f"groups: face {int(np.argmax(index < 0))} is in no group; name every face once")
            return [str(name) for name in mapping], index
        values = list(cast("Iterable[Any]", groups))
        if len(values) != n:
            raise InputError(f"groups: there are {len(values)} values and {n} faces; give one for each face")
        if values and not isinstance(values[0], str):
            index = np.asarray(values, dtype=np.int64)
            if index.min() < 0:
                raise InputError("groups: a number is below 0; give 0, 1, …")
            return [str(k) for k in range(int(index.max()) + 1)], index
        order: dict[str, int] = {}
        index = np.array([order.setdefault(str(v), len(order)) for v in values], dtype=np.int64)
        return list(order), index

    def script_f(
        self, emissivity: float | Sequence[float] | Floats, *, threads: int | None = None, progress: Progress = None
    ) -> tuple[Floats, Floats]:
        """Hottel's total exchange factors (script F) of grey faces, and their error radii.

        The net power from face i to face j is A_i F_ij sigma (T_i^4 - T_j^4), with all reflections.

        Parameters
        ----------
        emissivity : float or array of shape (faces,)
            0 to 1; taken as at least 0.001 and at most 0.999.
        threads, progress : optional
            As of :func:`view_factors`.

        Returns
        -------
        values, radii : numpy.ndarray
            (faces, faces) each.

        Raises
        ------
        InputError
            For more than 6,000 faces, a face without an area, or emissivities out of range.

        Notes
        -----
        Hottel and Sarofim, Radiative Transfer, 1967, chapter 3.

        Examples
        --------
        Two parallel plates, close to each other: 1 / (1/0.8 + 1/0.5 - 1) = 0.4444.

        >>> import zonal as zn
        >>> square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
        >>> above = [[x, y, 0.001] for x, y, _ in square]
        >>> plates = zn.view_factors((square + above, [[0, 1, 2, 3], [7, 6, 5, 4]]))
        >>> float(plates.script_f([0.8, 0.5])[0][0, 1].round(2))
        0.44
        """
        with observed(progress) as function:
            return _zonal.script_factors(self._arrays, self._per_face(emissivity).tolist(), function, threads)

    # Files.

    def save(
        self,
        path: Path,
        *,
        format: Literal["text", "binary", "sparse"] | None = None,
        emissivity: float | Sequence[float] | Floats | None = None,
        script_f: bool = False,
        threads: int | None = None,
    ) -> None:
        """Writes a file in the format of its extension.

        Parameters
        ----------
        path : path
            ``.npz``: the matrix as ``scipy.sparse.load_npz`` reads it, with radii, areas and the factors to the surroundings. Others as ``zonal view-factors``
            writes them: ``.csv``, ``.mtx`` (MatrixMarket), ``.txt``, ``.out`` and ``.bin`` (View3D).
        format : {"text", "binary", "sparse"}, optional
            View3D's format of ``.txt`` and ``.out``; text by default.
        emissivity : float or array of shape (faces,), optional
            Emissivities in View3D's formats; :attr:`emissivities` by default.
        script_f : bool
            Total exchange factors with these emissivities in place of view factors; not in ``.npz``.
        threads : int, optional
            As of :func:`view_factors`.

        Notes
        -----
        Keys of an ``.npz``: ``format``, ``shape``, ``data``, ``indices``, ``indptr``, ``radii`` (single precision, rounded up), ``areas``, ``sky``, ``sky_radii``, ``ground``,
        ``ground_radii``, ``defects``, ``names``, and those that :meth:`load` needs to restore every bit (``zonal_…``).

        Raises
        ------
        FileError
            If the file cannot be written.
        """
        target = os.fspath(path)
        if not target.lower().endswith(".npz"):
            self._write(target, format, emissivity, script_f, threads)
            return
        if format is not None or emissivity is not None or script_f:
            raise InputError("format, emissivity, script_f: these do not apply to an .npz; leave them out, or write .txt, .csv or .mtx")
        exact = cast(Floats, self.radius.data)
        nearest = exact.astype(np.float32)
        radii = np.where(nearest < exact, np.nextafter(nearest, np.float32(np.inf)), nearest)
        columns: dict[str, Any] = {
            "format": np.array(b"csr"),
            "shape": np.array([len(self), len(self)], dtype=np.int64),
            "data": self.matrix.data,
            "indices": self._arrays["columns"].view(np.int32),
            "indptr": self._arrays["row_starts"].view(np.int64),
            "radii": radii,
            "areas": self.areas,
            "sky": self.sky,
            "sky_radii": self.sky_radius,
            "ground": self.ground,
            "ground_radii": self.ground_radius,
            "defects": self.defect,
            "names": np.array(self.names),
        }
        columns |= {f"zonal_{k}": v for k, v in self._arrays.items() if k not in _WRITTEN_ONCE}
        temporary = f"{target}.partial.npz"
        try:
            np.savez_compressed(temporary, **columns)
            os.replace(temporary, target)
        except OSError as e:
            raise FileError(f"{target}: the view factors cannot be written ({e}); choose another folder", target) from e

    def _write(
        self, target: str, format: str | None, emissivity: float | Sequence[float] | Floats | None, script: bool, threads: int | None
    ) -> None:
        values = self._per_face(self.emissivities if emissivity is None else emissivity)
        names = self.names if self._names else (self.materials or self.names)
        enclosure = bool(self._arrays.get("enclosure", False))
        settings = {"format": format, "names": names, "emissivities": values.tolist(), "enclosure": enclosure, "script": script}
        _zonal.write_view_factors(self._arrays, target, settings, threads)

    def _per_face(self, emissivity: float | Sequence[float] | Floats) -> Floats:
        values = np.asarray(emissivity, dtype=np.float64).reshape(-1)
        return np.full(len(self), values[0]) if np.ndim(emissivity) == 0 else values

    @staticmethod
    def load(path: Path) -> ViewFactors:
        """Reads a file of :meth:`save`.

        Raises
        ------
        FileError
            If it is no such file.
        """
        source = os.fspath(path)
        try:
            with np.load(source, allow_pickle=False) as file:
                arrays: dict[str, Any] = {k[6:]: file[k] for k in file.files if k.startswith("zonal_")}
                arrays |= {
                    "areas": file["areas"],
                    "columns": file["indices"].view(np.uint32),
                    "row_starts": file["indptr"].view(np.uint64),
                    "defects": file["defects"],
                }
                names = [str(n) for n in file["names"]]
            for key in ("grade", "remaining_defect", "enclosure"):
                if key in arrays:
                    arrays[key] = arrays[key].item()
            if "materials" in arrays:
                arrays["materials"] = [str(n) for n in arrays["materials"]]
            if "diagnostics" in arrays:
                arrays["diagnostics"] = [tuple(str(part) for part in row) for row in arrays["diagnostics"]]
            n = len(arrays["areas"])
            # The native module checks that the arrays fit together.
            _zonal.combined_view_factors(arrays, np.zeros(n, dtype=np.int64), 1)
        except OSError as e:
            raise FileError(f"{source}: cannot be read ({e}); give a file of ViewFactors.save", source) from e
        except (KeyError, ValueError, TypeError, AttributeError, InputError) as e:
            # numpy's own text speaks of pickled objects where a file is no .npz.
            reason = f" ({e})" if isinstance(e, (KeyError, InputError)) else ""
            raise FileError(f"{source}: this holds no view factors of ViewFactors.save{reason}; save them again", source) from e
        return ViewFactors(arrays, names if names != [str(i) for i in range(n)] else ())

    # Display.

    def _facts(self) -> list[tuple[str, str]]:
        sums = self.row_sums
        entries = len(self._arrays["columns"])
        largest = float(self.radius.data.max()) if entries else 0.0
        return [
            ("faces", f"{len(self):,}"),
            ("pairs that see each other", f"{entries // 2:,}"),
            ("largest error radius of a factor", f"{largest:.1e} ({self.grade})"),
            ("row sums", f"{sums.min():.9f} to {sums.max():.9f}" if len(self) else "none"),
            ("largest defect before closing", f"{np.abs(self.defect).max(initial=0.0):.1e}"),
            ("open rows", f"{len(self.open_rows):,}"),
        ]

    def _repr_html_(self) -> str:
        rows = "".join(f"<tr><th style='text-align:left'>{html.escape(k)}</th><td>{html.escape(v)}</td></tr>" for k, v in self._facts())
        return f"<table><caption>zonal.ViewFactors</caption>{rows}</table>"

    def __repr__(self) -> str:
        return f"<zonal.ViewFactors: {len(self)} faces, {len(self._arrays['columns'])} factors, {self.grade}>"


# Arrays that stand in a file under the names that scipy and the command know.
_WRITTEN_ONCE = ("areas", "columns", "row_starts", "defects")
_AXES = ("x", "y", "z")


def _number(name: str, value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise InputError(f"{name}: {value!r} is no number; give one") from None


def _native_mesh(mesh: Mesh) -> Any:
    if is_path(mesh):
        return os.fspath(cast(Path, mesh))
    return tuple(mesh_arrays(mesh))


def _obstacle_list(obstacles: Any) -> list[Any]:
    if obstacles is None:
        return []
    if isinstance(obstacles, list):
        return [_native_mesh(o) for o in cast("list[Any]", obstacles)]
    return [_native_mesh(obstacles)]


def _periods(up: str, given: Mapping[str, float | None]) -> list[float | None]:
    axis = _AXES.index(up)
    if given.get(up) is not None:
        raise InputError(f"period_{up}: the geometry cannot repeat along the vertical '{up}'; give another axis as up")
    return [given.get(_AXES[(axis + k) % 3]) for k in (1, 2)]


def view_factors(
    mesh: Mesh,
    *,
    obstacles: Mesh | list[Mesh] | None = None,
    sides: Literal["front", "both"] = "front",
    tolerance: float = 1e-3,
    closing: bool = True,
    surroundings: bool = True,
    up: Literal["x", "y", "z"] = "z",
    period_x: float | None = None,
    period_y: float | None = None,
    max_memory: float | None = None,
    cache: Path | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> ViewFactors:
    """The view factors of all pairs of faces of a mesh, which also hide each other, with an error radius for each.

    Parameters
    ----------
    mesh : mesh or path
        ``(vertices, faces)`` with arrays of shape (vertices, 3) and (faces, 3) or (faces, 4), or faces as a list of lists of any length; the corners of
        the faces, (faces, corners, 3);
        ``pyvista.PolyData``, ``trimesh.Trimesh`` or ``meshio.Mesh``; or the path of a mesh file or of an input file of View3D (``.vs3``); m. A face sees with its front, from which its corners run counter-clockwise. Rows keep the order of the faces.
    obstacles : mesh, path or list of them, optional
        Faces that hide from both sides and exchange nothing. A pair ``(vertices, faces)`` is one mesh as a tuple.
    sides : {"front", "both"}
        Sides that exchange. With ``"both"`` the rows of the backs follow those of the fronts in the same order: 2 n rows for n faces.
    tolerance : float
        Requested error radius of a factor F: max(tolerance F, tolerance / 50). A pair that cannot meet it has a larger stated radius.
    closing : bool
        Makes rows sum to 1 by the least change relative to the error radii; the change becomes part of the radii. Reciprocity is kept.
    surroundings : bool
        Whether faces see the sky and the space below the horizon where nothing hides them; ``False`` for an enclosure, as ``encl = 1`` in a ``.vs3`` file.
    up : {"x", "y", "z"}
        The axis that points to the sky.
    period_x, period_y : float, optional
        The geometry repeats along this axis without end, m.
    max_memory : float, optional
        Largest memory of the results, GB; 12 by default.
    cache : path, optional
        Folder of finished parts: an interrupted call resumes, and an equal call reads all of them.
    threads : int, optional
        Number of threads; all cores by default. Results do not depend on it.
    progress : optional
        As of :meth:`Scene.solve`.

    Returns
    -------
    ViewFactors

    Raises
    ------
    InputError
        If the mesh or a setting is not valid.
    MemoryLimitError
        If the factors need more than ``max_memory``.
    FileError
        If the cache cannot be written.

    Warns
    -----
    RuntimeWarning
        For each of :attr:`ViewFactors.warnings`: rows that stay open, since their faces lie inside a solid, see backs of others, or see obstacles; and radii
        above the tolerance, of faces that are partly hidden.

    Examples
    --------
    Opposite squares at a distance of their edge, and what they see of the surroundings:

    >>> import zonal as zn
    >>> square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> above = [[x, y, 1] for x, y, _ in square]
    >>> F = zn.view_factors((square + above, [[0, 1, 2, 3], [7, 6, 5, 4]]), tolerance=1e-6)
    >>> F.matrix.toarray().round(5)
    array([[0.     , 0.19982],
           [0.19982, 0.     ]])
    >>> F.sky.round(4), F.ground.round(4), bool(F.radius.toarray().max() < 1e-6)
    (array([0.8002, 0.    ]), array([0.    , 0.8002]), True)
    """
    if up not in _AXES:
        raise InputError(f"up: '{up}' is no axis; give x, y or z")
    if sides not in ("front", "both"):
        raise InputError(f"sides: '{sides}' is not known; give front or both")
    settings: dict[str, Any] = {
        "tolerance": _number("tolerance", tolerance),
        "closing": closing,
        "surroundings": surroundings,
        "both_sides": sides == "both",
        "up": _AXES.index(up),
        "periods": _periods(up, {"x": period_x, "y": period_y}),
        "memory_limit": None if max_memory is None else memory_limit(max_memory),
        "cache": None if cache is None else os.fspath(cache),
    }
    with observed(progress) as function:
        made = _zonal.view_factors(_native_mesh(mesh), _obstacle_list(obstacles), settings, function, threads)
    factors = ViewFactors(made)
    for found in factors.warnings:
        warnings.warn(found.text, RuntimeWarning, stacklevel=2)
    return factors
