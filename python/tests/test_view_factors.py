"""View factors: sums, reciprocity, closed forms, threads, files, errors."""

# Guards (python): view factors in Python sum to one, are reciprocal, do not depend on threads and agree with closed forms and with pyviewfactor.

from __future__ import annotations

import inspect
import os
import pickle
import signal
import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT, sphere

import zonal as zn
import zonal.pyviewfactor as pvf

BOX_FACES = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
"""Faces of a solid box, outwards."""


def box(low, high) -> tuple[np.ndarray, np.ndarray]:
    """A solid box."""
    corners = [[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)]
    return np.array(corners, dtype=float), BOX_FACES


def room(low, high) -> tuple[np.ndarray, np.ndarray]:
    """A box whose faces look inside."""
    vertices, faces = box(low, high)
    return vertices, faces[:, ::-1]


def joined(*meshes) -> tuple[np.ndarray, np.ndarray]:
    """Several meshes as one."""
    offsets = np.cumsum([0, *[len(m[0]) for m in meshes]])
    faces = [np.asarray(f) + o for (_, f), o in zip(meshes, offsets)]
    return np.concatenate([m[0] for m in meshes]), np.concatenate(faces)


def city(n: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Boxes of several heights on a plane in squares, without bottoms."""
    parts = []
    for i in range(n):
        for j in range(n):
            v, f = box([10 * i + 3, 10 * j + 3, 0], [10 * i + 7, 10 * j + 7, 4 + (3 * i + 5 * j) % 7])
            parts.append((v, f[1:]))
            cuts = [0, 3, 7, 10]
            for a in range(3):
                for b in range(3):
                    if (a, b) != (1, 1):
                        x, y = 10 * i + np.array(cuts[a : a + 2]), 10 * j + np.array(cuts[b : b + 2])
                        v = np.array([[x[0], y[0], 0], [x[1], y[0], 0], [x[1], y[1], 0], [x[0], y[1], 0]], dtype=float)
                        parts.append((v, np.array([[0, 1, 2, 3]])))
    return joined(*parts)


def checked(f: zn.ViewFactors) -> np.ndarray:
    """The matrix, after its sums, bounds and reciprocity hold."""
    dense = f.matrix.toarray()
    assert np.allclose(f.row_sums, 1.0, atol=1e-9, rtol=0), f.row_sums
    assert dense.min() >= 0 and dense.max() <= 1
    exchange = f.exchange_areas.toarray()
    assert np.array_equal(exchange, exchange.T)
    assert np.abs(dense * f.areas[:, None] - exchange).max() <= 1e-12 * f.areas.max()
    assert len(f.open_rows) == 0
    return dense


def test_a_cube_has_its_closed_form():
    f = zn.view_factors(room([0, 0, 0], [1, 1, 1]), surroundings=False, tolerance=1e-6)
    dense = checked(f)
    opposite = 0.19982489569838746
    for i in range(6):
        wanted = np.full(6, (1 - opposite) / 4)
        wanted[i], wanted[i ^ 1] = 0.0, opposite
        assert (np.abs(dense[i] - wanted) <= f.radius.toarray()[i] + 1e-15).all(), (dense[i], wanted)
    assert f.radius.toarray().max() < 1e-6


def test_a_sphere_in_a_box():
    vertices, faces = sphere(6)
    triangles = np.concatenate([BOX_FACES[:, [0, 2, 1]], BOX_FACES[:, [0, 3, 2]]])
    mesh = joined((vertices, faces), (room([-2, -2, -2], [2, 2, 2])[0], triangles))
    f = zn.view_factors(mesh, surroundings=False)
    dense = checked(f)
    on_sphere = np.arange(len(f)) < len(faces)
    # A convex body sees the box alone, and the box sees it by its area.
    assert dense[np.ix_(on_sphere, on_sphere)].max() == 0
    groups = f.combined(np.where(on_sphere, 0, 1))
    assert abs(groups.matrix.toarray()[1, 0] - f.areas[on_sphere].sum() / 96) < 1e-6
    assert abs(groups.matrix.toarray()[0, 1] - 1) < 1e-9
    assert np.abs(f.defect).max() < 1e-2


def test_a_city_and_its_sky():
    f = zn.view_factors(city())
    checked(f)
    assert f.sky.max() <= 1 and f.sky.min() >= 0 and f.sky_radius.max() < 5e-3
    # The highest roof sees nothing else.
    roof = int(np.argmax(f.sky))
    assert abs(f.sky[roof] - 1) < 1e-3
    table = f.table
    assert len(table["name"]) == len(f) == len(table["sky"]) and (table["faces_seen"] > 0).any()
    assert "row sums" in f._repr_html_() and str(len(f)) in repr(f)


@pytest.mark.parametrize("period", [{"period_x": 10.0}, {"period_x": 10.0, "period_y": 10.0}])
def test_a_repeated_city_sees_more_of_itself(period):
    alone, repeated = zn.view_factors(city(1), tolerance=1e-2), zn.view_factors(city(1), tolerance=1e-2, **period)
    checked(repeated)
    assert repeated.ground.sum() < alone.ground.sum() and repeated.sky.sum() < alone.sky.sum()


def test_an_obstacle_hides_the_middle():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    plates = joined((square, [[0, 1, 2, 3]]), (square + [0, 0, 1], [[3, 2, 1, 0]]))
    screen = (square * 3 - [1, 1, -0.5], [[0, 1, 2, 3]])
    free = zn.view_factors(plates)
    with pytest.warns(RuntimeWarning, match="obstacles"):
        hidden = zn.view_factors(plates, obstacles=screen)
    narrow = zn.view_factors(plates, closing=False, obstacles=[(square * 0.5 + [0.25, 0.25, 0.5], [[0, 1, 2, 3]])])
    assert hidden.matrix.toarray().max() == 0
    assert 0 < narrow.matrix.toarray()[0, 1] < free.matrix.toarray()[0, 1]
    # What arrives at an obstacle is missing in a row: the row is not complete.
    assert (narrow.defect < -0.05).all() and list(narrow.open_rows) == [0, 1]


def test_backs_have_rows_after_the_fronts():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    # A lid over a floor that looks away from it: its back sees the floor.
    plates = joined((square, [[0, 1, 2, 3]]), (square + [0, 0, 1], [[0, 1, 2, 3]]))
    front = zn.view_factors(plates, closing=False)
    both = zn.view_factors(plates, sides="both", tolerance=1e-6)
    assert len(front) == 2 and len(both) == 4 and front.matrix.toarray().max() == 0
    expected = np.zeros((4, 4))
    expected[0, 3] = expected[3, 0] = 0.199825
    assert np.allclose(both.matrix.toarray(), expected, atol=2e-6)
    assert np.allclose(both.row_sums, 1) and np.array_equal(both.areas, [1, 1, 1, 1])


def test_bits_do_not_depend_on_threads_and_survive_files(tmp_path):
    f = zn.view_factors(city(2), threads=1)
    same = zn.view_factors(city(2), threads=2)
    f.save(tmp_path / "F.npz")
    for other in (same, pickle.loads(pickle.dumps(f)), zn.ViewFactors.load(tmp_path / "F.npz")):
        for name in ("matrix", "radius", "exchange_areas"):
            a, b = getattr(f, name), getattr(other, name)
            assert np.array_equal(a.data, b.data) and np.array_equal(a.indices, b.indices)
        for name in ("areas", "sky", "sky_radius", "ground", "ground_radius", "defect", "open_rows"):
            assert np.array_equal(getattr(f, name), getattr(other, name)), name
        assert other.grade == f.grade and other.names == f.names
    with np.load(tmp_path / "F.npz") as file:
        assert (file["radii"].astype(float) >= f.radius.data).all()


def test_scipy_reads_the_file(tmp_path):
    sparse = pytest.importorskip("scipy.sparse")
    f = zn.view_factors(city(2))
    f.save(tmp_path / "F.npz")
    read = sparse.load_npz(tmp_path / "F.npz")
    assert read.format == "csr" and np.array_equal(read.toarray(), f.matrix.toarray())


def test_matrices_without_scipy(monkeypatch):
    f = zn.view_factors(city(2))
    wanted = f.matrix.toarray()
    monkeypatch.setitem(sys.modules, "scipy.sparse", None)
    own = zn.view_factors(city(2)).matrix
    assert isinstance(own, zn.CompressedRows) and np.array_equal(own.toarray(), wanted)
    x = np.arange(float(len(f)))
    assert np.allclose(own @ x, wanted @ x) and np.allclose(own.sum(axis=0), wanted.sum(axis=0))
    assert own[0, -1] == wanted[0, -1] and all(own[i, i] == 0 for i in range(len(f))) and np.array_equal(np.asarray(own), wanted)
    with pytest.raises(IndexError):
        own[len(f), 0]
    assert own.nnz == len(own.indices) and "entries" in repr(own)


def test_a_cache_resumes_with_the_same_bits(tmp_path):
    first = zn.view_factors(city(2), cache=tmp_path / "cache")
    stages = sorted((tmp_path / "cache").rglob("*.stage"))
    assert stages
    stages[0].unlink()
    again = zn.view_factors(city(2), cache=tmp_path / "cache")
    assert np.array_equal(again.matrix.data, first.matrix.data) and np.array_equal(again.sky, first.sky)
    # Another tolerance is another computation.
    zn.view_factors(city(2), cache=tmp_path / "cache", tolerance=1e-2)
    assert len(list((tmp_path / "cache").iterdir())) == 2


def test_script_f_and_groups():
    f = zn.view_factors(room([0, 0, 0], [1, 1, 1]), surroundings=False)
    emissivity = np.array([0.1, 0.3, 0.5, 0.7, 0.9, 0.6])
    values, radii = f.script_f(emissivity)
    assert np.allclose(values.sum(axis=1), emissivity, atol=1e-9) and (radii >= 0).all()
    assert np.allclose(f.script_f(0.5)[0].sum(axis=1), 0.5, atol=1e-9)
    named = f.combined({"walls": [2, 3, 4, 5], "ends": [0, 1]})
    assert named.names == ["walls", "ends"] and np.allclose(named.areas, [4, 2])
    assert np.allclose(named.matrix.toarray(), f.combined([1, 1, 0, 0, 0, 0]).matrix.toarray())
    with pytest.raises(zn.InputError, match="6 emissivities"):
        f.script_f([0.5])
    for groups, match in (({"a": [0, 1]}, "no group"), ({"a": [0, 1, 2], "b": [2, 3, 4, 5]}, "two groups"), ({"a": [9]}, "out of range"), (["a"], "1 values"), ([0, 0, 0, 0, 0, -1], "below 0")):
        with pytest.raises(zn.InputError, match=match):
            f.combined(groups)


def test_meshes_of_other_packages_and_paths(tmp_path):
    vertices, faces = room([0, 0, 0], [1, 2, 3])
    wanted = zn.view_factors((vertices, faces), surroundings=False).matrix.toarray()
    assert np.array_equal(zn.view_factors(vertices[faces], surroundings=False).matrix.toarray(), wanted)
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    for k, face in enumerate(faces):
        lines += [f"usemtl wall{k % 2}", "f " + " ".join(str(v + 1) for v in face)]
    (tmp_path / "room.obj").write_text("\n".join(lines))
    f = zn.view_factors(tmp_path / "room.obj", surroundings=False)
    assert np.array_equal(f.matrix.toarray(), wanted)
    assert f.materials == ["wall0", "wall1"] * 3 and f.combined(f.materials).names == ["wall0", "wall1"]
    pyvista = pytest.importorskip("pyvista")
    padded = np.column_stack([np.full(6, 4), faces]).reshape(-1)
    assert np.array_equal(zn.view_factors(pyvista.PolyData(vertices, padded), surroundings=False).matrix.toarray(), wanted)
    meshio = pytest.importorskip("meshio")
    assert np.array_equal(zn.view_factors(meshio.Mesh(vertices, [("quad", faces)]), surroundings=False).matrix.toarray(), wanted)


def test_polygons_of_many_corners():
    # An L-shaped room: its floor and its ceiling are not convex.
    shape = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], dtype=float)
    bottom, top = (np.column_stack([shape, np.full(6, z)]) for z in (0.0, 1.0))

    walls = [[k, k + 6, (k + 1) % 6 + 6, (k + 1) % 6] for k in range(6)]
    f = zn.view_factors((np.concatenate([bottom, top]), [[0, 1, 2, 3, 4, 5], [11, 10, 9, 8, 7, 6], *walls]), surroundings=False)
    checked(f)
    assert np.allclose(f.areas[:2], 3) and np.abs(f.defect).max() < 1e-3


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        ({"tolerance": 0}, "tolerance"),
        ({"tolerance": float("nan")}, "tolerance"),
        ({"up": "w"}, "up: 'w'"),
        ({"period_x": -1.0}, "periods"),
        ({"period_y": 1.0, "up": "y"}, "period_y"),
        ({"max_memory": -1.0}, "max_memory"),
        ({"threads": 0}, "threads"),
        ({"threads": -1}, "threads"),
        ({"tolerance": "small"}, "tolerance: 'small'"),
        ({"tolerance": None}, "tolerance: None"),
        ({"obstacles": 3}, "mesh"),
        ({"sides": "back"}, "sides: 'back'"),
    ],
)
def test_errors(arguments, match):
    with pytest.raises(zn.InputError, match=match):
        zn.view_factors(room([0, 0, 0], [1, 1, 1]), **arguments)


def test_errors_of_meshes_and_files(tmp_path):
    vertices, faces = room([0, 0, 0], [1, 1, 1])
    for mesh, match in (((vertices, faces + 5), "vert"), ((vertices * np.nan, faces), "finite"), ((vertices, faces[:0]), "no faces"), ((vertices, []), "no faces"), ((vertices[:, :2], faces), "shape"), ((vertices.astype(complex), faces), "complex128"), ((vertices.astype(str), faces), "real numbers"), ((vertices, faces + 0.5), "whole numbers"), (vertices, "shape"), ((vertices, [[0, 1, 2], [0, 1]]), "three corners"), (tmp_path / "no.obj", "no.obj"), ("no.xyz", "kind of mesh")):
        with pytest.raises(zn.InputError, match=match):
            zn.view_factors(mesh)
    with pytest.raises(MemoryError):
        zn.view_factors(city(), max_memory=1e-8)
    (tmp_path / "F.npz").write_bytes(b"nothing")
    np.savez(tmp_path / "G.npz", format=b"csr", data=[1.0])
    for name in ("F.npz", "G.npz", "none.npz"):
        with pytest.raises(zn.FileError):
            zn.ViewFactors.load(tmp_path / name)


def test_faces_that_look_at_backs_are_warned_of():
    with pytest.warns(RuntimeWarning, match="not closed"):
        f = zn.view_factors(joined(room([0, 0, 0], [3, 3, 3]), room([1, 1, 1], [2, 2, 2])), surroundings=False)
    assert len(f.open_rows) > 0
    (told,) = f.warnings
    assert (told.code, told.severity, told.part) == ("open-rows", "warning", None)
    assert 'sides="both"' in told.text and f"{f.open_rows[0]}" in told.text


def test_radii_above_the_tolerance_are_warned_of():
    # A tilted triangle hides a part of another one.
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.1, 0, 1], [0.2, 1.1, 1.1], [1.1, 0.1, 1.3], [0.2, 0.2, 0.4], [0.6, 0.3, 0.5], [0.3, 0.6, 0.6]]
    mesh = (np.array(corners), np.arange(9).reshape(3, 3))
    with pytest.warns(RuntimeWarning, match="above the tolerance 1e-10"):
        f = zn.view_factors(mesh, sides="both", tolerance=1e-10)
    (told,) = f.warnings
    assert (told.code, told.severity) == ("wide-radii", "warning")
    assert f.radius.toarray().max() > 1e-10
    # Nothing is told where the tolerance is met.
    assert zn.view_factors(city(1)).warnings == []


def test_files_keep_the_diagnostics(tmp_path):
    with pytest.warns(RuntimeWarning):
        f = zn.view_factors(joined(room([0, 0, 0], [3, 3, 3]), room([1, 1, 1], [2, 2, 2])), surroundings=False)
    f.save(tmp_path / "F.npz")
    again = zn.ViewFactors.load(tmp_path / "F.npz")
    assert again.warnings == f.warnings
    assert again.notes == f.notes


INTERRUPTED = """
import sys, threading, time, os, signal
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.path.insert(0, {tests!r})
from test_view_factors import city
import zonal as zn
def interrupt():
    time.sleep(1.5)
    global sent
    sent = time.perf_counter()
    os.kill(os.getpid(), signal.SIGINT)
mesh = city(16)
threading.Thread(target=interrupt, daemon=True).start()
try:
    zn.view_factors(mesh, tolerance=1e-7, period_x=160.0, period_y=160.0)
    print("finished")
except KeyboardInterrupt:
    print("interrupted", time.perf_counter() - sent < 60)
"""


# Guards (python): Ctrl-C ends a call of the Python package at once.
@pytest.mark.skipif(not hasattr(signal, "SIGINT") or os.name == "nt", reason="the system has no such signals")
def test_ctrl_c_ends_a_computation():
    code = INTERRUPTED.format(tests=str(ROOT / "python/tests"))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=100)
    assert done.stdout.split() == ["interrupted", "True"], done


# The names of pyviewfactor.


def faces_of(mesh) -> np.ndarray:
    return mesh[0][mesh[1]]


def test_aliases_have_the_closed_forms():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    opposite = (square + [0, 0, 1])[::-1]
    upright = square[:, [2, 0, 1]]
    assert pvf.compute_viewfactor(square, opposite) == pytest.approx(0.1998249, abs=1e-6)
    assert pvf.compute_viewfactor(square, upright) == pytest.approx(0.2000438, abs=1e-6)
    half = square * [0.5, 1, 1]
    # From the second to the first: A2 F21 = A1 F12.
    assert pvf.compute_viewfactor(half, opposite) == pytest.approx(0.5 * pvf.compute_viewfactor(opposite, half), rel=1e-5)
    assert pvf.compute_viewfactor_sa30(square, opposite, 4 * np.pi) == pytest.approx(0.1998249, abs=1e-6)
    assert pvf.polygon_area(half) == 0.5 and np.allclose(pvf.polygon_centroid(half), [0.25, 0.5, 0])
    assert np.allclose(pvf.face_normal_numpy(opposite), [0, 0, -1])
    assert pvf.get_visibility(square, opposite)[0] and not pvf.get_visibility(square, opposite[::-1])[0]
    # Boxes that touch meet.
    triangle = square[:3]
    assert pvf.tri_overlaps_aabb(triangle, np.array([1.0, 1.0, 0.0]), np.array([2.0, 2.0, 0.0]))
    assert not pvf.tri_overlaps_aabb(triangle, np.array([0.0, 0.0, 0.1]), np.array([1.0, 1.0, 1.0]))
    halves = pvf.FaceMeshPreprocessor((square, [[0, 1, 2, 3]]))
    assert halves.faces.tolist() == [[0, 1, 2], [0, 2, 3]] and len(halves.aabb_filter([0.9, 0.0, 0.0], [2.0, 0.05, 0.0])) == 2
    assert np.array_equal(halves.exclude_exact_match(square[[2, 1, 0]], opposite, halves.triangles), halves.triangles[1:])
    assert halves.build_exclusion_masks(pvf.ProcessedGeometry((square, [[0, 2, 3]]))).tolist() == [[False, True]]
    screen = (square + [0, 0, 0.5], [[0, 1, 2, 3]])
    assert not pvf.get_obstruction(square, opposite, screen)[0]
    assert pvf.get_obstruction(square, opposite, (square + [0, 0, 2], [[0, 1, 2, 3]]))[0]
    assert pvf.is_ray_blocked(np.array([0.4, 0.3, 0.0]), np.array([0.4, 0.3, 1.0]), pvf.FaceMeshPreprocessor(screen).triangles)
    with pytest.raises(zn.InputError):
        pvf.compute_viewfactor(square[:2], opposite)


def test_the_matrix_of_the_alias_is_transposed():
    mesh = room([0, 0, 0], [1, 2, 3])
    matrix = pvf.compute_viewfactor_matrix(mesh)
    assert np.allclose(matrix.sum(axis=0), 1, atol=1e-4)
    wanted = zn.view_factors(mesh, surroundings=False).matrix.toarray().T
    assert np.allclose(matrix, wanted, atol=1e-4)
    assert np.allclose(pvf.compute_viewfactor_matrix(mesh, skip_obstruction=True), wanted, atol=1e-4)
    cache = pvf.ProcessedGeometry(mesh)
    assert pvf.get_visibility_from_cache(0, 1, cache)[0] and np.allclose(cache.areas, [2, 2, 3, 3, 6, 6])
    assert pvf.get_obstruction_from_cache(0, 1, cache, mesh)[0]
    # A wall to the floor: from the second index to the first.
    assert matrix[0, 2] == pytest.approx(pvf.compute_viewfactor(faces_of(mesh)[0], faces_of(mesh)[2]), abs=1e-4)


def test_aliases_agree_with_pyviewfactor():
    original = pytest.importorskip("pyviewfactor")
    pyvista = pytest.importorskip("pyvista")
    first = pyvista.Rectangle([[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    second = pyvista.Rectangle([[0.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]])
    assert pvf.compute_viewfactor(second, first) == pytest.approx(original.compute_viewfactor(second, first), abs=1e-6)
    globe = pyvista.Sphere(radius=10, theta_resolution=5, phi_resolution=5).triangulate()
    globe.flip_faces(inplace=True)
    assert np.allclose(pvf.compute_viewfactor_matrix(globe), original.compute_viewfactor_matrix(globe), atol=2e-4)
    for i in range(0, globe.n_cells, 3):
        a, b = globe.extract_cells(i), globe.extract_cells((i + 4) % globe.n_cells)
        a, b, a2, b2 = pvf.fc_unstruc2poly(a), pvf.fc_unstruc2poly(b), original.fc_unstruc2poly(a), original.fc_unstruc2poly(b)
        assert np.array_equal(pvf.face_to_array(a), original.face_to_array(a2))
        assert pvf.get_visibility(a, b)[0] == original.get_visibility(a2, b2)[0]
        assert pvf.get_obstruction(a, b, globe)[0] == original.get_obstruction(a2, b2, globe)[0]
    # Every public name, with the parameters of the original in front.
    public = {name for name in vars(original) if not name.startswith(("_", "pvf_"))}
    assert public == set(pvf.__all__)
    for name in public:
        theirs, ours = (inspect.signature(getattr(getattr(m, name), "py_func", getattr(m, name))) for m in (original, pvf))
        assert list(ours.parameters)[: len(theirs.parameters)] == list(theirs.parameters), name
        defaults = [p.default for p in ours.parameters.values()][: len(theirs.parameters)]
        assert defaults == [p.default for p in theirs.parameters.values()], name
    plane = pyvista.Plane(i_resolution=2, j_resolution=2).triangulate()
    a, b = pvf.FaceMeshPreprocessor(plane), original.FaceMeshPreprocessor(plane)
    assert np.array_equal(a.faces, b.faces) and np.array_equal(a.tri_mins, b.tri_mins)
    assert np.array_equal(a.aabb_filter([0.1, 0.1, -1], [1, 1, 1]), b.aabb_filter([0.1, 0.1, -1], [1, 1, 1]))
    assert np.array_equal(a.exclude_exact_match(a.triangles[0], a.triangles[2], a.triangles), b.exclude_exact_match(b.triangles[0], b.triangles[2], b.triangles))
    assert np.array_equal(a.build_exclusion_masks(pvf.ProcessedGeometry(plane)), b.build_exclusion_masks(original.ProcessedGeometry(plane)))
    for low in (-1.0, 0.5, 0.75):
        case = (a.triangles[0], np.full(3, low), np.full(3, low + 0.5))
        assert pvf.tri_overlaps_aabb(*case) == original.tri_overlaps_aabb(*case)
