//! Two convex polygons with others between them: the exchange area over what the obstructions leave to be seen.
//!
//! 𝓕 = (1/π) ∫_a ω⊥(x) dA, m², with ω⊥(x) the projected solid angle of that part of b which x sees. For one point x all is in closed
//! form: the cone from x over a convex obstruction is an intersection of half-spaces, so b minus the cones is a set of convex polygons
//! (`clip`), and each has Lambert's sum over its edges,
//!
//!   ω⊥ = ½ Σ_k γ_k n·ν_k   (γ_k: the angle that edge k spans from x; ν_k: the unit normal of the plane of x and the edge).
//!
//! **Sides.** Fronts exchange: a is cut to the half-space in front of b and b to the half-space in front of a. Obstructions hide from both
//! sides. They too are cut to both half-spaces, so that whatever of one lies in a cone from x lies between x and b.
//!
//! **Culling.** An obstruction hides nothing if a plane has it on one side and both polygons on the other: its own plane, or a plane
//! through an edge of the one and a corner of the other that leaves both on one side. The latter are all planes of the convex hull
//! of a ∪ b but the two polygons' own, which the cut has seen to.
//!
//! **Integration.** ω⊥(x) is continuous. Its derivatives jump where x crosses a critical segment (`critical`): the shadow of an
//! obstruction's edge cast on the plane of a by a corner of b, and the like. They are straight. So a is cut into triangles, along
//! critical segments before anything else; a triangle takes two Gauss rules (collapsed coordinates); that with the largest
//! difference is cut, along a critical segment if one crosses it, else across its longest edge, until the differences sum up to less
//! than is asked. What remains are jumps of second derivatives along curves (three edges that meet in a point of the view), which
//! the halving resolves. The error is **estimated**: a shadow that no point of either rule falls in, cast by an obstruction
//! whose segments were not yet cut along, is not seen.
//!
//! **Without obstructions** the outer integral is in closed form too (`super::contour`).
//!
//! The two polygons are ordered before the work, the smaller one outside: F_ab and F_ba are the same bits.

pub(crate) mod clip;
pub(crate) mod critical;

use super::contour::{self, Contour, HEIGHT};
use crate::{Demand, Factor, Method};
use clip::View;
use critical::Segment;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::PI;
use zonal_math::{Bounded, Vec3, gauss};
use zonal_scene::Plate;

/// Points in each direction of the rule that gives the value.
const FINE: usize = 6;
/// Points in each direction of the rule that it is compared with.
const COARSE: usize = 4;
/// Triangles up to which critical segments are cut along before any value is known.
const FORCED: usize = 192;
/// What the difference of the rules is multiplied by on a triangle that a critical segment still crosses: over a kink two rules may
/// agree by chance.
const UNSETTLED: f64 = 4.0;
/// Distances below this part of the polygons' size count as none: corners that are shared, walls that stand on each other.
const TOUCH: f64 = 1e-10;
/// Radius of the first contour sum, relative to the smaller area.
const ROUGH: f64 = 1e-9;
/// Rounding of one integrand relative to π, by experience with slivers.
const ROUNDING: f64 = 1e-14;

/// A flat convex polygon; its front sees the corners counter-clockwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    corners: Vec<Vec3>,
    normal: Vec3,
    area: f64,
}

impl Polygon {
    /// A polygon from its corners, m, counter-clockwise from the front. None unless it has three corners or more, is flat and
    /// convex (to 1e-9 of its size) and has an area.
    pub fn new(corners: Vec<Vec3>) -> Option<Polygon> {
        let twice = (2..corners.len())
            .fold(Vec3::ZERO, |s, k| s + (corners[k - 1] - corners[0]).cross(corners[k] - corners[0]));
        let (normal, area) = (twice.normalized(), 0.5 * twice.length());
        let n = corners.len();
        let edge = |k: usize| corners[(k + 1) % n] - corners[k];
        let size = (0..n).fold(0.0f64, |s, k| s.max(edge(k).length()));
        let slack = 1e-9 * size;
        let flat = (0..n).all(|k| normal.dot(corners[k] - corners[0]).abs() <= slack);
        let convex = (0..n).all(|k| normal.dot(edge(k).cross(edge((k + 1) % n))) >= -slack * size);
        (n >= 3 && area > 1e-12 * size * size && flat && convex).then_some(Polygon { corners, normal, area })
    }

