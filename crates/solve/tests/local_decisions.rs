//! What holds for a pair or a zone does not depend on other zones of the scene: exact factors, and losses that follow from them.

use crate::common;

use common::{read, solve, solved};
use std::f64::consts::PI;
use zonal_scene::{Band, NoProgress, Scene, Solution};
use zonal_solve::{SolveSettings, solve_with_settings};

/// A cloud that absorbs nothing, in surroundings of radiance 1: nothing of it can be seen.
fn furnace(medium: &str, rest: &str) -> String {
    format!(
        "[solve]\nengine = 'dense'\nzone_basis = 'constant'\nresidual = 1e-13\npatch_size = 0.5\n[surroundings]\nradiance = 1\n[medium]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\ncells = [4, 4, 4]\nalbedo = 1\n{medium}\n{rest}\n"
    )
}

fn rectangle(name: &str, origin: [f64; 3], edges: [[f64; 3]; 2]) -> String {
    let [a, b] = edges;
    format!(
        "[[surface]]\nname = '{name}'\nrectangle = {{ origin = {origin:?}, edge1 = {a:?}, edge2 = {b:?} }}\nreflectance = 1\nsides = 'both'\n"
    )
}

/// Largest relative distance of the fluence from 4π, and of the irradiance from π.
fn distance_from_uniform(s: &Solution) -> f64 {
    let n = s.zones.voxel_offset();
    let of = |(i, h): (usize, &zonal_scene::Bands)| {
        let exact = if i < n { PI } else { 4.0 * PI };
        h.iter().fold(0.0f64, |m, h| m.max((h / exact - 1.0).abs()))
    };
    s.fields.incident.iter().enumerate().map(of).fold(0.0, f64::max)
}

