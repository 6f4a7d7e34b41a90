//! Radiation of the voxels incident on the walls, summed over the blocks of frequencies f₁.
//!
//! | wall | sum |
//! |---|---|
//! | across x | none: every block has the spectrum at its own frequencies |
//! | across y | over all f₁, along a tree of fixed shape (`fixed_tree.rs`) |
//! | across z | none over f₁; over f₂ within the block |
//!
//! Each wall is completed by one rank, to which the others send their parts.

use super::line_exchange::ZERO;
use crate::device::GridPart;
use crate::device::grid::BoxGrid;
use crate::device::slabs::FREQUENCIES_PER_BLOCK;
use crate::distribution::fixed_tree::{self, SubtreeRoot};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::BTreeMap;
use zonal_fourier::Complex64;
use zonal_math::simd::{complex_bytes, complex_bytes_mut};

/// Numbers that one task adds.
const NUMBERS_PER_TASK: usize = 1 << 12;

/// One of the walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::engines::spectral) struct BoxWall {
    /// The axis that it stands across.
    pub axis: usize,
    /// 0 for the low one, 1 for the high one.
    pub side: usize,
}

/// Sums of a block of frequencies for the walls; empty across periodic axes.
pub(super) struct WallSums {
    /// Walls across x: `[side][component][f₂][f₁ of the block]`.
    pub(super) x: [Vec<Complex64>; 2],
    /// Walls across y: `[side][component][f₂][f₀]`, this block's part of the sum.
    pub(super) y: [Vec<Complex64>; 2],
    /// Walls across z: `[side][component][f₁ of the block][f₀]`.
    pub(super) z: [Vec<Complex64>; 2],
}

impl WallSums {
    /// Sets all sums to zero.
    pub(super) fn clear(&mut self) {
        [&mut self.x, &mut self.y, &mut self.z].into_iter().flatten().for_each(|s| s.fill(ZERO));
    }

    fn of_axis(&self, axis: usize) -> &[Vec<Complex64>; 2] {
        [&self.x, &self.y, &self.z][axis]
    }
}

/// Shapes of the sums.
#[derive(Clone, Copy)]
pub(super) struct WallSumLayout<'a> {
    pub(super) part: GridPart<'a>,
}

/// Weight of a frequency along z, which also represents its opposite.
#[inline(always)]
pub(super) fn half_weight(grid: &BoxGrid, f2: usize) -> f64 {
    let own = f2 == 0 || 2 * f2 == grid.lengths()[2];
    if own { 0.5 } else { 1.0 }
}

/// The walls of a grid, in the order of their axes, low ones first.
pub(in crate::engines::spectral) fn walls(grid: &BoxGrid) -> Vec<BoxWall> {
    grid.walled().flat_map(|axis| [0, 1].map(|side| BoxWall { axis, side })).collect()
}