    /// The corners, m.
    pub fn corners(&self) -> &[Vec3] {
        &self.corners
    }

    /// Area, m².
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Unit normal of the front.
    pub fn normal(&self) -> Vec3 {
        self.normal
    }

    /// The polygon in parts of at most `most` corners that share the first one.
    fn fan(&self, most: usize) -> impl Iterator<Item = impl Iterator<Item = Vec3> + '_> + '_ {
        let n = self.corners.len();
        (1..n - 1).step_by(most - 2).map(move |k| {
            let last = (k + most - 2).min(n - 1);
            std::iter::once(self.corners[0]).chain(self.corners[k..=last].iter().copied())
        })
    }

    fn height(&self, x: Vec3) -> f64 {
        self.normal.dot(x - self.corners[0])
    }

    /// What lies at a height of zero or more over the plane of `other`; none if nothing rises above `eps`, m.
    fn in_front_of(&self, other: &Polygon, eps: f64) -> Option<Polygon> {
        let h: Vec<f64> = self.corners.iter().map(|c| other.height(*c)).collect();
        if h.iter().all(|x| *x <= eps) {
            return None;
        }
        if h.iter().all(|x| *x >= -eps) {
            return Some(self.clone());
        }
        let mut kept = Vec::with_capacity(h.len() + 1);
        for i in 0..h.len() {
            let j = (i + 1) % h.len();
            if h[i] >= 0.0 {
                kept.push(self.corners[i]);
            }
            if h[i] * h[j] < 0.0 {
                kept.push(self.corners[i] + (self.corners[j] - self.corners[i]) * (h[i] / (h[i] - h[j])));
            }
        }
        Polygon::new(kept)
    }
}

impl From<&Plate> for Polygon {
    /// A plate's front.
    ///
    /// # Panics
    /// On a plate without area.
    fn from(p: &Plate) -> Polygon {
        let (c, n) = p.corners();
        Polygon::new(c[..n].to_vec()).expect("a plate with an area")
    }
}

/// 𝓕 of the fronts of `a` and `b`, m², with `obstructions` between them, to a radius of `demand` or of `floor` (m²), whichever is
/// larger. Grade estimated; method [`Method::Clipped`], or [`Method::Contour`] where nothing can hide anything. Neither `a` nor `b` need be
/// left out of the obstructions.
pub fn exchange(a: &Polygon, b: &Polygon, obstructions: &[Polygon], demand: &Demand, floor: f64) -> Factor {
    let (a, b) = if before(a, b) { (a, b) } else { (b, a) };
    let size = a.corners.iter().chain(&b.corners).fold(0.0f64, |s, c| s.max((*c - a.corners[0]).length()));
    let eps = TOUCH * size;
    let (Some(outer), Some(inner)) = (a.in_front_of(b, eps), b.in_front_of(a, eps)) else {
        return Factor::UNSEEN;
    };
    let between = between(&outer, &inner, obstructions, eps);
    if between.is_empty() {
        return unobstructed(&outer, &inner, size, demand, floor);
    }
    let segments = critical::segments(&outer, &inner, &between);
    let view = View::new(outer.normal, &inner, &between);
    let mut work = Work { view, segments: &segments, parts: BinaryHeap::new(), made: 0, evaluations: 0 };
    work.start(&outer);
    work.refine(demand, floor)
}

