//! The paper's strips: the series against exact factors, its radius against the true error.

use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_math::{Vec3, low_discrepancy, vec3};
use zonal_paper::voxel_strips::{
    MomentQuadrature, StripAccuracy, StripCounts, UniformGrid, formfact, formfact_along,
    single_reference_strip,
};

fn cube(x: f64, y: f64, z: f64) -> Cuboid {
    Cuboid::voxel(vec3(x, y, z), vec3(x + 1.0, y + 1.0, z + 1.0))
}

fn exact(a: &Cuboid, b: &Cuboid) -> f64 {
    geometric_factor(a, b, 0.0, 1e-13).bounded.value
}

/// Offsets of the reference voxels.
const REFERENCE_OFFSETS: [[i32; 3]; 19] = [
    [3, 0, 0],
    [3, 1, 0],
    [3, 2, 2],
    [3, 3, 3],
    [4, 0, 0],
    [4, 3, 1],
    [5, 0, 0],
    [5, 2, 0],
    [5, 5, 0],
    [0, 6, 1],
    [2, 1, 7],
    [7, 7, 7],
    [0, 0, 9],
    [1, 10, 0],
    [10, 5, 2],
    [14, 0, 0],
    [0, 3, 17],
    [20, 1, 0],
    [12, 12, 1],
];

/// Tests the intervals of one strip; returns the ratios of radius and true error above 1e-12.
fn strip_radius_ratios(u: [i32; 3], axis: usize, order: usize) -> Vec<f64> {
    let v = cube(0.0, 0.0, 0.0);
    let reference = cube(u[0] as f64, u[1] as f64, u[2] as f64);
    let nearest = u.iter().map(|&x: &i32| ((x - 1).max(0) as f64).powi(2)).sum::<f64>().sqrt();
    let reach = (0.6 * nearest) as usize;
    let strip = single_reference_strip(&v, &reference, axis, reach, reach, order);
    let mut ratios = Vec::new();
    for j in -(reach as i32)..=reach as i32 {
        let p = j.abs() as f64 / nearest;
        let mut at = u;
        at[axis] += j;
        if !(0.1..=0.6).contains(&p) || at.iter().all(|x| x.abs() < 3) {
            continue;
        }
        let want = exact(&v, &cube(at[0] as f64, at[1] as f64, at[2] as f64));
        let got = strip.get((j + reach as i32) as usize);
        let off = (got.value - want).abs();
        assert!(off <= got.radius + 1e-13 * want, "{u:?} {axis} {j} N={order}: {off:e} {got:?}");
        if off > 1e-12 * want {
            ratios.push(got.radius / off);
        }
    }
    ratios
}

/// Strips on all axes, gap of two voxels at least, 0.1 ≤ p̂ ≤ 0.6, orders 5, 10, 20, pairs whose truncation error is above 1e-12.
#[test]
fn series_radius_is_close_to_the_true_error() {
    let mut ratios = Vec::new();
    for u in REFERENCE_OFFSETS {
        for axis in 0..3 {
            ratios.extend([5, 10, 20].into_iter().flat_map(|order| strip_radius_ratios(u, axis, order)));
        }
    }
    ratios.sort_by(f64::total_cmp);
    let (median, high) = (ratios[ratios.len() / 2], ratios[ratios.len() * 95 / 100]);
    println!("{} pairs, radius over true error: median {median:.1}, 95 % {high:.1}", ratios.len());
    assert!(ratios.len() > 500 && median <= 30.0 && high <= 1000.0, "{median} {high}");
}

/// Reference, axis, sign, j, and the relative errors of N = 5, 10, 20.
#[test]
fn series_errors_match_the_reference() {
    type Row = ([f64; 3], usize, i32, i32, [f64; 3]);
    let rows: [Row; 9] = [
        ([10.0, 0.0, 0.0], 0, 1, 1, [7.7e-6, 1.4e-10, 0.0]),
        ([10.0, 0.0, 0.0], 0, 1, 3, [6.5e-3, 2.8e-5, 3.4e-10]),
        ([10.0, 0.0, 0.0], 0, 1, 5, [1.6e-1, 8.9e-3, 1.8e-5]),
        ([10.0, 0.0, 0.0], 0, 1, 7, [1.3, 4.1e-1, 2.3e-2]),
        ([10.0, 0.0, 0.0], 1, 1, 5, [1.6e-2, 2.5e-4, 2.3e-7]),
        ([10.0, 0.0, 0.0], 1, 1, 9, [0.53, 0.28, 9.6e-2]),
        ([10.0, 0.0, 0.0], 0, -1, 5, [6.4e-2, 3.3e-3, 6.3e-6]),
        ([5.0, 0.0, 0.0], 1, 1, 3, [4.7e-2, 2.1e-3, 7.0e-6]),
        ([5.0, 0.0, 0.0], 1, 1, 9, [34.0, 1.1e3, 2.4e5]),
    ];
    let v = cube(0.0, 0.0, 0.0);
    for (u, axis, sign, j, errors) in rows {
        let reference = cube(u[0], u[1], u[2]);
        let (back, forth) = if sign > 0 { (0, j) } else { (j, 0) };
        let mut at = u;
        at[axis] += (sign * j) as f64;
        let want = exact(&v, &cube(at[0], at[1], at[2]));
        for (order, error) in [5, 10, 20].into_iter().zip(errors) {
            let strip = single_reference_strip(&v, &reference, axis, back as usize, forth as usize, order);
            let got = strip.get(if sign > 0 { j as usize } else { 0 });
            let off = (got.value / want - 1.0).abs();
            assert!((got.value - want).abs() <= got.radius + 1e-13 * want, "{u:?} {axis} {j} {order}");
            if error > 0.0 {
                // Two printed digits.
                assert!(
                    (off / error - 1.0).abs() < 0.06,
                    "{u:?} {axis} {j} {order}: {off:e} against {error:e}"
                );
            } else {
                assert!(off < 1e-13);
            }
        }
    }
}

