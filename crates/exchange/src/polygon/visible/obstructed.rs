//! Partly hidden pairs by adaptive rules of low order, for many pairs at moderate accuracy.
//!
//! ```text
//! 𝓕 = (1/π) ∫_a ω⊥(x) dA,    ω⊥(x) the projected solid angle of the visible part of the target in closed form (`occluded_view.rs`)
//! ```
//!
//! The target is a convex polygon or a cone of directions (a part of the sky). The outer polygon a is divided into triangles. On a triangle two
//! rules are compared: the interior rule of Radon (7 points, degree 5) and the closed rule on corners, midpoints of edges and centroid (7 points,
//! degree 3). The error estimate is the larger of their difference and twelve times the root mean square residual of a cubic fit to all 13 values (null
//! rules): over a kink two rules may agree by chance. The triangle with the largest estimate is halved until their sum meets
//! the request: across the edge along which the values bend most, which follows shadows along a long triangle, or the longest of equals. The closed rule reaches the
//! corners, where a target first appears behind an obstruction.
//!
//! A gap or a shadow that no point of either rule meets is not in that estimate. A triangle of area A_t, of N alike, misses features narrower than its points' distances:
//! a share ∝ N⁻¹ of the area, where ω⊥ has reached ∝ N^(−1/2) of its full value. So each error contains
//!
//! ```text
//! κ ω⊥₀ A_t (A_t/A)^(3/2),      ω⊥₀ the largest view without obstructions from its corners and its centroid, κ from random meshes
//! ```
//!
//! Cost: 13 evaluations of ω⊥ for each triangle. Radius: **estimated**.
//!
//! Source of the rules: A. H. Stroud, Approximate Calculation of Multiple Integrals, 1971 (T₂:5-1, T₂:3-1).

use super::convex_polygon::ConvexPolygon;
use super::occluded_view::OccludedView;
use super::{TrianglePart, bisect};
use std::collections::BinaryHeap;
use std::f64::consts::PI;
use std::sync::OnceLock;
use zonal_math::{Bounded, Vec3};

/// Points of both rules on a triangle: the centroid, two orbits of the interior rule, midpoints of edges, corners.
const POINTS: usize = 13;
/// Weights and coordinates of Radon's rule: centroid, then two orbits of three points.
const INTERIOR_CENTROID_WEIGHT: f64 = 0.225;
const INTERIOR_ORBITS: [(f64, f64); 2] = [
    (0.132_394_152_788_506_2, 0.470_142_064_105_115_1),
    (0.125_939_180_544_827_15, 0.101_286_507_323_456_34),
];
/// Weights of the closed rule: centroid, midpoints of edges, corners.
const CLOSED_CENTROID_WEIGHT: f64 = 9.0 / 20.0;
const CLOSED_MIDPOINT_WEIGHT: f64 = 2.0 / 15.0;
const CLOSED_CORNER_WEIGHT: f64 = 1.0 / 20.0;
/// Distance of the closed rule's points from the boundary, relative to that of the centroid: on the boundary itself an adjoining obstruction
/// is seen edge-on, and ω⊥ has not the value of its limit from within.
const BOUNDARY_INSET: f64 = 1e-6;
/// Degree of the polynomials that the null rules annihilate, and their number.
const NULL_DEGREE: i32 = 3;
const MONOMIALS: usize = 10;
/// Factor on the root mean square of the residual in the error: with it, hardly any radius of random meshes is smaller than the error.
const RESIDUAL_SHARE: f64 = 12.0;
/// Points of the edges: corner, middle, corner.
const EDGE_POINTS: [[usize; 3]; 3] = [[10, 7, 12], [12, 9, 11], [11, 8, 10]];
/// Weight of first differences beside second ones in the choice of the edge that is divided.
const SLOPE_SHARE: f64 = 0.25;
/// Changes along edges that count as equal to the largest, relative to it: the longest of these edges is divided.
const EQUAL_CHANGES: f64 = 0.5;
/// κ: with it, no radius of the random meshes is smaller than a third of the error.
const UNDETECTED_SHARE: f64 = 1e-2;
/// Share of the requested radius to which a pair that no point sees is examined.
const UNSEEN_SHARE: f64 = 0.1;
/// Rounding of one integrand relative to π, measured on slivers.
const INTEGRAND_ROUNDING: f64 = 1e-14;

