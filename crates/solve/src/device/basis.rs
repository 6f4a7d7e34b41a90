//! Basis of the radiosity inside a zone, and the kernels between its components.
//!
//! Constant: one component a zone. Linear: also its slopes, functions √12 (x_k − c_k)/e_k of mean square one, orthogonal to each other and to the
//! constant: four components of a voxel (0; x, y, z), three of a patch (0 and its two axes, ascending). Galerkin's equations have the form of the
//! zonal equations, with the same ρ, Ω, A and V for every component of a zone.
//!
//! **Real spectra.** If one of two components is a slope along an axis k, the factor is odd in d_k, and its spectrum is −i A with a real, odd A;
//! for two such axes it is −C. With the strengths of slopes multiplied by i in frequency space (one factor i for each slope along a transformed axis), the
//! matrix between components is real and symmetric: `KernelSet` holds A and C, and `KernelSpectrum::sign` gives the signs at negative
//! frequencies. Across a wall there is no transform, and the slope across it is unchanged; it changes its sign at the high wall.

use super::grid::OTHER_AXES;
use super::spectra::KernelTerm;

/// Order of the basis inside a zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BasisOrder {
    /// Constant radiosity.
    Constant,
    /// A slope along each axis of the zone.
    Linear,
}

impl BasisOrder {
    /// Number of components of a voxel.
    pub fn voxel_components(self) -> usize {
        if self == BasisOrder::Linear { 4 } else { 1 }
    }
    /// Number of components of a patch.
    pub fn patch_components(self) -> usize {
        if self == BasisOrder::Linear { 3 } else { 1 }
    }
    /// The kernels of two voxels.
    pub(crate) fn volume_layout(self) -> KernelLayout {
        let n = self.voxel_components();
        KernelLayout::new(n, n, |p, q| [0, 1, 2].map(|k| slope_count(p == k + 1, q == k + 1)))
    }
    /// The kernels of a voxel (first) and a patch of a wall across `a`.
    pub(crate) fn wall_layout(self, a: usize) -> KernelLayout {
        KernelLayout::new(self.voxel_components(), self.patch_components(), |p, q| {
            let across = usize::from(p == a + 1);
            [0, 1, 2]
                .map(|k| if k == a { across } else { slope_count(p == k + 1, patch_axis(a, q) == Some(k)) })
        })
    }
    /// The kernels of two walls across `a`.
    pub(crate) fn opposite_layout(self, a: usize) -> KernelLayout {
        let slope = |q: usize, k: usize| patch_axis(a, q) == Some(k);
        KernelLayout::new(self.patch_components(), self.patch_components(), |p, q| {
            [0, 1, 2].map(|k| slope_count(slope(p, k), slope(q, k)))
        })
    }
    /// The kernels of a patch of a wall across `a` (first) and of one across `b`.
    pub(crate) fn adjacent_layout(self, [a, b]: [usize; 2]) -> KernelLayout {
        KernelLayout::new(self.patch_components(), self.patch_components(), |p, q| {
            let (p, q) = (patch_axis(a, p), patch_axis(b, q));
            [0, 1, 2].map(|k| match k {
                _ if k == a => usize::from(q == Some(a)),
                _ if k == b => usize::from(p == Some(b)),
                _ => slope_count(p == Some(k), q == Some(k)),
            })
        })
    }
}

/// The axis of a component of a patch across `a`; `None` for the constant.
pub fn patch_axis(a: usize, component: usize) -> Option<usize> {
    (component > 0).then(|| OTHER_AXES[a][component - 1])
}

/// The density of two zones along an axis along which both extend: 0, 1 or 2 of them are slopes.
fn slope_count(p: bool, q: bool) -> usize {
    usize::from(p) + usize::from(q)
}

/// The distinct kernels, and the pairs of components that share one.
#[derive(Clone, Debug)]
pub(crate) struct KernelLayout {
    /// Every pair of components.
    pub terms: Vec<KernelTerm>,
    /// The densities of each distinct kernel along the three axes, numbered as in `zonal_exchange::aligned::lattice::Linear`.
    pub densities: Vec<[usize; 3]>,
}

impl KernelLayout {
    fn new(first: usize, second: usize, densities: impl Fn(usize, usize) -> [usize; 3]) -> KernelLayout {
        let mut out = KernelLayout { terms: Vec::new(), densities: Vec::new() };
        for p in 0..first {
            for q in 0..second {
                let d = densities(p, q);
                let known = out.densities.iter().position(|x| *x == d);
                let array = known.unwrap_or_else(|| {
                    out.densities.push(d);
                    out.densities.len() - 1
                });
                out.terms.push(KernelTerm { p, q, array });
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_kernels_are_shared() {
        let count = |l: KernelLayout| (l.terms.len(), l.densities.len());
        let v = BasisOrder::Linear;
        assert_eq!(count(BasisOrder::Constant.volume_layout()), (1, 1));
        assert_eq!(count(v.volume_layout()), (16, 10));
        assert_eq!(count(v.wall_layout(1)), (12, 9));
        assert_eq!(count(v.opposite_layout(2)), (9, 6));
        assert_eq!(count(v.adjacent_layout([0, 2])), (9, 8));
    }
}
