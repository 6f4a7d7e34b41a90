//! Laws of clear boxes, exact to nine digits for any zones.

use crate::common;

use common::{count, mean, patches_of, read, solve, solved, unit_room, unlevel, with_exchange};
use std::fmt::Write as _;
use zonal_reference::{BruteForceScene, Rng, radiance};
use zonal_scene::{Band, Bands, NoProgress, PerBand, Progress, SolveStatus};
use zonal_solve::engines::dense::band_groups::{BandGroups, InteriorPanes};

/// A random closed clear box at one emissive power.
fn isothermal(seed: u64, m: f64, extra: &str) -> String {
    let mut d = Rng::new(seed);
    let size = [0, 1, 2].map(|_| d.uniform_in(0.4, 3.0));
    let cells = [0, 1, 2].map(|_| 1 + (d.uniform() * 4.0) as usize);
    let zero = (d.uniform() * 4.0) as usize;
    let kappa = Bands::from_fn(|b| if b.index() == zero { 0.0 } else { 3.0 * d.uniform().powi(2) }).to_rgb();
    let albedo = Bands::from_fn(|_| d.uniform()).to_rgb();
    let mut t = format!("[solve]\npatch_size = {}\nresidual = 1e-13\n{extra}\n", d.uniform_in(0.3, 1.2));
    let _ = writeln!(t, "[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = {size:?} }}");
    for face in ["x0", "x1", "y0", "y1", "z0", "z1"] {
        let rho = Bands::from_fn(|_| d.uniform());
        let (rho, e) = (rho.to_rgb(), ((1.0 - rho) * m).to_rgb());
        let _ = writeln!(t, "faces.{face} = {{ reflectance = {rho:?}, emission = {e:?} }}");
    }
    let _ = writeln!(
        t,
        "[medium]\nmin = [0,0,0]\nmax = {size:?}\ncells = {cells:?}\nextinction = {kappa:?}\nalbedo = {albedo:?}\nemission = {m}"
    );
    t
}

#[test]
fn isothermal_clear_box_is_uniform() {
    for seed in 0..12 {
        let s = solved(&isothermal(seed, 7.0, ""));
        let (h, g) = unlevel(&s, 7.0);
        let c = &s.report.closure;
        assert!(h < 1e-9 && g < 1e-9, "seed {seed}: H {h:e}, G {g:e}, closure {:?}", c.worst);
        assert!(c.worst.iter().all(|x| *x < 1e-9), "seed {seed}: closure {:?}", c.worst);
        assert!(s.report.energy.residual.iter().all(|r| r.abs() < 1e-9), "{:?}", s.report.energy.residual);
    }
}

#[test]
fn flux_of_isothermal_cube_matches_the_table_for_any_zones() {
    let table = [
        (0.01, 0.006636878475),
        (0.1, 0.063775152574),
        (0.5, 0.269605372691),
        (1.0, 0.446027456455),
        (2.0, 0.646759992379),
        (5.0, 0.842328957831),
        (10.0, 0.918296688398),
    ];
    for (k, gs) in table {
        for (cells, patch) in [("[1,1,1]", 1.0), ("[2,3,4]", 0.4), ("[4,4,4]", 0.25)] {
            let medium =
                format!("[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells={cells}\nextinction={k}\nemission=1");
            let s = solved(&unit_room(&format!("patch_size={patch}"), "reflectance=0", &medium));
            for face in ["x0", "y1", "z0"] {
                let flux = mean(&s, &s.fields.incident, &patches_of(&s, face));
                assert!((flux - gs).abs() < 1e-9, "K {k}, {cells}, {face}: {flux} against {gs}");
            }
        }
    }
}

