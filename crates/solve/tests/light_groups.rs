//! Light groups, relighting and checkpoints: groups add up to the solution, a relit solution is that of the relit scene, saved factors equal new ones,
//! and an interrupted solve is bit-identical.

use crate::common;

use common::{read, solve};
use std::collections::HashMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use zonal_reference::test_cases::sampled_cases;
use zonal_scene::{
    Band, Bands, CheckpointStore, Engine, NoProgress, PerBand, Scene, Solution, SolveOptions, SolveStatus,
    ZoneValues,
};
use zonal_solve::relight::{relight, with_surface_colors};
use zonal_solve::{SolveSettings, solve_with_settings};

/// Sun through an opening, a lamp as direct light, an emitting wall, an emitting medium and pane, and the sky.
const ROOM: &str = "
[solve]
patch_size = 0.5
residual = 1e-12
tolerance = 0.05
engine = 'dense'
[[surface]]
name = 'floor'
rectangle = { origin = [0,0,0], edge1 = [1,0,0], edge2 = [0,1,0] }
reflectance = [0.7, 0.4, 0.1]
[[surface]]
name = 'wall'
rectangle = { origin = [0,0,0], edge1 = [0,1,0], edge2 = [0,0,1] }
reflectance = 0.8
emission = [0, 2, 1]
[[surface]]
name = 'lamp'
rectangle = { origin = [0.9,0.4,0.8], edge1 = [0,0,0.1], edge2 = [0,0.2,0] }
emission = 100
[[pane]]
name = 'glass'
polygon = [[0.5,0.2,0.6], [0.9,0.2,0.6], [0.9,0.8,0.6]]
thickness = 0.01
extinction = [10, 20, 30]
albedo = 0.5
emission = 3
[medium]
min = [0,0,0]
max = [1,1,1]
cells = [2,2,2]
extinction = [0.5, 1, 2]
albedo = 0.6
emission = 0.4
[[light]]
name = 'sun'
kind = 'sun'
direction = [0.3, 0.2, -1]
irradiance = [30, 20, 10]
[[light]]
kind = 'emitter'
surface = 'lamp'
[surroundings]
radiance = 0.1
";

const NAMES: [&str; 6] = ["sun", "lamp", "wall", "medium", "panes", "surroundings"];

fn with(scene: Scene, change: impl FnOnce(&mut SolveOptions)) -> Scene {
    let mut o = scene.options().clone();
    change(&mut o);
    scene.with_options(o).unwrap()
}

/// Largest difference of two fields, relative to the largest value of the second.
fn off(x: &[Bands], y: &[Bands]) -> f64 {
    let most = y.iter().flatten().fold(0.0f64, |m, y| m.max(y.abs()));
    let worst = x.iter().flatten().zip(y.iter().flatten()).fold(0.0f64, |w, (x, y)| w.max((x - y).abs()));
    if most > 0.0 { worst / most } else { worst }
}

/// Largest difference of all fields but the errors.
fn light_apart(a: &Solution, b: &Solution) -> f64 {
    let (f, g) = (&a.fields, &b.fields);
    [(&f.radiosity, &g.radiosity), (&f.incident, &g.incident), (&f.direct, &g.direct)]
        .into_iter()
        .fold(0.0, |w, (x, y)| w.max(off(x, y)))
}

/// Largest difference of all fields.
fn apart(a: &Solution, b: &Solution) -> f64 {
    light_apart(a, b).max(off(&a.fields.error, &b.fields.error))
}

fn powers(s: &Solution) -> Vec<f64> {
    let e = &s.report.energy;
    let mut all = vec![
        e.emitted,
        e.incoming,
        e.absorbed_volumes,
        e.absorbed_panes,
        e.escaped,
        e.absorbed_backfaces,
        e.residual,
    ];
    all.extend(e.absorbed_surfaces.iter().map(|a| a.1));
    all.into_iter().flatten().collect()
}

