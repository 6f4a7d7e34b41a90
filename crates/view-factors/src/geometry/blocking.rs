//! Total occlusion: one convex body that hides two sets of points from each other.
//!
//! **Plates.** Points a on one side of the plate's plane at height h_a > 0, points b (finite, or directions) at height h_b < 0. The segment from a
//! to b crosses the plane inside the edge with inward normal m and offset o if
//!
//! ```text
//! (m·a − o) |h_b| + (m·b − o w_b) h_a ≥ 0,      w_b = 1 for a point, 0 for a direction.
//! ```
//!
//! Both sides are linear in a and in b, so the condition for all corners of two convex hulls is that for the hulls.
//!
//! **Solids.** For a fixed end the points whose segments meet a convex set over a part of their length form a convex set, so corners decide for
//! hulls here too. The planes of faces are moved inwards by the contact distance, so that a solid does not hide its own facets; the plane of an
//! opening outwards, so that it hides what stands on the ground beside it. The largest ball about the middle inside the solid and the smallest around
//! it decide most segments.

use crate::bounds::{Bounds, ball_about_middle};
use crate::geometry::occluders::MergedOccluder;
use std::borrow::Cow;
use zonal_exchange::polygon::visible::ConvexBody;
use zonal_math::Vec3;

/// Points, or directions, and one of their hull.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hull<'a> {
    pub middle: Vec3,
    pub corners: &'a [Vec3],
}

/// An obstruction.
#[derive(Clone, Debug)]
pub(crate) struct Occluder {
    pub body: ConvexBody,
    /// Edges of a plate with inward normals, none of a solid.
    plate_edges: Vec<(Vec3, f64)>,
    has_opening: bool,
    pub bounds: Bounds,
    pub centre: Vec3,
    pub radius: f64,
    /// Radius of a ball about the centre inside a solid; zero for a plate.
    inner_radius: f64,
}

/// Faces of a body, at most, that are tried as separating planes.
const MAX_SEPARATING_PLANES: usize = 24;

/// Corners of a hull at most: those of a box, or of a polygon.
pub(crate) const MAX_HULL_CORNERS: usize = 8;

impl Occluder {
    pub(crate) fn new(MergedOccluder { body, has_opening }: MergedOccluder) -> Occluder {
        let c = body.corners();
        let normal = body.planes()[0].0;
        let edge = |k: usize| {
            let inward = normal.cross(c[(k + 1) % c.len()] - c[k]).normalized();
            (inward, inward.dot(c[k]))
        };
        let plate_edges = if body.is_plate() { (0..c.len()).map(edge).collect() } else { Vec::new() };
        let (centre, radius) = ball_about_middle(c);
        let depth = body.planes().iter().fold(radius, |s, (n, c)| s.min(c - n.dot(centre)));
        Occluder {
            bounds: Bounds::of(c),
            plate_edges,
            has_opening,
            centre,
            radius,
            inner_radius: depth.max(0.0),
            body,
        }
    }

    /// True if the body, displaced by `shift`, meets every segment from a point of `from` to a point of `to` (weight 1) or every
    /// ray from there in a direction of `to` (weight 0), a plate at a distance of more than `contact` from their ends. False for hulls of more
    /// than [`MAX_HULL_CORNERS`] corners.
    pub(crate) fn hides(&self, from: Hull, to: Hull, weight: f64, shift: Vec3, contact: f64) -> bool {
        let is_small = |hull: Hull| hull.corners.len() <= MAX_HULL_CORNERS;
        if !(is_small(from) && is_small(to) && self.crosses(from.middle, to.middle, weight, shift)) {
            return false;
        }
        if self.body.is_plate() {
            self.plate_hides(from.corners, to.corners, weight, shift, contact)
        } else {
            self.solid_hides(from.corners, to.corners, weight, shift, contact)
        }
    }

    fn plate_hides(&self, from: &[Vec3], to: &[Vec3], weight: f64, shift: Vec3, contact: f64) -> bool {
        let (n, c) = self.body.planes()[0];
        let offset = c + n.dot(shift);
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
        self.plate_edges.iter().all(|(m, o)| {
            let o = o + m.dot(shift);
            let beyond: [f64; MAX_HULL_CORNERS] =
                std::array::from_fn(|j| to.get(j).map_or(0.0, |b| m.dot(*b) - o * weight));
            from.iter().zip(&above).all(|(a, h)| {
                let inside = m.dot(*a) - o;
                (0..to.len()).all(|j| inside * below[j] + beyond[j] * h >= 0.0)
            })
        })
    }

    fn solid_hides(&self, from: &[Vec3], to: &[Vec3], weight: f64, shift: Vec3, contact: f64) -> bool {
        from.iter().all(|a| to.iter().all(|b| self.solid_meets(*a, *b, weight, shift, contact)))
    }

