//! Memory of the spectra and of a product of the spectral engine.

use super::basis::{BasisOrder, KernelLayout};
use super::grid::BoxGrid;
use super::kernels::shares_adjacent;
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
    let pairs: Vec<[usize; 2]> = grid.corners().collect();
    for (k, &pair) in pairs.iter().enumerate() {
        if pairs[..k].iter().any(|other| shares_adjacent(grid, order, pair, *other)) {
            continue;
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectral::basis::KernelSet;
    use crate::spectral::kernels::GridKernels;
    use std::sync::Arc;

    /// Bytes of the distinct spectra of voxels and of adjacent walls; those of opposite walls have two dimensions and are not counted.
    fn bytes_of_kernels(k: &GridKernels) -> u64 {
        let of = |set: &KernelSet| set.arrays.iter().map(|a| 8 * a.data.len() as u64).sum::<u64>();
        let distinct = |i: usize| !k.adjacent[..i].iter().any(|other| Arc::ptr_eq(other, &k.adjacent[i]));
        let adjacent = (0..3).filter(|&i| distinct(i)).map(|i| of(&k.adjacent[i])).sum::<u64>();
        of(&k.volume) + k.walls.iter().map(of).sum::<u64>() + adjacent
    }

    #[test]
    fn expected_bytes_are_those_of_the_spectra() {
        for cells in [[4, 4, 4], [3, 5, 5], [2, 3, 4]] {
            for order in [BasisOrder::Constant, BasisOrder::Linear] {
                let grid = BoxGrid::new(cells, [0.25; 3], [false; 3]);
                let kernels = GridKernels::new(&grid, 0.7, order, &mut Vec::new());
                assert_eq!(bytes_of_kernels(&kernels), spectra_bytes(&grid, order), "{cells:?} {order:?}");
            }
        }
        // Adjacent walls of a cube share one kernel.
        let grid = BoxGrid::new([4; 3], [0.25; 3], [false; 3]);
        let kernels = GridKernels::new(&grid, 0.7, BasisOrder::Constant, &mut Vec::new());
        assert!(Arc::ptr_eq(&kernels.adjacent[0], &kernels.adjacent[2]));
    }
}
