//! Where a straight line meets a plate.
//!
//! The line is x(t) = a + t d, the plate o + u e₁ + v e₂, N = e₁ × e₂, n̂ = N/|N|, s = a − o, q = s × d. Then
//!
//! ```text
//! D = −d·N      u D = q·e₂      v D = −q·e₁      t = (s·N)/D                  (Möller and Trumbore 1997)
//! ```
//!
//! q·e is |d||e| times the distance of the line from the edge's line times the sine of their angle: a moment that knows no
//! grazing angle. So both plates at a shared edge accept a line that passes it within a length τ: q·e ≥ −τ|d||e|. With τ a few
//! hundred roundings of the scene's size no line slips through, and nothing visible is widened.
//!
//! **Ends.** A segment crosses a plate only when its ends lie on opposite sides of the plate's plane, each farther from it than
//! ε. An end on the plate, a segment in its plane, or a touch is therefore no hit, at any angle.

use zonal_math::Vec3;
use zonal_scene::{Plate, PlateKind, Scene};

/// The lengths below which points coincide.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tolerance {
    /// ε: how near a plane a point counts as lying in it, m.
    pub plane: f64,
    /// Rounding of a point's distance from a plane, m.
    pub rounding: f64,
    /// τ: by how much a plate's edges are widened, m.
    pub edge: f64,
}

impl Tolerance {
    pub(crate) fn of(scene: &Scene) -> Tolerance {
        let (lo, hi) = scene.bounds();
        let (size, far) = (scene.diagonal(), lo.max_abs().max(hi.max_abs()));
        Tolerance {
            plane: 1e-9 * size + 4e-15 * far,
            rounding: 1e-12 * size + 4e-15 * far,
            edge: 1e-13 * size + 1e-15 * far,
        }
    }
}

/// A plate made ready for [`Prepared::crosses`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Prepared {
    origin: Vec3,
    e1: Vec3,
    e2: Vec3,
    normal: Vec3,
    /// |e₁ × e₂|
    area2: f64,
    /// Longest edge or diagonal of the triangle (o, e₁, e₂).
    reach: f64,
    triangle: bool,
}

/// A line with what all plates need of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub a: Vec3,
    pub d: Vec3,
    pub plane: f64,
    /// τ|d|
    moment: f64,
}

impl Line {
    pub(crate) fn new(a: Vec3, d: Vec3, tol: &Tolerance) -> Line {
        Line { a, d, plane: tol.plane, moment: tol.edge * d.length() }
    }
}

impl Prepared {
    pub(crate) fn new(p: &Plate) -> Prepared {
        Prepared {
            origin: p.origin,
            e1: p.e1,
            e2: p.e2,
            normal: p.normal(),
            area2: p.e1.cross(p.e2).length(),
            reach: p.e1.length().max(p.e2.length()).max((p.e2 - p.e1).length()),
            triangle: p.kind == PlateKind::Triangle,
        }
    }

    /// The line's parameters (u D, v D, D), D > 0, when it passes inside the plate's edges.
    #[inline(always)]
    fn inside(&self, line: &Line, s: Vec3, along: f64) -> Option<[f64; 3]> {
        let det = along.abs() * self.area2;
        let q = s.cross(line.d);
        let sign = if along < 0.0 { 1.0 } else { -1.0 };
        let (u, v) = (sign * q.dot(self.e2), -sign * q.dot(self.e1));
        let tau = line.moment * self.reach;
        let top = det + tau;
        let far = if self.triangle { u + v <= top } else { u <= top && v <= top };
        (u >= -tau && v >= -tau && far).then_some([u, v, det])
    }

    /// True when the segment a → a + d crosses the plate, its ends not counted.
    #[inline(always)]
    pub(crate) fn crosses(&self, line: &Line) -> bool {
        let s = line.a - self.origin;
        let (da, along) = (s.dot(self.normal), line.d.dot(self.normal));
        let db = da + along;
        let apart = (da > line.plane && db < -line.plane) || (da < -line.plane && db > line.plane);
        apart && self.inside(line, s, along).is_some()
    }

    /// Where the segment a → a + d crosses the plate: the share t of the segment and (u, v).
    #[inline]
    pub(crate) fn crossing(&self, line: &Line) -> Option<[f64; 3]> {
        if !self.crosses(line) {
            return None;
        }
        let s = line.a - self.origin;
        let along = line.d.dot(self.normal);
        let [u, v, det] = self.inside(line, s, along)?;
        Some([-s.dot(self.normal) / along, u / det, v / det])
    }

    /// Where the ray a + t d, d of unit length, meets the plate with t_min < t < t_max; a ray that starts in the plane or
    /// runs along it does not.
    #[inline]
    pub(crate) fn meets(&self, line: &Line, rounding: f64, t_min: f64, t_max: f64) -> Option<[f64; 3]> {
        let s = line.a - self.origin;
        let (da, along) = (s.dot(self.normal), line.d.dot(self.normal));
        if da.abs() <= rounding || along.abs() <= 1e-13 {
            return None;
        }
        let t = -da / along;
        if !(t > t_min && t < t_max) {
            return None;
        }
        let [u, v, det] = self.inside(line, s, along)?;
        Some([t, u / det, v / det])
    }

    /// The share t of the segment a → a + d at which its line pierces the plate, ends or not; none when it runs along the plate.
    #[inline]
    pub(crate) fn pierced(&self, line: &Line) -> Option<f64> {
        let s = line.a - self.origin;
        let (da, along) = (s.dot(self.normal), line.d.dot(self.normal));
        if along.abs() <= 1e-12 * line.d.max_abs() {
            return None;
        }
        self.inside(line, s, along).map(|_| -da / along)
    }

    /// Unit normal of the front.
    pub(crate) fn normal(&self) -> Vec3 {
        self.normal
    }
    /// Signed distance of `p` from the plane.
    pub(crate) fn height(&self, p: Vec3) -> f64 {
        (p - self.origin).dot(self.normal)
    }
    /// Corners, three or four.
    pub(crate) fn corners(&self) -> ([Vec3; 4], usize) {
        let (a, b, c) = (self.origin, self.origin + self.e1, self.origin + self.e2);
        ([a, b, c, b + self.e2], if self.triangle { 3 } else { 4 })
    }
}
