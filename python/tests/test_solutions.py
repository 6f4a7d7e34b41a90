"""Solutions: arrays, tables, files, pictures, other packages."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from conftest import furnace, room, sphere

import zonal as zn


@pytest.fixture(scope="module")
def lit() -> zn.Solution:
    return room().solve()


@pytest.fixture(scope="module")
def hot() -> zn.Solution:
    return furnace().solve()


def test_results_by_name(hot, lit):
    table = hot.table
    row = table["name"].index("wall.z0")
    assert table["temperature"][row] == pytest.approx(1200) and table["net_power"][row] > 2e5
    assert abs(table["net_power"].sum()) <= 1e-6 * np.abs(table["net_power"]).max() + table["net_power_error"].sum()
    assert "temperature" not in lit.table
    zones = hot.zones_of("wall")
    assert len(zones) == hot.patch_count
    absorbed, error = lit.absorbed
    assert absorbed.shape == error.shape == (len(lit.table["name"]), 3)
    with pytest.raises(zn.InputError, match="the names are"):
        hot.zones_of("floor")
    with pytest.raises(zn.InputError, match="thermal"):
        lit.temperature  # noqa: B018


def test_tables_are_frames(hot, lit):
    pandas = pytest.importorskip("pandas")
    assert len(pandas.DataFrame(hot.table)) == len(hot.names)
    frame = pandas.DataFrame(lit.zone_table)
    assert len(frame) == lit.zone_count and {"name", "kind", "x", "radiosity_red"} <= set(frame.columns)


def test_radiosity_follows_from_its_parts(lit):
    size, emission, reflectance = lit.size, lit.array("emission"), lit.array("reflectance")
    incident = lit.incident + (lit.direct if len(lit.direct) else 0)
    response = np.where(lit.array("kind")[:, None] == 0, 1.0, 0.25) * reflectance
    assert np.allclose(lit.radiosity, emission + response * incident, rtol=1e-9)
    assert size[: lit.patch_count].sum() == pytest.approx(2 * (4 * 3 + 4 * 2.5 + 3 * 2.5) + 0.16)


def test_arrays_are_read_only_and_kept(lit):
    assert lit.radiosity is lit.radiosity
    with pytest.raises(ValueError, match="read-only"):
        lit.radiosity[0] = 1


def test_solutions_survive_pickles_and_files(lit, hot, tmp_path):
    for solution in (lit, hot):
        solution.save(tmp_path / "s.npz")
        for again in (pickle.loads(pickle.dumps(solution)), copy.deepcopy(solution), zn.load_solution(tmp_path / "s.npz")):
            assert again.report == solution.report
            assert np.array_equal(again.radiosity, solution.radiosity)
            again.save(tmp_path / "t.npz")
            assert (tmp_path / "t.npz").read_bytes() == (tmp_path / "s.npz").read_bytes()


def test_relighting(lit):
    dark = lit.relight({"lamp": 0.0})
    assert abs(dark.radiosity).max() == 0
    red = lit.relight(lamp=[1, 0, 0])
    assert np.allclose(red.radiosity[:, 0], lit.radiosity[:, 0], rtol=1e-12) and abs(red.radiosity[:, 1:]).max() == 0
    assert np.allclose(lit.group("lamp")["incident"], lit.incident, rtol=1e-6)
    with pytest.raises(zn.InputError):
        lit.relight(sun=1.0)
    with pytest.raises(zn.InputError, match="the groups are: lamp"):
        lit.group("sun")


def test_pictures(lit, hot):
    camera = zn.Camera([0.3, 0.3, 1.5], [3, 2, 1])
    assert np.array_equal(lit.render(camera, (20, 15)), lit.render("corner", (20, 15)))
    kelvin = hot.render(size=(20, 16), show="temperature")
    assert kelvin.shape == (16, 20) and set(np.unique(kelvin[~np.isnan(kelvin)]).round()) <= {400.0, 900.0, 1200.0}
    gas = hot.render(size=(20, 16), show="temperature", slice=("x", 1.0))
    assert np.isfinite(gas).any()
    html = lit._repr_html_()
    assert "data:image/png;base64" in html and "engine dense" in html
    assert "900 to 1200 K" in hot._repr_html_()
    for arguments, message in [
        ({"camera": "none"}, "there is no camera 'none'"),
        ({"size": (0, 1)}, "size"),
        ({"show": "temperature"}, "only in thermal mode"),
        ({"show": "colour"}, "give one of temperature"),
        ({"slice": ("w", 1)}, "there is no axis"),
        ({"camera": zn.Camera([0, 0, 0], [0, 0, 1])}, "up must not run along"),
    ]:
        with pytest.raises(zn.InputError, match=message):
            lit.render(**arguments)
    with pytest.raises(zn.InputError, match="thermal"):
        hot.render()


def test_the_viewer_is_a_frame_in_a_notebook(lit, hot):
    page = zn.show(lit)
    assert page.text.startswith("<!doctype html>") and "srcdoc=" in page._repr_html_()
    with pytest.raises(zn.InputError):
        zn.show(hot)


def test_pyvista_has_surfaces_and_medium(hot):
    pytest.importorskip("pyvista")
    blocks = hot.to_pyvista()
    assert blocks["surfaces"].n_cells == hot.patch_count and blocks["medium"].n_cells == hot.voxel_count
    cells = blocks["surfaces"].compute_cell_sizes()
    assert np.allclose(cells.cell_data["Area"], hot.size[: hot.patch_count])
    centres = blocks["medium"].cell_centers().points
    order = np.lexsort(np.round(centres, 6).T[::-1])
    zones = slice(hot.patch_count, hot.patch_count + hot.voxel_count)
    assert np.allclose(blocks["medium"].cell_data["temperature"][order], hot.temperature[zones])


def test_meshio_and_xarray(hot):
    pytest.importorskip("meshio")
    mesh = hot.to_meshio()
    assert sum(len(c.data) for c in mesh.cells) == hot.patch_count
    pytest.importorskip("xarray")
    data = hot.to_xarray()
    assert data["medium_temperature"].shape == (2, 2, 4) and data["temperature"].attrs["units"] == "K"
    cell = hot.array("cell")
    assert np.allclose(data["medium_temperature"].values.reshape(-1)[cell], hot.temperature[hot.patch_count :])


def test_many_bands(tmp_path):
    scene = zn.Scene(bands=5)
    scene.surface(room=([0, 0, 0], [1, 1, 1]), name="walls", reflectance=[0.1, 0.3, 0.5, 0.7, 0.9], emission=[1, 2, 3, 4, 5], patch_size=1.0)
    solution = scene.solve()
    assert solution.radiosity.shape == (6, 5)
    # All walls are alike: B = E/(1 - reflectance).
    assert np.allclose(solution.radiosity, np.array([1, 2, 3, 4, 5]) / (1 - np.array([0.1, 0.3, 0.5, 0.7, 0.9])), rtol=1e-8)
    solution.save(tmp_path / "m.npz")
    assert np.array_equal(np.load(tmp_path / "m.npz")["radiosity"], solution.radiosity)
    assert solution.array("reflectance").shape == (6, 5)


def test_states_of_faces_and_zones():
    vertices, faces = sphere(3)
    scene = zn.Scene(mode="thermal")
    scene.surface((vertices, faces[:, ::-1]), name="m", emissivity=0.5, temperature=300, patch_size=10.0)
    solver = zn.StateSolver(scene.exchange())
    kelvin = np.linspace(300, 500, len(faces))
    solver.set_temperature(kelvin, by="face")
    state = solver.solve()
    assert np.allclose(state.by_face["temperature"], kelvin)
    solver.set_net_power(0.0)
    solver.set_temperature({"m": 350.0})
    solver.set_emissivity(0.9)
    assert np.allclose(solver.solve().zones["net_power"], 0, atol=1e-6)
    with pytest.raises(zn.InputError, match="give one value for each"):
        solver.set_temperature(np.zeros(3))
    with pytest.raises(zn.InputError, match="out of range"):
        solver.set_temperature(-5.0)
    assert state.table["name"] == ["m"]
    # Without a temperature their level is undetermined.
    powers = np.linspace(-1.0, 1.0, len(faces))
    solver.set_net_power(powers, by="face")
    with pytest.raises(zn.InputError, match="undetermined"):
        solver.solve()


def test_states_of_a_court_in_sunlight():
    def court(kelvin: float) -> zn.Scene:
        scene = zn.Scene(mode="thermal")
        scene.settings(engine="dense", residual=1e-13, discretization_error=False)
        scene.surface(room=([0, 0, 0], [1, 1, 1]), omit=["z1"], name="court", emissivity=0.9, solar_absorptance=0.3, temperature=kelvin, patch_size=0.5)
        scene.sun([0.2, 0, -1], irradiance=700)
        scene.surroundings(temperature=270)
        return scene

    solver = zn.StateSolver(court(300).exchange())
    solver.set_temperature(350.0)
    state = solver.solve()
    solved = court(350).solve()
    assert abs(state.balance) < 1e-6 and state.emitters == 0
    assert np.allclose(state.by_name["net_power"], solved.table["net_power"], rtol=1e-8)
