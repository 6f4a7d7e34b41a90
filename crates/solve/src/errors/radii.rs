//! Error radii of all pairs of zones, one byte each, and their propagation to incident powers.
//!
//! The errors of the factors are independent of one another, so for strengths s the error of the power incident on zone i is
//!
//! ```text
//! e_i = √( Σ_j (r_ij s_j)² )
//! ```
//!
//! which is small if the pairs that carry the light are accurate, however large the errors of the others are. A radius r is stored as a code k
//! with r = 2^((k − 193)/2), k from 1 to 255, and 0 for none: at most 19 % off, which is acceptable for an estimate.

use crate::dense::row_blocks::{RowBlocks, packed_length};
use crate::distribution::Communicator;
use rayon::prelude::*;
use zonal_scene::Bands;

/// The code of the radius 1.
const CODE_OF_ONE: f64 = 193.0;

/// The radii of the lower triangle by rows, or those of the rows that a process has.
#[derive(Clone, Debug)]
pub(crate) struct PairRadii {
    blocks: RowBlocks,
    codes: Vec<u8>,
}

/// The code of a radius; the largest one for a radius that is not a number.
pub(crate) fn radius_code(radius: f64) -> u8 {
    match radius {
        r if r > 0.0 => (2.0 * r.log2() + CODE_OF_ONE).round().clamp(1.0, 255.0) as u8,
        r if r.is_nan() => 255,
        _ => 0,
    }
}

impl PairRadii {
    /// Radii of the rows of some blocks: the codes of their pairs (i, j ≤ i), row by row.
    pub(crate) fn new(blocks: RowBlocks, codes: Vec<u8>) -> PairRadii {
        assert_eq!(codes.len(), blocks.entries(blocks.own_rows()));
        PairRadii { blocks, codes }
    }

    /// e of every zone for strengths `s`, in the unit of the incident power.
    pub(crate) fn propagate(&self, s: &[Bands], communicator: &dyn Communicator) -> Vec<Bands> {
        let squares: Vec<f64> =
            (0..256).map(|k| if k == 0 { 0.0 } else { 2.0f64.powf(k as f64 - CODE_OF_ONE) }).collect();
        let own: Vec<Bands> = s.iter().map(|s| s * s).collect();
        let before = packed_length(self.blocks.own_rows().start);
        let block = |b: usize| {
            let rows = self.blocks.rows_of(b);
            let mut sum = vec![Bands::ZERO; rows.end];
            for i in rows {
                let start = packed_length(i) - before;
                let row = &self.codes[start..start + i];
                let mut here = Bands::ZERO;
                for (j, r) in row.iter().enumerate().filter(|(_, r)| **r > 0) {
                    let r2 = squares[*r as usize];
                    here += r2 * own[j];
                    sum[j] += r2 * own[i];
                }
                let r2 = squares[self.codes[start + i] as usize];
                sum[i] = sum[i] + here + r2 * own[i];
            }
            sum
        };
        let parts: Vec<Vec<Bands>> = self.blocks.own().into_par_iter().map(block).collect();
        let total = self.blocks.sum(parts, communicator, Bands::ZERO, |a, b| a + b);
        total.into_iter().map(Bands::sqrt).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::SingleProcess;
    use zonal_scene::Band;

    #[test]
    fn errors_follow_the_pairs_that_carry_the_light() {
        let r = [[0.0, 1e-3, 0.02], [1e-3, 0.5, 0.0], [0.02, 0.0, 1e-20]];
        let codes = (0..3).flat_map(|i| (0..=i).map(move |j| radius_code(r[i][j]))).collect();
        let s = [[1.0, 0.0, 5.0], [10.0, 1.0, 0.0], [0.1, 3.0, 1.0]].map(Bands::from_rgb);
        let e = PairRadii::new(RowBlocks::all(3), codes).propagate(&s, &SingleProcess);
        for i in 0..3 {
            for b in Band::all() {
                let exact = (0..3).map(|j| (r[i][j] * s[j][b]).powi(2)).sum::<f64>().sqrt();
                assert!((e[i][b] - exact).abs() <= 0.2 * exact, "{i} {b:?}: {} {exact}", e[i][b]);
            }
        }
    }
}
