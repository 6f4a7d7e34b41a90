//! Two plates apart, without a medium, by tensor Gauss rules with a proved error.
//!
//! The heights over the planes factorise, n_a·(y − x) depending on y alone:
//!
//! ```text
//! 𝓕 = (1/π) ∫_a h_b(x) ∫_b h_a(y) / |x − y|⁴ dA dA
//! ```
//!
//! Parallelograms take Gauss–Legendre, triangles collapsed coordinates o + u e₁ + (1 − u) v e₂ with a rule for the weight 1 − u in u.
//!
//! **Proof.** Along a segment of length ℓ, parametrised on [0, 1], the derivatives of 1/r⁴ are Gegenbauer polynomials,
//! g⁽ᵐ⁾/m! = ± ℓᵐ C_m²(cosθ)/r^{m+4}, and |C_m²| ≤ B_m = min[binom(m+3, 3), (m+2)/(2 sin³θ)] (C_m² = U'_{m+1}/2; the second attained at
//! θ = π/2 for even m). With the linear height h, at most H with a range Δ over the plate, an n-point rule errs by
//!
//! ```text
//! γ_n (ℓ/D)^{2n} D⁻⁴ [H B_{2n} + (Δ D/ℓ) B_{2n−1}],
//! ```
//!
//! D the least distance of the plates, γ_n the rule's remainder ([`zonal_math::gauss_jacobi`]). In a triangle's v the segment is (1 − u) ℓ long:
//! ∫ 2 (1 − u)^{2n+1} du = 1/(n+1) more. The other plate contributes A_b times the mean of its height, which both the integral and the rule
//! give exactly; the errors of the four directions add, weights being positive. sinθ ≥ sin(θ₀ − φ), θ₀ the angle to the line of centres, sinφ
//! the plates' radii over the distance of the centres.
//!
//! D: along the line of centres the support functions, or the least height over the other's plane.
//!
//! **Rounding.** All terms are positive but for heights within their rounding η = 16ε (|d| + sizes); they err by η each, and parts of a plate
//! within η behind
//! the plane of the other are included: (A_a A_b/πD⁴) η (H_a + H_b + η). The rest is relative: 1/r⁴ 8ε(lengths)/D·2, products and sums below
//! 64 + points ε.

use super::contour::{ContourSum, HEIGHT_ROUNDINGS};
use super::plate_geometry::{LANES, MAX_POINTS_PER_DIRECTION, PlateGeometry, TensorRule, tensor_rule};
use std::f64::consts::PI;
use zonal_math::gauss_jacobi::{binomial, gauss_jacobi_remainder, gauss_legendre_remainder};
use zonal_math::{Vec3, simd};
use zonal_scene::PlateKind;

/// Unit roundoff 2⁻⁵³.
const UNIT_ROUNDOFF: f64 = 0.5 * f64::EPSILON;
/// Roundings of products and sums (header), without the points of the sums.
const SUM_ROUNDINGS: f64 = 64.0; // bound
/// Roundings of r⁻⁴ by the places of the points, relative to lengths/D.
const PLACE_ROUNDINGS: f64 = 64.0; // bound
/// Kernel evaluations above which contours are cheaper.
const MAX_TENSOR_EVALUATIONS: usize = 1_600;

/// The geometry of a pair, before the choice of a rule.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlatePairGeometry {
    /// From a's origin to b's.
    pub d: Vec3,
    /// Rounding of heights, m.
    pub eta: f64,
    /// Heights of a's corners over b's plane: least, mean, largest; and of b's over a's plane.
    pub over_b: [f64; 3],
    pub over_a: [f64; 3],
}

