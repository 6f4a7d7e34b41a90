//! The natural logarithm, lane by lane, for loops that [`super::dispatch`] runs.
//!
//! x = 2^k m with m in [√½, √2), s = (m − 1)/(m + 1), ln m = 2 artanh s = 2s (1 + s²/3 + s⁴/5 + …). |s| ≤ 0.1716, so that the sum of the terms
//! from s²⁰/21 on is below 3e-17 of the first. m − 1 is exact, m + 1 and the quotient round once each, k ln 2 is added in two parts:
//! the relative error is at most 4 units of 2⁻⁵³ (`LN_ERROR_HALF_ULPS`).

/// Bound of the relative error of [`ln`] in units of 2⁻⁵³.
#[cfg(test)]
const LN_ERROR_HALF_ULPS: f64 = 4.0; // bound

/// Bits of √½.
const SQRT_HALF_BITS: u64 = 0x3FE6_A09E_667F_3BCD;
/// Bits of 1.
const ONE_BITS: u64 = 0x3FF0_0000_0000_0000;
/// Bits of 2⁵²: an integer below 2⁵² in the low bits is added to it.
const TWO_POW_52_BITS: u64 = 0x4330_0000_0000_0000;
/// ln 2 = LN2_HIGH + LN2_LOW; LN2_HIGH has 21 trailing zero bits.
const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// ln x for positive normal x, lane by lane, without branches; unspecified for other numbers.
///
/// ```
/// let [zero, two] = zonal_math::simd::ln([1.0, std::f64::consts::E.powi(2)]);
/// assert_eq!(zero, 0.0);
/// assert!((two - 2.0).abs() < 1e-15);
/// ```
#[inline(always)]
pub fn ln<const N: usize>(x: [f64; N]) -> [f64; N] {
    let mut out = [0.0; N];
    for i in 0..N {
        out[i] = ln_lane(x[i]);
    }
    out
}

#[inline(always)]
fn ln_lane(x: f64) -> f64 {
    let bits = x.to_bits();
    // The exponent plus 1023, counted from √½.
    let exponent = bits.wrapping_add(ONE_BITS - SQRT_HALF_BITS) >> 52;
    let k = f64::from_bits(TWO_POW_52_BITS | exponent) - (4_503_599_627_370_496.0 + 1023.0);
    let m = f64::from_bits(bits.wrapping_add(ONE_BITS).wrapping_sub(exponent << 52));
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    let z2 = z * z;
    let z4 = z2 * z2;
    let low = (1.0 / 3.0 + z * (1.0 / 5.0)) + z2 * (1.0 / 7.0 + z * (1.0 / 9.0));
    let high = (1.0 / 11.0 + z * (1.0 / 13.0)) + z2 * (1.0 / 15.0 + z * (1.0 / 17.0));
    let tail = low + z4 * (high + z4 * (1.0 / 19.0));
    let twice = 2.0 * s;
    k * LN2_HIGH + (twice + (twice * (z * tail) + k * LN2_LOW))
}

#[cfg(test)]
mod tests {
    use super::super::dispatch;
    use super::*;

    #[test]
    fn logarithm_error_is_within_its_bound() {
        let unit = 0.5 * f64::EPSILON;
        let mut worst: f64 = 0.0;
        let mut check = |x: f64| {
            let (got, want) = (ln([x])[0], x.ln());
            worst = worst.max((got - want).abs() / want.abs().max(1e-300));
        };
        for i in 0..400_000 {
            let t = i as f64 / 399_999.0;
            check((700.0 * (2.0 * t - 1.0)).exp());
            check(0.5 + 1.5 * t);
            check(1.0 + (t - 0.5) * 1e-6);
        }
        assert_eq!(ln([1.0])[0], 0.0);
        // The standard library's logarithm is rounded once.
        assert!(worst <= (LN_ERROR_HALF_ULPS + 1.0) * unit, "{:.2} units", worst / unit);
        assert!(
            worst > 0.5 * LN_ERROR_HALF_ULPS * unit,
            "half the bound would hold: {:.2} units",
            worst / unit
        );
    }

    #[test]
    fn logarithm_has_equal_bits_on_every_instruction_set() {
        let x: [f64; 8] = std::array::from_fn(|i| 0.3 + 0.7 * i as f64);
        assert_eq!(dispatch(|| ln(x)), ln(x));
    }
}
