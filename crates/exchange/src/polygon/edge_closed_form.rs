//! ∬ ln r ds dt over two straight edges, in closed form.
//!
//! Edges P(s) = P₀ + s u, Q(t) = Q₀ + t v, s and t in [0, 1], p = P₀ − Q₀, lengths ℓ_u and ℓ_v, α the angle between them.
//!
//! **Skew.** Let x and y be lengths along the two lines from the feet of their common perpendicular, whose length is d. Then
//! f = r² = x² − 2xy cosα + y² + d², and by Euler's identity div((x,y) ln f) = 2 ln f + 2 − 2d²/f
//!
//! ```text
//! 2 ∬ ln f dx dy = Σ_sides ± x ∫ ln f dy ± y ∫ ln f dx − 2 ℓ_u ℓ_v + 2 W,          W = d² ∬ dx dy/f
//! ∫ ln(z² + g²) dz = z ln(z² + g²) − 2z + 2g atan(z/g)                              on x = const: z = y − x cosα, g² = x² sin²α + d²
//! W = (d²/sinα) Σ_sides ± sgn(h) [T(θ)],  h = x sinα,  θ = atan(z/|h|)               (the parallelogram as four signed triangles)
//! T = ½ ∫₀^θ ln(1 + h²/(d² cos²θ')) dθ' = ½ [Im Li₂(−e^{2iθ}) − Im Li₂(−q e^{2iθ}) − θ ln q],   q = (√(1 + h²/d²) − |h|/d)².
//! ```
//!
//! For d = 0 (edges or lines that intersect) only the elementary terms remain.
//!
//! **Parallel.** f = (x − y)² + h², and the double integral is a second difference of K, K'' = ln(z² + h²):
//! K = ½ (z² − h²) ln(z² + h²) − (3/2) z² + 2hz atan(z/h).
//!
//! **Proof of the radius**, ε = 2⁻⁵³. The parameters (feet, angle, distance) that are computed describe exactly a pair of edges whose
//! differences P(s) − Q(t) are at most δ off the given ones: the residual |p − (x₀û − y₀v̂ + d n)|, which is computed, and roundings of
//! û, v̂, n counted as 8ε of the lengths they multiply (8ε/sinα for n). Moving the edges so far changes J by at most
//!
//! ```text
//! (1/ℓ_uℓ_v) ∬ |ln(r̃/r)| ≤ (2/ℓ) ∫ ln(1 + δ/|x|) dx (twice: r and r̃ may be the smaller) ≤ 4 (δ/ℓ) (1 + ln(1 + ℓ/2δ)),     ℓ the longer edge,
//! ```
//!
//! since r is at least the distance along a line from the foot of the other point. The formula's own rounding: with m = |x| + |y| + d at a corner,
//! z carries 2εm, f's error enters only as z Δln f ≤ 2(Δz + Δg), so a corner's terms err by ε m² (20 |ln f| + 128) over both of its sides. Each of
//! the eight values T errs by ε (600 + 4 |ln q|): two dilogarithms of 24 units, their arguments' 6ε times at most 40 (Li₂'s
//! modulus of continuity), θ ln q; and the corner's 2εm of z turns θ by that over its distance ρ, ½ ln(1 + ρ²/d²) · 2εm/ρ ≤ εm/d.
//!
//! Reference: Schröder and Hanrahan, On the form factor between two polygons, SIGGRAPH 1993 (a different derivation of the same integral).

use super::segment::{ContourEdge, EdgeIntegral};
use zonal_math::Vec3;
use zonal_math::dilogarithm::dilogarithm;

/// Unit roundoff 2⁻⁵³.
const UNIT_ROUNDOFF: f64 = 0.5 * f64::EPSILON;
/// Roundings of a corner's terms that |ln f| multiplies (header).
const CORNER_LOG_ROUNDINGS: f64 = 20.0; // bound
/// Roundings of a corner's other terms.
const CORNER_ROUNDINGS: f64 = 128.0; // bound
/// Roundings of one value T.
const TRIANGLE_ROUNDINGS: f64 = 600.0; // bound
/// Roundings that act as a displacement of the edges, relative to the lengths.
const DISPLACEMENT_ROUNDINGS: f64 = 8.0; // bound
/// The displacement's logarithmic bound: 2 for both sides of the foot, 2 for r and r̃.
const DISPLACEMENT_LOG_FACTOR: f64 = 4.0; // bound

/// Bound of the change of J when the edges are moved against each other by at most `delta`.
fn displacement_error(delta: f64, longer: f64) -> f64 {
    if delta == 0.0 {
        0.0
    } else {
        DISPLACEMENT_LOG_FACTOR * delta / longer * (1.0 + (longer / (2.0 * delta)).ln_1p())
    }
}

