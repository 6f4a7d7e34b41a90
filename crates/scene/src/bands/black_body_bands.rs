//! Fractions of the black-body emissive power between wavelengths.
//!
//! With x = c₂/(λT) and c₂ = hc/k, the fraction below λ is
//!
//! ```text
//!     F(x) = 15/π⁴ ∫_x^∞ t³/(eᵗ − 1) dt = 15/π⁴ Σ_n e^(−nx) (x³/n + 3x²/n² + 6x/n³ + 6/n⁴)          x dF/dx = −15/π⁴ x⁴/(eˣ − 1)
//! ```
//!
//! and 1 − 15/π⁴ (x³/3 − x⁴/8 + x⁵/60 − x⁷/5040 + x⁹/272160 − x¹¹/13305600 + …) for small x, the series of t³/(eᵗ − 1) by Bernoulli numbers.

use std::f64::consts::PI;

/// hc/k, nm K (CODATA 2018).
const SECOND_RADIATION_CONSTANT: f64 = 1.438_776_877e7;
/// x below which the power series holds, with an error below 1e-15 there, and the terms of the other series beyond.
const LARGEST_X_OF_POWER_SERIES: f64 = 0.5;
const TERMS: usize = 80;
/// Coefficients of x³, x⁴, x⁵, x⁷, x⁹, x¹¹, x¹³ of the power series: 1/3, −1/8, and B_2k/((2k + 3) (2k)!).
const POWER_SERIES: [(i32, f64); 7] = [
    (3, 1.0 / 3.0),
    (4, -1.0 / 8.0),
    (5, 1.0 / 60.0),
    (7, -1.0 / 5040.0),
    (9, 1.0 / 272_160.0),
    (11, -1.0 / 13_305_600.0),
    (13, 1.0 / 622_702_080.0),
];

/// The fraction of the black-body emissive power at `t` kelvin below a wavelength in nm, and its derivative by the temperature, 1/K.
pub(crate) fn fraction_below(wavelength: f64, t: f64) -> [f64; 2] {
    if wavelength <= 0.0 || t <= 0.0 {
        return [0.0; 2];
    }
    if wavelength.is_infinite() {
        return [1.0, 0.0];
    }
    let x = SECOND_RADIATION_CONSTANT / (wavelength * t);
    let scale = 15.0 / PI.powi(4);
    // dF/dT = −(x/T) dF/dx; x⁴/(eˣ − 1) has the limit 0 at both ends.
    let slope = if x < 700.0 { scale * x.powi(4) / x.exp_m1() / t } else { 0.0 };
    if x < LARGEST_X_OF_POWER_SERIES {
        let sum: f64 = POWER_SERIES.iter().map(|(power, c)| c * x.powi(*power)).sum();
        return [1.0 - scale * sum, slope];
    }
    let term = |n: usize| {
        let n = n as f64;
        (-n * x).exp() / n * (x.powi(3) + 3.0 * x * x / n + 6.0 * x / (n * n) + 6.0 / (n * n * n))
    };
    [scale * (1..=TERMS).map(term).sum::<f64>(), slope]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fractions_agree_with_tables_and_with_their_slopes() {
        // Below 1444, 2898 and 10 000 µm K and beyond (tables of Siegel and Howell).
        for (product, wanted) in [(1444.0, 0.0098), (2897.8, 0.2501), (10_000.0, 0.9142), (50_000.0, 0.9989)]
        {
            let [found, _] = fraction_below(1000.0, product);
            assert!((found - wanted).abs() < 1.5e-4, "{product}: {found}");
        }
        // Both series agree where they meet, and the slope is the derivative.
        let t = SECOND_RADIATION_CONSTANT / (1e4 * LARGEST_X_OF_POWER_SERIES);
        let [low, high] = [t * (1.0 - 1e-9), t * (1.0 + 1e-9)].map(|t| fraction_below(1e4, t)[0]);
        assert!((high - low).abs() < 1e-9 && high > low - 1e-14, "{low} {high}");
        for t in [200.0, 900.0, 3000.0, 2e4] {
            let difference = fraction_below(3000.0, t * 1.001)[0] - fraction_below(3000.0, t * 0.999)[0];
            let slope = fraction_below(3000.0, t)[1];
            assert!((difference / (0.002 * t) / slope - 1.0).abs() < 1e-4, "{t}");
        }
        assert_eq!(fraction_below(f64::INFINITY, 300.0), [1.0, 0.0]);
        assert_eq!(fraction_below(0.0, 300.0), [0.0, 0.0]);
    }
}
