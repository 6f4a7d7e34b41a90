//! Uniform sampling of the solid angle of a polygon.
//!
//! The polygon is the part of a facet in front of the receiver. With q the foot of the receiver's point p on the facet's plane, it
//! is split into triangles about its point b nearest to q: from p no point of the polygon is then more than 90° from b, and every
//! triangle is well conditioned however near p is to the plane. In a spherical triangle with corners a, b, c (unit vectors) let w
//! run along the side ac. The solid angle ω of abw (van Oosterom and Strackee 1983) satisfies, with o = a + w up to length,
//!
//! ```text
//! tan(ω/2) = det(a, b, o) / ((a + b)·o),   linear in o = x a + y c:
//! x = D cos(ω/2) − (a + b)·c sin(ω/2)      y = (1 + a·b) sin(ω/2)      D = det(a, b, c)
//! ```
//!
//! so the fraction of the solid angle up to w gives w, and a point on the arc from b to w with uniform 1 − cos is uniform over the
//! triangle (Arvo 1995; in this form after Peters 2021). The map from the unit square onto the polygon is continuous and preserves
//! areas: evenly distributed numbers give evenly distributed directions.

use super::receiver::Receiver;
use crate::solid_angle::clip_to_half_space;
use std::f64::consts::PI;
use zonal_math::direction_sampling::sin_cos_turns;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Plate, PlateKind};

/// Triangles of a smaller determinant are so distant, or so thin, that rounding dominates: their points are drawn by area. A thin
/// triangle adds too little to H or G to matter, and for a distant one the two measures agree.
const MIN_TRIANGLE_DETERMINANT: f64 = 1e-9;
/// Samples keep this distance from the borders of a facet, as a fraction of its sides: off a wall that stands on the border. A larger
/// margin would move samples seen from close above a border.
const BORDER_MARGIN: f64 = 1e-9;
/// Most corners of a facet clipped to a half-space, and one.
const MAX_POLYGON_CORNERS: usize = 6;

/// A facet of an emitter, with axes of its own: the first two in its plane, the third its normal, the origin that of the plate.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmitterFacet {
    pub id: usize,
    pub plate: Plate,
    axes: [Vec3; 3],
    corners: [Vec3; 4],
    count: usize,
    /// Maps a point (x, y) of the plane to (u, v).
    parameters: [[f64; 2]; 2],
}

impl EmitterFacet {
    pub(super) fn new(id: usize, plate: Plate) -> EmitterFacet {
        let normal = plate.normal();
        let (t, b) = normal.frame();
        let axes = [t, b, normal];
        let in_plane = |x: Vec3| vec3(x.dot(t), x.dot(b), 0.0);
        let (corners, count) = plate.corners();
        let (e, f) = (in_plane(plate.e1), in_plane(plate.e2));
        let det = e.x * f.y - e.y * f.x;
        let parameters = [[f.y / det, -f.x / det], [-e.y / det, e.x / det]];
        EmitterFacet {
            id,
            plate,
            axes,
            corners: corners.map(|c| in_plane(c - plate.origin)),
            count,
            parameters,
        }
    }

    /// Unit normal of the front.
    pub(super) fn normal(&self) -> Vec3 {
        self.axes[2]
    }

    /// A vector in the facet's axes.
    pub(super) fn local(&self, x: Vec3) -> Vec3 {
        let [t, b, n] = self.axes;
        vec3(x.dot(t), x.dot(b), x.dot(n))
    }

    /// (u, v) of a point given in the facet's axes.
    pub(super) fn parameters_of(&self, at: Vec3) -> [f64; 2] {
        self.parameters.map(|[x, y]| x * at.x + y * at.y)
    }

    /// (u, v) of a point given in the facet's axes, clamped to the plate and off its borders.
    pub(super) fn clamped_uv(&self, at: Vec3) -> [f64; 2] {
        let [u, v] = self.parameters_of(at).map(|x| x.clamp(BORDER_MARGIN, 1.0 - BORDER_MARGIN));
        let over = (u + v) / (1.0 - BORDER_MARGIN);
        match self.plate.kind {
            PlateKind::Triangle if over > 1.0 => [u / over, v / over],
            _ => [u, v],
        }
    }
}

/// The part of a facet that a point sees: a polygon, split into triangles about its point nearest to the foot of the receiver. In
/// the facet's axes; all vectors but `from` start at the receiver.
pub(super) struct VisiblePolygon {
    /// The receiver, from the facet's origin.
    from: Vec3,
    hub: Vec3,
    rim: [Vec3; MAX_POLYGON_CORNERS],
    count: usize,
    /// For the triangle of hub and rim k, k + 1: a complex number whose argument is half its solid angle.
    half_angles: [[f64; 2]; MAX_POLYGON_CORNERS],
    /// Solid angle of the polygon, sr.
    pub solid_angle: f64,
}

