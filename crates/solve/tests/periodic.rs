//! Periodic boxes of any extinction: closed forms, physical laws, and agreement of the engines.

use crate::common;

use common::{read, solve, solved, unlevels};
use zonal_scene::thermal::blackbody_emissive_power;
use zonal_scene::{Band, Bands, Engine, HeatRow, Scene, Solution};

fn row<'a>(s: &'a Solution, name: &str) -> &'a HeatRow {
    let rows = &s.report.heat.as_ref().expect("a thermal solution").rows;
    rows.iter().find(|r| r.name == name).unwrap_or_else(|| panic!("no row {name}"))
}

/// A slab between black plates of 1000 and 500 K, `size` m, periodic along x and y.
fn slab(size: [f64; 3], cells: [usize; 3], basis: &str, kappa: &str) -> String {
    format!(
        "mode = \"thermal\"\n[solve]\npatch_rule = \"voxels\"\nzone_basis = \"{basis}\"\n[boundary]\nx = \"periodic\"\ny = \"periodic\"\n[[surface]]\nname = \"d\"\nroom = {{ min = [0,0,0], max = {size:?} }}\nomit = [\"x0\", \"x1\", \"y0\", \"y1\"]\ntemperature = 500\nemissivity = 1\nfaces.z0 = {{ temperature = 1000 }}\n[medium]\nmin = [0,0,0]\nmax = {size:?}\ncells = {cells:?}\n{kappa}\nheat_source = 0\n"
    )
}

// Guards (numbers): thin periodic slabs have their fluxes within errors of 1e-6.
/// Regression: with a linear basis and κ = 1e-12 the hot plate emitted 56703.66 W/m² and the cold one +3542.7, ± 2.6e-6.
#[test]
fn thin_slabs_have_the_flux_of_black_plates() {
    let want = blackbody_emissive_power(1000.0) - blackbody_emissive_power(500.0);
    assert!((want - 53159.76).abs() < 0.005, "{want}");
    let cube = [1.0; 3];
    let mut cases = vec![
        ([3.0, 0.4, 1.0], [4, 3, 8], "linear", 1e-9),
        ([0.2, 5.0, 1.0], [1, 2, 3], "linear", 0.0),
        ([3.0, 0.4, 1.0], [3, 3, 7], "constant", 1e-12),
        (cube, [4, 3, 8], "constant", 0.0),
        (cube, [4, 3, 8], "linear", 1e-12),
    ];
    for kappa in [0.0, 1e-12, 1e-9, 1e-7] {
        for basis in ["constant", "linear", "auto"] {
            cases.extend([8, 7, 1].map(|n| (cube, [1, 1, n], basis, kappa)));
        }
    }
    for (size, cells, basis, kappa) in cases {
        let s = solved(&slab(size, cells, basis, &format!("extinction = {kappa:e}")));
        // Half of the power that the medium absorbs returns to the walls.
        let want = want * (0.5 + zonal_math::exponential_integral::e3(kappa));
        for (name, sign) in [("d.z0", 1.0), ("d.z1", -1.0)] {
            let [q, e] = row(&s, name).flux();
            let off = (q - sign * want).abs();
            assert!(off <= e, "{cells:?} {basis} {kappa:e} {name}: {q} ± {e}");
            assert!(e <= 1e-6 * want, "{cells:?} {basis} {kappa:e} {name}: ± {e}");
        }
        assert!(s.report.closure.worst.iter().all(|d| *d < 1e-12), "{:?}", s.report.closure);
    }
}

/// Flux of a grey slab in radiative equilibrium over that of black plates: ½ + E₃(τ) where it is thin, then the table of Heaslet and Warming as in
/// `linear_basis.rs`.
#[test]
fn slab_flux_is_smooth_in_the_optical_depth() {
    let all = blackbody_emissive_power(1000.0) - blackbody_emissive_power(500.0);
    let ratio = |kappa: f64, basis: &str| {
        let s = solved(&slab([1.0; 3], [1, 1, 10], basis, &format!("extinction = {kappa:e}")));
        let [hot, cold] = ["d.z0", "d.z1"].map(|n| row(&s, n).flux()[0] / all);
        assert!((hot + cold).abs() < 1e-10, "{kappa:e} {basis}: {hot} {cold}");
        hot
    };
    for basis in ["constant", "linear"] {
        let mut before = 1.0;
        for kappa in [1e-6, 1e-5, 1e-4, 1e-3, 1e-2] {
            let got = ratio(kappa, basis);
            // Half of the absorbed power returns: 2E₃(τ) + (1 − 2E₃(τ))/2 + O(τ² ln τ).
            let want = 0.5 + zonal_math::exponential_integral::e3(kappa);
            assert!((got - want).abs() < 2.0 * kappa * kappa * (1.0 - kappa.ln()), "{kappa:e}: {got} {want}");
            assert!(got < before, "{kappa:e}: {got} {before}");
            before = got;
        }
        assert!((ratio(0.1, basis) - 0.91570287).abs() < 2e-4);
    }
}

/// Three bands, the third almost transparent.
fn bands(kappa: &str) -> String {
    format!(
        "mode = \"thermal\"\n[solve]\npatch_rule = \"voxels\"\n[thermal]\nweights = [[0.6508, -0.0005551, 3.029e-07, -5.353e-11], [-0.02504, 0.0006112, -3.882e-07, 6.528e-11], \"rest\"]\nrange = [600, 2400]\n[boundary]\nx = \"periodic\"\ny = \"periodic\"\n[[surface]]\nname = \"d\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\nomit = [\"x0\", \"x1\", \"y0\", \"y1\"]\ntemperature = 800\nemissivity = 1\nfaces.z0 = {{ temperature = 1500 }}\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [1, 1, 20]\nabsorption = [0.3, 3.0, {kappa}]\nheat_source = 0\n"
    )
}

