//! Exchange of voxels with voxels and walls: a real three-dimensional convolution, with the contributions of the walls added in frequency space.
//!
//! ```text
//!     P(x) = Σ_x' V(x − x') s(x')  +  Σ_walls Σ_y S(x, y) s_w(y)              P_w(y) = Σ_x S(x, y) s(x)
//! ```
//!
//! Lines of zeros are not transformed: the transforms run plane by plane along z and y, then block by block of [`FREQUENCIES_PER_BLOCK`] frequencies f₁ along x, are
//! multiplied with the spectra, and run back. In a block before the transform along x, walls across x are sums over d₀. Walls across y and z are
//! impulses at both ends of their axis, with kernels extended as even sequences:
//!
//! ```text
//!     wall to voxels:  P̂ += Ŝ (ŵ_low + e^{−2πi f (n−1)/N} ŵ_high)        back:  ŵ_low = Σ_f Ŝ ŝ,   ŵ_high = Σ_f e^{+2πi f (n−1)/N} Ŝ ŝ
//! ```
//!
//! With a linear basis every component (`basis.rs`) is a field with transforms of its own, and V and S are matrices between components. Slopes along y
//! and z are multiplied by i in frequency space along these axes, slopes along x after the transform along x.
//!
//! Along z half of the frequencies are stored; sums over them count f and −f together (weight ½ where f = −f), and the wall takes twice the real
//! part. Every sum has a fixed order, so that the bits do not depend on the number of threads.

use super::basis::{BasisOrder, KernelSpectrum, KernelTerm, SpectrumHalf};
use super::grid::BoxGrid;
use super::kernels::GridKernels;
use super::line_exchange::{
    WallPairLines, ZERO, add_product, exchange, receive, send, times_i, times_minus_i, unfold,
};
use super::slabs::{FREQUENCIES_PER_BLOCK, Slabs};
use super::transposition::Transposition;
use super::wall_sums::{BoxWall, WallSumLayout, WallSums};
use crate::distribution::ExchangeBuffers;
use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};
use std::sync::{Arc, Mutex};
use zonal_math::simd;

/// Spectra of two opposite walls, low and high, each by `[component][f_c][f_b]`.
pub(crate) type WallSpectra = [Vec<Complex64>; 2];

/// Plans of the transforms.
pub(crate) struct VolumeConvolution<'a> {
    grid: BoxGrid,
    order: BasisOrder,
    slabs: Slabs<'a>,
    forward: [Arc<dyn Fft<f64>>; 2],
    back: [Arc<dyn Fft<f64>>; 2],
    real: Arc<dyn RealToComplex<f64>>,
    unreal: Arc<dyn ComplexToReal<f64>>,
    /// e^{−2πi f (n−1)/N} of the axes 1 and 2.
    phase: [Vec<Complex64>; 2],
    /// Buffers, reused by every product.
    buffers: Mutex<ProductBuffers>,
}

/// Buffers of a product.
#[derive(Default)]
struct ProductBuffers {
    /// The spectrum of the voxels: `[own block][component][x][f₂][f₁ of the block]`.
    spectrum: Vec<Complex64>,
    /// Spectra of some planes on their way to other ranks or back; empty in one process.
    messages: ExchangeBuffers,
    /// The sums of each block of frequencies.
    sums: Vec<WallSums>,
    /// Values of the voxels.
    values: Vec<f64>,
}

