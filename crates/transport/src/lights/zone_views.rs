//! Plates and boxes as seen from a point light: points by solid angle.
//!
//! With the intensity I(ω) of a light at p, the irradiance of a plate of area A and the fluence in a box of volume V are, in their mean,
//!
//! ```text
//! H = 1/A ∫ I τ dω      G = 1/V ∫ I ∫ τ dr dω      over the directions ω in which plate or box are seen
//! ```
//!
//! since cosθ/r² dA = dω and dV/r² = dr dω. Directions that are uniform over the solid angle have bounded contributions however near the light is, inside a box
//! too. A box is seen through those of its faces whose outer side the light sees, or through all from within. Solid angles: `visible_polygon`.

use super::receiver::Receiver;
use super::visible_polygon::{EmitterFacet, VisiblePolygon};
use zonal_math::{Vec3, vec3};
use zonal_scene::{Plate, PlateKind};

/// A light nearer to the plane of a plate, over the plate's size, lies in it.
const IN_PLANE_SHARE: f64 = 1e-9;

/// A plate as seen from a point.
pub struct PlateView {
    from: Vec3,
    facet: EmitterFacet,
    polygon: VisiblePolygon,
}

impl PlateView {
    /// The view of a plate from the point `from`, m; `None` in the plane of the plate.
    #[must_use]
    pub fn new(plate: &Plate, from: Vec3) -> Option<PlateView> {
        let facet = EmitterFacet::new(0, *plate);
        let local = facet.local(from - plate.origin);
        if local.z.abs() <= IN_PLANE_SHARE * plate.e1.length().max(plate.e2.length()) {
            return None;
        }
        let polygon = VisiblePolygon::new(&facet, local, Receiver::Free)?;
        Some(PlateView { from, facet, polygon })
    }

    /// Solid angle of the plate, sr.
    #[must_use]
    pub fn solid_angle(&self) -> f64 {
        self.polygon.solid_angle
    }

    /// The point of the plate at `s` ∈ [0,1)², uniform in solid angle.
    #[must_use]
    pub fn sample(&self, s: [f64; 2]) -> Option<Vec3> {
        let [u, v] = self.facet.clamped_uv(self.polygon.sample(s)?);
        Some(self.facet.plate.at(u, v))
    }

    /// The point in which the plate meets a direction from the point of view; `None` for a direction that misses it.
    #[must_use]
    pub fn hit(&self, direction: Vec3) -> Option<Vec3> {
        let (plate, normal) = (&self.facet.plate, self.facet.normal());
        let t = (plate.origin - self.from).dot(normal) / direction.dot(normal);
        if !(t.is_finite() && t > 0.0) {
            return None;
        }
        let at = self.from + direction * t;
        let [u, v] = self.facet.parameters_of(self.facet.local(at - plate.origin));
        let inside = match plate.kind {
            PlateKind::Triangle => u + v <= 1.0,
            PlateKind::Parallelogram => u <= 1.0 && v <= 1.0,
        };
        (u >= 0.0 && v >= 0.0 && inside).then_some(at)
    }
}

/// A box as seen from a point.
pub struct BoxView {
    from: Vec3,
    bounds: [Vec3; 2],
    faces: Vec<PlateView>,
}

/// The part of a ray within a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxChord {
    /// Unit vector from the point of view.
    pub direction: Vec3,
    /// Distance of the nearer end, m; 0 from within.
    pub near: f64,
    /// Length, m.
    pub length: f64,
}

impl BoxView {
    /// The view of the box between two corners from the point `from`, m.
    #[must_use]
    pub fn new(lo: Vec3, hi: Vec3, from: Vec3) -> BoxView {
        let outside = |k: usize| from[k] < lo[k] || from[k] > hi[k];
        let within = !(0..3).any(outside);
        let faces = (0..3).flat_map(|k| [(k, lo), (k, hi)]).filter_map(|(k, corner)| {
            let turned_to = if corner[k] == lo[k] { from[k] < lo[k] } else { from[k] > hi[k] };
            let faces = within || turned_to;
            faces.then(|| PlateView::new(&face(lo, hi, k, corner[k]), from)).flatten()
        });
        BoxView { from, bounds: [lo, hi], faces: faces.collect() }
    }

    /// Solid angle of the box, sr; 4π from within.
    #[must_use]
    pub fn solid_angle(&self) -> f64 {
        self.faces.iter().map(PlateView::solid_angle).sum()
    }

