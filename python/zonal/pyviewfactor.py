"""The names of pyviewfactor 1.1: its scripts run with ``import zonal.pyviewfactor as pvf``.

Matrices have pyviewfactor's layout: ``F[i, j]`` is the factor from face j to face i, so that columns sum to 1 in an enclosure;
:func:`zonal.view_factors` gives the transpose, with error radii. Differences:

- A pair of faces is hidden in part where something stands between parts of it; pyviewfactor tests one ray between the centroids.
- The faces of a mesh hide each other also without ``obstacles``. With ``skip_obstruction=True`` each pair is computed alone.
- Faces exchange with their fronts only, also with ``skip_visibility=True``.
- ``rounding_decimal``, ``epsilon``, ``strict_visibility`` and ``strict_obstruction`` have no effect on factors.

Cells are pyvista meshes of one face, or arrays of corners of shape (n, 3). pyvista is imported only by functions that return its objects.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from ._meshes import mesh_arrays
from ._types import Floats, Mesh
from .errors import InputError
from .factors import view_factors

__all__ = [
    "FaceMeshPreprocessor",
    "ProcessedGeometry",
    "compute_viewfactor",
    "compute_viewfactor_dblquad",
    "compute_viewfactor_gauss_legendre",
    "compute_viewfactor_matrix",
    "compute_viewfactor_matrix_fast",
    "compute_viewfactor_sa30",
    "face_normal_numpy",
    "face_to_array",
    "fc_unstruc2poly",
    "get_obstruction",
    "get_obstruction_from_cache",
    "get_visibility",
    "get_visibility_from_cache",
    "is_ray_blocked",
    "plot_viewfactor",
    "polygon_area",
    "polygon_centroid",
    "ray_intersects_triangle",
    "set_quadrature_order",
    "tri_overlaps_aabb",
]

_TOLERANCE = 1e-6


# Faces.


def fc_unstruc2poly(mesh_unstruc: Any) -> Any:
    """The faces of a ``pyvista.UnstructuredGrid`` as a ``pyvista.PolyData``, in their order."""
    cells = getattr(mesh_unstruc, "cells", None)
    if cells is None:
        return mesh_unstruc
    pyvista: Any = importlib.import_module("pyvista")
    return pyvista.PolyData(np.asarray(mesh_unstruc.points), np.asarray(cells))


def face_to_array(face: Any, rounding_decimal: int = 8) -> Floats:
    """The corners of a mesh of one face, (n, 3), rounded to a number of decimals."""
    if isinstance(face, np.ndarray):
        return np.round(np.asarray(face, dtype=np.float64), rounding_decimal)
    mesh = mesh_arrays(fc_unstruc2poly(face))
    if mesh.face_count < 1:
        raise InputError("face: the mesh has no face; give a mesh of one face")
    return np.round(mesh.vertices[mesh.face(0)], rounding_decimal)


def _area_vector(pts: Floats) -> Floats:
    d = np.asarray(pts, dtype=np.float64) - pts[0]
    return 0.5 * np.cross(d[1:-1], d[2:]).sum(axis=0)


def polygon_area(pts: Floats) -> float:
    """The area of a plane polygon."""
    return float(np.linalg.norm(_area_vector(pts)))


def face_normal_numpy(pts: Floats) -> Floats:
    """The unit normal of a plane polygon; z for one without an area."""
    vector = _area_vector(pts)
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0 else np.array([0.0, 0.0, 1.0])


def polygon_centroid(pts: Floats) -> Floats:
    """The centroid of a plane polygon; the mean of the corners of one without an area."""
    p = np.asarray(pts, dtype=np.float64)
    d = p - p[0]
    weights = np.cross(d[1:-1], d[2:]) @ face_normal_numpy(p)
    if abs(weights.sum()) < 1e-300:
        return p.mean(axis=0)
    return p[0] + weights @ (d[1:-1] + d[2:]) / (3.0 * weights.sum())


def tri_overlaps_aabb(tri_pts: Floats, aabb_min: Floats, aabb_max: Floats) -> bool:
    """Whether the bounding box of a triangle, (3, 3), meets a box; boxes that touch do."""
    return bool(_boxes_meet(np.asarray(tri_pts, dtype=np.float64)[None], aabb_min, aabb_max)[0])


def _boxes_meet(triangles: Floats, low: Floats, high: Floats) -> npt.NDArray[np.bool_]:
    """The triangles, (n, 3, 3), whose bounding boxes meet a box."""
    reaches = (triangles.max(axis=1) >= np.asarray(low)) & (triangles.min(axis=1) <= np.asarray(high))
    return reaches.all(axis=1)


class ProcessedGeometry:
    """The corners, normals, centroids, areas and mean lengths of edges of the faces of a mesh."""

    def __init__(self, mesh: Mesh, rounding_decimal: int = 8) -> None:
        arrays = mesh_arrays(fc_unstruc2poly(mesh))
        self.rounding_decimal = rounding_decimal
        self.N = arrays.face_count
        self.points = [np.round(arrays.vertices[arrays.face(k)], rounding_decimal) for k in range(self.N)]
        self.normals = np.array([face_normal_numpy(p) for p in self.points]).reshape(-1, 3)
        self.centroids = np.array([polygon_centroid(p) for p in self.points]).reshape(-1, 3)
        self.areas = np.array([polygon_area(p) for p in self.points])
        self.sizes = np.array([np.linalg.norm(p - np.roll(p, 1, axis=0), axis=1).mean() for p in self.points])

    def get_face(self, i: int) -> Floats:
        """The corners of face i, (n, 3)."""
        return self.points[i]

    def get_normal(self, i: int) -> Floats:
        """The unit normal of face i."""
        return self.normals[i]

    def get_centroid(self, i: int) -> Floats:
        """The centroid of face i."""
        return self.centroids[i]

    def get_area(self, i: int) -> float:
        """The area of face i."""
        return float(self.areas[i])

    def get_size(self, i: int) -> float:
        """The mean length of the edges of face i."""
        return float(self.sizes[i])


class FaceMeshPreprocessor:
    """The triangles of an obstacle, (triangles, 3, 3), their corners among ``points`` as ``faces``, and their bounding boxes."""

    def __init__(self, mesh: Mesh, rounding_decimal: int = 8) -> None:
        arrays = mesh_arrays(fc_unstruc2poly(mesh))
        polygons = [arrays.face(k) for k in range(arrays.face_count)]
        fans = [[c[0], c[i], c[i + 1]] for c in polygons for i in range(1, len(c) - 1)]
        self.rounding_decimal = rounding_decimal
        self.points: Floats = np.round(arrays.vertices, rounding_decimal)
        self.faces = np.array(fans, dtype=np.int64).reshape(-1, 3)
        self.triangles: Floats = self.points[self.faces]
        self.tri_mins: Floats = self.triangles.min(axis=1)
        self.tri_maxs: Floats = self.triangles.max(axis=1)

    def aabb_filter(self, aabb_min: Floats, aabb_max: Floats) -> Floats:
        """The triangles whose bounding boxes meet a box, (n, 3, 3)."""
        return self.triangles[_boxes_meet(self.triangles, aabb_min, aabb_max)]

    def exclude_exact_match(self, pts1: Floats, pts2: Floats, tris: Floats, rounding_decimal: int = 8) -> Floats:
        """The triangles of ``tris``, (n, 3, 3), whose corners are not those of ``pts1`` or of ``pts2`` in any order."""
        own = [_corner_set(p, rounding_decimal) for p in (pts1, pts2)]
        others = [t for t in tris if _corner_set(t, rounding_decimal) not in own]
        return np.array(others, dtype=np.float64).reshape(-1, 3, 3)

    def build_exclusion_masks(self, pg: ProcessedGeometry) -> npt.NDArray[np.bool_]:
        """Whether each triangle has the corners of each face, (faces, triangles)."""
        own = [_corner_set(t, self.rounding_decimal) for t in self.triangles]
        faces = [_corner_set(pg.get_face(i), self.rounding_decimal) for i in range(pg.N)]
        return np.array([[t == f for t in own] for f in faces], dtype=bool).reshape(pg.N, len(own))


def _corner_set(pts: Floats, decimals: int) -> frozenset[tuple[float, ...]]:
    # Adding zero turns -0 into 0.
    rounded = np.round(np.asarray(pts, dtype=np.float64), decimals) + 0.0
    return frozenset(map(tuple, rounded.tolist()))


# Factors.


def _exchange(pts1: Floats, pts2: Floats) -> float:
    """A2 F21 of two polygons that nothing hides, m2."""
    first, second = len(pts1), len(pts2)
    faces = [list(range(first)), list(range(first, first + second))]
    factors = view_factors((np.concatenate([pts1, pts2]), faces), tolerance=_TOLERANCE, closing=False, surroundings=False)
    return float(factors.exchange_areas.toarray()[1, 0])


def compute_viewfactor(cell1: Any, cell2: Any, *, rounding_decimal: int = 8) -> float:
    """The view factor from ``cell2`` to ``cell1`` with nothing between them.

    Examples
    --------
    >>> import numpy as np, zonal.pyviewfactor as pvf
    >>> square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    >>> round(pvf.compute_viewfactor(square, (square + [0, 0, 1])[::-1]), 5)
    0.19982
    """
    pts1, pts2 = face_to_array(cell1, rounding_decimal), face_to_array(cell2, rounding_decimal)
    area = polygon_area(pts2)
    if area <= 0 or polygon_area(pts1) <= 0:
        raise InputError("cell: a face has no area; give faces of three corners or more that are not on one line")
    return _exchange(pts1, pts2) / area


def compute_viewfactor_sa30(pts1: Floats, pts2: Floats, constante: float) -> float:
    """4 pi A2 F21 / ``constante`` of two polygons of shape (n, 3); ``constante`` is 4 pi A2."""
    return 4.0 * np.pi * _exchange(pts1, pts2) / constante


compute_viewfactor_dblquad = compute_viewfactor_sa30


def compute_viewfactor_gauss_legendre(pts1: Floats, pts2: Floats, constante: float, *_: Any) -> float:
    """As :func:`compute_viewfactor_sa30`; the order of a quadrature has no effect."""
    return compute_viewfactor_sa30(pts1, pts2, constante)


def set_quadrature_order(order: int) -> None:
    """Has no effect: the number of evaluations follows from the tolerance."""
    if order < 1:
        raise InputError(f"order: {order} is no order of a quadrature; give 1 or more")


def compute_viewfactor_matrix(
    mesh: Mesh,
    obstacles: Mesh | Sequence[Mesh] | None = None,
    skip_visibility: bool = False,
    skip_obstruction: bool = False,
    strict_visibility: bool = False,
    strict_obstruction: bool = False,
    rounding_decimal: int = 8,
    epsilon: float | None = None,
    verbose: bool = False,
    *,
    tolerance: float = 1e-4,
) -> Floats:
    """All view factors of a mesh as a dense matrix: ``F[i, j]`` from face j to face i.

    Parameters
    ----------
    mesh : mesh
        As of :func:`zonal.view_factors`, or a ``pyvista.UnstructuredGrid``.
    obstacles : mesh or list of meshes, optional
        Faces that hide from both sides.
    skip_visibility, strict_visibility, strict_obstruction, rounding_decimal, epsilon : optional
        No effect.
    skip_obstruction : bool
        Each pair alone: nothing hides anything.
    verbose : bool
        Prints the number of faces and of pairs.
    tolerance : float
        As of :func:`zonal.view_factors`.

    Returns
    -------
    numpy.ndarray
        (faces, faces).
    """
    poly = fc_unstruc2poly(mesh)
    if skip_obstruction:
        matrix = _unobstructed(ProcessedGeometry(poly, rounding_decimal))
    else:
        several = list(cast("Sequence[Any]", obstacles)) if isinstance(obstacles, (list, tuple)) else [obstacles]
        hiding = [_obstacle(o) for o in several if o is not None]
        found = view_factors(poly, obstacles=hiding, tolerance=tolerance, closing=False, surroundings=False)
        matrix = np.ascontiguousarray(found.matrix.toarray().T)
    if verbose:
        print(f"[zonal] {len(matrix)} faces, {int(np.count_nonzero(matrix)) // 2} pairs see each other")
    return matrix


def compute_viewfactor_matrix_fast(
    mesh: Mesh,
    obstacles: Mesh | Sequence[Mesh] | None = None,
    skip_visibility: bool = False,
    skip_obstruction: bool = False,
    strict_visibility: bool = False,
    strict_obstruction: bool = False,
    rounding_decimal: int = 8,
    verbose: bool = False,
    *,
    tolerance: float = 1e-4,
) -> Floats:
    """As :func:`compute_viewfactor_matrix`, without ``epsilon``."""
    return compute_viewfactor_matrix(
        mesh,
        obstacles,
        skip_visibility,
        skip_obstruction,
        strict_visibility,
        strict_obstruction,
        rounding_decimal,
        verbose=verbose,
        tolerance=tolerance,
    )


def _obstacle(mesh: Any) -> Any:
    if isinstance(mesh, FaceMeshPreprocessor):
        return mesh.triangles.reshape(-1, 3), np.arange(3 * len(mesh.triangles)).reshape(-1, 3)
    return fc_unstruc2poly(mesh)


def _unobstructed(faces: ProcessedGeometry) -> Floats:
    out = np.zeros((faces.N, faces.N))
    for i in range(faces.N):
        ahead = np.array([_reaches_front(faces, i, j) and _reaches_front(faces, j, i) for j in range(i)], dtype=bool)
        for j in np.flatnonzero(ahead):
            exchange = _exchange(faces.points[i], faces.points[j])
            out[i, j], out[j, i] = exchange / faces.areas[j], exchange / faces.areas[i]
    return out


def _reaches_front(faces: ProcessedGeometry, i: int, j: int) -> bool:
    """True if a corner of face j lies in front of face i, and both have an area."""
    return bool(faces.areas[i] * faces.areas[j] > 0 and ((faces.points[j] - faces.centroids[i]) @ faces.normals[i] > 0).any())


# Visibility and obstruction.


def _stated(result: bool, message: str, verbose: bool) -> tuple[bool, str]:
    if verbose:
        print(message)
    return result, message


def _visibility(pts1: Floats, pts2: Floats, strict: bool, verbose: bool) -> tuple[bool, str]:
    first, second = (polygon_centroid(pts1), face_normal_numpy(pts1)), (polygon_centroid(pts2), face_normal_numpy(pts2))
    towards = second[0] - first[0]
    if not (towards @ first[1] > 0 and towards @ second[1] < 0):
        return _stated(False, "[zonal] the fronts of the cells do not face each other", verbose)
    sides = [((pts2 - first[0]) @ first[1]), ((pts1 - second[0]) @ second[1])]
    if all((h >= -1e-8).all() for h in sides):
        return _stated(True, "[zonal] the cells see each other", verbose)
    if strict:
        return _stated(False, "[zonal] the cells see each other only in part", verbose)
    return _stated(True, "[zonal] the cells see each other, in part" if verbose else "[zonal] the cells see each other", verbose)


def get_visibility(
    c1: Any, c2: Any, strict: bool = False, verbose: bool = False, rounding_decimal: int = 8
) -> tuple[bool, str]:
    """Whether the fronts of two cells face each other, without regard to others; and a message.

    With ``strict`` all corners must lie in front of the other cell; otherwise the centroids decide.
    """
    return _visibility(face_to_array(c1, rounding_decimal), face_to_array(c2, rounding_decimal), strict, verbose)


def get_visibility_from_cache(
    i: int, j: int, cache: ProcessedGeometry, strict: bool = False, verbose: bool = False, rounding_decimal: int = 8
) -> tuple[bool, str]:
    """As :func:`get_visibility` for two faces of a :class:`ProcessedGeometry`."""
    return _visibility(cache.get_face(i), cache.get_face(j), strict, verbose)


def _blocked(orig: Floats, dest: Floats, triangles: Floats, eps: float) -> npt.NDArray[np.bool_]:
    """The triangles that an open segment crosses; those with a corner at one of its ends do not count."""
    t = np.asarray(triangles, dtype=np.float64).reshape(-1, 3, 3)
    d = np.asarray(dest, dtype=np.float64) - orig
    if np.linalg.norm(d) < eps:
        return np.zeros(len(t), dtype=bool)
    ends = [np.linalg.norm(t - np.asarray(p), axis=2).min(axis=1, initial=np.inf) < eps for p in (orig, dest)]
    a, b = t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]
    normal = np.cross(a, b)
    slope = normal @ d
    crossing = np.abs(slope) > 1e-12 * np.linalg.norm(normal, axis=1) * np.linalg.norm(d)
    safe = np.where(crossing, slope, 1.0)
    s = np.einsum("ij,ij->i", normal, t[:, 0] - orig) / safe
    hit = orig + s[:, None] * d - t[:, 0]
    area2 = np.einsum("ij,ij->i", normal, normal)
    area2 = np.where(area2 > 0, area2, 1.0)
    v = np.einsum("ij,ij->i", np.cross(hit, b), normal) / area2
    w = np.einsum("ij,ij->i", np.cross(a, hit), normal) / area2
    inside = (v >= 0) & (w >= 0) & (v + w <= 1)
    return crossing & inside & (s > eps) & (s < 1 - eps) & ~ends[0] & ~ends[1]


def ray_intersects_triangle(orig: Floats, dest: Floats, v0: Floats, v1: Floats, v2: Floats, eps: float = 1e-6) -> bool:
    """Whether the open segment from ``orig`` to ``dest`` crosses a triangle of which it touches no corner."""
    return bool(_blocked(orig, dest, np.stack([v0, v1, v2]), eps)[0])


def is_ray_blocked(start: Floats, end: Floats, triangles: Floats, eps: float = 1e-6) -> bool:
    """Whether the open segment from ``start`` to ``end`` crosses any of the triangles, (n, 3, 3)."""
    return bool(_blocked(start, end, triangles, eps).any())


def _obstruction(pts1: Floats, pts2: Floats, triangles: Floats, strict: bool, verbose: bool, eps: float) -> tuple[bool, str]:
    corners = {tuple(p) for p in np.round(np.concatenate([pts1, pts2]), 8)}
    own = [all(tuple(c) in corners for c in t) for t in np.round(triangles, 8)]
    others = triangles[~np.array(own, dtype=bool)]
    if strict:
        pairs = [(p, q) for p in pts1 for q in pts2]
    else:
        pairs = [(polygon_centroid(pts1), polygon_centroid(pts2))]
    if any(is_ray_blocked(p, q, others, eps) for p, q in pairs):
        return _stated(False, "[zonal] something stands between the cells", verbose)
    return _stated(True, "[zonal] nothing stands between the cells", verbose)


def _triangles(obstacle: Any, rounding_decimal: int) -> Floats:
    if isinstance(obstacle, FaceMeshPreprocessor):
        return obstacle.triangles
    return FaceMeshPreprocessor(obstacle, rounding_decimal).triangles


def get_obstruction(
    cell1: Any,
    cell2: Any,
    obstacle: Any,
    strict: bool = False,
    verbose: bool = False,
    eps: float = 1e-6,
    rounding_decimal: int = 8,
) -> tuple[bool, str]:
    """True if the segment between the centroids of two cells is free (with ``strict`` all between their corners); and a message.

    Triangles of the obstacle that are parts of the cells do not count.
    """
    pts1, pts2 = face_to_array(cell1, rounding_decimal), face_to_array(cell2, rounding_decimal)
    return _obstruction(pts1, pts2, _triangles(obstacle, rounding_decimal), strict, verbose, eps)


def get_obstruction_from_cache(
    i: int,
    j: int,
    cache: ProcessedGeometry,
    obstacle_mesh: Any,
    strict: bool = False,
    verbose: bool = False,
    eps: float = 1e-6,
    rounding_decimal: int = 8,
) -> tuple[bool, str]:
    """As :func:`get_obstruction` for two faces of a :class:`ProcessedGeometry`."""
    triangles = _triangles(obstacle_mesh, rounding_decimal)
    return _obstruction(cache.get_face(i), cache.get_face(j), triangles, strict, verbose, eps)


def plot_viewfactor(mesh: Any, F: Floats, cell_id: int, cmap: str = "viridis", show: bool = True) -> Any:  # noqa: N803
    """A ``pyvista.Plotter`` with the mesh coloured by ``F[:, cell_id]``; it is shown unless ``show`` is false."""
    pyvista: Any = importlib.import_module("pyvista")
    mesh.cell_data["ViewFactor"] = np.asarray(F)[:, cell_id]
    plotter = pyvista.Plotter()
    plotter.add_mesh(mesh, scalars="ViewFactor", cmap=cmap)
    if show:
        plotter.show()
    return plotter