#[test]
fn surfaces_away_from_a_medium_leave_its_exact_factors() {
    let speck = rectangle("speck", [3.0, 3.0, 0.0], [[0.01, 0.0, 0.0], [0.0, 0.01, 0.0]]);
    let tilted = rectangle("tilted", [2.0, 0.2, 0.4], [[0.1, 0.1, 0.0], [0.0, 0.1, 0.2]]);
    let plate = rectangle("plate", [0.0, 0.0, -0.5], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    for extinction in [4.0, 100.0] {
        for outside in ["", &speck, &tilted, &plate] {
            let s = solved(&furnace(&format!("extinction = {extinction}"), outside));
            let off = distance_from_uniform(&s);
            assert!(off < 1e-9, "κ {extinction}, {outside}: {off}");
            assert!(s.fields.error.iter().all(|e| e.all(f64::is_finite)));
        }
    }
}

// Guards (numbers): the exact loss of a zone does not depend on other zones.
/// The spectral engine applies to the box, whatever lies beside it, and agrees with all pairs.
#[test]
fn patches_outside_a_box_have_rows_of_their_own() {
    let speck = rectangle("speck", [3.0, 3.0, 0.0], [[0.01, 0.0, 0.0], [0.0, 0.01, 0.0]]);
    let tilted = rectangle("tilted", [1.5, 0.2, 0.4], [[0.4, 0.4, 0.0], [0.0, 0.4, 0.5]]);
    let plate = rectangle("plate", [0.0, 0.0, -0.25], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let by =
        |engine: &str, text: &str| solved(&text.replace("engine = 'dense'", &format!("engine = '{engine}'")));
    for outside in [&speck, &tilted, &plate, &format!("{plate}{tilted}")] {
        let s = by("spectral", &furnace("extinction = 10", outside));
        assert!(distance_from_uniform(&s) < 1e-9 && s.report.engine == "spectral", "{outside}");
        let glowing =
            furnace("extinction = 2", &outside.replace("reflectance = 1", "reflectance = 0.3\nemission = 5"));
        let grey = glowing.replace("albedo = 1", "albedo = 0.6").replace("radiance = 1", "radiance = 0.1");
        let [a, b] = ["spectral", "dense"].map(|engine| by(engine, &grey));
        for i in 0..a.zones.len() {
            let off = (a.fields.incident[i] - b.fields.incident[i]).abs();
            let stated = 2.0 * (a.fields.error[i] + b.fields.error[i]);
            assert!((off - stated).all(|excess| excess <= 1e-9), "{outside}: zone {i}, {off:?} {stated:?}");
        }
    }
    // A surface with a black back that the cloud sees, and a lamp, are for other engines.
    let one_sided = plate
        .replace("sides = 'both'", "sides = 'front'")
        .replace("edge1 = [1.0, 0.0, 0.0]", "edge1 = [-1.0, 0.0, 0.0]");
    let scene = furnace("extinction = 10", &one_sided).replace("engine = 'dense'", "engine = 'spectral'");
    let message =
        solve_with_settings(read(&scene), &SolveSettings::new(4 << 30, &NoProgress)).unwrap_err().to_string();
    assert!(message.contains("see the back of 'plate'"), "{message}");
}

/// Rows of sampled factors close too: a cloud of two densities, and a sheet within it.
#[test]
fn sampled_rows_of_a_white_cloud_close() {
    let sheet = rectangle("sheet", [0.3, 0.3, 0.4], [[0.5, 0.0, 0.0], [0.0, 0.3, 0.1]]);
    let half = "extinction = 3\n[[medium.region]]\nbox = { min = [0, 0, 0], max = [0.5, 1, 1] }\nextinction = 30\nalbedo = 1\n";
    for text in [furnace("extinction = 30", &sheet), furnace(half, "")] {
        let s = solved(&text);
        let closure = &s.report.closure;
        assert!(closure.restored && closure.worst.first() > 1e-4, "{closure:?}");
        let off = distance_from_uniform(&s);
        assert!(off < 1e-8, "{off}");
    }
}

// Guards (numbers): the exact loss of a zone does not depend on other zones.
/// A black gauge parallel to a black plate: its exchange with the plate is proved, and the rest of its row goes to the surroundings.
#[test]
fn losses_follow_from_exact_rows() {
    let scene = |extra: &str| {
        read(&format!(
            "mode = 'thermal'\n[solve]\ndiscretization_error = false\n{extra}\n[[surface]]\nname = 'hot'\nrectangle = {{ origin = [0, 0, 0], edge1 = [2, 0, 0], edge2 = [0, 2, 0] }}\nemissivity = 1\ntemperature = 1000\n[[surface]]\nname = 'gauge'\nrectangle = {{ origin = [1, 1, 1.5], edge1 = [0, 0.05, 0], edge2 = [0.05, 0, 0] }}\nemissivity = 1\ntemperature = 300\n"
        ))
    };
    for extra in ["", "tolerance = 1e-3", "closure = 'measure'"] {
        let s = solve(scene(extra));
        let row = &s.report.heat.as_ref().unwrap().rows[1];
        let (flux, error) = (row.over_size(row.power), row.over_size(row.power_error));
        assert!((flux + 19810.538).abs() < 0.01, "{extra}: {flux}");
        assert!(extra.contains("measure") || error < 1.0, "{extra}: {error}");
    }
}

/// Loss and creation of power in every scattering of a white medium are part of the stated errors where closure is measured only.
#[test]
fn amplified_defects_are_stated() {
    let sheet = rectangle("sheet", [0.3, 0.3, 0.4], [[0.5, 0.0, 0.0], [0.0, 0.3, 0.1]]);
    for extinction in [1.0, 10.0, 100.0] {
        let text = furnace(&format!("extinction = {extinction}"), &sheet);
        let s = solved(&text.replace("[solve]\n", "[solve]\nclosure = 'measure'\n"));
        let n = s.zones.voxel_offset();
        for (i, (h, e)) in s.fields.incident.iter().zip(&s.fields.error).enumerate() {
            let exact = if i < n { PI } else { 4.0 * PI };
            // Errors of zones are estimates: twice the stated one is covered.
            assert!(
                (h.first() - exact).abs() <= 2.0 * e.first() + 1e-9,
                "κ {extinction}, zone {i}: {h:?} ± {e:?}"
            );
        }
    }
}

/// Light that crosses smoke of white cells of two optical depths: 0.4003 ± 0.0035 W arrive at the ceiling.
#[test]
fn light_across_thick_cells_has_a_stated_error() {
    let text = "[solve]\npatch_size = 0.5\ntolerance = 0.05\n[[surface]]\nname = 'room'\nroom = { min = [0, 0, 0], max = [4, 3, 3] }\nreflectance = 0.5\nemission = 0\nfaces = { z0 = { emission = 1 } }\n[medium]\nmin = [0, 0, 1.5]\nmax = [4, 3, 3]\ncells = [16, 12, 6]\nextinction = 8\nalbedo = 1\n";
    for engine in ["rays", "auto"] {
        let s = solved(&text.replace("[solve]\n", &format!("[solve]\nengine = '{engine}'\n")));
        let rows = &s.report.energy.absorbed_surfaces;
        let k = rows.iter().position(|r| r.0.contains("z1")).expect("the ceiling");
        let zoning = s.report.discretization_error.as_ref().expect("cells are thick");
        let error = s.report.energy_error.absorbed_surfaces[k].1.first()
            + zoning.energy.absorbed_surfaces[k].1.first();
        let power = rows[k].1.first();
        assert!((power - 0.4003).abs() < error && error < power, "{engine}: {power} ± {error}");
        // No advice that this scene cannot follow.
        assert!(s.report.warnings.iter().all(|w| !w.text.contains("linear")), "{:?}", s.report.warnings);
    }
}

fn by_threads(scene: &Scene, threads: usize) -> Vec<u64> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let s = pool
        .install(|| solve_with_settings(scene.clone(), &SolveSettings::new(4 << 30, &NoProgress)).unwrap());
    s.fields.incident.iter().chain(&s.fields.error).map(|h| h[Band::first()].to_bits()).collect()
}

#[test]
fn threads_do_not_change_a_bit_of_closed_rows() {
    let sheet = rectangle("sheet", [0.3, 0.3, 0.4], [[0.5, 0.0, 0.0], [0.0, 0.3, 0.1]]);
    let scene = read(&furnace("extinction = 10", &sheet));
    assert_eq!(by_threads(&scene, 1), by_threads(&scene, 3));
}
