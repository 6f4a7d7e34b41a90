"""Scenes from arrays and meshes, and their errors."""

from __future__ import annotations

import inspect

import numpy as np
import pytest
from conftest import furnace, room, sphere

import zonal as zn


# Guards (python): every scene key is a parameter of the Python package.
def test_every_key_of_scenes_is_a_parameter():
    methods = {
        "solve.": zn.Scene.settings,
        "boundary.": zn.Scene.boundary,
        "surroundings.": zn.Scene.surroundings,
        "surface[].": zn.Scene.surface,
        "node[].": zn.Scene.node,
        "pane[].": zn.Scene.pane,
        "medium.": zn.Scene.medium,
        "medium.region[].": zn.Scene.region,
        "thermal.": zn.Scene.thermal,
        "light[] (sun).": zn.Scene.sun,
        "light[] (sky).": zn.Scene.sky,
        "light[] (cie-sky).": zn.Scene.cie_sky,
        "light[] (perez-sky).": zn.Scene.perez_sky,
        "light[] (image-sky).": zn.Scene.image_sky,
        "light[] (emitter).": zn.Scene.emitter,
        "light[] (planet).": zn.Scene.planet,
        "light[] (point).": zn.Scene.point,
        "light[] (spot).": zn.Scene.spot,
        "light[] (tube).": zn.Scene.tube,
        "light[] (luminaire).": zn.Scene.luminaire,
        "camera[].": zn.Scene.camera,
        "medium.gas.": zn.Gas,
        "surface[].mesh.": zn.Scene.surface,
    }
    # Keys that the package writes itself, or that have a method of their own.
    lights = ("sun", "sky", "cie-sky", "perez-sky", "image-sky", "emitter", "planet", "point", "spot", "tube", "luminaire")
    own = {"medium.region", "surface[].mesh.file", *(f"light[] ({k}).kind" for k in lights)}
    checked = 0
    for table, method in methods.items():
        parameters = inspect.signature(method).parameters.values()
        names = {p.name for p in parameters}
        takes_all = any(p.kind == p.VAR_KEYWORD for p in parameters)
        for key in zn.keys():
            rest = key.path.removeprefix(table)
            if key.path.startswith(table) and not any(c in rest for c in ".[") and key.path not in own:
                assert rest in names or takes_all, key.path
                checked += 1
    assert checked > 100
    # The tables of the document without a method.
    roots = {k.path for k in zn.keys() if not any(c in k.path for c in ".[ ")}
    assert roots - {t.split("[")[0].split(".")[0] for t in methods} == {"name", "mode", "bands"} | {"SPECTRUM"} & roots


# Guards (python): an argument that is no key of scene files is refused where it is given.
def test_keys_that_no_parameter_lists_are_taken_by_name():
    scene = zn.Scene()
    with pytest.raises(TypeError, match="did you mean 'reflectance'"):
        scene.surface(room=([0, 0, 0], [1, 1, 1]), reflectence=0.5)
    with pytest.raises(TypeError, match="unexpected argument 'flux'"):
        scene.camera([0, 0, 0], [1, 0, 0], flux=1)
    scene.surface(room=([0, 0, 0], [1, 1, 1]), reflectance=0.5, emission=1.0, patch_size=0.5)
    solution = scene.solve(engine="dense", max_iterations=1, residual=1e-12)
    assert "max_iterations" in solution.report["status"]
    with pytest.raises(zn.InputError, match="max_iterations: 0 is out of range"):
        scene.solve(max_iterations=0)


def test_documents_and_texts_are_inverse(tmp_path):
    scene = furnace()
    scene.save(tmp_path / "f.toml")
    again = zn.load_scene(tmp_path / "f.toml")
    assert again.document == scene.document | {"surface": again.document["surface"], "medium": again.document["medium"]}
    assert again.to_toml() == scene.to_toml()


def test_a_loaded_scene_can_be_changed(tmp_path):
    furnace().save(tmp_path / "f.toml")
    scene = zn.load_scene(tmp_path / "f.toml")
    scene.document["medium"]["heat_source"] = 0
    scene.settings(tolerance=0.5)
    cold = scene.solve(discretization_error=False)
    table = cold.table
    medium = table["name"].index("medium")
    assert abs(table["net_power"][medium]) < 1e-6
    # Saved elsewhere, it still finds its files.
    vertices, faces = sphere(4)
    scene = zn.Scene(mode="thermal")
    scene.surface((vertices, faces), name="s", emissivity=1.0, temperature=300, patch_size=10.0)
    scene.save(tmp_path / "s.toml")
    moved = zn.load_scene(tmp_path / "s.toml")
    moved.settings(tolerance=0.1)
    (tmp_path / "other").mkdir()
    moved.save(tmp_path / "other/s.toml")
    assert zn.load_scene(tmp_path / "other/s.toml").check()["patches"] == len(faces)