/// Every factor of a grid within its radius and the radius within the tolerance; strips of every axis agree.
#[test]
fn grid_factors_meet_their_tolerance() {
    let cases = [
        (cube(-4.0, 0.0, 0.0), Vec3::splat(1.0), vec3(0.0, -3.0, -3.0), [6, 6, 6]),
        (cube(0.0, 0.0, 0.0), Vec3::splat(1.0), vec3(-3.0, -2.0, 0.0), [7, 4, 3]),
        (cube(0.3, 0.1, -7.0), vec3(0.7, 0.25, 1.4), vec3(-1.0, -1.0, -4.0), [5, 9, 4]),
        (
            Cuboid::voxel(vec3(0.0, 0.0, 0.0), vec3(0.2, 3.0, 1.1)),
            vec3(0.5, 0.6, 0.1),
            vec3(2.0, 1.0, -1.0),
            [11, 3, 20],
        ),
        (cube(1e4, 1e4, 1e4), vec3(0.5, 0.5, 0.5), vec3(1e4 + 2.0, 1e4, 1e4 - 3.0), [4, 6, 12]),
    ];
    for (v, cell, origin, dims) in cases {
        let grid = UniformGrid { origin, cell, dims };
        for tolerance in [1e-3, 1e-6, 1e-9, 1e-12] {
            for axis in 0..3 {
                let f = formfact_along(
                    &v,
                    &grid,
                    axis,
                    StripAccuracy::Tolerance(tolerance),
                    MomentQuadrature::Reduced,
                );
                for i in 0..grid.len() {
                    let c = [i / (dims[1] * dims[2]), i / dims[2] % dims[1], i % dims[2]];
                    let want = geometric_factor(&v, &grid.voxel(c), 0.0, 1e-13).bounded;
                    let b = f.get(i);
                    assert!(
                        (b.value - want.value).abs() <= b.radius + want.radius,
                        "{v:?} {c:?} {b:?} {want:?}"
                    );
                    assert!(b.radius <= tolerance * b.value, "{v:?} {c:?} {tolerance}: {b:?}");
                }
            }
        }
    }
}

#[test]
fn six_dimensional_moments_meet_their_tolerance() {
    let grid = UniformGrid { origin: vec3(3.0, -2.0, -2.0), cell: Vec3::splat(1.0), dims: [12, 5, 4] };
    let v = cube(0.0, 0.0, 0.0);
    for m in [3, 5] {
        let f = formfact(&v, &grid, StripAccuracy::Tolerance(1e-5), MomentQuadrature::SixDimensional(m));
        let StripCounts { series, direct, exact: integrals, .. } = f.counts;
        // A factor that misses the tolerance counts again as an integral.
        assert!(series + direct + integrals >= grid.len());
        for i in 0..grid.len() {
            let want = exact(&v, &grid.voxel([i / 20, i / 4 % 5, i % 4]));
            let b = f.get(i);
            assert!((b.value - want).abs() <= b.radius + 1e-13 * want && b.radius <= 1e-5 * want);
        }
    }
}

/// Random orders, ratios and boxes: the interval of a series holds the exact value, with the bounds of order and ratio.
#[test]
fn series_intervals_of_random_boxes_contain_the_exact_value() {
    let mut worst: f64 = 0.0;
    for i in 0..400 {
        let u: [f64; 8] = std::array::from_fn(|k| low_discrepancy::hash_to_unit((8 * i + k) as u64 + 12_345));
        let size = |x: f64| 10f64.powf(-1.0 + 1.5 * x);
        let e = vec3(size(u[0]), size(u[1]), size(u[2]));
        let v = Cuboid::voxel(
            vec3(0.1, 0.2, 0.3),
            vec3(0.1, 0.2, 0.3) + vec3(size(u[3]), size(u[4]), size(u[5])),
        );
        let axis = i % 3;
        let mut lo = vec3(4.0 + 6.0 * u[6], -3.0 + 6.0 * u[7], 1.0).array();
        lo.rotate_left(i / 3 % 3);
        let lo = vec3(lo[0], lo[1], lo[2]);
        let reference = Cuboid::voxel(lo, lo + e);
        let f = single_reference_strip(&v, &reference, axis, 2, 3, [0, 3, 7, 12, 25, 40][i % 6]);
        for j in -2i32..=3 {
            let mut shift = [0.0; 3];
            shift[axis] = j as f64 * e[axis];
            let shift = vec3(shift[0], shift[1], shift[2]);
            let b = Cuboid::voxel(lo + shift, lo + shift + e);
            let got = f.get((j + 2) as usize);
            let want = exact(&v, &b);
            let off = (got.value - want).abs();
            assert!(off <= got.radius + 4e-13 * want, "{i} {j}: {off:e} {got:?} {want}");
            worst = worst.max((off - 4e-13 * want) / got.radius);
        }
    }
    println!("largest error over radius {worst:.3}");
}
