//! Far pairs without a medium: 𝓕 in the moments of the density of t.
//!
//! Let t = c + δ with c the centre offset, δ of independent axes, each symmetric: 0 (both boxes flat there), uniform
//! (one flat) or the sum of two uniforms (the trapezoid). With q = 2 + m = 2λ, m patches, p_k of them flat on axis k, r = |c|
//! and W the mass of the density
//!
//! ```text
//! 𝓕 = (W/π) E[ Π t_k^{p_k} / |t|^{2λ} ],      1/|c + δ|^{2λ} = Σ_n T_n,   |T_n| = |δ|^n |C_n^λ(cosθ)| / r^{n+2λ}.
//! ```
//!
//! **Evaluation.** 1/|t|^{2λ} = (1/Γ(λ)) ∫ s^{λ−1} e^{−s|t|²} ds, and e^{−s|t|²} factors by axes. The terms of e^{−s(c+δ)²} in
//! even powers of δ are Hermite's: the part in E δ^{2k} is
//!
//! ```text
//! A_k = e^{−sc²} μ_{2k} s^k Σ_i (−4sc²)^i (−1)^k / ((2i)! (k−i)!)                       (p = 0)
//!     = e^{−sc²} c μ_{2k} s^k Σ_i (−4sc²)^i (−1)^k (2k+1) / ((2i+1)! (k−i)!)            (p = 1, times t itself)
//! ```
//!
//! odd powers have no mean. The product of three axes is a polynomial in s, whose s^j becomes the rising factorial (λ)_j / r^{2j}.
//! All terms with k_x + k_y + k_z = K are the order n = 2K, exactly E of the terms of degree n in δ.
//!
//! **Truncation.** |C_n^λ| ≤ b_n = binom(n+2λ−1, n). With |δ_k| ≤ h_k on the axes of normals, e₁ = Σ h_k/c_k, e₂ = Π h_k/c_k (e₂ = 0
//! unless there are two) and M_n ≥ E|δ|^n, the order n is relative to Πc^p/r^{2λ} at most
//!
//! ```text
//! β_n = b_n M_n/r^n + e₁ b_{n−1} M_{n−1}/r^{n−1} + e₂ b_{n−2} M_{n−2}/r^{n−2},
//! ```
//!
//! even M_n being exact and M_{n−1} = √(M_{n−2} M_n) (Cauchy–Schwarz). Since |δ| ≤ D, each part shrinks from n to n + 2 by at
//! most g = (D/r)² b_n/b_{n−2}, which falls with n. So all orders above n = 2K leave at most **β_{n+2}/(1 − g)**, if g < 1.
//!
//! **Rounding.** Terms have both signs. Their absolute sum is that of the same expansion of 1/(1 − 2c·δ − |δ|²)^λ, whose order n is at most
//! G_n |δ|^n with Σ G_n p^n = (1 − 2p − p²)^{−λ}, and for the numerators G_n + e₁ G_{n−1} + e₂ G_{n−2} in the same way. With ε = 2⁻⁵³ a monomial of
//! order 2K carries: c²/r² 6ε, its powers 7Kε; moments (5K + 6)ε, constants 9ε; r^{−2K} 6Kε; (λ)_j 2Kε; additions at most
//! (K+1)²ε; mass, 1/r^{2λ}, c^p, π: 30ε. The geometry itself, breakpoints and lengths within an ulp, moves t by at most
//! 2ε(r + 2D) ≤ 4.4 ε r, against |t| ≥ 0.4 r ([`MAX_SIZE_OVER_DISTANCE`]): 44ε in 1/|t|^4, and 8ε in the numerator. Together
//! ([`ROUNDINGS`] + [`ROUNDINGS_PER_ORDER`] K + (K+1)²)ε.

use super::reduced_pair::{AxisDensity, ReducedPair};
use std::f64::consts::FRAC_1_PI;

