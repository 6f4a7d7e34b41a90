//! Two polygons without a medium by their contours, exactly.
//!
//! For polygons wholly in front of each other, Stokes' theorem twice gives (edges e_i, f_j, both counter-clockwise from the fronts)
//!
//! ```text
//! 𝓕 = (1/2π) Σ_ij e_i·f_j J_ij,        J_ij = ∬ ln r ds dt over the two edges       (`edge_integral.rs`, `edge_closed_form.rs`)
//! ```
//!
//! **Clipping.** Parts behind the plane of the other polygon are cut away first.
//!
//! **Proof.** The radius adds |e_i·f_j| ΔJ_ij, the roundings of e_i·f_j, of products and of the sum, and the effect of displaced corners: a contour
//! moved by at most δ changes 𝓕 by at most δ · length · |E|, for d𝓕 = ∮ (δ × dx)·E(x) with the irradiance vector E of the other
//! polygon, |E| ≤ 1 for one polygon (and at most r²/g² for one within a
//! disc of radius r at a distance g) and twice that while its corners are a little off a plane. Corners move by the rounding of their places
//! relative to the other plate, and by the rounding of heights where they are cut. A height that errs by at most η moves the line of the cut by
//! η/sinα across itself, α the angle of the two planes: its ends slide along the edges that were cut, and an edge that slides along itself
//! sweeps no area. So only the largest slope of the polygon's height enters, not the slopes of these edges:
//! sinα ≥ |h_i − h_j|/|c_i − c_j| for any two corners. Heights within their rounding count as zero, which moves corners as far.
//!
//! Lengths are scaled by a power of two, which rounds nothing.

use super::edge_integral;
use super::segment::{ContourEdge, EdgeIntegral};
use std::f64::consts::PI;
use zonal_math::Vec3;

/// Unit roundoff 2⁻⁵³.
const UNIT_ROUNDOFF: f64 = 0.5 * f64::EPSILON;
/// |E| while corners are off the plane (header).
const IRRADIANCE_BOUND: f64 = 2.0; // bound
/// Roundings of e_i·f_j and of its product with J.
const PRODUCT_ROUNDINGS: f64 = 8.0; // bound
/// Roundings of a height above a plane, relative to the lengths.
pub(super) const HEIGHT_ROUNDINGS: f64 = 16.0; // bound

/// Bound of the factor of the part of a plate below a height η over the other plane, per η and length: irradiance 2 times a displacement 2η.
pub(super) const COPLANAR_BOUND: f64 = 4.0; // bound

/// Value and radius in m², with the logarithms that it took.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContourSum {
    pub value: f64,
    pub radius: f64,
    pub evaluations: u64,
}

/// A polygon's corners in a frame near both, m, and how far each may be from its true place.
#[derive(Clone, Debug)]
pub(super) struct Contour {
    pub corners: Vec<Vec3>,
    pub displaced: f64,
}

impl Contour {
    fn length(&self) -> f64 {
        let n = self.corners.len();
        (0..n).map(|k| (self.corners[(k + 1) % n] - self.corners[k]).length()).sum()
    }
    /// A sphere about the corners.
    fn bounding_sphere(&self) -> (Vec3, f64) {
        let centre = self.corners.iter().fold(Vec3::ZERO, |s, c| s + *c) / self.corners.len() as f64;
        (centre, self.corners.iter().fold(0.0f64, |s, c| s.max((*c - centre).length())))
    }
    fn segments(&self, scale: f64) -> Vec<ContourEdge> {
        let n = self.corners.len();
        let made =
            (0..n).map(|k| ContourEdge::between(self.corners[k] * scale, self.corners[(k + 1) % n] * scale));
        made.filter(|s| s.length > 0.0).collect()
    }
    /// A lower bound of the sine between the polygon's plane and that over which heights, right to `eps`, are measured.
    fn largest_slope_sine(&self, height: &dyn Fn(Vec3) -> f64, eps: f64) -> f64 {
        let mut least = 0.0f64;
        for (i, p) in self.corners.iter().enumerate() {
            for q in &self.corners[..i] {
                let (rise, run) = ((height(*p) - height(*q)).abs() - 2.0 * eps, (*p - *q).length());
                least =
                    if rise > 0.0 { least.max(rise / (run * (1.0 + 8.0 * UNIT_ROUNDOFF))) } else { least };
            }
        }
        least
    }
    /// The part in front of the plane through `at` with the unit normal; None where no corner rises above `eps`.
    pub(super) fn in_front(&self, at: Vec3, normal: Vec3, eps: f64) -> Option<Contour> {
        // A corner within its rounding of the plane counts as in it: cut edges rise by more than that.
        let height = |c: &Vec3| normal.dot(*c - at);
        let h: Vec<f64> =
            self.corners.iter().map(height).map(|h| if h.abs() <= eps { 0.0 } else { h }).collect();
        if h.iter().all(|x| *x <= 0.0) {
            return None;
        }
        if h.iter().all(|x| *x >= 0.0) {
            // Corners that are certainly in front stay where they are.
            let slip = if h.iter().all(|x| *x > 0.0) { 0.0 } else { eps };
            return Some(Contour { displaced: self.displaced + slip, ..self.clone() });
        }
        let mut cut = Contour { corners: Vec::with_capacity(h.len() + 1), displaced: self.displaced + eps };
        let n = h.len();
        let climb = self.largest_slope_sine(&|c| normal.dot(c - at), eps);
        for i in 0..n {
            let j = (i + 1) % n;
            if h[i] >= 0.0 {
                cut.corners.push(self.corners[i]);
            }
            if h[i] * h[j] < 0.0 {
                let (edge, rise) = (self.corners[j] - self.corners[i], (h[i] - h[j]).abs());
                cut.corners.push(self.corners[i] + edge * (h[i] / (h[i] - h[j])));
                let slip = ((eps / rise).min(1.0) * edge.length()).min(eps / climb);
                cut.displaced = cut.displaced.max(self.displaced + eps + slip);
            }
        }
        Some(cut)
    }
}

