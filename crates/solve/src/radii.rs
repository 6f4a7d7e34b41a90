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
pub struct Radii {
    n: usize,
    steps: Vec<u8>,
}

/// The step of a radius; the last where it is not known.
pub fn step(radius: f64) -> u8 {
    match radius {
        r if r > 0.0 => (2.0 * r.log2() + ONE).round().clamp(1.0, 255.0) as u8,
        r if r.is_nan() => 255,
        _ => 0,
    }
}

impl Radii {
    /// Of `n` zones: the steps of all pairs (i, j ≤ i), row by row.
    pub fn new(n: usize, steps: Vec<u8>) -> Radii {
        assert_eq!(steps.len(), stored(n));
        Radii { n, steps }
    }

    /// e of every zone, in the unit of the power that arrives, for strengths `s`.
    pub fn spread(&self, s: &[Bands]) -> Vec<Bands> {
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
/// whole change of the row does.
pub(crate) fn untold(zones: &Zones, built: &Built, escape: &Escape) -> Vec<Bands> {
    const TWICE: f64 = 2.0;
    let (defects, restored) = (&built.closure.1, built.closure.0.restored);
    let one = |i: usize| {
        if restored {
            return defects[i].map(f64::abs);
        }
        let lost = escape.spread(i, target(zones, i));
        bands(|b| (defects[i][b].abs() - TWICE * lost[b]).max(0.0))
    };
    (0..zones.len()).into_par_iter().map(one).collect()
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
}
