//! The exchange area of two convex polygons with convex obstructions between them.
//!
//! 𝓕 = (1/π) ∫_a ω⊥(x) dA, m², with ω⊥(x) the projected solid angle of the part of b visible from x. For one point x all is in closed
//! form: the cone from x over a convex obstruction is an intersection of half-spaces, so b minus the cones is a set of convex polygons
//! (`occluded_view`), and each has Lambert's sum over its edges,
//!
//!   ω⊥ = ½ Σ_k γ_k n·ν_k   (γ_k: the angle that edge k spans from x; ν_k: the unit normal of the plane of x and the edge).
//!
//! **Sides.** Fronts exchange: a is cut to the half-space in front of b and b to the half-space in front of a. Obstructions occlude from both
//! sides. They are cut to both half-spaces as well, so that any part of one in a cone from x lies between x and b.
//!
//! **Culling.** An obstruction occludes nothing if a plane has it on one side and both polygons on the other: its own plane, or a plane
//! through an edge of the one and a corner of the other that leaves both on one side. The latter are all planes of the convex hull
//! of a ∪ b but the two polygons' own, which the cut already covers.
//!
//! **Integration.** ω⊥(x) is continuous. Its derivatives jump where x crosses a critical segment (`critical_segments`): the shadow of an
//! obstruction's edge cast on the plane of a by a corner of b, and the like. They are straight. So a is cut into triangles, along
//! critical segments before anything else; a triangle takes two Gauss rules (collapsed coordinates); that with the largest
//! difference is cut, along a critical segment if one crosses it, else across its longest edge, until the sum of the differences meets
//! the requested accuracy. The remaining irregularities are jumps of second derivatives along curves (three edges that meet in a point of the
//! view), which
//! the halving resolves. The error is **estimated**: a shadow that contains no point of either rule, cast by an obstruction
//! along whose segments no triangle was cut, goes undetected.
//!
//! **Without obstructions** the outer integral is in closed form too (`super::contour`).
//!
//! The two polygons are ordered before the work, the smaller one outside: F_ab and F_ba are identical to the bit.

mod convex_body;
mod convex_polygon;
mod critical_segments;
mod obstructed;
mod occluded_view;

pub use convex_body::ConvexBody;
pub use convex_polygon::ConvexPolygon;
pub use obstructed::{IntegrationRequest, obstructed_exchange, obstructed_sky, unobstructed_sky};
pub use occluded_view::OccludedView;

use super::contour::{self, Contour, HEIGHT_ROUNDINGS};
use crate::{AccuracyRequest, Factor, Method};
use convex_polygon::RELATIVE_CONTACT_DISTANCE;
use critical_segments::CriticalSegment;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::PI;
use zonal_math::{Bounded, Vec3, gauss_legendre};

/// Points in each direction of the rule for the value.
const FINE_RULE_POINTS: usize = 6;
/// Points in each direction of the rule for the error estimate.
const COARSE_RULE_POINTS: usize = 4;
/// Triangles, at most, of the initial cut along critical segments.
const MAX_INITIAL_TRIANGLES: usize = 192;
/// Factor on the difference of the rules on a triangle that a critical segment still crosses: over a kink two rules may agree by chance.
const KINK_ERROR_FACTOR: f64 = 4.0;
/// Radius of the first contour sum, relative to the smaller area.
const FIRST_CONTOUR_RADIUS: f64 = 1e-9;
/// Rounding of one integrand relative to π, measured on slivers.
const INTEGRAND_ROUNDING: f64 = 1e-14;

/// 𝓕 of the fronts of `a` and `b`, m², with `obstructions` between them, to a radius of `accuracy` or of `floor` (m²), whichever is
/// larger. Grade estimated; method [`Method::Clipped`], or [`Method::Contour`] without potential occluders. The obstructions may include `a` and `b`.
pub fn visible_exchange(
    a: &ConvexPolygon,
    b: &ConvexPolygon,
    obstructions: &[ConvexPolygon],
    accuracy: &AccuracyRequest,
    floor: f64,
) -> Factor {
    let (a, b) = if is_canonical_order(a, b) { (a, b) } else { (b, a) };
    let size = a.corners.iter().chain(&b.corners).fold(0.0f64, |s, c| s.max((*c - a.corners[0]).length()));
    let eps = RELATIVE_CONTACT_DISTANCE * size;
    let (Some(outer), Some(inner)) = (a.in_front_of(b, eps), b.in_front_of(a, eps)) else {
        return Factor::NOT_VISIBLE;
    };
    let potential_occluders = potential_occluders(&outer, &inner, obstructions, eps);
    if potential_occluders.is_empty() {
        return unobstructed(&outer, &inner, size, accuracy, floor);
    }
    let segments = critical_segments::critical_segments(&outer, &inner, &potential_occluders);
    let mut view = OccludedView::of_polygon(&outer, &inner);
    potential_occluders.iter().for_each(|o| view.add(&ConvexBody::plate(o)));
    let parts = BinaryHeap::new();
    let mut work =
        AdaptiveIntegration { view, segments: &segments, parts, scale: inner.area, made: 0, evaluations: 0 };
    work.add_initial_triangles(&outer);
    work.refine(accuracy, floor)
}

