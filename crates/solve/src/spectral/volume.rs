//! Voxels with voxels and with walls: one real three-dimensional convolution, and what the walls add to it on the way.
//!
//! ```text
//!     P(x) = Σ_x' V(x − x') s(x')  +  Σ_walls Σ_y S(x, y) s_w(y)              P_w(y) = Σ_x S(x, y) s(x)
//! ```
//!
//! Lines of zeros are never transformed: plane by plane along z and y, then block by block of [`BLOCK`] frequencies f₁ along x, times
//! the spectra, and back. In a block, x is still space before its transform: there walls across x are sums over d₀. Walls across y and z are
//! impulses at both ends of their axis, whose kernels are extended evenly:
//!
//! ```text
//!     wall to voxels:  P̂ += Ŝ (ŵ_low + e^{−2πi f (n−1)/N} ŵ_high)        back:  ŵ_low = Σ_f Ŝ ŝ,   ŵ_high = Σ_f e^{+2πi f (n−1)/N} Ŝ ŝ
//! ```
//!
//! Along z half of the frequencies are kept; sums over them count f and −f at once (weight ½ where f = −f), and the wall takes twice the real
//! part. Every sum has an order of its own: the bits are the same for any number of threads.

use super::grid::Grid;
use super::kernels::Kernels;
use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};
use std::sync::{Arc, Mutex};
use zonal_math::simd;

/// Frequencies along y that are worked on together.
pub const BLOCK: usize = 16;

const ZERO: Complex64 = Complex64 { re: 0.0, im: 0.0 };

/// Spectra of two opposite walls, low and high, each by `[f_c][f_b]`.
pub type Pair = [Vec<Complex64>; 2];

/// Plans of the transforms.
pub struct Volume {
    grid: Grid,
    forward: [Arc<dyn Fft<f64>>; 2],
    back: [Arc<dyn Fft<f64>>; 2],
    real: Arc<dyn RealToComplex<f64>>,
    unreal: Arc<dyn ComplexToReal<f64>>,
    /// e^{−2πi f (n−1)/N} of the axes 1 and 2.
    phase: [Vec<Complex64>; 2],
    /// The spectrum, kept from one application to the next.
    room: Mutex<Vec<Complex64>>,
}

/// What a block of frequencies finds about the walls.
struct Found {
    /// Walls across x: `[side][f₂][f₁ of the block]`.
    x: [Vec<Complex64>; 2],
    /// Walls across y: `[side][f₂][f₀]`, this block's part of the sum.
    y: [Vec<Complex64>; 2],
    /// Walls across z: `[side][f₁ of the block][f₀]`.
    z: [Vec<Complex64>; 2],
}

impl Volume {
    /// Plans for a grid.
    pub fn new(grid: Grid) -> Volume {
        let n = grid.lengths();
        let (mut complex, mut real) = (FftPlanner::new(), RealFftPlanner::new());
        let phase = |a: usize| {
            let turn =
                |f: usize| -std::f64::consts::TAU * ((f * (grid.cells[a] - 1)) % n[a]) as f64 / n[a] as f64;
            (0..n[a]).map(|f| Complex64::from_polar(1.0, turn(f))).collect()
        };
        Volume {
            forward: [0, 1].map(|a| complex.plan_fft_forward(n[a])),
            back: [0, 1].map(|a| complex.plan_fft_inverse(n[a])),
            real: real.plan_fft_forward(n[2]),
            unreal: real.plan_fft_inverse(n[2]),
            phase: [phase(1), phase(2)],
            room: Mutex::default(),
            grid,
        }
    }

    /// What arrives at the voxels of strengths `s` (by cell) and of `walls`, and the spectra of what arrives at the walls: those across the
    /// first two axes times the weight of f₂, those across the third half of a sum of which twice the real part counts.
    pub fn apply(
        &self,
        k: &Kernels,
        s: &[f64],
        walls: &[Option<Pair>; 3],
        out: &mut [f64],
    ) -> [Option<Pair>; 3] {
        let (n, h2) = (self.grid.cells, self.grid.halves()[2]);
        let blocks = self.grid.lengths()[1].div_ceil(BLOCK);
        let size = n[0] * h2 * BLOCK;
        let mut room = std::mem::take(&mut *self.room.lock().unwrap_or_else(|e| e.into_inner()));
        room.resize(blocks * size, ZERO);
        let mut slots: Vec<Vec<&mut [Complex64]>> = (0..n[0]).map(|_| Vec::with_capacity(blocks)).collect();
        for block in room.chunks_mut(size) {
            block.chunks_mut(h2 * BLOCK).zip(&mut slots).for_each(|(piece, slot)| slot.push(piece));
        }
        self.planes(s, slots);
        let found: Vec<Found> = room
            .par_chunks_mut(size)
            .enumerate()
            .with_max_len(1)
            .map_init(
                || Lines::new(self),
                |lines, (b, block)| {
                    simd::run(Block { volume: self, kernels: k, walls, first: b * BLOCK, lines, block })
                },
            )
            .collect();
        self.planes_back(&room, size, out);
        *self.room.lock().unwrap_or_else(|e| e.into_inner()) = room;
        self.gather(found)
    }

