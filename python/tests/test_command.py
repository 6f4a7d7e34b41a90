"""The package against the program: the same bits, the same command line."""

# Guards (python): scenes, solutions, exchange areas, pictures and exports of the Python package have the bits of the command, for all engines.

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT, furnace, room, sphere

import zonal as zn


def spectral() -> zn.Scene:
    scene = furnace()
    scene.settings(engine="spectral", patch_rule="voxels")
    return scene


def layered() -> zn.Scene:
    scene = zn.Scene("slab", mode="thermal")
    ends = {"z0": {"temperature": 500}, "z1": {"temperature": 300}}
    scene.surface(room=([0, 0, 0], [1, 1, 1]), name="end", omit=["x0", "x1", "y0", "y1"], emissivity=0.8, temperature=0.1, faces=ends)
    profile = np.linspace(0.2, 3.0, 8).reshape(1, 1, 8)
    scene.medium([0, 0, 0], [1, 1, 1], cells=[1, 1, 8], extinction=profile, heat_source=0)
    scene.boundary(x="periodic", y="periodic")
    scene.settings(patch_rule="voxels")
    return scene


def rays() -> zn.Scene:
    scene = room(0.7)
    scene.settings(engine="rays", tolerance=0.05)
    return scene


def mesh_with_face_values() -> zn.Scene:
    vertices, faces = sphere(6)
    scene = zn.Scene("sphere", mode="thermal")
    kelvin = 300 + 100 * vertices[faces].mean(axis=1)[:, 2]
    scene.surface((vertices, faces[:, ::-1]), name="shell", emissivity=0.8, temperature=kelvin, patch_size=1.0)
    scene.settings(discretization_error=False)
    return scene


def smoke_array() -> zn.Scene:
    scene = room()
    smoke = np.random.default_rng(2).uniform(0, 0.4, (8, 6, 5)).astype(np.float32)
    scene.medium([0, 0, 0], [4, 3, 2.5], cells=[4, 3, 3], extinction=smoke, albedo=0.9)
    return scene


def sunlit() -> zn.Scene:
    scene = zn.Scene("court")
    scene.surface(rectangle=([0, 0, 0], [2, 0, 0], [0, 2, 0]), name="ground", reflectance=[0.2, 0.4, 0.3], patch_size=0.5)
    scene.surface(box=([0.5, 0.5, 0], [1, 1, 1]), name="house", reflectance=0.6, patch_size=0.5)
    scene.sun([1, 0.5, -1], 900.0, name="sun")
    scene.sky(20.0, name="sky")
    return scene


def gas() -> zn.Scene:
    scene = zn.Scene("gas", mode="thermal")
    scene.surface(room=([0, 0, 0], [1, 1, 1]), name="wall", emissivity=0.8, temperature=600, patch_size=0.5)
    h2o = np.full((2, 2, 2), 0.2)
    h2o[0] = 0.1
    scene.medium([0, 0, 0], [1, 1, 1], cells=[2, 2, 2], gas=zn.Gas("wsgg-bordbar-2020", h2o=h2o, co2=0.1), temperature=1500)
    scene.settings(discretization_error=False)
    return scene


def paned() -> zn.Scene:
    scene = room(3.0)
    scene.settings(tolerance=0.2, patch_size=1.0)
    scene.pane([[2, 0.2, 0.2], [2, 2.8, 0.2], [2, 2.8, 2.2], [2, 0.2, 2.2]], thickness=0.01, extinction=[20, 5, 1], name="glass")
    return scene


SCENES = {
    "room": room,
    "furnace": furnace,
    "spectral": spectral,
    "layered": layered,
    "rays": rays,
    "mesh": mesh_with_face_values,
    "smoke": smoke_array,
    "sunlit": sunlit,
    "gas": gas,
    "pane": paned,
}


def test_scenes_use_all_engines():
    engines = {make().solve().report["engine"] for make in (room, spectral, layered, rays)}
    assert engines == {"dense", "spectral", "layered", "rays"}