/// The highest order is 2·`MAX_HALF_ORDER`.
pub(super) const MAX_HALF_ORDER: usize = 8;
const ORDER_COUNT: usize = MAX_HALF_ORDER + 1;
/// D/r of the pairs that are expanded: |t| ≥ (1 − `MAX_SIZE_OVER_DISTANCE`) r everywhere.
pub(super) const MAX_SIZE_OVER_DISTANCE: f64 = 0.6;
/// Smallest tolerance above the rounding of the series.
pub(super) const MIN_TOLERANCE: f64 = 5e-13;
/// Unit roundoff 2⁻⁵³.
const UNIT_ROUNDOFF: f64 = 0.5 * f64::EPSILON;
/// Roundings of every monomial, see above: 30 + 44 + 8, and 20 that do not grow with the order.
pub(super) const ROUNDINGS: f64 = 120.0; // bound
/// Roundings per order: powers, moments, (λ)_j.
pub(super) const ROUNDINGS_PER_ORDER: f64 = 20.0; // bound
/// Allowance for the rounding of the bounds themselves.
const BOUND_ROUNDING: f64 = 1.000_001;

const fn factorial(n: usize) -> f64 {
    let (mut f, mut i) = (1.0, 2);
    while i <= n {
        f *= i as f64;
        i += 1;
    }
    f
}

/// The numbers before μ_{2k} s^k (sc²)^i for p = 0 and 1.
const HERMITE_COEFFICIENTS: [[[f64; ORDER_COUNT]; ORDER_COUNT]; 2] = {
    let mut table = [[[0.0; ORDER_COUNT]; ORDER_COUNT]; 2];
    let mut k = 0;
    while k < ORDER_COUNT {
        let (mut i, mut four) = (0, if k % 2 == 0 { 1.0 } else { -1.0 });
        while i <= k {
            table[0][k][i] = four / (factorial(2 * i) * factorial(k - i));
            table[1][k][i] = four * (2 * k + 1) as f64 / (factorial(2 * i + 1) * factorial(k - i));
            four *= -4.0;
            i += 1;
        }
        k += 1;
    }
    table
};

/// (λ)_j for λ = 1, 3/2, 2.
const RISING_FACTORIALS: [[f64; 2 * MAX_HALF_ORDER + 1]; 3] = {
    let mut table = [[1.0; 2 * MAX_HALF_ORDER + 1]; 3];
    let mut m = 0;
    while m < 3 {
        let mut j = 1;
        while j <= 2 * MAX_HALF_ORDER {
            table[m][j] = table[m][j - 1] * (0.5 * (2 + m) as f64 + (j - 1) as f64);
            j += 1;
        }
        m += 1;
    }
    table
};

/// b_n = binom(n + 2λ − 1, n) with 2λ = 2 + m: the largest modulus of C_n^λ.
fn gegenbauer_bound(m: i32, n: usize) -> f64 {
    let n = n as f64;
    match m {
        0 => n + 1.0,                                 // bound
        1 => (n + 1.0) * (n + 2.0) / 2.0,             // bound
        _ => (n + 1.0) * (n + 2.0) * (n + 3.0) / 6.0, // bound
    }
}

/// G_n, the coefficients of (1 − 2p − p²)^{−λ}, by n G_n = 2(n−1+λ) G_{n−1} + (n−2+2λ) G_{n−2}.
fn absolute_sums(m: i32) -> [f64; 2 * MAX_HALF_ORDER + 1] {
    let lambda = 0.5 * (2 + m) as f64;
    let mut g = [1.0; 2 * MAX_HALF_ORDER + 1];
    g[1] = 2.0 * lambda;
    for n in 2..=2 * MAX_HALF_ORDER {
        let k = n as f64;
        g[n] = (2.0 * (k - 1.0 + lambda) * g[n - 1] + (k - 2.0 + 2.0 * lambda) * g[n - 2]) / k;
    }
    g
}

