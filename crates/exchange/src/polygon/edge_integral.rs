//! J = ∬ ln r ds dt over two straight edges, s and t in [0, 1]: Gauss rules for separated edges, closed forms for near ones.
//!
//! **Gauss.** Along an edge of length ℓ the distance of a point y has ln r = const − Σ_{k≥1} (2/k) Re(w^{−k}) T_k (the generating function
//! of Chebyshev's polynomials), where w + 1/w = 2z and z is the complex zero of r², which lies as far from the ends ±1 as y from the
//! edge's ends, in half-lengths. So |w| = ϱ with ½(ϱ + 1/ϱ) = (d₁ + d₂)/ℓ, the distances d of y from the two ends. The n-point rule is
//! exact below degree 2n, gives each T_k at most 1 and the integral of an even one is −1/(k² − 1), of an odd one 0. Hence, for the mean over the
//! edge,
//!
//! ```text
//! |error| ≤ Σ_{k = 2n, 2n+2, …} (2/k) ϱ^{−k} (1 + 1/(k² − 1)) ≤ (1/n) (1 + 1/(4n² − 1)) ϱ^{−2n}/(1 − ϱ^{−2}).
//! ```
//!
//! ϱ belongs to the least d₁ + d₂ of all y on the other edge. The sum is convex along it, so the tangents at the two ends bound it from
//! below. The errors of the two directions add, the weights being positive.
//!
//! **Product of four.** The weights of the rules are symmetric: the four points (±, ±) have equal weights, so one logarithm of
//! the product of four squared distances suffices.
//!
//! **Rounding.** The three components of P(s) − Q(t) err by 4ε (|p| + ℓ_u + ℓ_v) = 4εR, ln r by 8εR/D, D the least distance, at least
//! (½(ϱ + 1/ϱ) − 1) ℓ/2; the product, its logarithm, weights and sums by less than 64ε (1 + max |ln r|).
//!
//! Edges too near for [`MAX_EDGE_POINTS`] take the closed form ([`super::edge_closed_form`]); where its error is too large (nearly parallel and
//! close)
//! the longer edge is halved, J being the mean of the halves' values.

use super::edge_closed_form;
use super::segment::{ContourEdge, EdgeIntegral};
use std::sync::OnceLock;
use zonal_math::simd::ln;
use zonal_math::{Vec3, gauss_legendre, simd};

/// Unit roundoff 2⁻⁵³.
const UNIT_ROUNDOFF: f64 = 0.5 * f64::EPSILON;
/// Points along an edge, at most; with more the closed form is cheaper.
const MAX_EDGE_POINTS: usize = 20;
/// Lanes of the sums.
const LANES: usize = 8;
/// Roundings of the least sum of distances, relative to the lengths that enter it (about twenty are made).
const DISTANCE_SUM_SLACK: f64 = 64.0 * UNIT_ROUNDOFF;
/// Roundings of a Gauss sum, relative to 1 + max |ln r| (header).
const SUM_ROUNDINGS: f64 = 64.0; // bound
/// Roundings of ln r by the edges' differences, relative to R/D.
const PLACE_ROUNDINGS: f64 = 8.0; // bound
/// Closed forms per pair of edges, at most; the remaining parts keep the error of their closed form.
const MAX_CLOSED_FORMS: u32 = 200;
/// Errors of J below do not justify halving an edge.
const MIN_USEFUL_ERROR: f64 = 4e-14;

/// Lower bound of ½(ϱ + 1/ϱ) = (d₁ + d₂)/ℓ for an edge of that `length`, by the tangents.
///
/// `sums`: d₁ + d₂ at the two ends of the `other` edge (its length); `slopes`: their derivatives along it.
#[inline(always)]
fn ellipse_axis(sums: [f64; 2], slopes: [f64; 2], length: f64, other: f64) -> f64 {
    let least = if slopes[0] >= 0.0 {
        sums[0]
    } else if slopes[1] <= 0.0 {
        sums[1]
    } else {
        // A NaN slope (an end on the other edge) gives NaN here and rejects the rule.
        let t = (sums[1] - slopes[1] - sums[0]) / (slopes[0] - slopes[1]);
        sums[0] + slopes[0] * t
    };
    (least - DISTANCE_SUM_SLACK * (sums[0] + sums[1] + other)) / length
}