/// The requested radius, max(`relative` 𝓕, `absolute`), and a limit of the cost.
#[derive(Clone, Copy, Debug)]
pub struct IntegrationRequest {
    /// Requested radius relative to the value.
    pub relative: f64,
    /// Requested radius, m².
    pub absolute: f64,
    /// Evaluations of ω⊥ after which the integration stops and states the error reached.
    pub max_evaluations: u64,
}

/// 𝓕 in m² of `a` and the part of the target of `view` that its obstructions leave visible; the view is that of `a` or of a polygon that
/// contains it.
///
/// Grade estimated. A target that no point sees counts as hidden, with a radius of a tenth of the requested one if the cost allows.
pub fn obstructed_exchange(
    a: &ConvexPolygon,
    view: &mut OccludedView,
    request: &IntegrationRequest,
) -> Bounded {
    let most = view.exchange_limit(a);
    if most <= NEGLIGIBLE_SHARE * request.absolute {
        // The visible share lies between none and all.
        let seen = (view.seen_from(a.middle()) * a.area / PI).min(most);
        return Bounded::estimated(seen, seen.max(most - seen));
    }
    let triangles: Vec<[Vec3; 3]> = fan(a).collect();
    integrate(a, &triangles, std::slice::from_mut(view), request)
}

/// Share of the requested radius below which a pair is not integrated: its exchange without obstructions is smaller.
const NEGLIGIBLE_SHARE: f64 = 0.5;

/// 𝓕 in m² of `a` and the visible parts of cones of directions that do not overlap, integrated together: their sum varies less over `a` than
/// each of them. Grade estimated.
pub fn obstructed_sky(
    a: &ConvexPolygon,
    cones: &mut [OccludedView],
    request: &IntegrationRequest,
) -> Bounded {
    // Large facets see much of the surroundings between few obstructions: quarters miss no gap that matters.
    let quarters: Vec<[Vec3; 3]> = fan(a).flat_map(|t| bisect(&t)).flat_map(|t| bisect(&t)).collect();
    integrate(a, &quarters, cones, request)
}

/// 𝓕 in m² of `a` and all directions between the corners of `cell`: A ω⊥/π, exact to rounding.
pub fn unobstructed_sky(a: &ConvexPolygon, cell: &[Vec3]) -> Bounded {
    let Some(view) = OccludedView::of_directions(a, cell) else { return Bounded::ZERO };
    let value = { view }.unobstructed_from(Vec3::ZERO) * a.area / PI;
    Bounded::proved(value, INTEGRAND_ROUNDING * a.area)
}

/// A polygon as triangles.
fn fan(a: &ConvexPolygon) -> impl Iterator<Item = [Vec3; 3]> + '_ {
    (2..a.corners.len()).map(|k| [a.corners[0], a.corners[k - 1], a.corners[k]])
}

/// The integral of the sum of views over `triangles`, which make up `a`. Views that the first rules integrate well enough are not evaluated
/// again.
fn integrate(
    a: &ConvexPolygon,
    triangles: &[[Vec3; 3]],
    views: &mut [OccludedView],
    request: &IntegrationRequest,
) -> Bounded {
    let rounding = INTEGRAND_ROUNDING * a.area;
    let mut first: Vec<(&mut OccludedView, Vec<TriangleSum>)> = Vec::with_capacity(views.len());
    for view in views {
        let sums = triangles.iter().map(|t| views_sum(t, a.area, &mut [&mut *view])).collect();
        first.push((view, sums));
    }
    let evaluations = (first.len() * triangles.len() * POINTS) as u64;
    let error = |sums: &[TriangleSum]| sums.iter().map(|s| s.error).sum::<f64>();
    first.sort_by(|x, y| error(&x.1).total_cmp(&error(&y.1)));
    let rough: f64 = first.iter().flat_map(|f| &f.1).map(|s| s.value).sum();
    let goal = goal_of(request, rough);
    let all_errors: f64 = first.iter().map(|f| error(&f.1)).sum();
    if all_errors <= SETTLED_SHARE * goal {
        return Bounded::estimated(rough / PI, all_errors / PI + rounding);
    }
    let (mut value, mut settled) = (0.0, 0.0);
    let (parts, whole) = (BinaryHeap::new(), a.area);
    let mut work = LowOrderIntegration { views: Vec::new(), parts, whole, evaluations, made: 0 };
    let mut open: Vec<TriangleSum> = vec![TriangleSum::default(); triangles.len()];
    for (view, sums) in first {
        if work.views.is_empty() && settled + error(&sums) <= SETTLED_SHARE * goal {
            settled += error(&sums);
            value += sums.iter().map(|s| s.value).sum::<f64>();
        } else {
            open.iter_mut().zip(&sums).for_each(|(o, s)| o.add(s));
            work.views.push(view);
        }
    }
    triangles.iter().zip(open).for_each(|(t, s)| work.push(*t, &s));
    let sum = work.refine(goal - settled, request.max_evaluations, rounding);
    Bounded::estimated(sum.value + value / PI, sum.radius + settled / PI)
}