impl VisiblePolygon {
    /// The polygon seen from `from`, relative to the facet's origin; `None` where no part of the facet is in front of the receiver.
    #[inline(always)]
    pub(super) fn new(facet: &EmitterFacet, from: Vec3, receiver: Receiver) -> Option<VisiblePolygon> {
        let mut rim = [Vec3::ZERO; MAX_POLYGON_CORNERS];
        let mut count = facet.count;
        (0..count).for_each(|k| rim[k] = facet.corners[k] - from);
        if let Receiver::Surface(front) = receiver {
            (rim, count) = clip_to_half_space(&rim[..count], facet.local(front));
        }
        if count < 3 {
            return None;
        }
        let hub = nearest_point(&rim[..count], -from.z);
        let near = hub.length();
        let (mut half_angles, mut product) = ([[1.0, 0.0]; MAX_POLYGON_CORNERS], [1.0, 0.0]);
        let (mut a, mut la) = (rim[0], rim[0].length());
        for k in 0..count {
            let c = rim[if k + 1 < count { k + 1 } else { 0 }];
            let lc = c.length();
            // Twice the area times the height: free of cancellation however thin the triangle looks.
            let det = (cross_z(a - hub, c - hub) * from.z.abs()).max(0.0);
            half_angles[k] = [la * near * lc + a.dot(hub) * lc + a.dot(c) * near + hub.dot(c) * la, det];
            let scale = 1.0 / (la * near * lc);
            product = complex_product(product, half_angles[k].map(|x| x * scale));
            (a, la) = (c, lc);
        }
        // At most π; an excess is rounding.
        let solid_angle = 2.0 * product[1].abs().atan2(product[0]);
        (solid_angle > 0.0).then_some(VisiblePolygon { from, hub, rim, count, half_angles, solid_angle })
    }

    /// The point of the facet's plane at `s` ∈ [0,1)², uniform in solid angle, from the facet's origin.
    #[inline(always)]
    pub(super) fn sample(&self, s: [f64; 2]) -> Option<Vec3> {
        let (sin, cos) = sin_cos_turns(s[0] * self.solid_angle / (4.0 * PI));
        // Subtract the angle of one triangle after the other to find the one that holds the sample.
        let (mut rest, mut found) = ([cos, sin], None);
        for (k, &[x, y]) in self.half_angles[..self.count].iter().enumerate().filter(|h| h.1[1] > 0.0) {
            found = Some((k, rest));
            let back = complex_product(rest, [x, -y]);
            if back[1] < 0.0 {
                break;
            }
            let scale = 1.0 / (x * x + y * y).sqrt();
            rest = back.map(|b| b * scale);
        }
        let (k, rest) = found?;
        let (a, c) = (self.rim[k], self.rim[if k + 1 < self.count { k + 1 } else { 0 }]);
        let (la, lb, lc) = (a.length(), self.hub.length(), c.length());
        let det = self.half_angles[k][1] / (la * lb * lc);
        if det < MIN_TRIANGLE_DETERMINANT {
            // Uniform over the area: the square root accounts for the corner at the hub.
            let along = (rest[1] * self.half_angles[k][0] / self.half_angles[k][1]).clamp(0.0, 1.0);
            return Some(self.from + self.hub + (a + (c - a) * along - self.hub) * s[1].sqrt());
        }
        let direction = sample_triangle([a / la, self.hub / lb, c / lc], det, rest, s[1]);
        let reach = -self.from.z / direction.z;
        reach.is_finite().then(|| self.from + direction * reach)
    }
}

/// Product of two complex numbers.
#[inline(always)]
fn complex_product([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a * c - b * d, a * d + b * c]
}

/// The third component of a × b.
#[inline(always)]
fn cross_z(a: Vec3, b: Vec3) -> f64 {
    a.x * b.y - a.y * b.x
}

/// A unit vector of the spherical triangle abc of determinant `det`: the arc from b through it cuts off a solid angle ω on the side
/// of ab, given by the cosine and sine of ω/2, and the vector stands at the fraction `s` of that arc's 1 − cos. No corner is more
/// than 90° from b.
#[inline(always)]
fn sample_triangle([a, b, c]: [Vec3; 3], det: f64, [cos, sin]: [f64; 2], s: f64) -> Vec3 {
    let o = a * (det * cos - (a + b).dot(c) * sin) + c * ((1.0 + a.dot(b)) * sin);
    let w = o * (2.0 * a.dot(o) / o.length2()) - a;
    // 1 − cos of the whole arc from its chord: no cancellation where the arc is short.
    let chord = w - b;
    let whole = 0.5 * chord.length2();
    let part = s * whole;
    let along = (s * (2.0 - part) / (2.0 - whole)).sqrt();
    b * (1.0 - part) + (chord + b * whole) * along
}

/// The point of a convex polygon nearest to the foot (0, 0, z); the polygon lies in the plane of height `z`, its corners
/// counter-clockwise.
#[inline(always)]
fn nearest_point(corners: &[Vec3], z: f64) -> Vec3 {
    let foot = vec3(0.0, 0.0, z);
    let (mut best, mut best_d2) = (foot, f64::INFINITY);
    for (k, &a) in corners.iter().enumerate() {
        let edge = corners[if k + 1 < corners.len() { k + 1 } else { 0 }] - a;
        if cross_z(a, edge) < 0.0 {
            let t = ((foot - a).dot(edge) / edge.length2()).clamp(0.0, 1.0);
            let at = a + edge * t;
            let d2 = (foot - at).length2();
            if d2 < best_d2 {
                (best, best_d2) = (at, d2);
            }
        }
    }
    best
}
