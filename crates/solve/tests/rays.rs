//! The rays engine compared with the dense and the spectral engine on the same zones, and its symmetry, closure and determinism.

use crate::common;

use common::{read, unit_room};
use std::sync::LazyLock;
use zonal_reference::test_cases::sampled_cases;
use zonal_scene::{Band, Engine, LightGrouping, NoProgress, Scene, Solution, ZoneBasis};
use zonal_solve::{SolveSettings, solve_with_settings};

const GAS: &str = "[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [6,6,6]\nextinction = 1\nalbedo = 0.8\n";
const BLOCK: &str =
    "[[surface]]\nname = \"block\"\nbox = { min = [0.45,0.3,0.2], max = [0.7,0.6,0.6] }\nreflectance = 0.5\n";
const SLANTED: &str = "[[surface]]\nname = \"sheet\"\nrectangle = { origin = [0.2,0.3,0.2], edge1 = [0.5,0.2,0.1], edge2 = [-0.1,0.2,0.5] }\nreflectance = [0.6, 0.3, 0.5]\nsides = \"both\"\n";
const SMOKE: &str = "[[medium.region]]\nbox = { min = [0.25,0.25,0.25], max = [0.75,0.75,0.5] }\nextinction = [6, 3, 1]\nalbedo = 0.7\n";
const PANE: &str = "[[pane]]\npolygon = [[0.55,0,0],[0.55,1,0],[0.55,1,1],[0.55,0,1]]\nthickness = 0.01\nextinction = [30, 100, 300]\nalbedo = 0.6\n";

fn room(rest: &str) -> Scene {
    let walls = "reflectance = 0.5\nfaces.x0 = { emission = 1 }";
    read(&unit_room("patch_size = 0.1667", walls, &format!("{GAS}{rest}")))
}

/// The room with a block, solved by the dense engine.
static DENSE_BLOCK: LazyLock<Solution> = LazyLock::new(|| solved(&room(BLOCK), Engine::Dense, 0.01, false));

fn solved(scene: &Scene, engine: Engine, tolerance: f64, restore: bool) -> Solution {
    common::solve(with_engine(scene, engine, tolerance, restore))
}

fn with_engine(scene: &Scene, engine: Engine, tolerance: f64, restore: bool) -> Scene {
    let mut o = scene.options().clone();
    (o.engine, o.tolerance, o.light_grouping, o.restore_closure) =
        (engine, tolerance, LightGrouping::All, Some(restore));
    o.zone_basis = ZoneBasis::Constant;
    scene.clone().with_options(o).unwrap_or_else(|e| panic!("{e}"))
}

/// L2 error over a range of zones, the largest of the bands, and the fraction of zones within twice their own estimate.
fn errors(ours: &Solution, dense: &Solution, range: std::ops::Range<usize>) -> (f64, f64) {
    let mut worst = 0.0f64;
    let mut within = 0;
    for b in Band::all() {
        let (mut d2, mut r2) = (0.0, 0.0);
        for i in range.clone() {
            let (h, t) = (ours.fields.incident[i][b], dense.fields.incident[i][b]);
            d2 += (h - t) * (h - t);
            r2 += t * t;
            within += usize::from((h - t).abs() <= 2.0 * ours.fields.error[i][b]);
        }
        worst = worst.max((d2 / r2).sqrt());
    }
    (worst, within as f64 / (Band::count() * range.len()) as f64)
}

/// Asserts that the errors at a tolerance, against a reference on the same zones, are below the tolerance and below their estimate.
fn assert_tolerance_holds(name: &str, scene: &Scene, reference: &Solution, tolerance: f64) {
    let ours = solved(scene, Engine::Rays, tolerance, false);
    let (first, last) = (ours.zones.voxel_offset(), ours.zones.len());
    let estimate = &ours.report.estimate;
    for (what, range, estimated) in [("H", 0..first, estimate.patches), ("G", first..last, estimate.volumes)]
    {
        let (l2, within) = errors(&ours, reference, range);
        let estimated = estimated.iter().fold(0.0f64, |m, e| m.max(*e));
        assert!(l2 <= tolerance, "{name} {what}: {l2} at tolerance {tolerance}");
        assert!(l2 <= estimated, "{name} {what}: {l2}, estimated {estimated}");
        assert!(within >= 0.95, "{name} {what}: {within} within twice their estimate at {tolerance}");
    }
}