impl PlatePairGeometry {
    pub(super) fn of(a: &PlateGeometry, b: &PlateGeometry) -> PlatePairGeometry {
        let d = b.origin - a.origin;
        let lengths = d.x.abs() + d.y.abs() + d.z.abs() + a.reach + b.reach;
        let base = b.normal.dot(d);
        let over_b = height_range(a, |x| b.normal.dot(x) - base);
        let base = a.normal.dot(d);
        let over_a = height_range(b, |x| a.normal.dot(x) + base);
        PlatePairGeometry { d, eta: HEIGHT_ROUNDINGS * UNIT_ROUNDOFF * lengths, over_b, over_a }
    }
    /// True where one lies behind the other or in its plane, up to rounding.
    pub(super) fn is_unseen(&self) -> bool {
        self.over_a[2] <= self.eta || self.over_b[2] <= self.eta
    }
    /// True where neither plane cuts the other plate.
    pub(super) fn is_uncut(&self) -> bool {
        self.over_a[0] >= -self.eta && self.over_b[0] >= -self.eta
    }
}

#[inline(always)]
fn height_range(p: &PlateGeometry, height: impl Fn(Vec3) -> f64) -> [f64; 3] {
    let (mut least, mut most, mut sum) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
    for c in &p.corners[..p.count] {
        let h = height(*c);
        least = if h < least { h } else { least };
        most = if h > most { h } else { most };
        sum += h;
    }
    [least, sum / p.count as f64, most]
}

/// A chosen rule for both plates, and the bound of its error, m².
#[derive(Clone, Copy, Debug)]
pub(super) struct TensorPlan {
    first: [usize; 2],
    second: [usize; 2],
    truncation: f64,
    rounding: [f64; 2],
}

/// The least rules for max(`relative` 𝓕, `absolute`), if they are cheap; the plates wholly in front of each other.
#[inline(always)]
pub(super) fn plan(
    a: &PlateGeometry,
    b: &PlateGeometry,
    v: &PlatePairGeometry,
    relative: f64,
    absolute: f64,
) -> Option<TensorPlan> {
    let centres = v.d + b.centre - a.centre;
    let r0 = centres.length();
    let axis = centres / r0;
    let near = height_range(b, |x| x.dot(axis))[0] + v.d.dot(axis) - height_range(a, |x| x.dot(axis))[2];
    let distance = near.max(v.over_a[0]).max(v.over_b[0]) - v.eta;
    if distance.is_nan() || distance < 0.3 * a.radius.min(b.radius) || distance < 1e-30 || r0 > 1e30 {
        return None;
    }
    let (ha, hb) = (v.over_a[1] + v.eta, v.over_b[1] + v.eta);
    let both = a.area * b.area / PI;
    let far4 = r0 * r0 * r0 * r0;
    let wanted = 0.25
        * (0.8 * relative * both * v.over_a[1].max(0.0) * v.over_b[1].max(0.0) / far4).max(0.9 * absolute);
    let d2 = distance * distance;
    let front = both / (d2 * d2);
    let sin_phi = (a.radius + b.radius) / r0;
    let cone = [sin_phi, (1.0 - sin_phi * sin_phi).max(0.0).sqrt()];
    let mut truncation = 0.0;
    let mut choose = |p: &PlateGeometry, other_mean: f64, over: &[f64; 3]| {
        let mut points = [0; 2];
        for k in 0..2 {
            let sine = p.least_sine(k, axis, cone);
            let line = DirectionBound {
                x: p.lengths[k] * p.lengths[k] / d2,
                height: over[2] + v.eta,
                climb: (over[2] - over[0] + 2.0 * v.eta) * distance / p.lengths[k],
                inverse_sine3: 1.0 / (sine * sine * sine),
            };
            let (n, error) = line.points(p.kind, k, wanted / (front * other_mean))?;
            points[k] = n;
            truncation += error * front * other_mean;
        }
        Some(points)
    };
    let first = choose(a, ha, &v.over_b)?;
    let second = choose(b, hb, &v.over_a)?;
    if first[0] * first[1] * second[0] * second[1] > MAX_TENSOR_EVALUATIONS {
        return None;
    }
    let heights = front * v.eta * (v.over_a[2] + v.over_b[2] + v.eta);
    let places = PLACE_ROUNDINGS * UNIT_ROUNDOFF * (r0 + a.reach + b.reach) / distance;
    Some(TensorPlan { first, second, truncation, rounding: [heights, places] })
}

/// One direction of one plate.
struct DirectionBound {
    /// (ℓ/D)².
    x: f64,
    height: f64,
    climb: f64,
    inverse_sine3: f64,
}

