//! The division of the grid and of its spectra among processes.
//!
//! A rank has the voxels of some planes across x, and the frequencies f₁ of some blocks (`FREQUENCIES_PER_BLOCK`). A product transforms the own planes
//! along z and y, exchanges them for the own frequencies of all planes, transforms these along x and multiplies them with spectra, and goes back the same
//! way. Blocks that are mirrored in each other have one rank, since their spectra are equal: so a rank stores about 1/R of the spectra of voxels.
//!
//! Opposite and adjacent walls have n² patches against n³ voxels. Their values are on every rank; transforms of single walls, and the frequencies along an
//! edge, are shared.

use super::grid::BoxGrid;
use crate::distribution::fixed_tree::{self, SubtreeRoot};
use crate::distribution::part_of;
use crate::distribution::{Communicator, SingleProcess};
use std::ops::Range;

/// Frequencies along y of a block.
pub(crate) const FREQUENCIES_PER_BLOCK: usize = 8;

/// The parts of a grid that the ranks have.
#[derive(Clone, Copy)]
pub struct Slabs<'a> {
    /// The processes.
    pub communicator: &'a dyn Communicator,
    rank: usize,
    ranks: usize,
    planes: usize,
    frequencies: usize,
}

impl<'a> Slabs<'a> {
    /// The parts of these processes.
    pub fn new(grid: &BoxGrid, communicator: &'a dyn Communicator) -> Slabs<'a> {
        let of = Slabs::of_rank(grid, communicator.rank(), communicator.size());
        Slabs { communicator, ..of }
    }

    /// The parts of rank `rank` of `ranks`, for their sizes alone.
    pub(crate) fn of_rank(grid: &BoxGrid, rank: usize, ranks: usize) -> Slabs<'a> {
        Slabs {
            communicator: &SingleProcess,
            rank,
            ranks,
            planes: grid.cells[0],
            frequencies: grid.lengths()[1],
        }
    }

    /// Number of ranks.
    pub fn ranks(&self) -> usize {
        self.ranks
    }
    /// Number of this rank.
    pub fn rank(&self) -> usize {
        self.rank
    }
    /// The planes of voxels of a rank.
    pub(crate) fn planes_of(&self, rank: usize) -> Range<usize> {
        part_of(self.planes, rank, self.ranks())
    }
    /// The planes of voxels of this rank.
    pub fn planes(&self) -> Range<usize> {
        self.planes_of(self.rank())
    }
    /// Number of blocks of frequencies.
    pub(crate) fn block_count(&self) -> usize {
        self.frequencies.div_ceil(FREQUENCIES_PER_BLOCK)
    }
    /// The frequencies of a block.
    pub(crate) fn frequencies_of(&self, block: usize) -> Range<usize> {
        let first = block * FREQUENCIES_PER_BLOCK;
        first..(first + FREQUENCIES_PER_BLOCK).min(self.frequencies)
    }
    /// The blocks of a rank in two ascending runs, mirrored in each other; the second one is empty if they meet.
    pub(crate) fn runs_of(&self, rank: usize) -> [Range<usize>; 2] {
        // A rank has blocks of the lower half, of which the middle one of an odd number has no other mirror image, in proportion to their images.
        let (count, ranks) = (self.block_count(), self.ranks());
        let half = count.div_ceil(2);
        let edge = |r: usize| if r == ranks { half } else { (count * r).div_ceil(2 * ranks) };
        let (first, end) = (edge(rank), edge(rank + 1));
        if end == half { [first..count - first, 0..0] } else { [first..end, count - end..count - first] }
    }
    /// The blocks of a rank, ascending.
    pub(crate) fn blocks_of(&self, rank: usize) -> impl Iterator<Item = usize> + Clone + use<> {
        self.runs_of(rank).into_iter().flatten()
    }
    /// The blocks of this rank, ascending.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = usize> + Clone + use<> {
        self.blocks_of(self.rank())
    }
    /// The largest subtrees of blocks (`fixed_tree.rs`) that a rank has.
    pub(crate) fn subtrees_of(&self, rank: usize) -> Vec<SubtreeRoot> {
        let runs = self.runs_of(rank).into_iter();
        runs.flat_map(|run| fixed_tree::whole_subtrees(run, self.block_count())).collect()
    }
    /// The stored frequencies f₁ of a rank: its own, and the opposites of those above the middle.
    pub(crate) fn stored_of(&self, rank: usize) -> Range<usize> {
        let stored = |f: usize| f.min(self.frequencies - f);
        let all = || self.blocks_of(rank).flat_map(|b| self.frequencies_of(b)).map(stored);
        match (all().min(), all().max()) {
            (Some(first), Some(last)) => first..last + 1,
            _ => 0..0,
        }
    }
    /// The stored frequencies f₁ of this rank.
    pub fn stored(&self) -> Range<usize> {
        self.stored_of(self.rank())
    }
    /// This rank's part of `n` frequencies along an edge, or of `n` distances.
    pub(crate) fn own_part(&self, n: usize) -> Range<usize> {
        part_of(n, self.rank(), self.ranks())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::thread_ranks::on_ranks;

    #[test]
    fn every_block_has_one_rank_with_its_mirror_image() {
        for cells in [1, 2, 9, 50, 60, 115, 130] {
            for periodic in [false, true] {
                let grid = BoxGrid::new([cells; 3], [0.1; 3], [false, periodic, false]);
                for size in [1, 2, 3, 4, 7, 20] {
                    let all = on_ranks(size, |communicator| {
                        let slabs = Slabs::new(&grid, communicator);
                        let (blocks, stored) = (slabs.blocks().collect::<Vec<_>>(), slabs.stored());
                        assert!(blocks.is_sorted());
                        for &b in &blocks {
                            assert!(blocks.contains(&(slabs.block_count() - 1 - b)));
                            let of = |f: usize| f.min(grid.lengths()[1] - f);
                            assert!(slabs.frequencies_of(b).all(|f| stored.contains(&of(f))));
                        }
                        (blocks, slabs.planes(), slabs.block_count())
                    });
                    let (count, mut blocks, mut next) = (all[0].2, Vec::new(), 0);
                    for (own, planes, _) in all {
                        // Blocks are divided evenly, mirror images together.
                        assert!(own.len() <= 2 * count.div_ceil(2 * size), "{own:?}");
                        blocks.extend(own);
                        assert_eq!(planes.start, next);
                        next = planes.end;
                    }
                    blocks.sort_unstable();
                    assert_eq!((blocks, next), ((0..count).collect::<Vec<_>>(), cells));
                }
            }
        }
    }
}