    /// Along z and y, plane by plane.
    fn planes(&self, s: &[f64], slots: Vec<Vec<&mut [Complex64]>>) {
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
                    for (piece, part) in slot.iter_mut().zip(line.chunks(BLOCK)) {
                        piece[f2 * BLOCK..f2 * BLOCK + part.len()].copy_from_slice(part);
                    }
                }
            },
        );
    }

    /// Back along y and z, plane by plane.
    fn planes_back(&self, room: &[Complex64], size: usize, out: &mut [f64]) {
        let ([_, n1, n2], [_, l1, l2], h2) = (self.grid.cells, self.grid.lengths(), self.grid.halves()[2]);
        let plan = &self.back[1];
        let work = || {
            let scratch = vec![ZERO; plan.get_inplace_scratch_len()];
            (vec![0.0; l2], vec![ZERO; h2], vec![ZERO; h2 * l1], self.unreal.make_scratch_vec(), scratch)
        };
        out.par_chunks_mut(n1 * n2).enumerate().with_max_len(1).for_each_init(
            work,
            |(line, spectrum, plane, scratch_z, scratch_y), (x, cells)| {
                for (b, block) in room.chunks(size).enumerate() {
                    let piece = &block[x * h2 * BLOCK..(x + 1) * h2 * BLOCK];
                    let (from, to) = (b * BLOCK, ((b + 1) * BLOCK).min(l1));
                    for (f2, part) in piece.chunks(BLOCK).enumerate() {
                        plane[f2 * l1 + from..f2 * l1 + to].copy_from_slice(&part[..to - from]);
                    }
                }
                plan.process_with_scratch(plane, scratch_y);
                for (y, cells) in cells.chunks_mut(n2).enumerate() {
                    spectrum.iter_mut().enumerate().for_each(|(f, x)| *x = plane[f * l1 + y]);
                    // Real by symmetry; what rounding leaves is cut off.
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

    /// Weight of a frequency along z: it stands for its opposite too.
    fn weight(&self, f2: usize) -> f64 {
        let own = f2 == 0 || 2 * f2 == self.grid.lengths()[2];
        if own { 0.5 } else { 1.0 }
    }

    /// Puts the blocks' parts together, in their order.
    fn gather(&self, found: Vec<Found>) -> [Option<Pair>; 3] {
        let ([l0, l1, _], h2) = (self.grid.lengths(), self.grid.halves()[2]);
        let mut sides = [0, 1, 2].map(|a| {
            let size = [l1 * h2, l0 * h2, l0 * l1][a];
            (!self.grid.periodic[a]).then(|| [vec![ZERO; size], vec![ZERO; size]])
        });
        for side in 0..2 {
            if let Some(x) = &mut sides[0] {
                for (b, f) in found.iter().enumerate() {
                    for f2 in 0..h2 {
                        let (from, to) = (b * BLOCK, ((b + 1) * BLOCK).min(l1));
                        let part = &f.x[side][f2 * BLOCK..f2 * BLOCK + to - from];
                        let w = self.weight(f2);
                        let line = &mut x[side][f2 * l1 + from..f2 * l1 + to];
                        line.iter_mut().zip(part).for_each(|(o, p)| *o = p * w);
                    }
                }
            }
            if let Some(y) = &mut sides[1] {
                y[side].par_chunks_mut(l0).enumerate().for_each(|(f2, line)| {
                    for f in &found {
                        let part = &f.y[side][f2 * l0..(f2 + 1) * l0];
                        line.iter_mut().zip(part).for_each(|(o, p)| *o += p);
                    }
                    let w = self.weight(f2);
                    line.iter_mut().for_each(|o| *o *= w);
                });
            }
            if let Some(z) = &mut sides[2] {
                let all = found.iter().flat_map(|f| &f.z[side]);
                z[side].iter_mut().zip(all).for_each(|(o, p)| *o = *p);
            }
        }
        sides
    }
}

/// Room for the lines of a block.
struct Lines {
    lines: Vec<Complex64>,
    scratch: Vec<Complex64>,
    /// What the walls add to a line.
    added: Vec<Complex64>,
    /// An even spectrum written out.
    full: Vec<f64>,
}

impl Lines {
    fn new(v: &Volume) -> Lines {
        let l0 = v.grid.lengths()[0];
        let scratch = v.forward[0].get_inplace_scratch_len().max(v.back[0].get_inplace_scratch_len());
        Lines {
            lines: vec![ZERO; BLOCK * l0],
            scratch: vec![ZERO; scratch],
            added: vec![ZERO; l0],
            full: vec![0.0; l0],
        }
    }
}

/// The work on one block.
struct Block<'a> {
    volume: &'a Volume,
    kernels: &'a Kernels,
    walls: &'a [Option<Pair>; 3],
    first: usize,
    lines: &'a mut Lines,
    block: &'a mut [Complex64],
}

impl simd::Work for Block<'_> {
    type Output = Found;
    #[inline(always)]
    fn go(self) -> Found {
        let Block { volume: v, kernels, walls, first, lines, block } = self;
        let Lines { lines, scratch, added, full } = lines;
        let ([n0, _, _], [l0, l1, _], [h0, _, h2]) = (v.grid.cells, v.grid.lengths(), v.grid.halves());
        let count = BLOCK.min(l1 - first);
        let room =
            |a: usize, size: usize| [0, 1].map(|_| vec![ZERO; if walls[a].is_some() { size } else { 0 }]);
        let mut found = Found { x: room(0, h2 * BLOCK), y: room(1, h2 * l0), z: room(2, count * l0) };
        let used = &mut lines[..count * l0];
        for f2 in 0..h2 {
            for (x, row) in block.chunks(BLOCK).skip(f2).step_by(h2).enumerate() {
                (0..count).for_each(|j| used[j * l0 + x] = row[j]);
            }
            for j in 0..count {
                let line = &mut used[j * l0..(j + 1) * l0];
                line[n0..].fill(ZERO);
                if walls[0].is_some() {
                    let at = ((first + j).min(l1 - first - j) * h2 + f2) * n0;
                    let sums = meet(&kernels.walls[0][at..at + n0], &line[..n0]);
                    (0..2).for_each(|side| found.x[side][f2 * BLOCK + j] = sums[side]);
                }
            }
            v.forward[0].process_with_scratch(used, scratch);
            for j in 0..count {
                let f1 = first + j;
                let at = (f1.min(l1 - f1) * h2 + f2) * h0;
                let line = &mut used[j * l0..(j + 1) * l0];
                added.fill(ZERO);
                if let Some(sent) = &walls[1] {
                    unfold(full, &kernels.walls[1][at..at + h0]);
                    let sent = [0, 1].map(|s| &sent[s][f2 * l0..(f2 + 1) * l0]);
                    let met = found.y.each_mut().map(|m| &mut m[f2 * l0..(f2 + 1) * l0]);
                    exchange(line, full, added, met, sent, (v.phase[0][f1], 1.0));
                }
                if let Some(sent) = &walls[2] {
                    unfold(full, &kernels.walls[2][at..at + h0]);
                    let sent = [0, 1].map(|s| &sent[s][f1 * l0..(f1 + 1) * l0]);
                    let met = found.z.each_mut().map(|m| &mut m[j * l0..(j + 1) * l0]);
                    exchange(line, full, added, met, sent, (v.phase[1][f2], v.weight(f2)));
                }
                unfold(full, &kernels.volume[at..at + h0]);
                for ((x, k), more) in line.iter_mut().zip(&*full).zip(&*added) {
                    *x = *x * k + more;
                }
            }
            v.back[0].process_with_scratch(used, scratch);
            for j in 0..count {
                let line = &mut used[j * l0..j * l0 + n0];
                if let Some([low, high]) = &walls[0] {
                    let f1 = first + j;
                    let at = (f1.min(l1 - f1) * h2 + f2) * n0;
                    let sent = [low[f2 * l1 + f1], high[f2 * l1 + f1]];
                    send(&kernels.walls[0][at..at + n0], line, sent);
                }
            }
            for (x, row) in block.chunks_mut(BLOCK).skip(f2).step_by(h2).enumerate() {
                (0..count).for_each(|j| row[j] = used[j * l0 + x]);
            }
        }
        found
    }
}

/// An even spectrum of which one half is given, written out.
#[inline(always)]
fn unfold(full: &mut [f64], half: &[f64]) {
    let n = full.len();
    full[..half.len()].copy_from_slice(half);
    full[half.len()..].iter_mut().zip(half[..=n - half.len()].iter().rev()).for_each(|(x, h)| *x = *h);
}

/// What a line of voxels sends to the walls at its ends.
#[inline(always)]
fn meet(kernel: &[f64], line: &[Complex64]) -> [Complex64; 2] {
    let mut sums = [ZERO; 2];
    for ((x, k), r) in line.iter().zip(kernel).zip(kernel.iter().rev()) {
        sums = [sums[0] + x * k, sums[1] + x * r];
    }
    sums
}

/// What the walls at the ends of a line of voxels send to it.
#[inline(always)]
fn send(kernel: &[f64], line: &mut [Complex64], sent: [Complex64; 2]) {
    for ((x, k), r) in line.iter_mut().zip(kernel).zip(kernel.iter().rev()) {
        *x += sent[0] * k + sent[1] * r;
    }
}

/// Voxels and the walls across another axis, in frequencies; the phase takes the low wall to the high one.
#[inline(always)]
fn exchange(
    line: &[Complex64],
    kernel: &[f64],
    added: &mut [Complex64],
    [low, high]: [&mut [Complex64]; 2],
    [from_low, from_high]: [&[Complex64]; 2],
    (phase, weight): (Complex64, f64),
) {
    let n = line.len();
    let (added, low, high) = (&mut added[..n], &mut low[..n], &mut high[..n]);
    let (kernel, from_low, from_high) = (&kernel[..n], &from_low[..n], &from_high[..n]);
    for i in 0..n {
        let u = line[i] * (kernel[i] * weight);
        low[i] += u;
        high[i] += u * phase.conj();
        added[i] += (from_low[i] + from_high[i] * phase) * kernel[i];
    }
}
