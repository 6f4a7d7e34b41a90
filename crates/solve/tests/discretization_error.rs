//! The discretization error: the estimate covers the error against much finer zones, and unknown errors are reported.
//!
//! Guards (numbers): the discretization error covers the difference to finer zones, also for odd numbers of cells.

use crate::common;

use common::{read, solved, unit_room};
use zonal_math::{Vec3, vec3};
use zonal_reference::test_cases::sampled_cases;
use zonal_scene::{
    Band, Bands, CheckpointStore, DiscretizationError, Engine, Facet, HeatRow, NoProgress, Plate, Scene,
    Solution, SolveOptions,
};
use zonal_solve::{SolvePurpose, SolveSettings, solve_with_settings};

/// Range of the estimate over the error.
const ESTIMATE_OVER_ERROR: [f64; 2] = [1.0, 40.0];
/// Relative differences of powers and temperatures that are negligible.
const NEGLIGIBLE_DIFFERENCE: f64 = 1e-6;

fn without(text: &str) -> String {
    text.replace("[solve]", "[solve]\ndiscretization_error = false")
}

/// Checks the estimates of a coarse solve against the solution on finer zones; returns the number of checks.
fn covered(name: &str, coarse: &str, exact: &Solution) -> usize {
    let s = solved(coarse);
    let zoning =
        s.report.discretization_error.as_ref().unwrap_or_else(|| panic!("{name}: {:?}", s.report.warnings));
    let rows = |s: &Solution| -> Vec<HeatRow> { s.report.heat.as_ref().unwrap().rows.clone() };
    let (own, other) = (rows(&s), rows(exact));
    assert_eq!(zoning.heat.len(), own.len());
    let mut seen = 0;
    let mut check = |what: String, a: f64, b: f64, stated: f64, exchange: f64| {
        let error = (a - b).abs();
        if error > NEGLIGIBLE_DIFFERENCE * b.abs() + exchange {
            seen += 1;
            assert!(
                stated >= ESTIMATE_OVER_ERROR[0] * error && stated <= ESTIMATE_OVER_ERROR[1] * error,
                "{what}: error {error:e}, estimate {stated:e}"
            );
        }
    };
    for ((a, b), stated) in own.iter().zip(&other).zip(&zoning.heat) {
        check(format!("{name}, power of {}", a.name), a.power, b.power, stated[1], a.power_error);
        let (t, u) = (a.temperature.unwrap(), b.temperature.unwrap());
        check(format!("{name}, temperature of {}", a.name), t, u, stated[0], a.temperature_error.unwrap());
    }
    seen
}

fn furnace(m: usize, thick: &str) -> String {
    format!(
        "mode = \"thermal\"\n[solve]\npatch_rule = \"voxels\"\nzone_basis = \"{thick}\"\nengine = \"spectral\"\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [2,2,4] }}\ntemperature = 900\nemissivity = 0.7\nfaces.z0 = {{ temperature = 1200, emissivity = 0.85 }}\nfaces.z1 = {{ temperature = 400 }}\n[medium]\nmin = [0,0,0]\nmax = [2,2,4]\ncells = [{}, {}, {}]\nextinction = 0.5\nalbedo = 0\nheat_source = 5000\n",
        2 * m,
        2 * m,
        4 * m
    )
}

fn cube(n: usize, thick: &str) -> String {
    format!(
        "mode = \"thermal\"\n[solve]\npatch_rule = \"voxels\"\nzone_basis = \"{thick}\"\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\ntemperature = 300\nemissivity = 0.8\nfaces.z0 = {{ temperature = 1000, emissivity = 1 }}\nfaces.x0 = {{ heat_flux = 0 }}\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [{n},{n},{n}]\nextinction = 2\nalbedo = 0\nheat_source = 0\n"
    )
}

#[test]
fn furnace_error_is_within_the_estimate() {
    let exact = solved(&without(&furnace(8, "linear")));
    for (m, thick) in [(3, "constant"), (2, "linear"), (3, "linear")] {
        assert!(covered(&format!("m = {m}, {thick}"), &furnace(m, thick), &exact) >= 6);
    }
}

/// The furnace with this number of cells along each axis.
fn furnace_of_cells(cells: [usize; 3]) -> String {
    furnace(1, "linear").replace("cells = [2, 2, 4]", &format!("cells = {cells:?}"))
}

