//! The series for patches: radii contain the exact values and are close to the true error.

use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_exchange::{AccuracyRequest, Method};
use zonal_math::vec3;
use zonal_paper::patch_strips::{ZoneRow, row_factors, single_reference_row};

fn rows() -> Vec<ZoneRow> {
    let patch = |axis, sign| {
        let mut hi = [1.0, 1.0, 1.0];
        hi[axis] = 0.0;
        Cuboid::patch(vec3(0.0, 0.0, 0.0), vec3(hi[0], hi[1], hi[2]), axis, sign)
    };
    let voxel = |x, y, z| Cuboid::voxel(vec3(x, y, z), vec3(x + 1.0, y + 1.0, z + 1.0));
    let wall = |axis: usize, sign, at: [f64; 3]| {
        let mut hi = at.map(|x| x + 1.0);
        hi[axis] = at[axis];
        Cuboid::patch(vec3(at[0], at[1], at[2]), vec3(hi[0], hi[1], hi[2]), axis, sign)
    };
    let row = |from, first, axis| ZoneRow { from, first, axis, step: 1.0, count: 12 };
    vec![
        // A patch and voxels: along its normal, across it, seen from below.
        row(patch(2, 1), voxel(0.0, 0.0, 4.0), 2),
        row(patch(2, 1), voxel(-5.0, 1.0, 5.0), 0),
        row(patch(0, -1), voxel(-8.0, -3.0, 2.0), 1),
        row(patch(0, -1), voxel(-16.0, 0.0, 1.0), 0),
        // A voxel and patches.
        row(voxel(0.0, 0.0, 0.0), wall(1, -1, [-4.0, 5.0, 0.0]), 0),
        row(voxel(0.0, 0.0, 0.0), wall(1, -1, [1.0, 4.0, 0.0]), 1),
        // Two patches: parallel along and across the normal, perpendicular three ways.
        row(patch(2, 1), wall(2, -1, [1.0, 2.0, 4.0]), 2),
        row(patch(2, 1), wall(2, -1, [-6.0, 2.0, 5.0]), 0),
        row(patch(2, 1), wall(0, -1, [4.0, 0.0, 1.0]), 0),
        row(patch(2, 1), wall(0, -1, [5.0, -6.0, 1.0]), 1),
        row(patch(2, 1), wall(0, -1, [3.0, 0.0, 2.0]), 2),
        // Half of the row behind, one cut by the plane.
        ZoneRow { step: 0.7, ..row(patch(2, 1), voxel(6.0, 0.0, -4.0), 2) },
    ]
}

#[test]
fn series_intervals_of_rows_contain_the_exact_value() {
    let mut ratios = Vec::new();
    for row in rows() {
        for order in [5, 10, 20] {
            let all = single_reference_row(&row, 6, order);
            for (i, f) in all.iter().enumerate() {
                let want = geometric_factor(&row.from, &row.zone(i), 0.0, 1e-13).bounded;
                let off = (f.bounded.value - want.value).abs();
                assert!(off <= f.bounded.radius + want.radius, "{row:?} {i} N={order} {f:?} {want:?}");
                if f.method == Method::Series && off > 1e-11 * want.value && f.bounded.radius < want.value {
                    ratios.push(f.bounded.radius / off);
                }
            }
        }
    }
    ratios.sort_by(f64::total_cmp);
    let (median, high) = (ratios[ratios.len() / 2], ratios[ratios.len() * 95 / 100]);
    println!("{} pairs, radius over true error: median {median:.1}, 95 % {high:.1}", ratios.len());
    assert!(ratios.len() > 100 && median <= 30.0 && high <= 1000.0);
}

#[test]
fn row_factors_meet_their_tolerance() {
    let mut series = 0;
    for row in rows() {
        for tolerance in [1e-3, 1e-6, 1e-9] {
            for (i, f) in row_factors(&row, &AccuracyRequest::relative(tolerance)).iter().enumerate() {
                let want = geometric_factor(&row.from, &row.zone(i), 0.0, 1e-13).bounded;
                let off = (f.bounded.value - want.value).abs();
                assert!(off <= f.bounded.radius + want.radius, "{row:?} {i} {f:?} {want:?}");
                assert!(f.bounded.radius <= tolerance * f.bounded.value, "{row:?} {i} {tolerance} {f:?}");
                series += (f.method == Method::Series) as usize;
            }
        }
    }
    assert!(series > 300, "{series}");
}