impl<'a> VolumeConvolution<'a> {
    /// Plans for a grid.
    pub(crate) fn new(grid: BoxGrid, order: BasisOrder, slabs: Slabs<'a>) -> VolumeConvolution<'a> {
        let n = grid.lengths();
        let (mut complex, mut real) = (FftPlanner::new(), RealFftPlanner::new());
        let phase = |a: usize| {
            let turn =
                |f: usize| -std::f64::consts::TAU * ((f * (grid.cells[a] - 1)) % n[a]) as f64 / n[a] as f64;
            (0..n[a]).map(|f| Complex64::from_polar(1.0, turn(f))).collect()
        };
        VolumeConvolution {
            forward: [0, 1].map(|a| complex.plan_fft_forward(n[a])),
            back: [0, 1].map(|a| complex.plan_fft_inverse(n[a])),
            real: real.plan_fft_forward(n[2]),
            unreal: real.plan_fft_inverse(n[2]),
            phase: [phase(1), phase(2)],
            buffers: Mutex::default(),
            grid,
            order,
            slabs,
        }
    }

    /// Replaces the strengths of the voxels of this rank, `values` by component and cell, by their incident power, with that from wall spectra `walls`.
    /// Returns the spectra of the incident power of the walls that this rank completes ([`WallSumLayout::complete`]).
    pub(crate) fn apply(
        &self,
        k: &GridKernels,
        values: &mut [f64],
        walls: &[Option<WallSpectra>; 3],
    ) -> Vec<(BoxWall, Vec<Complex64>)> {
        let ([_, n1, n2], parts, layout) = (self.grid.cells, self.order.voxel_components(), self.wall_sums());
        let (blocks, planes): (Vec<usize>, _) = (self.slabs.blocks().collect(), self.slabs.planes());
        let size = self.component_size();
        let mut buffers = std::mem::take(&mut *self.buffers.lock().unwrap_or_else(|e| e.into_inner()));
        let ProductBuffers { spectrum, messages, sums, .. } = &mut buffers;
        spectrum.resize(blocks.len() * parts * size, ZERO);
        sums.extend((sums.len()..blocks.len()).map(|i| layout.zeros(blocks[i])));
        let transposition = Transposition { slabs: self.slabs, piece: self.piece_size(), parts };
        // A rank without planes has values of no component.
        let count = (planes.len() * n1 * n2).max(1);
        for p in 0..parts {
            let own = values.chunks(count).nth(p).unwrap_or_default();
            transposition.bring_to_frequencies(p, messages, spectrum, |planes, slots| {
                self.transform_planes(&own[planes.start * n1 * n2..planes.end * n1 * n2], slots);
            });
        }
        let chunks = spectrum.par_chunks_mut(parts * size).zip(&mut *sums).enumerate().with_max_len(1);
        chunks.for_each_init(
            || BlockLines::new(self),
            |lines, (i, (block, found))| {
                let first = blocks[i] * FREQUENCIES_PER_BLOCK;
                simd::run(FrequencyBlock { volume: self, kernels: k, walls, first, lines, block, found });
            },
        );
        for p in 0..parts {
            let own = values.chunks_mut(count).nth(p).unwrap_or_default();
            transposition.bring_to_planes(p, messages, spectrum, |planes, blocks| {
                let out = &mut own[planes.start * n1 * n2..planes.end * n1 * n2];
                self.inverse_transform_planes(blocks, out);
            });
        }
        let walls = layout.complete(sums);
        *self.buffers.lock().unwrap_or_else(|e| e.into_inner()) = buffers;
        walls
    }

    /// Shapes of the sums for the walls.
    fn wall_sums(&self) -> WallSumLayout<'a> {
        WallSumLayout { grid: self.grid, order: self.order, slabs: self.slabs }
    }

    /// Numbers of one plane in a block.
    fn piece_size(&self) -> usize {
        self.grid.halves()[2] * FREQUENCIES_PER_BLOCK
    }

    /// Numbers of one component of a block.
    fn component_size(&self) -> usize {
        self.grid.cells[0] * self.piece_size()
    }

    /// Number of voxels of this rank.
    pub(crate) fn own_count(&self) -> usize {
        self.slabs.planes().len() * self.grid.cells[1] * self.grid.cells[2]
    }

    /// A buffer for the values of the voxels of this rank by component and cell, with any content.
    pub(crate) fn take_values(&self) -> Vec<f64> {
        let mut buffers = self.buffers.lock().unwrap_or_else(|e| e.into_inner());
        let mut values = std::mem::take(&mut buffers.values);
        values.resize(self.order.voxel_components() * self.own_count(), 0.0);
        values
    }

    /// Keeps a buffer for [`VolumeConvolution::take_values`] of the next product.
    pub(crate) fn return_values(&self, values: Vec<f64>) {
        self.buffers.lock().unwrap_or_else(|e| e.into_inner()).values = values;
    }

    /// Frees the buffers; the next product allocates them again.
    pub(crate) fn free_buffers(&self) {
        *self.buffers.lock().unwrap_or_else(|e| e.into_inner()) = ProductBuffers::default();
    }

