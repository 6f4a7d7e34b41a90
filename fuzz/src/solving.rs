//! Small scenes solved, drawn, packed, written and read back. Fields must be finite, errors at least 0 or unknown (infinite), and
//! pixels not negative.

use super::drawing::{MAX_ZONES, draw, is_small, pack};
use super::{files, scenes};
use std::sync::atomic::{AtomicUsize, Ordering};
use zonal_io::output;
use zonal_scene::{Bands, NoProgress, Scene, Solution, ZoneValues};

/// Most zones of a scene that is always solved; of larger scenes one in [`SLOW_SCENE_INTERVAL`] is solved.
const MAX_ZONES_ALWAYS_SOLVED: usize = 48;
/// Most zones of a scene with occlusion, whose pairs are sampled.
const MAX_ZONES_WITH_OCCLUSION: usize = 32;
/// Optical depth of the diagonal above which a scene is slow, because factors between its boxes take long.
const MAX_FAST_DEPTH: f64 = 1e3;
/// One in this number of slow scenes is solved: optically deep ones, those with radiating surroundings behind facets, and those with
/// a second solve for the discretization error. Each takes seconds.
const SLOW_SCENE_INTERVAL: usize = 32;
/// Number of scenes solved and drawn.
static SOLVED_SCENES: AtomicUsize = AtomicUsize::new(0);
/// Number of solved scenes after which their count is printed.
const REPORT_INTERVAL: usize = 1000;
/// Smallest tolerance of a solve.
const MIN_TOLERANCE: f64 = 0.2;
/// Facets of a room.
const ROOM_FACETS: usize = 6;
/// Memory limit of a solve, bytes.
const MEMORY_LIMIT: u64 = 256 << 20;

/// Target: a scene that [`scenes`] generates from bytes, with its files.
pub fn solve(data: &[u8]) {
    let (text, in_memory) = scenes::scene_text(data);
    if let Some(scene) = files::read_scene(text.as_bytes(), &in_memory) {
        solve_and_draw(scene, text.len());
    }
}

/// Target: the text of a scene.
pub fn solve_toml(data: &[u8]) {
    if let Some(scene) = files::read_with_fixtures(data) {
        solve_and_draw(scene, data.len());
    }
}

/// Optical depth of the scene's diagonal.
fn diagonal_depth(scene: &Scene) -> f64 {
    let cells = scene.voxel_grid().into_iter().flat_map(|m| (0..m.len()).flat_map(|c| m.extinction(c)));
    scene.diagonal() * cells.fold(0.0, f64::max)
}

/// The scene with coarse zones and a low accuracy; `None` where it remains large, or is slow and not selected by `turn`.
fn coarsened(scene: Scene, turn: usize) -> Option<Scene> {
    if !is_small(&scene) {
        return None;
    }
    let occluded = scene.facets().len() > ROOM_FACETS || !scene.panes().is_empty();
    let slow = occluded && scene.surroundings().has_radiance() || diagonal_depth(&scene) > MAX_FAST_DEPTH;
    if slow && !turn.is_multiple_of(SLOW_SCENE_INTERVAL) {
        return None;
    }
    let size = scene.diagonal() / 2.0;
    if !(size > 0.0 && size.is_finite()) {
        return None;
    }
    let mut parts = scene.into_parts();
    parts.options.patch_size = Some(parts.options.patch_size.map_or(size, |p| p.max(size)));
    parts.surfaces.iter_mut().for_each(|s| s.patch_size = s.patch_size.map(|p| p.max(size)));
    parts.options.tolerance = parts.options.tolerance.max(MIN_TOLERANCE);
    parts.options.max_iterations = parts.options.max_iterations.min(100);
    parts.options.scattering_orders = parts.options.scattering_orders.map(|n| n.min(20));
    let scene = Scene::new(parts).ok()?;
    let transport = zonal_transport::Transport::new(&scene);
    let zones = zonal_transport::build_zones(&scene, &transport).ok()?;
    drop(transport);
    let max_zones = if occluded { MAX_ZONES_WITH_OCCLUSION } else { MAX_ZONES };
    if zones.len() > max_zones
        || zones.len() > MAX_ZONES_ALWAYS_SOLVED && !turn.is_multiple_of(SLOW_SCENE_INTERVAL)
    {
        return None;
    }
    if !turn.is_multiple_of(SLOW_SCENE_INTERVAL) {
        let mut parts = scene.into_parts();
        parts.options.discretization_error = Some(false);
        return Scene::new(parts).ok();
    }
    Some(scene)
}

fn assert_finite(what: &str, list: &[Bands]) {
    if let Some(x) = list.iter().flatten().find(|x| !x.is_finite()) {
        panic!("{what} is {x}");
    }
}

fn assert_errors(what: &str, list: &[Bands]) {
    if let Some(x) = list.iter().flatten().find(|x| x.is_nan() || **x < 0.0) {
        panic!("the {what} is {x}");
    }
}

/// Checks that fields are finite, temperatures not negative, and errors at least 0.
fn check_fields(solution: &Solution) {
    let f = &solution.fields;
    assert_finite("radiosity", &f.radiosity);
    assert_finite("incident", &f.incident);
    assert_finite("direct", &f.direct);
    assert_errors("error", &f.error);
    assert_errors("error of the surroundings", &f.surroundings_error);
    for g in &solution.groups {
        for values in [&g.incident, &g.direct] {
            let sound = match values {
                ZoneValues::Double(list) => list.iter().flatten().all(|x| x.is_finite()),
                ZoneValues::Single(list) => list.iter().flatten().all(|x| x.is_finite()),
            };
            assert!(sound, "light group '{}' is not finite", g.name);
        }
    }
    if let Some(h) = &f.heat {
        for (t, e) in h.temperature.iter().zip(&h.temperature_error) {
            assert!(t.is_nan() || *t >= 0.0 && t.is_finite(), "a temperature is {t}");
            assert!(t.is_nan() || *e >= 0.0, "the error of a temperature is {e}");
        }
        for (q, e) in h.net.iter().zip(&h.net_error) {
            assert!(q.is_finite() && *e >= 0.0, "a net power is {q} ± {e}");
        }
    }
}

/// Solves and checks a scene; `turn`, a number of the input, selects the slow scenes that are solved.
fn solve_and_draw(scene: Scene, turn: usize) {
    let packed = turn.is_multiple_of(16);
    // The replay of findings solves all scenes.
    let turn = if cfg!(test) { 0 } else { turn };
    let Some(scene) = coarsened(scene, turn) else { return };
    let Ok(solution) = zonal_solve::solve(scene, MEMORY_LIMIT, &NoProgress) else { return };
    check_fields(&solution);
    // Write and read back, then draw.
    let bytes = output::solution_bytes(&solution).expect("writing to memory succeeds");
    match output::read_solution_from_bytes(&bytes) {
        Ok(back) => assert_eq!(
            format!("{:?}", back.fields),
            format!("{:?}", solution.fields),
            "the file holds a different solution"
        ),
        Err(e) => panic!("the written file is refused: {e}"),
    }
    let light = solution.scene.thermal().is_none();
    let drawn = draw(&solution);
    if packed {
        pack(&solution);
    }
    let n = SOLVED_SCENES.fetch_add(1, Ordering::Relaxed) + 1;
    if n.is_multiple_of(REPORT_INTERVAL) {
        eprintln!("{n} scenes solved and drawn");
    }
    let bad = drawn.iter().flatten().flatten().find(|x| !(x.is_finite() && **x >= 0.0));
    assert!(!light || bad.is_none(), "a pixel is {bad:?}");
}
