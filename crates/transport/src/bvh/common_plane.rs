//! Common planes of the plates below a lane of a node.
//!
//! Walls are meshes of coplanar plates, and most segments end on walls. Without further knowledge a query descends to the plates
//! around each end, and along the whole wall where both ends lie in it. The plates below a **flat** lane have one plane to 10⁻¹¹ R, far
//! below the length ε at which an end counts as lying in it. So none is crossed where the ends are not on both sides of it by 0.9 ε,
//! and the lane is left out.

use crate::intersect::PreparedLine;
use zonal_math::Vec3;
use zonal_scene::Plate;

/// Largest distance between the planes of the plates, in units of R.
const COPLANARITY_TOLERANCE: f64 = 1e-11;
/// Fraction of ε within which an end lies in the common plane for certain.
const CERTAIN_SHARE_OF_EPSILON: f64 = 0.9;

/// The common plane of several plates.
#[derive(Clone, Copy, Debug)]
pub(super) struct CommonPlane {
    /// A point of it, m.
    origin: Vec3,
    normal: Vec3,
}

impl CommonPlane {
    /// The common plane of the plates; `scale` maps lengths to the tree's coordinates.
    pub(super) fn of(plates: &[Plate], scale: f64) -> Option<CommonPlane> {
        let first = plates.first()?;
        let (origin, normal) = (first.origin, first.normal());
        let coplanar = |p: &Plate| {
            let (n, height) = (p.normal(), (p.origin - origin).dot(normal));
            let turn = (n - normal).max_abs().min((n + normal).max_abs());
            turn <= 0.1 * COPLANARITY_TOLERANCE && height.abs() * scale <= COPLANARITY_TOLERANCE
        };
        plates.iter().all(coplanar).then_some(CommonPlane { origin, normal })
    }

    /// True when the segment a → a + d certainly crosses none of the plates. Both ends must lie in the scene's bounds.
    #[inline(always)]
    pub(super) fn never_crossed(&self, line: &PreparedLine) -> bool {
        let start = (line.a - self.origin).dot(self.normal);
        let end = start + line.d.dot(self.normal);
        let limit = CERTAIN_SHARE_OF_EPSILON * line.plane;
        (start >= -limit) & (end >= -limit) | (start <= limit) & (end <= limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intersect::Tolerance;

    #[test]
    fn coplanar_plates_have_a_common_plane() {
        let at = |x: f64, y: f64| Vec3::from_array([x, y, 0.25 + 0.5 * x - 0.1 * y]);
        let triangle = |k: f64| Plate::triangle(at(k, 0.0), at(k + 1.0, 0.0), at(k, 1.0));
        let mut plates = vec![triangle(0.0), triangle(1.0), triangle(2.0)];
        let line =
            |a, b: Vec3| PreparedLine::new(a, b - a, &Tolerance { plane: 1e-9, rounding: 0.0, edge: 0.0 });
        let up = Vec3::from_array([0.1, 0.2, 9.0]);
        let never_crossed = |plates: &[Plate], l: &PreparedLine| {
            CommonPlane::of(plates, 0.1).is_some_and(|p| p.never_crossed(l))
        };
        assert!(never_crossed(&plates, &line(at(0.3, 0.3), at(5.0, 8.0))));
        assert!(never_crossed(&plates, &line(at(0.3, 0.3), up)));
        assert!(never_crossed(&plates, &line(at(0.3, 0.3) + up * 1e-6, up)));
        assert!(!never_crossed(&plates, &line(at(0.3, 0.3) - up * 1e-6, up)));
        plates.push(Plate::triangle(at(0.0, 0.0), at(1.0, 0.0), up));
        assert!(!never_crossed(&plates, &line(at(0.3, 0.3), at(0.4, 0.4))));
    }
}