/// The constants of all pairs of the same two boxes, for any offset; lengths in units of `unit`.
#[derive(Clone, Debug)]
pub(super) struct BoxPairMoments {
    power: [i32; 3],
    patches: i32,
    /// Half of the width of t's density, units.
    half: [f64; 3],
    /// D² = Σ h².
    reach2: f64,
    /// A power of two near D, m.
    unit: f64,
    /// Mass of the density over π, in m to the number of axes that are not fixed, over unit².
    front: f64,
    /// `HERMITE_COEFFICIENTS` times μ_{2k}.
    axis: [[[f64; ORDER_COUNT]; ORDER_COUNT]; 3],
    /// For the order n = 2K + 2: b_n M_n, b_{n−1} M_{n−1}, b_{n−2} M_{n−2}.
    next: [[f64; 3]; ORDER_COUNT],
    /// For the order n = 2K: the same with G, times the count of roundings.
    noise: [[f64; 3]; ORDER_COUNT],
    /// b_{2K+2}/b_{2K} D².
    shrink: [f64; ORDER_COUNT],
}

/// μ_{2k} for k ≤ `MAX_HALF_ORDER` + 1 of the sum of two uniforms of widths `a` and `b`.
fn even_moments(a: f64, b: f64) -> [f64; ORDER_COUNT + 1] {
    let uniform = |width: f64| {
        let (square, mut term) = (0.25 * width * width, 1.0);
        let mut out = [1.0; ORDER_COUNT + 1];
        for k in 1..=ORDER_COUNT {
            // (width/2)^{2k} / (2k+1)!.
            term *= square / ((2 * k) as f64 * (2 * k + 1) as f64);
            out[k] = term;
        }
        out
    };
    let (x, y) = (uniform(a), uniform(b));
    std::array::from_fn(|k| factorial(2 * k) * (0..=k).map(|j| x[j] * y[k - j]).sum::<f64>())
}

/// E|δ|^{2K} for K ≤ `MAX_HALF_ORDER` + 1.
fn absolute_moments(moments: &[[f64; ORDER_COUNT + 1]; 3]) -> [f64; ORDER_COUNT + 1] {
    let scaled = moments.map(|m| std::array::from_fn::<f64, { ORDER_COUNT + 1 }, _>(|k| m[k] / factorial(k)));
    let fold = |a: &[f64; ORDER_COUNT + 1], b: &[f64; ORDER_COUNT + 1]| {
        std::array::from_fn::<f64, { ORDER_COUNT + 1 }, _>(|k| (0..=k).map(|j| a[j] * b[k - j]).sum())
    };
    let all = fold(&fold(&scaled[0], &scaled[1]), &scaled[2]);
    std::array::from_fn(|k| all[k] * factorial(k))
}

impl BoxPairMoments {
    /// Constants of two boxes with these extents on each axis (long, short), m; both zero where t is fixed, one where a patch is flat.
    pub(super) fn new(extents: [(f64, f64); 3]) -> BoxPairMoments {
        let power = extents.map(|(a, b)| (a == 0.0) as i32 + (b == 0.0) as i32);
        let patches: i32 = power.iter().sum();
        let metres = extents.map(|(a, b)| 0.5 * (a + b));
        let longest = metres.iter().copied().fold(0.0, f64::max);
        let unit = f64::from_bits(longest.to_bits() & !((1 << 52) - 1));
        let half = metres.map(|h| h / unit);
        let mass: f64 = extents.iter().flat_map(|&(a, b)| [a, b]).filter(|&x| x > 0.0).product();
        let moments = extents.map(|(a, b)| even_moments(a / unit, b / unit));
        let reach2 = half.iter().map(|h| h * h).sum();
        let m = absolute_moments(&moments);
        let g = absolute_sums(patches);
        // E|δ|^n, the odd ones by Cauchy and Schwarz.
        let mean = |n: usize| if n.is_multiple_of(2) { m[n / 2] } else { (m[n / 2] * m[n / 2 + 1]).sqrt() };
        let b = |n: usize| gegenbauer_bound(patches, n);
        let three = |n: usize, f: &dyn Fn(usize) -> f64| {
            std::array::from_fn(|i| if n >= i { BOUND_ROUNDING * f(n - i) * mean(n - i) } else { 0.0 })
        };
        BoxPairMoments {
            power,
            patches,
            half,
            reach2,
            unit,
            front: mass * FRAC_1_PI / (unit * unit),
            axis: std::array::from_fn(|x| {
                let table = &HERMITE_COEFFICIENTS[(power[x] == 1) as usize];
                std::array::from_fn(|k| table[k].map(|h| h * moments[x][k]))
            }),
            next: std::array::from_fn(|k| three(2 * k + 2, &b)),
            noise: std::array::from_fn(|k| {
                let count = ROUNDINGS + ROUNDINGS_PER_ORDER * k as f64 + ((k + 1) * (k + 1)) as f64;
                three(2 * k, &|n| UNIT_ROUNDOFF * count * g[n])
            }),
            shrink: std::array::from_fn(|k| BOUND_ROUNDING * reach2 * b(2 * k + 4) / b(2 * k + 2)),
        }
    }