/// The closed contour formula; its radius does not know the corners that the cut took for lying on the plane: estimated.
fn unobstructed(a: &Polygon, b: &Polygon, size: f64, demand: &Demand, floor: f64) -> Factor {
    let displaced = HEIGHT * f64::EPSILON * size;
    let contour =
        |p: &Polygon| Contour { corners: p.corners.iter().map(|c| *c - a.corners[0]).collect(), displaced };
    let (first, second) = (contour(a), contour(b));
    let rough = contour::sum(&first, &second, ROUGH * a.area);
    let wanted = demand.radius(rough.value).max(floor);
    let fine = if rough.radius <= wanted { rough } else { contour::sum(&first, &second, 0.5 * wanted) };
    let evaluations = rough.evaluations + if rough.radius <= wanted { 0 } else { fine.evaluations };
    let bounded = Bounded::estimated(fine.value.max(0.0), fine.radius);
    Factor { bounded, evaluations, method: Method::Contour }
}

/// The smaller first; of equal ones that with the smaller corners in lexicographic order.
fn before(a: &Polygon, b: &Polygon) -> bool {
    let key = |p: &Polygon| p.corners.iter().flat_map(|c| c.array()).collect::<Vec<f64>>();
    a.area.total_cmp(&b.area).then_with(|| key(a).partial_cmp(&key(b)).unwrap_or(Ordering::Equal)).is_le()
}

/// The parts of the obstructions that can hide something.
fn between(a: &Polygon, b: &Polygon, obstructions: &[Polygon], eps: f64) -> Vec<Polygon> {
    let shaft = shaft(a, b, eps);
    let cut = |o: &Polygon| o.in_front_of(a, eps).and_then(|o| o.in_front_of(b, eps));
    let mut kept: Vec<Polygon> = obstructions
        .iter()
        .filter(|o| !shaft.iter().any(|(n, c)| o.corners.iter().all(|x| n.dot(*x) >= c - eps)))
        .filter_map(cut)
        .filter(|o| {
            let h = || a.corners.iter().chain(&b.corners).map(|c| o.height(*c));
            !(h().all(|x| x <= eps) || h().all(|x| x >= -eps))
        })
        .filter(|o| !shaft.iter().any(|(n, c)| o.corners.iter().all(|x| n.dot(*x) >= c - eps)))
        .flat_map(|o| o.fan(clip::EDGES).filter_map(|p| Polygon::new(p.collect())).collect::<Vec<_>>())
        .collect();
    // The two sides of a thin wall are one obstruction.
    let mut k = 0;
    while k < kept.len() {
        let twin = |o: &Polygon| same_corners(o, &kept[k], eps);
        if kept[..k].iter().any(twin) {
            kept.remove(k);
        } else {
            k += 1;
        }
    }
    kept
}

fn same_corners(a: &Polygon, b: &Polygon, eps: f64) -> bool {
    let near = |x: &Vec3| b.corners.iter().any(|y| (*x - *y).max_abs() <= eps);
    a.corners.len() == b.corners.len() && a.corners.iter().all(near)
}

/// Planes (n, c) with n·x ≤ c for all of a and b, each through an edge of the one and a corner of the other.
fn shaft(a: &Polygon, b: &Polygon, eps: f64) -> Vec<(Vec3, f64)> {
    let mut planes = Vec::new();
    let all = || a.corners.iter().chain(&b.corners);
    for (p, q) in [(a, b), (b, a)] {
        for k in 0..p.corners.len() {
            let (s, t) = (p.corners[k], p.corners[(k + 1) % p.corners.len()]);
            for v in &q.corners {
                let raw = (t - s).cross(*v - s);
                if raw.length() <= TOUCH * (t - s).length2() {
                    continue;
                }
                for n in [raw.normalized(), -raw.normalized()] {
                    let c = n.dot(s);
                    if all().all(|x| n.dot(*x) <= c + eps) {
                        planes.push((n, c));
                    }
                }
            }
        }
    }
    planes
}

/// A triangle of a with its integral and the estimate of its error, both times π.
struct Part {
    corners: [Vec3; 3],
    value: f64,
    error: f64,
    made: u64,
}

