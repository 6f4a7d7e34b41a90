//! The product in frequency space: blocks of lines along x, with voxels and walls.
//!
//! ```text
//!     P(x) = Σ_x' V(x − x') s(x')  +  Σ_walls Σ_y S(x, y) s_w(y)              P_w(y) = Σ_x S(x, y) s(x)
//! ```
//!
//! The spectra of the planes (`voxel_transforms.rs`) are taken in blocks of [`FREQUENCIES_PER_BLOCK`] frequencies f₁: for each f₂ the lines along x
//! of a block are transformed, multiplied with V̂ and exchanged with the walls, and transformed back, all in the cache. V̂ is real and even, so that
//! the line f₁ of its octant serves f₁ and N₁ − f₁.
//!
//! In a block before the transform along x, walls across x are sums over d₀. Walls across y and z are impulses at both ends of their axis, with kernels
//! extended as even sequences:
//!
//! ```text
//!     wall to voxels:  P̂ += Ŝ (ŵ_low + e^{−2πi f (n−1)/N} ŵ_high)        back:  ŵ_low = Σ_f Ŝ ŝ,   ŵ_high = Σ_f e^{+2πi f (n−1)/N} Ŝ ŝ
//! ```
//!
//! With a linear basis every component ([`crate::device::basis`]) is a field with transforms of its own, and V and S are matrices between
//! components. Slopes along y and z are multiplied by i in frequency space along these axes, slopes along x after the transform along x.
//!
//! Along z half of the frequencies are stored; sums over them count f and −f together (weight ½ where f = −f), and the wall takes twice the real
//! part. Every sum has a fixed order, so that the bits do not depend on the number of threads.
//!
//! **Cost** of a constant basis for n³ cells, N = 2n, hence 4 n³ frequencies: 4 operations each for V̂ and 25 for a pair of walls across y or z;
//! 32 n³ for the walls across x. Each of V̂, Ŝ₀, Ŝ₁, Ŝ₂ is read twice, 16 n³ B; all blocks are read and written once, 64 n³ B.

use super::line_exchange::{
    FrequencyAcross, NUMBERS_PER_CACHE_LINE, WallPairLines, ZERO, add_product, exchange, receive, send,
    times_i, times_minus_i, unfold,
};
use super::voxel_transforms::VoxelTransforms;
use super::wall_sums::{WallSums, half_weight};
use crate::device::basis::BasisOrder;
use crate::device::grid::BoxGrid;
use crate::device::slabs::FREQUENCIES_PER_BLOCK;
use crate::device::spectra::{GridSpectra, KernelSpectrum, KernelTerm, SpectrumHalf};
use std::ops::Range;
use zonal_fourier::Complex64;
use zonal_math::simd;

/// Spectra of two opposite walls, low and high, each by `[component][f_c][f_b]`.
pub(super) type WallSpectra = [Vec<Complex64>; 2];

/// Data common to all blocks of frequencies of a grid.
pub(super) struct FrequencyProduct {
    pub(super) grid: BoxGrid,
    pub(super) order: BasisOrder,
    pub(super) transforms: VoxelTransforms,
    /// e^{−2πi f (n−1)/N} of the axes 1 and 2.
    phase: [Vec<Complex64>; 2],
}

impl FrequencyProduct {
    /// For a grid.
    pub(super) fn new(grid: BoxGrid, order: BasisOrder) -> FrequencyProduct {
        let n = grid.lengths();
        let phase = |a: usize| {
            let turn =
                |f: usize| -std::f64::consts::TAU * ((f * (grid.cells[a] - 1)) % n[a]) as f64 / n[a] as f64;
            (0..n[a]).map(|f| Complex64::from_polar(1.0, turn(f))).collect()
        };
        FrequencyProduct { grid, order, transforms: VoxelTransforms::new(grid), phase: [phase(1), phase(2)] }
    }