impl WallSumLayout<'_> {
    /// Numbers of one side in a block: those of an axis in the order of [`WallSums`].
    fn length(&self, axis: usize, block: usize) -> usize {
        let ([l0, _, _], h2) = (self.part.grid.lengths(), self.part.grid.halves()[2]);
        let size = match axis {
            0 => h2 * FREQUENCIES_PER_BLOCK,
            1 => h2 * l0,
            _ => self.part.slabs.frequencies_of(block).len() * l0,
        };
        self.part.order.patch_components() * size
    }

    /// Zeros for a block.
    pub(super) fn zeros(&self, block: usize) -> WallSums {
        let side = |a: usize| vec![ZERO; if self.part.grid.periodic[a] { 0 } else { self.length(a, block) }];
        let sides = |a: usize| [side(a), side(a)];
        WallSums { x: sides(0), y: sides(1), z: sides(2) }
    }

    /// The spectra of the walls that this rank completes, from the sums of its blocks and those of the others: across the first two axes times the weight of
    /// f₂, across the third half of a sum of which twice the real part counts. The sums are changed.
    pub(super) fn complete(&self, own: &mut [WallSums]) -> Vec<(BoxWall, Vec<Complex64>)> {
        let (rank, ranks) = (self.part.slabs.rank(), self.part.slabs.ranks());
        if !self.part.grid.periodic[1] {
            self.sum_subtrees(own);
        }
        let (all, own) = (walls(&self.part.grid), &*own);
        let mut received = Vec::new();
        if ranks > 1 {
            let mut messages = vec![Vec::new(); ranks];
            for (w, wall) in all.iter().enumerate().filter(|(w, _)| w % ranks != rank) {
                let parts = self.own_parts(own, *wall);
                parts.iter().for_each(|(_, p)| messages[w % ranks].extend_from_slice(complex_bytes(p)));
            }
            received = self.part.slabs.communicator.all_to_all(messages);
        }
        let mut read: Vec<&[u8]> = received.iter().map(Vec::as_slice).collect();
        let mut out = Vec::new();
        for (_, &wall) in all.iter().enumerate().filter(|(w, _)| w % ranks == rank) {
            let mut parts: BTreeMap<SubtreeRoot, Cow<[Complex64]>> = BTreeMap::new();
            parts.extend(self.own_parts(own, wall).into_iter().map(|(b, p)| (b, Cow::Borrowed(p))));
            for other in (0..ranks).filter(|r| *r != rank) {
                for node in self.parts_of(other, wall.axis) {
                    let (bytes, rest) = read[other].split_at(16 * self.length(wall.axis, node.first_block()));
                    read[other] = rest;
                    let mut part = vec![ZERO; bytes.len() / 16];
                    complex_bytes_mut(&mut part).copy_from_slice(bytes);
                    parts.insert(node, Cow::Owned(part));
                }
            }
            out.push((wall, self.join(wall.axis, parts)));
        }
        out
    }

    /// Sums the subtrees of own blocks for the walls across y.
    fn sum_subtrees(&self, own: &mut [WallSums]) {
        let count = self.part.slabs.block_count();
        let mut rest = own;
        for run in self.part.slabs.runs_of(self.part.slabs.rank()) {
            let (of_run, further) = rest.split_at_mut(run.len());
            fixed_tree::sum_subtrees_in_place(of_run, run, count, |lower, upper| {
                for (lower, upper) in lower.y.iter_mut().zip(&upper.y) {
                    let pairs =
                        lower.par_chunks_mut(NUMBERS_PER_TASK).zip(upper.par_chunks(NUMBERS_PER_TASK));
                    pairs.for_each(|(l, u)| l.iter_mut().zip(u).for_each(|(l, u)| *l += u));
                }
            });
            rest = further;
        }
    }

    /// The parts of a wall across `axis` that a rank has: subtrees of blocks, or single blocks.
    fn parts_of(&self, rank: usize, axis: usize) -> Vec<SubtreeRoot> {
        if axis == 1 {
            self.part.slabs.subtrees_of(rank)
        } else {
            self.part.slabs.blocks_of(rank).map(SubtreeRoot::block).collect()
        }
    }

    /// The parts of a wall that this rank has.
    fn own_parts<'a>(&self, own: &'a [WallSums], wall: BoxWall) -> Vec<(SubtreeRoot, &'a [Complex64])> {
        let BoxWall { axis, side } = wall;
        let place = |block: usize| self.part.slabs.blocks().position(|b| b == block).unwrap_or(0);
        let of = |node: SubtreeRoot| (node, &own[place(node.first_block())].of_axis(axis)[side][..]);
        self.parts_of(self.part.slabs.rank(), axis).into_iter().map(of).collect()
    }

    /// The spectrum of a wall across `axis` from its parts.
    fn join(&self, axis: usize, mut parts: BTreeMap<SubtreeRoot, Cow<[Complex64]>>) -> Vec<Complex64> {
        let ([l0, l1, _], h2, components) =
            (self.part.grid.lengths(), self.part.grid.halves()[2], self.part.order.patch_components());
        if axis == 1 {
            let root = fixed_tree::root(self.part.slabs.block_count());
            let mut sum = match parts.remove(&root) {
                Some(sum) => sum.into_owned(),
                None => {
                    let mut known = parts.into_iter().map(|(node, p)| (node, p.into_owned())).collect();
                    fixed_tree::node_sum(&mut known, root, &|a, b| a + b)
                }
            };
            let lines = sum.par_chunks_mut(l0).enumerate().with_min_len(NUMBERS_PER_TASK / l0);
            lines.for_each(|(k, line)| {
                line.iter_mut().for_each(|o| *o *= half_weight(&self.part.grid, k % h2))
            });
            return sum;
        }
        let size = [l1 * h2, l0 * h2, l0 * l1][axis];
        let mut out = vec![ZERO; components * size];
        for (node, part) in &parts {
            let frequencies = self.part.slabs.frequencies_of(node.number);
            for (q, part) in part.chunks(part.len() / components).enumerate() {
                let out = &mut out[q * size..(q + 1) * size];
                if axis == 2 {
                    out[frequencies.start * l0..frequencies.end * l0].copy_from_slice(part);
                    continue;
                }
                for (f2, part) in part.chunks(FREQUENCIES_PER_BLOCK).enumerate() {
                    let w = half_weight(&self.part.grid, f2);
                    let line = &mut out[f2 * l1 + frequencies.start..f2 * l1 + frequencies.end];
                    line.iter_mut().zip(part).for_each(|(o, p)| *o = p * w);
                }
            }
        }
        out
    }
}
