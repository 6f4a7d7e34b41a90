//! The grid of an enclosure: cells, edges, what repeats itself, and lengths of transforms.
//!
//! Axis a has n_a cells. Where it ends, transforms have a length N_a ≥ 2n_a of small primes: what is convolved is followed by zeros. Where it
//! repeats itself, N_a = n_a: the circular convolution is the one that is wanted.

use super::basis::Variation;
use super::even::{half, padded};

/// The two other axes of each axis, ascending.
pub const OTHERS: [[usize; 2]; 3] = [[1, 2], [0, 2], [0, 1]];

/// A regular grid in a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Cells along each axis.
    pub cells: [usize; 3],
    /// Edges of a cell, m.
    pub edges: [f64; 3],
    /// Axes along which the box repeats itself.
    pub periodic: [bool; 3],
}

impl Grid {
    /// Lengths of the transforms.
    pub fn lengths(&self) -> [usize; 3] {
        [0, 1, 2].map(|k| if self.periodic[k] { self.cells[k] } else { padded(self.cells[k]) })
    }
    /// Frequencies that are kept of an even spectrum.
    pub fn halves(&self) -> [usize; 3] {
        self.lengths().map(half)
    }
    /// Distinct distances along each axis.
    pub fn distances(&self) -> [usize; 3] {
        [0, 1, 2].map(|k| if self.periodic[k] { self.cells[k] / 2 + 1 } else { self.cells[k] })
    }
    /// Number of cells.
    pub fn count(&self) -> usize {
        self.cells.iter().product()
    }
    /// Patches of a wall across `axis`.
    pub fn patches(&self, axis: usize) -> usize {
        OTHERS[axis].iter().map(|&k| self.cells[k]).product()
    }
    /// Axes that walls can stand across.
    pub fn walled(&self) -> impl Iterator<Item = usize> + use<> {
        let periodic = self.periodic;
        (0..3).filter(move |&a| !periodic[a])
    }
    /// Pairs of axes with adjacent walls.
    pub fn corners(&self) -> impl Iterator<Item = [usize; 2]> + use<> {
        let periodic = self.periodic;
        [[0, 1], [0, 2], [1, 2]].into_iter().filter(move |p| p.iter().all(|&a| !periodic[a]))
    }
    /// Bytes of the spectra of one extinction.
    pub fn spectra_bytes(&self, variation: Variation) -> u64 {
        let [h0, h1, h2] = self.halves().map(|h| h as u64);
        let [n0, n1, n2] = self.cells.map(|n| n as u64);
        let kernels = |l: super::basis::Layout| l.densities.len() as u64;
        let mut all = kernels(variation.volume()) * h0 * h1 * h2;
        for a in self.walled() {
            all += kernels(variation.wall(a)) * if a == 0 { n0 * h1 * h2 } else { h0 * h1 * h2 };
        }
        for pair in self.corners() {
            let one = match pair {
                [0, 1] => n0 * n1 * h2,
                [0, _] => n0 * n2 * h1,
                _ => n1 * n2 * h0,
            };
            all += kernels(variation.adjacent(pair)) * one;
        }
        8 * all
    }
    /// Bytes that one application works in, beside what goes in and out.
    pub fn work_bytes(&self, variation: Variation) -> u64 {
        let [voxel, patch] = [variation.voxel(), variation.patch()].map(|n| n as u64);
        let [n0, n1, _] = self.lengths().map(|n| n as u64);
        let h2 = self.halves()[2] as u64;
        let blocks = n1.div_ceil(super::volume::BLOCK as u64);
        let partial = if self.periodic[1] { 0 } else { 2 * blocks * h2 * n0 };
        16 * (voxel * blocks * super::volume::BLOCK as u64 * self.cells[0] as u64 * h2 + patch * partial)
            + patch * 16 * 8 * (n0 * n1 + (n0 + n1) * h2)
    }
}