    /// Constants of a pair.
    pub(super) fn of(pair: &ReducedPair) -> BoxPairMoments {
        BoxPairMoments::new(pair.0.map(|a| (a.long, a.short)))
    }

    /// D/`MAX_SIZE_OVER_DISTANCE`, m: the series applies to centres farther apart.
    pub(super) fn least_distance(&self) -> f64 {
        self.unit * self.reach2.sqrt() / MAX_SIZE_OVER_DISTANCE
    }
}

/// The centre offset of a pair.
pub(super) fn centre_offset(pair: &ReducedPair) -> [f64; 3] {
    pair.0.map(|AxisDensity { p, .. }| 0.5 * (p[0] + p[3]))
}

/// Centre offsets prepared for the series, `N` side by side.
#[derive(Clone, Copy)]
pub(super) struct FarPairs<const N: usize> {
    /// c_k²/r².
    share: [[f64; N]; 3],
    /// 1/r², in units.
    w: [f64; N],
    /// Π c^p / r^{2λ} · W/π: the order zero.
    lead: [f64; N],
    /// r e₁ and r² e₂.
    y: [[f64; N]; 2],
    served: [bool; N],
}

impl<const N: usize> FarPairs<N> {
    #[inline(always)]
    pub(super) fn new(shape: &BoxPairMoments, centre: &[[f64; N]; 3]) -> FarPairs<N> {
        let per = 1.0 / shape.unit;
        let (mut w, mut lead, mut y) = ([0.0; N], [0.0; N], [[0.0; N]; 2]);
        let mut share = [[0.0; N]; 3];
        let mut served = [false; N];
        for l in 0..N {
            let c = [centre[0][l] * per, centre[1][l] * per, centre[2][l] * per];
            let squares = [c[0] * c[0], c[1] * c[1], c[2] * c[2]];
            let r2 = squares[0] + squares[1] + squares[2];
            w[l] = 1.0 / r2;
            let (mut front, mut first, mut second, mut ahead) = (shape.front * w[l], 0.0, 1.0, true);
            for k in 0..3 {
                share[k][l] = squares[k] * w[l];
                if shape.power[k] == 1 {
                    front *= c[k];
                    let e = shape.half[k] / c[k];
                    first += e;
                    second *= e;
                    ahead &= e > 0.0 && e < 1.0 + 1e-9;
                } else if shape.power[k] == 2 {
                    front *= squares[k];
                }
            }
            lead[l] = match shape.patches {
                0 => front,
                1 => front * w[l].sqrt(),
                _ => front * w[l],
            };
            let fixed = shape.power[0] == 2 || shape.power[1] == 2 || shape.power[2] == 2;
            y[0][l] = first * r2.sqrt();
            y[1][l] = if shape.patches == 2 && !fixed { second * r2 } else { 0.0 };
            served[l] = ahead && shape.reach2 * w[l] <= MAX_SIZE_OVER_DISTANCE * MAX_SIZE_OVER_DISTANCE;
        }
        FarPairs { share, w, lead, y, served }
    }

