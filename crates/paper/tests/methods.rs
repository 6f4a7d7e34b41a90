//! The paper's methods on random pairs: intervals contain the exact value; laws; the constants of Proposition 1.

use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_exchange::{AccuracyRequest, Method};
use zonal_math::{Grade, Vec3, low_discrepancy, vec3};
use zonal_paper::chebyshev::{ZoneLattice, lattice_factors};
use zonal_paper::{factor, gauss_6d, mean_inverse_distance, proposition1};

const METHODS: [Method; 5] =
    [Method::Point, Method::SixGauss, Method::Proposition1, Method::Series, Method::Chebyshev];

/// Zone `i` of a stream: a voxel, or a patch along any axis; sizes 1:30.
fn zone(seed: u64, spread: f64) -> Cuboid {
    let u: [f64; 8] = std::array::from_fn(|k| low_discrepancy::hash_to_unit(seed * 8 + k as u64));
    let size = |x: f64| 30f64.powf(x - 1.0);
    let lo = vec3(spread * (u[0] - 0.5), spread * (u[1] - 0.5), spread * (u[2] - 0.5));
    let mut e = [size(u[3]), size(u[4]), size(u[5])];
    let kind = (u[6] * 6.0) as usize;
    if kind >= 3 {
        return Cuboid::voxel(lo, lo + vec3(e[0], e[1], e[2]));
    }
    e[kind] = 0.0;
    Cuboid::patch(lo, lo + vec3(e[0], e[1], e[2]), kind, if u[7] < 0.5 { 1 } else { -1 })
}

#[test]
fn intervals_of_every_method_contain_the_exact_value() {
    let mut useful = [0; 5];
    for i in 0..600u64 {
        let spread = [2.0, 8.0, 40.0][i as usize % 3];
        let (a, b) = (zone(2 * i + 1, spread), zone(2 * i + 2, spread));
        for kappa in [0.0, 0.05, 1.5] {
            let want = geometric_factor(&a, &b, kappa, 1e-12).bounded;
            for (k, method) in METHODS.into_iter().enumerate() {
                let demand = AccuracyRequest { tolerance: 1e-5, max_evaluations: 300_000 };
                let f = factor(method, &a, &b, kappa, &demand);
                let off = (f.bounded.value - want.value).abs();
                assert!(
                    off <= f.bounded.radius + want.radius && f.bounded.radius.is_finite(),
                    "{method:?} κ={kappa} {a:?} {b:?}: {f:?} against {want:?}"
                );
                assert_eq!(f.bounded.grade, Grade::Proved);
                useful[k] += (f.bounded.radius <= 1e-2 * want.value) as usize;
            }
        }
    }
    println!("radius within 1 %: {useful:?}");
    assert!(useful.iter().all(|&n| n >= 50), "{useful:?}");
}

/// Reciprocity, translation, scaling (𝓕 of zones λ times as large with κ/λ), exchange of axes.
#[test]
fn factors_obey_reciprocity_translation_scaling_and_axis_exchange() {
    for i in 0..60u64 {
        let (a, b) = (zone(2 * i + 5001, 9.0), zone(2 * i + 5002, 9.0));
        let power = 2 + 2 - (a.normal.is_some() as i32) - (b.normal.is_some() as i32);
        for method in METHODS {
            let demand = AccuracyRequest { tolerance: 1e-4, max_evaluations: 100_000 };
            let get = |a: &Cuboid, b: &Cuboid, kappa: f64| factor(method, a, b, kappa, &demand).bounded;
            let f = get(&a, &b, 0.4);
            let agree = |g: zonal_math::Bounded, what: &str| {
                let room = f.radius + g.radius + 1e-13 * f.value.abs();
                assert!((f.value - g.value).abs() <= room, "{what} {method:?} {a:?} {b:?}: {f:?} {g:?}");
            };
            agree(get(&b, &a, 0.4), "reciprocity");
            let map =
                |z: &Cuboid, m: &dyn Fn(Vec3) -> Vec3| Cuboid { lo: m(z.lo), hi: m(z.hi), normal: z.normal };
            let shift = |v: Vec3| v + vec3(2.0, -4.0, 8.0);
            agree(get(&map(&a, &shift), &map(&b, &shift), 0.4), "translation");
            let double = |v: Vec3| v * 2.0;
            let scaled = get(&map(&a, &double), &map(&b, &double), 0.2);
            agree(scaled * 0.5f64.powi(power), "scaling");
            let turn = |z: &Cuboid| {
                let t = |v: Vec3| vec3(v.z, v.x, v.y);
                Cuboid { lo: t(z.lo), hi: t(z.hi), normal: z.normal.map(|(k, s)| ((k + 1) % 3, s)) }
            };
            agree(get(&turn(&a), &turn(&b), 0.4), "axes");
        }
    }
}