/// ½(ϱ + 1/ϱ) of the ellipses along both edges, not proved to exceed one.
fn ellipse_axes(a: &ContourEdge, b: &ContourEdge) -> [f64; 2] {
    let (ends_a, ends_b) = ([a.start, a.end()], [b.start, b.end()]);
    let w = ends_a.map(|p| ends_b.map(|q| p - q));
    let r = w.map(|row| row.map(|x| x.length()));
    // Derivatives of |P − Q| as P moves along a, as Q moves along b.
    let da = [0, 1].map(|i| [0, 1].map(|j| w[i][j].dot(a.edge) / r[i][j]));
    let db = [0, 1].map(|i| [0, 1].map(|j| -w[i][j].dot(b.edge) / r[i][j]));
    let along_a = ellipse_axis(
        [r[0][0] + r[1][0], r[0][1] + r[1][1]],
        [db[0][0] + db[1][0], db[0][1] + db[1][1]],
        a.length,
        b.length,
    );
    let along_b = ellipse_axis(
        [r[0][0] + r[0][1], r[1][0] + r[1][1]],
        [da[0][0] + da[0][1], da[1][0] + da[1][1]],
        b.length,
        a.length,
    );
    [along_a, along_b]
}

/// Bound of the mean's error by n points: `rho2` = ϱ⁻², `power` = ϱ⁻²ⁿ.
#[inline(always)]
fn truncation(n: usize, rho2: f64, power: f64) -> f64 {
    let n = n as f64;
    power / (n * (1.0 - rho2)) * (1.0 + 1.0 / (4.0 * n * n - 1.0))
}

/// The least number of points for an error `wanted`, with the error's bound.
#[inline(always)]
fn points(axis: f64, wanted: f64) -> Option<(usize, f64)> {
    if axis.is_nan() || axis < 1.05 {
        return None;
    }
    let rho = axis + (axis * axis - 1.0).sqrt();
    let rho2 = 1.0 / (rho * rho);
    let mut power = 1.0;
    for n in 1..=MAX_EDGE_POINTS {
        power *= rho2;
        let error = truncation(n, rho2, power);
        if error <= wanted {
            return Some((n, error));
        }
    }
    None
}

/// A bound of |ln x| from the exponent alone.
fn ln_bound(x: f64) -> f64 {
    let exponent = (x.to_bits() >> 52) as i64 - 1023;
    std::f64::consts::LN_2 * (exponent.unsigned_abs() as f64 + 1.0)
}

/// J with an error of at most `wanted` where attainable.
pub(super) fn integral(a: &ContourEdge, b: &ContourEdge, wanted: f64) -> EdgeIntegral {
    let mut budget = MAX_CLOSED_FORMS;
    integrate_or_halve(a, b, wanted, &mut budget)
}

fn integrate_or_halve(a: &ContourEdge, b: &ContourEdge, wanted: f64, budget: &mut u32) -> EdgeIntegral {
    if let Some(part) = gauss_integral(a, b, wanted) {
        return part;
    }
    let closed = edge_closed_form::closed_form(a, b);
    if closed.error <= wanted.max(MIN_USEFUL_ERROR) || *budget == 0 {
        return closed;
    }
    *budget -= 1;
    let halves = if a.length >= b.length {
        a.halves().map(|h| integrate_or_halve(&h, b, wanted, budget))
    } else {
        b.halves().map(|h| integrate_or_halve(a, &h, wanted, budget))
    };
    let value = 0.5 * (halves[0].value + halves[1].value);
    let error = 0.5 * (halves[0].error + halves[1].error) + 2.0 * UNIT_ROUNDOFF * value.abs();
    let evaluations = closed.evaluations + halves[0].evaluations + halves[1].evaluations;
    if error < closed.error {
        EdgeIntegral { value, error, evaluations }
    } else {
        EdgeIntegral { evaluations, ..closed }
    }
}

/// The Gauss sum, if the edges are far enough apart.
#[inline(always)]
fn gauss_integral(a: &ContourEdge, b: &ContourEdge, wanted: f64) -> Option<EdgeIntegral> {
    let [along_a, along_b] = ellipse_axes(a, b);
    let (n, error_a) = points(along_a, 0.5 * wanted)?;
    let (m, error_b) = points(along_b, 0.5 * wanted)?;
    let p = a.start - b.start;
    let reach = p.length() + a.length + b.length;
    let distance = (0.5 * (along_a - 1.0) * a.length).max(0.5 * (along_b - 1.0) * b.length);
    if distance.is_nan() || distance <= 1e-30 {
        return None;
    }
    let logs = 1.0 + ln_bound(reach).max(ln_bound(distance));
    let rounding = UNIT_ROUNDOFF * (PLACE_ROUNDINGS * reach / distance + SUM_ROUNDINGS * logs);
    let value = simd::run(LogSumWork { p, u: a.edge, v: b.edge, quarter: quarter_rule(n, m) });
    Some(EdgeIntegral { value, error: error_a + error_b + rounding, evaluations: (n * m) as u64 })
}

/// A quarter of a tensor rule: lanes of (s, 1 − s, t, 1 − t, weight).
struct QuarterRule {
    rows: Vec<[[f64; LANES]; 5]>,
}

