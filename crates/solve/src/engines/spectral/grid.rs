//! The grid of an enclosure: cells, edges, periodic axes, and lengths of transforms.
//!
//! Axis a has n_a cells. For a finite axis the transforms have a length N_a ≥ 2n_a with small prime factors: zero padding for a linear convolution. For
//! a periodic axis N_a = n_a: the convolution is circular.

use super::axes::OTHER_AXES;
use super::real_symmetric_fft::{half_length, padded_length};

/// A regular grid in a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BoxGrid {
    /// Cells along each axis.
    pub cells: [usize; 3],
    /// Edges of a cell, m.
    pub edges: [f64; 3],
    /// Periodic axes.
    pub periodic: [bool; 3],
    /// Lengths of the transforms.
    lengths: [usize; 3],
}

impl BoxGrid {
    /// A grid of cells with these edges, m.
    pub(crate) fn new(cells: [usize; 3], edges: [f64; 3], periodic: [bool; 3]) -> BoxGrid {
        let length = |k: usize| if periodic[k] { cells[k] } else { padded_length(cells[k]) };
        BoxGrid { cells, edges, periodic, lengths: [0, 1, 2].map(length) }
    }
    /// Lengths of the transforms.
    pub(crate) fn lengths(&self) -> [usize; 3] {
        self.lengths
    }
    /// Numbers of stored frequencies of an even spectrum.
    pub(crate) fn halves(&self) -> [usize; 3] {
        self.lengths().map(half_length)
    }
    /// Distinct distances along each axis.
    pub(crate) fn distances(&self) -> [usize; 3] {
        [0, 1, 2].map(|k| if self.periodic[k] { self.cells[k] / 2 + 1 } else { self.cells[k] })
    }
    /// Number of cells.
    pub(crate) fn count(&self) -> usize {
        self.cells.iter().product()
    }
    /// Patches of a wall across `axis`.
    pub(crate) fn patches(&self, axis: usize) -> usize {
        OTHER_AXES[axis].iter().map(|&k| self.cells[k]).product()
    }
    /// Axes with walls across them.
    pub(crate) fn walled(&self) -> impl Iterator<Item = usize> + use<> {
        let periodic = self.periodic;
        (0..3).filter(move |&a| !periodic[a])
    }
    /// A permutation of equal axes that maps the axes `normals` to `others`.
    pub(crate) fn permutation(&self, normals: &[usize], others: &[usize]) -> Option<[usize; 3]> {
        const AXIS_PERMUTATIONS: [[usize; 3]; 6] =
            [[0, 1, 2], [1, 0, 2], [2, 1, 0], [0, 2, 1], [1, 2, 0], [2, 0, 1]];
        let alike = |k: usize, l: usize| {
            (self.edges[k], self.cells[k], self.periodic[k])
                == (self.edges[l], self.cells[l], self.periodic[l])
        };
        let fits = |turn: &[usize; 3]| {
            (0..3).all(|k| alike(k, turn[k])) && normals.iter().map(|&a| turn[a]).eq(others.iter().copied())
        };
        AXIS_PERMUTATIONS.into_iter().find(fits)
    }
    /// Pairs of axes with adjacent walls.
    pub(crate) fn corners(&self) -> impl Iterator<Item = [usize; 2]> + use<> {
        let periodic = self.periodic;
        [[0, 1], [0, 2], [1, 2]].into_iter().filter(move |p| p.iter().all(|&a| !periodic[a]))
    }
}
