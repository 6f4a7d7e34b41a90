//! Watertight intersection of lines with plates.
//!
//! The line is x(t) = a + t d, the plate o + u e₁ + v e₂, N = e₁ × e₂, n̂ = N/|N|, s = a − o, q = s × d. Then
//!
//! ```text
//! D = −d·N      u D = q·e₂      v D = −q·e₁      t = (s·N)/D                  (Möller and Trumbore 1997)
//! ```
//!
//! q·e is |d||e| times the distance of the line from the line of the edge times the sine of their angle, a moment without
//! singularity at grazing incidence. Both plates at a shared edge accept a line that passes it within a length τ: q·e ≥ −τ|d||e|.
//! With τ of a few hundred roundings of the scene's size no line passes between them, and the widening is invisible.
//!
//! **Ends.** A segment crosses a plate only when its ends lie on opposite sides of the plate's plane, each farther from it than
//! ε. An end on the plate, a segment in its plane, or a touch is therefore no hit, at any angle.

use zonal_math::Vec3;
use zonal_scene::{Plate, PlateKind, Scene};

/// The lengths below which points coincide.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tolerance {
    /// ε: distance from a plane below which a point counts as lying in it, m.
    pub plane: f64,
    /// Rounding of a point's distance from a plane, m.
    pub rounding: f64,
    /// τ: widening of a plate's edges, m.
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

/// A plate with the derived quantities of the intersection test, those of the test of heights in one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct PreparedPlate {
    origin: Vec3,
    normal: Vec3,
    /// |e₁ × e₂|
    area2: f64,
    /// Longest edge of the triangle (o, e₁, e₂), m.
    longest_edge: f64,
    e1: Vec3,
    e2: Vec3,
    triangle: bool,
}

/// A line with the quantities that all plate tests share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PreparedLine {
    /// Origin, m.
    pub a: Vec3,
    /// Direction; for a segment its full extent, m.
    pub d: Vec3,
    /// ε, m.
    pub plane: f64,
    /// τ|d|, m².
    moment: f64,
}

impl PreparedLine {
    pub(crate) fn new(a: Vec3, d: Vec3, tol: &Tolerance) -> PreparedLine {
        PreparedLine { a, d, plane: tol.plane, moment: tol.edge * d.length() }
    }
}

impl PreparedPlate {
    pub(crate) fn new(p: &Plate) -> PreparedPlate {
        PreparedPlate {
            origin: p.origin,
            e1: p.e1,
            e2: p.e2,
            normal: p.normal(),
            area2: p.e1.cross(p.e2).length(),
            longest_edge: p.e1.length().max(p.e2.length()).max((p.e2 - p.e1).length()),
            triangle: p.kind == PlateKind::Triangle,
        }
    }

    /// (u D, v D, D) with D > 0 when the line passes inside the plate's edges.
    #[inline(always)]
    fn scaled_parameters(&self, line: &PreparedLine, s: Vec3, along: f64) -> Option<[f64; 3]> {
        let det = along.abs() * self.area2;
        let q = s.cross(line.d);
        let sign = if along < 0.0 { 1.0 } else { -1.0 };
        let (u, v) = (sign * q.dot(self.e2), -sign * q.dot(self.e1));
        let tau = line.moment * self.longest_edge;
        let top = det + tau;
        let far = if self.triangle { u + v <= top } else { u <= top && v <= top };
        (u >= -tau && v >= -tau && far).then_some([u, v, det])
    }

    /// True when the segment a → a + d crosses the plate, its ends excluded.
    #[inline(always)]
    pub(crate) fn crosses(&self, line: &PreparedLine) -> bool {
        let s = line.a - self.origin;
        let (da, along) = (s.dot(self.normal), line.d.dot(self.normal));
        let db = da + along;
        let opposite = (da > line.plane && db < -line.plane) || (da < -line.plane && db > line.plane);
        opposite && self.scaled_parameters(line, s, along).is_some()
    }

    /// Crossing of the segment a → a + d with the plate: the fraction t of the segment and (u, v).
    #[inline]
    pub(crate) fn crossing(&self, line: &PreparedLine) -> Option<[f64; 3]> {
        if !self.crosses(line) {
            return None;
        }
        let s = line.a - self.origin;
        let along = line.d.dot(self.normal);
        let [u, v, det] = self.scaled_parameters(line, s, along)?;
        Some([-s.dot(self.normal) / along, u / det, v / det])
    }

    /// Intersection (t, u, v) of the ray a + t d, |d| = 1, with the plate for t_min < t < t_max; `None` for a ray that starts in the
    /// plane or runs along it.
    #[inline]
    pub(crate) fn hit(&self, line: &PreparedLine, rounding: f64, t_min: f64, t_max: f64) -> Option<[f64; 3]> {
        let s = line.a - self.origin;
        let (da, along) = (s.dot(self.normal), line.d.dot(self.normal));
        if da.abs() <= rounding || along.abs() <= 1e-13 {
            return None;
        }
        let t = -da / along;
        if !(t > t_min && t < t_max) {
            return None;
        }
        let [u, v, det] = self.scaled_parameters(line, s, along)?;
        Some([t, u / det, v / det])
    }

    /// The parameter t at which the line a + t d pierces the plate, for any t; `None` when it runs along the plate.
    #[inline]
    pub(crate) fn pierce(&self, line: &PreparedLine) -> Option<f64> {
        let s = line.a - self.origin;
        let (da, along) = (s.dot(self.normal), line.d.dot(self.normal));
        if along.abs() <= 1e-12 * line.d.max_abs() {
            return None;
        }
        self.scaled_parameters(line, s, along).map(|_| -da / along)
    }

    /// Unit normal of the front.
    pub(crate) fn normal(&self) -> Vec3 {
        self.normal
    }
    /// Signed distance of `p` from the plane.
    pub(crate) fn height(&self, p: Vec3) -> f64 {
        (p - self.origin).dot(self.normal)
    }
    /// Corners, and their number: three or four.
    pub(crate) fn corners(&self) -> ([Vec3; 4], usize) {
        let (a, b, c) = (self.origin, self.origin + self.e1, self.origin + self.e2);
        ([a, b, c, b + self.e2], if self.triangle { 3 } else { 4 })
    }
}