    /// The chord at `s` ∈ [0,1)², its direction uniform in solid angle.
    #[must_use]
    pub fn sample(&self, s: [f64; 2]) -> Option<BoxChord> {
        let mut rest = s[0] * self.solid_angle();
        for (k, face) in self.faces.iter().enumerate() {
            let own = face.solid_angle();
            if rest < own || k + 1 == self.faces.len() {
                let at = face.sample([(rest / own).min(1.0 - f64::EPSILON), s[1]])?;
                return self.chord((at - self.from).normalized());
            }
            rest -= own;
        }
        None
    }

    /// The part within the box of the ray in the unit direction `direction`; `None` for a ray that misses it.
    #[must_use]
    pub fn chord(&self, direction: Vec3) -> Option<BoxChord> {
        let [lo, hi] = self.bounds;
        let (mut near, mut far) = (0.0f64, f64::INFINITY);
        for k in 0..3 {
            let (a, b) = ((lo[k] - self.from[k]) / direction[k], (hi[k] - self.from[k]) / direction[k]);
            if direction[k] == 0.0 {
                if self.from[k] < lo[k] || self.from[k] > hi[k] {
                    return None;
                }
                continue;
            }
            (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
        }
        let length = far - near;
        (length > 0.0 && length.is_finite()).then_some(BoxChord { direction, near, length })
    }
}

/// The face of a box at the coordinate `at` of axis `k`.
fn face(lo: Vec3, hi: Vec3, k: usize, at: f64) -> Plate {
    let edge = |axis: usize| {
        let mut e = [0.0; 3];
        e[axis] = hi[axis] - lo[axis];
        vec3(e[0], e[1], e[2])
    };
    let mut origin = [lo.x, lo.y, lo.z];
    origin[k] = at;
    Plate::parallelogram(Vec3::from_array(origin), edge((k + 1) % 3), edge((k + 2) % 3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;
    use zonal_math::{low_discrepancy, scrambled_sobol};

    #[test]
    fn means_over_solid_angles_equal_means_over_volumes() {
        let (lo, hi) = (vec3(0.0, 0.0, 0.0), vec3(1.0, 2.0, 0.5));
        let volume = (hi - lo).product();
        for from in [vec3(0.3, 1.2, 0.1), vec3(2.0, -1.0, 0.2), vec3(-0.4, 3.0, 1.5), vec3(0.0, 1.0, 0.25)] {
            let view = BoxView::new(lo, hi, from);
            let n = 1 << 16;
            // ∫ (1 + x)/(r² + 0.04) dV by directions, and by points, which leave 1/r² too noisy within the box.
            let softened = |x: Vec3| (1.0 + x.x) / ((x - from).length2() + 0.04);
            let mut by_direction = 0.0;
            for i in 0..n {
                let [a, b, c, _] = scrambled_sobol::first_dimensions_of_blocks(i, 1);
                let chord = view.sample([a, b]).unwrap();
                let x = from + chord.direction * (chord.near + c * chord.length);
                let r2 = (x - from).length2();
                by_direction += softened(x) * r2 * chord.length * view.solid_angle() / n as f64;
            }
            let by_point = (0..n << 3)
                .map(|i| {
                    let u = low_discrepancy::r3(i, [0.1, 0.3, 0.5]);
                    let x = lo + (hi - lo).scale(Vec3::from_array(u));
                    softened(x) * volume / (n << 3) as f64
                })
                .sum::<f64>();
            assert!((by_direction / by_point - 1.0).abs() < 2e-3, "{from:?}: {by_direction} {by_point}");
        }
        assert!((BoxView::new(lo, hi, vec3(0.3, 1.2, 0.1)).solid_angle() - 4.0 * PI).abs() < 1e-9);
        // From a face, the half-space of the box.
        assert!((BoxView::new(lo, hi, vec3(0.0, 1.0, 0.25)).solid_angle() - 2.0 * PI).abs() < 1e-9);
    }

    #[test]
    fn a_plate_is_hit_where_it_is_sampled() {
        let e = (vec3(1.0, 0.2, 0.0), vec3(0.1, 0.8, 0.3));
        let from = vec3(0.4, 0.3, 1.5);
        for plate in [Plate::parallelogram(Vec3::ZERO, e.0, e.1), Plate::triangle(Vec3::ZERO, e.0, e.1)] {
            let view = PlateView::new(&plate, from).unwrap();
            for i in 0..200 {
                let at = view.sample(low_discrepancy::r2(i, [0.5, 0.5])).unwrap();
                let hit = view.hit((at - from).normalized()).unwrap();
                assert!((hit - at).length() < 1e-9, "{hit:?} {at:?}");
            }
            assert!(view.hit(vec3(0.0, 0.0, 1.0)).is_none());
            let off = vec3(2.0, 2.0, 0.0) - from;
            assert!(view.hit(off.normalized()).is_none());
            assert!(PlateView::new(&plate, plate.at(0.3, 0.3)).is_none());
        }
    }
}