/// J = ∬ ln r ds dt in closed form with a proved error: the better of the two formulas where both apply.
pub(super) fn closed_form(a: &ContourEdge, b: &ContourEdge) -> EdgeIntegral {
    let p = a.start - b.start;
    let (u, v) = (a.edge / a.length, b.edge / b.length);
    let w = u.cross(v);
    let s = w.length();
    if s < MIN_SINE_OF_SKEW_EDGES {
        return parallel(a, b, p, u, v);
    }
    let by_feet = skew(a, b, p, [u, v, w / s], s);
    if s > MAX_SINE_OF_PARALLEL_FORMULA {
        return by_feet;
    }
    let along = parallel(a, b, p, u, v);
    if along.error < by_feet.error { along } else { by_feet }
}

/// Sine of the angle below which the feet are lost in rounding.
const MIN_SINE_OF_SKEW_EDGES: f64 = 1e-12;
/// Sine of the angle above which the parallel formula is never better.
const MAX_SINE_OF_PARALLEL_FORMULA: f64 = 1e-5;

/// Skew edges: unit vectors u, v along them and n across both, s the sine of their angle.
fn skew(a: &ContourEdge, b: &ContourEdge, p: Vec3, [u, v, n]: [Vec3; 3], s: f64) -> EdgeIntegral {
    let (c, s2) = (u.dot(v), s * s);
    let feet = |r: Vec3| ((r.dot(u) - c * r.dot(v)) / s2, (c * r.dot(u) - r.dot(v)) / s2);
    let (x, y) = feet(p);
    let (dx, dy) = feet(p - u * x + v * y);
    let (x, y) = (x + dx, y + dy);
    let rest = p - u * x + v * y;
    let signed = rest.dot(n);
    let residual = (rest - n * signed).length();
    let d = signed.abs();
    let lengths = x.abs() + y.abs() + p.length() + a.length + b.length;
    let delta = residual + DISPLACEMENT_ROUNDINGS * UNIT_ROUNDOFF * (lengths + d / s);

    let lines = SkewLines { c, s, d, d2: d * d };
    let (xs, ys) = ([x, x + a.length], [y, y + b.length]);
    let mut sum = SkewTerms::default();
    for (k, sign) in [(0, -1.0), (1, 1.0)] {
        lines.side(xs[k], ys, sign, &mut sum);
        lines.side(ys[k], xs, sign, &mut sum);
    }
    for (x, y) in [(xs[0], ys[0]), (xs[0], ys[1]), (xs[1], ys[0]), (xs[1], ys[1])] {
        let (m, z) = (x.abs() + y.abs() + d, x - c * y);
        let f = z * z + s2 * y * y + lines.d2;
        sum.error += m
            * m
            * (CORNER_LOG_ROUNDINGS * f.max(f64::MIN_POSITIVE).ln().abs() + CORNER_ROUNDINGS)
            * UNIT_ROUNDOFF;
        sum.triangles_error += m * d / s * UNIT_ROUNDOFF;
    }
    let area = a.length * b.length;
    let integral = 0.5 * sum.boundary - area + sum.triangles;
    let error = 0.5 * sum.error + sum.triangles_error + 4.0 * UNIT_ROUNDOFF * integral.abs();
    let value = 0.5 * integral / area;
    EdgeIntegral {
        value,
        error: 0.5 * error / area
            + displacement_error(delta, a.length.max(b.length))
            + 4.0 * UNIT_ROUNDOFF * value.abs(),
        evaluations: 16,
    }
}

#[derive(Default)]
struct SkewTerms {
    boundary: f64,
    triangles: f64,
    error: f64,
    triangles_error: f64,
}

/// Two skew lines: cosine and sine of their angle, their distance and its square.
struct SkewLines {
    c: f64,
    s: f64,
    d: f64,
    d2: f64,
}

impl SkewLines {
    /// One side of the rectangle: x on the one axis, from ys[0] to ys[1] on the other; the signs of outward normals.
    fn side(&self, x: f64, ys: [f64; 2], sign: f64, sum: &mut SkewTerms) {
        let h = self.s * x.abs();
        let g = (h * h + self.d2).sqrt();
        let z = ys.map(|y| y - self.c * x);
        sum.boundary += sign * x * (log_integral(z[1], g) - log_integral(z[0], g));
        // sin α · 1e-160: there d² · T vanishes against any ε, and h/d could overflow.
        if h == 0.0 || self.d <= 1e-150 {
            return;
        }
        let k = h / self.d;
        let ln_q = -2.0 * k.asinh();
        let factor = self.d2 / self.s;
        let t = z.map(|z| triangle(h, z, ln_q));
        sum.triangles += sign * x.signum() * factor * (t[1] - t[0]);
        sum.triangles_error += 2.0 * factor * (TRIANGLE_ROUNDINGS + 4.0 * ln_q.abs()) * UNIT_ROUNDOFF;
    }
}