    /// Numbers of one plane in a block.
    pub(super) fn piece_size(&self) -> usize {
        self.grid.halves()[2] * FREQUENCIES_PER_BLOCK
    }

    /// Numbers of one component of a block.
    pub(super) fn component_size(&self) -> usize {
        self.grid.cells[0] * self.piece_size()
    }
}

/// Frequencies f₂ whose lines are copied at a time.
const LOADED_FREQUENCIES: usize = 4;
/// Buffers for the lines of a block.
pub(super) struct BlockLines {
    /// Lines of one frequency f₂, by component.
    lines: Vec<Vec<Complex64>>,
    /// Those of the frequencies f₂ that are copied at a time: their numbers adjoin in the block.
    loaded: Vec<Vec<Vec<Complex64>>>,
    scratch: Vec<Complex64>,
    /// Incident power of a group of lines, by component.
    added: Vec<Vec<Complex64>>,
    /// Their unfolded spectra, each value twice.
    full: Vec<f64>,
    /// Their exchange with a pair of walls.
    pair: WallPairLines,
}

/// Numbers of a group of lines that are multiplied together: loops over short lines alone take longer to start than to run.
const NUMBERS_OF_GROUP: usize = 96;

/// Lines of a group, of a length each.
fn lines_of_group(length: usize) -> usize {
    (NUMBERS_OF_GROUP / length).clamp(1, FREQUENCIES_PER_BLOCK)
}

impl BlockLines {
    pub(super) fn new(product: &FrequencyProduct) -> BlockLines {
        let (l0, order) = (product.grid.lengths()[0], product.order);
        let (parts, group) = (order.voxel_components(), l0 * lines_of_group(l0));
        BlockLines {
            lines: Vec::new(),
            loaded: vec![vec![vec![ZERO; FREQUENCIES_PER_BLOCK * l0]; parts]; LOADED_FREQUENCIES],
            scratch: vec![ZERO; product.transforms.line_scratch()],
            added: vec![vec![ZERO; group]; parts],
            full: vec![0.0; 2 * group],
            pair: WallPairLines::new(order.patch_components(), group),
        }
    }
}

/// The stored spectra of a group of lines.
struct StoredLines {
    /// Index of the first number of each line, and the half of the spectrum along y in which it lies.
    places: [(usize, SpectrumHalf); FREQUENCIES_PER_BLOCK],
    /// Numbers stored of a line.
    half: usize,
}

impl StoredLines {
    /// Unfolds the spectra of the lines of a length.
    #[inline(always)]
    fn unfold(&self, full: &mut [f64], array: &KernelSpectrum, length: usize) {
        for (full, &(from, half)) in full.chunks_exact_mut(2 * length).zip(&self.places) {
            unfold(full, &array.data[from..from + self.half], array.sign(1, half), array.odd[0]);
        }
    }
}

/// One block of frequencies f₁.
pub(super) struct FrequencyBlock<'a> {
    pub(super) product: &'a FrequencyProduct,
    pub(super) kernels: &'a GridSpectra,
    pub(super) walls: &'a [Option<WallSpectra>; 3],
    /// The first frequency f₁.
    pub(super) first: usize,
    pub(super) lines: &'a mut BlockLines,
    /// Spectra of the planes, by component: `[component][x][f₂][f₁ of the block]`.
    pub(super) block: &'a mut [Complex64],
    /// The sums of the block.
    pub(super) found: &'a mut WallSums,
}

impl simd::SimdKernel for FrequencyBlock<'_> {
    type Output = ();
    #[inline(always)]
    fn evaluate(mut self) {
        let (count, group) = (self.count(), lines_of_group(self.product.grid.lengths()[0]));
        self.found.clear();
        let h2 = self.product.grid.halves()[2];
        for first in (0..h2).step_by(LOADED_FREQUENCIES) {
            let all = first..(first + LOADED_FREQUENCIES).min(h2);
            self.load_lines(all.clone());
            for (k, f2) in all.clone().enumerate() {
                std::mem::swap(&mut self.lines.lines, &mut self.lines.loaded[k]);
                self.receive_x_walls(f2);
                self.transform_lines();
                for j in (0..count).step_by(group) {
                    self.exchange_lines(f2, j..(j + group).min(count));
                }
                self.inverse_transform_lines();
                self.send_x_walls(f2);
                std::mem::swap(&mut self.lines.lines, &mut self.lines.loaded[k]);
            }
            self.store_lines(all);
        }
    }
}

