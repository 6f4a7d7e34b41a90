//! Exchange of the spectra of planes for those of blocks of frequencies, and back.
//!
//! A rank has the planes `planes` of voxels, and needs its blocks of frequencies of all planes. Planes go in batches of some megabytes, so that messages and
//! their copies are small against the spectra. With R ranks a rank sends 16 n₀/R · N₁ (N₂/2 + 1) (R − 1)/R bytes in each direction, and receives as many.

use super::slabs::Slabs;
use rustfft::num_complex::Complex64;
use std::ops::Range;
use zonal_math::simd::{complex_bytes, complex_bytes_mut};

/// Numbers of a batch, at least.
const MIN_BATCH_NUMBERS: usize = 1 << 20;
/// Planes of a batch, at least: the threads of a rank share them.
const MIN_BATCH_PLANES: usize = 4;

/// The pieces of single planes in all blocks.
pub(super) type PlaneSlots<'a> = Vec<Vec<&'a mut [Complex64]>>;

/// The exchange of one component among `parts` of them.
#[derive(Clone, Copy)]
pub(super) struct Transposition<'a> {
    pub(super) slabs: Slabs<'a>,
    /// Numbers of one plane in one block.
    pub(super) piece: usize,
    /// Number of components, which lie one after the other in a block.
    pub(super) parts: usize,
}

/// Planes of a batch, for `piece` numbers of one plane in one block.
pub(super) fn batch_planes(slabs: &Slabs, piece: usize) -> usize {
    MIN_BATCH_PLANES.max(MIN_BATCH_NUMBERS.div_ceil(piece * slabs.block_count()))
}

impl Transposition<'_> {
    /// Planes of a batch.
    fn batch_planes(&self) -> usize {
        batch_planes(&self.slabs, self.piece)
    }

    /// Number of batches of the rank with the most planes.
    fn batches(&self) -> usize {
        let most = (0..self.slabs.ranks()).map(|r| self.slabs.planes_of(r).len()).max().unwrap_or(0);
        most.div_ceil(self.batch_planes())
    }

    /// The planes of batch `batch` of a rank, numbered in the grid.
    fn planes(&self, rank: usize, batch: usize) -> Range<usize> {
        let (all, size) = (self.slabs.planes_of(rank), self.batch_planes());
        let at = |k: usize| (all.start + k * size).min(all.end);
        at(batch)..at(batch + 1)
    }

    /// Planes of the grid, numbered among those of this rank.
    fn local(&self, planes: &Range<usize>) -> Range<usize> {
        let first = self.slabs.planes().start;
        planes.start - first..planes.end - first
    }

    /// Numbers of one component in one block: those of all planes.
    fn component_size(&self) -> usize {
        self.slabs.planes_of(self.slabs.ranks() - 1).end * self.piece
    }

    /// The place of planes of component `p` of own block number `i` in the spectrum.
    fn place(&self, i: usize, p: usize, planes: &Range<usize>) -> Range<usize> {
        let first = (i * self.parts + p) * self.component_size();
        first + planes.start * self.piece..first + planes.end * self.piece
    }

    /// Fills component `p` of the spectrum of the own blocks. `transform` writes the spectra of some own planes, numbered among these, to their slots.
    pub(super) fn to_frequencies(
        &self,
        p: usize,
        [batch, spectrum]: [&mut Vec<Complex64>; 2],
        mut transform: impl FnMut(Range<usize>, PlaneSlots),
    ) {
        let ranks = self.slabs.ranks();
        if ranks == 1 {
            let blocks = spectrum.chunks_mut(self.component_size()).skip(p).step_by(self.parts);
            let planes = self.slabs.planes();
            return transform(planes.clone(), self.slots(blocks, planes.len()));
        }
        for round in 0..self.batches() {
            let own = self.planes(self.slabs.rank(), round);
            let size = own.len() * self.piece;
            batch.resize(self.slabs.block_count() * size, Complex64::default());
            if !own.is_empty() {
                transform(self.local(&own), self.slots(batch.chunks_mut(size), own.len()));
            }
            let message = |rank: usize| {
                let mut bytes = Vec::with_capacity(self.slabs.blocks_of(rank).count() * 16 * size);
                for b in self.slabs.blocks_of(rank) {
                    bytes.extend_from_slice(complex_bytes(&batch[b * size..(b + 1) * size]));
                }
                bytes
            };
            let received = self.slabs.communicator.all_to_all((0..ranks).map(message).collect());
            for (rank, bytes) in received.iter().enumerate() {
                let planes = self.planes(rank, round);
                let blocks = bytes.chunks((16 * planes.len() * self.piece).max(1)).enumerate();
                blocks.for_each(|(i, bytes)| {
                    complex_bytes_mut(&mut spectrum[self.place(i, p, &planes)]).copy_from_slice(bytes);
                });
            }
        }
    }

    /// The opposite way: `transform` receives the spectra of some own planes, numbered among these: numbers of which those of a block begin at multiples of the
    /// second value; the third one is the number of components.
    pub(super) fn to_planes(
        &self,
        p: usize,
        [batch, spectrum]: [&mut Vec<Complex64>; 2],
        mut transform: impl FnMut(Range<usize>, (&[Complex64], usize, usize)),
    ) {
        let ranks = self.slabs.ranks();
        if ranks == 1 {
            let size = self.component_size();
            return transform(self.slabs.planes(), (&spectrum[p * size..], size, self.parts));
        }
        let own_blocks = self.slabs.blocks().count();
        for round in 0..self.batches() {
            let message = |rank: usize| {
                let planes = self.planes(rank, round);
                let mut bytes = Vec::with_capacity(own_blocks * 16 * planes.len() * self.piece);
                for i in 0..own_blocks {
                    bytes.extend_from_slice(complex_bytes(&spectrum[self.place(i, p, &planes)]));
                }
                bytes
            };
            let received = self.slabs.communicator.all_to_all((0..ranks).map(message).collect());
            let own = self.planes(self.slabs.rank(), round);
            if own.is_empty() {
                continue;
            }
            let size = own.len() * self.piece;
            batch.resize(self.slabs.block_count() * size, Complex64::default());
            for (rank, bytes) in received.iter().enumerate() {
                for (b, bytes) in self.slabs.blocks_of(rank).zip(bytes.chunks(16 * size)) {
                    complex_bytes_mut(&mut batch[b * size..(b + 1) * size]).copy_from_slice(bytes);
                }
            }
            transform(self.local(&own), (&*batch, size, 1));
        }
    }

    /// The pieces of each of `planes` planes in `blocks`.
    fn slots<'b>(
        &self,
        blocks: impl Iterator<Item = &'b mut [Complex64]>,
        planes: usize,
    ) -> PlaneSlots<'b> {
        let mut slots: PlaneSlots =
            (0..planes).map(|_| Vec::with_capacity(self.slabs.block_count())).collect();
        for block in blocks {
            block.chunks_mut(self.piece).zip(&mut slots).for_each(|(piece, slot)| slot.push(piece));
        }
        slots
    }
}