/// The contour formula; its radius does not cover corners that the cut moved onto the plane: estimated.
fn unobstructed(
    a: &ConvexPolygon,
    b: &ConvexPolygon,
    size: f64,
    accuracy: &AccuracyRequest,
    floor: f64,
) -> Factor {
    let displaced = HEIGHT_ROUNDINGS * f64::EPSILON * size;
    let contour = |p: &ConvexPolygon| Contour {
        corners: p.corners.iter().map(|c| *c - a.corners[0]).collect(),
        displaced,
    };
    let (first, second) = (contour(a), contour(b));
    let rough = contour::sum(&first, &second, FIRST_CONTOUR_RADIUS * a.area);
    let wanted = accuracy.radius(rough.value).max(floor);
    let fine = if rough.radius <= wanted { rough } else { contour::sum(&first, &second, 0.5 * wanted) };
    let evaluations = rough.evaluations + if rough.radius <= wanted { 0 } else { fine.evaluations };
    let bounded = Bounded::estimated(fine.value.max(0.0), fine.radius);
    Factor { bounded, evaluations, method: Method::Contour }
}

/// True if `a` is smaller, or equal in area and first in the lexicographic order of corners.
fn is_canonical_order(a: &ConvexPolygon, b: &ConvexPolygon) -> bool {
    let key = |p: &ConvexPolygon| p.corners.iter().flat_map(|c| c.array()).collect::<Vec<f64>>();
    a.area.total_cmp(&b.area).then_with(|| key(a).partial_cmp(&key(b)).unwrap_or(Ordering::Equal)).is_le()
}

/// The parts of the obstructions that can occlude.
fn potential_occluders(
    a: &ConvexPolygon,
    b: &ConvexPolygon,
    obstructions: &[ConvexPolygon],
    eps: f64,
) -> Vec<ConvexPolygon> {
    let mut shaft = Vec::new();
    add_shaft_planes(a, b, eps, &mut shaft);
    let cut = |o: &ConvexPolygon| o.in_front_of(a, eps).and_then(|o| o.in_front_of(b, eps));
    let mut kept: Vec<ConvexPolygon> = obstructions
        .iter()
        .filter(|o| !shaft.iter().any(|(n, c)| o.corners.iter().all(|x| n.dot(*x) >= c - eps)))
        .filter_map(cut)
        .filter(|o| {
            let h = || a.corners.iter().chain(&b.corners).map(|c| o.height(*c));
            !(h().all(|x| x <= eps) || h().all(|x| x >= -eps))
        })
        .filter(|o| !shaft.iter().any(|(n, c)| o.corners.iter().all(|x| n.dot(*x) >= c - eps)))
        .collect();
    // The two sides of a thin wall are one obstruction.
    let mut k = 0;
    while k < kept.len() {
        let twin = |o: &ConvexPolygon| same_corners(o, &kept[k], eps);
        if kept[..k].iter().any(twin) {
            kept.remove(k);
        } else {
            k += 1;
        }
    }
    kept
}

fn same_corners(a: &ConvexPolygon, b: &ConvexPolygon, eps: f64) -> bool {
    let near = |x: &Vec3| b.corners.iter().any(|y| (*x - *y).max_abs() <= eps);
    a.corners.len() == b.corners.len() && a.corners.iter().all(near)
}

/// Adds the planes (n, c) with n·x ≤ c for all of a and b, to `contact` (m), that go through an edge of the one and a corner of the other. What lies
/// beyond one of them is not between a and b.
pub fn add_shaft_planes(a: &ConvexPolygon, b: &ConvexPolygon, contact: f64, planes: &mut Vec<(Vec3, f64)>) {
    for (p, q) in [(a, b), (b, a)] {
        for (k, s) in p.corners.iter().enumerate() {
            let edge = p.corners[(k + 1) % p.corners.len()] - *s;
            for v in &q.corners {
                let n = edge.cross(*v - *s);
                let length = n.length();
                if length <= RELATIVE_CONTACT_DISTANCE * edge.length2() {
                    continue;
                }
                let n = n / length;
                let c = n.dot(*s);
                let heights = || a.corners.iter().chain(&b.corners).map(|x| n.dot(*x) - c);
                if heights().all(|h| h <= contact) {
                    planes.push((n, c));
                }
                if heights().all(|h| h >= -contact) {
                    planes.push((-n, -c));
                }
            }
        }
    }
}

/// A triangle of a with its integral and the estimate of its error, both times π.
struct TrianglePart {
    corners: [Vec3; 3],
    value: f64,
    error: f64,
    made: u64,
}