/// γ_n, binom(2n+3, 3), binom(2n+2, 3) for each n; by rule: Legendre, collapsed u, collapsed v.
type RemainderTable = [[[f64; 3]; MAX_POINTS_PER_DIRECTION + 1]; 3];

fn remainders() -> &'static RemainderTable {
    static REMAINDERS: std::sync::OnceLock<RemainderTable> = std::sync::OnceLock::new();
    REMAINDERS.get_or_init(|| {
        let row = |gamma: &dyn Fn(usize) -> f64| {
            std::array::from_fn(|n| {
                if n == 0 { [0.0; 3] } else { [gamma(n), binomial(2 * n + 3, 3), binomial(2 * n + 2, 3)] }
            })
        };
        [
            row(&gauss_legendre_remainder),
            row(&gauss_jacobi_remainder),
            row(&|n| gauss_legendre_remainder(n) / (n as f64 + 1.0)),
        ]
    })
}

impl DirectionBound {
    /// The least number of points for `wanted`, and the bound of the error, both over A_a A_b h/(π D⁴).
    #[inline(always)]
    fn points(&self, kind: PlateKind, k: usize, wanted: f64) -> Option<(usize, f64)> {
        let row = match (kind, k) {
            (PlateKind::Parallelogram, _) => &remainders()[0],
            (PlateKind::Triangle, 0) => &remainders()[1],
            (PlateKind::Triangle, _) => &remainders()[2],
        };
        let mut power = 1.0;
        for n in 1..=MAX_POINTS_PER_DIRECTION {
            power *= self.x;
            let [gamma, even, odd] = row[n];
            let wide = 0.5 * self.inverse_sine3;
            let m = 2.0 * n as f64;
            let even = even.min((m + 2.0) * wide);
            let odd = odd.min((m + 1.0) * wide);
            let error = gamma * power * (self.height * even + self.climb * odd);
            if error <= wanted {
                return Some((n, error));
            }
        }
        None
    }
}

/// Value, radius (m²) and evaluations of the planned rule.
#[inline(always)]
pub(super) fn evaluate(
    a: &PlateGeometry,
    b: &PlateGeometry,
    v: &PlatePairGeometry,
    plan: &TensorPlan,
) -> ContourSum {
    let (first, second) = (tensor_rule(a.kind, plan.first), tensor_rule(b.kind, plan.second));
    let mean = simd::run(PairwiseWork { a, b, v, first, second });
    let value = mean * (a.area * b.area / PI);
    let points = (first.points + second.points) as f64;
    let relative = UNIT_ROUNDOFF * (SUM_ROUNDINGS + points) + plan.rounding[1];
    let radius = plan.truncation + plan.rounding[0] + value.abs() * relative;
    ContourSum {
        value,
        radius: radius * (1.0 + 64.0 * UNIT_ROUNDOFF),
        evaluations: (first.points * second.points) as u64,
    }
}

/// The sum as a SIMD kernel.
struct PairwiseWork<'a> {
    a: &'a PlateGeometry,
    b: &'a PlateGeometry,
    v: &'a PlatePairGeometry,
    first: &'a TensorRule,
    second: &'a TensorRule,
}

impl simd::SimdKernel for PairwiseWork<'_> {
    type Output = f64;
    #[inline(always)]
    fn evaluate(self) -> f64 {
        pairwise_sum(self.a, self.b, self.v, self.first, self.second)
    }
}

