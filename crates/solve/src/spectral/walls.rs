//! Exchange of walls with walls, and the transforms along walls.
//!
//! Opposite walls: a two-dimensional convolution. Adjacent walls across axes a and b, with an edge along c: transforms along c, and for each
//! frequency a matrix Q(i_a, i_b) between the patches of the second wall at i_a cells from the first wall and those of the first wall at i_b cells from
//! the second. High walls follow by reversal R of an index, with the four columns (low, high, R low, R high) on the right of Q and of its transpose.
//! Slopes of the radiosity along the reversed index change their sign.
//!
//! ```text
//!     low_a  += Qᵀ low_b   + R Qᵀ high_b        high_a += Qᵀ R low_b + R Qᵀ R high_b        and the same with Q for b from a.
//! ```

use super::axes::OTHER_AXES;
use super::basis::{BasisOrder, SpectrumHalf, patch_axis};
use super::grid::BoxGrid;
use super::kernels::GridKernels;
use super::line_exchange::{times_i, times_minus_i};
use super::volume::WallSpectra;
use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;
use zonal_math::simd::{self, LANES};

const ZERO: Complex64 = Complex64 { re: 0.0, im: 0.0 };

/// Values on the patches of the six walls, low and high across each axis, by `[component][i_b][i_c]`; empty across periodic axes.
pub(crate) type WallValues = [[Vec<f64>; 2]; 3];

/// Plans of the transforms along walls.
pub(crate) struct WallConvolution {
    grid: BoxGrid,
    order: BasisOrder,
    forward: [Arc<dyn Fft<f64>>; 3],
    back: [Arc<dyn Fft<f64>>; 3],
    real: [Arc<dyn RealToComplex<f64>>; 3],
    unreal: [Arc<dyn ComplexToReal<f64>>; 3],
}

/// A component of the walls across axis `a`, transformed along the edge axis `c`.
#[derive(Clone, Copy)]
struct EdgeComponent {
    a: usize,
    c: usize,
    /// Number of the component.
    q: usize,
}

impl EdgeComponent {
    /// True for a slope along the edge, whose spectrum is multiplied by i.
    fn is_slope_along_edge(self) -> bool {
        patch_axis(self.a, self.q) == Some(self.c)
    }
}

/// Real columns that one product of a matrix of adjacent walls serves: four complex ones.
type ReversedColumns = [f64; LANES];

impl WallConvolution {
    /// Plans for a grid.
    pub(crate) fn new(grid: BoxGrid, order: BasisOrder) -> WallConvolution {
        let n = grid.lengths();
        let (mut complex, mut real) = (FftPlanner::new(), RealFftPlanner::new());
        WallConvolution {
            forward: n.map(|n| complex.plan_fft_forward(n)),
            back: n.map(|n| complex.plan_fft_inverse(n)),
            real: n.map(|n| real.plan_fft_forward(n)),
            unreal: n.map(|n| real.plan_fft_inverse(n)),
            grid,
            order,
        }
    }

    /// Zero values on all walls.
    pub(crate) fn zeros(&self) -> WallValues {
        [0, 1, 2].map(|a| {
            let size =
                if self.grid.periodic[a] { 0 } else { self.order.patch_components() * self.grid.patches(a) };
            [vec![0.0; size], vec![0.0; size]]
        })
    }

    /// Number of stored frequencies along the second direction of a wall: half of them along z.
    fn stored_frequencies(&self, a: usize) -> usize {
        if a == 2 { self.grid.lengths()[1] } else { self.grid.halves()[2] }
    }

    /// The spectra of both walls across each axis.
    pub(crate) fn spectra(&self, faces: &WallValues) -> [Option<WallSpectra>; 3] {
        let one = |(a, side): (usize, usize)| {
            let mut out = Vec::new();
            for (q, face) in faces[a][side].chunks(self.grid.patches(a)).enumerate() {
                let mut spectrum = self.spectrum(a, face);
                if q > 0 {
                    times_i(&mut spectrum);
                }
                if q == 0 { out = spectrum } else { out.append(&mut spectrum) }
            }
            out
        };
        let list: Vec<(usize, usize)> = self.grid.walled().flat_map(|a| [(a, 0), (a, 1)]).collect();
        let mut made = list.par_iter().map(|&x| one(x)).collect::<Vec<_>>().into_iter();
        let mut out = [const { None }; 3];
        for a in self.grid.walled() {
            out[a] = made.next().zip(made.next()).map(|(low, high)| [low, high]);
        }
        out
    }

