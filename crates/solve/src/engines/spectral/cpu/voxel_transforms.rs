//! Transforms of the voxels: planes along z and y, lines along x.
//!
//! A plane x of n₁ × n₂ cells is real. Its n₁ lines along z become N₂/2 + 1 frequencies each (the opposite ones are their conjugates), and each of
//! these N₂/2 + 1 columns becomes N₁ frequencies along y. Lines of zeros are not transformed; cells beyond n are zeros before a transform and are
//! dropped after it.
//!
//! ```text
//!     ŝ(x, f₁, f₂) = Σ_y Σ_z s(x, y, z) e^{−2πi (f₁ y/N₁ + f₂ z/N₂)}
//! ```
//!
//! **Cost** for n³ cells, N = 2n, each direction: 5 n³ log₂N operations along z, 10 n³ log₂N along y, 20 n³ log₂N along x. A plane reads 8 n² B and
//! writes 32 n² B; its work of 16 N₁ (N₂/2 + 1) B stays in the cache, as do all lines along x of a frequency f₂ and a block.
//!
//! Plans have no scale: the spectra of the kernels contain it.

use super::line_exchange::{NUMBERS_PER_CACHE_LINE, ZERO};
use super::transposition::PlaneSlots;
use crate::device::grid::BoxGrid;
use crate::device::slabs::FREQUENCIES_PER_BLOCK;
use rayon::prelude::*;
use std::sync::Arc;
use zonal_fourier::Complex64;
use zonal_fourier::{ComplexToReal, Fft, Planner, RealToComplex};
use zonal_math::parallel;

/// Operations of the transforms of a number of a plane.
const PLANE_OPERATIONS: usize = 20;

/// Plans of the transforms of a grid.
pub(super) struct VoxelTransforms {
    grid: BoxGrid,
    /// Along x and y.
    forward: [Arc<dyn Fft<f64>>; 2],
    back: [Arc<dyn Fft<f64>>; 2],
    /// Along z.
    real: Arc<dyn RealToComplex<f64>>,
    unreal: Arc<dyn ComplexToReal<f64>>,
}

impl VoxelTransforms {
    /// Plans for a grid.
    pub(super) fn new(grid: BoxGrid) -> VoxelTransforms {
        let n = grid.lengths();
        let mut plans = Planner::default();
        VoxelTransforms {
            forward: [0, 1].map(|a| plans.forward(n[a])),
            back: [0, 1].map(|a| plans.inverse(n[a])),
            real: plans.real_forward(n[2]),
            unreal: plans.real_inverse(n[2]),
            grid,
        }
    }

    /// Numbers of scratch that lines along x need.
    pub(super) fn line_scratch(&self) -> usize {
        self.forward[0].get_inplace_scratch_len().max(self.back[0].get_inplace_scratch_len())
    }

    /// Transforms lines along x of N₀ numbers each.
    #[inline(always)]
    pub(super) fn transform_lines(&self, lines: &mut [Complex64], scratch: &mut [Complex64]) {
        self.forward[0].process_with_scratch(lines, scratch);
    }

    /// Transforms lines along x back.
    #[inline(always)]
    pub(super) fn inverse_transform_lines(&self, lines: &mut [Complex64], scratch: &mut [Complex64]) {
        self.back[0].process_with_scratch(lines, scratch);
    }