@pytest.mark.parametrize("name", SCENES)
def test_solutions_have_the_bits_of_the_command(name, run, tmp_path):
    scene = SCENES[name]()
    scene.save(tmp_path / "scene.toml")
    run("solve", tmp_path / "scene.toml", "-o", tmp_path / "command.npz", "--quiet")
    scene.solve(threads=2).save(tmp_path / "memory.npz")
    zn.load_scene(tmp_path / "scene.toml").solve(threads=1).save(tmp_path / "file.npz")
    expected = (tmp_path / "command.npz").read_bytes()
    assert (tmp_path / "file.npz").read_bytes() == expected
    # A scene in memory has the same numbers; only names of files may differ.
    command, memory = (np.load(tmp_path / f) for f in ("command.npz", "memory.npz"))
    assert command.files == memory.files
    for array in command.files:
        if array != "header.json":
            assert command[array].tobytes() == memory[array].tobytes(), array


def test_arrays_of_a_solution_are_those_of_its_file(tmp_path):
    solution = gas().solve()
    solution.save(tmp_path / "a.npz")
    file = np.load(tmp_path / "a.npz")
    for name in ("radiosity", "incident", "error", "temperature", "net"):
        assert np.array_equal(solution.array(name), file[name], equal_nan=True), name
    assert solution.radiosity.shape == (solution.zone_count, len(solution.bands))


def test_exchange_areas_and_updates_have_the_bits_of_the_command(run, tmp_path):
    scene = furnace()
    scene.save(tmp_path / "f.toml")
    run("exchange", tmp_path / "f.toml", "-o", tmp_path / "c.npz", "--quiet")
    areas = scene.exchange()
    assert areas.save(tmp_path / "p.npz") == [str(tmp_path / "p.npz")]
    assert (tmp_path / "c.npz").read_bytes() == (tmp_path / "p.npz").read_bytes()
    (tmp_path / "t.csv").write_text("name,temperature\nwall.z0,1000\n")
    run("update", tmp_path / "c.npz", "--temperatures", tmp_path / "t.csv", "-o", tmp_path / "q.csv")
    rows = [line.split(",") for line in (tmp_path / "q.csv").read_text().splitlines()]
    column = rows[0].index("net_power_W")
    for source in (areas, tmp_path / "c.npz"):
        state = zn.update(source, temperatures={"wall.z0": 1000.0})
        assert [float(r[column]) for r in rows[1:]] == state.by_name["net_power"].tolist()


def test_pictures_have_the_bits_of_the_command(run, tmp_path):
    solution = room().solve()
    solution.save(tmp_path / "r.npz")
    run("render", tmp_path / "r.npz", "--size", "40x30", "-o", tmp_path / "p.png", "--quiet")
    picture = solution.render("corner", (40, 30))
    assert picture.shape == (30, 40, 3) and picture.dtype == np.float32
    assert zn.encode_png(picture) == (tmp_path / "p.png").read_bytes()


def test_exports_have_the_bits_of_the_command(run, tmp_path):
    solution = room().solve()
    solution.save(tmp_path / "r.npz")
    for extension in ("csv", "vtu", "vti", "html"):
        run("export", tmp_path / "r.npz", "-o", tmp_path / f"c.{extension}", "--quiet")
        solution.export(tmp_path / f"p.{extension}")
        assert (tmp_path / f"c.{extension}").read_bytes() == (tmp_path / f"p.{extension}").read_bytes()
    run("export", tmp_path / "r.npz", "-o", tmp_path / "c.json", "--irradiance-volume", "--grid", "2,2,3", "--rays", "32", "--quiet")
    solution.export(tmp_path / "p.json", irradiance_volume=True, grid=(2, 2, 3), rays=32)
    assert (tmp_path / "c.bin").read_bytes() == (tmp_path / "p.bin").read_bytes()
    solution.export(tmp_path / "p.vtu", points=True)
    files = solution.export(tmp_path / "p.glb", lightmap=True, texel=0.2)
    assert files == [str(tmp_path / "p.glb"), str(tmp_path / "p.lightmap.exr")]


