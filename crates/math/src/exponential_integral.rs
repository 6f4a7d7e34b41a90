//! Exponential integrals E_n(x) = ∫₁^∞ e^{−xt} t^{−n} dt (Modest, appendix E).
//!
//! E_1 by its power series for x ≤ 1 and by the continued fraction of the incomplete gamma function beyond (modified Lentz);
//! higher orders by n E_{n+1} = e^{−x} − x E_n.

/// The Euler–Mascheroni constant.
const EULER_GAMMA: f64 = 0.577_215_664_901_532_9;

/// Terms of the power series for x ≤ 1; the first omitted one is below 1e-49.
const SERIES_TERMS: usize = 40;
/// Largest number of terms of the continued fraction.
const MAX_FRACTION_TERMS: usize = 500;
/// Relative change of the continued fraction below which it has converged.
const FRACTION_TOLERANCE: f64 = 1e-16;

/// E_1(x) for x > 0; relative error below 1e-13.
///
/// ```
/// assert!((zonal_math::exponential_integral::e1(1.0) - 0.219_383_934_395_520_3).abs() < 1e-15);
/// ```
pub fn e1(x: f64) -> f64 {
    if x <= 1.0 {
        let (mut sum, mut term) = (0.0, 1.0);
        for k in 1..SERIES_TERMS {
            term *= -x / k as f64;
            sum -= term / k as f64;
        }
        return sum - x.ln() - EULER_GAMMA;
    }
    let mut b = x + 1.0;
    let mut c = 1e300;
    let mut d = 1.0 / b;
    let mut h = d;
    for i in 1..MAX_FRACTION_TERMS {
        let a = -((i * i) as f64);
        b += 2.0;
        d = 1.0 / (a * d + b);
        c = b + a / c;
        let delta = c * d;
        h *= delta;
        if (delta - 1.0).abs() < FRACTION_TOLERANCE {
            break;
        }
    }
    h * (-x).exp()
}

/// E_3(x) for x ≥ 0; absolute error below 1e-14.
pub fn e3(x: f64) -> f64 {
    if x == 0.0 {
        return 0.5;
    }
    let e = (-x).exp();
    let e2 = e - x * e1(x);
    0.5 * (e - x * e2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The emittance 1 − 2 E_3(τ) of an isothermal slab, computed independently to eight digits.
    #[test]
    fn slab_emittances_match_reference_values() {
        let table = [
            (0.01, 0.01944687),
            (0.1, 0.16741708),
            (0.5, 0.55679127),
            (1.0, 0.78061607),
            (2.0, 0.93973324),
            (5.0, 0.99824440),
            (10.0, 0.99999290),
        ];
        for (tau, want) in table {
            assert!((1.0 - 2.0 * e3(tau) - want).abs() < 6e-9, "tau = {tau}");
        }
    }

    #[test]
    fn series_and_continued_fraction_agree_at_one() {
        assert!((e1(1.0) - 0.219_383_934_395_520_3).abs() < 1e-15);
        assert!((e1(1.0 + 1e-9) / e1(1.0) - 1.0).abs() < 1e-8);
    }
}