#[test]
fn equilibrium_cube_matches_the_table_of_finite_zones() {
    let table =
        [(0.1, 5, 0.984871), (1.0, 5, 0.876007), (1.0, 9, 0.870908), (5.0, 5, 0.662410), (10.0, 5, 0.588629)];
    for (tau, n, want) in table {
        let medium =
            format!("[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[{n},{n},{n}]\nextinction={tau}\nalbedo=1");
        let walls = "reflectance=0\nfaces.z0 = { emission = 1 }";
        let solve = format!("patch_size={}\nresidual=1e-12\nzone_basis=\"constant\"", 1.0 / n as f64);
        let s = solved(&unit_room(&solve, walls, &medium));
        let q = 1.0 - mean(&s, &s.fields.incident, &patches_of(&s, "z0"));
        assert!((q - want).abs() < 6e-7, "tau {tau}, n {n}: {q} against {want}");
        let opposite = mean(&s, &s.fields.incident, &patches_of(&s, "z1"));
        let sides: f64 =
            ["x0", "x1", "y0", "y1"].iter().map(|f| mean(&s, &s.fields.incident, &patches_of(&s, f))).sum();
        assert!((q - opposite - sides).abs() < 1e-8, "flux is conserved");
        let centre = s.zones.voxel_offset() + s.zones.voxels.len() / 2;
        assert!(
            (s.fields.radiosity[centre].first() - 1.0 / 6.0).abs() < 1e-8,
            "the centre is a sixth by superposition"
        );
    }
}

#[test]
fn equilibrium_cube_has_the_centreline_profile() {
    let medium = "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[9,9,9]\nextinction=1\nalbedo=1";
    let s = solved(&unit_room(
        "patch_size=0.11111111111111112\nzone_basis=\"constant\"",
        "reflectance=0\nfaces.z0 = { emission = 1 }",
        medium,
    ));
    let want = [0.51617, 0.39369, 0.2969, 0.22245, 0.16667, 0.12523, 0.09424, 0.07053, 0.05131];
    let map = s.scene.voxel_grid().unwrap();
    for (k, w) in want.iter().enumerate() {
        let b = s.fields.radiosity[s.zones.voxel_offset() + map.index([4, 4, k])].first();
        assert!((b - w).abs() < 6e-6, "{k}: {b} against {w}");
    }
}

#[test]
fn vanishing_medium_converges_to_the_vacuum() {
    let text =
        |medium: &str| unit_room("patch_size=0.34", "reflectance=0.6\nfaces.x0 = { emission = 1 }", medium);
    let empty = solved(&text(""));
    let thin = |k: f64| {
        solved(&text(&format!(
            "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[3,3,3]\nextinction={k}\nalbedo=0.5"
        )))
    };
    for (k, bound) in [(0.0, 1e-12), (1e-14, 1e-12), (1e-9, 1e-8), (1e-300, 1e-12), (1e-4, 1e-3)] {
        let s = thin(k);
        for i in 0..empty.zones.len() {
            let (a, b) = (empty.fields.incident[i].first(), s.fields.incident[i].first());
            assert!((a - b).abs() <= bound * a.abs(), "κ {k}: {a} {b}");
        }
        let g = &s.fields.incident[s.zones.voxel_offset()..];
        assert!(g.iter().flatten().all(|x| x.is_finite() && *x > 0.0), "κ {k}");
    }
}

/// The fluence in a transparent band is Σ g B; it equals the Monte Carlo value and the limit of thin media.
#[test]
fn transparent_band_keeps_its_fluence() {
    let medium = "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[3,3,3]\nextinction=[1.5,0,1e-10]\nalbedo=0.7";
    let s = solved(&unit_room("patch_size=0.2", "reflectance=0.3\nfaces.x0 = { emission = 1 }", medium));
    let (map, w) = (s.scene.voxel_grid().unwrap(), BruteForceScene::new(&s.scene));
    for c in [[0, 1, 1], [2, 0, 1], [1, 1, 1]] {
        let g = s.fields.incident[s.zones.voxel_offset() + map.index(c)];
        let [_, transparent, thin] = g.to_rgb();
        assert!((transparent / thin - 1.0).abs() < 1e-8, "{g:?}");
        let lo = map.corner(c);
        for band in Band::all().take(2) {
            let e = radiance::fluence(&w, lo, lo + map.cell(), band, 60_000, 5 + band.index() as u64);
            // The discretization error is included in the bound.
            assert!(e.z(g[band], 0.015 * e.value) < 4.0, "{c:?} {band:?}: {} against {e:?}", g[band]);
        }
    }
}