/// The second solve has a looser residual and less accurate factors than a solve for itself; their errors are added, and are small.
#[test]
fn estimate_contains_the_difference_to_an_accurate_solve_on_the_same_zones() {
    let accurate = |text: &str| solved(&without(text).replace("[solve]", "[solve]\nresidual = 1e-12"));
    let (coarse, finer) = (furnace_of_cells([3, 3, 5]), furnace_of_cells([6, 6, 10]));
    let (s, fine) = (solved(&coarse), accurate(&finer));
    let stated = s.report.discretization_error.as_ref().unwrap();
    assert_eq!((stated.zones, stated.ratio), (fine.zones.len(), 2.0));
    let rows = |s: &Solution| s.report.heat.as_ref().unwrap().rows.clone();
    let mut seen = 0;
    for ((a, b), stated) in rows(&s).iter().zip(&rows(&fine)).zip(&stated.heat) {
        let difference = 2.0 * (a.power - b.power).abs();
        if difference > 1e-9 * a.power.abs() {
            seen += 1;
            let excess = stated[1] / difference - 1.0;
            assert!((0.0..0.02).contains(&excess), "{}: {} W, {difference} W", a.name, stated[1]);
        }
    }
    assert_eq!(seen, 6);
    // A solve for a comparison has less accurate factors.
    let settings =
        SolveSettings { purpose: SolvePurpose::Comparison, ..SolveSettings::new(4 << 30, &NoProgress) };
    let compared = solve_with_settings(read(&without(&finer)), &settings).unwrap();
    let emitted = fine.report.energy.emitted.sum();
    for (a, b) in rows(&fine).iter().zip(&rows(&compared)) {
        assert!((a.power - b.power).abs() < 3e-8 * emitted, "{}: {} W, {} W", a.name, a.power, b.power);
    }
}

/// A store that has nothing, and says that it keeps stages: the second solve runs after the first.
struct ForgetfulStore;

impl CheckpointStore for ForgetfulStore {
    fn load(&self, _stage: &str) -> Option<Vec<u8>> {
        None
    }
    fn save(&self, _stage: &str, _bytes: &[u8]) {}
}

#[test]
fn solves_at_the_same_time_have_the_bits_of_solves_after_each_other() {
    let gas = "heat_source = 5000\ngas = { model = \"wsgg-smith-1982\", h2o = 0.2, co2 = 0.1 }\n";
    let grey = furnace(1, "linear");
    let (walls, _) = grey.split_once("extinction").unwrap();
    for text in [grey.clone(), format!("{walls}{gas}"), furnace(1, "constant").replace("spectral", "dense")] {
        let scene = read(&text);
        let settings = SolveSettings::new(4 << 30, &NoProgress);
        let together = solve_with_settings(scene.clone(), &settings).unwrap();
        let settings = SolveSettings { checkpoints: &ForgetfulStore, ..settings };
        let apart = solve_with_settings(scene, &settings).unwrap();
        assert!(together.report.discretization_error.is_some());
        assert_eq!(together.report, apart.report);
        assert_eq!(together.fields, apart.fields);
    }
}

#[test]
fn odd_cell_counts_error_is_within_the_estimate() {
    let exact = solved(&without(&cube(20, "linear")));
    for (n, thick) in [(5, "constant"), (7, "constant"), (3, "linear"), (5, "linear")] {
        assert!(covered(&format!("n = {n}, {thick}"), &cube(n, thick), &exact) >= 6);
    }
}

#[test]
fn vacuum_room_error_is_within_the_estimate() {
    let room = |n: usize| {
        format!(
            "mode = \"thermal\"\n{}",
            unit_room(
                &format!("engine = \"dense\"\npatch_size = {}", 1.0 / n as f64),
                "temperature = 300\nemissivity = 0.5\nfaces.z0 = { temperature = 1000, emissivity = 0.9 }\nfaces.x0 = { heat_flux = 0 }",
                ""
            )
        )
    };
    let exact = solved(&without(&room(18)));
    for n in [4, 5, 6] {
        assert!(covered(&format!("n = {n}"), &room(n), &exact) >= 6);
    }
}

