"""The package against the program: the same bits, the same command line."""

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


def hierarchical() -> zn.Scene:
    scene = room(0.7)
    scene.settings(engine="hierarchical", tolerance=0.05)
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
    "hierarchical": hierarchical,
    "mesh": mesh_with_face_values,
    "smoke": smoke_array,
    "sunlit": sunlit,
    "gas": gas,
    "pane": paned,
}


def test_scenes_use_all_engines():
    engines = {make().solve().report["engine"] for make in (room, spectral, layered, hierarchical)}
    assert engines == {"dense", "spectral", "layered", "hierarchical"}


@pytest.mark.parametrize("name", SCENES)
def test_solutions_have_the_bits_of_the_command(name, run, tmp_path):
    scene = SCENES[name]()
    scene.save(tmp_path / "scene.toml")
    run("solve", tmp_path / "scene.toml", "-o", tmp_path / "command.npz", "--quiet")
    scene.solve(threads=2).save(tmp_path / "memory.npz")
    zn.load(tmp_path / "scene.toml").solve(threads=1).save(tmp_path / "file.npz")
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
    ours = zn.load(tmp_path / "f.toml").check()
    for key in ("verdict", "patches", "voxel_zones", "pairs", "engine", "warnings"):
        assert ours[key] == report[key], key


def test_gas_models_are_those_of_the_command(run):
    import json

    text = run("gas", "wsgg-bordbar-2020", "--h2o", "0.2", "--co2", "0.1", "--json").stdout
    assert zn.gas("wsgg-bordbar-2020", h2o=0.2, co2=0.1) == json.loads(text)
    assert "wsgg-bordbar-2020" in [m["name"] for m in zn.gas()]
    with pytest.raises(zn.InputError, match="not a gas model"):
        zn.gas("air")


def test_validation_runs_in_process():
    results = zn.validate(["view-factors"])
    assert results["passed"] is True
