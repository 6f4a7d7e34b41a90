//! The exponential function, lane by lane, for loops that [`super::dispatch`] runs.
//!
//! x = k ln 2 + r with |r| ≤ ln 2/2; e^r by its Taylor polynomial of degree 13 (remainder below 2⁻⁵⁸, Estrin's scheme); the result is
//! scaled by 2^k. Each step is a loop over all lanes: a single loop over lanes around all steps would be unrolled and stay scalar.
//!
//! **Cost:** about a nanosecond a lane.

/// ln 2 = LN2_HIGH + LN2_LOW; LN2_HIGH has 21 trailing zero bits, so that k·LN2_HIGH is exact for |k| < 2²⁰.
const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// 1.5 · 2⁵²: the sum with it is rounded to an integer, which is in the low bits.
const ROUNDING_SHIFT: f64 = 6_755_399_441_055_744.0;

/// Below this argument the result is zero: e^−708 is the smallest normal power.
const MIN_EXPONENT: f64 = -708.0;

/// Taylor coefficients 1/k!.
const TAYLOR: [f64; 14] = [
    1.0,
    1.0,
    1.0 / 2.0,
    1.0 / 6.0,
    1.0 / 24.0,
    1.0 / 120.0,
    1.0 / 720.0,
    1.0 / 5_040.0,
    1.0 / 40_320.0,
    1.0 / 362_880.0,
    1.0 / 3_628_800.0,
    1.0 / 39_916_800.0,
    1.0 / 479_001_600.0,
    1.0 / 6_227_020_800.0,
];

/// e^x for x ≤ 0 (and up to 700), lane by lane, within 2 ulp; zero below −708. Without branches.
///
/// ```
/// let [one, tenth] = zonal_math::simd::exp([0.0, -std::f64::consts::LN_10]);
/// assert_eq!(one, 1.0);
/// assert!((tenth - 0.1).abs() < 1e-16);
/// assert_eq!(zonal_math::simd::exp([-1e3]), [0.0]);
/// ```
#[inline(always)]
pub fn exp<const N: usize>(x: [f64; N]) -> [f64; N] {
    let (mut shifted, mut r, mut r2, mut r4) = ([0.0; N], [0.0; N], [0.0; N], [0.0; N]);
    let (mut low, mut middle, mut high, mut out) = ([0.0; N], [0.0; N], [0.0; N], [0.0; N]);
    let mut scale = [0.0; N];
    // Clamp the argument to the range of normal results.
    for l in 0..N {
        out[l] = if x[l] < MIN_EXPONENT { MIN_EXPONENT } else { x[l] };
    }
    // Round x / ln 2 to the integer k, which stands in the low bits of `shifted`.
    for l in 0..N {
        shifted[l] = out[l] * std::f64::consts::LOG2_E + ROUNDING_SHIFT;
    }
    // Reduce the argument: r = x − k ln 2.
    for l in 0..N {
        let k = shifted[l] - ROUNDING_SHIFT;
        r[l] = (out[l] - k * LN2_HIGH) - k * LN2_LOW;
    }
    // Powers of r for Estrin's scheme.
    for l in 0..N {
        r2[l] = r[l] * r[l];
    }
    for l in 0..N {
        r4[l] = r2[l] * r2[l];
    }
    // Evaluate the Taylor polynomial by Estrin's scheme.
    for l in 0..N {
        low[l] = (TAYLOR[2] + TAYLOR[3] * r[l]) + r2[l] * (TAYLOR[4] + TAYLOR[5] * r[l]);
    }
    for l in 0..N {
        middle[l] = (TAYLOR[6] + TAYLOR[7] * r[l]) + r2[l] * (TAYLOR[8] + TAYLOR[9] * r[l]);
    }
    for l in 0..N {
        high[l] = (TAYLOR[10] + TAYLOR[11] * r[l]) + r2[l] * (TAYLOR[12] + TAYLOR[13] * r[l]);
    }
    for l in 0..N {
        out[l] = 1.0 + (r[l] + r2[l] * (low[l] + r4[l] * (middle[l] + r4[l] * high[l])));
    }
    for l in 0..N {
        scale[l] = f64::from_bits((shifted[l].to_bits().wrapping_add(1023)) << 52);
    }
    // Scale by 2^k; zero below the range.
    for l in 0..N {
        out[l] = if x[l] < MIN_EXPONENT { 0.0 } else { out[l] * scale[l] };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::{LANES, dispatch};
    use super::*;

    #[test]
    fn exponential_is_within_two_ulp() {
        let mut worst: f64 = 0.0;
        for i in 0..400_000 {
            let x = -700.0 * (i as f64 / 399_999.0).powi(3);
            let (got, want) = (exp([x])[0], x.exp());
            worst = worst.max((got / want - 1.0).abs());
        }
        assert!(worst <= 2.0 * f64::EPSILON, "{worst:e}");
        assert_eq!(exp([0.0, -709.0, -1e9, 1.0]), [1.0, 0.0, 0.0, exp([1.0])[0]]);
        assert!((exp([600.0])[0] / 600f64.exp() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn exponential_has_equal_bits_on_every_instruction_set() {
        let x: [f64; LANES] = std::array::from_fn(|i| -0.37 * i as f64 - 1e-3);
        assert_eq!(dispatch(|| exp(x)), exp(x));
    }
}
