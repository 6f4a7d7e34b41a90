//! A scene solved, drawn, packed, written and read back, at tiny size. What comes out has to be finite, errors from 0 on or unknown
//! (infinite), and no pixel negative.

use super::{readers, scenes};
use std::sync::atomic::{AtomicUsize, Ordering};
use zonal::io::output;
use zonal::render::{RenderOptions, ZonesSeen, render};
use zonal::scene::{Bands, Camera, Lens, Quiet, Scene, Solution, Values};
use zonal::viewer::package::{Detail, package};

/// The most zones that are solved, and that a solution from a file may have to be used.
const ZONES: usize = 160;
/// The most zones of a scene that is solved whenever it comes; larger ones are one in [`ONE_IN`].
const ZONES_OFTEN: usize = 48;
/// The most zones where facets or panes stand in each other's way: their pairs are sampled.
const ZONES_BEHIND: usize = 32;
/// A scene of more optical depths than this is deep: factors between its boxes take long.
const LARGEST_DEPTH: f64 = 1e3;
/// Of scenes one in so many has its second solve where it asks for it, and of deep ones and those with shining surroundings behind facets one in so
/// many is solved at all: all of these take seconds.
const ONE_IN: usize = 32;
/// The number of scenes that were solved and drawn; it is printed after every COUNT_EVERY of them.
static DONE: AtomicUsize = AtomicUsize::new(0);
const COUNT_EVERY: usize = 1000;
/// The smallest tolerance.
const TOLERANCE: f64 = 0.2;
/// The most zones that are packed for the viewer.
const ZONES_PACKED: usize = 24;
/// The facets of a room.
const ROOM: usize = 6;
/// The most facets, panes' plates and voxels of a scene.
const PARTS: usize = 64;
/// The most direct lights.
const LIGHTS: usize = 4;
/// Bytes that a solve may take.
const MEMORY: u64 = 256 << 20;

/// A scene that [`scenes`] writes from bytes, with its own files beside it.
pub fn solve(data: &[u8]) {
    let (text, files) = scenes::text(data);
    if let Some(scene) = readers::read(text.as_bytes(), &files) {
        solve_and_draw(scene, text.len());
    }
}

/// A scene's text as it is.
pub fn solve_toml(data: &[u8]) {
    if let Some(scene) = readers::read_with_fixtures(data) {
        solve_and_draw(scene, data.len());
    }
}

fn tiny(scene: &Scene) -> bool {
    scene.facets().len() <= PARTS
        && scene.panes().iter().map(|p| p.plates.len()).sum::<usize>() <= PARTS
        && scene.voxmap().is_none_or(|v| v.len() <= PARTS)
        && scene.lights().len() <= LIGHTS
}

/// The scene's diagonal in optical depths.
fn depth(scene: &Scene) -> f64 {
    let cells = scene.voxmap().into_iter().flat_map(|m| (0..m.len()).flat_map(|c| m.extinction(c)));
    scene.diagonal() * cells.fold(0.0, f64::max)
}

/// The same scene with zones no smaller than a half of it, and content with little; none where it stays large, or takes long and its turn has not come.
fn coarse(scene: Scene, turn: usize) -> Option<Scene> {
    if !tiny(&scene) {
        return None;
    }
    let behind = scene.facets().len() > ROOM || !scene.panes().is_empty();
    let slow = behind && scene.surroundings().shine() || depth(&scene) > LARGEST_DEPTH;
    if slow && !turn.is_multiple_of(ONE_IN) {
        return None;
    }
    let size = scene.diagonal() / 2.0;
    if !(size > 0.0 && size.is_finite()) {
        return None;
    }
    let mut parts = scene.into_parts();
    parts.options.patch_size = Some(parts.options.patch_size.map_or(size, |p| p.max(size)));
    parts.surfaces.iter_mut().for_each(|s| s.patch_size = s.patch_size.map(|p| p.max(size)));
    parts.options.tolerance = parts.options.tolerance.max(TOLERANCE);
    parts.options.max_iterations = parts.options.max_iterations.min(100);
    parts.options.sweeps = parts.options.sweeps.map(|n| n.min(20));
    let scene = Scene::new(parts).ok()?;
    let transport = zonal::transport::Transport::new(&scene);
    let zones = zonal::transport::build_zones(&scene, &transport).ok()?;
    drop(transport);
    let most = if behind { ZONES_BEHIND } else { ZONES };
    if zones.len() > most || zones.len() > ZONES_OFTEN && !turn.is_multiple_of(ONE_IN) {
        return None;
    }
    if !turn.is_multiple_of(ONE_IN) {
        let mut parts = scene.into_parts();
        parts.options.zoning_error = Some(false);
        return Scene::new(parts).ok();
    }
    Some(scene)
}