/// 𝓕 of two polygons in front of each other, m², with a truncation below `wanted` where attainable.
pub(super) fn sum(a: &Contour, b: &Contour, wanted: f64) -> ContourSum {
    let scale = scale_to_unit(a, b);
    let (first, second) = (a.segments(scale), b.segments(scale));
    let share = wanted * scale * scale * PI / (first.len() * second.len()) as f64;
    let (mut value, mut error, mut size, mut evaluations) = (0.0, 0.0, 0.0, 0);
    for e in &first {
        for f in &second {
            let (c, cap) = (e.edge.dot(f.edge), e.length * f.length);
            let part: EdgeIntegral = edge_integral::integral(e, f, share / c.abs().max(1e-3 * cap));
            value += c * part.value;
            size += (c * part.value).abs();
            error += (c.abs() + PRODUCT_ROUNDINGS * UNIT_ROUNDOFF * cap) * part.error
                + PRODUCT_ROUNDINGS * UNIT_ROUNDOFF * cap * part.value.abs();
            evaluations += part.evaluations;
        }
    }
    let back = 0.5 / (PI * scale * scale);
    let terms = (first.len() * second.len()) as f64;
    let [from_a, from_b] = irradiance_bounds(a, b);
    let moved = a.displaced * a.length() * from_b + b.displaced * b.length() * from_a;
    let radius = (error + (terms + PRODUCT_ROUNDINGS) * UNIT_ROUNDOFF * size) * back + moved;
    ContourSum { value: value * back, radius: radius * (1.0 + 64.0 * UNIT_ROUNDOFF), evaluations }
}

/// Bounds of the irradiance vectors that a causes at b and b at a: a disc of radius r seen from a distance of at least g gives r²/g².
fn irradiance_bounds(a: &Contour, b: &Contour) -> [f64; 2] {
    let (p, q) = (a.bounding_sphere(), b.bounding_sphere());
    let gap = ((p.0 - q.0).length() - p.1 - q.1).max(0.0);
    [p.1, q.1].map(|r| IRRADIANCE_BOUND * if r < gap { 1.001 * (r / gap).powi(2) } else { 1.0 })
}

/// The power of two that brings the pair's extent to between one half and one.
fn scale_to_unit(a: &Contour, b: &Contour) -> f64 {
    let at = a.corners[0];
    let extent = a.corners.iter().chain(&b.corners).fold(0.0f64, |s, c| s.max((*c - at).max_abs()));
    let exponent = (extent.to_bits() >> 52) as i64 - 1022;
    2f64.powi(-exponent as i32)
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
        // |E| ≤ 1 for one polygon, once more for the area between it and the displaced one.
        covers(IRRADIANCE_BOUND, 1.0 + 1.0);
        // Three products and two sums of e·f, the product with J, its place in the sum of sizes.
        covers(PRODUCT_ROUNDINGS, 3.0 + 2.0 + 1.0 + 1.0);
        // An irradiance of 1 for each of two plates off by the height and its error.
        covers(COPLANAR_BOUND, 2.0 * (1.0 + 1.0));
        // Difference, normal (4), product, two sums, of components that add up to twice the lengths.
        covers(HEIGHT_ROUNDINGS, 2.0 * (1.0 + 4.0 + 1.0 + 2.0));
    }

    #[test]
    fn irradiance_stays_below_bound() {
        // Two squares face to face: the mean irradiance is the view factor, below r²/g².
        let square = |z: f64| Contour {
            corners: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
                .map(|[x, y]| zonal_math::vec3(x, y, z))
                .to_vec(),
            displaced: 0.0,
        };
        for z in [3.0, 5.0, 20.0] {
            let (a, mut b) = (square(0.0), square(z));
            b.corners.reverse();
            let f = sum(&a, &b, 1e-12);
            let [bound, _] = irradiance_bounds(&a, &b);
            assert!(f.value > 0.0 && f.value < bound, "{z}: {f:?} {bound}");
        }
    }
}
