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
    debug_assert!(from.len() <= MAX_HULL_CORNERS && to.len() <= MAX_HULL_CORNERS);
    // Heights along a + t (b − w a) over planes shrunk by the contact distance: h₀ + t h₁ ≤ 0 inside.
    let mut enter = [[0.0f64; MAX_HULL_CORNERS]; MAX_HULL_CORNERS];
    let mut leave = [[if weight > 0.0 { 1.0 } else { f64::INFINITY }; MAX_HULL_CORNERS]; MAX_HULL_CORNERS];
    for (n, c) in &solid.planes {
        let offset = c + n.dot(shift) - contact;
        let starts = from.iter().map(|a| n.dot(*a));
        let ends: [f64; MAX_HULL_CORNERS] = std::array::from_fn(|j| to.get(j).map_or(0.0, |b| n.dot(*b)));
        for (i, along) in starts.enumerate() {
            let start = along - offset;
            for j in 0..to.len() {
                let slope = ends[j] - along * weight;
                if slope < 0.0 {
                    enter[i][j] = enter[i][j].max(-start / slope);
                } else if slope > 0.0 {
                    leave[i][j] = leave[i][j].min(-start / slope);
                } else if start > 0.0 {
                    return false;
                }
                if enter[i][j] >= leave[i][j] {
                    return false;
                }
            }
        }
    }
    true
}

/// Corners of a hull at most: those of a box, or of a polygon.
pub(crate) const MAX_HULL_CORNERS: usize = 8;

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
        let sign = if n.dot(from[0]) - offset > 0.0 { 1.0 } else { -1.0 };
        let end = if weight > 0.0 { contact } else { 0.0 };
        let (mut above, mut below) = ([0.0; MAX_HULL_CORNERS], [0.0; MAX_HULL_CORNERS]);
        for (h, a) in above.iter_mut().zip(from) {
            *h = sign * (n.dot(*a) - offset);
            if *h <= contact {
                return false;
            }
        }
        for (h, b) in below.iter_mut().zip(to) {
            *h = -sign * (n.dot(*b) - offset * weight);
            if *h <= end {
                return false;
            }
        }
        self.edges.iter().all(|(m, o)| {
            let o = o + m.dot(shift);
            let beyond: [f64; MAX_HULL_CORNERS] =
                std::array::from_fn(|j| to.get(j).map_or(0.0, |b| m.dot(*b) - o * weight));
            from.iter().zip(&above).all(|(a, h)| {
                let inside = m.dot(*a) - o;
                (0..to.len()).all(|j| inside * below[j] + beyond[j] * h >= 0.0)
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