/// ∫₀^z ln(z² + g²) dz.
fn log_integral(z: f64, g: f64) -> f64 {
    let f = z * z + g * g;
    if f < f64::MIN_POSITIVE {
        return 0.0;
    }
    let arc = if g > 0.0 { 2.0 * g * (z / g).atan() } else { 0.0 };
    z * f.ln() - 2.0 * z + arc
}

/// T at θ = atan(z/h), h > 0.
fn triangle(h: f64, z: f64, ln_q: f64) -> f64 {
    let theta = z.atan2(h);
    // e^{2iθ} = (h + iz)²/(h² + z²).
    let r = h.hypot(z);
    let (x, y) = (h / r, z / r);
    let turn = [-(x - y) * (x + y), -2.0 * x * y];
    let q = ln_q.exp();
    0.5 * (dilogarithm(turn)[1] - dilogarithm([q * turn[0], q * turn[1]])[1] - theta * ln_q)
}

/// Nearly parallel edges, the second turned about its middle until it is parallel.
fn parallel(a: &ContourEdge, b: &ContourEdge, p: Vec3, u: Vec3, v: Vec3) -> EdgeIntegral {
    let sense = if u.dot(v) < 0.0 { -1.0 } else { 1.0 };
    let middle = p - b.edge * 0.5;
    let along = middle.dot(u);
    let h = (middle - u * along).length();
    let turned = 0.5 * b.length * (v - u * sense).length();
    let delta = turned + DISPLACEMENT_ROUNDINGS * UNIT_ROUNDOFF * (p.length() + a.length + b.length);
    let (x, y) = ([along, along + a.length], 0.5 * b.length);
    let terms = [(x[1] + y, 1.0), (x[0] + y, -1.0), (x[1] - y, -1.0), (x[0] - y, 1.0)];
    let (mut sum, mut error) = (0.0, 0.0);
    for (z, sign) in terms {
        let f = z * z + h * h;
        let m = z.abs() + h + p.length() + b.length;
        let log = if f < f64::MIN_POSITIVE { 0.0 } else { f.ln() };
        let arc = if h > 0.0 { 2.0 * h * z * (z / h).atan() } else { 0.0 };
        sum += sign * (0.5 * (z - h) * (z + h) * log - 1.5 * z * z + arc);
        error += m * m * (CORNER_LOG_ROUNDINGS * log.abs() + CORNER_ROUNDINGS) * UNIT_ROUNDOFF;
    }
    let area = a.length * b.length;
    let value = 0.5 * sum / area;
    EdgeIntegral {
        value,
        error: 0.5 * error / area + displacement_error(delta, a.length.max(b.length)),
        evaluations: 4,
    }
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
        // Both sides of a corner: x and z with 2 each, their product, the logarithm's 2, the difference and the sum.
        covers(CORNER_LOG_ROUNDINGS, 2.0 * (2.0 + 2.0 + 1.0 + 2.0 + 1.0 + 2.0));
        // 2 (Δz + Δg) = 2 (2 + 4), −2z with 3, 2g atan with 5 · π, the logarithm of f once more 6, sums 4, the area's share 8; both sides.
        covers(CORNER_ROUNDINGS, 2.0 * (12.0 + 6.0 + 16.0 + 6.0 + 4.0 + 8.0));
        // Two dilogarithms of 24 units, their arguments' 6 times the modulus of continuity 40.
        covers(TRIANGLE_ROUNDINGS, 2.0 * (24.0 + 6.0 * 40.0));
        // Unit vectors with 3 each, feet and residual with 1.
        covers(DISPLACEMENT_ROUNDINGS, 3.0 + 3.0 + 1.0 + 1.0);
        // Both sides of the foot, r and r̃.
        covers(DISPLACEMENT_LOG_FACTOR, 2.0 * 2.0);
    }

    #[test]
    fn displaced_edges_stay_within_bound() {
        // Two parallel unit edges a little apart, moved a little: J in closed form by the same formula.
        let edge =
            |y: f64| ContourEdge::between(zonal_math::vec3(0.0, y, 0.0), zonal_math::vec3(1.0, y, 0.0));
        for (gap, delta) in [(0.0, 1e-3), (1e-3, 1e-3), (0.1, 1e-4)] {
            let [a, b] = [gap, gap + delta].map(|y| closed_form(&edge(0.0), &edge(y)).value);
            assert!((a - b).abs() <= displacement_error(delta, 1.0), "{gap} {delta}");
        }
    }
}
