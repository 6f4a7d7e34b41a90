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
    // 1 + h − √(1 + h²) and √(1 + h²) − h, √(1 + h²) − 1 without cancellation.
    let side = 2.0 * h / (1.0 + h + diagonal);
    let across = 1.0 / (diagonal + h);
    let _ = across;
    [0.5 * side, (diagonal - 1.0) / h, 0.5 * side / h, 0.5 * side / h]
}

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
                println!(
                    "{h} {block} {along} {triangles} {tolerance:e} {what}: {} ± {:.1e}, off {off:.1e}",
                    ours.value, ours.radius
                );
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
            let begin = std::time::Instant::now();
            let f = compute(&set, tolerance, [Some(1.0), Some(5.5)]);
            println!("{:?}", begin.elapsed());
            for (i, j, exact) in [(0, 1, 0.055_347), (0, 2, 0.041_263), (1, 2, 0.903_389)] {
                let ours = factor(&f, i, j);
                let off = (ours.value - exact).abs();
                println!(
                    "{triangles} {tolerance:e} {i} {j}: {} ± {:.1e}, off {off:.1e}",
                    ours.value, ours.radius
                );
                assert!(off <= ours.radius + 6e-7, "{tolerance:e} {i} {j}: {ours:?} {exact}");
                assert!(ours.radius <= 2.0 * tolerance, "{tolerance:e} {i} {j}: {ours:?}");
            }
        }
    }
}
