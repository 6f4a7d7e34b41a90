"""Every public property and method of the package, used on solutions with notes, warnings, errors and unknown errors."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import warnings

import numpy as np
import pytest
from conftest import furnace, room, sphere

import zonal as zn


def open_plate() -> zn.Scene:
    """A plate with black surroundings: warnings, and notes of the discretization error."""
    scene = zn.Scene(mode="thermal")
    scene.surface(rectangle=([0, 0, 0], [1, 0, 0], [0, 1, 0]), name="p", emissivity=0.8, temperature=400.0, patch_size=0.5)
    return scene


def unknown_errors() -> zn.Scene:
    """A room of gas whose discretization error nobody requests."""
    scene = zn.Scene(mode="thermal")
    scene.surface(room=([0, 0, 0], [1, 1, 1]), name="room", emissivity=0.8, temperature=300.0, faces={"z0": {"temperature": 1000.0}}, patch_size=2.0)
    scene.medium([0, 0, 0], [1, 1, 1], cells=[8, 8, 8], extinction=0.2, heat_source=0.0)
    scene.settings(discretization_error=False)
    return scene


def sunlit_mesh() -> zn.Scene:
    """A ball of triangles in sunlight."""
    vertices, faces = sphere(4)
    scene = zn.Scene(mode="thermal")
    scene.surface((vertices, faces), name="ball", emissivity=0.9, solar_absorptance=0.4, heat_flux=0.0, patch_size=10.0)
    scene.sun([0, 0, -1], irradiance=800.0)
    scene.surroundings(temperature=280.0)
    return scene


def glass() -> zn.Scene:
    """A pane between walls, with the discretization error of light."""
    scene = room(2.0)
    scene.pane([[2, 0.2, 0.2], [2, 2.8, 0.2], [2, 2.8, 2.2], [2, 0.2, 2.2]], thickness=0.01, extinction=[20, 5, 1], name="glass")
    scene.settings(tolerance=0.2, discretization_error=True)
    return scene


def gases() -> zn.Scene:
    """Five grey gases: bands in two triples."""
    scene = zn.Scene("gas", mode="thermal")
    scene.surface(room=([0, 0, 0], [1, 1, 1]), name="wall", emissivity=0.8, temperature=600, patch_size=1.0)
    scene.medium([0, 0, 0], [1, 1, 1], cells=[2, 2, 2], gas=zn.Gas("wsgg-bordbar-2020", h2o=0.2, co2=0.1), temperature=1500)
    return scene


SCENES = {"plate": open_plate, "unknown": unknown_errors, "sunlit": sunlit_mesh, "glass": glass, "gases": gases, "room": room, "furnace": furnace}


@pytest.fixture(scope="module")
def solutions() -> dict[str, zn.Solution]:
    return {name: make().solve() for name, make in SCENES.items()}


def public_names(kind: type) -> tuple[list[str], list[str]]:
    """Names of the properties and data fields, and of the methods, of a class."""
    names = [n for n in dir(kind) if not n.startswith("_")]
    own = {n: inspect.getattr_static(kind, n) for n in names if not isinstance(inspect.getattr_static(kind, n), type(BaseException.args))}
    methods = [n for n, x in own.items() if callable(x) or isinstance(x, (staticmethod, classmethod))]
    fields = [f.name for f in dataclasses.fields(kind)] if dataclasses.is_dataclass(kind) else []
    return sorted({*(n for n in own if n not in methods), *fields}), methods


def read_all(thing: object) -> dict[str, object]:
    """Reads every public property; those of the other mode say so."""
    found: dict[str, object] = {}
    for name in public_names(type(thing))[0]:
        try:
            found[name] = getattr(thing, name)
        except zn.InputError as error:
            assert error.remedy, f"{type(thing).__name__}.{name}: {error}"
    assert repr(thing)
    return found


# Guards (python): every public property is read with notes, warnings and unknown errors.
def test_every_property_of_solutions_is_read(solutions):
    thermal_only = {"temperature", "temperature_error", "net_flux", "net_flux_error"}
    severities = set()
    for name, solution in solutions.items():
        found = read_all(solution)
        missing = set(public_names(zn.Solution)[0]) - set(found)
        assert missing == (set() if "temperature" in solution.table else thermal_only), name
        for severity, listed in (("warning", solution.warnings), ("note", solution.notes)):
            for d in listed:
                assert isinstance(d, zn.Diagnostic) and d.severity == severity and d.code and d.text
                assert d.part is None or d.part
                assert str(d) == f"{severity}: " + (f"{d.part}: " if d.part else "") + d.text
                severities.add(severity)
    assert severities == {"note", "warning"}


def test_fields_have_one_row_for_each_zone(solutions):
    """Also those of errors that no zone has."""
    fields = ("radiosity", "incident", "direct", "error", "direct_error", "surroundings_error")
    without_errors = 0
    for name, solution in solutions.items():
        shapes = {f: getattr(solution, f).shape for f in fields}
        assert len(set(shapes.values())) == 1 and shapes["incident"][0] > 0, (name, shapes)
        without_errors += not solution.direct_error.any()
    assert without_errors > 0


def test_warnings_and_notes_are_those_of_the_report(solutions):
    of_discretization = 0
    for solution in solutions.values():
        report = solution.report
        zones = report["discretization_error"]
        entries = [*report["warnings"], *(zones["notes"] if zones else [])]
        of_discretization += len(zones["notes"]) if zones else 0
        found = {(d.severity, d.code, d.part, d.text) for d in (*solution.warnings, *solution.notes)}
        assert {(d["severity"], d["code"], d["location"], d["text"]) for d in entries} <= found
    assert of_discretization > 0


# Guards (python): the errors of tables are the errors that the command prints.
def test_the_table_has_the_errors_of_the_command(solutions):
    units = {"temperature": "_K", "net_flux": "", "net_power": "_W"}
    unknown = known = 0
    for solution in solutions.values():
        table = solution.table
        heat = solution.report["heat"]
        quantities = units if heat else {"net_flux": "", "net_power": "_W"}
        for quantity, unit in quantities.items():
            whole, exchange, zones = (table[f"{quantity}_{part}"] for part in ("error", "exchange_error", "discretization_error"))
            assert np.allclose(whole, exchange + zones, rtol=1e-12, equal_nan=True), quantity
            for part in ("error", "exchange_error", "discretization_error") if heat else ():
                for ours, row in zip(table[f"{quantity}_{part}"], heat["rows"], strict=True):
                    theirs = row.get(f"{quantity}_{part}{unit}")
                    assert theirs == ours if np.isfinite(ours) else theirs is None
                    unknown, known = unknown + (theirs is None), known + (theirs is not None)
        assert len(table["name"]) == len(table["net_power_error"])
        if heat and "absorbed_sunlight_W" in heat["rows"][0]:
            assert table["absorbed_sunlight"].tolist() == [row["absorbed_sunlight_W"] for row in heat["rows"]]
    assert unknown > 0 and known > 0
    # An unknown part leaves the known one beside it.
    table = solutions["unknown"].table
    wall = table["name"].index("room.x0")
    assert np.isinf(table["net_power_error"][wall]) and np.isfinite(table["net_power_exchange_error"][wall])
    # What nobody estimated is unknown.
    bare = furnace().solve(discretization_error=False).table
    assert np.isinf(bare["net_power_error"]).all() and np.isfinite(bare["net_power_exchange_error"]).all()
    absorbed, whole = solutions["glass"].absorbed
    parts = solutions["glass"].absorbed_errors
    assert absorbed.shape == whole.shape and np.allclose(whole, parts["exchange"] + parts["discretization"], rtol=1e-12) and (whole > 0).any()
    assert np.isinf(solutions["room"].absorbed[1]).all()


def test_sunlight_by_face_adds_up_to_that_of_the_surface(solutions, run, tmp_path):
    ball = solutions["sunlit"]
    faces, table = ball.face_table, ball.table
    assert len(faces["mesh"]) == len(faces["absorbed_sunlight"]) == ball.patch_count
    assert faces["absorbed_sunlight"].sum() == pytest.approx(table["absorbed_sunlight"][0], rel=1e-12)
    # The lit half of the ball has the irradiance times the cosine, and its infrared surroundings beside: no band counts twice.
    up = ball.normal[:, 2].clip(0)
    sky = 5.670374419e-8 * 280.0**4
    assert faces["incident_flux"] == pytest.approx(800 * up + sky, rel=0.02, abs=4)
    # The columns are those of the command.
    ball.save(tmp_path / "b.npz")
    run("export", tmp_path / "b.npz", "--faces", "-o", tmp_path / "b.csv", "--quiet")
    head, *rows = (line.split(",") for line in (tmp_path / "b.csv").read_text().splitlines())
    assert [float(r[head.index("absorbed_sunlight_W")]) for r in rows] == faces["absorbed_sunlight"].tolist()
    assert len(head) == len(faces)


def test_every_method_of_solutions_is_called(solutions, tmp_path):
    pytest.importorskip("pyvista"), pytest.importorskip("meshio"), pytest.importorskip("xarray")
    calls = {
        "array": lambda s: s.array("radiosity"),
        "export": lambda s: s.export(tmp_path / "s.csv"),
        "group": lambda s: [s.group(name) for name in s.light_groups],
        "medium_arrays": lambda s: s.medium_arrays(),
        "relight": lambda s: s.relight(dict.fromkeys(s.light_groups, 0.5)),
        "render": lambda s: s.render(size=(8, 6), show="radiosity"),
        "save": lambda s: s.save(tmp_path / "s.npz"),
        "save_picture": lambda s: s.save_picture(tmp_path / "s.png", size=(8, 6), show="radiosity"),
        "to_meshio": lambda s: s.to_meshio(),
        "to_pyvista": lambda s: s.to_pyvista(),
        "to_xarray": lambda s: s.to_xarray(),
        "zones_of": lambda s: s.zones_of(s.names[0]),
    }
    assert sorted(calls) == sorted(public_names(zn.Solution)[1])
    for name, solution in solutions.items():
        for method, call in calls.items():
            try:
                call(solution)
            except zn.InputError as error:
                assert error.remedy, f"{name}.{method}: {error}"
                # Without lights, without a medium, bands that are no colours.
                assert method in ("relight", "medium_arrays", "render", "save_picture"), f"{name}.{method}: {error}"
        assert "<div>" in solution._repr_html_() and copy.deepcopy(solution).warnings == solution.warnings


def test_areas_states_and_factors_are_read(tmp_path):
    severities = set()
    for make in (open_plate, unknown_errors, furnace):
        areas = make().exchange()
        read_all(areas)
        severities |= {d.severity for d in (*areas.warnings, *areas.notes)}
        calls = {"by_name": lambda a: a.by_name(), "save": lambda a: a.save(tmp_path / "a.npz"), "view_factors": lambda a: a.view_factors()}
        assert sorted(calls) == sorted(public_names(zn.ExchangeAreas)[1])
        for call in calls.values():
            call(areas)
        solver = zn.StateSolver(areas)
        read_all(solver)
        settings = {
            "set_temperature": lambda x: x.set_temperature({x.names[0]: 500.0}),
            "set_net_power": lambda x: x.set_net_power({x.names[0]: 1.0}),
            "set_heat_flux": lambda x: x.set_heat_flux({x.names[0]: 1.0}),
            "set_emissivity": lambda x: x.set_emissivity({x.names[0]: 0.5}),
            "set_surroundings_temperature": lambda x: x.set_surroundings_temperature(290.0),
            "solve": lambda x: x.solve(),
        }
        assert sorted(settings) == sorted(public_names(zn.StateSolver)[1])
        for call in settings.values():
            call(solver)
        state = solver.solve()
        table = read_all(state)["table"]
        assert not public_names(zn.ThermalState)[1]
        # No discretization error is estimated, so that no total error stands there.
        assert "net_power_exchange_error" in table and "net_power_error" not in table
    assert severities


def test_factors_data_sets_and_others_are_read(tmp_path):
    vertices, faces = sphere(4)
    with warnings.catch_warnings():
        # Rows of an open ball.
        warnings.simplefilter("ignore", RuntimeWarning)
        for factors in (zn.view_factors((vertices, faces)), zn.view_factors((vertices, faces[:20, ::-1]), surroundings=False)):
            read_all(factors)
            read_all(factors.matrix)
            calls = {
                "combined": lambda f: f.combined([0] * len(f)),
                "load": lambda f: type(f).load(tmp_path / "F.npz"),
                "save": lambda f: f.save(tmp_path / "F.npz"),
                "script_f": lambda f: f.script_f(0.5),
            }
            assert sorted(calls) == sorted(public_names(zn.ViewFactors)[1])
            for name in ("save", "combined", "load", "script_f"):
                calls[name](factors)
    made = furnace().dataset({"medium.heat_source": (0, 9000)}, n=2, discretization_error=True)
    read_all(made)
    assert not public_names(zn.Dataset)[1]
    assert np.array_equal(made["named_power_error"], made["named_power_exchange_error"] + made["named_power_discretization_error"])
    read_all(zn.keys("solve.tolerance")[0])
    read_all(zn.Camera([0, 0, 1], [1, 0, 1]))
    read_all(room())
    timings = zn.Timings()
    room(2.0).solve(progress=timings)
    read_all(timings)
    assert not public_names(zn.Timings)[1] and timings.phases
    for phase in timings.phases:
        read_all(phase)
    for error in (zn.InputError("a; b", "f", "1:2", "k"), zn.FileError("a"), zn.MemoryLimitError("a"), zn.Interrupted("a")):
        read_all(error)


def test_every_public_class_is_in_this_file():
    read = {"Camera", "CompressedRows", "Dataset", "Diagnostic", "Error", "ExchangeAreas", "FileError", "InputError", "Interrupted", "Key", "MemoryLimitError"}
    read |= {"Phase", "Scene", "Solution", "StateSolver", "ThermalState", "Timings", "ViewFactors"}
    assert {n for n in zn.__all__ if inspect.isclass(getattr(zn, n))} == read
    functions = {"Gas", "encode_png", "gas_properties", "keys", "load_dataset", "load_scene", "load_solution", "show", "update", "validate", "view_factors"}
    assert set(zn.__all__) == read | functions


@pytest.mark.parametrize("name", ["load", "read_solution", "read_dataset", "gas"])
def test_former_names_are_gone(name):
    assert not hasattr(zn, name) and not hasattr(zn.Solution, name)
