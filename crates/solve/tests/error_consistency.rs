//! Errors widened by inconsistencies of a solution: unclosed rows, early termination, negative fluxes.

use crate::common;

use common::{patches_of, read, solve, unit_room};
use zonal_exchange::pair::PairSettings;
use zonal_paper::VoxelFormula;
use zonal_scene::{Band, NoProgress, Scene, Solution, SolveOptions, SolveStatus};
use zonal_solve::{SolveSettings, solve_with_settings};

const HOT_WALLS: &str = "temperature = 500\nemissivity = 0.7\nfaces.z0.temperature = 1200";
const GAS: &str = "[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [3,3,3]\nextinction = 2\nheat_source = 0";

fn with(scene: &Scene, change: impl FnOnce(&mut SolveOptions)) -> Scene {
    let mut o = scene.options().clone();
    change(&mut o);
    scene.clone().with_options(o).unwrap()
}

fn by(scene: Scene, formula: Option<VoxelFormula>) -> Solution {
    let pair_settings =
        PairSettings { volume_factors: formula.map(VoxelFormula::method), ..PairSettings::default() };
    let settings = SolveSettings { pair_settings, ..SolveSettings::new(4 << 30, &NoProgress) };
    solve_with_settings(scene, &settings).unwrap()
}

fn heat(closure: &str) -> Scene {
    let solve = format!("patch_rule = 'voxels'\ndiscretization_error = false\nclosure = '{closure}'");
    read(&format!("mode = 'thermal'\n{}", unit_room(&solve, HOT_WALLS, GAS)))
}

// Guards (numbers): closure defects, early termination and imbalance widen the stated errors.
/// Factors of voxels by formulas of the paper have closure defects of some per cent, which the stated errors include.
#[test]
fn unclosed_rows_widen_the_errors() {
    let truth = by(heat("measure"), None);
    for closure in ["measure", "restore"] {
        for voxels in [VoxelFormula::Point, VoxelFormula::Proposition1] {
            let s = by(heat(closure), Some(voxels));
            let [own, exact] = [&s, &truth].map(|s| &s.report.heat.as_ref().unwrap().rows);
            assert!(s.report.closure.worst.first() > 1e-3);
            let rows: Vec<[f64; 2]> =
                own.iter().zip(exact).map(|(a, b)| [(a.power - b.power).abs(), a.power_error]).collect();
            let [off, told] = [0, 1].map(|k| rows.iter().map(|r| r[k]).sum::<f64>());
            assert!(off > 1.0, "the formula is no good test: {off} W");
            // The residual of the balance is exact; its distribution over the zones is an estimate.
            assert!(told >= 0.5 * off, "{closure}: {rows:?}");
            assert!(rows.iter().all(|[d, e]| *e >= 0.4 * d - 1e-6), "{closure}: {rows:?}");
        }
    }
}

/// A detector sees a white relay alone, by exact factors; a partly hidden lamp lights the relay. The scene and its mirror image differ by the errors of the
/// samples, which the relay passes on.
#[test]
fn relays_pass_errors_on() {
    let plate = |name: &str, at: [f64; 3], edges: [[f64; 3]; 2], rest: &str| {
        let [a, b] = edges;
        format!(
            "[[surface]]\nname = '{name}'\nrectangle = {{ origin = {at:?}, edge1 = {a:?}, edge2 = {b:?} }}\n{rest}\n"
        )
    };
    let (x, y) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let detector = |mirrored: bool, tolerance: f64| {
        // Mirrored at x = ½.
        let from = |x0: f64, width: f64| if mirrored { 1.0 - x0 - width } else { x0 };
        let text = format!("[solve]\nengine = 'dense'\npatch_size = 1\ntolerance = {tolerance}\n")
            + &plate("lamp", [0.0; 3], [x, y], "reflectance = 0\nemission = 10")
            + &plate(
                "shade",
                [from(0.13, 0.61), 0.21, 1.0],
                [[0.61, 0.0, 0.0], [0.0, 0.53, 0.0]],
                "sides = 'both'\nreflectance = 0",
            )
            + &plate("relay", [from(-0.3, 1.6), 0.0, 2.0], [y, [1.6, 0.0, 0.0]], "reflectance = 1")
            + &plate("detector", [from(2.0, 1.0), 0.0, 1.0], [x, y], "reflectance = 0");
        let s = solve(read(&text));
        let i = patches_of(&s, "detector")[0];
        [s.fields.incident[i].first(), s.fields.error[i].first()]
    };
    for tolerance in [0.03, 1e-2, 1e-3] {
        let [[a, da], [b, db]] = [detector(false, tolerance), detector(true, tolerance)];
        // 2·10⁷ rays from the lamp to the halves of the relay, and their exact factors to the detector.
        let exact = 0.010229;
        for (h, e) in [(a, da), (b, db)] {
            assert!((h - exact).abs() <= 2.0 * e + 2e-5, "{tolerance}: {h} ± {e}");
        }
        assert!((a - b).abs() <= 2.0 * (da + db), "{tolerance}: {a} ± {da}, mirrored {b} ± {db}");
    }
}