def test_the_module_is_the_command(tmp_path):
    def run(*arguments: object) -> subprocess.CompletedProcess[str]:
        words = [sys.executable, "-m", "zonal", *map(str, arguments)]
        return subprocess.run(words, capture_output=True, text=True)

    assert run("--version").stdout == f"zonal {zn.__version__}\n"
    assert run("solve").returncode == 2
    bad = tmp_path / "bad.toml"
    bad.write_text("[[surface]]\nboxx = 1")
    failed = run("check", bad)
    assert failed.returncode == 2
    assert failed.stderr == f"error: {bad}:2:1: surface #1.boxx: unknown key; did you mean 'box'?\n"
    furnace_file = ROOT / "scenes/furnace.toml"
    assert run("check", furnace_file, "--json").returncode == 0


def test_check_reports_what_the_command_reports(run, tmp_path):
    import json

    furnace().save(tmp_path / "f.toml")
    report = json.loads(run("check", tmp_path / "f.toml", "--json").stdout)
    ours = zn.load_scene(tmp_path / "f.toml").check()
    for key in ("verdict", "patches", "voxel_zones", "pairs", "engine", "warnings"):
        assert ours[key] == report[key], key


def test_gas_models_are_those_of_the_command(run):
    import json

    text = run("gas", "wsgg-bordbar-2020", "--h2o", "0.2", "--co2", "0.1", "--json").stdout
    assert zn.gas_properties("wsgg-bordbar-2020", h2o=0.2, co2=0.1) == json.loads(text)
    assert "wsgg-bordbar-2020" in [m["name"] for m in zn.gas_properties()]
    with pytest.raises(zn.InputError, match="not a gas model"):
        zn.gas_properties("air")


def test_validation_runs_in_process():
    results = zn.validate(["view-factors"])
    assert results["passed"] is True


def test_other_reflectances_have_the_bits_of_the_command(run, tmp_path):
    scene = room()
    scene.save(tmp_path / "r.toml")
    run("solve", tmp_path / "r.toml", "-o", tmp_path / "r.npz", "--keep-factors", "--quiet")
    run("relight", tmp_path / "r.npz", "--reflectance", "walls=0.3", "--albedo", "0.5,0.6,0.7", "lamp=0.5", "-o", tmp_path / "c.npz")
    # The factors of the package, and those of the command.
    solution = scene.solve(keep_factors=tmp_path / "kept")
    for factors in (tmp_path / "kept", tmp_path / "r.npz.factors"):
        relit = solution.relight(lamp=0.5, reflectance={"walls": 0.3}, albedo=[0.5, 0.6, 0.7], kept_factors=factors)
        relit.save(tmp_path / "p.npz")
        ours, command = (np.load(tmp_path / f) for f in ("p.npz", "c.npz"))
        for name in ("radiosity", "incident", "error"):
            assert ours[name].tobytes() == command[name].tobytes(), name
    # They are the solution of that scene.
    for surface in scene.document["surface"]:
        if surface["name"] == "walls":
            surface["reflectance"] = 0.3
    again = scene.solve(keep_factors=tmp_path / "other")
    relit = solution.relight(reflectance={"walls": 0.3}, kept_factors=tmp_path / "kept")
    assert np.allclose(again.radiosity, relit.radiosity, rtol=1e-7)
    for settings, match in (
        ({"reflectance": {"walls": 0.3}}, "keep_factors"),
        ({"albedo": 0.3, "kept_factors": tmp_path / "none"}, "no factors"),
        ({"reflectance": {"walls": 1.3}, "kept_factors": tmp_path / "kept"}, "0 to 1"),
        ({"reflectance": {"roof": 0.3}, "kept_factors": tmp_path / "kept"}, "roof"),
    ):
        with pytest.raises(zn.InputError, match=match):
            solution.relight(**settings)


