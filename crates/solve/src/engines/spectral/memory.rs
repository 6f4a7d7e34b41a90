//! Memory of the spectra and of a product of the spectral engine on the processor, and bytes of its messages.

use super::cpu::transposition::batch_planes;
use super::cpu::wall_sums::walls;
use super::kernels::shares_adjacent;
use crate::device::basis::{BasisOrder, KernelLayout};
use crate::device::grid::BoxGrid;
use crate::device::slabs::{FREQUENCIES_PER_BLOCK, Slabs};

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

/// Bytes that a rank of several sends for one product in a band.
pub(crate) fn sent_bytes_of_product(grid: &BoxGrid, order: BasisOrder, rank: usize, ranks: usize) -> u64 {
    let (slabs, others) = (Slabs::of_rank(grid, rank, ranks), ranks - 1);
    let ([voxel, patch], [l0, l1, _], h2) =
        ([order.voxel_components(), order.patch_components()], grid.lengths(), grid.halves()[2]);
    // Planes for frequencies, and frequencies for planes.
    let (planes, blocks, piece) = (slabs.planes().len(), slabs.blocks().count(), FREQUENCIES_PER_BLOCK * h2);
    let there = planes * (slabs.block_count() - blocks) * piece;
    let back = blocks * (grid.cells[0] - planes) * piece;
    // Spectra of walls to all, parts of the sums for walls of other ranks, and values of walls to all.
    let spectrum = [l1 * h2, l0 * h2, l0 * l1];
    let part = [
        blocks * piece,
        slabs.subtrees_of(rank).len() * l0 * h2,
        slabs.blocks().flat_map(|b| slabs.frequencies_of(b)).count() * l0,
    ];
    let (mut complex, mut real) = (voxel * (there + back), 0);
    for (w, wall) in walls(grid).into_iter().enumerate() {
        let axis = wall.axis;
        if w % ranks == rank {
            complex += patch * spectrum[axis] * others;
            real += patch * grid.patches(axis) * others;
        } else {
            complex += patch * part[axis];
        }
    }
    // Walls along their edges: frequencies of own walls, products of own frequencies, and values to all.
    let edges = grid.corners().flat_map(|[a, b]| [(a, 3 - a - b), (b, 3 - a - b)]);
    for (e, (across, along)) in edges.enumerate() {
        let (line, all) = (2 * grid.cells[3 - across - along], grid.halves()[along]);
        let own = slabs.own_part(all).len();
        if e % ranks == rank {
            complex += patch * line * (all - own);
            real += 2 * patch * grid.patches(across) * others;
        } else {
            complex += patch * line * own;
        }
    }
    (16 * complex + 8 * real) as u64
}

/// Most voxels of a grid whose bands have their products at the same time: a product of a small grid has too few parts for many threads.
const MAX_VOXELS_OF_BANDS_TOGETHER: usize = 1 << 17;

/// True if all bands have their products at the same time, each with buffers of its own. Processes exchange messages band by band.
pub(super) fn runs_bands_together(grid: &BoxGrid, ranks: usize) -> bool {
    ranks == 1 && grid.count() <= MAX_VOXELS_OF_BANDS_TOGETHER
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::spectra::{GridSpectra, KernelSet};
    use crate::device::{Device, GridPart};
    use crate::distribution::SingleProcess;
    use crate::distribution::thread_ranks::on_ranks;
    use crate::engines::spectral::cpu::Processor;
    use crate::engines::spectral::kernels::GridKernels;
    use std::sync::Arc;

    fn spectra_of(part: &GridPart) -> GridSpectra {
        GridKernels::new(part, 0.7, &mut Vec::new()).spectra
    }

    /// Bytes of the distinct spectra of voxels and of adjacent walls; those of opposite walls have two dimensions and are not counted.
    fn bytes_of_kernels(k: &GridSpectra) -> u64 {
        let of = |set: &KernelSet| set.arrays.iter().map(|a| 8 * a.data.len() as u64).sum::<u64>();
        let distinct = |i: usize| !k.adjacent[..i].iter().any(|other| Arc::ptr_eq(other, &k.adjacent[i]));
        let adjacent = (0..3).filter(|&i| distinct(i)).map(|i| of(&k.adjacent[i])).sum::<u64>();
        of(&k.volume) + k.walls.iter().map(of).sum::<u64>() + adjacent
    }

    #[test]
    fn expected_messages_are_those_of_a_product() {
        use crate::distribution::CountedRanks;
        for cells in [[7, 10, 9], [20, 4, 5]] {
            for (order, ranks) in
                [(BasisOrder::Constant, 2), (BasisOrder::Constant, 5), (BasisOrder::Linear, 3)]
            {
                let grid = BoxGrid::new(cells, [0.25; 3], [false; 3]);
                on_ranks(ranks, |communicator| {
                    let counted = CountedRanks::new(communicator);
                    let part = GridPart::new(grid, order, &counted);
                    let mut convolution = Processor.convolution(part);
                    convolution.load(spectra_of(&part));
                    let before = counted.sent();
                    let mut voxels = vec![0.0; order.voxel_components() * part.own_voxels()];
                    convolution.exchange(0, &mut voxels, &part.zero_walls());
                    let found = counted.sent().bytes - before.bytes;
                    let want = sent_bytes_of_product(&grid, order, communicator.rank(), ranks);
                    assert_eq!(found, want, "{cells:?} {order:?} rank {} of {ranks}", communicator.rank());
                });
            }
        }
    }

    #[test]
    fn expected_bytes_are_those_of_the_spectra() {
        for cells in [[4, 4, 4], [3, 5, 5], [2, 3, 4]] {
            for order in [BasisOrder::Constant, BasisOrder::Linear] {
                let grid = BoxGrid::new(cells, [0.25; 3], [false; 3]);
                for ranks in [1, 3] {
                    let all = on_ranks(ranks, |communicator| {
                        let part = GridPart::new(grid, order, communicator);
                        [bytes_of_kernels(&spectra_of(&part)), spectra_bytes(&grid, order, &part.slabs)]
                    });
                    all.iter()
                        .for_each(|[found, want]| assert_eq!(found, want, "{cells:?} {order:?} {ranks}"));
                }
            }
        }
        // Adjacent walls of a cube share one kernel.
        let grid = BoxGrid::new([4; 3], [0.25; 3], [false; 3]);
        let kernels = spectra_of(&GridPart::new(grid, BasisOrder::Constant, &SingleProcess));
        assert!(Arc::ptr_eq(&kernels.adjacent[0], &kernels.adjacent[2]));
    }
}
