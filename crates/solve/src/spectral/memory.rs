//! Memory of the spectra and of a product of the spectral engine.

use super::basis::{BasisOrder, KernelLayout};
use super::grid::BoxGrid;
use super::volume::FREQUENCIES_PER_BLOCK;

/// Bytes of the spectra of one extinction.
pub(super) fn spectra_bytes(grid: &BoxGrid, order: BasisOrder) -> u64 {
    let [h0, h1, h2] = grid.halves().map(|h| h as u64);
    let [n0, n1, n2] = grid.cells.map(|n| n as u64);
    let kernels = |l: KernelLayout| l.densities.len() as u64;
    let mut all = kernels(order.volume_layout()) * h0 * h1 * h2;
    for a in grid.walled() {
        all += kernels(order.wall_layout(a)) * if a == 0 { n0 * h1 * h2 } else { h0 * h1 * h2 };
    }
    for pair in grid.corners() {
        let one = match pair {
            [0, 1] => n0 * n1 * h2,
            [0, _] => n0 * n2 * h1,
            _ => n1 * n2 * h0,
        };
        all += kernels(order.adjacent_layout(pair)) * one;
    }
    8 * all
}
/// Bytes of the buffers of one product, besides its input and output.
pub(super) fn work_bytes(grid: &BoxGrid, order: BasisOrder) -> u64 {
    let [voxel, patch] = [order.voxel_components(), order.patch_components()].map(|n| n as u64);
    let [n0, n1, _] = grid.lengths().map(|n| n as u64);
    let h2 = grid.halves()[2] as u64;
    let blocks = n1.div_ceil(FREQUENCIES_PER_BLOCK as u64);
    let partial = if grid.periodic[1] { 0 } else { 2 * blocks * h2 * n0 };
    16 * (voxel * blocks * FREQUENCIES_PER_BLOCK as u64 * grid.cells[0] as u64 * h2 + patch * partial)
        + patch * 16 * 8 * (n0 * n1 + (n0 + n1) * h2)
}
