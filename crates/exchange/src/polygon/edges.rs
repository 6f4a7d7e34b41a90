//! J = ∬ ln r ds dt over two straight edges, s and t in [0, 1]: Gauss rules where the edges are apart, closed forms where not.
//!
//! **Gauss.** Along an edge of length ℓ the distance of a point y has ln r = const − Σ_{k≥1} (2/k) Re(w^{−k}) T_k (the generating function
//! of Chebyshev's polynomials), where w + 1/w = 2z and z is the complex zero of r², which lies as far from the ends ±1 as y from the
//! edge's ends, in half-lengths. So |w| = ϱ with ½(ϱ + 1/ϱ) = (d₁ + d₂)/ℓ, the distances d of y from the two ends. The n-point rule is
//! exact below degree 2n, gives each T_k at most 1 and the integral of an even one is −1/(k² − 1), of an odd one 0. Hence, for the mean over the edge,
//!
//! ```text
//! |error| ≤ Σ_{k = 2n, 2n+2, …} (2/k) ϱ^{−k} (1 + 1/(k² − 1)) ≤ (1/n) (1 + 1/(4n² − 1)) ϱ^{−2n}/(1 − ϱ^{−2}).
//! ```
//!
//! ϱ belongs to the least d₁ + d₂ of all y on the other edge. The sum is convex along it, so the tangents at the two ends bound it from
//! below. The errors of the two directions add, the weights being positive.
//!
//! **Four logarithms in one.** The weights of the rules are symmetric: the four points (±, ±) share theirs, and the logarithm of
//! the product of four squared distances serves them all.
//!
//! **Rounding.** The three components of P(s) − Q(t) err by 4ε (|p| + ℓ_u + ℓ_v) = 4εR, ln r by 8εR/D, D the least distance, at least
//! (½(ϱ + 1/ϱ) − 1) ℓ/2; the product, its logarithm, weights and sums by less than 64ε (1 + max |ln r|).
//!
//! Edges too near for [`MAX_POINTS`] take the closed form ([`super::skew`]); where its error is too large (nearly parallel and close)
//! the longer edge is halved, J being the mean of the halves' values.

use super::skew;
use std::sync::OnceLock;
use zonal_math::logarithm::ln;
use zonal_math::{Vec3, gauss, simd};

/// 2⁻⁵³.
const EPS: f64 = 0.5 * f64::EPSILON;
/// The most points along an edge; with more the closed form is cheaper.
const MAX_POINTS: usize = 20;
/// Lanes of the sums.
const LANES: usize = 8;
/// Roundings of the least sum of distances, relative to the lengths that enter it (about twenty are made).
const SLACK: f64 = 64.0 * EPS;
/// Roundings of a Gauss sum, relative to 1 + max |ln r| (header).
const SUM_ROUNDING: f64 = 64.0; // bound
/// Roundings of ln r by the edges' differences, relative to R/D.
const PLACE_ROUNDING: f64 = 8.0; // bound
/// Closed forms for one pair of edges at most; what is left then has the error that it has.
const BUDGET: u32 = 200;
/// A smaller error of J than this is not worth halving for.
const FINEST: f64 = 4e-14;

/// A straight edge; lengths in units of the pair's size, about one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    pub start: Vec3,
    pub edge: Vec3,
    pub length: f64,
}

impl Segment {
    pub(super) fn between(a: Vec3, b: Vec3) -> Segment {
        let edge = b - a;
        Segment { start: a, edge, length: edge.length() }
    }
    fn end(&self) -> Vec3 {
        self.start + self.edge
    }
    fn halves(&self) -> [Segment; 2] {
        let (edge, length) = (self.edge * 0.5, 0.5 * self.length);
        [Segment { start: self.start, edge, length }, Segment { start: self.start + edge, edge, length }]
    }
}

/// J, its proved error and the logarithms or dilogarithms that it took.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Part {
    pub value: f64,
    pub error: f64,
    pub evaluations: u64,
}

/// Lower bound of ½(ϱ + 1/ϱ) = (d₁ + d₂)/ℓ for an edge of that `length`, by the tangents.
///
/// `sums`: d₁ + d₂ at the two ends of the `other` edge (its length); `slopes`: their derivatives along it.
#[inline(always)]
fn axis(sums: [f64; 2], slopes: [f64; 2], length: f64, other: f64) -> f64 {
    let least = if slopes[0] >= 0.0 {
        sums[0]
    } else if slopes[1] <= 0.0 {
        sums[1]
    } else {
        // A slope that is no number (an end on the other edge) leaves none here, and no rule.
        let t = (sums[1] - slopes[1] - sums[0]) / (slopes[0] - slopes[1]);
        sums[0] + slopes[0] * t
    };
    (least - SLACK * (sums[0] + sums[1] + other)) / length
}

