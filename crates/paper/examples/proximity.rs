//! The proximity development against cell-by-cell integration, one thread: `cargo run --release -p zonal-paper --example proximity`.
//!
//! Meshes of n × n cells of each kind of surface, a patch in front of them. A development costs one series a node and reference and
//! (N+1)(N+2)/2 products a cell, the baseline p⁴ kernels a cell (p the fewest points that reach the tolerance in every eighth cell).

use std::time::Instant;
use zonal_exchange::AccuracyRequest;
use zonal_math::vec3;
use zonal_paper::proximity::{
    CellFactor, MeshFactors, ParametricMesh, SmoothSurface, direct_integral, mesh_factors,
};
use zonal_scene::Plate;

fn main() {
    let axis = vec3(0.0, 0.0, 1.0);
    let o = vec3(0.0, 0.0, 0.0);
    let (x, y) = (vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    let kinds = [
        ("plane", SmoothSurface::plane(o, x, y), [0.0, 0.0]),
        ("ruled", SmoothSurface::ruled(o, x, y, vec3(0.0, 0.0, 0.5)), [0.0, 0.0]),
        ("cylinder", SmoothSurface::cylinder(o, axis, 1.0), [0.0, 0.0]),
        ("cone", SmoothSurface::cone(o, axis, 0.5), [0.0, 2.0]),
        ("sphere", SmoothSurface::sphere(o, axis, 1.0), [0.0, 0.0]),
    ];
    println!(
        "surface    cells     tol  order  refs  series      ms    us/cell | points  baseline ms  speed-up"
    );
    for (name, s, at) in kinds {
        let n = s.normal(at[0], at[1]).normalized();
        let (t, b) = n.frame();
        let plate = Plate::parallelogram(s.at(at[0], at[1]) + n * 1.5 - (t + b) * 0.15, b * 0.3, t * 0.3);
        for cells in [20, 80] {
            let mesh =
                ParametricMesh::regular([at[0] - 0.4, at[1] - 0.4], [at[0] + 0.4, at[1] + 0.4], cells, cells);
            for (tolerance, orders) in [(1e-3, [3, 4, 6]), (1e-6, [8, 10, 14]), (1e-9, [12, 16, 20])] {
                compare(name, &s, &plate, &mesh, tolerance, orders);
            }
        }
    }
}

/// Times the development at the best of `orders` and the baseline with the fewest sufficient points, and prints a row.
fn compare(
    name: &str,
    s: &SmoothSurface,
    plate: &Plate,
    mesh: &ParametricMesh,
    tolerance: f64,
    orders: [usize; 3],
) {
    let cells = mesh.cells()[0];
    let patch =
        |k: usize| [[mesh.u[k / cells], mesh.u[k / cells + 1]], [mesh.v[k % cells], mesh.v[k % cells + 1]]];
    let sample: Vec<usize> = (0..cells * cells).step_by(7).collect();
    let want: Vec<f64> =
        sample.iter().map(|k| direct_integral(s, patch(*k), plate, 8).bounded.value).collect();
    let good = |p: &usize| {
        sample.iter().zip(&want).all(|(k, w)| {
            (direct_integral(s, patch(*k), plate, *p).bounded.value / w - 1.0).abs() <= tolerance
        })
    };
    let points = (2..8).find(good).unwrap_or(8);
    // The rule and the coarser one that estimates its error, as `direct` does.
    let clock = Instant::now();
    let sum: f64 =
        (0..cells * cells).map(|k| direct_integral(s, patch(k), plate, points).bounded.value).sum();
    let baseline = clock.elapsed().as_secs_f64() * 1e3;
    let demand = AccuracyRequest::relative(tolerance);
    let runs = orders.map(|order| {
        let mut best = f64::INFINITY;
        let mut row: MeshFactors = mesh_factors(s, mesh, plate, order, &demand);
        for _ in 0..3 {
            let clock = Instant::now();
            row = mesh_factors(s, mesh, plate, order, &demand);
            best = best.min(clock.elapsed().as_secs_f64() * 1e3);
        }
        (best, order, row)
    });
    let (ms, order, row) = runs.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    let total: f64 =
        row.cells.iter().map(|c| if let CellFactor::Factor(f) = c { f.bounded.value } else { 0.0 }).sum();
    assert!((total / sum - 1.0).abs() < tolerance);
    println!(
        "{name:9} {:6} {tolerance:7.0e} {order:6} {:5} {:7} {ms:7.2} {:10.3} | {points:6} {baseline:12.2} {:9.1}",
        cells * cells,
        row.references,
        row.evaluations,
        1e3 * ms / (cells * cells) as f64,
        baseline / ms
    );
}
