//! Error radii of all pairs of zones, a byte each, and what they make of a solution.
//!
//! The errors of single factors are independent of one another, so with strengths s the power that arrives at zone i is off by
//!
//! ```text
//! e_i = √( Σ_j (r_ij s_j)² )
//! ```
//!
//! which is small where the pairs that bring the light are known well, however badly the others are. A radius r is kept as the number k
//! of the step of a ladder, r = 2^((k − 193)/2), k from 1 to 255, 0 for none: 19 % off at most, which an estimate may be.

use crate::engine::Built;
use crate::packed::stored;
use crate::surroundings::Escape;
use rayon::prelude::*;
use zonal_exchange::pair::target;
use zonal_scene::{Bands, Zones, bands};

/// Blocks of rows; fixed, so that sums are the same for any number of threads.
const BLOCKS: usize = 32;
/// The step that stands for the radius 1.
const ONE: f64 = 193.0;

/// The radii of the lower triangle by rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Radii {
    n: usize,
    steps: Vec<u8>,
}

/// The step of a radius; the last where it is not known.
pub(crate) fn step(radius: f64) -> u8 {
    match radius {
        r if r > 0.0 => (2.0 * r.log2() + ONE).round().clamp(1.0, 255.0) as u8,
        r if r.is_nan() => 255,
        _ => 0,
    }
}

impl Radii {
    /// Of `n` zones: the steps of all pairs (i, j ≤ i), row by row.
    pub(crate) fn new(n: usize, steps: Vec<u8>) -> Radii {
        assert_eq!(steps.len(), stored(n));
        Radii { n, steps }
    }

    /// e of every zone, in the unit of the power that arrives, for strengths `s`.
    pub(crate) fn spread(&self, s: &[Bands]) -> Vec<Bands> {
        let squares: Vec<f64> =
            (0..256).map(|k| if k == 0 { 0.0 } else { 2.0f64.powf(k as f64 - ONE) }).collect();
        let own: Vec<Bands> = s.iter().map(|s| s.map(|x| x * x)).collect();
        // Blocks of about equal numbers of pairs.
        let border = |k: usize| (self.n as f64 * (k as f64 / BLOCKS as f64).sqrt()) as usize;
        let block = |k: usize| {
            let mut sum = vec![[0.0; 3]; self.n];
            let end = if k + 1 == BLOCKS { self.n } else { border(k + 1) };
            for i in border(k)..end {
                let row = &self.steps[stored(i)..stored(i) + i];
                let mut here = [0.0; 3];
                for (j, r) in row.iter().enumerate().filter(|(_, r)| **r > 0) {
                    let r2 = squares[*r as usize];
                    here = bands(|b| here[b] + r2 * own[j][b]);
                    sum[j] = bands(|b| sum[j][b] + r2 * own[i][b]);
                }
                let r2 = squares[self.steps[stored(i) + i] as usize];
                sum[i] = bands(|b| sum[i][b] + here[b] + r2 * own[i][b]);
            }
            sum
        };
        let parts: Vec<Vec<Bands>> = (0..BLOCKS).into_par_iter().map(block).collect();
        let total = |i: usize| parts.iter().fold([0.0; 3], |t, p| bands(|b| t[b] + p[i][b])).map(f64::sqrt);
        (0..self.n).map(total).collect()
    }
}

/// What a row misses of closure beyond the errors of its factors, as a share of all that arrives. A row misses closure by the error of what escapes and by
/// what the factors have in common, which no sum of squares tells: what it misses beyond twice the former counts. Where closure was restored, the
/// whole change of the row does, and all that it still misses. A row that sums to 1 − d holds 1 − d of what arrives: what it misses, if that is
/// like the rest, is d/(1 − d) of what it holds, and unknown (infinite) where it holds nothing.
pub(crate) fn untold(zones: &Zones, built: &Built, escape: &Escape) -> Vec<Bands> {
    const TWICE: f64 = 2.0;
    let (closure, defects) = &built.closure;
    let one = |i: usize| {
        if closure.restored {
            return defects[i].map(share_missed);
        }
        let lost = escape.spread(i, target(zones, i));
        bands(|b| share_missed((defects[i][b].abs() - TWICE * lost[b]).max(0.0).copysign(defects[i][b])))
    };
    (0..zones.len()).into_par_iter().map(one).collect()
}

/// The error of what arrives, `h`, that `share` of it makes; unknown where the share is, also of nothing.
pub(crate) fn of_share(share: f64, h: f64) -> f64 {
    if share.is_infinite() { f64::INFINITY } else { share * h.abs() }
}

/// The share of what a row holds by which it is off, for its relative defect: negative where it misses something.
pub(crate) fn share_missed(defect: f64) -> f64 {
    const NOTHING: f64 = 1e-9;
    match defect < 0.0 {
        true if defect <= -1.0 + NOTHING => f64::INFINITY,
        true => -defect / (1.0 + defect),
        false => defect,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_those_of_the_pairs_that_bring_the_light() {
        let r = [[0.0, 1e-3, 0.02], [1e-3, 0.5, 0.0], [0.02, 0.0, 1e-20]];
        let steps = (0..3).flat_map(|i| (0..=i).map(move |j| step(r[i][j]))).collect();
        let s = [[1.0, 0.0, 5.0], [10.0, 1.0, 0.0], [0.1, 3.0, 1.0]];
        let e = Radii::new(3, steps).spread(&s);
        for i in 0..3 {
            for b in 0..3 {
                let exact = (0..3).map(|j| (r[i][j] * s[j][b]).powi(2)).sum::<f64>().sqrt();
                assert!((e[i][b] - exact).abs() <= 0.2 * exact, "{i} {b}: {} {exact}", e[i][b]);
            }
        }
    }

    #[test]
    fn a_row_that_misses_something_is_off_by_what_it_misses_over_what_it_holds() {
        assert_eq!(share_missed(0.25), 0.25);
        assert!((share_missed(-0.2) - 0.25).abs() < 1e-15, "a fifth of all is a quarter of the rest");
        assert_eq!(share_missed(-1.0), f64::INFINITY);
        assert_eq!(of_share(share_missed(-1.0), 0.0), f64::INFINITY, "nothing seen of what there is");
        assert_eq!(of_share(0.25, -2.0), 0.5);
    }
}