impl FrequencyBlock<'_> {
    /// Number of frequencies f₁ of the block.
    #[inline(always)]
    fn count(&self) -> usize {
        FREQUENCIES_PER_BLOCK.min(self.product.grid.lengths()[1] - self.first)
    }

    /// Index of the stored spectrum of (f₁, f₂). The frequencies f₂ are all stored; f₁ stands for its opposite in the upper half.
    #[inline(always)]
    fn stored_index(&self, f1: usize, f2: usize) -> usize {
        let row = f1.min(self.product.grid.lengths()[1] - f1) - self.kernels.first;
        row * self.product.grid.halves()[2] + f2
    }

    /// The half of the spectrum along y with frequency f₁.
    #[inline(always)]
    fn half_of(&self, f1: usize) -> SpectrumHalf {
        SpectrumHalf::of(f1, self.product.grid.lengths()[1])
    }

    /// Copies the lines along x of some frequencies f₂ out of the block.
    #[inline(always)]
    fn load_lines(&mut self, all: Range<usize>) {
        let (n0, l0) = (self.product.grid.cells[0], self.product.grid.lengths()[0]);
        let (count, size, h2) = (self.count(), self.product.component_size(), self.product.grid.halves()[2]);
        for p in 0..self.product.order.voxel_components() {
            let block = &self.block[p * size..(p + 1) * size];
            for x0 in (0..n0).step_by(NUMBERS_PER_CACHE_LINE) {
                let places = x0..(x0 + NUMBERS_PER_CACHE_LINE).min(n0);
                for (f2, lines) in all.clone().zip(&mut self.lines.loaded) {
                    for j in 0..count {
                        let line = &mut lines[p][j * l0..][places.clone()];
                        line.iter_mut().zip(places.clone()).for_each(|(to, x)| {
                            *to = block[(x * h2 + f2) * FREQUENCIES_PER_BLOCK + j];
                        });
                    }
                }
            }
            for lines in &mut self.lines.loaded[..all.len()] {
                lines[p][..count * l0].chunks_mut(l0).for_each(|line| {
                    line[n0..].fill(ZERO);
                    if p > 1 {
                        times_i(&mut line[..n0]);
                    }
                });
            }
        }
    }

    /// Copies the lines along x of some frequencies f₂ back into the block.
    #[inline(always)]
    fn store_lines(&mut self, all: Range<usize>) {
        let (n0, l0) = (self.product.grid.cells[0], self.product.grid.lengths()[0]);
        let (count, size, h2) = (self.count(), self.product.component_size(), self.product.grid.halves()[2]);
        for p in 0..self.product.order.voxel_components() {
            let block = &mut self.block[p * size..(p + 1) * size];
            if p > 1 {
                for lines in &mut self.lines.loaded[..all.len()] {
                    lines[p][..count * l0].chunks_mut(l0).for_each(|line| times_minus_i(&mut line[..n0]));
                }
            }
            for x0 in (0..n0).step_by(NUMBERS_PER_CACHE_LINE) {
                let places = x0..(x0 + NUMBERS_PER_CACHE_LINE).min(n0);
                for (f2, lines) in all.clone().zip(&self.lines.loaded) {
                    for j in 0..count {
                        let line = &lines[p][j * l0..][places.clone()];
                        line.iter().zip(places.clone()).for_each(|(from, x)| {
                            block[(x * h2 + f2) * FREQUENCIES_PER_BLOCK + j] = *from;
                        });
                    }
                }
            }
        }
    }

    /// Transforms the lines along x.
    #[inline(always)]
    fn transform_lines(&mut self) {
        let end = self.count() * self.product.grid.lengths()[0];
        let (transforms, BlockLines { lines, scratch, .. }) = (&self.product.transforms, &mut *self.lines);
        for (p, lines) in lines.iter_mut().enumerate() {
            transforms.transform_lines(&mut lines[..end], scratch);
            if p == 1 {
                times_i(&mut lines[..end]);
            }
        }
    }

    /// Transforms the lines along x back.
    #[inline(always)]
    fn inverse_transform_lines(&mut self) {
        let end = self.count() * self.product.grid.lengths()[0];
        let (transforms, BlockLines { lines, scratch, .. }) = (&self.product.transforms, &mut *self.lines);
        for (p, lines) in lines.iter_mut().enumerate() {
            if p == 1 {
                times_minus_i(&mut lines[..end]);
            }
            transforms.inverse_transform_lines(&mut lines[..end], scratch);
        }
    }

    /// Adds the radiation of the voxels incident on the walls across x, for all f₁ of the block.
    #[inline(always)]
    fn receive_x_walls(&mut self, f2: usize) {
        if self.walls[0].is_none() {
            return;
        }
        let (n0, l0, h2) =
            (self.product.grid.cells[0], self.product.grid.lengths()[0], self.product.grid.halves()[2]);
        let set = &self.kernels.walls[0];
        for (j, KernelTerm { p, q, array }) in
            (0..self.count()).flat_map(|j| set.terms.iter().map(move |t| (j, *t)))
        {
            let (f1, array) = (self.first + j, &set.arrays[array]);
            let from = self.stored_index(f1, f2) * n0;
            let sums = receive(&array.data[from..from + n0], &self.lines.lines[p][j * l0..j * l0 + n0]);
            // The slope across the wall has the opposite sign at the high end.
            let sign = array.sign(1, self.half_of(f1));
            let place = (q * h2 + f2) * FREQUENCIES_PER_BLOCK + j;
            self.found.x[0][place] += sums[0] * sign;
            self.found.x[1][place] += sums[1] * if p == 1 { -sign } else { sign };
        }
    }

    /// Adds the radiation of the walls across x incident on the voxels, for all f₁ of the block.
    #[inline(always)]
    fn send_x_walls(&mut self, f2: usize) {
        let Some([low, high]) = &self.walls[0] else { return };
        let (n0, h2) = (self.product.grid.cells[0], self.product.grid.halves()[2]);
        let [l0, l1, _] = self.product.grid.lengths();
        let set = &self.kernels.walls[0];
        for (j, KernelTerm { p, q, array }) in
            (0..self.count()).flat_map(|j| set.terms.iter().map(move |t| (j, *t)))
        {
            let (f1, array) = (self.first + j, &set.arrays[array]);
            let (from, place) = (self.stored_index(f1, f2) * n0, (q * h2 + f2) * l1 + f1);
            let sign = array.sign(1, self.half_of(f1));
            let sent = [low[place] * sign, high[place] * if p == 1 { -sign } else { sign }];
            send(&array.data[from..from + n0], &mut self.lines.lines[p][j * l0..j * l0 + n0], sent);
        }
    }

    /// Multiplies the lines of a group of frequencies f₁ with the spectra of the voxels, and exchanges with the walls across y and z.
    #[inline(always)]
    fn exchange_lines(&mut self, f2: usize, group: Range<usize>) {
        let (l0, h0) = (self.product.grid.lengths()[0], self.product.grid.halves()[0]);
        let line = group.start * l0..group.end * l0;
        self.lines.added.iter_mut().for_each(|a| a[..line.len()].fill(ZERO));
        let mut spectra =
            StoredLines { places: [(0, SpectrumHalf::Stored); FREQUENCIES_PER_BLOCK], half: h0 };
        for (place, j) in spectra.places.iter_mut().zip(group.clone()) {
            let f1 = self.first + j;
            *place = (self.stored_index(f1, f2) * h0, self.half_of(f1));
        }
        self.exchange_lines_with_walls(f2, group, &spectra);
        let BlockLines { lines, added, full, .. } = &mut *self.lines;
        let full = &mut full[..2 * line.len()];
        let set = &self.kernels.volume;
        for (k, array) in set.arrays.iter().enumerate() {
            spectra.unfold(full, array, l0);
            for &KernelTerm { p, q, .. } in set.terms.iter().filter(|t| t.array == k) {
                add_product(&mut added[p], &lines[q][line.clone()], full);
            }
        }
        for (lines, added) in lines.iter_mut().zip(&*added) {
            lines[line.clone()].copy_from_slice(&added[..line.len()]);
        }
    }

    /// Exchanges the lines of a group with the walls across y and z.
    #[inline(always)]
    fn exchange_lines_with_walls(&mut self, f2: usize, group: Range<usize>, spectra: &StoredLines) {
        let (v, first, count) = (self.product, self.first, self.count());
        let ([l0, l1, _], h2) = (v.grid.lengths(), v.grid.halves()[2]);
        let BlockLines { lines, added, full, pair, .. } = &mut *self.lines;
        let all = group.start * l0..group.end * l0;
        let full = &mut full[..2 * all.len()];
        for a in [1, 2] {
            let Some(sent) = &self.walls[a] else { continue };
            let (met, of) = match a {
                1 => (&mut self.found.y, h2),
                _ => (&mut self.found.z, count),
            };
            let across = |j: usize| match a {
                1 => FrequencyAcross { phase: v.phase[0][first + j], weight: 1.0 },
                _ => FrequencyAcross { phase: v.phase[1][f2], weight: half_weight(&v.grid, f2) },
            };
            // Spectra of a wall have the frequencies along its axis other than x.
            let place = |j: usize| if a == 1 { f2 } else { j };
            let (frequency, others) =
                (|j: usize| if a == 1 { f2 } else { first + j }, if a == 1 { h2 } else { l1 });
            let set = &self.kernels.walls[a];
            if let [array] = &set.arrays[..] {
                spectra.unfold(full, array, l0);
                for (k, j) in group.clone().enumerate() {
                    let sent = sent.each_ref().map(|s| &s[frequency(j) * l0..][..l0]);
                    let met = met.each_mut().map(|m| &mut m[place(j) * l0..][..l0]);
                    let (line, full) = (&lines[0][j * l0..(j + 1) * l0], &full[2 * k * l0..][..2 * l0]);
                    exchange(line, full, &mut added[0][k * l0..][..l0], met, sent, across(j));
                }
                continue;
            }
            for (k, j) in group.clone().enumerate() {
                let of = |q: usize| sent.each_ref().map(|s| &s[(q * others + frequency(j)) * l0..][..l0]);
                pair.load(k * l0..(k + 1) * l0, of, across(j).phase);
            }
            for (k, array) in set.arrays.iter().enumerate() {
                spectra.unfold(full, array, l0);
                for &KernelTerm { p, q, .. } in set.terms.iter().filter(|t| t.array == k) {
                    let (line, added) = (&lines[p][all.clone()], &mut added[p][..]);
                    // The slope across the walls is stored times i, with the opposite sign at the high wall.
                    let parity = usize::from(p == a + 1);
                    let (sent, met) = (&pair.sent[parity][q], &mut pair.met[parity][q]);
                    add_product(met, line, full);
                    add_product(added, sent, full);
                }
            }
            for (q, (k, j)) in
                (0..v.order.patch_components()).flat_map(|q| group.clone().enumerate().map(move |x| (q, x)))
            {
                let met = met.each_mut().map(|m| &mut m[(q * of + place(j)) * l0..][..l0]);
                pair.store(k * l0..(k + 1) * l0, q, met, across(j));
            }
        }
    }
}