/// A gas with 6³ densities, denser in the middle and hotter below, in `split`³ zones each.
fn cloud(split: usize) -> Scene {
    let n = 6 * split;
    let text = format!(
        "mode = \"thermal\"\n{}",
        unit_room(
            "patch_rule = \"voxels\"\nengine = \"dense\"",
            "temperature = 300\nemissivity = 0.9\nfaces.z0 = { temperature = 900 }",
            &format!(
                "[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [{n},{n},{n}]\nextinction = 1\nalbedo = 0\ntemperature = 500"
            )
        )
    );
    let mut parts = read(&text).into_parts();
    let map = parts.voxel_grid.as_mut().unwrap();
    for i in 0..map.len() {
        let p = map.coordinates(i).map(|c| ((c / split) as f64 + 0.5) / 6.0);
        let p = zonal_math::vec3(p[0], p[1], p[2]);
        let bump = |a: f64| (std::f64::consts::PI * a).sin();
        map.set(
            i,
            Bands::splat(1.5 * bump(p.x) * bump(p.y) * bump(p.z)),
            Bands::splat(0.2 * p.x),
            Bands::ZERO,
            Bands::ZERO,
        );
        map.set_heat(
            i,
            zonal_scene::ThermalCondition::Temperature(1400.0 - 600.0 * p.z),
            zonal_scene::ThermalCondition::Flux(0.0),
        );
    }
    parts.voxel_grid = Some(parts.voxel_grid.unwrap().seal().unwrap());
    Scene::new(parts).unwrap()
}

#[test]
fn heterogeneous_gas_error_is_within_the_estimate() {
    let fine = cloud(2);
    let options = SolveOptions { engine: Engine::Rays, tolerance: 0.05, ..fine.options().clone() };
    let exact = common::solve(fine.with_options(options).unwrap());
    let s = common::solve(cloud(1));
    let zoning = s.report.discretization_error.as_ref().unwrap();
    assert_eq!((zoning.zones, zoning.ratio), (6 * 9 + 27, 2.0));
    let rows =
        |s: &Solution| -> Vec<f64> { s.report.heat.as_ref().unwrap().rows.iter().map(|r| r.power).collect() };
    for ((a, b), stated) in rows(&s).into_iter().zip(rows(&exact)).zip(&zoning.heat) {
        let error = (a - b).abs();
        assert!(stated[1] > error && stated[1] < 0.1 * a.abs(), "{a} {b}: estimate {}", stated[1]);
    }
}

#[test]
fn light_has_an_estimate_on_request() {
    let room = |n: usize, more: &str| {
        unit_room(
            &format!("patch_rule = \"voxels\"\nzone_basis = \"constant\"\n{more}"),
            "reflectance = 0.5\nfaces.x0 = { emission = [1, 2, 0] }",
            &format!(
                "[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [{n},{n},{n}]\nextinction = [0.5, 1, 2]\nalbedo = 0.7"
            ),
        )
    };
    let s = solved(&room(6, "discretization_error = true"));
    let exact = solved(&room(16, ""));
    assert_eq!(exact.report.discretization_error, None);
    let stated = &s.report.discretization_error.as_ref().unwrap().energy;
    let all = |s: &Solution| -> Vec<(String, Bands)> {
        let e = &s.report.energy;
        let mut out = e.absorbed_surfaces.clone();
        out.push(("medium".into(), e.absorbed_volumes));
        out
    };
    let mut estimates: Vec<Bands> = stated.absorbed_surfaces.iter().map(|x| x.1).collect();
    estimates.push(stated.absorbed_volumes);
    for (((name, a), (_, b)), stated) in all(&s).into_iter().zip(all(&exact)).zip(estimates) {
        for k in Band::all().take(2) {
            let error = (a[k] - b[k]).abs();
            assert!(
                stated[k] >= error && stated[k] <= 20.0 * error + 1e-5,
                "{name} {k:?}: {error:e}, {:e}",
                stated[k]
            );
        }
        // A dark band has no error.
        assert_eq!(stated.to_rgb()[2], 0.0);
    }
    // Relighting removes the estimate.
    let relit = zonal_solve::relight::relight(s, &[("room.x0".into(), Bands::splat(2.0))]).unwrap();
    assert_eq!(relit.report.discretization_error, None);
}