def test_data_sets_have_the_bits_of_the_command(run, tmp_path):
    scene = furnace()
    scene.save(tmp_path / "f.toml")
    vary = ["--vary", "medium.heat_source=0:20000", "--vary", "surface.wall.emissivity=log:0.2:0.9", "--vary", "medium.extinction=0.3,0.5"]
    run("dataset", tmp_path / "f.toml", *vary, "-n", 5, "--seed", 3, "-o", tmp_path / "c.npz", "--quiet")
    given = {"medium.heat_source": (0, 20000), "surface.wall.emissivity": "log:0.2:0.9", "medium.extinction": [0.3, 0.5]}
    made = scene.dataset(given, n=5, seed=3, output=tmp_path / "p.npz", threads=2)
    assert (tmp_path / "p.npz").read_bytes() == (tmp_path / "c.npz").read_bytes()
    assert made.inputs.shape == (5, 3) and made.keys == list(given) and made.status == ["converged"] * 5
    table = made.table
    assert np.array_equal(table["net_power wall.z0"], made["named_power"][:, made.names.index("wall.z0")])
    assert (np.abs(made.energy_residual) < 1e-6).all() and "5 samples" in repr(made)
    # The same inputs as a table, and without a file.
    columns = {key: made.inputs[:, k] for k, key in enumerate(made.keys)}
    again = zn.load_scene(tmp_path / "f.toml").dataset(inputs=columns)
    assert np.array_equal(again["temperature"], made["temperature"])
    for bad, match in (
        ({"vary": {"medium.heat": (0, 1)}}, "heat"),
        ({"vary": {"medium.heat_source": (1, 0)}}, "lower number first"),
        ({"vary": {"medium.heat_source": (1, 2, 3)}}, "tuple"),
        ({"inputs": {"medium.heat_source": [1, 2], "medium.extinction": [1]}}, "length"),
        ({}, "vary, inputs"),
        ({"vary": {"medium.heat_source": (0, 1)}, "inputs": {"medium.heat_source": [1]}}, "vary, inputs"),
    ):
        with pytest.raises(zn.InputError, match=match):
            scene.dataset(**bad)
    with pytest.warns(RuntimeWarning, match="sample 1"):
        refused = scene.dataset(inputs={"surface.wall.emissivity": [0.5, 2.0]})
    assert refused.status == ["converged", "refused"] and np.isnan(refused["temperature"][1]).all()
    np.savez(tmp_path / "other.npz", a=[1.0])
    for name in ("other.npz", "none.npz", "f.toml"):
        with pytest.raises(zn.FileError):
            zn.load_dataset(tmp_path / name)


def test_pictures_in_files_have_the_bits_of_the_command(run, tmp_path):
    lit, hot = room().solve(), furnace().solve()
    lit.save(tmp_path / "lit.npz")
    hot.save(tmp_path / "hot.npz")
    keys = tmp_path / "keys.toml"
    keys.write_text('frames_per_second = 1\n[[key]]\ntime = 0\ncamera = "corner"\n')
    cases = [
        (lit, "a.png", ["--stops", "-1", "--contrast", "1.3", "--bloom", "0.1"], {"stops": -1, "contrast": 1.3, "bloom": 0.1}),
        (lit, "b.exr", ["--samples", "2"], {"samples": 2}),
        (hot, "c.png", ["--show", "net-flux", "--range", "-2e4,6e4"], {"show": "net_flux", "range": (-2e4, 6e4)}),
        (hot, "d.png", ["--show", "temperature", "--slice", "x=1.0", "--log"], {"show": "temperature", "slice": ("x", 1), "log": True}),
        (lit, "frames", ["--animate", keys], {"animate": keys}),
    ]
    for solution, name, options, settings in cases:
        source = tmp_path / ("lit.npz" if solution is lit else "hot.npz")
        (tmp_path / "command").mkdir(exist_ok=True)
        run("render", source, "--size", "40x30", "-o", tmp_path / "command" / name, "--quiet", *options)
        assert solution.save_picture(tmp_path / name, size=(40, 30), **settings) == str(tmp_path / name)
        picture = "frames/frame-00001.png" if name == "frames" else name
        assert (tmp_path / picture).read_bytes() == (tmp_path / "command" / picture).read_bytes(), name
    for solution, settings, match in ((lit, {"show": "temperature"}, "thermal"), (hot, {}, "thermal"), (lit, {"camera": "roof"}, "no camera"), (hot, {"show": "net_flux", "stops": 1}, "stops")):
        with pytest.raises(zn.InputError, match=match):
            solution.save_picture(tmp_path / "e.png", **settings)