/// The requested error, m² sr, for a first value.
fn goal_of(request: &IntegrationRequest, rough: f64) -> f64 {
    let absolute = if rough > 0.0 { request.absolute } else { UNSEEN_SHARE * request.absolute };
    PI * absolute.max(request.relative * rough / PI)
}

/// Share of the requested error for views that are not refined.
const SETTLED_SHARE: f64 = 0.25;

/// The rules on one triangle; sums over views add before moduli are taken.
#[derive(Clone, Copy, Debug, Default)]
struct TriangleSum {
    value: f64,
    /// The estimate for this function alone.
    error: f64,
    area: f64,
    difference: f64,
    null: [f64; POINTS - MONOMIALS],
    /// Estimated error of features narrower than the distances of the points, m² sr.
    undetected: f64,
    /// Second and first differences of the values along each edge, from its first corner on.
    bends: [f64; 3],
    slopes: [f64; 3],
}

impl TriangleSum {
    fn add(&mut self, o: &TriangleSum) {
        self.value += o.value;
        self.area = o.area;
        self.undetected += o.undetected;
        (0..3).for_each(|k| self.bends[k] += o.bends[k]);
        (0..3).for_each(|k| self.slopes[k] += o.slopes[k]);
        self.difference += o.difference;
        self.null.iter_mut().zip(&o.null).for_each(|(a, b)| *a += b);
    }

    fn error(&self) -> f64 {
        let residual = (self.null.iter().map(|n| n * n).sum::<f64>() / POINTS as f64).sqrt();
        self.difference.abs().max(RESIDUAL_SHARE * residual) * self.area + self.undetected
    }

    /// The corners from the edge on that is divided.
    fn turned(&self, t: &[Vec3; 3]) -> [Vec3; 3] {
        let change = |k: usize| self.bends[k].abs() + SLOPE_SHARE * self.slopes[k].abs();
        let most = (0..3).fold(0.0f64, |s, k| s.max(change(k)));
        let length = |k: usize| (t[(k + 1) % 3] - t[k]).length2();
        let first = (0..3).filter(|k| change(*k) >= EQUAL_CHANGES * most);
        let first = first.max_by(|k, l| length(*k).total_cmp(&length(*l))).unwrap_or(0);
        std::array::from_fn(|k| t[(first + k) % 3])
    }
}

/// The rules on a triangle of a polygon of area `whole` (m²) for the sum of views.
fn views_sum(t: &[Vec3; 3], whole: f64, views: &mut [&mut OccludedView]) -> TriangleSum {
    let mut sum = triangle_sum(t, &mut |x| views.iter_mut().map(|v| v.seen_from(x)).sum());
    let middle = (t[0] + t[1] + t[2]) / 3.0;
    let inset = t.map(|c| c + (middle - c) * BOUNDARY_INSET);
    let mut most = |x: Vec3| views.iter_mut().map(|v| v.unobstructed_from(x)).sum::<f64>();
    let most = inset.into_iter().fold(most(middle), |s, x| s.max(most(x)));
    sum.undetected = UNDETECTED_SHARE * most * sum.area * (sum.area / whole).powf(1.5);
    sum.error = sum.error();
    sum
}

/// A triangle cut from the middle of its first edge.
fn halves(&[a, b, c]: &[Vec3; 3]) -> [[Vec3; 3]; 2] {
    let m = (a + b) * 0.5;
    [[a, m, c], [m, b, c]]
}