/// The discretization errors, and all diagnostics.
fn notes(text: &str) -> (Option<DiscretizationError>, String) {
    let s = solved(text);
    let mut notes = s.report.warnings;
    notes.extend(s.report.discretization_error.iter().flat_map(|z| z.notes.clone()));
    (s.report.discretization_error, notes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
}

const WALLS: &str = "temperature = 300\nemissivity = 0.5\nfaces.z0 = { temperature = 1000 }";

fn room(solve: &str, rest: &str) -> String {
    format!("mode = \"thermal\"\n{}", unit_room(solve, WALLS, rest))
}

fn gas(cells: &str, known: &str) -> String {
    format!("[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = {cells}\nextinction = 0.2\n{known}")
}

/// For each row, whether the errors of temperature and power are unknown.
fn unknown(z: &DiscretizationError) -> Vec<[bool; 2]> {
    z.heat.iter().map(|e| e.map(|x| x == f64::INFINITY)).collect()
}

fn stated(z: &Option<DiscretizationError>) -> &DiscretizationError {
    z.as_ref().unwrap()
}

#[test]
fn few_zones_are_estimated_by_smaller_ones() {
    let equilibrium = |cells: &str| gas(cells, "heat_source = 0");
    for (solve, cells) in [
        ("patch_size = 2", "[1,1,1]"),
        ("patch_size = 0.25", "[1,1,1]"),
        ("patch_rule = \"voxels\"", "[2,2,2]"),
    ] {
        let (z, message) = notes(&room(solve, &equilibrium(cells)));
        assert!(
            stated(&z).zones > 40
                && !message.contains("not known")
                && !stated(&z).heat.as_flattened().contains(&f64::INFINITY),
            "{message}"
        );
    }
    let (z, message) = notes(&room("patch_rule = \"voxels\"", &equilibrium("[6,6,6]")));
    assert!(stated(&z).zones == 6 * 9 + 27 && !message.contains("not known"), "{message}");
    // A gap of a tenth of the width of its patches.
    let gap = room("patch_size = 0.2", "").replace("max = [1,1,1]", "max = [1,1,0.02]");
    let (z, message) = notes(&gap);
    assert!(stated(&z).zones > 0 && message.contains("twice the gap"), "{message}");
}

#[test]
fn unknown_errors_are_infinite_and_reported() {
    let equilibrium = |cells: &str| gas(cells, "heat_source = 0");
    // Prescribed wall temperatures and a prescribed power of the medium have errors of 0.
    let (z, message) = notes(&room("patch_size = 0.09", &equilibrium("[1,1,1]")));
    assert!(message.contains("one cell across"), "{message}");
    assert_eq!(unknown(stated(&z))[..6], [[false, true]; 6]);
    assert!(unknown(stated(&z))[6][0]);
    // Walls of one patch are divided beside larger cells.
    let (z, message) = notes(&room("patch_size = 2", &equilibrium("[8,8,8]")));
    assert!(
        !message.contains("unknown") && unknown(stated(&z)).iter().all(|x| *x == [false; 2]),
        "{message}"
    );
    let (z, message) = notes(&room("patch_rule = \"voxels\"", &equilibrium("[2,14,14]")));
    assert!(stated(&z).zones > 0 && message.contains("multiplied by 10: zones are few"), "{message}");
    let (z, message) =
        notes(&room("patch_rule = \"voxels\"\ndiscretization_error = false", &equilibrium("[6,6,6]")));
    assert!(z.is_none() && message.is_empty(), "{message}");
}

/// Single triangles that are too many to be divided have unknown errors, which the other parts keep apart.
#[test]
fn unchanged_surface_is_named() {
    let speck = |k: usize| {
        let at = vec3(0.1 + 0.05 * (k % 16) as f64, 0.1 + 0.05 * (k / 16) as f64, 0.5);
        Plate::triangle(at, at + vec3(0.02, 0.0, 0.0), at + vec3(0.0, 0.02, 0.0))
    };
    let dust = (0..256).map(speck).collect();
    let s = common::solve(room_of_balls(
        "patch_size = 0.24\ntolerance = 0.1",
        "temperature = 1500\nemissivity = 1",
        dust,
        "",
    ));
    let z = stated(&s.report.discretization_error);
    let message = z.notes.iter().map(ToString::to_string).collect::<String>();
    assert!(message.contains("of the same size on balls, and"), "{message}");
    assert_eq!(unknown(z), [[[false; 2]; 6].to_vec(), vec![[false, true]]].concat());
}

#[test]
fn single_patch_among_many_has_an_estimate() {
    let lamp = "[[surface]]\nname = \"lamp\"\nrectangle = { origin = [0.4,0.4,0.5], edge1 = [0.05,0,0], edge2 = [0,0.05,0] }\ntemperature = 1500\nemissivity = 1\n";
    let (z, message) = notes(&room("patch_size = 0.09", lamp));
    // A third solve divides it.
    assert!(!message.contains("lamp") && unknown(stated(&z)).iter().all(|x| *x == [false; 2]), "{message}");
    assert!(stated(&z).heat[6][1] > 0.0, "{:?}", stated(&z).heat);
    let (z, message) =
        notes(&room("patch_size = 0.09", &lamp.replace("emissivity", "patch_size = 0.02\nemissivity")));
    assert!(!message.contains("lamp") && !unknown(stated(&z))[6][1], "{message}");
    // Smaller zones cover it where they are few.
    let (z, message) = notes(&room("patch_size = 0.2", lamp));
    assert!(stated(&z).zones > 600 && !message.contains("lamp") && !unknown(stated(&z))[6][1], "{message}");
}

/// The backscattered light of a lamp smaller than its cell has the same error for a lamp as direct light.
#[test]
fn small_lamp_has_equal_errors_as_surface_and_direct_light() {
    let stated = |light: &str| {
        let s = solved(&unit_room(
            "patch_size = 0.5\ndiscretization_error = true",
            "reflectance = 0.2",
            &format!(
                "[[surface]]\nname = \"lamp\"\nrectangle = {{ origin = [0.4,0.4,0.5], edge1 = [0.1,0,0], edge2 = [0,0.1,0] }}\nreflectance = 0.5\nemission = 100\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [2,2,2]\nextinction = 0.5\nalbedo = 0.8\n{light}"
            ),
        ));
        let errors = &s.report.discretization_error.as_ref().unwrap().energy.absorbed_surfaces;
        errors.iter().find(|e| e.0 == "lamp").unwrap().1.first()
    };
    let (surface, light) = (stated(""), stated("[[light]]\nkind = \"emitter\"\nsurface = \"lamp\"\n"));
    // Half of 0.4 1/m times 0.1 m, of 100 W/m² on 0.01 m², half of which is absorbed.
    assert!(surface > 0.009 && surface < 0.05, "{surface}");
    assert!((light / surface - 1.0).abs() < 0.5, "{light} against {surface}");
}

/// A lamp that is smaller than its cells along two axes, larger along the third: cells of its size return three times the light.
#[test]
fn lamps_in_flat_cells_are_within_the_estimate() {
    let by = |cells: &str, estimate: bool| {
        let s = solved(&unit_room(
            &format!("patch_size = 0.5\nengine = \"dense\"\ndiscretization_error = {estimate}"),
            "reflectance = 0",
            &format!(
                "[[surface]]\nname = \"lamp\"\nrectangle = {{ origin = [0.4,0.4,0.52], edge1 = [0.2,0,0], edge2 = [0,0.2,0] }}\nreflectance = 0\nemission = 100\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = {cells}\nextinction = 1\nalbedo = 0.95\n[[light]]\nkind = \"emitter\"\nsurface = \"lamp\"\n"
            ),
        ));
        let find = |list: &[(String, Bands)]| list.iter().find(|e| e.0 == "lamp").unwrap().1.first();
        let error = s.report.discretization_error.as_ref().map(|z| find(&z.energy.absorbed_surfaces));
        (find(&s.report.energy.absorbed_surfaces), error)
    };
    let (fine, _) = by("[8, 8, 16]", false);
    let (flat, stated) = by("[2, 2, 8]", true);
    assert!(fine > 1.5 * flat, "the scene is no good test: {flat} for {fine}");
    assert!(fine - flat <= stated.unwrap(), "{flat} ± {stated:?}, not {fine}");
}

/// A flame in a black, cold box: cells of one extinction with different temperatures, divided by `split`.
fn flame(cells: [usize; 3], split: usize, extinction: f64, albedo: f64, thick: &str) -> Scene {
    let dims = cells.map(|n| n * split);
    let text = format!(
        "mode = \"thermal\"\n[solve]\npatch_rule = \"voxels\"\nzone_basis = \"{thick}\"\nengine = \"spectral\"\n{}[[surface]]\nname = \"f\"\nroom = {{ min = [0,0,0], max = [2,2,4] }}\ntemperature = 300\nemissivity = 0.6\n[medium]\nmin = [0,0,0]\nmax = [2,2,4]\ncells = {dims:?}\nextinction = {extinction}\nalbedo = {albedo}\ntemperature = 500\n",
        if split > 1 { "discretization_error = false\n" } else { "" }
    );
    let mut parts = read(&text).into_parts();
    let map = parts.voxel_grid.as_mut().unwrap();
    for i in 0..map.len() {
        let c = map.coordinates(i);
        let p: Vec<f64> = (0..3).map(|k| ((c[k] / split) as f64 + 0.5) / cells[k] as f64).collect();
        let r2 = (p[0] - 0.5).powi(2) + (p[1] - 0.5).powi(2);
        let kelvin = 500.0 + 1300.0 * p[2] * (-8.0 * r2).exp();
        map.set_heat(
            i,
            zonal_scene::ThermalCondition::Temperature(kelvin),
            zonal_scene::ThermalCondition::Flux(0.0),
        );
    }
    parts.voxel_grid = Some(parts.voxel_grid.unwrap().seal().unwrap());
    Scene::new(parts).unwrap()
}

// Guards (numbers): the discretization error covers the difference to finer zones, also for odd numbers of cells.
/// Regression: rounding turned a uniform extinction into several in cells merged by odd numbers, so that no error was estimated.
#[test]
fn odd_cell_counts_of_temperatures_have_an_estimate() {
    let cases = [
        ([5, 5, 10], 0.5, 0.0, "auto"),
        ([7, 5, 11], 1.3, 0.3, "linear"),
        ([7, 5, 11], 0.7, 0.7, "constant"),
        ([1, 3, 5], 0.3, 0.2, "auto"),
    ];
    for (cells, extinction, albedo, thick) in sampled_cases(cases, &[0, 2, 3]) {
        let s = common::solve(flame(cells, 1, extinction, albedo, thick));
        let exact = common::solve(flame(
            cells,
            4,
            extinction,
            albedo,
            if thick == "constant" { thick } else { "linear" },
        ));
        assert!(
            s.report.warnings.is_empty() && exact.report.discretization_error.is_none(),
            "{:?}",
            s.report.warnings
        );
        let zoning = stated(&s.report.discretization_error);
        assert!(zoning.zones > 0 && zoning.notes.iter().all(|n| !n.is_warning()), "{:?}", zoning.notes);
        let rows = |s: &Solution| s.report.heat.as_ref().unwrap().rows.clone();
        for ((a, b), stated) in rows(&s).iter().zip(&rows(&exact)).zip(&zoning.heat) {
            let error = (a.power - b.power).abs();
            assert!(
                stated[1] >= error && stated[1].is_finite(),
                "{cells:?} {}: {error:e} {:e}",
                a.name,
                stated[1]
            );
            assert!(stated[1] > 0.0 && stated[0] == 0.0);
        }
    }
}

#[test]
fn one_cell_suffices_along_periodic_axes() {
    let slab = |periodic: &str, omit: &str| {
        format!(
            "mode = \"thermal\"\n[boundary]\n{periodic}\n{}",
            unit_room(
                "patch_rule = \"voxels\"",
                &format!("omit = {omit}\n{}", WALLS),
                &gas("[1,1,12]", "heat_source = 0")
            )
        )
    };
    let (z, message) = notes(&slab("x = \"periodic\"\ny = \"periodic\"", "[\"x0\", \"x1\", \"y0\", \"y1\"]"));
    assert!(stated(&z).ratio == 2.0 && message.is_empty(), "{message}");
    // Walls across y see several values along y; smaller cells resolve them.
    let (z, message) = notes(&slab("x = \"periodic\"", "[\"x0\", \"x1\"]"));
    assert!(stated(&z).zones > 12 * 3 && message.is_empty(), "{message}");
}

#[test]
fn prescribed_values_have_no_error() {
    // Prescribed temperatures of all walls and cells.
    let all =
        room("patch_size = 0.25\nengine = \"dense\"", &gas("[5,5,5]", "temperature = 700\nalbedo = 0.3"));
    let (z, _) = notes(&all);
    assert_eq!(stated(&z).heat.iter().filter(|e| e[0] != 0.0).count(), 0);
    assert!(stated(&z).heat.iter().all(|e| e[1] > 0.0));
    assert_eq!(stated(&z).energy.emitted, Bands::ZERO);
    // A source in a gas of known temperature: cells of both kinds cannot be merged.
    let source = "[[medium.region]]\nbox = { min = [0.2,0.2,0.2], max = [0.8,0.8,0.8] }\nextinction = 0.2\nheat_source = 1e5\n";
    let text = |cells: &str, known: &str, rule: &str| room(rule, &format!("{}\n{source}", gas(cells, known)));
    let (z, message) = notes(&text("[5,5,5]", "temperature = 700", "patch_size = 0.08"));
    assert!(
        message.contains("which cannot be merged") && unknown(stated(&z)).iter().all(|x| x[1]),
        "{message}"
    );
    let (z, message) = notes(&text("[7,7,7]", "temperature = 700", "patch_rule = \"voxels\""));
    assert!(message.contains("not known: cells of known temperature"), "{message}");
    assert!(stated(&z).zones == 0 && unknown(stated(&z)).iter().all(|x| x[1]), "{message}");
    let (z, message) = notes(&text("[5,5,5]", "temperature = 700", "patch_rule = \"voxels\""));
    assert!(stated(&z).zones > 1000 && message.is_empty(), "{message}");
    let (z, message) = notes(&text("[5,5,5]", "heat_source = 0", "patch_rule = \"voxels\""));
    assert!(stated(&z).zones > 0 && !message.contains("not known"), "{message}");
}

#[test]
fn scene_of_panes_alone_has_an_estimate() {
    let pane = "mode = \"thermal\"\n[solve]\npatch_size = 0.25\n[surroundings]\ntemperature = 300\n[[pane]]\nname = \"p\"\npolygon = [[0,0,0],[1,0,0],[1,1,0],[0,1,0]]\nthickness = 0.04\nextinction = 5\nalbedo = 0\ntemperature = 900\n";
    let (stated, message) = notes(pane);
    assert!(stated.is_some_and(|z| z.zones == 4 && z.ratio == 2.0), "{message}");
}

/// A ball of 8·4^`levels` triangles.
fn ball(centre: Vec3, radius: f64, levels: usize) -> Vec<Plate> {
    let [x, y, z] = [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)];
    let mut faces = vec![
        [x, y, z],
        [y, -x, z],
        [-x, -y, z],
        [-y, x, z],
        [y, x, -z],
        [-x, y, -z],
        [-y, -x, -z],
        [x, -y, -z],
    ];
    for _ in 0..levels {
        let middle = |a: Vec3, b: Vec3| ((a + b) * 0.5).normalized();
        let divided = |[a, b, c]: &[Vec3; 3]| {
            let (d, e, f) = (middle(*a, *b), middle(*b, *c), middle(*c, *a));
            [[*a, d, f], [*b, e, d], [*c, f, e], [d, e, f]]
        };
        faces = faces.iter().flat_map(divided).collect();
    }
    let at = |p: Vec3| centre + p * radius;
    faces.into_iter().map(|[a, b, c]| Plate::triangle(at(a), at(b), at(c))).collect()
}

