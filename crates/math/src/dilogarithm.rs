//! The dilogarithm Li₂(z) = Σ zⁿ/n² in the closed unit disc, and Clausen's function Cl₂(φ) = Im Li₂(e^{iφ}).
//!
//! For Re z ≤ ½: with U = −ln(1 − z), Li₂(z) = Σ B_n U^{n+1}/(n+1)! = U − U²/4 + Σ_{k≥1} B_{2k} U^{2k+1}/(2k+1)! ('t Hooft and Veltman 1979).
//! There |U| ≤ π/3 (at e^{±iπ/3}), so the ratio of the terms is at most 1/36, and the remainder after the tenth term is below 1e-18.
//! For Re z > ½: Li₂(z) = π²/6 − ln z ln(1 − z) − Li₂(1 − z), and |1 − z| < 1 with Re(1 − z) < ½.
//!
//! **Rounding.** With library functions within an ulp, U carries an absolute error of 3 units of 2⁻⁵³ · max(1, |ln|1 − z||), the series has a
//! derivative below 1.5 and its own roundings are below 4 units of |U| ≤ 1.05. In the second case ln z ln(1 − z) multiplies errors of |ln z| ≤ 1.32
//! and |ln z| |ln(1 − z)| ≤ 1.1. Together less than `ERROR_HALF_ULPS` units of 2⁻⁵³ absolute, in either part.

use std::f64::consts::PI;

/// Bound of the absolute error of either part of [`dilogarithm`], in units of 2⁻⁵³ (see the header).
#[cfg(test)]
const ERROR_HALF_ULPS: f64 = 24.0;

/// B_{2k}/(2k+1)! for k = 1 … 10.
const BERNOULLI_SERIES: [f64; 10] = [
    1.0 / 6.0 / 6.0,
    -1.0 / 30.0 / 120.0,
    1.0 / 42.0 / 5_040.0,
    -1.0 / 30.0 / 362_880.0,
    5.0 / 66.0 / 39_916_800.0,
    -691.0 / 2_730.0 / 6_227_020_800.0,
    7.0 / 6.0 / 1_307_674_368_000.0,
    -3_617.0 / 510.0 / 355_687_428_096_000.0,
    43_867.0 / 798.0 / 121_645_100_408_832_000.0,
    -174_611.0 / 330.0 / 51_090_942_171_709_440_000.0,
];

type Complex = [f64; 2];

