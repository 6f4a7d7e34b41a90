//! Total occlusion: one convex polygon that hides two sets of points from each other.
//!
//! Points a on one side of the polygon's plane at height h_a > 0, points b (finite, or directions) at height h_b < 0. The segment from a to b
//! crosses the plane inside the edge with inward normal m and offset o if
//!
//! ```text
//! (m·a − o) |h_b| + (m·b − o w_b) h_a ≥ 0,      w_b = 1 for a point, 0 for a direction.
//! ```
//!
//! Both sides are linear in a and in b, so the condition for all corners of two convex hulls is that for the hulls.

use crate::occluders::ConvexSolid;
use zonal_exchange::polygon::visible::ConvexPolygon;
use zonal_math::Vec3;

/// A convex polygon with its edges' inward normals.
#[derive(Clone, Debug)]
pub(crate) struct Occluder {
    pub polygon: ConvexPolygon,
    edges: Vec<(Vec3, f64)>,
    offset: f64,
    pub centre: Vec3,
    pub radius: f64,
    /// The convex solid that it bounds, if any.
    pub solid: Option<u32>,
}

/// True if every segment from a point of `from` to a point of `to` (weight 1), or every ray from there in a direction of `to` (weight 0), meets
/// the solid, displaced by `shift`, over a part of its length.
///
/// For a fixed end the points whose segments meet a convex set form a convex set, so corners decide for hulls.
pub(crate) fn solid_hides(
    solid: &ConvexSolid,
    from: &[Vec3],
    to: &[Vec3],
    weight: f64,
    shift: Vec3,
    contact: f64,
) -> bool {
    from.iter().all(|a| to.iter().all(|b| segment_meets(solid, *a, *b, weight, shift, contact)))
}

fn segment_meets(solid: &ConvexSolid, a: Vec3, b: Vec3, weight: f64, shift: Vec3, contact: f64) -> bool {
    // Heights along a + t (b − w a) over a plane shrunk by the contact distance: h₀ + t h₁ ≤ 0 inside.
    let (mut enter, mut leave) = (0.0f64, if weight > 0.0 { 1.0 } else { f64::INFINITY });
    let along = b - a * weight;
    for (n, c) in &solid.planes {
        let (start, slope) = (n.dot(a) - c - n.dot(shift) + contact, n.dot(along));
        if slope < 0.0 {
            enter = enter.max(-start / slope);
        } else if slope > 0.0 {
            leave = leave.min(-start / slope);
        } else if start > 0.0 {
            return false;
        }
    }
    enter < leave
}

impl Occluder {
    pub(crate) fn new(polygon: ConvexPolygon, solid: Option<u32>) -> Occluder {
        let c = polygon.corners();
        let edge = |k: usize| {
            let inward = polygon.normal().cross(c[(k + 1) % c.len()] - c[k]).normalized();
            (inward, inward.dot(c[k]))
        };
        let edges = (0..c.len()).map(edge).collect();
        let centre = c.iter().fold(Vec3::ZERO, |s, p| s + *p) / c.len() as f64;
        let radius = c.iter().fold(0.0f64, |s, p| s.max((*p - centre).length()));
        Occluder { edges, offset: polygon.normal().dot(c[0]), centre, radius, solid, polygon }
    }

    /// True if the polygon, displaced by `shift`, crosses every segment from a point of `from` to a point of `to` (weight 1) or every
    /// ray from there in a direction of `to` (weight 0), at a distance of more than `contact` from their ends.
    pub(crate) fn hides(&self, from: &[Vec3], to: &[Vec3], weight: f64, shift: Vec3, contact: f64) -> bool {
        let n = self.polygon.normal();
        let offset = self.offset + n.dot(shift);
        let height = |p: &Vec3, weight: f64| n.dot(*p) - offset * weight;
        let sign = if height(&from[0], 1.0) > 0.0 { 1.0 } else { -1.0 };
        let end = if weight > 0.0 { contact } else { 0.0 };
        if !from.iter().all(|p| sign * height(p, 1.0) > contact)
            || !to.iter().all(|p| sign * height(p, weight) < -end)
        {
            return false;
        }
        self.edges.iter().all(|(m, o)| {
            let o = o + m.dot(shift);
            from.iter().all(|a| {
                let (inside, above) = (m.dot(*a) - o, sign * height(a, 1.0));
                to.iter()
                    .all(|b| inside * -(sign * height(b, weight)) + (m.dot(*b) - o * weight) * above >= 0.0)
            })
        })
    }

    /// A necessary condition of [`Occluder::hides`]: the same for one point and one target.
    pub(crate) fn crosses(&self, from: Vec3, to: Vec3, weight: f64, shift: Vec3) -> bool {
        let n = self.polygon.normal();
        let offset = self.offset + n.dot(shift);
        let (above, below) = (n.dot(from) - offset, n.dot(to) - offset * weight);
        if above * below >= 0.0 {
            return false;
        }
        self.edges.iter().all(|(m, o)| {
            let o = o + m.dot(shift);
            (m.dot(from) - o) * below.abs() + (m.dot(to) - o * weight) * above.abs() >= 0.0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    #[test]
    fn a_wall_hides_hulls_within_its_outline_alone() {
        let wall = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]].map(|[x, y]| vec3(x, y, 0.0));
        let wall = Occluder::new(ConvexPolygon::new(wall.to_vec()).expect("a square"), None);
        let square = |z: f64, s: f64| [[-s, -s], [s, -s], [s, s], [-s, s]].map(|[x, y]| vec3(x, y, z));
        let none = Vec3::ZERO;
        // The segments between squares of half-width 1 and 3 at equal distances cross the plane within 2.
        assert!(wall.hides(&square(1.0, 1.0), &square(-1.0, 3.0), 1.0, none, 1e-9));
        assert!(wall.hides(&square(-1.0, 3.0), &square(1.0, 1.0), 1.0, none, 1e-9));
        assert!(!wall.hides(&square(1.0, 1.0), &square(-1.0, 3.1), 1.0, none, 1e-9));
        assert!(!wall.hides(&square(1.0, 1.0), &square(1.0, 0.5), 1.0, none, 1e-9));
        assert!(!wall.hides(&square(1.0, 1.0), &square(-1.0, 3.0), 1.0, vec3(0.1, 0.0, 0.0), 1e-9));
        // Directions within 45° of the axis from a square of half-width 1 at height 1 cross within 2.
        assert!(wall.hides(&square(1.0, 1.0), &square(-1.0, 1.0), 0.0, none, 1e-9));
        assert!(!wall.hides(&square(1.0, 1.0), &square(-1.0, 1.1), 0.0, none, 1e-9));
    }
}
