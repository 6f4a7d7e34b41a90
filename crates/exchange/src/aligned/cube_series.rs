//! Far pairs of equal cubes on a lattice: the moments' series as polynomials in two invariants.
//!
//! With edge h, offset c, r = |c| and x, y, z = c_k²/r², the order 2K of `moment_series.rs` (λ = 1) is (h/r)^{2K} S_K(x, y, z), S_K symmetric. Since
//! x + y + z = 1 it is a polynomial in e₂ = xy + yz + zx ≤ 1/3 and e₃ = xyz ≤ 1/27:
//!
//! ```text
//! π𝓕 = (h⁶/r²) Σ_K (h/r)^{2K} Σ_{2a+3b≤K} s_{Kab} e₂^a e₃^b,        S_0 = 1, S_1 = 1/6, …
//! ```
//!
//! The s_{Kab} follow from Hermite's coefficients and the triangle's moments 2/((2k+1)(2k+2)): the coefficient of x^i y^j z^l (i ≥ j ≥ l) is
//! summed, and leading monomials are replaced by e₁^{i−j} e₂^{j−l} e₃^l, highest first. The constants are computed once in double-double
//! arithmetic: cancellation
//! takes fewer than 12 of 32 digits, and each constant is rounded once.
//!
//! **Truncation.** |S_K| ≤ σ_K = Σ |s_{Kab}| 3^{−a} 27^{−b}; so the orders above K leave at most Σ_{K<j≤`MAX_HALF_ORDER`} σ_j (h/r)^{2j} and
//! beyond `MAX_HALF_ORDER`
//! the bound of `moment_series.rs`: β/(1 − g) with n = 2·`MAX_HALF_ORDER` + 2, b_n = n + 1 and the exact E|δ|^n.
//!
//! **Rounding.** As in `moment_series.rs`, 90ε for the order zero and the geometry. x, y, z carry 6ε, e₂ and e₃ 15ε and 20ε, their
//! powers at most 8Kε, r^{−2K} 6Kε, additions at most 2Kε + 8ε: ([`ROUNDINGS`] + [`ROUNDINGS_PER_ORDER`] K)ε of σ_K (h/r)^{2K}.

use super::moment_series::{MAX_SIZE_OVER_DISTANCE, ROUNDINGS, ROUNDINGS_PER_ORDER};
use std::f64::consts::FRAC_1_PI;
use std::sync::OnceLock;
use zonal_math::double_double::DoubleDouble;

/// The highest order is 2·`MAX_HALF_ORDER`.
pub(super) const MAX_HALF_ORDER: usize = 12;
/// Unit roundoff 2⁻⁵³.
const UNIT_ROUNDOFF: f64 = 0.5 * f64::EPSILON;
const BOUND_ROUNDING: f64 = 1.000_001;

/// The series' constants, for the unit cube.
#[derive(Debug)]
pub(super) struct CubeSeries {
    /// s_{Kab} at [K][b][a].
    terms: [[[f64; MAX_HALF_ORDER / 2 + 1]; MAX_HALF_ORDER / 3 + 1]; MAX_HALF_ORDER + 1],
    /// σ_K.
    sup: [f64; MAX_HALF_ORDER + 1],
    /// b_n E|δ|^n for n = 2·`MAX_HALF_ORDER` + 2, and g r².
    beyond: [f64; 2],
}

fn double_double(x: f64) -> DoubleDouble {
    DoubleDouble::new(x)
}

/// n!, exact in a pair up to 33!.
fn factorial(n: usize) -> DoubleDouble {
    (2..=n).fold(double_double(1.0), |f, i| f.mul(double_double(i as f64)))
}

/// E δ^{2k} = 2/((2k+1)(2k+2)) of the triangle on [−1, 1].
fn moment(k: usize) -> DoubleDouble {
    double_double(1.0).div(double_double(((2 * k + 1) * (k + 1)) as f64))
}

