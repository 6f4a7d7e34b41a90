//! Low-discrepancy points on the unit interval, square and cube: deterministic, no state.
//!
//! The R_d sequence of Roberts: x_n = wrap(s + n·α), α_k = φ_d^{−k} with φ_d the positive root of x^{d+1} = x + 1.

const PHI1: f64 = 0.618_033_988_749_894_9;
const R2: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
const R3: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_3, 0.549_700_477_901_970_2];

/// Points keep this far from the borders of the unit interval: a point of a patch must not fall onto the wall beside it.
const RIM: f64 = 1e-6;

/// The fractional part of `x`, kept off the borders of the unit interval.
pub fn wrap(x: f64) -> f64 {
    // As x − ⌊x⌋, which is a call where the processor may be old.
    let part = x - (x as i64) as f64;
    (if part < 0.0 { part + 1.0 } else { part }).clamp(RIM, 1.0 - RIM)
}

/// The `n`-th point of the golden-ratio sequence in (0,1), shifted by `shift`.
pub fn r1(n: usize, shift: f64) -> f64 {
    wrap(0.5 + shift + n as f64 * PHI1)
}
/// The `n`-th point of the sequence in the unit square, shifted by `shift`.
pub fn r2(n: usize, shift: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|k| wrap(0.5 + shift[k] + n as f64 * R2[k]))
}
/// The `n`-th point of the sequence in the unit cube, shifted by `shift`.
pub fn r3(n: usize, shift: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| wrap(0.5 + shift[k] + n as f64 * R3[k]))
}
/// φ^{−m} with φ the root of x⁷ = x + 1.
const R6: [f64; 6] = {
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
/// The `n`-th point of the sequence in the six-dimensional unit cube; the first is `shift` itself.
pub fn r6(n: usize, shift: [f64; 6]) -> [f64; 6] {
    std::array::from_fn(|m| wrap(shift[m] + n as f64 * R6[m]))
}
/// A shift for a sequence in `D` dimensions, of its own for each seed.
pub fn shift<const D: usize>(seed: u64) -> [f64; D] {
    std::array::from_fn(|m| unit(seed.wrapping_mul(D as u64).wrapping_add(m as u64)))
}

/// The `n`-th point of Sobol's sequence in the unit square, its digits scrambled: the first 2^k points, and each 2^k after, have one in
/// every box of area 2^−k that halving makes.
pub fn net(n: u32, scramble: [u32; 2]) -> [f64; 2] {
    let (mut rest, mut direction, mut second) = (n, 1u32 << 31, 0u32);
    while rest != 0 {
        if rest & 1 == 1 {
            second ^= direction;
        }
        rest >>= 1;
        direction ^= direction >> 1;
    }
    let unit = |x: u32| wrap((x as f64 + 0.5) / (1u64 << 32) as f64);
    [unit(n.reverse_bits() ^ scramble[0]), unit(second ^ scramble[1])]
}

/// Directions of the third coordinate of Sobol's sequence: m_k = 2 m_{k−1} ⊕ 4 m_{k−2} ⊕ m_{k−2} from 1 and 3, as binary fractions.
const THIRD: [u32; 32] = {
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

/// The coordinate that belongs to the `n`-th point of [`net`]: (x, y, z) fill the unit cube evenly.
pub fn third(n: u32, scramble: u32) -> f64 {
    let (mut rest, mut sum, mut k) = (n, scramble, 0);
    while rest != 0 {
        if rest & 1 == 1 {
            sum ^= THIRD[k];
        }
        rest >>= 1;
        k += 1;
    }
    wrap((sum as f64 + 0.5) / (1u64 << 32) as f64)
}

/// A well-mixed 64-bit hash (SplitMix64's finaliser), for decorrelated shifts.
pub fn hash(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// A number in [0,1) from a hash of `seed`.
pub fn unit(seed: u64) -> f64 {
    (hash(seed) >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_box_of_a_net_has_one_point() {
        for (a, b) in [(4, 4), (16, 1), (2, 8)] {
            let mut hit = vec![0; 16];
            for n in 32..48 {
                let [x, y] = net(n, [0x1234_5678, 0x9abc_def0]);
                hit[(x * a as f64) as usize * b + (y * b as f64) as usize] += 1;
            }
            assert!(hit.iter().all(|h| *h == 1), "{a} {b}: {hit:?}");
        }
    }

    #[test]
    fn every_slab_of_a_cube_has_its_share() {
        // Of 64 points each slab has one, each octant eight, and each box of 8 × 4 in two coordinates two.
        let points: Vec<[f64; 3]> = (64..128)
            .map(|n| {
                let [x, y] = net(n, [0x1234_5678, 0x9abc_def0]);
                [x, y, third(n, 0x0f1e_2d3c)]
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
    fn points_stay_in_the_unit_square_and_fill_it() {
        let n = 1000;
        let inside = (0..n).map(|i| r2(i, [0.3, 0.9])).filter(|p| p[0] < 0.5 && p[1] < 0.25).count();
        assert!((inside as f64 - 125.0).abs() < 8.0, "{inside}");
        assert!((0..n).map(|i| r3(i, [0.0; 3])).all(|p| p.iter().all(|x| (0.0..1.0).contains(x))));
    }
}