impl PartialEq for Part {
    fn eq(&self, o: &Part) -> bool {
        self.cmp(o).is_eq()
    }
}
impl Eq for Part {}
impl PartialOrd for Part {
    fn partial_cmp(&self, o: &Part) -> Option<Ordering> {
        Some(self.cmp(o))
    }
}
impl Ord for Part {
    /// The worst first; of equals the older.
    fn cmp(&self, o: &Part) -> Ordering {
        self.error.total_cmp(&o.error).then(o.made.cmp(&self.made))
    }
}

struct Work<'a> {
    view: View<'a>,
    segments: &'a [Segment],
    parts: BinaryHeap<Part>,
    made: u64,
    evaluations: u64,
}

impl Work<'_> {
    /// The polygon in triangles, cut along the shadows that each obstruction casts by itself.
    fn start(&mut self, outer: &Polygon) {
        let c = &outer.corners;
        let mut triangles: Vec<[Vec3; 3]> = (2..c.len()).map(|k| [c[0], c[k - 1], c[k]]).collect();
        for s in self.segments.iter().filter(|s| s.first) {
            if triangles.len() > FORCED {
                break;
            }
            triangles = triangles.into_iter().flat_map(|t| s.cut(&t).unwrap_or_else(|| vec![t])).collect();
        }
        for t in triangles {
            self.add(t);
        }
    }

    fn add(&mut self, corners: [Vec3; 3]) -> (f64, f64) {
        let (value, coarse) = (self.rule(&corners, FINE), self.rule(&corners, COARSE));
        let unsettled = self.segments.iter().any(|s| s.first && s.crosses(&corners));
        let error = (value - coarse).abs() * if unsettled { UNSETTLED } else { 1.0 };
        self.parts.push(Part { corners, value, error, made: self.made });
        self.made += 1;
        (value, error)
    }

    /// ∫ ω⊥ dA over a triangle: x = a + u (b − a) + u v (c − b), dA = 2 A u du dv.
    fn rule(&mut self, [a, b, c]: &[Vec3; 3], n: usize) -> f64 {
        let rule = gauss::rule(n);
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

    fn refine(mut self, demand: &Demand, floor: f64) -> Factor {
        let sums = |parts: &BinaryHeap<Part>| {
            parts.iter().fold((0.0, 0.0, 0.0), |(v, e, m), p| (v + p.value, e + p.error, p.error.max(m)))
        };
        let (mut value, mut error, _) = sums(&self.parts);
        let noise = ROUNDING * self.view.scale();
        loop {
            let wanted = PI * demand.radius(value / PI).max(floor);
            let worst = self.parts.peek().map_or(0.0, |p| p.error);
            if error <= wanted || self.evaluations >= demand.budget || worst <= noise * ROUNDING {
                break;
            }
            let part = self.parts.pop().expect("a part");
            (value, error) = (value - part.value, error - part.error);
            let cut = self.segments.iter().find_map(|s| s.cut(&part.corners));
            for t in cut.unwrap_or_else(|| halves(&part.corners)) {
                let (v, e) = self.add(t);
                (value, error) = (value + v, error + e);
            }
        }
        let (value, error, _) = sums(&self.parts);
        let bounded = Bounded::estimated(value / PI, error / PI + ROUNDING * value.abs());
        Factor { bounded, evaluations: self.evaluations, method: Method::Clipped }
    }
}

/// A triangle cut from the middle of its longest edge.
fn halves(&[a, b, c]: &[Vec3; 3]) -> Vec<[Vec3; 3]> {
    let turns = [[a, b, c], [b, c, a], [c, a, b]];
    let longest = |t: &[Vec3; 3]| (t[1] - t[0]).length2();
    let [a, b, c] = turns.into_iter().max_by(|s, t| longest(s).total_cmp(&longest(t))).expect("three turns");
    let m = (a + b) * 0.5;
    vec![[a, m, c], [m, b, c]]
}