#[test]
fn identical_cell_override_changes_nothing() {
    for (k, bound) in [(0.1, 2e-3), (0.5, 5e-3), (1.0, 1e-2), (3.0, 2e-2)] {
        let medium = |extra: &str| {
            format!(
                "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[4,4,4]\nextinction={k}\nalbedo=0.6\nemission=0.2\n{extra}"
            )
        };
        let other = format!(
            "[[medium.region]]\nbox={{min=[0.5,0.5,0.5],max=[0.75,0.75,0.75]}}\nextinction={}",
            k * (1.0 + 1e-12)
        );
        let walls = "reflectance=0.4\nfaces.x0 = { emission = 1 }";
        // A linear basis requires a uniform extinction.
        let solve = "patch_size=0.25\nzone_basis=\"constant\"";
        let a = solved(&unit_room(solve, walls, &medium("")));
        let b = solved(&unit_room(solve, walls, &medium(&other)));
        assert!(b.scene.voxel_grid().unwrap().uniform_extinction().is_none());
        let off = a
            .fields
            .incident
            .iter()
            .zip(&b.fields.incident)
            .fold(0.0f64, |m, (x, y)| m.max((x.first() / y.first() - 1.0).abs()));
        println!(
            "κℓ = {}: fields differ by {off:.2e}, closure {:.2e}",
            k / 4.0,
            b.report.closure.worst.first()
        );
        assert!(off < bound, "κ {k}: {off:e}");
    }
}

#[test]
fn bands_with_equal_extinction_share_factors() {
    let scene = |k: &str| {
        read(&unit_room(
            "patch_size=0.5",
            "",
            &format!("[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[2,2,2]\nextinction={k}"),
        ))
    };
    for (extinction, groups, count) in
        [("[1,1,1]", [0, 0, 0], 1), ("[1,2,1]", [0, 1, 0], 2), ("[1,2,3]", [0, 1, 2], 3)]
    {
        let found = BandGroups::of_scene(&scene(extinction), InteriorPanes::Absent);
        assert_eq!((found.group, found.firsts.len()), (PerBand::from_rgb(groups), count));
    }
    // Shared and separate factors give the same band.
    let s = |k: &str| {
        solved(&unit_room(
            "patch_size=0.5",
            "reflectance=[0.5,0.2,0.5]\nfaces.z1={emission=1}",
            &format!("[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[2,2,2]\nextinction={k}\nalbedo=0.3"),
        ))
    };
    let (a, b) = (s("[1,2,1]"), s("[1,2,3]"));
    for (x, y) in a.fields.incident.iter().zip(&b.fields.incident) {
        assert!(Band::all().take(2).all(|b| (x[b] / y[b] - 1.0).abs() < 1e-12));
    }
}

#[test]
fn factors_are_bit_symmetric_in_any_order_of_evaluation() {
    let text = unit_room(
        "patch_size=0.5\ntolerance=0.1",
        "omit=[\"y1\"]",
        "[[surface]]\nname=\"box\"\nbox={min=[0.2,0.3,0],max=[0.5,0.6,0.4],rotate_z_degrees=30}\n\
         [[surface]]\nname=\"slab\"\ntriangle={corners=[[0.9,0.1,0.9],[0.6,0.9,0.8],[0.7,0.4,0.2]]}\nsides=\"both\"\n\
         [[pane]]\npolygon=[[0.1,0.8,0.1],[0.9,0.8,0.1],[0.9,0.8,0.9],[0.1,0.8,0.9]]\nthickness=0.02\nextinction=[5,10,0]\n\
         [medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[3,3,3]\nextinction=[0.5,1,0]\n\
         [[medium.region]]\nbox={min=[0,0,0],max=[0.4,0.4,0.4]}\nextinction=2",
    );
    let scene = read(&text);
    with_exchange(&scene, |zones, _, exchange| {
        let mut c = count();
        for i in 0..zones.len() {
            for j in 0..=i {
                let (f, g) = (exchange.pair(i, j, &mut c), exchange.pair(j, i, &mut c));
                assert_eq!((f.value, f.radius), (g.value, g.radius), "{i} {j}");
                assert!(
                    f.value.iter().chain(&f.radius).all(|x| x.is_finite() && *x >= 0.0),
                    "{i} {j}: {f:?}"
                );
            }
        }
    });
}

#[test]
fn maximum_of_one_iteration_is_reported() {
    let s =
        solved(&unit_room("patch_size=0.5\nmax_iterations=1", "reflectance=0.9\nfaces.x0={emission=1}", ""));
    assert_eq!(s.report.status, PerBand::splat(SolveStatus::MaxIterations));
    assert!(s.report.residuals.iter().all(|r| r.len() == 2));
    assert!(s.report.warnings.iter().any(|w| w.contains("max_iterations")), "{:?}", s.report.warnings);
}