// Guards (numbers): errors of the rays engine stay below tolerance and estimate, against the dense and the spectral engine.
#[test]
fn errors_stay_below_tolerance_and_estimate() {
    let cases = [("block", BLOCK), ("pane", PANE), ("free", ""), ("smoke", SMOKE), ("slanted", SLANTED)];
    for (name, rest) in sampled_cases(cases, &[1]) {
        let scene = room(rest);
        let dense = match name {
            "block" => DENSE_BLOCK.clone(),
            _ => solved(&scene, Engine::Dense, 0.01, false),
        };
        let tolerances = if name == "block" { vec![0.03, 0.1, 0.01] } else { vec![0.03] };
        for tolerance in sampled_cases(tolerances, &[0]) {
            assert_tolerance_holds(name, &scene, &dense, tolerance);
        }
    }
}

// Guards (numbers): errors of the rays engine stay below tolerance and estimate, against the dense and the spectral engine.
/// The spectral engine has every exchange area of a box to 1e-12.
#[test]
fn errors_against_the_spectral_engine_stay_below_tolerance_and_estimate() {
    let walls = "reflectance = 0.5\nfaces.z0 = { emission = 1 }";
    let cases = [("thin", 1, "[14,14,14]", [0.1, 0.05]), ("thick", 2, "[12,10,8]", [0.1, 0.02])];
    for (name, kappa, cells, tolerances) in sampled_cases(cases, &[1]) {
        let gas = format!(
            "[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = {cells}\nextinction = {kappa}\nalbedo = 0.9\n"
        );
        let scene = read(&unit_room("patch_rule = \"voxels\"", walls, &gas));
        let exact = solved(&scene, Engine::Spectral, 0.01, false);
        tolerances.iter().for_each(|&t| assert_tolerance_holds(name, &scene, &exact, t));
    }
}

/// A preview by the stored rays has more noise than a gather, and states it.
#[test]
fn stored_rays_without_a_gather_state_their_error() {
    let cases = [("block", BLOCK), ("pane", PANE), ("smoke", SMOKE), ("slanted", SLANTED)];
    for (name, rest) in sampled_cases(cases, &[1]) {
        let scene = room(rest);
        let dense = match name {
            "block" => DENSE_BLOCK.clone(),
            _ => solved(&scene, Engine::Dense, 0.01, false),
        };
        for tolerance in [0.5, 0.1] {
            let scene = with_engine(&scene, Engine::Rays, tolerance, true);
            let settings = SolveSettings { final_gather: false, ..SolveSettings::new(4 << 30, &NoProgress) };
            let ours = solve_with_settings(scene, &settings).unwrap_or_else(|e| panic!("{e}"));
            assert!(ours.report.counts.iter().all(|c| !c.0.contains("gather")), "{:?}", ours.report.counts);
            let (first, last, estimate) =
                (ours.zones.voxel_offset(), ours.zones.len(), &ours.report.estimate);
            for (range, stated) in [(0..first, estimate.patches), (first..last, estimate.volumes)] {
                let (l2, within) = errors(&ours, &dense, range);
                let stated = stated.iter().fold(0.0f64, |m, e| m.max(*e));
                assert!(l2 <= stated && stated < 6.0 * l2, "{name} {tolerance}: {l2}, stated {stated}");
                assert!(within >= 0.95, "{name} {tolerance}: {within} within twice their estimate");
            }
        }
    }
}