/// Σ w h_b Σ w h_a / r⁴, two points of a at a time to share a division.
#[inline(always)]
fn pairwise_sum(
    a: &PlateGeometry,
    b: &PlateGeometry,
    v: &PlatePairGeometry,
    first: &TensorRule,
    second: &TensorRule,
) -> f64 {
    const BLOCK: usize = MAX_POINTS_PER_DIRECTION * MAX_POINTS_PER_DIRECTION / LANES;
    let mut x = [[[0.0; LANES]; 4]; BLOCK];
    let mut y = [[[0.0; LANES]; 4]; BLOCK];
    let (na, nb) = (first.rows.len(), second.rows.len());
    place_points(a, a.base - v.d, b.normal, first, &mut x);
    place_points(b, b.base, a.normal, second, &mut y);
    let lift = a.normal.dot(v.d);
    for k in 0..nb {
        let w = &second.rows[k][2];
        for l in 0..LANES {
            y[k][3][l] = (y[k][3][l] + lift) * w[l];
        }
    }
    for k in 0..na {
        let w = &first.rows[k][2];
        for l in 0..LANES {
            x[k][3][l] *= w[l];
        }
    }
    // Sums stay in memory: the compiler vectorizes the stores. The black box prevents gathers across rows.
    let mut total = [[0.0; LANES]; BLOCK];
    for i in 0..first.points.div_ceil(2) {
        let (row, l) = (&x[2 * i / LANES], 2 * i % LANES);
        let [p, q] = [l, l + 1].map(|l| [row[0][l], row[1][l], row[2][l], row[3][l]]);
        for (t, y) in total[..nb].iter_mut().zip(&y[..nb]) {
            add_two(t, std::hint::black_box(y), &p, &q);
        }
    }
    let mut all = [0.0; LANES];
    for t in &total[..nb] {
        for l in 0..LANES {
            all[l] += t[l];
        }
    }
    ((all[0] + all[4]) + (all[2] + all[6])) + ((all[1] + all[5]) + (all[3] + all[7]))
}

/// Adds the kernels between eight points and two: one division for both.
#[inline(always)]
fn add_two(total: &mut [f64; LANES], y: &[[f64; LANES]; 4], p: &[f64; 4], q: &[f64; 4]) {
    let (s, t) = (fourth_power(y, p), fourth_power(y, q));
    let mut share = [0.0; LANES];
    for l in 0..LANES {
        share[l] = (p[3] * t[l] + q[3] * s[l]) / (s[l] * t[l]);
    }
    for l in 0..LANES {
        total[l] += y[3][l] * share[l];
    }
}

#[inline(always)]
fn fourth_power(y: &[[f64; LANES]; 4], c: &[f64; 4]) -> [f64; LANES] {
    let mut r2 = [0.0; LANES];
    for k in 0..3 {
        let mut d = [0.0; LANES];
        for l in 0..LANES {
            d[l] = y[k][l] - c[k];
        }
        for l in 0..LANES {
            r2[l] += d[l] * d[l];
        }
    }
    for l in 0..LANES {
        r2[l] *= r2[l];
    }
    r2
}

/// The rule's points on a plate, `start` + α e₁ + β e₂, and their heights along `normal`.
#[inline(always)]
fn place_points(
    p: &PlateGeometry,
    start: Vec3,
    normal: Vec3,
    rule: &TensorRule,
    out: &mut [[[f64; LANES]; 4]],
) {
    for (row, place) in rule.rows.iter().zip(out) {
        for l in 0..LANES {
            let (s, t) = (row[0][l], row[1][l]);
            let x = start.x + (s * p.e1.x + t * p.e2.x);
            let y = start.y + (s * p.e1.y + t * p.e2.y);
            let z = start.z + (s * p.e1.z + t * p.e2.z);
            place[0][l] = x;
            place[1][l] = y;
            place[2][l] = z;
            place[3][l] = x * normal.x + y * normal.y + z * normal.z;
        }
    }
}

/// A rough value from a few points, for setting tolerances; not negative.
pub(super) fn rough_value(a: &PlateGeometry, b: &PlateGeometry, v: &PlatePairGeometry) -> f64 {
    let (first, second) = (tensor_rule(a.kind, [2, 2]), tensor_rule(b.kind, [3, 3]));
    let mean = simd::run(PairwiseWork { a, b, v, first, second });
    if mean.is_finite() { mean.max(0.0) * (a.area * b.area / PI) } else { 0.0 }
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
        // r² 6, its square 13, the quotient 1; two heights of 5; weights of two rules and Jacobians 8; products of these 4, the front 4.
        covers(SUM_ROUNDINGS, 13.0 + 1.0 + 2.0 * 5.0 + 8.0 + 4.0 + 4.0);
        // The fourth power of r, two places of 4, the difference and its length as much again.
        covers(PLACE_ROUNDINGS, 4.0 * 2.0 * 4.0 * 2.0);
    }
}