    /// The spectrum of one wall by `[f_c][f_b]`.
    fn spectrum(&self, a: usize, face: &[f64]) -> Vec<Complex64> {
        let ([b, c], n, l) = (OTHER_AXES[a], self.grid.cells, self.grid.lengths());
        let kept = self.stored_frequencies(a);
        let mut rows = vec![ZERO; n[b] * l[c]];
        for (row, cells) in rows.chunks_mut(l[c]).zip(face.chunks(n[c])) {
            row.iter_mut().zip(cells).for_each(|(r, x)| r.re = *x);
        }
        self.forward[c].process(&mut rows);
        let mut out = vec![ZERO; kept * l[b]];
        for (f, line) in out.chunks_mut(l[b]).enumerate() {
            (0..n[b]).for_each(|i| line[i] = rows[i * l[c] + f]);
        }
        self.forward[b].process(&mut out);
        out
    }

    /// Adds the incident power of the walls: twice the real part of the half sums `spectra`.
    pub(crate) fn add_spectra(&self, spectra: [Option<WallSpectra>; 3], faces: &mut WallValues) {
        let list = spectra.into_iter().zip(faces).enumerate();
        let list: Vec<_> = list.filter_map(|(a, (s, f))| s.map(|s| (a, s, f))).collect();
        list.into_par_iter().for_each(|(a, spectra, faces)| {
            spectra.into_par_iter().zip(faces.par_iter_mut()).for_each(|(mut s, face)| {
                let size = s.len() / self.order.patch_components();
                let parts = s.chunks_mut(size).zip(face.chunks_mut(self.grid.patches(a)));
                for (q, (spectrum, face)) in parts.enumerate() {
                    if q > 0 {
                        times_minus_i(spectrum);
                    }
                    self.inverse_spectrum(a, spectrum, face);
                }
            });
        });
    }

    /// Transforms the spectrum of one wall back and adds it to its values.
    fn inverse_spectrum(&self, a: usize, spectrum: &mut [Complex64], face: &mut [f64]) {
        let ([b, c], n, l) = (OTHER_AXES[a], self.grid.cells, self.grid.lengths());
        self.back[b].process(spectrum);
        let mut rows = vec![ZERO; n[b] * l[c]];
        for (f, line) in spectrum.chunks(l[b]).enumerate() {
            (0..n[b]).for_each(|i| rows[i * l[c] + f] = line[i]);
        }
        self.back[c].process(&mut rows);
        for (row, cells) in rows.chunks(l[c]).zip(face.chunks_mut(n[c])) {
            cells.iter_mut().zip(row).for_each(|(x, r)| *x += 2.0 * r.re);
        }
    }

    /// Adds the exchange of opposite walls in frequency space.
    pub(crate) fn opposite(
        &self,
        k: &GridKernels,
        sent: &[Option<WallSpectra>; 3],
        met: &mut [Option<WallSpectra>; 3],
    ) {
        for a in self.grid.walled() {
            let (Some(sent), Some(met)) = (&sent[a], &mut met[a]) else { continue };
            let [b, c] = OTHER_AXES[a];
            let (lb, hb, lc) = (self.grid.lengths()[b], self.grid.halves()[b], self.grid.lengths()[c]);
            let size = sent[0].len() / self.order.patch_components();
            for (side, term) in
                [0, 1].into_iter().flat_map(|s| k.opposite[a].terms.iter().map(move |t| (s, t)))
            {
                let array = &k.opposite[a].arrays[term.array];
                let from = sent[1 - side][term.q * size..(term.q + 1) * size].par_chunks(lb);
                let to = met[side][term.p * size..(term.p + 1) * size].par_chunks_mut(lb);
                to.zip(from).enumerate().for_each(|(f, (met, sent))| {
                    // Across z all frequencies are stored, with half of their weight; else half of them.
                    let weight = if a == 2 || f == 0 || 2 * f == lc { 0.5 } else { 1.0 };
                    let weight = weight * array.sign(c, SpectrumHalf::of(f, lc));
                    let kernel = &array.data[f.min(lc - f) * hb..(f.min(lc - f) + 1) * hb];
                    for (i, (m, s)) in met.iter_mut().zip(sent).enumerate() {
                        let sign = array.sign(b, SpectrumHalf::of(i, lb));
                        *m += s * (weight * sign * kernel[i.min(lb - i)]);
                    }
                });
            }
        }
    }