    /// Heights along a + t (b − w a) over the planes: h₀ + t h₁ ≤ 0 inside.
    fn solid_meets(&self, a: Vec3, b: Vec3, weight: f64, shift: Vec3, contact: f64) -> bool {
        let planes = self.body.planes();
        let start = a - shift;
        let along = b - a * weight;
        let to_centre = self.centre - start;
        let nearest = to_centre.dot(along) / along.length2();
        let nearest = if weight > 0.0 { nearest.clamp(0.0, 1.0) } else { nearest.max(0.0) };
        let distance2 = (to_centre - along * nearest).length2();
        if distance2 < (self.inner_radius - contact).max(0.0).powi(2) {
            return true;
        }
        // The opening's plane is moved outwards.
        if distance2 > (self.radius + contact).powi(2) {
            return false;
        }
        let (mut enter, mut leave) = (0.0f64, if weight > 0.0 { 1.0 } else { f64::INFINITY });
        for (k, (n, c)) in planes.iter().enumerate() {
            let is_opening = self.has_opening && k + 1 == planes.len();
            let height = n.dot(start) - c + if is_opening { -contact } else { contact };
            let slope = n.dot(along);
            if slope < 0.0 {
                enter = enter.max(-height / slope);
            } else if slope > 0.0 {
                leave = leave.min(-height / slope);
            } else if height > 0.0 {
                return false;
            }
            if enter >= leave {
                return false;
            }
        }
        true
    }

    /// The same as [`Occluder::hides`] for one point and one target.
    fn crosses(&self, from: Vec3, to: Vec3, weight: f64, shift: Vec3) -> bool {
        if !self.body.is_plate() {
            return self.solid_meets(from, to, weight, shift, 0.0);
        }
        let (n, c) = self.body.planes()[0];
        let offset = c + n.dot(shift);
        let (above, below) = (n.dot(from) - offset, n.dot(to) - offset * weight);
        if above * below >= 0.0 {
            return false;
        }
        self.plate_edges.iter().all(|(m, o)| {
            let o = o + m.dot(shift);
            (m.dot(from) - o) * below.abs() + (m.dot(to) - o * weight) * above.abs() >= 0.0
        })
    }

    /// The body displaced by `shift`.
    pub(crate) fn placed(&self, shift: Vec3) -> Cow<'_, ConvexBody> {
        if shift == Vec3::ZERO { Cow::Borrowed(&self.body) } else { Cow::Owned(self.body.translated(shift)) }
    }

    /// True if all of the body, displaced by `shift`, has n·x ≥ c.
    pub(crate) fn is_beyond(&self, n: Vec3, c: f64, shift: Vec3) -> bool {
        let level = c - n.dot(shift);
        let middle = n.dot(self.centre) - level;
        middle >= 0.0 && (middle >= self.radius || self.body.corners().iter().all(|x| n.dot(*x) >= level))
    }

    /// True if one face has all of `from` on its outer side, and no segment to `to` (weight 1: points; 0: directions) leads inwards; not
    /// decided for bodies of very many faces.
    pub(crate) fn is_beside(
        &self,
        from: &[Vec3],
        to: &[Vec3],
        weight: f64,
        shift: Vec3,
        contact: f64,
    ) -> bool {
        let planes = self.body.planes();
        planes.len() <= MAX_SEPARATING_PLANES
            && planes.iter().any(|(n, c)| {
                let offset = c + n.dot(shift);
                let margin = if weight > 0.0 { contact } else { 0.0 };
                from.iter().all(|x| n.dot(*x) >= offset - contact)
                    && to.iter().all(|x| n.dot(*x) >= offset * weight - margin)
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_exchange::polygon::visible::ConvexPolygon;
    use zonal_math::vec3;

    #[test]
    fn a_wall_hides_hulls_within_its_outline_alone() {
        let wall = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]].map(|[x, y]| vec3(x, y, 0.0));
        let wall = ConvexPolygon::new(wall.to_vec()).expect("a square");
        let wall = Occluder::new(MergedOccluder { body: ConvexBody::plate(&wall), has_opening: false });
        let square = |z: f64, s: f64| [[-s, -s], [s, -s], [s, s], [-s, s]].map(|[x, y]| vec3(x, y, z));
        let hides = |from: [Vec3; 4], to: [Vec3; 4], weight: f64, shift: Vec3| {
            let hull = |corners| Hull { middle: ball_about_middle(corners).0, corners };
            wall.hides(hull(&from), hull(&to), weight, shift, 1e-9)
        };
        let none = Vec3::ZERO;
        // The segments between squares of half-width 1 and 3 at equal distances cross the plane within 2.
        assert!(hides(square(1.0, 1.0), square(-1.0, 3.0), 1.0, none));
        assert!(hides(square(-1.0, 3.0), square(1.0, 1.0), 1.0, none));
        assert!(!hides(square(1.0, 1.0), square(-1.0, 3.1), 1.0, none));
        assert!(!hides(square(1.0, 1.0), square(1.0, 0.5), 1.0, none));
        assert!(!hides(square(1.0, 1.0), square(-1.0, 3.0), 1.0, vec3(0.1, 0.0, 0.0)));
        // Directions within 45° of the axis from a square of half-width 1 at height 1 cross within 2.
        assert!(hides(square(1.0, 1.0), square(-1.0, 1.0), 0.0, none));
        assert!(!hides(square(1.0, 1.0), square(-1.0, 1.1), 0.0, none));
    }
}