/// ½(ϱ + 1/ϱ) of the ellipses along both edges, not proved to exceed one.
fn axes(a: &Segment, b: &Segment) -> [f64; 2] {
    let (ends_a, ends_b) = ([a.start, a.end()], [b.start, b.end()]);
    let w = ends_a.map(|p| ends_b.map(|q| p - q));
    let r = w.map(|row| row.map(|x| x.length()));
    // Derivatives of |P − Q| as P moves along a, as Q moves along b.
    let da = [0, 1].map(|i| [0, 1].map(|j| w[i][j].dot(a.edge) / r[i][j]));
    let db = [0, 1].map(|i| [0, 1].map(|j| -w[i][j].dot(b.edge) / r[i][j]));
    let along_a = axis(
        [r[0][0] + r[1][0], r[0][1] + r[1][1]],
        [db[0][0] + db[1][0], db[0][1] + db[1][1]],
        a.length,
        b.length,
    );
    let along_b = axis(
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
    for n in 1..=MAX_POINTS {
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

/// J with an error of at most `wanted` where that can be had.
pub(super) fn integral(a: &Segment, b: &Segment, wanted: f64) -> Part {
    let mut budget = BUDGET;
    divide(a, b, wanted, &mut budget)
}

fn divide(a: &Segment, b: &Segment, wanted: f64, budget: &mut u32) -> Part {
    if let Some(part) = apart(a, b, wanted) {
        return part;
    }
    let closed = skew::closed(a, b);
    if closed.error <= wanted.max(FINEST) || *budget == 0 {
        return closed;
    }
    *budget -= 1;
    let halves = if a.length >= b.length {
        a.halves().map(|h| divide(&h, b, wanted, budget))
    } else {
        b.halves().map(|h| divide(a, &h, wanted, budget))
    };
    let value = 0.5 * (halves[0].value + halves[1].value);
    let error = 0.5 * (halves[0].error + halves[1].error) + 2.0 * EPS * value.abs();
    let evaluations = closed.evaluations + halves[0].evaluations + halves[1].evaluations;
    if error < closed.error { Part { value, error, evaluations } } else { Part { evaluations, ..closed } }
}

/// The Gauss sum, if the edges are far enough apart for it.
#[inline(always)]
fn apart(a: &Segment, b: &Segment, wanted: f64) -> Option<Part> {
    let [along_a, along_b] = axes(a, b);
    let (n, error_a) = points(along_a, 0.5 * wanted)?;
    let (m, error_b) = points(along_b, 0.5 * wanted)?;
    let p = a.start - b.start;
    let reach = p.length() + a.length + b.length;
    let distance = (0.5 * (along_a - 1.0) * a.length).max(0.5 * (along_b - 1.0) * b.length);
    if distance.is_nan() || distance <= 1e-30 {
        return None;
    }
    let logs = 1.0 + ln_bound(reach).max(ln_bound(distance));
    let rounding = EPS * (PLACE_ROUNDING * reach / distance + SUM_ROUNDING * logs);
    let value = simd::run(Logs { p, u: a.edge, v: b.edge, quarter: table(n, m) });
    Some(Part { value, error: error_a + error_b + rounding, evaluations: (n * m) as u64 })
}

/// A quarter of a tensor rule: lanes of (s, 1 − s, t, 1 − t, weight).
struct Quarter {
    rows: Vec<[[f64; LANES]; 5]>,
}

fn table(n: usize, m: usize) -> &'static Quarter {
    static TABLES: [[OnceLock<Quarter>; MAX_POINTS + 1]; MAX_POINTS + 1] =
        [const { [const { OnceLock::new() }; MAX_POINTS + 1] }; MAX_POINTS + 1];
    TABLES[n][m].get_or_init(|| make(n, m))
}

fn make(n: usize, m: usize) -> Quarter {
    let (first, second) = (gauss::rule(n), gauss::rule(m));
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
    Quarter { rows }
}

/// The sum as work for the widest vectors.
struct Logs<'a> {
    p: Vec3,
    u: Vec3,
    v: Vec3,
    quarter: &'a Quarter,
}

impl simd::Work for Logs<'_> {
    type Output = f64;
    #[inline(always)]
    fn go(self) -> f64 {
        sum(self.p, self.u, self.v, self.quarter)
    }
}

/// ½ Σ w ln|p + s u − t v|², four points to a logarithm.
#[inline(always)]
fn sum(p: Vec3, u: Vec3, v: Vec3, quarter: &Quarter) -> f64 {
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
    fn the_constants_cover_their_counts() {
        // ln of a product of four squares: four times 6, three products; the logarithm 4; two weights and their product 6; a hundred
        // quarters in eight lanes 13 + 7.
        covers(SUM_ROUNDING, 4.0 * 6.0 + 3.0 + 4.0 + 6.0 + 20.0);
        // 4εR for the difference, as much for its square root's relative error.
        covers(PLACE_ROUNDING, 4.0 + 4.0);
    }

    #[test]
    fn a_truncation_holds_and_is_near_what_happens() {
        // The mean of ln|x − y| over an edge, y beside its middle: closed form.
        for (height, n) in [(1.0f64, 3), (0.7, 5), (2.0, 2)] {
            let exact = 0.5 * (1.0 + height * height).ln() - 1.0 + height * (1.0 / height).atan();
            let rule = gauss::rule(n);
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