    /// Bound of all orders above 2K, relative to the order zero; infinite where the series does not apply.
    #[inline(always)]
    pub(super) fn truncation(&self, shape: &BoxPairMoments, order: usize) -> [f64; N] {
        let mut out = [f64::INFINITY; N];
        let [a, b, c] = shape.next[order];
        for l in 0..N {
            let mut power = self.w[l];
            for _ in 0..order {
                power *= self.w[l];
            }
            let beta = power * (a + self.y[0][l] * b + self.y[1][l] * c);
            let g = shape.shrink[order] * self.w[l];
            out[l] = if self.served[l] && g < 0.9 { beta / (1.0 - g) } else { f64::INFINITY };
        }
        out
    }

    /// The rounding of the series up to the order 2K, relative to the order zero.
    #[inline(always)]
    pub(super) fn noise(&self, shape: &BoxPairMoments, order: usize) -> [f64; N] {
        let mut out = [0.0; N];
        for k in (0..=order).rev() {
            let [a, b, c] = shape.noise[k];
            for l in 0..N {
                out[l] = out[l] * self.w[l] + (a + self.y[0][l] * b + self.y[1][l] * c);
            }
        }
        out
    }

    /// Values up to the order 2K and their radii, given the truncation.
    #[inline(always)]
    pub(super) fn finish(
        &self,
        shape: &BoxPairMoments,
        order: usize,
        truncation: &[f64; N],
    ) -> ([f64; N], [f64; N]) {
        let sum = self.series(shape, order);
        let noise = self.noise(shape, order);
        let (mut value, mut radius) = ([0.0; N], [0.0; N]);
        for l in 0..N {
            value[l] = self.lead[l] * sum[l];
            radius[l] = self.lead[l] * (truncation[l] + noise[l]) * BOUND_ROUNDING;
        }
        (value, radius)
    }

    #[inline(always)]
    fn series(&self, shape: &BoxPairMoments, order: usize) -> [f64; N] {
        match order {
            0 => [1.0; N],
            1 => self.sum::<2>(shape),
            2 => self.sum::<3>(shape),
            3 => self.sum::<4>(shape),
            4 => self.sum::<5>(shape),
            5 => self.sum::<6>(shape),
            6 => self.sum::<7>(shape),
            7 => self.sum::<8>(shape),
            _ => self.sum::<9>(shape),
        }
    }

    /// The series relative to its order zero, C orders.
    #[inline(always)]
    fn sum<const C: usize>(&self, shape: &BoxPairMoments) -> [f64; N] {
        let [x, y, z] = [0, 1, 2].map(|k| self.axis::<C>(shape, k));
        // The product of two axes: by order and by the power of c².
        let mut plane = [[[0.0; N]; C]; C];
        for k1 in 0..C {
            for i1 in 0..=k1 {
                for k2 in 0..C - k1 {
                    for i2 in 0..=k2 {
                        for l in 0..N {
                            plane[k1 + k2][i1 + i2][l] += x[k1][i1][l] * y[k2][i2][l];
                        }
                    }
                }
            }
        }
        let rising = &RISING_FACTORIALS[shape.patches as usize];
        let mut total = [0.0; N];
        for k in (0..C).rev() {
            let mut powers = [[0.0; N]; C];
            for k1 in 0..=k {
                for i1 in 0..=k1 {
                    for i2 in 0..=k - k1 {
                        for l in 0..N {
                            powers[i1 + i2][l] += z[k1][i1][l] * plane[k - k1][i2][l];
                        }
                    }
                }
            }
            for l in 0..N {
                total[l] *= self.w[l];
            }
            for j in 0..=k {
                for l in 0..N {
                    total[l] += rising[k + j] * powers[j][l];
                }
            }
        }
        total
    }

    #[inline(always)]
    fn axis<const C: usize>(&self, shape: &BoxPairMoments, axis: usize) -> [[[f64; N]; C]; C] {
        let mut out = [[[0.0; N]; C]; C];
        let mut power = [[1.0; N]; C];
        for i in 1..C {
            for l in 0..N {
                power[i][l] = power[i - 1][l] * self.share[axis][l];
            }
        }
        for k in 0..C {
            for i in 0..=k {
                for l in 0..N {
                    out[k][i][l] = shape.axis[axis][k][i] * power[i][l];
                }
            }
        }
        out
    }
}

