//! Shaft culling against random segments between two zones, and against simple cases.
use crate::common;
use common::*;
use zonal_math::{Vec3, vec3};
use zonal_scene::Plate;
use zonal_transport::{ShaftEnd, Transport};

fn corners(lo: Vec3, hi: Vec3) -> [Vec3; 8] {
    std::array::from_fn(|k| {
        let pick = |bit: usize, l: f64, h: f64| if k >> bit & 1 == 1 { h } else { l };
        vec3(pick(0, lo.x, hi.x), pick(1, lo.y, hi.y), pick(2, lo.z, hi.z))
    })
}

fn whole(points: &[Vec3]) -> ShaftEnd<'_> {
    ShaftEnd { points, front: None }
}

/// A random point of a convex hull: a mean with random weights.
fn inside(points: &[Vec3], rng: &mut TestRng) -> Vec3 {
    let w: Vec<f64> = points.iter().map(|_| rng.uniform().powi(4)).collect();
    let sum: f64 = w.iter().sum();
    points.iter().zip(w).fold(Vec3::ZERO, |x, (p, w)| x + *p * (w / sum))
}

#[test]
fn culled_facets_occlude_no_segment() {
    let mut rng = TestRng(11);
    let (mut clear, mut seen) = (0, 0);
    for k in 0..600 {
        let mut plates = room(Vec3::ZERO, Vec3::splat(1.0));
        for _ in 0..1 + k % 40 {
            let edge = |rng: &mut TestRng| (rng.point() - Vec3::splat(0.5)) * 0.3;
            let (o, e1, e2) = (rng.point() * 0.7 + Vec3::splat(0.15), edge(&mut rng), edge(&mut rng));
            plates.push(if k % 2 == 0 {
                Plate::parallelogram(o, e1, e2)
            } else {
                Plate::triangle(o, o + e1, o + e2)
            });
        }
        let s = plain(&plates, None);
        let t = Transport::new(&s);
        for _ in 0..20 {
            // Boxes, and every third zone a plate in any position.
            let zone = |rng: &mut TestRng| {
                let (lo, e) = (rng.point() * 0.8, rng.point() * 0.2);
                match (rng.uniform() * 3.0) as u8 {
                    0 => vec![lo, lo + vec3(e.x, 0.0, e.z), lo + vec3(0.0, e.y, 0.1)],
                    _ => corners(lo, lo + e).to_vec(),
                }
            };
            let (a, b) = (zone(&mut rng), zone(&mut rng));
            let may = t.may_occlude([whole(&a), whole(&b)]);
            assert_eq!(may, t.may_occlude([whole(&b), whole(&a)]));
            let blocked = (0..40).any(|_| t.occluded_inside(inside(&a, &mut rng), inside(&b, &mut rng)));
            assert!(may || !blocked, "{a:?} {b:?}");
            clear += !may as usize;
            seen += (may && blocked) as usize;
        }
    }
    // Many pairs are culled, and many of the others are occluded.
    assert!(clear > 3000 && seen > 1500, "{clear} culled, {seen} occluded");
}

#[test]
fn walls_beside_the_shaft_are_culled_and_intruding_walls_are_not() {
    // An L of two rooms: the walls at its inner corner occlude.
    let mut plates = room(Vec3::ZERO, vec3(2.0, 2.0, 1.0));
    plates.push(Plate::parallelogram(vec3(1.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0)));
    plates.push(Plate::parallelogram(vec3(1.0, 1.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)));
    let s = plain(&plates, None);
    let t = Transport::new(&s);
    assert_eq!(t.occluder_count(), 2);
    let cell = |i: i32, j: i32| {
        let lo = vec3(0.5 * i as f64, 0.5 * j as f64, 0.0);
        corners(lo, lo + vec3(0.5, 0.5, 1.0))
    };
    let may = |a: &[Vec3], b: &[Vec3]| t.may_occlude([whole(a), whole(b)]);
    // Along an arm the walls are touched but never crossed.
    assert!(
        !may(&cell(0, 0), &cell(3, 1)) && !may(&cell(2, 1), &cell(3, 1)) && !may(&cell(1, 0), &cell(1, 3))
    );
    // From the square where the arms meet, and around the corner.
    assert!(!may(&cell(1, 1), &cell(2, 1)) && !may(&cell(1, 1), &cell(1, 2)));
    assert!(may(&cell(2, 1), &cell(1, 2)) && may(&cell(3, 0), &cell(0, 3)));
    // In the bounding box of both zones, but outside the shaft.
    assert!(!may(&cell(2, 0), &cell(0, 2)));
    let patch = [vec3(1.0, 1.0, 0.2), vec3(1.5, 1.0, 0.2), vec3(1.5, 1.0, 0.7)];
    assert!(!may(&patch, &cell(3, 0)));
    // A one-sided zone has no segments behind it.
    let (slanted, up) =
        ([vec3(0.9, 1.0, 0.0), vec3(1.1, 1.0, 0.0), vec3(1.0, 1.0, 0.5)], vec3(0.0, -1.0, 0.0));
    let around = corners(vec3(0.5, 0.5, 0.0), vec3(0.9, 1.5, 1.0));
    assert!(may(&slanted, &around));
    assert!(!t.may_occlude([ShaftEnd { points: &slanted, front: Some(up) }, whole(&around)]));
}
