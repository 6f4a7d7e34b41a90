//! Periodic geometries against crossed strings: no stated radius is smaller than the error, at any tolerance and proportion.

use zonal_math::{Bounded, Vec3, vec3};
use zonal_scene::{NoCheckpoints, NoProgress};
use zonal_view_factors::{ConvexPolygon, FacetSet, RowClosing, ViewFactorSettings, ViewFactors};

/// Rectangles at, at + e, at + e + f, at + f, whole or each in two triangles, added as one surface each.
fn surfaces(rectangles: &[[Vec3; 3]], triangles: bool) -> FacetSet {
    let mut set = FacetSet::new();
    for [at, e, f] in rectangles {
        let c = [*at, *at + *e, *at + *e + *f, *at + *f];
        let part = |k: &[usize]| ConvexPolygon::new(k.iter().map(|k| c[*k]).collect()).expect("a polygon");
        set.add_parts(match triangles {
            true => vec![part(&[0, 1, 2]), part(&[0, 2, 3])],
            false => vec![part(&[0, 1, 2, 3])],
        });
    }
    set
}

fn compute(set: &FacetSet, tolerance: f64, periods: [Option<f64>; 2]) -> ViewFactors {
    let settings = ViewFactorSettings { tolerance, periods, closure: RowClosing::Keep, ..Default::default() };
    set.compute(&settings, &NoProgress, &NoCheckpoints).expect("valid settings")
}

fn factor(f: &ViewFactors, i: usize, j: usize) -> Bounded {
    f.row(i).find(|e| e.0 == j).map_or(Bounded::ZERO, |e| e.1)
}

/// A street of width 1 between blocks of height h and width `block`, repeated across and along.
fn canyon(h: f64, block: f64, along: f64) -> Vec<[Vec3; 3]> {
    let (x, y, z) = (vec3(1.0, 0.0, 0.0), vec3(0.0, along, 0.0), vec3(0.0, 0.0, h));
    vec![[Vec3::ZERO, x, y], [x, z, y], [x + z, x * block, y], [x + x * block, y, z]]
}

/// Exact factors of a canyon: street to a wall, wall to wall, wall to street, wall to sky.
fn canyon_factors(h: f64) -> [f64; 4] {
    let diagonal = 1f64.hypot(h);
    // 1 + h − √(1 + h²) without cancellation.
    let side = 2.0 * h / (1.0 + h + diagonal);
    [0.5 * side, (diagonal - 1.0) / h, 0.5 * side / h, 0.5 * side / h]
}

// Guards (numbers): radii of view factors hold in periodic canyons and sheds at every tolerance.
#[test]
fn canyons_of_any_proportion_hold_at_any_tolerance() {
    for (h, block, along, triangles) in [
        (1.0, 0.6, 1.0, false),
        (0.01, 0.6, 0.5, false),
        (100.0, 2.0, 10.0, false),
        (0.8, 0.05, 0.02, false),
        (0.8, 3.0, 50.0, false),
        (1.0, 0.6, 1.0, true),
        (0.1, 1.0, 0.1, true),
    ] {
        let set = surfaces(&canyon(h, block, along), triangles);
        let [street, walls, to_street, sky] = canyon_factors(h);
        for tolerance in [1e-3, 1e-4, 1e-6, 1e-8] {
            let f = compute(&set, tolerance, [Some(1.0 + block), Some(along)]);
            let checks = [
                ("street to wall", factor(&f, 0, 1), street),
                ("wall to wall", factor(&f, 1, 3), walls),
                ("wall to street", factor(&f, 3, 0), to_street),
                ("wall to sky", f.sky(1), sky),
                ("roof to sky", f.sky(2), 1.0),
            ];
            for (what, ours, exact) in checks {
                let off = (ours.value - exact).abs();
                assert!(
                    off <= ours.radius + 1e-12,
                    "{h} {along} {triangles} {tolerance:e}, {what}: {ours:?}, exact {exact}"
                );
                assert!(
                    ours.radius <= 2.0 * tolerance,
                    "{h} {along} {triangles} {tolerance:e}, {what}: {ours:?}"
                );
            }
            for i in 0..4 {
                assert!(f.defects()[i].abs() <= f.row_radius(i) + 1e-12);
            }
        }
    }
}