/// F(u) for unit cubes.
#[test]
fn intervals_contain_the_table_of_offsets() {
    let table = [
        ([2.0, 0.0, 0.0], 0.08274400378572),
        ([2.0, 1.0, 0.0], 0.06593039107507),
        ([2.0, 1.0, 1.0], 0.05469120942791),
        ([2.0, 2.0, 0.0], 0.04068407576830),
        ([2.0, 2.0, 2.0], 0.02692280822478),
        ([3.0, 0.0, 0.0], 0.03600834559637),
        ([5.0, 0.0, 0.0], 0.01281659763789),
        ([10.0, 0.0, 0.0], 0.00318839340356),
        ([100.0, 0.0, 0.0], 0.00003183151912),
        ([0.0, 0.0, 0.0], 1.79326723077820),
        ([1.0, 0.0, 0.0], 0.38048216172724),
        ([1.0, 1.0, 0.0], 0.17909621813407),
        ([1.0, 1.0, 1.0], 0.11453209119428),
    ];
    let a = Cuboid::voxel(Vec3::splat(0.0), Vec3::splat(1.0));
    for (u, want) in table {
        let u = vec3(u[0], u[1], u[2]);
        let b = Cuboid::voxel(u, u + Vec3::splat(1.0));
        for method in METHODS {
            let f =
                factor(method, &a, &b, 0.0, &AccuracyRequest { tolerance: 1e-9, max_evaluations: 2_000_000 })
                    .bounded;
            assert!(
                (f.value - want).abs() <= f.radius + 0.6e-14 * (1.0 + 1e2 * want),
                "{method:?} {u:?} {f:?} {want}"
            );
        }
        let two = mean_inverse_distance::mean_inverse_power(&a, &b, 2);
        let mean = std::f64::consts::PI * want;
        assert!((two.value - mean).abs() <= two.radius + 2e-14 * (1.0 + 1e2 * want));
    }
}

#[test]
fn constants_of_proposition_1_match_the_reference() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/reference/proposition1_constant.csv");
    let Ok(text) = std::fs::read_to_string(path) else {
        println!("skipped: no {path}");
        return;
    };
    let unit = |u: [i32; 3]| {
        let lo = vec3(u[0] as f64, u[1] as f64, u[2] as f64);
        Cuboid::voxel(lo, lo + Vec3::splat(1.0))
    };
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|l| l.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 16);
    for r in rows {
        let u = [r[0] as i32, r[1] as i32, r[2] as i32];
        let (one, two) = (
            mean_inverse_distance::mean_inverse_power(&unit([0; 3]), &unit(u), 1),
            mean_inverse_distance::mean_inverse_power(&unit([0; 3]), &unit(u), 2),
        );
        assert!((one.value - r[3]).abs() <= one.radius + 2e-14 * r[3], "{u:?} {one:?} {}", r[3]);
        assert!((two.value - r[4]).abs() <= two.radius + 2e-14 * r[4], "{u:?} {two:?} {}", r[4]);
        let c = proposition1::centre_constant(u);
        // The table has C to 12 digits of the difference of numbers of size |u|.
        let scale = r[0].hypot(r[1]).hypot(r[2]).max(1.0);
        assert!((c.value - r[5]).abs() <= c.radius + 3e-13 * scale, "{u:?} {c:?} {}", r[5]);
        assert!(c.radius <= 1e-12 * scale, "{u:?} {c:?}");
    }
}

/// Blocks and strips with attenuation inside, voxels and patches, partly behind a patch.
#[test]
fn chebyshev_blocks_meet_their_tolerance() {
    let cube = Cuboid::voxel(Vec3::splat(0.0), Vec3::splat(1.0));
    let patch = Cuboid::patch(Vec3::splat(0.0), vec3(1.0, 1.0, 0.0), 2, 1);
    let wall = Cuboid::patch(vec3(-9.0, -6.0, 5.0), vec3(-8.0, -5.0, 5.0), 2, -1);
    let voxel = Cuboid::voxel(vec3(-6.0, -6.0, -2.0), vec3(-5.0, -5.0, -1.0));
    let cases = [
        (cube, Cuboid::voxel(vec3(4.0, 0.0, 0.0), vec3(5.0, 1.0, 1.0)), [60, 1, 1]),
        (cube, Cuboid::voxel(vec3(25.0, -9.0, -9.0), vec3(26.0, -8.0, -8.0)), [18, 18, 18]),
        (patch, wall, [20, 14, 1]),
        (patch, voxel, [12, 12, 9]),
        (cube, voxel, [9, 3, 6]),
    ];
    let mut interpolated = 0;
    for (from, first, dims) in cases {
        let lattice = ZoneLattice { from, first, step: Vec3::splat(1.0), dims };
        for (kappa, tolerance) in [(0.0, 1e-3), (0.3, 1e-3), (0.1, 1e-6), (0.0, 1e-9)] {
            let all = lattice_factors(&lattice, kappa, &AccuracyRequest::relative(tolerance));
            for x in 0..dims[0] {
                for y in 0..dims[1] {
                    for z in 0..dims[2] {
                        if (x * 31 + y * 17 + z * 7) % 5 != 0 {
                            continue;
                        }
                        let c = [x, y, z];
                        let want = geometric_factor(&from, &lattice.zone(c), kappa, 1e-12).bounded;
                        let f = all[lattice.index(c)];
                        let off = (f.bounded.value - want.value).abs();
                        assert!(
                            off <= f.bounded.radius + want.radius,
                            "{from:?} {c:?} {kappa} {f:?} {want:?}"
                        );
                        assert!(f.bounded.radius <= tolerance * f.bounded.value, "{c:?} {f:?}");
                        interpolated += (f.method == Method::Chebyshev) as usize;
                    }
                }
            }
        }
    }
    assert!(interpolated > 1500, "{interpolated}");
}

