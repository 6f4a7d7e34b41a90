//! Discrete cosine and sine transforms: spectra of real sequences that are even or odd. They are real (times −i) and even or odd, so that half of
//! each is stored.
//!
//! A kernel k(d), d = 0 … m − 1, stands for the circular sequence of length N with x(d) = x(N − d) = k(d) and zeros between. Its spectrum
//!
//! ```text
//!     X(f) = Σ_d x(d) cos(2π d f/N),      f = 0 … N/2,      X(N − f) = X(f).
//! ```
//!
//! If x(N − d) = −k(d), X(f) = −i S(f) with S(f) = Σ_d x(d) sin(2π d f/N), and S is stored.

use crate::device::grid::half_length;
use rayon::prelude::*;
use std::sync::Arc;
use zonal_fourier::Complex64;
use zonal_fourier::{Planner, RealToComplex};
use zonal_math::parallel;

/// Operations of the transform of a number.
const OPERATIONS_PER_NUMBER: usize = 20;

/// Symmetry of a sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parity {
    Even,
    Odd,
}

/// The transform of one length.
pub(crate) struct RealSymmetricFft {
    length: usize,
    plan: Arc<dyn RealToComplex<f64>>,
}

impl RealSymmetricFft {
    /// The transform of a length.
    pub(crate) fn new(length: usize) -> RealSymmetricFft {
        RealSymmetricFft { length, plan: Planner::default().real_forward(length) }
    }

    /// Transforms every line of `m` numbers in `data`, extended as an even or odd sequence, to [`half_length`] numbers each, times `scale`, written
    /// to `out`.
    pub(super) fn lines(&self, data: &[f64], m: usize, parity: Parity, scale: f64, out: &mut Vec<f64>) {
        let (n, h) = (self.length, half_length(self.length));
        let odd = parity == Parity::Odd;
        let other = if odd { -1.0 } else { 1.0 };
        assert!(m <= n && data.len().is_multiple_of(m), "lines of {m} for a length of {n}");
        parallel::set_length(out, data.len() / m * h);
        let work = || (vec![0.0; n], vec![Complex64::default(); h], self.plan.make_scratch_vec());
        let least = parallel::least_items(OPERATIONS_PER_NUMBER * n);
        out.par_chunks_mut(h).zip(data.par_chunks(m)).with_min_len(least).for_each_init(
            work,
            |(line, spectrum, scratch), (out, k)| {
                line.fill(0.0);
                // If 2m > N + 1 the two halves overlap and agree; odd ones are zero there.
                for (d, &x) in k.iter().enumerate().take(h) {
                    line[d] = x;
                    line[(n - d) % n] = other * x;
                    if odd && 2 * d % n == 0 {
                        line[d] = 0.0;
                    }
                }
                let done = self.plan.process_with_scratch(line, spectrum, scratch);
                assert!(done.is_ok(), "buffers of the plan's lengths");
                let kept = |s: &Complex64| if odd { -s.im } else { s.re };
                out.iter_mut().zip(&*spectrum).for_each(|(o, s)| *o = kept(s) * scale);
            },
        );
    }
}

/// Permutes the axes of an array of shape `dims` so that `order[k]` is its k-th axis; the result is written to `out`.
pub(crate) fn permute_axes(data: &[f64], dims: [usize; 3], order: [usize; 3], out: &mut Vec<f64>) {
    let stride = [dims[1] * dims[2], dims[2], 1];
    let [p, q, r] = order.map(|k| (dims[k], stride[k]));
    parallel::set_length(out, data.len());
    // A rank of many may have no rows.
    let plane = (q.0 * r.0).max(1);
    let planes = parallel::least_items(plane);
    parallel::chunks(out, planes * plane, |c, chunk| {
        // Square tiles, so that reads and writes stay in the cache.
        const TILE: usize = 16;
        for (i, plane) in (c * planes..).zip(chunk.chunks_mut(plane)) {
            for j0 in (0..q.0).step_by(TILE) {
                for k0 in (0..r.0).step_by(TILE) {
                    for j in j0..(j0 + TILE).min(q.0) {
                        for k in k0..(k0 + TILE).min(r.0) {
                            plane[j * r.0 + k] = data[i * p.1 + j * q.1 + k * r.1];
                        }
                    }
                }
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transformed_line_is_its_cosine_or_sine_sum() {
        let k = [3.0, -1.0, 0.5, 0.25];
        let transform = |n: usize, parity: Parity, scale: f64| {
            let mut got = Vec::new();
            RealSymmetricFft::new(n).lines(&k, 4, parity, scale, &mut got);
            got
        };
        for n in [7, 8, 12] {
            let got = transform(n, Parity::Even, 2.0);
            for (f, g) in got.iter().enumerate() {
                let term = |d: usize| (std::f64::consts::TAU * (d * f) as f64 / n as f64).cos() * k[d];
                let want = 2.0 * (k[0] + 2.0 * (1..4).map(term).sum::<f64>());
                assert!((g - want).abs() < 1e-14, "{n} {f}: {g} {want}");
            }
        }
        // A period of six: the distance 3 is its own opposite.
        let got = transform(6, Parity::Even, 1.0);
        assert!((got[0] - (3.0 - 2.0 + 1.0 + 0.25)).abs() < 1e-14);
        for n in [8, 12] {
            let got = transform(n, Parity::Odd, 2.0);
            for (f, g) in got.iter().enumerate() {
                let term = |d: usize| (std::f64::consts::TAU * (d * f) as f64 / n as f64).sin() * k[d];
                let want = 4.0 * (1..4).map(term).sum::<f64>();
                assert!((g - want).abs() < 1e-14, "{n} {f}: {g} {want}");
            }
        }
    }

    #[test]
    fn arrays_are_permute_axes() {
        let dims = [2, 3, 4];
        let data: Vec<f64> = (0..24).map(f64::from).collect();
        let mut t = Vec::new();
        permute_axes(&data, dims, [2, 0, 1], &mut t);
        assert_eq!(t[(3 * 2 + 1) * 3 + 2], data[(3 + 2) * 4 + 3]);
    }
}