    /// Adds the exchange of adjacent walls.
    pub(crate) fn adjacent(&self, k: &GridKernels, sent: &WallValues, met: &mut WallValues) {
        for pair in self.grid.corners() {
            let [a, b] = pair;
            let (c, h) = (3 - a - b, self.grid.halves()[3 - a - b]);
            let [na, nb] = [self.grid.cells[a], self.grid.cells[b]];
            let (parts, set) = (self.order.patch_components(), &k.adjacent[a + b - 1]);
            let components = |a: usize| (0..parts).map(move |q| EdgeComponent { a, c, q });
            // Patches of the wall across a by their cells along b, and vice versa; slopes along c times i.
            let from = [(a, &sent[a]), (b, &sent[b])]
                .map(|(a, faces)| components(a).map(|part| self.along(part, faces)).collect::<Vec<_>>());
            let empty = |n: usize| vec![vec![ZERO; 2 * n * h]; parts];
            let mut to = [empty(nb), empty(na)];
            for term in &set.terms {
                let q = &set.arrays[term.array].data;
                let [to_a, to_b] = &mut to;
                let (to_a, to_b) = (&mut to_a[term.p], &mut to_b[term.q]);
                let (from_a, from_b) = (&from[0][term.p], &from[1][term.q]);
                let sign = |turned: bool| if turned { -1.0 } else { 1.0 };
                let signs = [patch_axis(a, term.p) == Some(b), patch_axis(b, term.q) == Some(a)].map(sign);
                to_a.par_chunks_mut(2 * nb).zip(to_b.par_chunks_mut(2 * na)).enumerate().for_each(
                    |(f, to)| {
                        let from =
                            [&from_a[f * 2 * nb..(f + 1) * 2 * nb], &from_b[f * 2 * na..(f + 1) * 2 * na]];
                        let q = &q[f * na * nb..(f + 1) * na * nb];
                        simd::run(AdjacentWallProduct { q, from, to: [to.0, to.1], signs });
                    },
                );
            }
            for (a, to) in [a, b].into_iter().zip(&to) {
                for (part, to) in components(a).zip(to) {
                    self.inverse_along(part, to, &mut met[a]);
                }
            }
        }
    }

    /// A component of the walls transformed along the edge, by `[f][side][i]`, times i where it is a slope along the edge.
    fn along(&self, part: EdgeComponent, faces: &[Vec<f64>; 2]) -> Vec<Complex64> {
        let EdgeComponent { a, c, q } = part;
        let first = q * self.grid.patches(a);
        let (n, l, h) = (self.grid.cells, self.grid.lengths()[c], self.grid.halves()[c]);
        let i = 3 - a - c;
        let [step_i, step_c] = if i < c { [n[c], 1] } else { [1, n[i]] };
        let mut out = vec![ZERO; 2 * n[i] * h];
        let (mut line, mut spectrum) = (vec![0.0; l], vec![ZERO; h]);
        let mut scratch = self.real[c].make_scratch_vec();
        for (side, face) in faces.iter().enumerate() {
            for k in 0..n[i] {
                line.fill(0.0);
                (0..n[c]).for_each(|j| line[j] = face[first + k * step_i + j * step_c]);
                let done = self.real[c].process_with_scratch(&mut line, &mut spectrum, &mut scratch);
                assert!(done.is_ok(), "buffers of the plan's lengths");
                (0..h).for_each(|f| out[(f * 2 + side) * n[i] + k] = spectrum[f]);
            }
        }
        if part.is_slope_along_edge() {
            times_i(&mut out);
        }
        out
    }