VS3 = """T a street
F 3
C encl=0 emit=0 out=0
V 1 0 0 0
V 2 4 0 0
V 3 4 2 0
V 4 0 2 0
V 5 0 2 1
V 6 4 2 1
S 1 1 2 3 4 0 0 0.9 ground
S 2 4 3 6 5 0 0 0.8 wall
End of data
"""


def test_view_factors_have_the_bits_of_the_command(run, tmp_path):
    vertices, faces = sphere(6)
    lines = ["solid ball"]
    for face in faces:
        lines += ["facet normal 0 0 0", "outer loop", *(f"vertex {x!r} {y!r} {z!r}" for x, y, z in (vertices[face] + [0, 0, 2]).tolist()), "endloop", "endfacet"]
    for corners in ([[-3, -3, 0], [3, -3, 0], [3, 3, 0]], [[-3, -3, 0], [3, 3, 0], [-3, 3, 0]]):
        lines += ["facet normal 0 0 0", "outer loop", *(f"vertex {x} {y} {z}" for x, y, z in corners), "endloop", "endfacet"]
    (tmp_path / "ball.stl").write_text("\n".join([*lines, "endsolid ball"]))
    (tmp_path / "street.vs3").write_text(VS3)
    for source in ("ball.stl", "street.vs3"):
        factors = zn.view_factors(tmp_path / source)
        for name, options in (("F.csv", []), ("F.mtx", []), ("F.bin", []), ("F.txt", ["--format", "text"]), ("F.out", ["--format", "sparse"])):
            (tmp_path / "command").mkdir(exist_ok=True)
            run("view-factors", tmp_path / source, "-o", tmp_path / "command" / name, *options)
            factors.save(tmp_path / name, format=options[1] if options else None)
            assert (tmp_path / name).read_bytes() == (tmp_path / "command" / name).read_bytes(), (source, name)
        run("view-factors", tmp_path / source, "-o", tmp_path / "F.npz")
        with np.load(tmp_path / "F.npz") as file:
            assert np.array_equal(file["data"], factors.matrix.data) and np.array_equal(file["sky"], factors.sky)
    street = zn.view_factors(tmp_path / "street.vs3")
    assert street.materials == ["ground", "wall"] and street.emissivities.tolist() == [0.9, 0.8]
    run("view-factors", tmp_path / "street.vs3", "--script-f", "-o", tmp_path / "command/S.csv")
    street.save(tmp_path / "S.csv", script_f=True)
    assert (tmp_path / "S.csv").read_bytes() == (tmp_path / "command/S.csv").read_bytes()
    for settings, name, match in (({"format": "rows"}, "F.txt", "text, binary or sparse"), ({"format": "text"}, "F.csv", "format"), ({"format": "text"}, "F.npz", "npz"), ({}, "F.xyz", "xyz"), ({"emissivity": [1.0]}, "F.txt", "one value for each")):
        with pytest.raises(zn.InputError, match=match):
            street.save(tmp_path / name, **settings)


def test_a_cache_of_the_package_is_one_of_the_command(run, tmp_path):
    (tmp_path / "street.vs3").write_text(VS3)
    factors = zn.view_factors(tmp_path / "street.vs3", cache=tmp_path / "cache")
    (folder,) = (tmp_path / "cache").iterdir()
    stamps = {p.name: p.stat().st_mtime_ns for p in folder.glob("*.stage")}
    run("view-factors", tmp_path / "street.vs3", "--cache", folder, "-o", tmp_path / "F.npz")
    # Nothing was computed again.
    assert stamps and stamps == {p.name: p.stat().st_mtime_ns for p in folder.glob("*.stage")}
    with np.load(tmp_path / "F.npz") as file:
        assert np.array_equal(file["data"], factors.matrix.data)