#[test]
fn highly_reflecting_rooms_converge() {
    for (rho, albedo, k) in
        [(0.99, 0.999, 2.0), (0.999, 1.0, 8.0), (0.9999, 0.5, 0.1), (0.5, 1.0, 20.0), (1.0, 0.99, 0.1)]
    {
        let medium =
            format!("[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[4,4,4]\nextinction={k}\nalbedo={albedo}");
        let s = solved(&unit_room(
            "patch_size=0.25",
            &format!("reflectance={rho}\nfaces.x0={{emission=1}}"),
            &medium,
        ));
        let e = &s.report.energy;
        println!(
            "ρ {rho} Ω {albedo} κ {k}: {} iterations, balance {:.1e}",
            s.report.residuals[Band::first()].len() - 1,
            e.residual.first()
        );
        assert_eq!(
            s.report.status,
            PerBand::splat(SolveStatus::Converged),
            "ρ {rho} Ω {albedo} κ {k}: {:?}",
            s.report.residuals[Band::first()]
        );
        assert!(e.residual.iter().all(|r| r.abs() < 1e-6), "{:?}", e.residual);
    }
}

/// Without absorption there is no steady state, and the solver reports that.
#[test]
fn conservative_closed_box_is_not_converged() {
    let medium = "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[2,2,2]\nextinction=1\nalbedo=1\nsource=3";
    let s = solved(&unit_room("patch_size=0.5", "reflectance=1", medium));
    assert!(s.fields.incident.iter().flatten().all(|x| x.is_finite()), "no NaN");
    assert!(
        s.report.status.iter().all(|s| *s != SolveStatus::Converged),
        "{:?} {:?}",
        s.report.status,
        s.fields.incident[0]
    );
    assert!(s.report.warnings.iter().any(|w| w.contains("nothing absorbs")), "{:?}", s.report.warnings);
}

/// The walls absorb the whole source of a conservative medium.
#[test]
fn source_in_a_conservative_medium_is_absorbed_by_the_walls() {
    let medium =
        "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[3,3,3]\nextinction=2\nalbedo=1\nemission=9\nsource=3";
    let s = solved(&unit_room("patch_size=0.34", "reflectance=0.2", medium));
    let e = &s.report.energy;
    let absorbed: f64 = e.absorbed_surfaces.iter().map(|x| x.1.first()).sum();
    assert!(
        (e.emitted.first() - 3.0).abs() < 1e-12 && (absorbed - 3.0).abs() < 1e-8,
        "{} {absorbed}",
        e.emitted.first()
    );
    assert!(e.absorbed_volumes.first().abs() < 1e-12);
}

#[test]
fn split_zones_do_not_change_a_clear_box() {
    // For given radiosities the sums are exact, so the flux of a uniform source does not depend on the zones.
    let flux = |patch: f64, n: usize| {
        let medium =
            format!("[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[{n},{n},{n}]\nextinction=1.3\nemission=0.4");
        let s = solve(read(&unit_room(
            &format!("patch_size={patch}"),
            "reflectance=0\nfaces.y0={emission=2}",
            &medium,
        )));
        mean(&s, &s.fields.incident, &patches_of(&s, "x1"))
    };
    let a = flux(1.0, 1);
    for (p, n) in [(0.5, 2), (0.3, 3), (0.25, 5)] {
        assert!((flux(p, n) / a - 1.0).abs() < 1e-9);
    }
}

#[test]
fn progress_is_reported_to_the_end() {
    #[derive(Default)]
    struct Sum(std::sync::Mutex<Vec<(String, u64, u64)>>);
    impl Progress for Sum {
        fn begin(&self, stage: &str, total: u64) {
            self.0.lock().unwrap().push((stage.into(), total, 0));
        }
        fn advance(&self, steps: u64) {
            self.0.lock().unwrap().last_mut().unwrap().2 += steps;
        }
        fn end(&self) {}
    }
    let sum = Sum::default();
    zonal_solve::solve(read(&unit_room("patch_size=0.5", "", "")), 1 << 30, &sum).unwrap();
    for (stage, total, done) in sum.0.lock().unwrap().iter() {
        assert!(done <= total, "{stage}: {done} of {total}");
        assert!(stage == "solving" || done == total, "{stage}: {done} of {total}");
    }
    assert!(
        zonal_solve::solve(read(&unit_room("patch_size=0.05", "", "")), 1 << 10, &NoProgress).is_err(),
        "refuses"
    );
}