// Guards (numbers): a relit solution equals the solution of the relit scene.
#[test]
fn relit_solution_equals_solution_of_the_relit_scene() {
    // The zoning error of the given light is that of the first solution; with a second solve there is none in the fields.
    let s = solve(with(read(ROOM), |o| o.discretization_error = Some(true)));
    assert_eq!(s.groups.iter().map(|g| g.name.as_str()).collect::<Vec<_>>(), NAMES);
    // Factors of 1 are bit-identical.
    let same = relight(s.clone(), &[]).unwrap();
    assert_eq!(same.fields.incident, s.fields.incident);
    assert_eq!(same.report.energy, s.report.energy);
    let factors = [[0.2; 3], [3.0; 3], [1.0, 0.0, 2.5], [0.5; 3], [0.0; 3], [7.0; 3]].map(Bands::from_rgb);
    let wanted: Vec<(String, Bands)> = NAMES.iter().map(|n| n.to_string()).zip(factors).collect();
    let relit = relight(s.clone(), &wanted).unwrap();
    let fresh = solve(relit.scene.clone());
    let off = apart(&relit, &fresh);
    assert!(off < 1e-9, "{off:e}");
    for (x, y) in powers(&relit).iter().zip(powers(&fresh)) {
        assert!((x - y).abs() < 1e-9 * relit.report.energy.incoming.first().max(1.0), "{x} {y}");
    }
    assert_eq!(relit.zones, fresh.zones);
    let e = relit.report.estimate.patches.first() / fresh.report.estimate.patches.first();
    assert!((e - 1.0).abs() < 1e-9, "{e}");
    // Successive relighting equals relighting at once, and extinguished groups cannot be relit.
    let twice = relight(relight(s, &wanted[..3]).unwrap(), &wanted[3..]).unwrap();
    assert!(apart(&twice, &relit) < 1e-14);
    let message = relight(relit, &[("panes".into(), Bands::splat(2.0))]).unwrap_err().to_string();
    assert!(message.contains("scaled to zero"), "{message}");
}

/// Links are refined for the given light, so the solutions agree within the tolerance, not bit by bit.
#[test]
fn relit_rays_solution_agrees_within_the_tolerance() {
    let tolerance = 0.05;
    let scene = with(read(ROOM), |o| {
        o.engine = Engine::Rays;
        o.tolerance = tolerance;
        o.patch_size = Some(0.25);
    });
    let s = solve(scene);
    assert_eq!(s.report.engine, "rays");
    assert!(s.groups.iter().all(|g| matches!(g.incident, ZoneValues::Single(_))));
    let same = relight(s.clone(), &[]).unwrap();
    assert!(apart(&same, &s) < 1e-6, "{}", apart(&same, &s));
    let wanted = [("sun", 0.2), ("lamp", 3.0), ("wall", 2.0)].map(|(n, f)| (n.to_string(), Bands::splat(f)));
    let relit = relight(s, &wanted).unwrap();
    let fresh = solve(relit.scene.clone());
    let patches = fresh.zones.voxel_offset();
    for part in [0..patches, patches..fresh.zones.len()] {
        let [x, y] = [&relit, &fresh].map(|s| &s.fields.incident[part.clone()]);
        let off: f64 = x.iter().flatten().zip(y.iter().flatten()).map(|(x, y)| (x - y) * (x - y)).sum();
        let off = (off / y.iter().flatten().map(|y| y * y).sum::<f64>()).sqrt();
        assert!(off <= tolerance, "{off} {part:?} {patches}");
    }
}

