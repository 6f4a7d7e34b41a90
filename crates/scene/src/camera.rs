//! Cameras: where they stand and how they see.

use crate::SceneError;
use zonal_math::Vec3;

/// A thin lens; a pinhole where its aperture is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lens {
    /// Diameter of the opening, m.
    pub aperture: f64,
    /// Distance of the plane in focus along the line of sight, m; none: that of what the middle of the picture sees.
    pub focus: Option<f64>,
}

/// A camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Unique name.
    pub name: String,
    /// Middle of the lens, or the pinhole, m.
    pub origin: Vec3,
    /// A point in the middle of the picture, m.
    pub target: Vec3,
    /// Upward direction.
    pub up: Vec3,
    /// Full angle of view across the picture's width, degrees.
    pub fov: f64,
    /// Its lens.
    pub lens: Lens,
}

impl Camera {
    /// Refuses what no camera can be; keys are `camera 'NAME'.KEY`.
    pub fn check(&self) -> Result<(), SceneError> {
        let fail =
            |key: &str, what: &str| Err(SceneError::new(format!("camera '{}'.{key}", self.name), what));
        let view = self.target - self.origin;
        if !(self.origin.is_finite() && self.target.is_finite() && view.length() > 0.0) {
            return fail("target", "origin and target must be finite and apart");
        }
        let askew = view.normalized().cross(self.up.normalized()).length();
        if askew <= 1e-9 || askew.is_nan() {
            return fail("up", "up must not run along the line of sight");
        }
        if !(self.fov > 0.0 && self.fov < 180.0) {
            return fail("fov", "the field of view must lie between 0 and 180 degrees");
        }
        if !(self.lens.aperture.is_finite() && self.lens.aperture >= 0.0) {
            return fail("aperture", "the lens must have a diameter from 0");
        }
        if self.lens.focus.is_some_and(|f| !(f.is_finite() && f > 0.0)) {
            return fail("focus", "the distance in focus must be positive");
        }
        Ok(())
    }
}