/// A white cloud beside a partly hidden lamp: its voxels scatter what errs on its surface.
#[test]
fn clouds_pass_errors_on() {
    let field = |mirrored: bool, engine: &str| {
        let from = |x0: f64, width: f64| if mirrored { 1.0 - x0 - width } else { x0 };
        let s = solve(read(&format!(
            "[solve]\nengine = '{engine}'\npatch_size = 1\ntolerance = 0.02\n\
             [[surface]]\nname = 'lamp'\nrectangle = {{ origin = [{}, 0.1, -1], edge1 = [0.7,0,0], edge2 = [0,0.7,0] }}\nreflectance = 0\nemission = 10\n\
             [[surface]]\nname = 'shade'\nrectangle = {{ origin = [{}, 0.2, -0.5], edge1 = [0.41,0,0], edge2 = [0,0.53,0] }}\nsides = 'both'\nreflectance = 0\n\
             [medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [4,4,4]\nextinction = 10\nalbedo = 1",
            from(0.1, 0.7),
            from(0.13, 0.41)
        )));
        let of = |[i, j, k]: [usize; 3]| {
            let cell = (i * 4 + j) * 4 + k;
            let zone = (s.zones.voxel_offset()..s.zones.len())
                .find(|z| s.zones.voxels.at(z - s.zones.voxel_offset()).cell == cell)
                .unwrap();
            [s.fields.incident[zone].first(), s.fields.error[zone].first()]
        };
        let place = |i: usize| if mirrored { 3 - i } else { i };
        (0..64).map(|k| of([place(k / 16), k / 4 % 4, k % 4])).collect::<Vec<_>>()
    };
    for engine in ["dense", "spectral"] {
        let (a, b) = (field(false, engine), field(true, engine));
        let off: Vec<f64> = a.iter().zip(&b).map(|(a, b)| (a[0] - b[0]).abs() / (a[1] + b[1])).collect();
        let beyond = off.iter().filter(|x| **x > 1.0).count();
        assert!(beyond <= 3 && off.iter().all(|x| *x < 3.0), "{engine}: {beyond} of 64 voxels, {off:?}");
        assert!(
            a.iter().zip(&b).any(|(a, b)| (a[0] - b[0]).abs() > 1e-6 * a[0]),
            "the scene is no good test"
        );
    }
}

/// Rows of formulas of the paper are not restored: their losses come of all rays, not of the pilot rays alone.
#[test]
fn losses_beside_formulas_come_of_all_rays() {
    let cloud =
        "[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [3,3,3]\nextinction = 2\nalbedo = 0.5\nemission = 1";
    let rays = |closure: &str, formula: Option<VoxelFormula>| {
        let s = by(read(&format!("[solve]\nengine = 'dense'\n{closure}\n{cloud}")), formula);
        s.report.counts.iter().find(|c| c.0 == "rays to the surroundings").map(|c| c.1)
    };
    let all = rays("closure = 'measure'", None);
    assert!(all.is_some() && rays("", None) < all);
    for formula in [VoxelFormula::Point, VoxelFormula::Proposition1] {
        assert_eq!(rays("", Some(formula)), all);
    }
}

