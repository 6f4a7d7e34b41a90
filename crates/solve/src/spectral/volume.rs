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
//! Radiosity that varies inside a zone has components (`basis.rs`), each a field of its own with its transforms; then V and S are matrices between
//! components. Slopes along y and z are taken times i while frequencies are along these axes, slopes along x after the transform along x.
//!
//! Along z half of the frequencies are kept; sums over them count f and −f at once (weight ½ where f = −f), and the wall takes twice the real
//! part. Every sum has an order of its own: the bits are the same for any number of threads.

use super::basis::{Array, Term, Variation};
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

/// Spectra of two opposite walls, low and high, each by `[component][f_c][f_b]`.
pub type Pair = [Vec<Complex64>; 2];

/// Plans of the transforms.
pub struct Volume {
    grid: Grid,
    variation: Variation,
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
    /// Walls across x: `[side][component][f₂][f₁ of the block]`.
    x: [Vec<Complex64>; 2],
    /// Walls across y: `[side][component][f₂][f₀]`, this block's part of the sum.
    y: [Vec<Complex64>; 2],
    /// Walls across z: `[side][component][f₁ of the block][f₀]`.
    z: [Vec<Complex64>; 2],
}

impl Volume {
    /// Plans for a grid.
    pub fn new(grid: Grid, variation: Variation) -> Volume {
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
            variation,
        }
    }

    /// What arrives at the voxels of strengths `s` (by component and cell) and of `walls`, and the spectra of what arrives at the walls: those across the
    /// first two axes times the weight of f₂, those across the third half of a sum of which twice the real part counts.
    pub fn apply(
        &self,
        k: &Kernels,
        s: &[f64],
        walls: &[Option<Pair>; 3],
        out: &mut [f64],
    ) -> [Option<Pair>; 3] {
        let (n, h2, count) = (self.grid.cells, self.grid.halves()[2], self.grid.count());
        let (blocks, parts) = (self.grid.lengths()[1].div_ceil(BLOCK), self.variation.voxel());
        let size = n[0] * h2 * BLOCK;
        let mut room = std::mem::take(&mut *self.room.lock().unwrap_or_else(|e| e.into_inner()));
        room.resize(blocks * parts * size, ZERO);
        let mut slots: Vec<Vec<Vec<&mut [Complex64]>>> =
            (0..parts).map(|_| (0..n[0]).map(|_| Vec::with_capacity(blocks)).collect()).collect();
        for (b, block) in room.chunks_mut(size).enumerate() {
            let pieces = block.chunks_mut(h2 * BLOCK).zip(&mut slots[b % parts]);
            pieces.for_each(|(piece, slot)| slot.push(piece));
        }
        for (s, slots) in s.chunks(count).zip(slots) {
            self.planes(s, slots);
        }
        let found: Vec<Found> = room
            .par_chunks_mut(parts * size)
            .enumerate()
            .with_max_len(1)
            .map_init(
                || Lines::new(self),
                |lines, (b, block)| {
                    simd::run(Block { volume: self, kernels: k, walls, first: b * BLOCK, lines, block })
                },
            )
            .collect();
        for (p, out) in out.chunks_mut(count).enumerate() {
            self.planes_back(&room[p * size..], (size, parts), out);
        }
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
    fn planes_back(&self, room: &[Complex64], (size, parts): (usize, usize), out: &mut [f64]) {
        let ([_, n1, n2], [_, l1, l2], h2) = (self.grid.cells, self.grid.lengths(), self.grid.halves()[2]);
        let plan = &self.back[1];
        let work = || {
            let scratch = vec![ZERO; plan.get_inplace_scratch_len()];
            (vec![0.0; l2], vec![ZERO; h2], vec![ZERO; h2 * l1], self.unreal.make_scratch_vec(), scratch)
        };
        out.par_chunks_mut(n1 * n2).enumerate().with_max_len(1).for_each_init(
            work,
            |(line, spectrum, plane, scratch_z, scratch_y), (x, cells)| {
                for (b, block) in room.chunks(size).step_by(parts).enumerate() {
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
        let ([l0, l1, _], h2, parts) = (self.grid.lengths(), self.grid.halves()[2], self.variation.patch());
        let sizes = [l1 * h2, l0 * h2, l0 * l1];
        let mut sides =
            [0, 1, 2].map(|a| (!self.grid.periodic[a]).then(|| [0, 1].map(|_| vec![ZERO; parts * sizes[a]])));
        for (side, q) in [0, 1].into_iter().flat_map(|side| (0..parts).map(move |q| (side, q))) {
            if let Some(x) = &mut sides[0] {
                let x = &mut x[side][q * sizes[0]..(q + 1) * sizes[0]];
                for (b, f) in found.iter().enumerate() {
                    let f = &f.x[side][q * h2 * BLOCK..];
                    for f2 in 0..h2 {
                        let (from, to) = (b * BLOCK, ((b + 1) * BLOCK).min(l1));
                        let part = &f[f2 * BLOCK..f2 * BLOCK + to - from];
                        let w = self.weight(f2);
                        let line = &mut x[f2 * l1 + from..f2 * l1 + to];
                        line.iter_mut().zip(part).for_each(|(o, p)| *o = p * w);
                    }
                }
            }
            if let Some(y) = &mut sides[1] {
                let y = &mut y[side][q * sizes[1]..(q + 1) * sizes[1]];
                y.par_chunks_mut(l0).enumerate().for_each(|(f2, line)| {
                    for f in &found {
                        let part = &f.y[side][(q * h2 + f2) * l0..(q * h2 + f2 + 1) * l0];
                        line.iter_mut().zip(part).for_each(|(o, p)| *o += p);
                    }
                    let w = self.weight(f2);
                    line.iter_mut().for_each(|o| *o *= w);
                });
            }
            if let Some(z) = &mut sides[2] {
                let z = &mut z[side][q * sizes[2]..(q + 1) * sizes[2]];
                let part = |f: &Found| f.z[side].len() / parts;
                let all = found.iter().flat_map(|f| &f.z[side][q * part(f)..(q + 1) * part(f)]);
                z.iter_mut().zip(all).for_each(|(o, p)| *o = *p);
            }
        }
        sides
    }
}

/// Room for the lines of a block.
struct Lines {
    /// By component.
    lines: Vec<Vec<Complex64>>,
    scratch: Vec<Complex64>,
    /// What arrives at a line, by component.
    added: Vec<Vec<Complex64>>,
    /// A spectrum written out.
    full: Vec<f64>,
}

impl Lines {
    fn new(v: &Volume) -> Lines {
        let (l0, parts) = (v.grid.lengths()[0], v.variation.voxel());
        let scratch = v.forward[0].get_inplace_scratch_len().max(v.back[0].get_inplace_scratch_len());
        Lines {
            lines: vec![vec![ZERO; BLOCK * l0]; parts],
            scratch: vec![ZERO; scratch],
            added: vec![vec![ZERO; l0]; parts],
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
    /// By component.
    block: &'a mut [Complex64],
}

impl simd::Work for Block<'_> {
    type Output = Found;
    #[inline(always)]
    fn go(self) -> Found {
        let Block { volume: v, kernels, walls, first, lines, block } = self;
        let Lines { lines, scratch, added, full } = lines;
        let ([n0, _, _], [l0, l1, _], [h0, _, h2]) = (v.grid.cells, v.grid.lengths(), v.grid.halves());
        let (count, size, parts) = (BLOCK.min(l1 - first), n0 * h2 * BLOCK, v.variation.patch());
        let room = |a: usize, size: usize| {
            [0, 1].map(|_| vec![ZERO; if walls[a].is_some() { parts * size } else { 0 }])
        };
        let mut found = Found { x: room(0, h2 * BLOCK), y: room(1, h2 * l0), z: room(2, count * l0) };
        // Frequencies along y and z; those along z are never opposites of what is kept.
        let at = |f1: usize, f2: usize| f1.min(l1 - f1) * h2 + f2;
        let opposite = |f1: usize| 2 * f1 > l1;
        for f2 in 0..h2 {
            for (p, lines) in lines.iter_mut().enumerate() {
                let rows = block[p * size..(p + 1) * size].chunks(BLOCK).skip(f2).step_by(h2);
                for (x, row) in rows.enumerate() {
                    (0..count).for_each(|j| lines[j * l0 + x] = row[j]);
                }
                lines[..count * l0].chunks_mut(l0).for_each(|line| {
                    line[n0..].fill(ZERO);
                    if p > 1 {
                        turn(&mut line[..n0]);
                    }
                });
            }
            if walls[0].is_some() {
                let set = &kernels.walls[0];
                for (j, Term { p, q, array }) in
                    (0..count).flat_map(|j| set.terms.iter().map(move |t| (j, *t)))
                {
                    let (f1, array) = (first + j, &set.arrays[array]);
                    let from = at(f1, f2) * n0;
                    let sums = meet(&array.data[from..from + n0], &lines[p][j * l0..j * l0 + n0]);
                    // The slope across the wall is the other way round at the high end.
                    let sign = array.sign(1, opposite(f1));
                    let place = (q * h2 + f2) * BLOCK + j;
                    found.x[0][place] += sums[0] * sign;
                    found.x[1][place] += sums[1] * if p == 1 { -sign } else { sign };
                }
            }
            for (p, lines) in lines.iter_mut().enumerate() {
                v.forward[0].process_with_scratch(&mut lines[..count * l0], scratch);
                if p == 1 {
                    turn(&mut lines[..count * l0]);
                }
            }
            for j in 0..count {
                let f1 = first + j;
                let from = at(f1, f2) * h0;
                let line = j * l0..(j + 1) * l0;
                added.iter_mut().for_each(|a| a.fill(ZERO));
                let write = |full: &mut [f64], array: &Array| {
                    let sign = array.sign(1, opposite(f1));
                    unfold(full, &array.data[from..from + h0], sign, array.odd[0]);
                };
                for a in [1, 2] {
                    let Some(sent) = &walls[a] else { continue };
                    let (met, place, of) = match a {
                        1 => (&mut found.y, f2, h2),
                        _ => (&mut found.z, j, count),
                    };
                    let (phase, weight) = match a {
                        1 => (v.phase[0][f1], 1.0),
                        _ => (v.phase[1][f2], v.weight(f2)),
                    };
                    // What a wall sent has its frequencies along the axis that is not x.
                    let (g, others) = if a == 1 { (f2, h2) } else { (f1, l1) };
                    let set = &kernels.walls[a];
                    for (k, array) in set.arrays.iter().enumerate() {
                        write(full, array);
                        for &Term { p, q, .. } in set.terms.iter().filter(|t| t.array == k) {
                            let sent = sent.each_ref().map(|s| &s[(q * others + g) * l0..][..l0]);
                            let met = met.each_mut().map(|m| &mut m[(q * of + place) * l0..][..l0]);
                            let (line, added) = (&lines[p][line.clone()], &mut added[p][..]);
                            match p == a + 1 {
                                true => exchange::<true>(line, full, added, met, sent, (phase, weight)),
                                false => exchange::<false>(line, full, added, met, sent, (phase, weight)),
                            }
                        }
                    }
                }
                let set = &kernels.volume;
                for (k, array) in set.arrays.iter().enumerate() {
                    write(full, array);
                    for &Term { p, q, .. } in set.terms.iter().filter(|t| t.array == k) {
                        let all = added[p].iter_mut().zip(&lines[q][line.clone()]).zip(&*full);
                        all.for_each(|((o, x), k)| *o += x * k);
                    }
                }
                for (lines, added) in lines.iter_mut().zip(&*added) {
                    lines[line.clone()].copy_from_slice(added);
                }
            }
            for (p, lines) in lines.iter_mut().enumerate() {
                if p == 1 {
                    turn_back(&mut lines[..count * l0]);
                }
                v.back[0].process_with_scratch(&mut lines[..count * l0], scratch);
            }
            if let Some([low, high]) = &walls[0] {
                let set = &kernels.walls[0];
                for (j, Term { p, q, array }) in
                    (0..count).flat_map(|j| set.terms.iter().map(move |t| (j, *t)))
                {
                    let (f1, array) = (first + j, &set.arrays[array]);
                    let (from, place) = (at(f1, f2) * n0, (q * h2 + f2) * l1 + f1);
                    let sign = array.sign(1, opposite(f1));
                    let sent = [low[place] * sign, high[place] * if p == 1 { -sign } else { sign }];
                    send(&array.data[from..from + n0], &mut lines[p][j * l0..j * l0 + n0], sent);
                }
            }
            for (p, lines) in lines.iter_mut().enumerate() {
                if p > 1 {
                    lines[..count * l0].chunks_mut(l0).for_each(|line| turn_back(&mut line[..n0]));
                }
                let rows = block[p * size..(p + 1) * size].chunks_mut(BLOCK).skip(f2).step_by(h2);
                for (x, row) in rows.enumerate() {
                    (0..count).for_each(|j| row[j] = lines[j * l0 + x]);
                }
            }
        }
        found
    }
}

/// Times i.
#[inline(always)]
pub fn turn(line: &mut [Complex64]) {
    line.iter_mut().for_each(|z| *z = Complex64::new(-z.im, z.re));
}

/// Times −i.
#[inline(always)]
pub fn turn_back(line: &mut [Complex64]) {
    line.iter_mut().for_each(|z| *z = Complex64::new(z.im, -z.re));
}

/// A spectrum of which one half is given, even or odd, written out with a sign.
#[inline(always)]
fn unfold(full: &mut [f64], half: &[f64], sign: f64, odd: bool) {
    let n = full.len();
    let other = if odd { -sign } else { sign };
    full.iter_mut().zip(half).for_each(|(x, h)| *x = sign * h);
    let rest = full[half.len()..].iter_mut().zip(half[..=n - half.len()].iter().rev());
    rest.for_each(|(x, h)| *x = other * h);
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

/// Voxels and the walls across another axis, in frequencies; the phase takes the low wall to the high one. `ACROSS`: the slope of the voxels across
/// these walls, which is kept times i but meets them as it is, and the high one the other way round.
#[inline(always)]
fn exchange<const ACROSS: bool>(
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
        let mut u = line[i] * (kernel[i] * weight);
        if ACROSS {
            u = Complex64::new(u.im, -u.re);
            low[i] += u;
            high[i] -= u * phase.conj();
            let more = (from_low[i] - from_high[i] * phase) * kernel[i];
            added[i] += Complex64::new(-more.im, more.re);
        } else {
            low[i] += u;
            high[i] += u * phase.conj();
            added[i] += (from_low[i] + from_high[i] * phase) * kernel[i];
        }
    }
}