/// The lowest order whose truncation is within the relative `budget` in all lanes, with the truncation.
#[inline(always)]
pub(super) fn order<const N: usize>(
    shape: &BoxPairMoments,
    far: &FarPairs<N>,
    budget: f64,
) -> Option<(usize, [f64; N])> {
    for order in 0..=MAX_HALF_ORDER {
        let truncation = far.truncation(shape, order);
        if truncation.iter().all(|t| *t <= budget) {
            return Some((order, truncation));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gegenbauer_bound_equals_value_at_one() {
        // C_n^λ(1) by the recurrence n C_n = 2(n−1+λ) C_{n−1} − (n−2+2λ) C_{n−2}.
        for m in 0..3 {
            let lambda = 0.5 * (2 + m) as f64;
            let (mut before, mut now) = (1.0, 2.0 * lambda);
            assert_eq!(gegenbauer_bound(m, 0), before);
            for n in 1..=2 * MAX_HALF_ORDER + 4 {
                assert!((gegenbauer_bound(m, n) / now - 1.0).abs() < 1e-12, "{m} {n}");
                let k = (n + 1) as f64;
                (before, now) =
                    (now, (2.0 * (k - 1.0 + lambda) * now - (k - 2.0 + 2.0 * lambda) * before) / k);
            }
        }
    }

    #[test]
    fn even_moments_of_two_uniform_densities() {
        // a = 2, b = 1: E δ² = a²/12 + b²/12, E δ⁴ = a⁴/80 + b⁴/80 + 6 a²b²/144.
        let m = even_moments(2.0, 1.0);
        assert!((m[1] - 5.0 / 12.0).abs() < 1e-16);
        assert!((m[2] - (17.0 / 80.0 + 1.0 / 6.0)).abs() < 1e-16);
        // Of the unit triangle 2/((2k+1)(2k+2)).
        let m = even_moments(1.0, 1.0);
        for k in 0..=ORDER_COUNT {
            assert!((m[k] * ((2 * k + 1) * (k + 1)) as f64 - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn truncation_bounds_higher_orders() {
        for (extents, c) in [
            ([(1.0, 1.0); 3], [3.0, 1.0, 0.0]),
            ([(1.0, 0.2), (2.0, 1.0), (0.5, 0.5)], [1.0, 4.0, 2.0]),
            ([(1.0, 0.0), (1.0, 1.0), (0.3, 0.1)], [0.5, 3.0, 1.0]),
            ([(1.0, 0.0), (1.0, 0.0), (1.0, 1.0)], [0.5, 0.5, 4.0]),
            ([(0.0, 0.0), (1.0, 0.7), (1.0, 1.0)], [0.1, 2.0, 4.0]),
        ] {
            let shape = BoxPairMoments::new(extents);
            let far = FarPairs::new(&shape, &c.map(|x| [x]));
            let all = far.finish(&shape, MAX_HALF_ORDER, &[0.0]).0[0];
            for order in 0..MAX_HALF_ORDER - 1 {
                let t = far.truncation(&shape, order);
                let (value, radius) = far.finish(&shape, order, &t);
                assert!(t[0].is_finite() && t[0] < 10.0);
                let beyond = far.lead[0] * far.truncation(&shape, MAX_HALF_ORDER)[0];
                assert!((value[0] - all).abs() <= radius[0] + beyond, "{extents:?} {order}");
            }
        }
    }

    #[test]
    fn rounding_constants_cover_their_counts() {
        let (value, geometry, once) = (30.0, 44.0 + 8.0, 6.0 + 9.0 + 5.0);
        assert!(ROUNDINGS >= value + geometry + once);
        let (shares, moments, distance, rising) = (7.0, 5.0, 6.0, 2.0);
        assert!(ROUNDINGS_PER_ORDER >= shares + moments + distance + rising);
    }
}
