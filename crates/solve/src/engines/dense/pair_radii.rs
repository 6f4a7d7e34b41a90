//! Error radii of all pairs of zones, one byte each, and their propagation to incident powers.
//!
//! The errors of the factors are independent of one another, so for strengths s the error of the power incident on zone i is
//!
//! ```text
//! e_i = √( Σ_j (r_ij s_j)² )
//! ```
//!
//! which is small if the pairs that carry the light are accurate, however large the errors of the others are. A radius r is stored as a code k
//! with r = 2^((k − 193)/2), k from 1 to 255, and 0 for none: at most 19 % off, which is acceptable for an estimate. Rows of panes come last, and every
//! process has all of them, as it has their factors.

use crate::distribution::Communicator;
use crate::engines::dense::row_blocks::{RowBlocks, packed_length};
use rayon::prelude::*;
use zonal_math::parallel;
use zonal_scene::Bands;

/// The code of the radius 1.
const CODE_OF_ONE: i32 = 193;
/// 2^(1/4) and 2^(3/4): the limits between the codes of one power of two.
const CODE_STEPS: [f64; 2] = [1.189_207_115_002_721, 1.681_792_830_507_429];

/// The radii of the lower triangle by rows, or those of the rows that a process has.
#[derive(Clone, Debug)]
pub(crate) struct PairRadii {
    /// Blocks of the rows before the panes.
    blocks: RowBlocks,
    codes: Vec<u8>,
    /// Codes of the rows of the panes.
    panes: Vec<Vec<u8>>,
}

/// The code of a radius; the largest one for a radius that is not a number. By the exponent and two thresholds of the fraction, without a logarithm: each
/// pair of zones has one.
pub(crate) fn radius_code(radius: f64) -> u8 {
    match radius {
        r if r > 0.0 => {
            let (exponent, fraction) = ((r.to_bits() >> 52) as i32 - 1023, r.to_bits() & ((1 << 52) - 1));
            let half_steps =
                CODE_STEPS.iter().filter(|step| fraction >= (step.to_bits() & ((1 << 52) - 1))).count();
            (2 * exponent + half_steps as i32 + CODE_OF_ONE).clamp(1, 255) as u8
        }
        r if r.is_nan() => 255,
        _ => 0,
    }
}

/// r² of each code.
pub(crate) fn squared_radii() -> Vec<f64> {
    (0..256).map(|k| if k == 0 { 0.0 } else { 2.0f64.powi(k - CODE_OF_ONE) }).collect()
}

impl PairRadii {
    /// Radii of the rows of some blocks, the codes of their pairs (i, j ≤ i) row by row, and those of the rows of all panes.
    pub(crate) fn new(blocks: RowBlocks, codes: Vec<u8>, panes: Vec<Vec<u8>>) -> PairRadii {
        assert_eq!(codes.len(), blocks.entries(blocks.own_rows()));
        PairRadii { blocks, codes, panes }
    }

    /// The same with no radius above `limit(i, j)`; `limit` is called for pairs with a radius only.
    pub(crate) fn limited(&self, limit: impl Fn(usize, usize) -> f64 + Sync) -> PairRadii {
        let limited_row = |i: usize, codes: &[u8]| -> Vec<u8> {
            let of_pair = |(j, code): (usize, &u8)| match *code {
                0 => 0,
                code => code.min(radius_code(limit(i, j))),
            };
            codes.iter().enumerate().map(of_pair).collect()
        };
        let rows = self.blocks.own_rows();
        let codes = rows.into_par_iter().flat_map_iter(|i| limited_row(i, self.row(i))).collect();
        let panes = self.panes.iter().map(|row| limited_row(row.len() - 1, row)).collect();
        PairRadii { blocks: self.blocks.clone(), codes, panes }
    }

    /// Codes of the stored row `i` before the panes.
    pub(crate) fn row(&self, i: usize) -> &[u8] {
        let start = packed_length(i) - packed_length(self.blocks.own_rows().start);
        &self.codes[start..start + i + 1]
    }

