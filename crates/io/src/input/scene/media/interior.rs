//! Voxels inside closed bodies, by the winding number along vertical lines through their centres.
//!
//! A point is inside if the signed crossings of the line below it do not cancel. Cost: the number of triangles times the voxel columns
//! that each one covers, plus the number of voxels.

use crate::input::scene::media::voxel_grid::VoxelGridBuilder;
use crate::input::scene::quantities::medium_properties::MediumProperties;
use zonal_math::Vec3;
use zonal_scene::Plate;

/// Position of the line of a column in its voxels along x and y: off the centre, so that no line runs along an edge of a mesh that is
/// drawn on the grid.
const COLUMN_LINE: [f64; 2] = [0.5 + 1.234e-7, 0.5 + 2.718e-7];

/// Crossings of a column's line: height, and +1 upward or −1 downward.
type Crossings = Vec<(f64, i32)>;

/// Fills the voxels whose centre lies inside closed plates; returns their number.
pub(crate) fn fill_interior(
    grid: &mut VoxelGridBuilder,
    plates: &[Plate],
    properties: &MediumProperties,
) -> usize {
    let [_, ny, nz] = grid.dims;
    let mut columns = column_crossings(grid, plates);
    let mut filled = 0;
    for (column, crossings) in columns.iter_mut().enumerate() {
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Count crossings upward: the winding number is that of all bodies around a point, whatever their orientation.
        let (mut winding, mut next) = (0, 0);
        for k in 0..nz {
            let z = grid.min.z + (k as f64 + 0.5) * grid.cell.z;
            while next < crossings.len() && crossings[next].0 <= z {
                winding += crossings[next].1;
                next += 1;
            }
            if winding != 0 {
                grid.fill([column / ny, column % ny, k], 1.0, properties);
                filled += 1;
            }
        }
    }
    filled
}

/// The crossings of the plates with the line of every column, columns with y fastest.
fn column_crossings(grid: &VoxelGridBuilder, plates: &[Plate]) -> Vec<Crossings> {
    let [nx, ny, _] = grid.dims;
    let [hx, hy] = COLUMN_LINE;
    let x_of = |i: usize| grid.min.x + (i as f64 + hx) * grid.cell.x;
    let y_of = |j: usize| grid.min.y + (j as f64 + hy) * grid.cell.y;
    let mut columns: Vec<Crossings> = vec![Vec::new(); nx * ny];
    let triangles = plates.iter().flat_map(|p| {
        let (c, n) = p.corners();
        (1..n - 1).map(move |k| [c[0], c[k], c[k + 1]])
    });
    for t in triangles {
        let [a, b, c] = t;
        let (lo, hi) = (a.min(b).min(c), a.max(b).max(c));
        let range = |lo: f64, hi: f64, min: f64, size: f64, n: usize| {
            let clamp = |x: f64| x.clamp(0.0, n as f64) as usize;
            clamp(((lo - min) / size).floor() - 1.0)..clamp(((hi - min) / size).ceil() + 1.0)
        };
        let up = (b - a).cross(c - a).z;
        if up == 0.0 {
            continue;
        }
        for i in range(lo.x, hi.x, grid.min.x, grid.cell.x, nx) {
            for j in range(lo.y, hi.y, grid.min.y, grid.cell.y, ny) {
                if let Some(z) = height_of_crossing(t, x_of(i), y_of(j)) {
                    columns[i * ny + j].push((z, if up > 0.0 { 1 } else { -1 }));
                }
            }
        }
    }
    columns
}

/// The height at which the vertical line through (x, y) crosses a triangle. Each edge is evaluated from its smaller end, so that a
/// shared edge belongs to exactly one of its triangles.
fn height_of_crossing([a, b, c]: [Vec3; 3], x: f64, y: f64) -> Option<f64> {
    let side = |p: Vec3, q: Vec3| {
        let swap = (q.x, q.y) < (p.x, p.y);
        let (p, q) = if swap { (q, p) } else { (p, q) };
        let s = (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x);
        (s >= 0.0) != swap
    };
    let s = side(a, b);
    if s != side(b, c) || s != side(c, a) {
        return None;
    }
    let n = (b - a).cross(c - a);
    Some(a.z - (n.x * (x - a.x) + n.y * (y - a.y)) / n.z)
}