fn finite(what: &str, list: &[Bands]) {
    if let Some(x) = list.as_flattened().iter().find(|x| !x.is_finite()) {
        panic!("{what} is {x}");
    }
}

fn errors(what: &str, list: &[Bands]) {
    if let Some(x) = list.as_flattened().iter().find(|x| x.is_nan() || **x < 0.0) {
        panic!("the {what} is {x}");
    }
}

/// `turn`: a number of the input, by which some scenes are spared what takes long.
fn solve_and_draw(scene: Scene, turn: usize) {
    let packed = turn.is_multiple_of(16);
    // The replay of what was found spares nothing.
    let turn = if cfg!(test) { 0 } else { turn };
    let Some(scene) = coarse(scene, turn) else { return };
    let Ok(solution) = zonal::solve::solve(scene, MEMORY, &Quiet) else { return };
    let f = &solution.fields;
    finite("radiosity", &f.radiosity);
    finite("incident", &f.incident);
    finite("direct", &f.direct);
    errors("error", &f.error);
    errors("error of the surroundings", &f.surroundings_error);
    for g in &solution.groups {
        for values in [&g.incident, &g.direct] {
            let sound = match values {
                Values::Double(list) => list.as_flattened().iter().all(|x| x.is_finite()),
                Values::Single(list) => list.as_flattened().iter().all(|x| x.is_finite()),
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
    let bytes = output::solution_bytes(&solution).expect("memory takes all");
    match output::read_solution_from_bytes(&bytes) {
        Ok(back) => assert_eq!(
            format!("{:?}", back.fields),
            format!("{:?}", solution.fields),
            "the file holds another solution"
        ),
        Err(e) => panic!("our own file is refused: {e}"),
    }
    let light = solution.scene.thermal().is_none();
    let drawn = draw(&solution);
    if packed {
        pack(&solution);
    }
    let n = DONE.fetch_add(1, Ordering::Relaxed) + 1;
    if n.is_multiple_of(COUNT_EVERY) {
        eprintln!("{n} scenes solved and drawn");
    }
    let bad = drawn.iter().flatten().flatten().find(|x| !(x.is_finite() && **x >= 0.0));
    assert!(!light || bad.is_none(), "a pixel is {bad:?}");
}

/// Some cameras of the scene, or one in its middle.
fn cameras(scene: &Scene) -> Vec<Camera> {
    let mut cameras: Vec<Camera> = scene.cameras().iter().take(2).cloned().collect();
    if cameras.is_empty() {
        let (lo, hi) = scene.bounds();
        cameras.push(Camera {
            name: "middle".into(),
            origin: lo * 0.4 + hi * 0.6,
            target: hi,
            up: zonal::math::vec3(0.0, 0.1, 1.0),
            fov: 70.0,
            lens: Lens::default(),
        });
    }
    cameras.retain(|c| c.check().is_ok());
    cameras
}

/// Everything that only reads a solution.
fn draw(solution: &Solution) -> Vec<Vec<[f32; 3]>> {
    zonal::table::report(solution);
    zonal::table::groups(solution);
    output::report_json(solution).to_string();
    let mut out = Vec::new();
    for (i, camera) in cameras(&solution.scene).iter().enumerate() {
        let options = RenderOptions { width: 3, height: 2, samples: i, light_samples: 1, gather: 2 * i };
        out.push(render(solution, camera, &options, &Quiet).pixels);
        let mut seen = ZonesSeen::new(solution, camera, (3, 2), true);
        if solution.scene.voxmap().is_some() {
            seen = seen.sliced(i, solution.scene.bounds().0.z);
        }
        seen.zones(&Quiet);
    }
    out
}

/// The viewer's package, of few zones.
fn pack(solution: &Solution) {
    if solution.zones.len() <= ZONES_PACKED {
        let _ = package(solution, &Detail { vertices: 200 }, &Quiet);
    }
}

/// A solution from a file of anyone's: drawn, relit, and packed for the viewer where that is wanted.
pub fn use_solution(solution: Solution, packed: bool) {
    let s = &solution.scene;
    let size = s.diagonal();
    if solution.zones.len() > ZONES || !tiny(s) || !(size > 1e-6 && size < 1e6) {
        return;
    }
    draw(&solution);
    if packed {
        pack(&solution);
    }
    if let Some(name) = solution.groups.first().map(|g| g.name.clone())
        && let Ok(relit) = zonal::solve::relight::relight(solution, &[(name, [0.5, 2.0, 0.0])])
    {
        let _ = output::solution_bytes(&relit);
    }
}
