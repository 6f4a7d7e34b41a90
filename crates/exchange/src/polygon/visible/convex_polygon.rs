//! Flat convex polygons.

use zonal_math::Vec3;
use zonal_scene::Plate;

/// Distances below this share of the polygons' size count as contact: shared corners, adjoining walls.
pub(super) const RELATIVE_CONTACT_DISTANCE: f64 = 1e-10;

/// A flat convex polygon; its front sees the corners counter-clockwise.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexPolygon {
    pub(super) corners: Vec<Vec3>,
    pub(super) normal: Vec3,
    pub(super) area: f64,
}

impl ConvexPolygon {
    /// A polygon from its corners, m, counter-clockwise from the front. None unless it has three corners or more, is flat and
    /// convex (to 1e-9 of its size) and has an area.
    pub fn new(corners: Vec<Vec3>) -> Option<ConvexPolygon> {
        let twice = (2..corners.len())
            .fold(Vec3::ZERO, |s, k| s + (corners[k - 1] - corners[0]).cross(corners[k] - corners[0]));
        let (normal, area) = (twice.normalized(), 0.5 * twice.length());
        let n = corners.len();
        let edge = |k: usize| corners[(k + 1) % n] - corners[k];
        let size = (0..n).fold(0.0f64, |s, k| s.max(edge(k).length()));
        let slack = 1e-9 * size;
        let flat = (0..n).all(|k| normal.dot(corners[k] - corners[0]).abs() <= slack);
        let convex = (0..n).all(|k| normal.dot(edge(k).cross(edge((k + 1) % n))) >= -slack * size);
        (n >= 3 && area > 1e-12 * size * size && flat && convex).then_some(ConvexPolygon {
            corners,
            normal,
            area,
        })
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

    /// The mean of the corners.
    pub fn middle(&self) -> Vec3 {
        self.corners.iter().fold(Vec3::ZERO, |s, c| s + *c) / self.corners.len() as f64
    }

    /// The polygon displaced; None if rounding leaves no flat convex polygon.
    pub fn translated(&self, by: Vec3) -> Option<ConvexPolygon> {
        ConvexPolygon::new(self.corners.iter().map(|c| *c + by).collect())
    }

    /// Height of a point over the plane of the polygon, m.
    pub fn height(&self, x: Vec3) -> f64 {
        self.normal.dot(x - self.corners[0])
    }

    /// The part at a height of zero or more over the plane of `other`; none if no corner rises above `eps`, m.
    pub fn in_front_of(&self, other: &ConvexPolygon, eps: f64) -> Option<ConvexPolygon> {
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
        ConvexPolygon::new(kept)
    }
}

impl From<&Plate> for ConvexPolygon {
    /// A plate's front.
    ///
    /// # Panics
    /// On a plate without area.
    fn from(p: &Plate) -> ConvexPolygon {
        let (c, n) = p.corners();
        ConvexPolygon::new(c[..n].to_vec()).expect("a plate with an area")
    }
}
