//! Memory of the spectra and of a product of the spectral engine.

use super::basis::{BasisOrder, KernelLayout};
use super::grid::BoxGrid;
use super::kernels::shares_adjacent;
use super::slabs::Slabs;
use super::transposition::batch_planes;
use super::volume::FREQUENCIES_PER_BLOCK;

/// Bytes of the spectra of one extinction that a rank has.
pub(super) fn spectra_bytes(grid: &BoxGrid, order: BasisOrder, slabs: &Slabs) -> u64 {
    let [h0, _, h2] = grid.halves().map(|h| h as u64);
    let h1 = slabs.stored().len() as u64;
    let [n0, n1, n2] = grid.cells.map(|n| n as u64);
    let edge = |axis: usize| slabs.own_part(grid.halves()[axis]).len() as u64;
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
            [0, 1] => n0 * n1 * edge(2),
            [0, _] => n0 * n2 * edge(1),
            _ => n1 * n2 * edge(0),
        };
        all += kernels(order.adjacent_layout(pair)) * one;
    }
    8 * all
}

/// Bytes of the buffers of one product of a rank, besides its input and output.
pub(super) fn work_bytes(grid: &BoxGrid, order: BasisOrder, slabs: &Slabs) -> u64 {
    let [voxel, patch] = [order.voxel_components(), order.patch_components()].map(|n| n as u64);
    let [n0, n1, _] = grid.lengths().map(|n| n as u64);
    let h2 = grid.halves()[2] as u64;
    let blocks = slabs.blocks().count() as u64;
    let partial = if grid.periodic[1] { 0 } else { 2 * blocks * h2 * n0 };
    let piece = FREQUENCIES_PER_BLOCK as u64 * h2;
    // Planes on their way, sent and received.
    let batch = match slabs.ranks() {
        1 => 0,
        _ => 2 * slabs.block_count() as u64 * piece * batch_planes(slabs, piece as usize) as u64,
    };
    16 * (voxel * blocks * piece * grid.cells[0] as u64 + patch * partial + batch)
        + patch * 16 * 8 * (n0 * n1 + (n0 + n1) * h2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::Execution;
    use crate::distribution::tests::on_ranks;
    use crate::spectral::basis::KernelSet;
    use crate::spectral::kernels::GridKernels;
    use std::sync::Arc;
    use zonal_scene::NoProgress;

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
                for ranks in [1, 3] {
                    let all = on_ranks(ranks, |communicator| {
                        let slabs = Slabs::new(&grid, Execution { communicator, progress: &NoProgress });
                        let kernels = GridKernels::new(&grid, 0.7, order, slabs, &mut Vec::new());
                        [bytes_of_kernels(&kernels), spectra_bytes(&grid, order, &slabs)]
                    });
                    all.iter().for_each(|[found, want]| assert_eq!(found, want, "{cells:?} {order:?} {ranks}"));
                }
            }
        }
        // Adjacent walls of a cube share one kernel.
        let grid = BoxGrid::new([4; 3], [0.25; 3], [false; 3]);
        let slabs = Slabs::of_rank(&grid, 0, 1);
        let kernels = GridKernels::new(&grid, 0.7, BasisOrder::Constant, slabs, &mut Vec::new());
        assert!(Arc::ptr_eq(&kernels.adjacent[0], &kernels.adjacent[2]));
    }
}