/// Regression: the fluxes were 203744 and −207640 W/m², ± 1e-4 %.
#[test]
fn gas_with_a_transparent_band_conserves_power() {
    for kappa in ["1e-9", "0"] {
        let s = solved(&bands(kappa));
        for (name, want) in [("d.z0", 203_996.0), ("d.z1", -203_996.0)] {
            let [q, e] = row(&s, name).flux();
            assert!(
                (q / want - 1.0).abs() < 5e-4 && (q - want).abs() <= e + 1.0,
                "{kappa} {name}: {q} ± {e}"
            );
        }
    }
}

/// A room of 0.9 × 0.8 × 0.7 m with emitting, reflecting walls and an emitting, scattering medium.
fn room(periodic: &[&str], omit: &[&str], engine: &str, kappa: &str) -> Scene {
    let boundary: String = periodic.iter().map(|a| format!("{a} = \"periodic\"\n")).collect();
    let omit: Vec<String> = omit.iter().map(|f| format!("{f:?}")).collect();
    let face = ["x0", "y1", "z0"].into_iter().find(|f| !omit.contains(&format!("{f:?}"))).unwrap_or("z0");
    read(&format!(
        "[solve]\nengine = \"{engine}\"\nzone_basis = \"constant\"\npatch_rule = \"voxels\"\nresidual = 1e-13\n[boundary]\n{boundary}[[surface]]\nname = \"r\"\nroom = {{ min = [0,0,0], max = [0.9,0.8,0.7] }}\nomit = [{}]\nreflectance = 0.4\nemission = 1\nfaces.{face} = {{ emission = 3 }}\n[medium]\nmin = [0,0,0]\nmax = [0.9,0.8,0.7]\ncells = [4, 3, 5]\nextinction = {kappa}\nalbedo = 0.6\n",
        omit.join(", ")
    ))
}

#[test]
fn engines_agree_in_transparent_bands() {
    let slab = (&["x", "y"][..], &["x0", "x1", "y0", "y1"][..]);
    let duct = (&["z"][..], &["z0", "z1"][..]);
    for (periodic, omit) in [slab, duct] {
        for kappa in ["[0.0, 0.0, 0.0]", "[0.0, 0.7, 1e-9]"] {
            let [a, b] = ["spectral", "dense"].map(|e| solve(room(periodic, omit, e, kappa)));
            assert_eq!((a.report.engine.as_str(), b.report.engine.as_str()), ("spectral", "dense"));
            for (i, (x, y)) in a.fields.incident.iter().zip(&b.fields.incident).enumerate() {
                assert!((x / y - 1.0).abs().all(|d| d < 1e-11), "{periodic:?} {kappa} {i}: {x:?} {y:?}");
                let stated = a.fields.error[i] + b.fields.error[i];
                let holds = |k: Band| (x[k] - y[k]).abs() <= stated[k];
                assert!(Band::all().all(holds), "{periodic:?} {kappa} {i}: ± {stated:?}");
            }
            assert!(a.report.energy.residual.iter().all(|r| r.abs() < 1e-11), "{:?}", a.report.energy);
        }
    }
}

/// An isothermal duct and slab: transparent voxels receive the uniform radiation of the walls.
#[test]
fn transparent_isothermal_enclosures_are_uniform() {
    for (periodic, omit) in
        [(&["x"][..], &["x0", "x1"][..]), (&["y", "z"][..], &["y0", "y1", "z0", "z1"][..])]
    {
        for basis in ["constant", "linear"] {
            let mut parts = room(periodic, omit, "spectral", "[0.0, 0.3, 1e-12]").into_parts();
            parts.options.zone_basis = match basis {
                "linear" => zonal_scene::ZoneBasis::Linear,
                _ => zonal_scene::ZoneBasis::Constant,
            };
            parts
                .surfaces
                .iter_mut()
                .for_each(|s| (s.reflectance, s.emission) = (Bands::splat(0.5), Bands::ONE));
            let map = parts.voxel_grid.as_mut().unwrap();
            map.fill(Bands::from_rgb([0.0, 0.3, 1e-12]), Bands::splat(0.6), Bands::splat(2.0), Bands::ZERO);
            let s = solve(Scene::new(parts).unwrap());
            for (i, off) in unlevels(&s, 2.0).iter().enumerate() {
                assert!(*off < 1e-11, "{periodic:?} {basis} {i}: {off:e}");
            }
            assert_eq!(s.scene.options().engine, Engine::Spectral);
        }
    }
}

/// All emission of a black plate leaves a transparent slab that is open above.
#[test]
fn transparent_open_slabs_lose_all_power() {
    for basis in ["constant", "linear"] {
        for kappa in ["0", "1e-12"] {
            let s = solved(&format!(
                "[solve]\npatch_rule = \"voxels\"\nzone_basis = \"{basis}\"\n[boundary]\nx = \"periodic\"\ny = \"periodic\"\n[[surface]]\nname = \"d\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\nomit = [\"x0\", \"x1\", \"y0\", \"y1\", \"z1\"]\nreflectance = 0\nemission = 1\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [2, 3, 4]\nextinction = {kappa}\nalbedo = 1\n"
            ));
            let e = &s.report.energy;
            assert!((e.escaped.first() - 1.0).abs() < 1e-11 && e.residual.first().abs() < 1e-11, "{e:?}");
        }
    }
}