/// Overlapping boxes whose edges leave ratios of 2^{1/3} at the corner: the halving of cells ends.
#[test]
fn mean_inverse_distance_subdivision_ends_for_cubic_root_edges() {
    let edges = [1.0, 2f64.powf(1.0 / 3.0), 2f64.powf(2.0 / 3.0)];
    let a = Cuboid::voxel(Vec3::splat(0.0), vec3(edges[0], edges[1], edges[2]));
    let b = Cuboid::voxel(vec3(0.5, 0.25, 0.125), vec3(3.0, 4.0, 5.0));
    for (a, b) in [(a, a), (a, b)] {
        let two = mean_inverse_distance::mean_inverse_power(&a, &b, 2);
        let want = geometric_factor(&a, &b, 0.0, 1e-13).bounded.value * std::f64::consts::PI
            / (a.measure() * b.measure());
        assert!(
            (two.value - want).abs() <= two.radius + 2e-13 * want && two.radius <= 1e-12 * want,
            "{two:?} {want}"
        );
    }
}

/// The tolerance determines the number of points of the six-dimensional rule.
#[test]
fn six_dimensional_gauss_meets_its_tolerance() {
    let a = Cuboid::voxel(Vec3::splat(0.0), Vec3::splat(1.0));
    let b = Cuboid::voxel(vec3(4.0, 1.0, 0.0), vec3(5.0, 2.0, 1.0));
    for tolerance in [1e-3, 1e-6, 1e-9] {
        let f = gauss_6d::factor(&a, &b, 0.2, &AccuracyRequest::relative(tolerance));
        let want = geometric_factor(&a, &b, 0.2, 1e-13).bounded.value;
        assert!(f.bounded.radius <= tolerance * want && (f.bounded.value - want).abs() <= f.bounded.radius);
    }
}

/// The hemi-cube by `factor`: estimated, near the exact value in front of the patch, zero behind it.
#[test]
fn hemicube_through_factor_is_estimated_and_one_sided() {
    let patch = Cuboid::patch(vec3(0.0, 0.0, 1.0), vec3(1.0, 1.0, 1.0), 2, -1);
    let below = Cuboid::voxel(vec3(0.0, 0.5, -2.0), vec3(1.0, 1.5, -1.0));
    let above = Cuboid::voxel(vec3(0.0, 0.5, 2.0), vec3(1.0, 1.5, 3.0));
    let demand = AccuracyRequest { tolerance: 1e-2, max_evaluations: 1_000_000 };
    let want = geometric_factor(&patch, &below, 0.3, 1e-10).bounded.value;
    for (a, b) in [(&patch, &below), (&below, &patch)] {
        let f = factor(Method::HemiCube, a, b, 0.3, &demand);
        assert_eq!((f.method, f.bounded.grade), (Method::HemiCube, Grade::Estimated));
        assert!((f.bounded.value / want - 1.0).abs() < 0.03, "{f:?} {want}");
    }
    assert_eq!(factor(Method::HemiCube, &patch, &above, 0.3, &demand).bounded.value, 0.0);
}

/// The paper's first-order statement with its sign: at small κ the error of the plain product is −κ C.
#[test]
fn first_order_error_has_the_sign_of_the_constant() {
    let a = Cuboid::voxel(Vec3::splat(0.0), Vec3::splat(1.0));
    for u in [[0, 0, 0], [1, 0, 0], [2, 1, 0], [5, 0, 0]] {
        let shift = vec3(u[0] as f64, u[1] as f64, u[2] as f64);
        let b = Cuboid::voxel(shift, shift + Vec3::splat(1.0));
        let kappa = 1e-5;
        let exact = geometric_factor(&a, &b, kappa, 1e-13).bounded.value;
        let got =
            proposition1::uncorrected_factor(&a, &b, kappa, &AccuracyRequest::relative(1e-12)).bounded.value;
        let error = (exact - got) / exact;
        assert!(
            (error / (-kappa * proposition1::centre_constant(u).value) - 1.0).abs() < 1e-3,
            "{u:?} {error:e}"
        );
    }
}