/// Rows of sheds over a ground: the front, the back, the ground.
fn sheds() -> Vec<[Vec3; 3]> {
    let (x, at) = (vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 0.7));
    let slope = vec3(0.0, 2.119_074_222_86, 1.126_731_750_69);
    vec![[at, x, slope], [at, slope, x], [vec3(0.0, -1.0, 0.0), x, vec3(0.0, 5.5, 0.0)]]
}

#[test]
fn sheds_hold_and_meet_the_tolerance() {
    for triangles in [false, true] {
        let set = surfaces(&sheds(), triangles);
        for tolerance in [1e-3, 1e-4, 1e-5] {
            let f = compute(&set, tolerance, [Some(1.0), Some(5.5)]);
            for (i, j, exact) in [(0, 1, 0.055_347), (0, 2, 0.041_263), (1, 2, 0.903_389)] {
                let ours = factor(&f, i, j);
                let off = (ours.value - exact).abs();
                assert!(off <= ours.radius + 6e-7, "{tolerance:e} {i} {j}: {ours:?} {exact}");
                assert!(ours.radius <= 2.0 * tolerance, "{tolerance:e} {i} {j}: {ours:?}");
            }
        }
    }
}

/// The walls of a canyon as two surfaces each, divided along the street: no cross-section serves.
#[test]
fn parts_of_a_period_hold() {
    let halves: Vec<[Vec3; 3]> = canyon(1.0, 0.6, 1.0)
        .into_iter()
        .flat_map(|[at, e, f]| {
            let [e, f, step] = if e.y == 0.0 { [e, f * 0.5, f * 0.5] } else { [e * 0.5, f, e * 0.5] };
            [[at, e, f], [at + step, e, f]]
        })
        .collect();
    let [street, walls, to_street, sky] = canyon_factors(1.0);
    for tolerance in [1e-3, 1e-4] {
        let f = compute(&surfaces(&halves, false), tolerance, [Some(1.6), Some(1.0)]);
        let f = f.combined(&[0, 0, 1, 1, 2, 2, 3, 3], 4);
        for (ours, exact) in [
            (factor(&f, 0, 1), street),
            (factor(&f, 1, 3), walls),
            (factor(&f, 3, 0), to_street),
            (f.sky(1), sky),
        ] {
            assert!((ours.value - exact).abs() <= ours.radius, "{tolerance:e}: {ours:?}, exact {exact}");
            assert!(ours.radius <= 2.0 * tolerance, "{tolerance:e}: {ours:?}");
        }
    }
}

/// Sheds of other proportions: the radii of few columns hold what many columns find.
#[test]
fn sheds_of_any_proportion_hold() {
    for (low, tilt, width, period) in
        [(0.01, 0.1f64, 1.0, 1.05), (3.0, 1.2, 1.0, 0.7), (0.2, 1.5, 10.0, 2.0), (0.0, 0.5, 1.0, 30.0)]
    {
        let (x, at) = (vec3(2.0, 0.0, 0.0), vec3(0.0, 0.0, low));
        let slope = vec3(0.0, width * tilt.cos(), width * tilt.sin());
        let set = surfaces(&[[at, x, slope], [at, slope, x], [Vec3::ZERO, x, vec3(0.0, period, 0.0)]], false);
        let of = |tolerance| compute(&set, tolerance, [Some(2.0), Some(period)]);
        let fine = of(1e-5);
        for tolerance in [1e-1, 1e-2, 1e-3] {
            let f = of(tolerance);
            for (i, j) in [(0, 1), (0, 2), (1, 2)] {
                let (ours, exact) = (factor(&f, i, j), factor(&fine, i, j));
                let off = (ours.value - exact.value).abs();
                assert!(
                    off <= ours.radius + exact.radius,
                    "{low} {tilt} {tolerance:e} {i} {j}: {ours:?} {exact:?}"
                );
            }
            for i in 0..3 {
                assert!(f.defects()[i].abs() <= f.row_radius(i), "{low} {tilt}: {}", f.defects()[i]);
            }
        }
    }
}