def test_layouts_and_types_of_arrays_give_the_same_medium():
    smoke = np.random.default_rng(3).integers(1, 9, (4, 3, 5)).astype(np.float64) / 16
    wanted = None
    big = np.zeros((8, 3, 5))
    big[::2] = smoke
    for array in (smoke, smoke.astype(np.float32), np.asfortranarray(smoke), big[::2], smoke.astype(">f8"), smoke.astype(np.float16)):
        scene = zn.Scene()
        scene.medium([0, 0, 0], [1, 1, 1], cells=[2, 3, 5], extinction=array, emission=1.0)
        found = scene.solve().array("extinction")
        wanted = found if wanted is None else wanted
        assert np.array_equal(found, wanted)


def test_xarray_has_its_box_and_the_order_of_its_axes():
    xarray = pytest.importorskip("xarray")
    values = np.random.default_rng(4).uniform(300, 400, (5, 3, 4))
    axis = lambda n: (np.arange(n) + 0.5) / n  # noqa: E731
    field = xarray.DataArray(values, dims=("z", "x", "y"), coords={"z": axis(5), "x": axis(3), "y": axis(4)})

    def solve(temperature: object) -> np.ndarray:
        scene = zn.Scene(mode="thermal")
        scene.surface(room=([0, 0, 0], [1, 1, 1]), emissivity=1.0, temperature=300, patch_size=1.0)
        scene.medium([0, 0, 0], [1, 1, 1], cells=[3, 4, 5], extinction=1.0, temperature=temperature)
        return scene.solve(discretization_error=False).temperature

    # The box follows from the coordinates, and is rounded.
    assert np.allclose(solve(field), solve(values.transpose(1, 2, 0)), rtol=1e-7)
    scene = zn.Scene()
    scene.medium([0, 0, 0], [2, 1, 1], cells=[2, 1, 1], extinction=0.5 + 0 * field, emission=1.0)
    # The array fills one of the two cells.
    assert scene.solve().array("extinction")[:, 0] == pytest.approx([0.5, 0.0], abs=1e-12)


def areas_of(mesh: object) -> np.ndarray:
    scene = zn.Scene(mode="thermal")
    scene.surface(mesh, name="m", emissivity=0.5, temperature=300, patch_size=10.0)
    return scene.exchange(direct_only=True).direct


def test_meshes_of_other_packages_are_the_same_surface():
    vertices, faces = sphere(3)
    inside = faces[:, ::-1]
    wanted = areas_of((vertices, inside))
    assert wanted.shape == (1, len(faces), len(faces))
    trimesh = pytest.importorskip("trimesh")
    assert np.array_equal(areas_of(trimesh.Trimesh(vertices, inside, process=False)), wanted)
    meshio = pytest.importorskip("meshio")
    assert np.array_equal(areas_of(meshio.Mesh(vertices, [("triangle", inside)])), wanted)
    pyvista = pytest.importorskip("pyvista")
    assert np.array_equal(areas_of(pyvista.PolyData.from_regular_faces(vertices, inside)), wanted)


def test_polygons_of_several_sizes_and_materials():
    pyvista = pytest.importorskip("pyvista")
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]], dtype=float)
    mesh = pyvista.PolyData(points, np.array([4, 0, 1, 2, 3, 3, 1, 4, 2]))
    scene = zn.Scene(mode="thermal")
    scene.surface(mesh, name="m", emissivity=1.0, temperature=np.array([300.0, 400.0]), patch_size=10)
    by_face = zn.StateSolver(scene.exchange()).solve().by_face
    assert by_face["temperature"].tolist() == [300.0, 400.0]
    meshio = pytest.importorskip("meshio")
    tagged = meshio.Mesh(
        points,
        [("quad", [[0, 1, 2, 3]]), ("triangle", [[1, 4, 2]]), ("line", [[0, 1]])],
        cell_data={"gmsh:physical": [np.array([7]), np.array([8]), np.array([9])]},
        field_data={"floor": np.array([7, 2]), "ramp": np.array([8, 2])},
    )
    scene = zn.Scene(mode="thermal")
    scene.surface(tagged, name="m", emissivity=1.0, temperature=300, materials={"ramp": {"temperature": 500}}, patch_size=10)
    table = scene.solve(discretization_error=False).table
    assert dict(zip(table["name"], table["temperature"], strict=True)) == pytest.approx({"m/floor": 300, "m/ramp": 500})


@pytest.mark.parametrize(
    ("change", "error", "key"),
    [
        (lambda s: s.document.update(solver={}), "solver: unknown key; did you mean 'solve'?", "solver"),
        (lambda s: s.settings(tolerance=2), "2 is out of range; give a number above 0 and below 1", "solve.tolerance"),
        (lambda s: s.surface((np.zeros((3, 3)), [[0, 1, 5]])), "vertex index 5 is out of range", None),
        (lambda s: s.surface((np.zeros((3, 3)), [[0.5, 1, 2]])), "give whole numbers", None),
        (lambda s: s.surface(object()), "is no mesh; give", None),
        (lambda s: s.medium([0, 0, 0], [1, 1, 1], extinction=np.full((2, 2, 2), -1.0)), "-1 is no density", None),
        (lambda s: s.medium([0, 0, 0], [1, 1, 1], extinction=np.full((2, 2, 2), np.nan)), "NaN is no density", None),
        (lambda s: s.document.update(name=object()), "a object has no place in a scene", None),
        (lambda s: s.document.update(name='a"\\ é'), None, None),
    ],
)
def test_errors_name_key_and_remedy(change, error, key):
    scene = room()
    if error is None:
        change(scene)
        assert scene.solve().name == scene.document["name"]
        return
    with pytest.raises(zn.InputError) as caught:
        change(scene)
        scene.solve()
    assert error in str(caught.value), str(caught.value)
    assert caught.value.remedy
    if key is not None:
        assert caught.value.key == key