#[test]
fn unknown_group_is_refused_with_a_list_of_groups() {
    let s = solve(read(ROOM));
    let message = |list: &[(&str, f64)]| {
        let list: Vec<(String, Bands)> =
            list.iter().map(|(n, f)| (n.to_string(), Bands::splat(*f))).collect();
        relight(s.clone(), &list).unwrap_err().to_string()
    };
    assert!(
        message(&[("moon", 1.0)]).contains("moon") && message(&[("moon", 1.0)]).contains(&NAMES.join(", "))
    );
    assert!(message(&[("sun", 1.0), ("sun", 2.0)]).contains("two factors"));
    assert!(message(&[("sun", -1.0)]).contains("from 0") && message(&[("sun", f64::NAN)]).contains("from 0"));
    let merged = solve(with(read(ROOM), |o| o.light_grouping = zonal_scene::LightGrouping::All));
    assert_eq!(merged.groups.iter().map(|g| g.name.as_str()).collect::<Vec<_>>(), ["all"]);
    assert!(light_apart(&merged, &s) < 1e-9);
    // The errors of the groups add up as if they had one sign.
    // The residual of the balance is distributed over the zones, so that single zones may have a slightly larger error.
    for (m, e) in merged.fields.error.iter().flatten().zip(s.fields.error.iter().flatten()) {
        assert!(*m <= 1.6 * e && *m >= 0.3 * e, "{m} {e}");
    }
    let dim = relight(merged, &[("all".into(), Bands::splat(0.5))]).unwrap();
    let want = powers(&s);
    let n = want.len();
    // The residual is not a power.
    for (k, (x, y)) in powers(&dim).iter().zip(&want).enumerate().filter(|(k, _)| !(18..21).contains(k)) {
        assert!((x - 0.5 * y).abs() < 1e-9 * y.abs().max(1.0), "{k} of {n}: {x} {y}");
    }
    assert!(apart(&dim, &solve(dim.scene.clone())) < 1e-9);
}

/// A store in memory that panics at save number `last`.
#[derive(Default)]
struct Memory {
    stages: Mutex<HashMap<String, Vec<u8>>>,
    saves: Mutex<Vec<String>>,
    left: AtomicUsize,
    loads: AtomicUsize,
}

impl CheckpointStore for Memory {
    fn load(&self, stage: &str) -> Option<Vec<u8>> {
        let found = self.stages.lock().unwrap().get(stage).cloned();
        self.loads.fetch_add(found.is_some() as usize, Ordering::Relaxed);
        found
    }
    fn save(&self, stage: &str, bytes: &[u8]) {
        let left = self.left.load(Ordering::Relaxed);
        assert!(left > 0, "killed");
        self.left.store(left - 1, Ordering::Relaxed);
        self.saves.lock().unwrap().push(stage.into());
        self.stages.lock().unwrap().insert(stage.into(), bytes.to_vec());
    }
}

fn run(scene: &Scene, vault: &dyn CheckpointStore) -> Solution {
    solve_with_settings(
        scene.clone(),
        &SolveSettings { checkpoints: vault, ..SolveSettings::new(4 << 30, &NoProgress) },
    )
    .unwrap()
}

/// Solves with an interruption after every `stages` saved stages, at least `least` times; the result must equal `straight`.
fn broken_off(scene: &Scene, stages: usize, least: usize, straight: &Solution) -> Memory {
    let vault = Memory::default();
    // One thread, so that a panic ends the solve.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut deaths = 0;
    let resumed = loop {
        vault.left.store(stages, Ordering::Relaxed);
        let once = || pool.install(|| run(scene, &vault));
        match std::panic::catch_unwind(std::panic::AssertUnwindSafe(once)) {
            Ok(s) => break s,
            Err(_) => deaths += 1,
        }
    };
    assert!(deaths >= least, "{deaths}");
    assert_eq!(resumed.fields, straight.fields);
    assert_eq!(resumed.groups, straight.groups);
    assert_eq!(resumed.report, straight.report);
    vault
}

// Guards (determinism): interrupted and resumed solves have the bits of uninterrupted ones.
#[test]
fn solve_interrupted_at_any_stage_is_bit_identical() {
    let scene = with(read(ROOM), |o| {
        o.restore_closure = Some(true);
        o.residual = 1e-15;
        o.max_iterations = 35;
    });
    let straight = solve(scene.clone());
    let vault = broken_off(&scene, 4, 5, &straight);
    assert!(vault.stages.lock().unwrap().contains_key("state-gradients"));
}