/// A floor in two rooms of equal brightness, one lit red and one blue: smoothing does not average patches across the wall.
#[test]
fn smoothing_does_not_mix_colours_across_a_wall() {
    let rest = "[[surface]]\nname = \"wall\"\nrectangle = { origin = [0.5,0,0], edge1 = [0,1,0], edge2 = [0,0,1] }\nreflectance = 0.5\nsides = \"both\"\n";
    let walls =
        "reflectance = 0.5\nfaces.x0 = { emission = [1, 0.1, 0] }\nfaces.x1 = { emission = [0, 0.1, 1] }";
    let scene = read(&unit_room("patch_size = 0.0625", walls, rest));
    let dense = solved(&scene, Engine::Dense, 0.01, false);
    let ours = solved(&scene, Engine::Rays, 0.1, false);
    for i in 0..ours.zones.patches.len() {
        let c = ours.zones.patches[i].plate.centre();
        let other = if c.x < 0.5 || c.x == 0.5 && ours.zones.patches[i].normal.x < 0.0 { 2 } else { 0 };
        assert_eq!(dense.fields.incident[i].to_rgb()[other], 0.0);
        let [stray, light] = [other, 2 - other].map(|b| ours.fields.incident[i].to_rgb()[b]);
        assert!(stray < 0.02 * light, "patch {i} at {c:?}: {stray} beside {light}");
    }
}

// Guards (determinism): solutions of the rays engine do not depend on the number of threads.
#[test]
fn threads_do_not_change_a_bit() {
    let scene = room(&format!("{SMOKE}{BLOCK}"));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| solved(&scene, Engine::Rays, 0.05, true).fields)
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn one_factor_restores_the_balance_and_is_reported() {
    let scene = room(BLOCK);
    let measured = solved(&scene, Engine::Rays, 0.02, false);
    let restored = solved(&scene, Engine::Rays, 0.02, true);
    assert!(restored.report.closure.restored && !measured.report.closure.restored);
    let off = |s: &Solution| s.report.energy.residual.iter().fold(0.0f64, |m, r| m.max(r.abs()));
    assert!(off(&restored) < 2e-3, "{}", off(&restored));
    let change = restored.report.closure.largest_change.first();
    assert!(change > 0.0 && change < 0.5, "{change}");
    let dense = &*DENSE_BLOCK;
    let first = restored.zones.voxel_offset();
    let (h, g) =
        (errors(&restored, dense, 0..first).0, errors(&restored, dense, first..restored.zones.len()).0);
    assert!(h < 0.02 && g < 0.02, "{h} {g}");
}

/// A small opaque cloud shades a small part of a large floor from distant lights, and few rays between them meet it.
#[test]
fn a_small_cloud_shades_a_large_floor() {
    let wall = |name: &str, x: f64, edge: &str| {
        format!(
            "[[surface]]\nname = \"{name}\"\nrectangle = {{ origin = [{x}, 0, -150], {edge} }}\nreflectance = 0\nemission = 1\npatch_size = 25\n"
        )
    };
    let text = format!(
        "[solve]\npatch_size = 0.5\n[[surface]]\nname = \"floor\"\nrectangle = {{ origin = [-6, -1, 6], edge1 = [12, 0, 0], edge2 = [0, 0, -12] }}\nreflectance = 0.4\n{}{}[medium]\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\ncells = [5, 5, 5]\n[[medium.region]]\nbox = {{ min = [-0.6, -0.9, -0.6], max = [0.6, 0.6, 0.6] }}\nextinction = 4\nalbedo = 0\n",
        wall("left", -150.0, "edge1 = [0, 300, 0], edge2 = [0, 0, 300]"),
        wall("right", 150.0, "edge1 = [0, 0, 300], edge2 = [0, 300, 0]"),
    );
    let scene = read(&text);
    let [dense, ours] = [Engine::Dense, Engine::Rays].map(|engine| solved(&scene, engine, 0.01, false));
    let floor = common::patches_of(&ours, "floor");
    let most = floor.iter().fold(0.0f64, |m, &i| m.max(dense.fields.incident[i].first()));
    let shaded = floor.iter().filter(|&&i| dense.fields.incident[i].first() < 0.7 * most).count();
    assert!(shaded > 4 && shaded < floor.len() / 4, "{shaded} of {}", floor.len());
    let off = |&i: &usize| (ours.fields.incident[i].first() / dense.fields.incident[i].first() - 1.0).abs();
    let worst = floor.iter().map(off).fold(0.0, f64::max);
    let (l2, _) = errors(&ours, &dense, 0..ours.zones.voxel_offset());
    assert!(l2 < 0.01 && worst < 0.3, "{l2} {worst}");
}