/// In a white cloud in a uniform field nothing absorbs the power that the rays of a gather lose: what escapes bounds the errors.
#[test]
fn errors_of_a_white_cloud_are_known() {
    let cloud = "[surroundings]\nradiance = 5\n[solve]\nengine = 'rays'\n\
        [medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [5,5,5]\nextinction = 4\nalbedo = 1";
    let s = solve(read(cloud));
    let exact = 4.0 * std::f64::consts::PI * 5.0;
    for (g, e) in s.fields.incident.iter().zip(&s.fields.error) {
        let (off, e) = ((g.first() - exact).abs(), e.first());
        assert!(e.is_finite() && off <= 2.0 * e, "off by {off}, stated {e}");
    }
    assert!(s.fields.incident.iter().any(|g| (g.first() - exact).abs() > 1e-6), "the scene is no good test");
}

/// A plate and a very thin medium of known heat in surroundings of known temperature: no zone absorbs, the surroundings do.
#[test]
fn errors_beside_known_powers_are_known() {
    let scene = "mode = 'thermal'\n[surroundings]\ntemperature = 700\n[solve]\npatch_size = 0.35\n\
        [[surface]]\nname = 'plate'\nrectangle = { origin = [0.6, 0.8, -0.2], edge1 = [0,0.127,0], edge2 = [0,0,0.121] }\n\
        emissivity = 0.8\nheat_flux = 4450\nsides = 'both'\n\
        [medium]\nmin = [0,0,0]\nmax = [0.5,0.9,0.8]\ncells = [3,3,4]\nextinction = 1.8e-8\nalbedo = 0\nheat_source = 0";
    for engine in ["dense", "rays"] {
        let s = solve(read(&scene.replace("[solve]", &format!("[solve]\nengine = '{engine}'"))));
        let row = &s.report.heat.as_ref().unwrap().rows[0];
        let [t, e] = [row.temperature, row.temperature_error].map(|x| x.unwrap_or(f64::INFINITY));
        // σT⁴ = σ 700⁴ + q/ε without reflection on the medium.
        let exact = (700f64.powi(4) + 4450.0 / 0.8 / 5.670374419e-8).powf(0.25);
        assert!(e.is_finite() && (t - exact).abs() <= 2.0 * e + 1e-3, "{engine}: {t} ± {e}, exact {exact}");
    }
}

/// The dense engine restores closure unless the scene says otherwise; powers are normalized in thermal mode alone.
#[test]
fn dense_engine_restores_closure() {
    let scene =
        |mode: &str, walls: &str| read(&format!("{mode}{}", unit_room("patch_size = 0.5", walls, "")));
    let heat = scene("mode = 'thermal'\n", HOT_WALLS);
    assert!(heat.restores_closure() && solve(heat.clone()).report.closure.restored);
    let measured = with(&heat, |o| o.restore_closure = Some(false));
    assert!(!measured.restores_closure() && !solve(measured).report.closure.restored);
    let light = scene("", "faces.x0 = { emission = 1 }");
    assert!(!light.restores_closure() && solve(light).report.closure.restored);
}

// Guards (numbers): closure defects, early termination and imbalance widen the stated errors.
#[test]
fn early_termination_widens_the_errors() {
    for (rho, steps) in [(0.5, 1), (0.9, 1), (0.9, 2), (0.99, 1), (0.99, 3)] {
        let walls = format!("reflectance = {rho}\nfaces.x0 = {{ emission = 1 }}");
        let scene = read(&unit_room(&format!("patch_size = 0.25\nmax_iterations = {steps}"), &walls, ""));
        let truth = solve(with(&scene, |o| o.max_iterations = 500));
        let s = solve(scene);
        assert_eq!(s.report.status[Band::first()], SolveStatus::MaxIterations);
        for (i, (h, e)) in s.fields.incident.iter().zip(&s.fields.error).enumerate() {
            let d = (h.first() - truth.fields.incident[i].first()).abs();
            assert!(d <= e.first(), "ρ {rho}, {steps} steps, zone {i}: off by {d}, stated {}", e.first());
        }
    }
}

/// Every power of the balance has an error of at least the residual, and none of zones where light is even.
#[test]
fn powers_by_name_have_errors() {
    let s = solve(read(&unit_room("patch_size = 0.25", "reflectance = 0.5\nemission = 1", "")));
    let (e, d) = (&s.report.energy, &s.report.energy_error);
    assert_eq!(e.absorbed_surfaces.len(), d.absorbed_surfaces.len());
    let told: f64 = d.absorbed_surfaces.iter().map(|x| x.1.first()).sum();
    assert!(told > 0.0 && told < 1e-6, "{told}");
    assert!((e.residual.first() * e.emitted.first()).abs() <= told + d.escaped.first() + 1e-12);
}

