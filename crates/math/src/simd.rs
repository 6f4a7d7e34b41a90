//! Loops for the widest vectors that the machine has, chosen when the program runs.
//!
//! [`dispatch`] compiles its closure for AVX-512, AVX2 and the plain instruction set, and runs the best. The compiler vectorises
//! what is written as loops over arrays of [`LANES`] numbers. It never contracts a·b + c and never reorders sums, so that **the
//! bits are the same on every machine**; write no `mul_add` here: without the instruction it is a slow library call.

/// Numbers side by side in a lane array: one AVX-512 register, two of AVX2.
pub const LANES: usize = 8;

/// Runs `work` with the best instructions of the machine. What it calls must be `#[inline(always)]` to gain by it.
#[inline(always)]
pub fn dispatch<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

/// Work for [`run`]; mark `go` `#[inline(always)]`.
pub trait Work {
    /// What it makes.
    type Output;
    /// Does it.
    fn go(self) -> Self::Output;
}

struct Call<W>(W);

impl<W: Work> pulp::NullaryFnOnce for Call<W> {
    type Output = W::Output;
    #[inline(always)]
    fn call(self) -> W::Output {
        self.0.go()
    }
}

/// Like [`dispatch`], for loops of any length: the compiler leaves a large **closure** outside of the function that has the wide
/// instructions, a [`Work`] never.
#[inline(always)]
pub fn run<W: Work>(work: W) -> W::Output {
    pulp::Arch::new().dispatch(Call(work))
}

const LOG2_E: f64 = std::f64::consts::LOG2_E;
/// ln 2 = HIGH + LOW; HIGH has 21 trailing zero bits, so that k·HIGH is exact for |k| < 2²⁰.
const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// 1.5 · 2⁵²: adding it rounds to an integer that stands in the low bits.
const SHIFT: f64 = 6_755_399_441_055_744.0;

/// e^x for x ≤ 0 (and up to 700), lane by lane, within 2 ulp; zero below −708. Without branches: about a nanosecond a lane.
///
/// x = k ln 2 + r with |r| ≤ ln 2/2, e^r by its Taylor polynomial of degree 13 (remainder below 2⁻⁵⁸).
///
/// Step by step over all lanes: a loop over lanes around all the steps would be unrolled and stay scalar.
#[inline(always)]
pub fn exp<const N: usize>(x: [f64; N]) -> [f64; N] {
    const C: [f64; 14] = [
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
    let (mut shifted, mut r, mut r2, mut r4) = ([0.0; N], [0.0; N], [0.0; N], [0.0; N]);
    let (mut low, mut middle, mut high, mut out) = ([0.0; N], [0.0; N], [0.0; N], [0.0; N]);
    let mut scale = [0.0; N];
    for l in 0..N {
        out[l] = if x[l] < -708.0 { -708.0 } else { x[l] };
    }
    for l in 0..N {
        shifted[l] = out[l] * LOG2_E + SHIFT;
    }
    for l in 0..N {
        let k = shifted[l] - SHIFT;
        r[l] = (out[l] - k * LN2_HIGH) - k * LN2_LOW;
    }
    for l in 0..N {
        r2[l] = r[l] * r[l];
    }
    for l in 0..N {
        r4[l] = r2[l] * r2[l];
    }
    for l in 0..N {
        low[l] = (C[2] + C[3] * r[l]) + r2[l] * (C[4] + C[5] * r[l]);
    }
    for l in 0..N {
        middle[l] = (C[6] + C[7] * r[l]) + r2[l] * (C[8] + C[9] * r[l]);
    }
    for l in 0..N {
        high[l] = (C[10] + C[11] * r[l]) + r2[l] * (C[12] + C[13] * r[l]);
    }
    for l in 0..N {
        out[l] = 1.0 + (r[l] + r2[l] * (low[l] + r4[l] * (middle[l] + r4[l] * high[l])));
    }
    // 2^k: k stands in the low bits of `shifted`.
    for l in 0..N {
        scale[l] = f64::from_bits((shifted[l].to_bits().wrapping_add(1023)) << 52);
    }
    for l in 0..N {
        out[l] = if x[l] < -708.0 { 0.0 } else { out[l] * scale[l] };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_is_within_two_ulp() {
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
    fn every_instruction_set_gives_the_same_bits() {
        let x: [f64; LANES] = std::array::from_fn(|i| -0.37 * i as f64 - 1e-3);
        assert_eq!(dispatch(|| exp(x)), exp(x));
    }
}