def test_errors_of_files_have_line_and_column(tmp_path):
    bad = tmp_path / "bad.toml"
    bad.write_text("[[surface]]\nboxx = 1")
    with pytest.raises(zn.InputError) as caught:
        zn.load_scene(bad).check()
    assert (caught.value.file, caught.value.place, caught.value.key) == (str(bad), "2:1", "surface #1.boxx")
    bad.write_text("[[surface")
    with pytest.raises(zn.InputError, match="this is not TOML"):
        zn.load_scene(bad)
    with pytest.raises(zn.InputError, match="there is no such file"):
        zn.load_scene(tmp_path / "none.toml")
    with pytest.raises(zn.FileError) as missing:
        zn.load_solution(tmp_path / "none.npz")
    assert missing.value.file == str(tmp_path / "none.npz")
    assert isinstance(missing.value, OSError) and isinstance(missing.value, zn.Error)


def test_errors_can_be_pickled():
    import pickle

    error = zn.InputError("a.toml:1:2: k: wrong; mend it", "a.toml", "1:2", "k")
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.file, again.place, again.key, again.remedy) == (str(error), "a.toml", "1:2", "k", "mend it")
    again = pickle.loads(pickle.dumps(zn.FileError("a: wrong", "a")))
    assert (str(again), again.file) == ("a: wrong", "a")


def test_arguments_are_checked():
    scene = room()
    for arguments, message in [
        ({"threads": 0}, "threads: 0 is out of range"),
        ({"engine": "fast"}, "known here: auto, dense"),
        ({"max_memory": 0}, "give a positive number of gigabytes"),
        ({"tolerance": 3.0}, "tolerance"),
        ({"factors": "other"}, "give one of exact"),
    ]:
        with pytest.raises(zn.InputError, match=message):
            scene.solve(**arguments)
    scene.settings(engine="dense")
    with pytest.raises(zn.MemoryLimitError):
        scene.solve(max_memory=1e-6)


def test_messages_about_arrays_name_argument_and_shape(tmp_path):
    corners, faces = sphere(3)

    def mesh(**values: object) -> zn.Scene:
        scene = zn.Scene(mode="thermal")
        scene.surface((corners, faces[:, ::-1]), name="m", patch_size=10.0, **{"emissivity": 0.5, "temperature": 300.0, **values})
        return scene

    def medium(extinction: np.ndarray) -> zn.Scene:
        scene = zn.Scene()
        scene.medium([0, 0, 0], [1, 1, 1], cells=[2, 2, 2], extinction=extinction)
        return scene

    count = len(faces)
    wrong = np.full(count, 300.0)
    wrong[7] = -1.0
    cases = [
        (mesh(temperature=np.full(count + 1, 300.0)), ["surface 'm'.temperature", f"({count + 1},)", f"({count},)"]),
        (mesh(temperature=wrong), ["surface 'm'.temperature", f"({count},)", "[7]", "-1"]),
        (mesh(emissivity=np.full(count, 2.0)), ["surface 'm'.emissivity", f"({count},)", "[0]"]),
        (mesh(temperature=np.full(count, "hot")), ["temperature", f"({count},)", "<U3"]),
        (mesh(temperature=np.full(count, 1j)), ["temperature", f"({count},)", "complex128"]),
        (mesh(temperature=np.full((2, 2, 2, 2), 1.0)), ["temperature", "(2, 2, 2, 2)"]),
        (medium(np.full((2, 2, 2), -1.0)), ["medium.extinction", "(2, 2, 2)", "[0, 0, 0]", "-1"]),
        (medium(np.full((2, 2), 1.0)[None, None]), ["medium.extinction", "(1, 1, 2, 2)"]),
    ]
    mesh().save(tmp_path / "saved.toml")
    loaded = zn.load_scene(tmp_path / "saved.toml")
    loaded.document["surface"][0]["temperature"] = np.full(count + 1, 300.0)
    cases.append((loaded, ["surface 'm'.temperature", f"({count + 1},)", f"({count},)"]))
    for scene, words in cases:
        with pytest.raises(zn.InputError) as caught:
            scene.check()
        text = str(caught.value)
        assert all(word in text for word in words), text
        # No file and no row exists.
        assert not any(word in text for word in ("file", " row", "number 1")), text
        assert caught.value.remedy, text