/// The power that enters from a sky has an error of a third by rays that mostly pass between two distant plates; a residual within it is no defect.
#[test]
fn residuals_within_the_stated_errors_are_no_warning() {
    let plate = |name: &str, origin: &str, edge: &str| {
        format!(
            "[[surface]]\nname = \"{name}\"\nrectangle = {{ origin = {origin}, edge1 = [1,0,0], edge2 = {edge} }}\nreflectance = 0\n"
        )
    };
    let sky = "[[light]]\nkind = \"perez-sky\"\ndirect_normal = 800\ndiffuse_horizontal = 90\ndirection = [0, 0.819152044, -0.573576436]\n";
    let plates = plate("ground", "[0,0,0]", "[0,1,0]") + &plate("south", "[0,50,20]", "[0,0,1]");
    let s = solve(read(&format!("{plates}{sky}")));
    let energy = &s.report.energy;
    assert!(energy.residual.first().abs() > 0.01, "the scene is no good test: {energy:?}");
    assert!(s.report.warnings.iter().all(|w| w.code != "energy-balance"), "{:?}", s.report.warnings);
    // The stated errors cover the residual.
    let errors = &s.report.energy_error;
    let absorbed = errors.absorbed_surfaces.iter().map(|x| x.1.first()).sum::<f64>();
    let residual = (energy.residual * (energy.emitted + energy.incoming)).first().abs();
    assert!(residual <= absorbed + errors.incoming.first(), "{residual} W of {errors:?}");
}

/// A body of given power in a room of its temperature: what iterations on rays leave of a balance of 59 kW is no defect of the factors.
#[test]
fn isothermal_rooms_give_no_warning() {
    let room = "[[surface]]\nname = 'room'\nroom = { min = [0,0,0], max = [2,2,2] }\nemissivity = 0.7\ntemperature = 500\npatch_size = 1\n";
    let body = "[[surface]]\nname = 'body'\nbox = { min = [0.5,0.5,0.5], max = [1,1,1] }\nemissivity = 0.3\nnode = 'n'\npatch_size = 0.5\n[[node]]\nname = 'n'\n";
    let other = "[[surface]]\nname = 'other'\nbox = { min = [1.2,1.2,0.5], max = [1.5,1.5,1] }\nemissivity = 0.3\nnet_power = 0\npatch_size = 0.5\n";
    for engine in ["dense", "rays"] {
        let solve_lines =
            format!("mode = 'thermal'\n[solve]\nengine = '{engine}'\ndiscretization_error = false\n");
        let s = solve(read(&format!("{solve_lines}{room}{body}{other}")));
        let heat = s.report.heat.as_ref().unwrap();
        assert!(heat.balance().abs() < 1.0, "{engine}: {}", heat.balance());
        assert!(s.report.warnings.iter().all(|w| w.code != "heat-balance"), "{:?}", s.report.warnings);
    }
}

/// A room that absorbs a ten-thousandth at each reflection: by rays within the stated errors of exact factors; the advice names what would help.
#[test]
fn nearly_white_rooms_by_rays_have_known_errors() {
    let text = |engine: &str| {
        format!(
            "[solve]\nengine = '{engine}'\npatch_size = 0.25\n[[surface]]\nname = 'room'\nroom = {{ min = [0,0,0], max = [1,1,1] }}\nreflectance = 0.9999\nfaces.z1 = {{ emission = 1 }}\n"
        )
    };
    let [exact, rays] = ["dense", "rays"].map(|engine| solve(read(&text(engine))));
    for ((a, b), e) in rays.fields.incident.iter().zip(&exact.fields.incident).zip(&rays.fields.error) {
        let (off, stated) = ((*a - *b).first().abs(), e.first());
        assert!(off <= 2.0 * stated, "{off} beside {stated}");
        assert!(stated < 0.1 * b.first(), "{stated} of {}", b.first());
    }
    let said = |word: &str| rays.report.warnings.iter().any(|w| w.contains(word));
    let spent = rays.report.status.any(|s| s == SolveStatus::MaxIterations);
    assert_eq!(said("increase max_iterations"), spent, "{:?}", rays.report.warnings);
    assert!(!said("nothing absorbs"), "{:?}", rays.report.warnings);
}