// Guards (determinism): interrupted and resumed solves have the bits of uninterrupted ones.
/// Identical bands solved by the spectral engine: interrupted at every saved state in turn.
#[test]
fn grey_solve_interrupted_in_the_iteration_is_bit_identical() {
    let scene = read(
        "[solve]
patch_rule = 'voxels'
engine = 'spectral'
residual = 1e-14
max_iterations = 45
[[surface]]
name = 'duct'
room = { min = [0,0,0], max = [1,1,10] }
reflectance = 0.97
faces.z0 = { emission = 1 }
[medium]
min = [0,0,0]
max = [1,1,10]
cells = [3,3,30]
extinction = 0.2
albedo = 0.5
",
    );
    let straight = solve(scene.clone());
    let iterations = straight.report.residuals[Band::first()].len() - 1;
    assert!(iterations >= 20, "{iterations}");
    // The first state is saved, the next interrupts, and so on.
    let kept = broken_off(&scene, 1, iterations / 10 - 1, &straight);
    let states = kept.saves.lock().unwrap().iter().filter(|s| *s == "state-gradients").count();
    assert_eq!(states, iterations / 10, "every tenth iteration, each kept once");
}

/// A duct with three bands, temperature-dependent band fractions and highly reflecting walls, so that each step needs many iterations.
const GASES: &str = "mode = 'thermal'
[solve]
patch_size = 0.5
residual = 1e-13
[thermal]
weights = [[0.65, -5.5e-4, 3e-7, -5.3e-11], [-0.025, 6.1e-4, -3.9e-7, 6.5e-11], 'rest']
range = [600, 2400]
[[surface]]
name = 'room'
room = { min = [0,0,0], max = [1,1,2] }
temperature = 700
emissivity = [0.02, 0.01, 0.03]
faces.z0 = { temperature = 1800, emissivity = [0.8, 0.3, 0.1] }
faces.x1.heat_flux = 0
faces.y0.heat_flux = 3000
[medium]
min = [0,0,0]
max = [1,1,2]
cells = [2,2,4]
extinction = [0.4, 2.5, 0]
albedo = [0.1, 0.3, 0]
heat_source = 2000
";

// Guards (determinism): interrupted and resumed solves have the bits of uninterrupted ones.
/// The iteration over temperatures of coupled bands resumes without repeating a step or an iteration of its linear solve.
#[test]
fn coupled_temperatures_interrupted_at_any_step_are_bit_identical() {
    for shares in sampled_cases(["", "band_fractions = [0.25, 0.35, 0.4]"], &[0]) {
        let text = match shares.is_empty() {
            true => GASES.to_string(),
            false => {
                let (head, tail) = GASES.split_once("weights").unwrap();
                format!("{head}{shares}\n{}", tail.split_once("2400]\n").unwrap().1)
            }
        };
        let scene = read(&text);
        let straight = solve(scene.clone());
        assert_eq!(straight.report.status, PerBand::splat(SolveStatus::Converged));
        let steps = straight.report.residuals[Band::first()].len();
        assert!(if shares.is_empty() { steps > 2 } else { steps == 1 }, "{steps}");
        let kept = broken_off(&scene, 1, steps + 2, &straight);
        let saves = kept.saves.lock().unwrap();
        let of = |name: &str| saves.iter().filter(|s| *s == name).count();
        assert_eq!(of("state-temperatures"), steps, "each step once");
        assert!(of("state-temperatures-linear") > 0);
        // The second solve for the discretization error resumes as well.
        let second = ["larger", "smaller"].map(|w| of(&format!("state-{w}-zones-state-temperatures")));
        assert!(
            straight.report.discretization_error.as_ref().is_some_and(|z| z.zones > 0)
                && second.iter().sum::<usize>() > 0
        );
    }
}

/// The room without its pane, with a patch size.
fn bare(patch: f64) -> Scene {
    let (head, tail) = (ROOM.split("[[pane]]").next().unwrap(), ROOM.split("[medium]").nth(1).unwrap());
    read(&format!("{head}[medium]{tail}").replace("patch_size = 0.5", &format!("patch_size = {patch}")))
}

// Guards (determinism): interrupted and resumed solves have the bits of uninterrupted ones.
/// The same with the rays engine, in the rays and between the rounds of the final gather.
#[test]
fn rays_and_gather_interrupted_at_any_stage_are_bit_identical() {
    for tolerance in [0.2, 0.03] {
        let scene = with(bare(0.5), |o| {
            (o.engine, o.tolerance) = (zonal_scene::Engine::Rays, tolerance);
        });
        let straight = solve(scene.clone());
        assert!(straight.report.counts.iter().any(|c| c.0 == "transport_rays"));
        let vault = broken_off(&scene, 1, 3, &straight);
        let stages = vault.stages.lock().unwrap();
        assert!(stages.keys().any(|k| k.starts_with("views-")) && stages.contains_key("state-gather"));
    }
}

