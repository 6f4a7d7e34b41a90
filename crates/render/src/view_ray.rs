//! A ray in parametric form, x(t) = o + t d with a unit direction d.

use zonal_math::Vec3;

/// Origin and unit direction of a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ViewRay {
    /// Origin o, m.
    pub origin: Vec3,
    /// Unit direction d.
    pub dir: Vec3,
}

impl ViewRay {
    /// The point at the distance `t`, m.
    pub(crate) fn at(&self, t: f64) -> Vec3 {
        self.origin + self.dir * t
    }
}
