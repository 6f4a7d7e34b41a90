"""Meshes of other packages as arrays, recognized by their attributes; no other package than numpy is imported."""

from __future__ import annotations

import os
from typing import Any, NamedTuple, cast

import numpy as np
import numpy.typing as npt

from .errors import InputError

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

# Cells of meshio that are polygons, and those that are left out: they have no area.
_POLYGON_CELLS = ("triangle", "quad", "polygon")
_CELLS_WITHOUT_AREA = ("vertex", "line", "line3")


class MeshArrays(NamedTuple):
    """A mesh in the layout of the native module.

    ``corners`` lists the vertices of all polygons. Polygon ``k`` has ``corners[starts[k]:starts[k + 1]]``, or without ``starts`` the ``k``-th
    ``corners_of_face`` of them.
    """

    vertices: Floats
    corners: Integers
    starts: Integers
    corners_of_face: int
    material_of_face: Integers
    materials: list[str]

    @property
    def face_count(self) -> int:
        """Number of polygons."""
        return len(self.starts) - 1 if len(self.starts) else len(self.corners) // self.corners_of_face

    def face(self, k: int) -> Integers:
        """The vertices of a polygon."""
        if len(self.starts):
            return self.corners[self.starts[k] : self.starts[k + 1]]
        return self.corners[k * self.corners_of_face : (k + 1) * self.corners_of_face]


def mesh_arrays(mesh: Any) -> MeshArrays:
    """The arrays of a mesh: (vertices, faces), corners of faces, pyvista, trimesh or meshio."""
    if isinstance(mesh, (tuple, list)):
        pair = cast("list[Any]", mesh)
        if len(pair) != 2:
            raise InputError(f"mesh: a tuple of {len(pair)} is no mesh; give (vertices, faces)")
        return _uniform(pair[0], pair[1])
    if isinstance(mesh, np.ndarray):
        return _of_polygons(cast("npt.NDArray[Any]", mesh))
    if hasattr(mesh, "cells_dict"):
        return _of_meshio(mesh)
    if hasattr(mesh, "points") and hasattr(mesh, "faces"):
        return _of_pyvista(mesh)
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        return _uniform(mesh.vertices, mesh.faces)
    if hasattr(mesh, "extract_surface"):
        return _of_pyvista(mesh.extract_surface())
    raise InputError(
        f"mesh: a {type(mesh).__name__} is no mesh; give (vertices, faces), an array of shape (faces, corners, 3), a path, "
        "or a mesh of pyvista, trimesh or meshio"
    )


def is_path(value: Any) -> bool:
    """True for names of files."""
    return isinstance(value, (str, os.PathLike))


def _vertices(vertices: Any) -> Floats:
    array = np.asarray(vertices)
    if array.dtype.kind not in "fiuO":
        raise InputError(f"mesh: the vertices are of the type {array.dtype}; give real numbers")
    try:
        array = np.ascontiguousarray(array, dtype=np.float64)
    except (TypeError, ValueError) as e:
        raise InputError(f"mesh: the vertices are no numbers ({e}); give an array of shape (vertices, 3)") from e
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(f"mesh: the vertices have the shape {array.shape}; give an array of shape (vertices, 3)")
    return array


def _indices(indices: Any) -> Integers:
    array = np.asarray(indices)
    if array.dtype.kind not in "iu":
        raise InputError(f"mesh: the faces are numbers of type {array.dtype}; give whole numbers")
    return np.ascontiguousarray(array, dtype=np.int64)


_NONE: Integers = np.empty(0, dtype=np.int64)


def _of_polygons(polygons: npt.NDArray[Any]) -> MeshArrays:
    """The mesh of the corners of its faces, (faces, corners, 3)."""
    if polygons.ndim != 3 or polygons.shape[1] < 3 or polygons.shape[2] != 3:
        raise InputError(f"mesh: the array has the shape {polygons.shape}; give (vertices, faces), or an array of shape (faces, corners, 3)")
    faces = np.arange(polygons.shape[0] * polygons.shape[1], dtype=np.int64).reshape(polygons.shape[:2])
    return _uniform(polygons.reshape(-1, 3), faces)