/// Rays do not depend on reflectances: a solve with saved rays equals a new one bit by bit.
#[test]
fn saved_rays_serve_other_reflectances() {
    let scene = with(bare(0.5), |o| (o.engine, o.tolerance) = (zonal_scene::Engine::Rays, 0.2));
    let vault = Memory { left: AtomicUsize::new(usize::MAX), ..Memory::default() };
    run(&scene, &vault);
    let painted = with_surface_colors(
        scene,
        &[("floor".into(), Bands::from_rgb([0.1, 0.9, 0.5]))],
        Some(Bands::from_rgb([0.9, 0.5, 0.0])),
    )
    .unwrap();
    vault.stages.lock().unwrap().retain(|k, _| !k.starts_with("state-"));
    let views = |v: &Memory| v.stages.lock().unwrap().keys().filter(|k| k.starts_with("views-")).count();
    let before = (views(&vault), vault.loads.load(Ordering::Relaxed));
    let again = run(&painted, &vault);
    // Two lights, the surroundings, and the first rays of patches and volume zones; other light may need more rays.
    assert!(before.0 >= 2 && vault.loads.load(Ordering::Relaxed) >= before.1 + 5);
    assert_eq!(again.fields, solve(painted).fields);
}

#[test]
fn saved_factors_serve_other_reflectances() {
    for closure in [false, true] {
        let scene = with(read(ROOM), |o| o.restore_closure = Some(closure));
        let vault = Memory { left: AtomicUsize::new(usize::MAX), ..Memory::default() };
        let first = run(&scene, &vault);
        vault.stages.lock().unwrap().remove("state-gradients");
        vault.loads.store(0, Ordering::Relaxed);
        vault.left.store(0, Ordering::Relaxed);
        let painted = with_surface_colors(
            scene.clone(),
            &[("floor".into(), Bands::from_rgb([0.1, 0.9, 0.5]))],
            Some(Bands::from_rgb([0.99, 0.5, 0.0])),
        )
        .unwrap();
        // No stage is computed again; the iteration starts from the earlier solution.
        struct Read<'a>(&'a Memory);
        impl CheckpointStore for Read<'_> {
            fn load(&self, stage: &str) -> Option<Vec<u8>> {
                let found = self.0.load(stage);
                assert!(found.is_some() || stage.starts_with("state-gradients"), "{stage} would be computed");
                found
            }
            fn save(&self, _: &str, _: &[u8]) {}
            fn keeps(&self) -> bool {
                false
            }
        }
        let job = SolveSettings {
            checkpoints: &Read(&vault),
            initial_groups: &first.groups,
            ..SolveSettings::new(4 << 30, &NoProgress)
        };
        let again = solve_with_settings(painted.clone(), &job).unwrap();
        let fresh = solve(painted);
        let off = apart(&again, &fresh);
        assert!(off < 1e-9, "{off:e}");
        assert!(apart(&again, &first) > 1e-2, "the change was to matter");
        assert!(vault.loads.load(Ordering::Relaxed) > 5);
    }
    let message =
        with_surface_colors(read(ROOM), &[("roof".into(), Bands::splat(0.1))], None).unwrap_err().to_string();
    assert!(message.contains("roof") && message.contains("floor"), "{message}");
}

#[test]
fn scattering_orders_approach_the_solution_from_below() {
    let whole = solve(read(ROOM));
    let mut last = f64::INFINITY;
    for n in [1, 2, 4, 8, 16] {
        let s = solve(with(read(ROOM), |o| o.scattering_orders = Some(n)));
        assert_eq!(s.report.status, PerBand::splat(SolveStatus::FixedOrder));
        for (x, y) in s.fields.incident.iter().flatten().zip(whole.fields.incident.iter().flatten()) {
            assert!(*x <= y * (1.0 + 1e-9), "no sweep brings too much");
        }
        let off = light_apart(&s, &whole);
        assert!(off < 0.7 * last, "{n}: {off} {last}");
        last = off;
    }
    assert!(last < 1e-3, "{last}");
}