/// A room with balls in the place of its last surface, which is `condition`.
fn room_of_balls(solve: &str, condition: &str, balls: Vec<Plate>, gas: &str) -> Scene {
    let surface = format!(
        "[[surface]]\nname = \"balls\"\nrectangle = {{ origin = [0.4,0.4,0.5], edge1 = [0.1,0,0], edge2 = [0,0.1,0] }}\n{condition}\n{gas}"
    );
    let mut parts = read(&room(solve, &surface)).into_parts();
    let last = parts.surfaces.len() - 1;
    parts.surfaces[last].solid = true;
    parts.facets.retain(|f| f.surface != last);
    parts.facets.extend(balls.into_iter().map(|plate| Facet { surface: last, plate, uv: [[0.0; 2]; 3] }));
    Scene::new(parts).unwrap()
}

/// Facets of a mesh that are patches cannot grow; their groups do, so that the errors of the balls, the walls and the gas have an estimate.
#[test]
fn fine_meshes_leave_no_error_unknown() {
    let centres = [[0.25, 0.25, 0.25], [0.75, 0.75, 0.25], [0.25, 0.75, 0.75], [0.75, 0.25, 0.75]];
    let balls = centres.into_iter().flat_map(|c| ball(Vec3::from_array(c), 0.15, 2)).collect();
    let gas = gas("[6,6,6]", "temperature = 900");
    let s = common::solve(room_of_balls(
        "patch_size = 0.1\ntolerance = 0.1",
        "temperature = 600\nemissivity = 0.7",
        balls,
        &gas,
    ));
    let z = stated(&s.report.discretization_error);
    assert!(unknown(z).iter().all(|x| *x == [false; 2]), "{:?} {:?}", z.heat, z.notes);
    assert!(z.heat.iter().all(|e| e[1] > 0.0) && z.notes.iter().all(|n| !n.is_warning()), "{:?}", z.notes);
    // The second solve has no more zones than the first.
    assert!(z.zones < s.zones.len(), "{} of {}", z.zones, s.zones.len());
}

