//! The grid of an enclosure: cells, edges, periodic axes, and lengths of transforms.
//!
//! Axis a has n_a cells. For a finite axis the transforms have a length N_a ≥ 2n_a with small prime factors: zero padding for a linear convolution. For
//! a periodic axis N_a = n_a: the convolution is circular.

/// The two other axes of each axis, ascending.
pub const OTHER_AXES: [[usize; 2]; 3] = [[1, 2], [0, 2], [0, 1]];

/// Number of stored frequencies for a length.
pub(crate) fn half_length(length: usize) -> usize {
    length / 2 + 1
}

/// The smallest even length ≥ 2n − 1 with prime factors 2, 3, 5 and 7, for a linear convolution of n cells; 1 for n = 1.
fn padded_length(n: usize) -> usize {
    let smooth = |mut x: usize| {
        for p in [2, 3, 5, 7] {
            while x.is_multiple_of(p) {
                x /= p;
            }
        }
        x == 1
    };
    if n == 1 { 1 } else { (2 * n..).step_by(2).find(|&x| smooth(x)).unwrap_or(2 * n) }
}

/// A regular grid in a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxGrid {
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
    pub fn lengths(&self) -> [usize; 3] {
        self.lengths
    }
    /// Numbers of stored frequencies of an even spectrum.
    pub fn halves(&self) -> [usize; 3] {
        self.lengths().map(half_length)
    }
    /// Distinct distances along each axis.
    pub(crate) fn distances(&self) -> [usize; 3] {
        [0, 1, 2].map(|k| if self.periodic[k] { self.cells[k] / 2 + 1 } else { self.cells[k] })
    }
    /// Number of cells.
    pub fn count(&self) -> usize {
        self.cells.iter().product()
    }
    /// Patches of a wall across `axis`.
    pub fn patches(&self, axis: usize) -> usize {
        OTHER_AXES[axis].iter().map(|&k| self.cells[k]).product()
    }
    /// Axes with walls across them.
    pub fn walled(&self) -> impl Iterator<Item = usize> + use<> {
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
    pub fn corners(&self) -> impl Iterator<Item = [usize; 2]> + use<> {
        let periodic = self.periodic;
        [[0, 1], [0, 2], [1, 2]].into_iter().filter(move |p| p.iter().all(|&a| !periodic[a]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn padded_lengths_are_smooth_and_sufficient() {
        assert_eq!([1, 2, 32, 64, 115, 256].map(padded_length), [1, 4, 64, 128, 240, 512]);
    }
}
