//! A box with cells of longer edges, whose equations correct the iteration ([`crate::iteration::coarse_system`]).

use super::enclosure::{BoxEnclosure, OPENING};
use crate::device::grid::{BoxGrid, OTHER_AXES};
use crate::distribution::zone_blocks::ZoneBlocks;
use std::ops::Range;

/// Fewest voxels of a box whose iteration is worth the tables of a second grid.
const MIN_VOXELS: usize = 1 << 17;
/// Fewest voxels of a block.
const MIN_VOXELS_PER_BLOCK: usize = 8;
/// Voxels of a block along an axis, the best first: the first divisor of the number of cells counts.
const BLOCK_LENGTHS: [usize; 7] = [4, 5, 6, 3, 7, 8, 2];

/// The box of the blocks of an enclosure with a number of patches, whose vectors have the voxels of `planes`; `None` for a box of few voxels, or whose
/// numbers of cells have no small divisors.
pub(super) fn divide(
    enclosure: &BoxEnclosure,
    planes: Range<usize>,
    patches: usize,
) -> Option<(BoxEnclosure, ZoneBlocks)> {
    Some(divide_by(enclosure, planes, patches, block_lengths(&enclosure.grid)?))
}

/// As [`divide`], by blocks of these numbers of voxels.
pub(super) fn divide_by(
    enclosure: &BoxEnclosure,
    planes: Range<usize>,
    patches: usize,
    lengths: [usize; 3],
) -> (BoxEnclosure, ZoneBlocks) {
    let fine = &enclosure.grid;
    let grid = merged(fine, lengths);
    // Number the patches of the blocks wall by wall.
    let (mut of_patch, mut patch_sizes) = (vec![0; patches], Vec::new());
    let faces = [0, 1, 2].map(|axis| {
        [0, 1].map(|side| {
            let [b, c] = OTHER_AXES[axis];
            let first = patch_sizes.len();
            let count = if grid.periodic[axis] { 0 } else { grid.patches(axis) };
            patch_sizes.resize(first + count, (lengths[b] * lengths[c]) as f64);
            for (at, &zone) in enclosure.faces[axis][side].iter().enumerate() {
                if zone != OPENING {
                    let [i, j] = [at / fine.cells[c] / lengths[b], at % fine.cells[c] / lengths[c]];
                    of_patch[zone as usize] = (first + i * grid.cells[c] + j) as u32;
                }
            }
            (first..first + count).map(|i| i as u32).collect::<Vec<u32>>()
        })
    });
    let blocks = ZoneBlocks { patches: of_patch, patch_sizes, cells: fine.cells, lengths, planes };
    (BoxEnclosure { grid, kappa: enclosure.kappa, faces, outside: Vec::new() }, blocks)
}

/// The grid of the blocks of a grid, if there are any.
pub(crate) fn grid_of_blocks(fine: &BoxGrid) -> Option<BoxGrid> {
    block_lengths(fine).map(|lengths| merged(fine, lengths))
}

/// Bytes of the vectors over blocks.
pub(super) fn bytes_of_vectors(fine: &BoxGrid, grid: &BoxGrid) -> u64 {
    let patches: usize = grid.walled().map(|a| 2 * grid.patches(a)).sum();
    // Weights, norms and targets; vectors and roots of the iteration in all bands, and the sums of each plane of voxels on their way between processes.
    let sums = 3 * fine.cells[0] * grid.cells[1] * grid.cells[2];
    ((56 + 6 * 24) * (grid.count() + patches) + 24 * sums) as u64
}

/// The grid of cells that have some cells of another grid along each axis.
fn merged(fine: &BoxGrid, lengths: [usize; 3]) -> BoxGrid {
    let cells = [0, 1, 2].map(|k| fine.cells[k] / lengths[k]);
    let edges = [0, 1, 2].map(|k| fine.edges[k] * lengths[k] as f64);
    BoxGrid::new(cells, edges, fine.periodic)
}

/// Voxels of a block along each axis.
fn block_lengths(grid: &BoxGrid) -> Option<[usize; 3]> {
    let length = |n: usize| BLOCK_LENGTHS.into_iter().find(|l| n.is_multiple_of(*l)).unwrap_or(1);
    let lengths = grid.cells.map(length);
    let block: usize = lengths.iter().product();
    (grid.count() >= MIN_VOXELS && block >= MIN_VOXELS_PER_BLOCK).then_some(lengths)
}
