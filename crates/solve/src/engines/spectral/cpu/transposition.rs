//! Exchange of the spectra of planes for those of blocks of frequencies, and back.
//!
//! A rank has the planes `planes` of voxels, and needs its blocks of frequencies of all planes. Planes go in batches of some megabytes, so that messages and
//! their copies are small against the spectra. With R ranks a rank sends 16 n₀/R · N₁ (N₂/2 + 1) (R − 1)/R bytes in each direction, and receives as many.

use crate::device::slabs::Slabs;
use crate::distribution::ExchangeBuffers;
use std::ops::Range;
use zonal_fourier::Complex64;

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
pub(in crate::engines::spectral) fn batch_planes(slabs: &Slabs, piece: usize) -> usize {
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

    /// Numbers that this rank sends to each rank in a batch of planes `own`, and numbers that it receives.
    fn lengths(&self, own: &Range<usize>, round: usize) -> [Vec<usize>; 2] {
        let (rank, own_blocks) = (self.slabs.rank(), self.slabs.blocks().count());
        let of = |r: usize| {
            let blocks = self.slabs.blocks_of(r).count();
            // Own planes of own blocks stay here.
            if r == rank {
                return [0, 0];
            }
            [blocks * own.len() * self.piece, own_blocks * self.planes(r, round).len() * self.piece]
        };
        let all: Vec<[usize; 2]> = (0..self.slabs.ranks()).map(of).collect();
        [0, 1].map(|k| all.iter().map(|lengths| lengths[k]).collect())
    }

    /// Fills component `p` of the spectrum of the own blocks. `transform` writes the spectra of some own planes, numbered among these, to their slots.
    pub(super) fn bring_to_frequencies(
        &self,
        p: usize,
        buffers: &mut ExchangeBuffers,
        spectrum: &mut [Complex64],
        mut transform: impl FnMut(Range<usize>, PlaneSlots),
    ) {
        let (rank, ranks) = (self.slabs.rank(), self.slabs.ranks());
        if ranks == 1 {
            let blocks = spectrum.chunks_mut(self.component_size()).skip(p).step_by(self.parts);
            let planes = self.slabs.planes();
            return transform(planes.clone(), self.slots(blocks, planes.len()));
        }
        for round in 0..self.batches() {
            let own = self.planes(rank, round);
            let size = own.len() * self.piece;
            let [sent, received] = self.lengths(&own, round);
            buffers.sent.resize(sent.iter().sum(), Complex64::default());
            buffers.received.resize(received.iter().sum(), Complex64::default());
            if !own.is_empty() {
                // Own blocks go to the spectrum at once, others to their messages.
                let mut blocks: Vec<(usize, &mut [Complex64])> = Vec::new();
                let others = (0..ranks).filter(|r| *r != rank).flat_map(|r| self.slabs.blocks_of(r));
                blocks.extend(others.zip(buffers.sent.chunks_mut(size)));
                let components = spectrum.chunks_mut(self.component_size()).skip(p).step_by(self.parts);
                let own_part = own.start * self.piece..own.end * self.piece;
                blocks.extend(self.slabs.blocks().zip(components.map(|c| &mut c[own_part.clone()])));
                blocks.sort_by_key(|(b, _)| *b);
                let blocks = blocks.into_iter().map(|(_, block)| block);
                transform(self.local(&own), self.slots(blocks, own.len()));
            }
            (buffers.sent_lengths, buffers.received_lengths) = (sent, received);
            *buffers = self.slabs.communicator.exchange(std::mem::take(buffers));
            let mut read = &buffers.received[..];
            for other in (0..ranks).filter(|r| *r != rank) {
                let planes = self.planes(other, round);
                for i in 0..self.slabs.blocks().count() {
                    let (part, rest) = read.split_at(planes.len() * self.piece);
                    spectrum[self.place(i, p, &planes)].copy_from_slice(part);
                    read = rest;
                }
            }
        }
    }

    /// The opposite way: `transform` receives the spectra of some own planes, numbered among these, in all blocks in their order.
    pub(super) fn bring_to_planes(
        &self,
        p: usize,
        buffers: &mut ExchangeBuffers,
        spectrum: &[Complex64],
        mut transform: impl FnMut(Range<usize>, &[&[Complex64]]),
    ) {
        let (rank, ranks) = (self.slabs.rank(), self.slabs.ranks());
        let components = || spectrum.chunks(self.component_size()).skip(p).step_by(self.parts);
        if ranks == 1 {
            return transform(self.slabs.planes(), &components().collect::<Vec<_>>());
        }
        for round in 0..self.batches() {
            let own = self.planes(rank, round);
            // What came to the frequencies goes back.
            let [received, sent] = self.lengths(&own, round);
            buffers.received.resize(received.iter().sum(), Complex64::default());
            buffers.sent.clear();
            for other in (0..ranks).filter(|r| *r != rank) {
                let planes = self.planes(other, round);
                let places = (0..self.slabs.blocks().count()).map(|i| self.place(i, p, &planes));
                places.for_each(|place| buffers.sent.extend_from_slice(&spectrum[place]));
            }
            (buffers.sent_lengths, buffers.received_lengths) = (sent, received);
            *buffers = self.slabs.communicator.exchange(std::mem::take(buffers));
            if own.is_empty() {
                continue;
            }
            let mut blocks: Vec<(usize, &[Complex64])> = Vec::new();
            let others = (0..ranks).filter(|r| *r != rank).flat_map(|r| self.slabs.blocks_of(r));
            blocks.extend(others.zip(buffers.received.chunks(own.len() * self.piece)));
            let own_part = own.start * self.piece..own.end * self.piece;
            blocks.extend(self.slabs.blocks().zip(components().map(|c| &c[own_part.clone()])));
            blocks.sort_by_key(|(b, _)| *b);
            let blocks: Vec<&[Complex64]> = blocks.into_iter().map(|(_, block)| block).collect();
            transform(self.local(&own), &blocks);
        }
    }

    /// The pieces of each of `planes` planes in `blocks`.
    fn slots<'b>(&self, blocks: impl Iterator<Item = &'b mut [Complex64]>, planes: usize) -> PlaneSlots<'b> {
        let mut slots: PlaneSlots =
            (0..planes).map(|_| Vec::with_capacity(self.slabs.block_count())).collect();
        for block in blocks {
            block.chunks_mut(self.piece).zip(&mut slots).for_each(|(piece, slot)| slot.push(piece));
        }
        slots
    }
}