/// μ_{2k} (−1)^k (−4)^i / ((2i)! (k−i)!).
fn hermite(k: usize, i: usize) -> DoubleDouble {
    let sign = if (k + i).is_multiple_of(2) { 1.0 } else { -1.0 };
    let top = double_double(sign * 4f64.powi(i as i32)).mul(moment(k));
    top.div(factorial(2 * i).mul(factorial(k - i)))
}

/// Coefficients of x^i y^j z^l in all of S_K, by [i][j][l]; only i ≥ j ≥ l are set.
type MonomialCoefficients = Vec<Vec<Vec<DoubleDouble>>>;

fn monomials(order: usize, table: &[Vec<DoubleDouble>]) -> MonomialCoefficients {
    let zero = double_double(0.0);
    let mut out = vec![vec![vec![zero; order + 1]; order + 1]; order + 1];
    for i in 0..=order {
        for j in 0..=i.min(order - i) {
            for l in 0..=j.min(order - i - j) {
                let mut sum = zero;
                for k1 in i..=order {
                    for k2 in j..=order - k1 {
                        let k3 = order - k1 - k2;
                        if k3 >= l {
                            sum = sum.add(table[k1][i].mul(table[k2][j]).mul(table[k3][l]));
                        }
                    }
                }
                out[i][j][l] = sum.mul(factorial(order + i + j + l));
            }
        }
    }
    out
}

/// e₁^p e₂^q e₃^r as monomials (i, j, l), i ≥ j ≥ l, with their coefficients.
fn elementary_symmetric_product(p: usize, q: usize, r: usize) -> Vec<([usize; 3], f64)> {
    let mut poly = std::collections::BTreeMap::from([([r, r, r], 1.0)]);
    let mut times = |factor: [[usize; 3]; 3]| {
        let mut next = std::collections::BTreeMap::new();
        for (m, c) in &poly {
            for f in factor {
                *next.entry([m[0] + f[0], m[1] + f[1], m[2] + f[2]]).or_insert(0.0) += c;
            }
        }
        poly = next;
    };
    (0..p).for_each(|_| times([[1, 0, 0], [0, 1, 0], [0, 0, 1]]));
    (0..q).for_each(|_| times([[1, 1, 0], [0, 1, 1], [1, 0, 1]]));
    poly.into_iter().filter(|(m, _)| m[0] >= m[1] && m[1] >= m[2]).collect()
}

/// s_{Kab} at [b][a] of one order.
fn reduce_to_elementary(
    mut left: MonomialCoefficients,
    order: usize,
) -> [[f64; MAX_HALF_ORDER / 2 + 1]; MAX_HALF_ORDER / 3 + 1] {
    let mut sums = [[double_double(0.0); MAX_HALF_ORDER / 2 + 1]; MAX_HALF_ORDER / 3 + 1];
    for i in (0..=order).rev() {
        for j in (0..=i.min(order - i)).rev() {
            for l in (0..=j.min(order - i - j)).rev() {
                let lead = left[i][j][l];
                for (m, c) in elementary_symmetric_product(i - j, j - l, l) {
                    let place = &mut left[m[0]][m[1]][m[2]];
                    *place = place.sub(lead.mul(double_double(c)));
                }
                sums[l][j - l] = sums[l][j - l].add(lead);
            }
        }
    }
    sums.map(|row| row.map(|s| s.hi))
}

/// The constants, computed once.
pub(super) fn constants() -> &'static CubeSeries {
    static SERIES: OnceLock<CubeSeries> = OnceLock::new();
    SERIES.get_or_init(CubeSeries::new)
}