/// The estimate of the groups of facets covers the error against divided facets.
#[test]
fn error_of_a_mesh_of_single_patches_is_within_the_estimate() {
    for condition in ["heat_flux = 0\nemissivity = 0.8", "temperature = 500\nemissivity = 0.3"] {
        let scene = |patch: f64, more: &str| {
            let facets = ball(vec3(0.4, 0.5, 0.3), 0.2, 1);
            let solve = format!("engine = \"dense\"\ntolerance = 1e-3\npatch_size = 0.16\n{more}");
            room_of_balls(&solve, &format!("{condition}\npatch_size = {patch}"), facets, "")
        };
        let s = common::solve(scene(0.2, ""));
        let exact = common::solve(
            scene(0.07, "discretization_error = false")
                .with_options(SolveOptions {
                    patch_size: Some(0.12),
                    ..scene(0.07, "discretization_error = false").options().clone()
                })
                .unwrap(),
        );
        let z = stated(&s.report.discretization_error);
        let rows = |s: &Solution| s.report.heat.as_ref().unwrap().rows.clone();
        for ((a, b), stated) in rows(&s).iter().zip(&rows(&exact)).zip(&z.heat) {
            let (error, noise) = ((a.power - b.power).abs(), a.power_error + b.power_error);
            assert!(stated[1].is_finite() && stated[1] + noise >= error, "{}: {error} {stated:?}", a.name);
            let (error, noise) = (
                (a.temperature.unwrap() - b.temperature.unwrap()).abs(),
                a.temperature_error.unwrap() + b.temperature_error.unwrap(),
            );
            let rounding = 1e-12 * a.temperature.unwrap();
            assert!(stated[0] + noise + rounding >= error, "{}: {error} K {stated:?}", a.name);
        }
    }
}