fn triangle_sum([a, b, c]: &[Vec3; 3], f: &mut impl FnMut(Vec3) -> f64) -> TriangleSum {
    static RULES: OnceLock<TriangleRules> = OnceLock::new();
    let rules = RULES.get_or_init(make_triangle_rules);
    let values: [f64; POINTS] = std::array::from_fn(|k| {
        let [u, v, w] = rules.points[k];
        f(*a * u + *b * v + *c * w)
    });
    let sum = |weights: &[f64; POINTS]| weights.iter().zip(&values).map(|(w, f)| w * f).sum::<f64>();
    let area = 0.5 * (*b - *a).cross(*c - *a).length();
    let null = std::array::from_fn(|k| sum(&rules.null[k]));
    let mut made = TriangleSum {
        value: sum(&rules.interior) * area,
        error: 0.0,
        area,
        difference: sum(&rules.difference),
        null,
        undetected: 0.0,
        bends: EDGE_POINTS.map(|[a, m, b]| values[a] - 2.0 * values[m] + values[b]),
        slopes: EDGE_POINTS.map(|[a, _, b]| values[a] - values[b]),
    };
    made.error = made.error();
    made
}

/// Both rules on a triangle, and the rules that vanish for cubic polynomials.
struct TriangleRules {
    /// Barycentric coordinates.
    points: [[f64; 3]; POINTS],
    /// Weights of the interior rule; they sum to one.
    interior: [f64; POINTS],
    /// Interior minus closed rule.
    difference: [f64; POINTS],
    /// An orthonormal basis of the weights that annihilate polynomials up to [`NULL_DEGREE`].
    null: [[f64; POINTS]; POINTS - MONOMIALS],
}

fn make_triangle_rules() -> TriangleRules {
    let third = 1.0 / 3.0;
    let mut points = vec![[third; 3]];
    let (mut interior, mut closed) = (vec![INTERIOR_CENTROID_WEIGHT], vec![CLOSED_CENTROID_WEIGHT]);
    let mut orbit = |at: [f64; 3], inner: f64, outer: f64| {
        for k in 0..3 {
            points.push([at[k], at[(k + 1) % 3], at[(k + 2) % 3]]);
            interior.push(inner);
            closed.push(outer);
        }
    };
    for (weight, share) in INTERIOR_ORBITS {
        orbit([1.0 - 2.0 * share, share, share], weight, 0.0);
    }
    let inset = |at: [f64; 3]| at.map(|x| x + (third - x) * BOUNDARY_INSET);
    orbit(inset([0.5, 0.5, 0.0]), 0.0, CLOSED_MIDPOINT_WEIGHT);
    orbit(inset([1.0, 0.0, 0.0]), 0.0, CLOSED_CORNER_WEIGHT);
    TriangleRules {
        points: std::array::from_fn(|k| points[k]),
        interior: std::array::from_fn(|k| interior[k]),
        difference: std::array::from_fn(|k| interior[k] - closed[k]),
        null: null_rules(&points),
    }
}

/// Orthonormal weights perpendicular to all monomials of the first two coordinates: the unit vectors, with those parts removed twice (against
/// rounding), in the order of the points.
fn null_rules(points: &[[f64; 3]]) -> [[f64; POINTS]; POINTS - MONOMIALS] {
    let exponents = (0..=NULL_DEGREE).flat_map(|i| (0..=NULL_DEGREE - i).map(move |j| (i, j)));
    let monomials =
        exponents.map(|(i, j)| std::array::from_fn(|k| points[k][0].powi(i) * points[k][1].powi(j)));
    let units = (0..POINTS).map(|k| std::array::from_fn(|l| f64::from(u8::from(k == l))));
    let mut basis: Vec<[f64; POINTS]> = Vec::with_capacity(POINTS);
    for mut v in monomials.chain(units) {
        let before = dot(&v, &v).sqrt();
        for _ in 0..2 {
            for b in &basis {
                let along = dot(&v, b);
                (0..POINTS).for_each(|k| v[k] -= along * b[k]);
            }
        }
        let length = dot(&v, &v).sqrt();
        if length > 1e-6 * before && basis.len() < POINTS {
            basis.push(v.map(|x| x / length));
        }
    }
    std::array::from_fn(|k| basis[MONOMIALS + k])
}

