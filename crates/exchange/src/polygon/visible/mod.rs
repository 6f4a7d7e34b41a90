//! Views of convex polygons past convex obstructions, and their integrals over a polygon.
//!
//! 𝓕 = (1/π) ∫_a ω⊥(x) dA, m², with ω⊥(x) the projected solid angle of the part of b visible from x. For one point x all is in closed
//! form: the cone from x over a convex obstruction is an intersection of half-spaces, so b minus the cones is a set of convex polygons
//! (`occluded_view`), and each has Lambert's sum over its edges,
//!
//!   ω⊥ = ½ Σ_k γ_k n·ν_k   (γ_k: the angle that edge k spans from x; ν_k: the unit normal of the plane of x and the edge).
//!
//! The integral over a is estimated by adaptive rules (`obstructed`).
//!
//! **Culling.** An obstruction occludes nothing if a plane has it on one side and both polygons on the other: a plane through an edge of the
//! one and a corner of the other that leaves both on one side ([`add_shaft_planes`]). These are all planes of the convex hull of a ∪ b but the two
//! polygons' own.

mod convex_body;
mod convex_polygon;
mod obstructed;
mod occluded_view;

pub use convex_body::ConvexBody;
pub use convex_polygon::ConvexPolygon;
pub use obstructed::{IntegrationRequest, obstructed_exchange, obstructed_sky, unobstructed_sky};
pub use occluded_view::OccludedView;

use convex_polygon::RELATIVE_CONTACT_DISTANCE;
use std::cmp::Ordering;
use zonal_math::Vec3;

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

/// A triangle cut from the middle of its longest edge.
fn bisect(&[a, b, c]: &[Vec3; 3]) -> Vec<[Vec3; 3]> {
    let turns = [[a, b, c], [b, c, a], [c, a, b]];
    let longest = |t: &[Vec3; 3]| (t[1] - t[0]).length2();
    let [a, b, c] = turns.into_iter().max_by(|s, t| longest(s).total_cmp(&longest(t))).expect("three turns");
    let m = (a + b) * 0.5;
    vec![[a, m, c], [m, b, c]]
}
