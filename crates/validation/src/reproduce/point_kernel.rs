//! Error of formula (3), which evaluates the kernel at the centres of two voxels, as a function of their distance.

use std::f64::consts::PI;
use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_math::{Vec3, vec3};
use zonal_report::Failure;
use zonal_report::plot::{LOG_LOG, Plot, SeriesMark};
use zonal_report::{PageFolder, markdown, percent};

/// Relative excess of the exact factor of two unit cubes over formula (3): exact/(V²/(π d²)) − 1. `u` is the offset of the second cube.
fn relative_excess(u: [i32; 3]) -> f64 {
    let lo = vec3(u[0] as f64, u[1] as f64, u[2] as f64);
    let (a, b) = (Cuboid::voxel(Vec3::ZERO, Vec3::splat(1.0)), Cuboid::voxel(lo, lo + Vec3::splat(1.0)));
    geometric_factor(&a, &b, 0.0, 1e-12).bounded.value * PI * lo.length2() - 1.0
}

/// Writes the table and the plot, and returns the section of the page.
pub(super) fn write(folder: &PageFolder) -> Result<String, Failure> {
    let steps: Vec<i32> = (1..=12).chain([15, 20, 30, 50, 70, 100]).collect();
    let directions = [
        ([1, 0, 0], "along an axis"),
        ([1, 1, 0], "diagonal of a face"),
        ([1, 1, 1], "diagonal of the cube"),
    ];
    let mut plot = Plot::new(
        "Formula (3): relative error against distance (equal cubes)",
        "distance of the centres, voxels",
        "relative error",
        LOG_LOG,
    );
    let mut rows = Vec::new();
    for (k, (d, name)) in directions.into_iter().enumerate() {
        let mut points = Vec::new();
        for &n in &steps {
            let u = d.map(|x| x * n);
            let r = u.iter().map(|x| (x * x) as f64).sum::<f64>().sqrt();
            let e = relative_excess(u) / (1.0 + relative_excess(u));
            rows.push(vec![name.to_string(), format!("{r:.6}"), format!("{e:.9e}")]);
            points.push((r, e));
        }
        plot.add(name, SeriesMark::LineWithPoints, k, points);
    }
    plot.add(
        "1/(6 d²)",
        SeriesMark::Dashed,
        7,
        (1..=100).map(|n| (n as f64, 1.0 / (6.0 * (n * n) as f64))).collect(),
    );
    folder.table("point.csv", &["direction", "distance", "relative_error"], &rows)?;
    folder.plot("point.svg", &plot)?;
    let shown: Vec<Vec<String>> = [1, 2, 3, 5, 10, 30]
        .iter()
        .map(|&n| {
            vec![n.to_string(), percent(relative_excess([n, 0, 0]) / (1.0 + relative_excess([n, 0, 0])))]
        })
        .collect();
    Ok(format!(
        "## 3. Formula (3) against distance\n\n\
Geometry: two equal cubes of a voxel grid, no medium. The formula evaluates the kernel at the centres of both voxels.\n\n\
![formula (3)](point.svg) · [point.csv](point.csv)\n\n{}\n\
The paper's statement “An important error when they are close” is correct. The error decreases as 1/(6d²), and the factor is always too \
small: the mean of 1/r² is above its value at the centres.\n\n",
        markdown(&["distance along an axis, voxels", "too small by"], &shown)
    ))
}