fn quarter_rule(n: usize, m: usize) -> &'static QuarterRule {
    static TABLES: [[OnceLock<QuarterRule>; MAX_EDGE_POINTS + 1]; MAX_EDGE_POINTS + 1] =
        [const { [const { OnceLock::new() }; MAX_EDGE_POINTS + 1] }; MAX_EDGE_POINTS + 1];
    TABLES[n][m].get_or_init(|| make_quarter_rule(n, m))
}

fn make_quarter_rule(n: usize, m: usize) -> QuarterRule {
    let (first, second) = (gauss_legendre::rule(n), gauss_legendre::rule(m));
    // The middle point of an odd rule is its own mirror image and counts half.
    let share = |i: usize, n: usize| if 2 * i + 1 == n { 0.5 } else { 1.0 };
    let mut points = Vec::new();
    for i in 0..n.div_ceil(2) {
        for j in 0..m.div_ceil(2) {
            let w = first.weights[i] * share(i, n) * second.weights[j] * share(j, m);
            points.push([
                first.nodes[i],
                first.nodes[n - 1 - i],
                second.nodes[j],
                second.nodes[m - 1 - j],
                0.5 * w,
            ]);
        }
    }
    let rows = points
        .chunks(LANES)
        .map(|chunk| {
            [0, 1, 2, 3, 4].map(|k| {
                std::array::from_fn(|l| match chunk.get(l) {
                    Some(p) => p[k],
                    None => {
                        if k == 4 {
                            0.0
                        } else {
                            chunk[0][k]
                        }
                    }
                })
            })
        })
        .collect();
    QuarterRule { rows }
}

/// The sum as a SIMD kernel.
struct LogSumWork<'a> {
    p: Vec3,
    u: Vec3,
    v: Vec3,
    quarter: &'a QuarterRule,
}

impl simd::SimdKernel for LogSumWork<'_> {
    type Output = f64;
    #[inline(always)]
    fn evaluate(self) -> f64 {
        log_sum(self.p, self.u, self.v, self.quarter)
    }
}

/// ½ Σ w ln|p + s u − t v|², four points to a logarithm.
#[inline(always)]
fn log_sum(p: Vec3, u: Vec3, v: Vec3, quarter: &QuarterRule) -> f64 {
    let mut total = [0.0; LANES];
    for [s0, s1, t0, t1, w] in &quarter.rows {
        let mut product = [1.0; LANES];
        for (s, t) in [(s0, t0), (s0, t1), (s1, t0), (s1, t1)] {
            for l in 0..LANES {
                let x = (p.x + s[l] * u.x) - t[l] * v.x;
                let y = (p.y + s[l] * u.y) - t[l] * v.y;
                let z = (p.z + s[l] * u.z) - t[l] * v.z;
                product[l] *= x * x + y * y + z * z;
            }
        }
        let logs = ln(product);
        for l in 0..LANES {
            total[l] += w[l] * logs[l];
        }
    }
    ((total[0] + total[4]) + (total[2] + total[6])) + ((total[1] + total[5]) + (total[3] + total[7]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A constant covers its count, and half of it would not.
    fn covers(constant: f64, count: f64) {
        assert!(constant >= count && 0.5 * constant < count, "{constant} {count}");
    }

    #[test]
    fn rounding_constants_cover_their_counts() {
        // ln of a product of four squares: four times 6, three products; the logarithm 4; two weights and their product 6; a hundred
        // quarters in eight lanes 13 + 7.
        covers(SUM_ROUNDINGS, 4.0 * 6.0 + 3.0 + 4.0 + 6.0 + 20.0);
        // 4εR for the difference, as much for its square root's relative error.
        covers(PLACE_ROUNDINGS, 4.0 + 4.0);
    }

    #[test]
    fn edge_truncation_bound_is_sharp() {
        // The mean of ln|x − y| over an edge, y beside its middle: closed form.
        for (height, n) in [(1.0f64, 3), (0.7, 5), (2.0, 2)] {
            let exact = 0.5 * (1.0 + height * height).ln() - 1.0 + height * (1.0 / height).atan();
            let rule = gauss_legendre::rule(n);
            let f = |s: f64| 0.5 * ((2.0 * s - 1.0).powi(2) + height * height).ln();
            let got: f64 = rule.nodes.iter().zip(&rule.weights).map(|(s, w)| w * f(*s)).sum();
            let axis = (1.0 + height * height).sqrt();
            let rho = axis + (axis * axis - 1.0).sqrt();
            let bound = truncation(n, rho.powi(-2), rho.powi(-2 * n as i32));
            let off = (got - exact).abs();
            assert!(off <= bound && bound < 2.0 * off, "{height} {n}: {off:e} {bound:e}");
        }
    }
}