def _uniform(vertices: Any, faces: Any) -> MeshArrays:
    if isinstance(faces, (list, tuple)) and not faces:
        raise InputError("mesh: there are no faces; give at least one")
    if isinstance(faces, (list, tuple)) and len({np.size(face) for face in cast("list[Any]", faces)}) > 1:
        lists = [_indices(face).reshape(-1) for face in cast("list[Any]", faces)]
        if any(len(face) < 3 for face in lists):
            raise InputError("mesh: a face has less than three corners; give three or more")
        starts = np.concatenate([[0], np.cumsum([len(face) for face in lists])]).astype(np.int64)
        return MeshArrays(_vertices(vertices), np.concatenate(lists), starts, 0, _NONE, [])
    corners = _indices(faces)
    if corners.ndim != 2 or corners.shape[1] < 3:
        raise InputError(f"mesh: the faces have the shape {corners.shape}; give an array of shape (faces, 3) or (faces, 4), or a list of lists")
    return MeshArrays(_vertices(vertices), corners.reshape(-1), _NONE, int(corners.shape[1]), _NONE, [])


def _of_pyvista(mesh: Any) -> MeshArrays:
    padded = _indices(mesh.faces)
    if len(padded) == 0:
        return MeshArrays(_vertices(mesh.points), _NONE, _NONE, 3, _NONE, [])
    size = int(padded[0])
    if len(padded) % (size + 1) == 0:
        table = padded.reshape(-1, size + 1)
        if (table[:, 0] == size).all():
            return _uniform(mesh.points, table[:, 1:])
    # Polygons of several sizes: each is its number of corners, then its corners.
    places = [0]
    while places[-1] < len(padded):
        places.append(places[-1] + 1 + int(padded[places[-1]]))
    first = np.asarray(places[:-1])
    is_corner = np.ones(len(padded), dtype=bool)
    is_corner[first] = False
    starts = np.concatenate([[0], np.cumsum(padded[first])]).astype(np.int64)
    return MeshArrays(_vertices(mesh.points), padded[is_corner], starts, 0, _NONE, [])


def _points_of_meshio(mesh: Any) -> Floats:
    """The points of a mesh of meshio, those of a plane at z = 0."""
    points = np.asarray(mesh.points)
    if points.ndim == 2 and points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    return _vertices(points)


def _of_meshio(mesh: Any) -> MeshArrays:
    counts: list[Integers] = []
    corners: list[Integers] = []
    kept: list[int] = []
    for k, block in enumerate(mesh.cells):
        if block.type in _CELLS_WITHOUT_AREA:
            continue
        if block.type not in _POLYGON_CELLS:
            raise InputError(
                f"mesh: cells of the type {block.type} are not read; give the surface of the mesh as triangles and quads"
            )
        data = _indices(block.data)
        counts.append(np.full(len(data), data.shape[1], dtype=np.int64))
        corners.append(data.reshape(-1))
        kept.append(k)
    if not counts:
        return MeshArrays(_points_of_meshio(mesh), _NONE, _NONE, 3, _NONE, [])
    starts = np.concatenate([[0], np.cumsum(np.concatenate(counts))]).astype(np.int64)
    material_of_face, materials = _materials_of_meshio(mesh, kept)
    return MeshArrays(_points_of_meshio(mesh), np.concatenate(corners), starts, 0, material_of_face, materials)


def _materials_of_meshio(mesh: Any, blocks: list[int]) -> tuple[Integers, list[str]]:
    """Physical groups of gmsh are materials."""
    data = mesh.cell_data.get("gmsh:physical")
    if data is None:
        return _NONE, []
    tags = np.concatenate([np.asarray(data[k], dtype=np.int64) for k in blocks])
    names = {int(tag[0]): str(name) for name, tag in mesh.field_data.items() if int(tag[1]) == 2}
    used, index = np.unique(tags, return_inverse=True)
    return index.astype(np.int64), [names.get(int(tag), str(tag)) for tag in used]


def write_obj(path: str, mesh: MeshArrays) -> None:
    """Writes a mesh as OBJ; coordinates keep their bits."""
    with open(path, "w", encoding="utf-8") as out:
        for x, y, z in mesh.vertices.tolist():
            out.write(f"v {x!r} {y!r} {z!r}\n")
        material = None
        for k in range(mesh.face_count):
            if len(mesh.material_of_face) and mesh.material_of_face[k] != material:
                material = mesh.material_of_face[k]
                out.write(f"usemtl {mesh.materials[material]}\n")
            out.write("f " + " ".join(str(v + 1) for v in mesh.face(k).tolist()) + "\n")