impl CubeSeries {
    fn new() -> CubeSeries {
        let table: Vec<Vec<DoubleDouble>> =
            (0..=MAX_HALF_ORDER).map(|k| (0..=k).map(|i| hermite(k, i)).collect()).collect();
        let terms: [_; MAX_HALF_ORDER + 1] =
            std::array::from_fn(|k| reduce_to_elementary(monomials(k, &table), k));
        let sup = terms.map(|t: [[f64; MAX_HALF_ORDER / 2 + 1]; MAX_HALF_ORDER / 3 + 1]| {
            let of = |b: usize, a: usize| t[b][a].abs() / 3f64.powi(a as i32) / 27f64.powi(b as i32);
            BOUND_ROUNDING
                * (0..=MAX_HALF_ORDER / 3)
                    .flat_map(|b| (0..=MAX_HALF_ORDER / 2).map(move |a| of(b, a)))
                    .sum::<f64>()
        });
        let n = (2 * MAX_HALF_ORDER + 2) as f64;
        let beyond = [
            BOUND_ROUNDING * (n + 1.0) * absolute_moment(MAX_HALF_ORDER + 1),
            BOUND_ROUNDING * 3.0 * (n + 3.0) / (n + 1.0),
        ];
        CubeSeries { terms, sup, beyond }
    }

    /// Bound of the orders above K, relative to the order zero, at (h/r)² = `u` ≤ MAX_SIZE_OVER_DISTANCE²/3.
    #[inline(always)]
    pub(super) fn truncation<const N: usize>(&self, order: usize, u: &[f64; N]) -> [f64; N] {
        // The order `MAX_HALF_ORDER` + 1 has one factor u more than the loops below multiply, which are `MAX_HALF_ORDER` in all.
        let mut left = [0.0; N];
        for l in 0..N {
            left[l] = BOUND_ROUNDING * self.beyond[0] * u[l] / (1.0 - self.beyond[1] * u[l]);
        }
        for k in (order + 1..=MAX_HALF_ORDER).rev() {
            for l in 0..N {
                left[l] = (left[l] + BOUND_ROUNDING * self.sup[k]) * u[l];
            }
        }
        for _ in 0..order {
            for l in 0..N {
                left[l] *= u[l];
            }
        }
        left
    }

    /// The lowest order whose truncation at `u` is within `budget`: the first neglected term gives the order to start from.
    #[inline(always)]
    pub(super) fn order(&self, u: f64, budget: f64) -> Option<usize> {
        if u * 3.0 > MAX_SIZE_OVER_DISTANCE * MAX_SIZE_OVER_DISTANCE {
            return None;
        }
        let (mut k, mut power) = (0, u);
        while k < MAX_HALF_ORDER && self.sup[k + 1] * power > budget {
            (k, power) = (k + 1, power * u);
        }
        (k..=MAX_HALF_ORDER).find(|&k| self.truncation(k, &[u])[0] <= budget)
    }

    /// Values and radii of cubes with edge `h` (m) at centre offsets `c` (m), up to the order 2K.
    #[inline(always)]
    pub(super) fn factors<const N: usize>(
        &self,
        order: usize,
        h: f64,
        c: &[[f64; N]; 3],
    ) -> ([f64; N], [f64; N]) {
        let (mut e2, mut e3, mut u, mut lead) = ([0.0; N], [0.0; N], [0.0; N], [0.0; N]);
        let (h2, front) = (h * h, h * h * h * h * h * h * FRAC_1_PI);
        for l in 0..N {
            let (x, y, z) = (c[0][l] * c[0][l], c[1][l] * c[1][l], c[2][l] * c[2][l]);
            let w = 1.0 / (x + y + z);
            let (x, y, z) = (x * w, y * w, z * w);
            e2[l] = x * y + z * (x + y);
            e3[l] = x * y * z;
            u[l] = h2 * w;
            lead[l] = front * w;
        }
        let (mut sum, mut noise) = ([0.0; N], [0.0; N]);
        for k in (0..=order).rev() {
            let s = self.term(k, &e2, &e3);
            let rounding = UNIT_ROUNDOFF * (ROUNDINGS + ROUNDINGS_PER_ORDER * k as f64) * self.sup[k];
            for l in 0..N {
                sum[l] = sum[l] * u[l] + s[l];
                noise[l] = noise[l] * u[l] + rounding;
            }
        }
        let truncation = self.truncation(order, &u);
        let (mut value, mut radius) = ([0.0; N], [0.0; N]);
        for l in 0..N {
            value[l] = lead[l] * sum[l];
            radius[l] = lead[l] * (truncation[l] + noise[l]) * BOUND_ROUNDING;
        }
        (value, radius)
    }