fn complex_product(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

/// ln(1 − z).
fn ln_one_minus([x, y]: Complex) -> Complex {
    let square = x * x + y * y;
    let modulus = if (square - 2.0 * x).abs() < 0.5 {
        (square - 2.0 * x).ln_1p()
    } else {
        ((1.0 - x) * (1.0 - x) + y * y).ln()
    };
    [0.5 * modulus, (-y).atan2(1.0 - x)]
}

/// The series in U = −ln(1 − z), for Re z ≤ ½.
fn series(u: Complex) -> Complex {
    let square = complex_product(u, u);
    let mut tail = [0.0, 0.0];
    for t in BERNOULLI_SERIES.iter().rev() {
        tail = complex_product(tail, square);
        tail[0] += t;
    }
    let odd = complex_product(complex_product(tail, square), u);
    [u[0] - 0.25 * square[0] + odd[0], u[1] - 0.25 * square[1] + odd[1]]
}

/// Li₂(z) for |z| ≤ 1 (and a few rounding errors beyond), as [real, imaginary], within `ERROR_HALF_ULPS`·2⁻⁵³ in either part.
///
/// ```
/// use zonal_math::dilogarithm::dilogarithm;
/// let [re, im] = dilogarithm([1.0, 0.0]);
/// assert!((re - std::f64::consts::PI.powi(2) / 6.0).abs() < 1e-15 && im == 0.0);
/// ```
pub fn dilogarithm(z: [f64; 2]) -> [f64; 2] {
    let [x, y] = z;
    let one_minus = ln_one_minus(z);
    if x <= 0.5 {
        return series([-one_minus[0], -one_minus[1]]);
    }
    if x == 1.0 && y == 0.0 {
        return [PI * PI / 6.0, 0.0];
    }
    let log = ln_one_minus([1.0 - x, -y]);
    let (product, rest) = (complex_product(log, one_minus), series([-log[0], -log[1]]));
    [PI * PI / 6.0 - product[0] - rest[0], -product[1] - rest[1]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauss_legendre;

    const HALF_ULP_OF_ONE: f64 = 0.5 * f64::EPSILON;

    #[test]
    fn dilogarithm_matches_known_values() {
        let close = |z: Complex, want: Complex| {
            let got = dilogarithm(z);
            for k in 0..2 {
                assert!(
                    (got[k] - want[k]).abs() <= ERROR_HALF_ULPS * HALF_ULP_OF_ONE,
                    "Li2({z:?}) = {got:?}, not {want:?}"
                );
            }
        };
        let ln2 = std::f64::consts::LN_2;
        close([0.0, 0.0], [0.0, 0.0]);
        close([1.0, 0.0], [PI * PI / 6.0, 0.0]);
        close([-1.0, 0.0], [-PI * PI / 12.0, 0.0]);
        close([0.5, 0.0], [PI * PI / 12.0 - 0.5 * ln2 * ln2, 0.0]);
        // Catalan's constant, and the maximum of Clausen's function at π/3.
        close([0.0, 1.0], [-PI * PI / 48.0, 0.915_965_594_177_219]);
        close([0.5, 0.75f64.sqrt()], [PI * PI / 36.0, 1.014_941_606_409_653_6]);
    }

    /// Li₂(z) = −∫₀¹ ln(1 − zt)/t dt on pieces that shrink towards t = 1.
    fn dilogarithm_by_quadrature(z: Complex) -> Complex {
        let rule = gauss_legendre::rule(30);
        let mut sum = [0.0; 2];
        let mut hi = 1.0;
        for piece in 0..50 {
            let (a, b) = if piece == 49 { (1.0 - hi, 1.0) } else { (1.0 - hi, 1.0 - 0.5 * hi) };
            for (x, w) in rule.nodes.iter().zip(&rule.weights) {
                let t = a + (b - a) * x;
                let l = ln_one_minus([z[0] * t, z[1] * t]);
                sum[0] -= w * (b - a) * l[0] / t;
                sum[1] -= w * (b - a) * l[1] / t;
            }
            hi *= 0.5;
        }
        sum
    }

    #[test]
    fn dilogarithm_matches_its_integral() {
        for i in 0..24 {
            for r in [0.05, 0.3, 0.5, 0.77, 0.95, 1.0] {
                let phi = 2.0 * PI * (i as f64 + 0.21) / 24.0;
                let z = [r * phi.cos(), r * phi.sin()];
                let (got, want) = (dilogarithm(z), dilogarithm_by_quadrature(z));
                for k in 0..2 {
                    assert!((got[k] - want[k]).abs() < 8e-15, "Li2({z:?}) = {got:?}, not {want:?}");
                }
            }
        }
    }

    /// The duplication formula Li₂(z²) = 2 (Li₂(z) + Li₂(−z)).
    #[test]
    fn duplication_formula_holds_within_the_error_bound() {
        let mut worst: f64 = 0.0;
        for i in 0..20_000 {
            let (phi, r) = (1e-3 * i as f64, ((i * 7919) % 20_000) as f64 / 20_000.0);
            let z = [r * phi.cos(), r * phi.sin()];
            let double = dilogarithm(complex_product(z, z));
            let (plus, minus) = (dilogarithm(z), dilogarithm([-z[0], -z[1]]));
            for k in 0..2 {
                worst = worst.max((double[k] - 2.0 * (plus[k] + minus[k])).abs());
            }
        }
        // Three values with weights 1, 2, 2, and the rounding of z² times |ln| ≤ 20.
        assert!(
            worst <= (5.0 * ERROR_HALF_ULPS + 40.0) * HALF_ULP_OF_ONE,
            "{:.1} units",
            worst / HALF_ULP_OF_ONE
        );
    }
}