/// The engine follows a fixed number of scattering orders.
#[test]
fn rays_follow_a_fixed_scattering_order() {
    let mut o = room(BLOCK).options().clone();
    for sweeps in sampled_cases([1, 3], &[1]) {
        o.scattering_orders = Some(sweeps);
        let scene = room(BLOCK).with_options(o.clone()).unwrap();
        let [dense, ours] =
            [(Engine::Dense, 0.01), (Engine::Rays, 0.15)].map(|(e, t)| solved(&scene, e, t, true));
        let n = ours.zones.voxel_offset();
        for range in [0..n, n..ours.zones.len()] {
            let (l2, _) = errors(&ours, &dense, range.clone());
            let mean = |s: &Solution| range.clone().map(|i| s.fields.incident[i].first()).sum::<f64>();
            assert!(l2 < 0.08, "{sweeps}: {l2}");
            assert!(
                (mean(&ours) / mean(&dense) - 1.0).abs() < 0.03,
                "{sweeps}: {} {}",
                mean(&ours),
                mean(&dense)
            );
        }
    }
}

/// A square on the floor below a screen, over which a lamp shines, and perhaps a small lamp beside it.
fn beside_a_hidden_lamp(small_lamp: &str) -> Scene {
    read(&format!(
        "[solve]\npatch_size = 0.25\ndiscretization_error = false\n\
         [[surface]]\nname = 'floor'\nrectangle = {{ origin = [0,0,0], edge1 = [0.5,0,0], edge2 = [0,0.5,0] }}\nreflectance = 0\nsides = 'front'\n\
         [[surface]]\nname = 'screen'\nrectangle = {{ origin = [-3,-3,1], edge1 = [0,6,0], edge2 = [6,0,0] }}\nreflectance = 0\npatch_size = 9\nsides = 'both'\n\
         [[surface]]\nname = 'lamp'\nrectangle = {{ origin = [-1,-1,2], edge1 = [0,2,0], edge2 = [2,0,0] }}\nreflectance = 0\nemission = 100\nsides = 'front'\n\
         {small_lamp}"
    ))
}

#[test]
fn gathered_samples_that_meet_no_light_are_no_proof_of_darkness() {
    let small = "[[surface]]\nname = 'small'\nrectangle = { origin = [2,0,0.2], edge1 = [0,0.15,0], edge2 = [0,0,0.15] }\nreflectance = 0\nemission = 100\nsides = 'both'\n";
    let scene = beside_a_hidden_lamp(small);
    let dense = solved(&scene, Engine::Dense, 0.001, false);
    for tolerance in [0.5, 0.2, 0.05] {
        let ours = solved(&scene, Engine::Rays, tolerance, false);
        for i in 0..4 {
            let (h, e, t) = (
                ours.fields.incident[i].first(),
                ours.fields.error[i].first(),
                dense.fields.incident[i].first(),
            );
            // Few samples of a zone meet the lamp: its error is uncertain, but none is missing.
            assert!(t > 0.01 && (h - t).abs() <= 6.0 * e, "{tolerance}, {i}: {h} ± {e} of {t}");
        }
    }
    // Nothing is visible: the error says so.
    let ours = solved(&beside_a_hidden_lamp(""), Engine::Rays, 0.05, false);
    let floor = (0..4).map(|i| (ours.fields.incident[i].first(), ours.fields.error[i].first()));
    for (h, e) in floor {
        assert!(h == 0.0 && e > 0.0 && e < 0.5, "{h} ± {e}");
    }
}

#[test]
fn a_convex_body_in_the_open_has_no_field_and_no_error() {
    let body = "[solve]\npatch_size = 0.5\n[[surface]]\nname = 'body'\nbox = { min = [0,0,0], max = [1,1,1] }\nreflectance = 0.5\nemission = 3\n";
    let s = solved(&read(body), Engine::Rays, 0.05, false);
    assert!(
        s.fields.incident.iter().chain(&s.fields.error).all(|h| h.first() == 0.0),
        "{:?}",
        s.fields.error
    );
}