    /// S_K.
    #[inline(always)]
    fn term<const N: usize>(&self, k: usize, e2: &[f64; N], e3: &[f64; N]) -> [f64; N] {
        let mut out = [0.0; N];
        for b in (0..=k / 3).rev() {
            let mut row = [0.0; N];
            for a in (0..=(k - 3 * b) / 2).rev() {
                for l in 0..N {
                    row[l] = row[l] * e2[l] + self.terms[k][b][a];
                }
            }
            for l in 0..N {
                out[l] = out[l] * e3[l] + row[l];
            }
        }
        out
    }
}

/// E|δ|^{2K} of the unit cube's density.
fn absolute_moment(order: usize) -> f64 {
    let part = |k: usize| moment(k).div(factorial(k));
    let mut sum = double_double(0.0);
    for i in 0..=order {
        for j in 0..=order - i {
            sum = sum.add(part(i).mul(part(j)).mul(part(order - i - j)));
        }
    }
    sum.mul(factorial(order)).hi
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aligned::moment_series::{self, BoxPairMoments, FarPairs};

    #[test]
    fn cube_series_first_coefficients() {
        let cube = CubeSeries::new();
        assert_eq!(cube.terms[0][0][0], 1.0);
        // THEORY.md section 3: 1/r² + ℓ²/(6 r⁴).
        assert!((cube.terms[1][0][0] - 1.0 / 6.0).abs() < 1e-17);
    }

    #[test]
    fn sigma_bounds_the_polynomials() {
        let cube = constants();
        for i in 0..=20 {
            for j in 0..=20 - i {
                let (x, y) = (i as f64 / 20.0, j as f64 / 20.0);
                let z = 1.0 - x - y;
                let (e2, e3) = (x * y + y * z + z * x, x * y * z);
                // The orders 0 and 1 are constants: there the bound is met.
                for k in 0..=MAX_HALF_ORDER {
                    let s = cube.term(k, &[e2], &[e3])[0];
                    assert!(s.abs() <= cube.sup[k], "{k} at {x} {y}: {s}");
                }
            }
        }
    }

    #[test]
    fn remainder_beyond_highest_order_is_geometric() {
        // E|δ|² = 1/2, E|δ|⁴ = 3/15 + 6/36.
        assert!((absolute_moment(1) - 0.5).abs() < 1e-15 && (absolute_moment(2) - 11.0 / 30.0).abs() < 1e-15);
        let cube = constants();
        let n = (2 * MAX_HALF_ORDER + 2) as f64;
        assert!(
            cube.beyond[0] >= (n + 1.0) * absolute_moment(MAX_HALF_ORDER + 1)
                && cube.beyond[1] >= 3.0 * (n + 3.0) / (n + 1.0)
        );
        // Geometric: with nothing but the part beyond `MAX_HALF_ORDER`, one factor u for each order.
        let u: f64 = 0.1;
        let left = cube.beyond[0] * u.powi(MAX_HALF_ORDER as i32 + 1) / (1.0 - cube.beyond[1] * u);
        assert!((cube.truncation(MAX_HALF_ORDER, &[u])[0] / left - 1.0).abs() < 1e-5);
    }

    #[test]
    fn cube_polynomials_equal_general_moment_series() {
        let shape = BoxPairMoments::new([(1.0, 1.0); 3]);
        let cube = constants();
        for c in [[3.0, 0.0, 0.0], [3.0, 3.0, 3.0], [5.0, 2.0, 1.0], [4.0, 4.0, 0.0], [9.0, 8.0, 3.0]] {
            let far = FarPairs::new(&shape, &c.map(|x| [x]));
            for order in 0..=moment_series::MAX_HALF_ORDER {
                let (general, _) = far.finish(&shape, order, &[0.0]);
                let (value, _) = cube.factors(order, 1.0, &c.map(|x| [x]));
                assert!((value[0] / general[0] - 1.0).abs() < 1e-14, "{c:?} {order}: {value:?} {general:?}");
            }
        }
    }
}