/// Single rectangles have no neighbours: a solve with these divided estimates their errors, and those of the other parts.
#[test]
fn parts_that_do_not_grow_are_divided() {
    let shelf = |k: usize| {
        format!(
            "[[surface]]\nname = \"shelf {k}\"\nrectangle = {{ origin = [0.2,0.2,{}], edge1 = [0.6,0,0], edge2 = [0,0.6,0] }}\nsides = \"both\"\npatch_size = 2\ntemperature = 700\nemissivity = 0.6\n",
            0.2 * k as f64
        )
    };
    let shelves: String = (1..4).map(shelf).collect();
    let (z, message) = notes(&room("patch_size = 0.12\ntolerance = 0.05", &shelves));
    assert!(unknown(stated(&z)).iter().all(|x| *x == [false; 2]), "{message}");
    assert!(!message.contains("unknown") && stated(&z).heat.iter().all(|e| e[1] > 0.0), "{message}");
}

/// Cells that neither absorb nor emit have no net power and no error of it.
#[test]
fn transparent_cells_leave_the_errors_of_the_medium_known() {
    let region =
        "[[medium.region]]\nbox = { min = [0,0,0.5], max = [1,1,1] }\nextinction = 2\ntemperature = 300\n";
    let clear = "[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [4,4,4]\n";
    let s =
        solved(&room("patch_rule = \"voxels\"\ndiscretization_error = false", &format!("{clear}{region}")));
    let medium = &s.report.heat.as_ref().unwrap().rows[6];
    assert!(medium.power_error.is_finite() && medium.power < 0.0, "{medium:?}");
}