    /// Codes of the rows of the panes.
    pub(crate) fn panes(&self) -> &[Vec<u8>] {
        &self.panes
    }

    /// e of every zone for strengths `s`, in the unit of the incident power.
    pub(crate) fn propagate(&self, s: &[Bands], communicator: &dyn Communicator) -> Vec<Bands> {
        let own: Vec<Bands> = s.iter().map(|s| s * s).collect();
        self.squared_product(&own, communicator).into_iter().map(Bands::sqrt).collect()
    }

    /// Σ_j r_ij² x_j of every zone.
    pub(crate) fn squared_product(&self, own: &[Bands], communicator: &dyn Communicator) -> Vec<Bands> {
        let squares = squared_radii();
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
        let blocks: Vec<usize> = self.blocks.own().collect();
        let parts: Vec<Vec<Bands>> = parallel::map(&blocks, |b| block(*b));
        let mut total = self.blocks.sum(parts, communicator, Bands::ZERO, |a, b| a + b);
        for row in &self.panes {
            let i = row.len() - 1;
            let mut here = Bands::ZERO;
            for (j, r) in row[..i].iter().enumerate().filter(|(_, r)| **r > 0) {
                let r2 = squares[*r as usize];
                here += r2 * own[j];
                total[j] += r2 * own[i];
            }
            total.push(here + squares[row[i] as usize] * own[i]);
        }
        total
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::SingleProcess;
    use zonal_scene::Band;

    #[test]
    fn codes_are_rounded_logarithms() {
        for k in 1..20_000 {
            let r = 1e-30 * 1.005f64.powi(k);
            let exact = (2.0 * r.log2() + f64::from(CODE_OF_ONE)).round().clamp(1.0, 255.0);
            assert_eq!(f64::from(radius_code(r)), exact, "{r}");
        }
        let special = [0.0, -1.0, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE / 4.0].map(radius_code);
        assert_eq!(special, [0, 0, 255, 255, 1]);
    }

    #[test]
    fn rows_of_panes_count_as_all_others() {
        let codes: Vec<u8> = (0..6).map(|k| radius_code(0.1 + f64::from(k))).collect();
        let s = [[1.0, 2.0, 5.0], [10.0, 1.0, -3.0], [0.1, 3.0, 1.0]].map(Bands::from_rgb);
        let all = PairRadii::new(RowBlocks::all(3), codes.clone(), Vec::new());
        let own = PairRadii::new(
            RowBlocks::all(1),
            codes[..1].to_vec(),
            vec![codes[1..3].to_vec(), codes[3..].to_vec()],
        );
        let [a, b] = [all, own].map(|r| r.squared_product(&s, &SingleProcess));
        assert!(a.iter().zip(&b).all(|(a, b)| (*a - *b).abs().all(|d| d < 1e-12)), "{a:?} {b:?}");
    }

    #[test]
    fn errors_follow_the_pairs_that_carry_the_light() {
        let r = [[0.0, 1e-3, 0.02], [1e-3, 0.5, 0.0], [0.02, 0.0, 1e-20]];
        let codes = (0..3).flat_map(|i| (0..=i).map(move |j| radius_code(r[i][j]))).collect();
        let s = [[1.0, 0.0, 5.0], [10.0, 1.0, 0.0], [0.1, 3.0, 1.0]].map(Bands::from_rgb);
        let e = PairRadii::new(RowBlocks::all(3), codes, Vec::new()).propagate(&s, &SingleProcess);
        for i in 0..3 {
            for b in Band::all() {
                let exact = (0..3).map(|j| (r[i][j] * s[j][b]).powi(2)).sum::<f64>().sqrt();
                assert!((e[i][b] - exact).abs() <= 0.2 * exact, "{i} {b:?}: {} {exact}", e[i][b]);
            }
        }
    }
}
