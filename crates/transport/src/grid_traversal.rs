//! Traversal of the voxel grid along a segment, cell by cell.
//!
//! On axis k the segment a + t d (|d| = 1, t in metres) passes the planes x_k = min_k + i h_k at t = (x_k − a_k)/d_k. The traversal
//! (Amanatides and Woo 1987) steps to the neighbour whose plane comes first. Every t is computed from the index of its plane, not
//! by summation, so errors do not accumulate; an index changes in one direction only, so there are at most n_x + n_y + n_z steps.
//! The pieces tile the clipped segment: their lengths sum to its length. A segment in a face of cells belongs to the cell above it,
//! in the topmost face to the cell below.

use zonal_math::Vec3;
use zonal_scene::VoxelGrid;

/// The part of a + t d, t0 ≤ t ≤ t1, inside the closed box [lo, hi].
#[inline]
pub(crate) fn clip(a: Vec3, d: Vec3, lo: Vec3, hi: Vec3, mut t0: f64, mut t1: f64) -> Option<(f64, f64)> {
    for k in 0..3 {
        if d[k] == 0.0 {
            if a[k] < lo[k] || a[k] > hi[k] {
                return None;
            }
            continue;
        }
        let (x, y) = ((lo[k] - a[k]) / d[k], (hi[k] - a[k]) / d[k]);
        let (near, far) = if x < y { (x, y) } else { (y, x) };
        t0 = if near > t0 { near } else { t0 };
        t1 = if far < t1 { far } else { t1 };
    }
    (t0 < t1).then_some((t0, t1))
}

/// The direction of a → b and the part of the segment, in metres from a, inside the voxel grid.
#[inline]
pub(crate) fn clip_to_grid(grid: &VoxelGrid, a: Vec3, b: Vec3) -> Option<(Vec3, f64, f64)> {
    let d = b - a;
    let length = d.length();
    if !(length > 0.0 && length.is_finite()) {
        return None;
    }
    let d = d / length;
    let (t0, t1) = clip(a, d, grid.min(), grid.max(), 0.0, length)?;
    Some((d, t0, t1))
}

/// A lattice of boxes.
#[derive(Clone, Copy)]
pub(crate) struct Lattice {
    /// Lower corner, m.
    pub min: Vec3,
    /// Edges of a box, m.
    pub edges: Vec3,
    /// Boxes along each axis.
    pub dims: [usize; 3],
}

impl Lattice {
    /// The cells of a grid.
    pub(crate) fn of(grid: &VoxelGrid) -> Lattice {
        Lattice { min: grid.min(), edges: grid.cell(), dims: grid.dims() }
    }
}

/// The axis of the smallest number, the first of equal ones.
#[inline(always)]
fn first_axis(t: [f64; 3]) -> usize {
    if t[0] <= t[1] && t[0] <= t[2] {
        0
    } else if t[1] <= t[2] {
        1
    } else {
        2
    }
}

/// Calls `each` with (cell, t0, t1) along a → b, t in metres from a.
#[inline]
pub(crate) fn traverse(grid: &VoxelGrid, a: Vec3, b: Vec3, each: &mut impl FnMut(usize, f64, f64)) {
    if let Some((d, start, end)) = clip_to_grid(grid, a, b) {
        traverse_lattice(Lattice::of(grid), a, d, start, end, each);
    }
}

/// Calls `each` with (box, t0, t1) along the part of the line a + t d, |d| = 1, from `start` to `end`, which lies in the lattice.
#[inline]
pub(crate) fn traverse_lattice(
    lattice: Lattice,
    a: Vec3,
    d: Vec3,
    start: f64,
    end: f64,
    each: &mut impl FnMut(usize, f64, f64),
) {
    let Lattice { min, edges: h, dims: n } = lattice;
    let stride = [(n[1] * n[2]) as isize, n[2] as isize, 1];
    // Find the first cell and, per axis, the next plane, the step and the remaining number of cells.
    let mut remaining = [0usize; 3];
    let mut plane = [0.0; 3];
    let mut step = [0isize; 3];
    let mut next = [f64::INFINITY; 3];
    let mut cell = 0isize;
    for k in 0..3 {
        let x = (a[k] + d[k] * start - min[k]) / h[k];
        let i = (x.max(0.0) as usize).min(n[k] - 1);
        cell += i as isize * stride[k];
        if d[k] > 0.0 {
            (remaining[k], plane[k], step[k]) = (n[k] - 1 - i, (i + 1) as f64, 1);
        } else if d[k] < 0.0 {
            (remaining[k], plane[k], step[k]) = (i, i as f64, -1);
        }
        if step[k] != 0 {
            next[k] = (min[k] + h[k] * plane[k] - a[k]) / d[k];
        }
    }
    // Step to the neighbour whose plane comes first.
    let mut t = start;
    loop {
        let k = first_axis(next);
        let stop = if remaining[k] == 0 { end } else { next[k].min(end) };
        if stop > t {
            each(cell as usize, t, stop);
            t = stop;
        }
        if t >= end || remaining[k] == 0 {
            return;
        }
        remaining[k] -= 1;
        plane[k] += step[k] as f64;
        next[k] = (min[k] + h[k] * plane[k] - a[k]) / d[k];
        cell += step[k] * stride[k];
    }
}
