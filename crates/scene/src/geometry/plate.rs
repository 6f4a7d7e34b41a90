//! Plates: the triangles and parallelograms of which all surfaces consist.
//!
//! A point of a plate is x(u, v) = origin + u e1 + v e2 with (u, v) in the unit square (parallelogram) or in u, v ≥ 0,
//! u + v ≤ 1 (triangle). The front is the side that e1 × e2 points to.

use zonal_math::Vec3;

/// Parameter domain of a plate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlateKind {
    /// u, v ≥ 0, u + v ≤ 1.
    Triangle,
    /// 0 ≤ u, v ≤ 1.
    Parallelogram,
}

/// A flat triangle or parallelogram.
///
/// ```
/// use zonal_math::vec3;
/// use zonal_scene::Plate;
/// let plate = Plate::triangle(vec3(0.0, 0.0, 0.0), vec3(2.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
/// assert_eq!(plate.area(), 1.0);
/// assert_eq!(plate.normal(), vec3(0.0, 0.0, 1.0));
/// assert_eq!(plate.flipped().normal(), -plate.normal());
/// assert_eq!(plate.quarters().iter().map(Plate::area).sum::<f64>(), 1.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plate {
    /// Corner at (u, v) = (0, 0).
    pub origin: Vec3,
    /// Edge along u.
    pub e1: Vec3,
    /// Edge along v.
    pub e2: Vec3,
    /// Triangle or parallelogram.
    pub kind: PlateKind,
}

impl Plate {
    /// The triangle with these corners, counter-clockwise from the front.
    pub fn triangle(a: Vec3, b: Vec3, c: Vec3) -> Plate {
        Plate { origin: a, e1: b - a, e2: c - a, kind: PlateKind::Triangle }
    }
    /// The parallelogram spanned by `e1` and `e2` at `origin`.
    pub fn parallelogram(origin: Vec3, e1: Vec3, e2: Vec3) -> Plate {
        Plate { origin, e1, e2, kind: PlateKind::Parallelogram }
    }
    /// The point with parameters (u, v).
    pub fn at(&self, u: f64, v: f64) -> Vec3 {
        self.origin + self.e1 * u + self.e2 * v
    }
    /// Area, m².
    pub fn area(&self) -> f64 {
        let full = self.e1.cross(self.e2).length();
        if self.kind == PlateKind::Triangle { 0.5 * full } else { full }
    }
    /// Unit normal of the front; zero for a degenerate plate.
    pub fn normal(&self) -> Vec3 {
        self.e1.cross(self.e2).normalized()
    }
    /// Centroid.
    pub fn centre(&self) -> Vec3 {
        let t = if self.kind == PlateKind::Triangle { 1.0 / 3.0 } else { 0.5 };
        self.at(t, t)
    }
    /// True where all of the plate lies behind the plane through `point` with the unit normal `normal`, or within `tolerance`, m, before it.
    #[must_use]
    pub fn is_behind(&self, point: Vec3, normal: Vec3, tolerance: f64) -> bool {
        let (corners, n) = self.corners();
        corners[..n].iter().all(|c| normal.dot(*c - point) <= tolerance)
    }
    /// The corners, counter-clockwise from the front, and their number: three or four.
    pub fn corners(&self) -> ([Vec3; 4], usize) {
        let (a, b, d) = (self.origin, self.origin + self.e1, self.origin + self.e2);
        match self.kind {
            PlateKind::Triangle => ([a, b, d, d], 3),
            PlateKind::Parallelogram => ([a, b, b + self.e2, d], 4),
        }
    }
    /// The plate with reversed normal: the same points, u and v exchanged.
    pub fn flipped(&self) -> Plate {
        Plate { origin: self.origin, e1: self.e2, e2: self.e1, kind: self.kind }
    }
    /// Smallest and largest coordinates, m.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let (c, n) = self.corners();
        c[..n].iter().fold((c[0], c[0]), |(lo, hi), &p| (lo.min(p), hi.max(p)))
    }
    /// Largest distance between two corners, m.
    pub fn diameter(&self) -> f64 {
        let (c, n) = self.corners();
        let mut d2: f64 = 0.0;
        for i in 0..n {
            for j in 0..i {
                d2 = d2.max((c[i] - c[j]).length2());
            }
        }
        d2.sqrt()
    }
    /// Maps a point of the unit square to (u, v) of this plate; the map preserves area ratios.
    pub fn warp(&self, s: [f64; 2]) -> [f64; 2] {
        match self.kind {
            PlateKind::Parallelogram => s,
            // Fold the square along the diagonal.
            PlateKind::Triangle if s[0] + s[1] > 1.0 => [1.0 - s[0], 1.0 - s[1]],
            PlateKind::Triangle => s,
        }
    }
    /// Parameters (u, v) of the point of the plate's plane nearest to `p`.
    pub fn parameters(&self, p: Vec3) -> [f64; 2] {
        let d = p - self.origin;
        let (a, b, c) = (self.e1.length2(), self.e1.dot(self.e2), self.e2.length2());
        let (x, y) = (d.dot(self.e1), d.dot(self.e2));
        let det = a * c - b * b;
        [(x * c - y * b) / det, (y * a - x * b) / det]
    }
    /// Four plates of a quarter of the area each, with the same kind and orientation.
    pub fn quarters(&self) -> [Plate; 4] {
        let (h1, h2) = (self.e1 * 0.5, self.e2 * 0.5);
        let corner_quarter = |o: Vec3| Plate { origin: o, e1: h1, e2: h2, kind: self.kind };
        let o = self.origin;
        match self.kind {
            PlateKind::Parallelogram => [
                corner_quarter(o),
                corner_quarter(o + h1),
                corner_quarter(o + h1 + h2),
                corner_quarter(o + h2),
            ],
            PlateKind::Triangle => {
                let middle = Plate { origin: o + h1 + h2, e1: -h1, e2: -h2, kind: PlateKind::Triangle };
                [corner_quarter(o), corner_quarter(o + h1), middle, corner_quarter(o + h2)]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    #[test]
    fn quarters_tile_the_plate() {
        for kind in [PlateKind::Triangle, PlateKind::Parallelogram] {
            let p =
                Plate { origin: vec3(1.0, 2.0, 3.0), e1: vec3(2.0, 0.5, 0.0), e2: vec3(0.1, 1.0, 0.3), kind };
            let q = p.quarters();
            let area: f64 = q.iter().map(Plate::area).sum();
            assert!((area - p.area()).abs() < 1e-14);
            let mean = q.iter().fold(Vec3::ZERO, |s, x| s + x.centre() * 0.25);
            assert!((mean - p.centre()).length() < 1e-14);
            assert!(q.iter().all(|x| (x.normal() - p.normal()).length() < 1e-14));
            assert!((p.flipped().normal() + p.normal()).length() < 1e-14);
        }
    }

    #[test]
    fn parameters_are_the_inverse_of_at() {
        let p = Plate::triangle(vec3(0.0, 0.0, 1.0), vec3(2.0, 0.0, 1.0), vec3(0.5, 1.5, 2.0));
        let [u, v] = p.parameters(p.at(0.2, 0.3));
        assert!((u - 0.2).abs() < 1e-14 && (v - 0.3).abs() < 1e-14);
    }
}
