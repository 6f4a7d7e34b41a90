//! How radiosity varies inside a zone, and the kernels that its components have with each other.
//!
//! Constant: one component a zone. Linear: also its slopes, functions √12 (x_k − c_k)/e_k of mean square one, square to each other and to the
//! constant: four components of a voxel (0; x, y, z), three of a patch (0 and its two axes, ascending). Galerkin's equations have the form of the
//! zonal ones, with the same ρ, Ω, A and V for every component of a zone: strengths in, what arrives of each component out.
//!
//! **Real spectra.** Between components of which one is a slope along an axis k and the other is not, the factor is odd in d_k, and its spectrum
//! −i A with a real, odd A; with two such axes −C. With the strengths of slopes times i in frequencies (one factor i for each slope along an
//! axis that is transformed), the matrix between components is real and symmetric: [`Set`] keeps A and C, and the signs that negative
//! frequencies have ([`Array::sign`]). Across a wall nothing is transformed, and the slope across stays as it is; it changes its sign where the wall
//! stands at the high end.

use super::grid::OTHERS;

/// How radiosity varies inside a zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variation {
    /// Not at all.
    Constant,
    /// By a slope along each of its axes.
    Linear,
}

impl Variation {
    /// Components of a voxel.
    pub fn voxel(self) -> usize {
        if self == Variation::Linear { 4 } else { 1 }
    }
    /// Components of a patch.
    pub fn patch(self) -> usize {
        if self == Variation::Linear { 3 } else { 1 }
    }
    /// The kernels of two voxels.
    pub fn volume(self) -> Layout {
        let n = self.voxel();
        Layout::new(n, n, |p, q| [0, 1, 2].map(|k| along(p == k + 1, q == k + 1)))
    }
    /// The kernels of a voxel (first) and a patch of a wall across `a`.
    pub fn wall(self, a: usize) -> Layout {
        Layout::new(self.voxel(), self.patch(), |p, q| {
            let across = usize::from(p == a + 1);
            [0, 1, 2].map(|k| if k == a { across } else { along(p == k + 1, patch_axis(a, q) == Some(k)) })
        })
    }
    /// The kernels of two walls across `a`.
    pub fn opposite(self, a: usize) -> Layout {
        let slope = |q: usize, k: usize| patch_axis(a, q) == Some(k);
        Layout::new(self.patch(), self.patch(), |p, q| [0, 1, 2].map(|k| along(slope(p, k), slope(q, k))))
    }
    /// The kernels of a patch of a wall across `a` (first) and of one across `b`.
    pub fn adjacent(self, [a, b]: [usize; 2]) -> Layout {
        Layout::new(self.patch(), self.patch(), |p, q| {
            let (p, q) = (patch_axis(a, p), patch_axis(b, q));
            [0, 1, 2].map(|k| match k {
                _ if k == a => usize::from(q == Some(a)),
                _ if k == b => usize::from(p == Some(b)),
                _ => along(p == Some(k), q == Some(k)),
            })
        })
    }
}

/// The axis of a component of a patch across `a`; none of the constant.
pub fn patch_axis(a: usize, component: usize) -> Option<usize> {
    (component > 0).then(|| OTHERS[a][component - 1])
}

/// The number of the density of two zones along an axis along which both extend: none, one or both are slopes.
fn along(p: bool, q: bool) -> usize {
    usize::from(p) + usize::from(q)
}

/// One component with another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// The component of the first zone.
    pub p: usize,
    /// The component of the second.
    pub q: usize,
    /// Which array is their kernel.
    pub array: usize,
}

/// Which kernels are needed, and who shares one.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Every pair of components.
    pub terms: Vec<Term>,
    /// The densities of each distinct kernel along the three axes, numbered as in `zonal_exchange::aligned::lattice::Linear`.
    pub densities: Vec<[usize; 3]>,
}

impl Layout {
    fn new(first: usize, second: usize, densities: impl Fn(usize, usize) -> [usize; 3]) -> Layout {
        let mut out = Layout { terms: Vec::new(), densities: Vec::new() };
        for p in 0..first {
            for q in 0..second {
                let d = densities(p, q);
                let known = out.densities.iter().position(|x| *x == d);
                let array = known.unwrap_or_else(|| {
                    out.densities.push(d);
                    out.densities.len() - 1
                });
                out.terms.push(Term { p, q, array });
            }
        }
        out
    }
}

/// One kernel in frequencies.
#[derive(Clone, Debug, Default)]
pub struct Array {
    /// Axes along which its spectrum is odd.
    pub odd: [bool; 3],
    /// Its values, in an order that its maker tells.
    pub data: Vec<f64>,
}

impl Array {
    /// The sign of its value at a frequency along `axis` that stands for the opposite of one that is kept.
    #[inline(always)]
    pub fn sign(&self, axis: usize, opposite: bool) -> f64 {
        if self.odd[axis] && opposite { -1.0 } else { 1.0 }
    }
}

/// The kernels between two kinds of zones.
#[derive(Clone, Debug, Default)]
pub struct Set {
    /// Every pair of components.
    pub terms: Vec<Term>,
    /// The distinct kernels.
    pub arrays: Vec<Array>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_are_shared() {
        let count = |l: Layout| (l.terms.len(), l.densities.len());
        let v = Variation::Linear;
        assert_eq!(count(Variation::Constant.volume()), (1, 1));
        assert_eq!(count(v.volume()), (16, 10));
        assert_eq!(count(v.wall(1)), (12, 9));
        assert_eq!(count(v.opposite(2)), (9, 6));
        assert_eq!(count(v.adjacent([0, 2])), (9, 8));
    }
}
