//! The spectra of the kernels of a grid.
//!
//! | kernel | zones | stored as |
//! |---|---|---|
//! | V(d₀, d₁, d₂) | two voxels | one octant of its real, even spectrum |
//! | S₀(d₀; d₁, d₂) | a voxel d₀ cells from a wall across the first axis | spectra along the wall, one for each d₀ |
//! | S₁, S₂ | the same for walls across the other axes | one octant; extended as an even sequence across the wall, which is never read |
//! | O(d_b, d_c) | opposite walls | one quadrant |
//! | Q(i_a, i_b; d_c) | adjacent walls across a and b | spectra along their edge, a matrix for each frequency |
//!
//! The spectra include the scale 1/N of each transform, so that forward and inverse transforms have none. A linear basis has a kernel for each pair
//! of components ([`super::basis`]), odd along some axes.

use std::sync::Arc;

/// The kernel of a pair of components.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KernelTerm {
    /// The component of the first zone.
    pub p: usize,
    /// The component of the second.
    pub q: usize,
    /// The index of their kernel.
    pub array: usize,
}

/// Half of a spectrum along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpectrumHalf {
    /// Frequencies that are stored.
    Stored,
    /// Their opposites.
    Opposite,
}

impl SpectrumHalf {
    /// The half of frequency `f` of a transform of length `n`.
    #[inline(always)]
    pub fn of(f: usize, n: usize) -> SpectrumHalf {
        if 2 * f > n { SpectrumHalf::Opposite } else { SpectrumHalf::Stored }
    }
}

/// Spectrum of one kernel.
#[derive(Clone, Debug, Default)]
pub struct KernelSpectrum {
    /// Axes along which its spectrum is odd.
    pub odd: [bool; 3],
    /// Its values, in the order of [`GridSpectra`].
    pub data: Vec<f64>,
}

impl KernelSpectrum {
    /// The sign of its value at a frequency along `axis` in one of the halves of the spectrum.
    #[inline(always)]
    pub fn sign(&self, axis: usize, half: SpectrumHalf) -> f64 {
        if self.odd[axis] && half == SpectrumHalf::Opposite { -1.0 } else { 1.0 }
    }
}

/// The kernels between two kinds of zones.
#[derive(Clone, Debug, Default)]
pub struct KernelSet {
    /// Every pair of components.
    pub terms: Vec<KernelTerm>,
    /// The distinct kernels.
    pub arrays: Vec<KernelSpectrum>,
}

/// Spectra of all kernels of a grid for one extinction: of kernels with an index f₁ the frequencies that this process stores
/// ([`super::slabs::Slabs::stored`]), of Q with f_c its part of about 1/R of them.
#[derive(Clone, Debug, Default)]
pub struct GridSpectra {
    /// The first stored frequency f₁.
    pub first: usize,
    /// V by `[f₁][f₂][f₀]`.
    pub volume: KernelSet,
    /// S₀ by `[f₁][f₂][d₀]`; S₁ and S₂ by `[f₁][f₂][f₀]`; empty across periodic axes.
    pub walls: [KernelSet; 3],
    /// O of the walls across each axis by `[f_c][f_b]`.
    pub opposite: [KernelSet; 3],
    /// Q by `[f_c][i_a][i_b]` for the pairs of axes (0, 1), (0, 2), (1, 2); pairs of equal axes share it with a constant basis.
    pub adjacent: [Arc<KernelSet>; 3],
}