    /// Transforms along z and y, plane by plane.
    fn transform_planes(&self, s: &[f64], slots: Vec<Vec<&mut [Complex64]>>) {
        let ([_, n1, n2], [_, l1, l2], h2) = (self.grid.cells, self.grid.lengths(), self.grid.halves()[2]);
        let plan = &self.forward[1];
        let work = || {
            let scratch = vec![ZERO; plan.get_inplace_scratch_len()];
            (vec![0.0; l2], vec![ZERO; h2], vec![ZERO; h2 * l1], self.real.make_scratch_vec(), scratch)
        };
        slots.into_par_iter().zip(s.par_chunks(n1 * n2)).with_max_len(1).for_each_init(
            work,
            |(line, spectrum, plane, scratch_z, scratch_y), (mut slot, cells)| {
                for (y, cells) in cells.chunks(n2).enumerate() {
                    line[..n2].copy_from_slice(cells);
                    line[n2..].fill(0.0);
                    let done = self.real.process_with_scratch(line, spectrum, scratch_z);
                    assert!(done.is_ok(), "buffers of the plan's lengths");
                    spectrum.iter().enumerate().for_each(|(f, x)| plane[f * l1 + y] = *x);
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
    fn inverse_transform_planes(&self, blocks: &[&[Complex64]], out: &mut [f64]) {
        let ([_, n1, n2], [_, l1, l2], h2) = (self.grid.cells, self.grid.lengths(), self.grid.halves()[2]);
        let plan = &self.back[1];
        let work = || {
            let scratch = vec![ZERO; plan.get_inplace_scratch_len()];
            (vec![0.0; l2], vec![ZERO; h2], vec![ZERO; h2 * l1], self.unreal.make_scratch_vec(), scratch)
        };
        out.par_chunks_mut(n1 * n2).enumerate().with_max_len(1).for_each_init(
            work,
            |(line, spectrum, plane, scratch_z, scratch_y), (x, cells)| {
                for (b, block) in blocks.iter().enumerate() {
                    let piece = &block[x * h2 * FREQUENCIES_PER_BLOCK..(x + 1) * h2 * FREQUENCIES_PER_BLOCK];
                    let (from, to) = (b * FREQUENCIES_PER_BLOCK, ((b + 1) * FREQUENCIES_PER_BLOCK).min(l1));
                    for (f2, part) in piece.chunks(FREQUENCIES_PER_BLOCK).enumerate() {
                        plane[f2 * l1 + from..f2 * l1 + to].copy_from_slice(&part[..to - from]);
                    }
                }
                plan.process_with_scratch(plane, scratch_y);
                for (y, cells) in cells.chunks_mut(n2).enumerate() {
                    spectrum.iter_mut().enumerate().for_each(|(f, x)| *x = plane[f * l1 + y]);
                    // Real by symmetry; imaginary rounding errors are dropped.
                    spectrum[0].im = 0.0;
                    if l2.is_multiple_of(2) {
                        spectrum[h2 - 1].im = 0.0;
                    }
                    let done = self.unreal.process_with_scratch(spectrum, line, scratch_z);
                    assert!(done.is_ok(), "buffers of the plan's lengths");
                    cells.copy_from_slice(&line[..n2]);
                }
            },
        );
    }
}

/// Buffers for the lines of a block.
struct BlockLines {
    /// By component.
    lines: Vec<Vec<Complex64>>,
    scratch: Vec<Complex64>,
    /// Incident power of a line, by component.
    added: Vec<Vec<Complex64>>,
    /// An unfolded spectrum, each value twice.
    full: Vec<f64>,
    /// The exchange of a line with a pair of walls.
    pair: WallPairLines,
}

impl BlockLines {
    fn new(v: &VolumeConvolution) -> BlockLines {
        let (l0, parts) = (v.grid.lengths()[0], v.order.voxel_components());
        let scratch = v.forward[0].get_inplace_scratch_len().max(v.back[0].get_inplace_scratch_len());
        BlockLines {
            lines: vec![vec![ZERO; FREQUENCIES_PER_BLOCK * l0]; parts],
            scratch: vec![ZERO; scratch],
            added: vec![vec![ZERO; l0]; parts],
            full: vec![0.0; 2 * l0],
            pair: WallPairLines::new(v.order.patch_components(), l0),
        }
    }
}

/// One block of frequencies f₁.
struct FrequencyBlock<'a> {
    volume: &'a VolumeConvolution<'a>,
    kernels: &'a GridKernels,
    walls: &'a [Option<WallSpectra>; 3],
    first: usize,
    lines: &'a mut BlockLines,
    /// By component.
    block: &'a mut [Complex64],
    /// The sums of the block.
    found: &'a mut WallSums,
}

impl simd::SimdKernel for FrequencyBlock<'_> {
    type Output = ();
    #[inline(always)]
    fn evaluate(mut self) {
        let count = self.count();
        self.found.clear();
        for f2 in 0..self.volume.grid.halves()[2] {
            self.load_lines(f2);
            self.receive_x_walls(f2);
            self.transform_lines();
            for j in 0..count {
                self.exchange_line(f2, j);
            }
            self.inverse_transform_lines();
            self.send_x_walls(f2);
            self.store_lines(f2);
        }
    }
}

impl FrequencyBlock<'_> {
    /// Number of frequencies f₁ of the block.
    #[inline(always)]
    fn count(&self) -> usize {
        FREQUENCIES_PER_BLOCK.min(self.volume.grid.lengths()[1] - self.first)
    }

    /// Index of the stored spectrum of (f₁, f₂). The frequencies f₂ are all stored; f₁ stands for its opposite in the upper half.
    #[inline(always)]
    fn stored_index(&self, f1: usize, f2: usize) -> usize {
        let row = f1.min(self.volume.grid.lengths()[1] - f1) - self.kernels.first;
        row * self.volume.grid.halves()[2] + f2
    }

    /// The half of the spectrum along y with frequency f₁.
    #[inline(always)]
    fn half_of(&self, f1: usize) -> SpectrumHalf {
        SpectrumHalf::of(f1, self.volume.grid.lengths()[1])
    }

    /// Copies the lines along x of frequency f₂ out of the block.
    #[inline(always)]
    fn load_lines(&mut self, f2: usize) {
        let (n0, l0) = (self.volume.grid.cells[0], self.volume.grid.lengths()[0]);
        let (count, size, h2) = (self.count(), self.volume.component_size(), self.volume.grid.halves()[2]);
        for (p, lines) in self.lines.lines.iter_mut().enumerate() {
            let rows =
                self.block[p * size..(p + 1) * size].chunks(FREQUENCIES_PER_BLOCK).skip(f2).step_by(h2);
            for (x, row) in rows.enumerate() {
                (0..count).for_each(|j| lines[j * l0 + x] = row[j]);
            }
            lines[..count * l0].chunks_mut(l0).for_each(|line| {
                line[n0..].fill(ZERO);
                if p > 1 {
                    times_i(&mut line[..n0]);
                }
            });
        }
    }

    /// Copies the lines along x of frequency f₂ back into the block.
    #[inline(always)]
    fn store_lines(&mut self, f2: usize) {
        let (n0, l0) = (self.volume.grid.cells[0], self.volume.grid.lengths()[0]);
        let (count, size, h2) = (self.count(), self.volume.component_size(), self.volume.grid.halves()[2]);
        for (p, lines) in self.lines.lines.iter_mut().enumerate() {
            if p > 1 {
                lines[..count * l0].chunks_mut(l0).for_each(|line| times_minus_i(&mut line[..n0]));
            }
            let rows =
                self.block[p * size..(p + 1) * size].chunks_mut(FREQUENCIES_PER_BLOCK).skip(f2).step_by(h2);
            for (x, row) in rows.enumerate() {
                (0..count).for_each(|j| row[j] = lines[j * l0 + x]);
            }
        }
    }

    /// Transforms the lines along x.
    #[inline(always)]
    fn transform_lines(&mut self) {
        let end = self.count() * self.volume.grid.lengths()[0];
        let BlockLines { lines, scratch, .. } = &mut *self.lines;
        for (p, lines) in lines.iter_mut().enumerate() {
            self.volume.forward[0].process_with_scratch(&mut lines[..end], scratch);
            if p == 1 {
                times_i(&mut lines[..end]);
            }
        }
    }

    /// Transforms the lines along x back.
    #[inline(always)]
    fn inverse_transform_lines(&mut self) {
        let end = self.count() * self.volume.grid.lengths()[0];
        let BlockLines { lines, scratch, .. } = &mut *self.lines;
        for (p, lines) in lines.iter_mut().enumerate() {
            if p == 1 {
                times_minus_i(&mut lines[..end]);
            }
            self.volume.back[0].process_with_scratch(&mut lines[..end], scratch);
        }
    }

    /// Adds the radiation of the voxels incident on the walls across x, for all f₁ of the block.
    #[inline(always)]
    fn receive_x_walls(&mut self, f2: usize) {
        if self.walls[0].is_none() {
            return;
        }
        let (n0, l0, h2) =
            (self.volume.grid.cells[0], self.volume.grid.lengths()[0], self.volume.grid.halves()[2]);
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
        let (n0, h2) = (self.volume.grid.cells[0], self.volume.grid.halves()[2]);
        let [l0, l1, _] = self.volume.grid.lengths();
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

    /// Multiplies the line of frequency f₁ number `j` with the spectra of the voxels, and exchanges with the walls across y and z.
    #[inline(always)]
    fn exchange_line(&mut self, f2: usize, j: usize) {
        let f1 = self.first + j;
        let (l0, h0) = (self.volume.grid.lengths()[0], self.volume.grid.halves()[0]);
        let (from, half) = (self.stored_index(f1, f2) * h0, self.half_of(f1));
        let line = j * l0..(j + 1) * l0;
        self.lines.added.iter_mut().for_each(|a| a.fill(ZERO));
        let write = |full: &mut [f64], array: &KernelSpectrum| {
            unfold(full, &array.data[from..from + h0], array.sign(1, half), array.odd[0]);
        };
        self.exchange_line_with_walls(f2, j, &write);
        let BlockLines { lines, added, full, .. } = &mut *self.lines;
        let set = &self.kernels.volume;
        for (k, array) in set.arrays.iter().enumerate() {
            write(full, array);
            for &KernelTerm { p, q, .. } in set.terms.iter().filter(|t| t.array == k) {
                add_product(&mut added[p], &lines[q][line.clone()], full);
            }
        }
        for (lines, added) in lines.iter_mut().zip(&*added) {
            lines[line.clone()].copy_from_slice(added);
        }
    }

    /// Exchanges the line of frequency f₁ number `j` with the walls across y and z; `write` unfolds a spectrum.
    #[inline(always)]
    fn exchange_line_with_walls(
        &mut self,
        f2: usize,
        j: usize,
        write: &impl Fn(&mut [f64], &KernelSpectrum),
    ) {
        let (v, f1, count) = (self.volume, self.first + j, self.count());
        let ([l0, l1, _], h2) = (v.grid.lengths(), v.grid.halves()[2]);
        let BlockLines { lines, added, full, pair, .. } = &mut *self.lines;
        for a in [1, 2] {
            let Some(sent) = &self.walls[a] else { continue };
            let (met, place, of) = match a {
                1 => (&mut self.found.y, f2, h2),
                _ => (&mut self.found.z, j, count),
            };
            let (phase, weight) = match a {
                1 => (v.phase[0][f1], 1.0),
                _ => (v.phase[1][f2], v.wall_sums().weight(f2)),
            };
            // Spectra of a wall have the frequencies along its axis other than x.
            let (g, others) = if a == 1 { (f2, h2) } else { (f1, l1) };
            let set = &self.kernels.walls[a];
            if let [array] = &set.arrays[..] {
                write(full, array);
                let sent = sent.each_ref().map(|s| &s[g * l0..][..l0]);
                let met = met.each_mut().map(|m| &mut m[place * l0..][..l0]);
                exchange(&lines[0][j * l0..(j + 1) * l0], full, &mut added[0], met, sent, (phase, weight));
                continue;
            }
            pair.load(|q| sent.each_ref().map(|s| &s[(q * others + g) * l0..][..l0]), phase);
            for (k, array) in set.arrays.iter().enumerate() {
                write(full, array);
                for &KernelTerm { p, q, .. } in set.terms.iter().filter(|t| t.array == k) {
                    let (line, added) = (&lines[p][j * l0..(j + 1) * l0], &mut added[p][..]);
                    // The slope across the walls is stored times i, with the opposite sign at the high wall.
                    let parity = usize::from(p == a + 1);
                    let (sent, met) = (&pair.sent[parity][q], &mut pair.met[parity][q]);
                    add_product(met, line, full);
                    add_product(added, sent, full);
                }
            }
            for q in 0..v.order.patch_components() {
                let met = met.each_mut().map(|m| &mut m[(q * of + place) * l0..][..l0]);
                pair.store(q, met, (phase, weight));
            }
        }
    }
}