impl PartialEq for TrianglePart {
    fn eq(&self, o: &TrianglePart) -> bool {
        self.cmp(o).is_eq()
    }
}
impl Eq for TrianglePart {}
impl PartialOrd for TrianglePart {
    fn partial_cmp(&self, o: &TrianglePart) -> Option<Ordering> {
        Some(self.cmp(o))
    }
}
impl Ord for TrianglePart {
    /// The worst first; of equals the older.
    fn cmp(&self, o: &TrianglePart) -> Ordering {
        self.error.total_cmp(&o.error).then(o.made.cmp(&self.made))
    }
}

struct AdaptiveIntegration<'a> {
    view: OccludedView,
    segments: &'a [CriticalSegment],
    parts: BinaryHeap<TrianglePart>,
    /// Area of the inner polygon, the scale of rounding errors, m².
    scale: f64,
    made: u64,
    evaluations: u64,
}

impl AdaptiveIntegration<'_> {
    /// The polygon in triangles, cut along the shadows that each obstruction casts by itself.
    fn add_initial_triangles(&mut self, outer: &ConvexPolygon) {
        let c = &outer.corners;
        let mut triangles: Vec<[Vec3; 3]> = (2..c.len()).map(|k| [c[0], c[k - 1], c[k]]).collect();
        for s in self.segments.iter().filter(|s| s.first) {
            if triangles.len() > MAX_INITIAL_TRIANGLES {
                break;
            }
            triangles = triangles.into_iter().flat_map(|t| s.cut(&t).unwrap_or_else(|| vec![t])).collect();
        }
        for t in triangles {
            self.add_triangle(t);
        }
    }

    fn add_triangle(&mut self, corners: [Vec3; 3]) -> (f64, f64) {
        let (value, coarse) =
            (self.apply_rule(&corners, FINE_RULE_POINTS), self.apply_rule(&corners, COARSE_RULE_POINTS));
        let unsettled = self.segments.iter().any(|s| s.first && s.crosses(&corners));
        let error = (value - coarse).abs() * if unsettled { KINK_ERROR_FACTOR } else { 1.0 };
        self.parts.push(TrianglePart { corners, value, error, made: self.made });
        self.made += 1;
        (value, error)
    }

    /// ∫ ω⊥ dA over a triangle: x = a + u (b − a) + u v (c − b), dA = 2 A u du dv.
    fn apply_rule(&mut self, [a, b, c]: &[Vec3; 3], n: usize) -> f64 {
        let rule = gauss_legendre::rule(n);
        let (first, second) = (*b - *a, *c - *b);
        let mut sum = 0.0;
        for (u, wu) in rule.nodes.iter().zip(&rule.weights) {
            for (v, wv) in rule.nodes.iter().zip(&rule.weights) {
                sum += wu * wv * u * self.view.seen_from(*a + first * *u + second * (u * v));
            }
        }
        self.evaluations += (n * n) as u64;
        sum * first.cross(second).length()
    }

    fn refine(mut self, accuracy: &AccuracyRequest, floor: f64) -> Factor {
        let sums = |parts: &BinaryHeap<TrianglePart>| {
            parts.iter().fold((0.0, 0.0, 0.0), |(v, e, m), p| (v + p.value, e + p.error, p.error.max(m)))
        };
        let (mut value, mut error, _) = sums(&self.parts);
        let noise = INTEGRAND_ROUNDING * self.scale;
        loop {
            let wanted = PI * accuracy.radius(value / PI).max(floor);
            let worst = self.parts.peek().map_or(0.0, |p| p.error);
            if error <= wanted
                || self.evaluations >= accuracy.max_evaluations
                || worst <= noise * INTEGRAND_ROUNDING
            {
                break;
            }
            let part = self.parts.pop().expect("a part");
            (value, error) = (value - part.value, error - part.error);
            let cut = self.segments.iter().find_map(|s| s.cut(&part.corners));
            for t in cut.unwrap_or_else(|| bisect(&part.corners)) {
                let (v, e) = self.add_triangle(t);
                (value, error) = (value + v, error + e);
            }
        }
        let (value, error, _) = sums(&self.parts);
        let bounded = Bounded::estimated(value / PI, error / PI + INTEGRAND_ROUNDING * value.abs());
        Factor { bounded, evaluations: self.evaluations, method: Method::Clipped }
    }
}

/// A triangle cut from the middle of its longest edge.
fn bisect(&[a, b, c]: &[Vec3; 3]) -> Vec<[Vec3; 3]> {
    let turns = [[a, b, c], [b, c, a], [c, a, b]];
    let longest = |t: &[Vec3; 3]| (t[1] - t[0]).length2();
    let [a, b, c] = turns.into_iter().max_by(|s, t| longest(s).total_cmp(&longest(t))).expect("three turns");
    let m = (a + b) * 0.5;
    vec![[a, m, c], [m, b, c]]
}