fn dot(a: &[f64; POINTS], b: &[f64; POINTS]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

struct LowOrderIntegration<'a> {
    views: Vec<&'a mut OccludedView>,
    parts: BinaryHeap<TrianglePart>,
    /// Area of the polygon, m².
    whole: f64,
    evaluations: u64,
    made: u64,
}

impl LowOrderIntegration<'_> {
    /// Adds a triangle; returns its error.
    fn add_triangle(&mut self, corners: [Vec3; 3]) -> f64 {
        let sum = views_sum(&corners, self.whole, &mut self.views);
        self.evaluations += (POINTS * self.views.len()) as u64;
        self.push(corners, &sum);
        sum.error
    }

    fn push(&mut self, corners: [Vec3; 3], sum: &TriangleSum) {
        let (value, error, corners) = (sum.value, sum.error(), sum.turned(&corners));
        self.parts.push(TrianglePart { corners, value, error, made: self.made });
        self.made += 1;
    }

    /// Halves triangles until the sum of their errors is at most `goal` (m² sr).
    fn refine(mut self, goal: f64, max_evaluations: u64, rounding: f64) -> Bounded {
        let sums = |parts: &BinaryHeap<TrianglePart>| {
            parts.iter().fold((0.0, 0.0), |(v, e), p| (v + p.value, e + p.error))
        };
        let (_, mut error) = sums(&self.parts);
        while error > goal && self.evaluations < max_evaluations {
            let part = self.parts.pop().expect("a polygon has triangles");
            error -= part.error;
            for t in halves(&part.corners) {
                error += self.add_triangle(t);
            }
        }
        let (value, error) = sums(&self.parts);
        Bounded::estimated(value / PI, error / PI + rounding)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polygon::visible::ConvexBody;
    use zonal_math::vec3;
    use zonal_reference::visible_views::VisibleScene;

    fn rectangle(at: Vec3, e: Vec3, f: Vec3) -> ConvexPolygon {
        ConvexPolygon::new(vec![at, at + e, at + e + f, at + f]).expect("a rectangle")
    }

    #[test]
    fn hidden_parts_agree_with_exact_views() {
        let floor = rectangle(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        let top = rectangle(vec3(0.0, 0.0, 1.0), vec3(0.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0));
        for (x, size) in [(0.3, 0.4), (0.0, 0.5), (0.8, 0.4)] {
            let screen = rectangle(vec3(x, 0.2, 0.5), vec3(size, 0.0, 0.0), vec3(0.0, size, 0.0));
            let request = IntegrationRequest { relative: 1e-4, absolute: 0.0, max_evaluations: 100_000 };
            let mut view = OccludedView::default();
            view.set_polygon(&floor, &top);
            view.add(&ConvexBody::plate(&screen));
            let ours = obstructed_exchange(&floor, &mut view, &request);
            let corners = [&floor, &top].map(|p| p.corners().to_vec());
            let row = VisibleScene::new(&corners, &[screen.corners().to_vec()]).row(0, 1e-7, 10_000);
            let exact = &row.facets[1];
            let off = (ours.value - exact.value * floor.area()).abs();
            assert!(off <= ours.radius + exact.error * floor.area(), "{x}: {ours:?} {exact:?}");
            assert!(ours.radius <= 1.01e-4 * ours.value);
        }
    }

    #[test]
    fn cells_of_the_whole_sky_sum_to_the_area() {
        let plate = rectangle(vec3(0.3, 0.1, 0.0), vec3(2.0, 0.3, 0.1), vec3(-0.2, 1.0, 0.4));
        let corners = |k: usize, s: f64| {
            let at = |u: f64, v: f64| {
                let mut d = [0.0; 3];
                (d[k], d[(k + 1) % 3], d[(k + 2) % 3]) = (s, u, v);
                Vec3::from_array(d)
            };
            let mut c = vec![at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)];
            if s > 0.0 {
                c.reverse();
            }
            c
        };
        let cells = (0..3).flat_map(|k| [1.0, -1.0].map(|s| corners(k, s)));
        let sum = cells.fold(Bounded::ZERO, |sum, c| sum + unobstructed_sky(&plate, &c));
        assert!((sum.value - plate.area()).abs() <= sum.radius, "{sum:?} {}", plate.area());
    }
}