    /// Transforms `spectra` of [`WallConvolution::along`] back and adds them to the walls.
    fn inverse_along(&self, part: EdgeComponent, spectra: &[Complex64], faces: &mut [Vec<f64>; 2]) {
        let EdgeComponent { a, c, q } = part;
        let slope = part.is_slope_along_edge();
        let first = q * self.grid.patches(a);
        let (n, l, h) = (self.grid.cells, self.grid.lengths()[c], self.grid.halves()[c]);
        let i = 3 - a - c;
        let [step_i, step_c] = if i < c { [n[c], 1] } else { [1, n[i]] };
        let (mut line, mut spectrum) = (vec![0.0; l], vec![ZERO; h]);
        let mut scratch = self.unreal[c].make_scratch_vec();
        for (side, face) in faces.iter_mut().enumerate() {
            for k in 0..n[i] {
                (0..h).for_each(|f| spectrum[f] = spectra[(f * 2 + side) * n[i] + k]);
                if slope {
                    times_minus_i(&mut spectrum);
                }
                spectrum[0].im = 0.0;
                if l.is_multiple_of(2) {
                    spectrum[h - 1].im = 0.0;
                }
                let done = self.unreal[c].process_with_scratch(&mut spectrum, &mut line, &mut scratch);
                assert!(done.is_ok(), "buffers of the plan's lengths");
                (0..n[c]).for_each(|j| face[first + k * step_i + j * step_c] += line[j]);
            }
        }
    }
}

/// One frequency of two pairs of adjacent walls: q by `[i_a][i_b]`, walls by `[side][i]`, and the signs of the components under reversal.
struct AdjacentWallProduct<'a> {
    q: &'a [f64],
    from: [&'a [Complex64]; 2],
    to: [&'a mut [Complex64]; 2],
    signs: [f64; 2],
}

impl simd::SimdKernel for AdjacentWallProduct<'_> {
    type Output = ();
    #[inline(always)]
    fn evaluate(self) {
        let AdjacentWallProduct { q, from: [from_a, from_b], to: [to_a, to_b], signs: [sign_a, sign_b] } =
            self;
        let (nb, na) = (from_a.len() / 2, from_b.len() / 2);
        let (of_a, of_b) = (reversed_columns(from_a), reversed_columns(from_b));
        let (mut sum_a, mut sum_b) = (vec![[0.0; LANES]; nb], vec![[0.0; LANES]; na]);
        for i in 0..na {
            let row = &q[i * nb..(i + 1) * nb];
            let x = of_b[i];
            let mut own = [0.0; LANES];
            for j in 0..nb {
                for l in 0..LANES {
                    sum_a[j][l] += row[j] * x[l];
                    own[l] += row[j] * of_a[j][l];
                }
            }
            sum_b[i] = own;
        }
        add_products(&sum_a, to_a, [sign_a, sign_b]);
        add_products(&sum_b, to_b, [sign_b, sign_a]);
    }
}

/// (low, high, R low, R high) of two walls by `[side][i]`.
#[inline(always)]
fn reversed_columns(walls: &[Complex64]) -> Vec<ReversedColumns> {
    let n = walls.len() / 2;
    let at = |i: usize| {
        let z = [walls[i], walls[n + i], walls[n - 1 - i], walls[2 * n - 1 - i]];
        std::array::from_fn(|l| if l % 2 == 0 { z[l / 2].re } else { z[l / 2].im })
    };
    (0..n).map(at).collect()
}

/// Adds the four products to two walls; the signs are those of reversal of their own index and of the index of the other walls.
#[inline(always)]
fn add_products(sums: &[ReversedColumns], to: &mut [Complex64], [own_sign, other_sign]: [f64; 2]) {
    let n = sums.len();
    for i in 0..n {
        let (own, turned) = (sums[i], sums[n - 1 - i].map(|x| own_sign * x));
        to[i] += Complex64::new(own[0] + turned[2], own[1] + turned[3]);
        to[n + i] += Complex64::new(own[4] + turned[6], own[5] + turned[7]) * other_sign;
    }
}
