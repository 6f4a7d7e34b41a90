//! Low-discrepancy sequences on the unit interval, square and cube: deterministic functions of the index, without state.
//!
//! - The R_d sequence (Roberts 2018): x_n = wrap(s + n·α), α_k = φ_d^{−k} with φ_d the positive root of x^{d+1} = x + 1. The shift s
//!   is a Cranley–Patterson rotation.
//! - Sobol's sequence in two and three dimensions, scrambled by an exclusive or of its digits.

/// α of R_1: the inverse of the golden ratio.
const R1_STEP: f64 = 0.618_033_988_749_894_9;
/// α of R_2.
const R2_STEPS: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
/// α of R_3.
const R3_STEPS: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_3, 0.549_700_477_901_970_2];

/// Distance of all points from the borders of the unit interval: a point of a patch must not lie on an adjacent wall.
const BORDER_DISTANCE: f64 = 1e-6;

/// The fractional part of `x`, clamped to stay off the borders of the unit interval.
pub fn wrap(x: f64) -> f64 {
    // x − ⌊x⌋ without `floor`, which is a function call on the baseline instruction set.
    let fraction = x - (x as i64) as f64;
    (if fraction < 0.0 { fraction + 1.0 } else { fraction }).clamp(BORDER_DISTANCE, 1.0 - BORDER_DISTANCE)
}

/// The `n`-th point of the golden-ratio sequence R_1 in (0, 1), shifted by `shift`.
pub fn r1(n: usize, shift: f64) -> f64 {
    wrap(0.5 + shift + n as f64 * R1_STEP)
}
/// The `n`-th point of R_2 in the unit square, shifted by `shift`.
///
/// ```
/// use zonal_math::low_discrepancy::r2;
/// let inside = (0..1000).map(|n| r2(n, [0.0; 2])).filter(|[x, y]| x * x + y * y < 1.0).count();
/// assert!((inside as f64 / 1000.0 - std::f64::consts::FRAC_PI_4).abs() < 0.01);
/// ```
pub fn r2(n: usize, shift: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|k| wrap(0.5 + shift[k] + n as f64 * R2_STEPS[k]))
}
/// The `n`-th point of R_3 in the unit cube, shifted by `shift`.
pub fn r3(n: usize, shift: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| wrap(0.5 + shift[k] + n as f64 * R3_STEPS[k]))
}
/// α of R_6: φ^{−m} with φ the root of x⁷ = x + 1.
const R6_STEPS: [f64; 6] = {
    let phi = 1.112_775_684_278_705_5;
    let mut a = [0.0; 6];
    let mut p = 1.0;
    let mut m = 0;
    while m < 6 {
        p /= phi;
        a[m] = p;
        m += 1;
    }
    a
};
/// The `n`-th point of R_6 in the six-dimensional unit cube; the first is `shift` itself.
pub fn r6(n: usize, shift: [f64; 6]) -> [f64; 6] {
    std::array::from_fn(|m| wrap(shift[m] + n as f64 * R6_STEPS[m]))
}
/// A pseudo-random Cranley–Patterson shift of a sequence in `D` dimensions, a function of the seed.
pub fn random_shift<const D: usize>(seed: u64) -> [f64; D] {
    std::array::from_fn(|m| hash_to_unit(seed.wrapping_mul(D as u64).wrapping_add(m as u64)))
}

/// The `n`-th point of the scrambled Sobol sequence in the unit square: each aligned block of 2^k points has one point in every elementary
/// interval of area 2^−k.
pub fn sobol_2d(n: u32, scramble: [u32; 2]) -> [f64; 2] {
    let (mut digits, mut direction, mut second) = (n, 1u32 << 31, 0u32);
    while digits != 0 {
        if digits & 1 == 1 {
            second ^= direction;
        }
        digits >>= 1;
        direction ^= direction >> 1;
    }
    let unit = |x: u32| wrap((x as f64 + 0.5) / (1u64 << 32) as f64);
    [unit(n.reverse_bits() ^ scramble[0]), unit(second ^ scramble[1])]
}

/// Direction numbers of the third dimension of Sobol's sequence: m_k = 2 m_{k−1} ⊕ 4 m_{k−2} ⊕ m_{k−2} from 1 and 3, as binary fractions.
const THIRD_DIMENSION_DIRECTIONS: [u32; 32] = {
    let mut m = [1u64, 3];
    let mut out = [0; 32];
    let mut k = 0;
    while k < 32 {
        out[k] = (m[0] << (31 - k)) as u32;
        m = [m[1], (2 * m[1]) ^ (4 * m[0]) ^ m[0]];
        k += 1;
    }
    out
};

/// The third coordinate of the `n`-th Sobol point, to be used with [`sobol_2d`].
pub fn sobol_third_dimension(n: u32, scramble: u32) -> f64 {
    let (mut digits, mut sum, mut k) = (n, scramble, 0);
    while digits != 0 {
        if digits & 1 == 1 {
            sum ^= THIRD_DIMENSION_DIRECTIONS[k];
        }
        digits >>= 1;
        k += 1;
    }
    wrap((sum as f64 + 0.5) / (1u64 << 32) as f64)
}

/// The 64-bit hash of SplitMix64 (Steele, Lea and Flood 2014).
pub fn split_mix64(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// A pseudo-random number in [0, 1): the leading 53 bits of the hash of `seed`.
pub fn hash_to_unit(seed: u64) -> f64 {
    (split_mix64(seed) >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_elementary_interval_of_sobol_2d_has_one_point() {
        for (a, b) in [(4, 4), (16, 1), (2, 8)] {
            let mut hit = vec![0; 16];
            for n in 32..48 {
                let [x, y] = sobol_2d(n, [0x1234_5678, 0x9abc_def0]);
                hit[(x * a as f64) as usize * b + (y * b as f64) as usize] += 1;
            }
            assert!(hit.iter().all(|h| *h == 1), "{a} {b}: {hit:?}");
        }
    }

    #[test]
    fn sobol_points_are_stratified_in_three_dimensions() {
        // Of 64 points each slab holds one, each octant eight, and each of 8 × 4 boxes in two coordinates two.
        let points: Vec<[f64; 3]> = (64..128)
            .map(|n| {
                let [x, y] = sobol_2d(n, [0x1234_5678, 0x9abc_def0]);
                [x, y, sobol_third_dimension(n, 0x0f1e_2d3c)]
            })
            .collect();
        let count = |sides: [usize; 3]| {
            let mut hit = vec![0; sides.iter().product()];
            for p in &points {
                let at = [0, 1, 2].map(|k| (p[k] * sides[k] as f64) as usize);
                hit[(at[0] * sides[1] + at[1]) * sides[2] + at[2]] += 1;
            }
            (hit.iter().copied().min().unwrap_or(0), hit.iter().copied().max().unwrap_or(0))
        };
        assert_eq!(count([1, 1, 64]), (1, 1));
        assert_eq!(count([2, 2, 2]), (8, 8));
        for sides in [[8, 1, 4], [4, 1, 8], [1, 8, 4], [1, 4, 8]] {
            assert_eq!(count(sides), (2, 2), "{sides:?}");
        }
    }

    #[test]
    fn r2_and_r3_points_stay_inside_and_are_equidistributed() {
        let n = 1000;
        let inside = (0..n).map(|i| r2(i, [0.3, 0.9])).filter(|p| p[0] < 0.5 && p[1] < 0.25).count();
        assert!((inside as f64 - 125.0).abs() < 8.0, "{inside}");
        assert!((0..n).map(|i| r3(i, [0.0; 3])).all(|p| p.iter().all(|x| (0.0..1.0).contains(x))));
    }
}