    /// Transforms along z and y, plane by plane.
    pub(super) fn transform_planes(&self, s: &[f64], slots: PlaneSlots) {
        let ([_, n1, n2], [_, l1, l2], h2) = (self.grid.cells, self.grid.lengths(), self.grid.halves()[2]);
        let plan = &self.forward[1];
        let work = || {
            let scratch = vec![ZERO; plan.get_inplace_scratch_len()];
            let spectra = vec![ZERO; NUMBERS_PER_CACHE_LINE * h2];
            (vec![0.0; l2], spectra, vec![ZERO; h2 * l1], self.real.make_scratch_vec(), scratch)
        };
        let least = parallel::least_items(PLANE_OPERATIONS * l1 * l2);
        slots.into_par_iter().zip(s.par_chunks(n1 * n2)).with_max_len(1).with_min_len(least).for_each_init(
            work,
            |(line, spectra, plane, scratch_z, scratch_y), (mut slot, cells)| {
                // Lines y go to the plane together, so that each line of the cache is written once.
                for (g, cells) in cells.chunks(NUMBERS_PER_CACHE_LINE * n2).enumerate() {
                    for (spectrum, cells) in spectra.chunks_mut(h2).zip(cells.chunks(n2)) {
                        line[..n2].copy_from_slice(cells);
                        line[n2..].fill(0.0);
                        let done = self.real.process_with_scratch(line, spectrum, scratch_z);
                        assert!(done.is_ok(), "buffers of the plan's lengths");
                    }
                    let (first, lines) = (g * NUMBERS_PER_CACHE_LINE, cells.len() / n2);
                    for f in 0..h2 {
                        let to = &mut plane[f * l1 + first..][..lines];
                        to.iter_mut().enumerate().for_each(|(k, x)| *x = spectra[k * h2 + f]);
                    }
                }
                plane.chunks_mut(l1).for_each(|line| line[n1..].fill(ZERO));
                plan.process_with_scratch(plane, scratch_y);
                for (f2, line) in plane.chunks(l1).enumerate() {
                    for (piece, part) in slot.iter_mut().zip(line.chunks(FREQUENCIES_PER_BLOCK)) {
                        piece[f2 * FREQUENCIES_PER_BLOCK..f2 * FREQUENCIES_PER_BLOCK + part.len()]
                            .copy_from_slice(part);
                    }
                }
            },
        );
    }

    /// Transforms back along y and z, plane by plane.
    pub(super) fn inverse_transform_planes(&self, blocks: &[&[Complex64]], out: &mut [f64]) {
        let ([_, n1, n2], [_, l1, l2], h2) = (self.grid.cells, self.grid.lengths(), self.grid.halves()[2]);
        let plan = &self.back[1];
        let work = || {
            let scratch = vec![ZERO; plan.get_inplace_scratch_len()];
            let spectra = vec![ZERO; NUMBERS_PER_CACHE_LINE * h2];
            (vec![0.0; l2], spectra, vec![ZERO; h2 * l1], self.unreal.make_scratch_vec(), scratch)
        };
        let least = parallel::least_items(PLANE_OPERATIONS * l1 * l2);
        out.par_chunks_mut(n1 * n2).enumerate().with_max_len(1).with_min_len(least).for_each_init(
            work,
            |(line, spectra, plane, scratch_z, scratch_y), (x, cells)| {
                for (b, block) in blocks.iter().enumerate() {
                    let piece = &block[x * h2 * FREQUENCIES_PER_BLOCK..(x + 1) * h2 * FREQUENCIES_PER_BLOCK];
                    let (from, to) = (b * FREQUENCIES_PER_BLOCK, ((b + 1) * FREQUENCIES_PER_BLOCK).min(l1));
                    for (f2, part) in piece.chunks(FREQUENCIES_PER_BLOCK).enumerate() {
                        plane[f2 * l1 + from..f2 * l1 + to].copy_from_slice(&part[..to - from]);
                    }
                }
                plan.process_with_scratch(plane, scratch_y);
                for (g, cells) in cells.chunks_mut(NUMBERS_PER_CACHE_LINE * n2).enumerate() {
                    let (first, lines) = (g * NUMBERS_PER_CACHE_LINE, cells.len() / n2);
                    for f in 0..h2 {
                        let from = &plane[f * l1 + first..][..lines];
                        from.iter().enumerate().for_each(|(k, x)| spectra[k * h2 + f] = *x);
                    }
                    for (spectrum, cells) in spectra.chunks_mut(h2).zip(cells.chunks_mut(n2)) {
                        // Real by symmetry; imaginary rounding errors are dropped.
                        spectrum[0].im = 0.0;
                        if l2.is_multiple_of(2) {
                            spectrum[h2 - 1].im = 0.0;
                        }
                        let done = self.unreal.process_with_scratch(spectrum, line, scratch_z);
                        assert!(done.is_ok(), "buffers of the plan's lengths");
                        cells.copy_from_slice(&line[..n2]);
                    }
                }
            },
        );
    }
}
