//! Cameras: pinholes and thin lenses.

use crate::base::scene_error::{SceneError, invalid};
use zonal_math::{Vec3, vec3};

/// A thin lens; a pinhole if the aperture is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Deserialize, serde::Serialize)]
pub struct Lens {
    /// Diameter of the aperture, m.
    #[serde(default)]
    pub aperture: f64,
    /// Distance of the focal plane along the line of sight, m; if `None`, the distance of the first surface in the picture's centre.
    pub focus: Option<f64>,
}

/// A camera.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
pub struct Camera {
    /// Unique name.
    pub name: String,
    /// Centre of the lens, or the pinhole, m.
    pub origin: Vec3,
    /// A point in the centre of the picture, m.
    pub target: Vec3,
    /// Upward direction.
    pub up: Vec3,
    /// Full horizontal angle of view, degrees.
    pub fov: f64,
    /// The lens.
    #[serde(flatten)]
    pub lens: Lens,
}

/// Full horizontal angle of view of an overview, degrees.
const OVERVIEW_FOV_DEGREES: f64 = 50.0;
/// Fraction of the picture's half width that the box may fill in an overview.
const OVERVIEW_FILL_FRACTION: f64 = 0.94;
/// Smallest distance of an overview, in units of the diagonal of the box.
const MIN_OVERVIEW_DISTANCE: f64 = 1e-3;
/// Smallest sine of the angle between the upward direction and the line of sight.
const MIN_UP_SINE: f64 = 1e-9;

impl Camera {
    /// A pinhole camera at a point that looks at another, m, with z up and a field of view of 60 degrees across the picture's width.
    ///
    /// ```
    /// use zonal_scene::Camera;
    /// let camera = Camera::look_at([0.0, -3.0, 1.5], [0.0, 0.0, 1.0]).name("front").field_of_view_degrees(45.0);
    /// assert!(camera.check().is_ok());
    /// ```
    #[must_use]
    pub fn look_at(origin: [f64; 3], target: [f64; 3]) -> Camera {
        Camera {
            name: "camera".into(),
            origin: Vec3::from_array(origin),
            target: Vec3::from_array(target),
            up: vec3(0.0, 0.0, 1.0),
            fov: 60.0,
            lens: Lens::default(),
        }
    }

    /// Sets the name, which has to be unique in the scene.
    #[must_use]
    pub fn name(mut self, name: impl Into<String>) -> Camera {
        self.name = name.into();
        self
    }

    /// Sets the field of view across the picture's width, degrees.
    #[must_use]
    pub fn field_of_view_degrees(mut self, degrees: f64) -> Camera {
        self.fov = degrees;
        self
    }

    /// A view of a whole box (lower and upper corner, m) from above one of its edges, as large as it fits into a picture of the given
    /// aspect ratio (width over height). The viewer's overview has the same direction.
    ///
    /// ```
    /// use zonal_math::Vec3;
    /// let camera = zonal_scene::Camera::overview(Vec3::ZERO, Vec3::ONE, 4.0 / 3.0);
    /// assert!(camera.check().is_ok());
    /// assert_eq!(camera.target, Vec3::splat(0.5));
    /// ```
    pub fn overview(low: Vec3, high: Vec3, aspect: f64) -> Camera {
        Camera::framing(low, high, vec3(-1.0, -1.4, -0.8), aspect).name("overview")
    }

    /// A view of a whole box (lower and upper corner, m) along a direction that is not vertical, as large as it fits into a picture of the given aspect ratio
    /// (width over height).
    #[must_use]
    pub fn framing(low: Vec3, high: Vec3, direction: Vec3, aspect: f64) -> Camera {
        let centre = (low + high) * 0.5;
        let up = vec3(0.0, 0.0, 1.0);
        let forward = direction.normalized();
        let right = forward.cross(up).normalized();
        let above = right.cross(forward);
        let half = OVERVIEW_FILL_FRACTION * (0.5 * OVERVIEW_FOV_DEGREES).to_radians().tan();
        // A corner c is inside the picture for distances of at least |c·r|/tan − c·f.
        let corner_distance = |corner: usize| {
            let end = |k: usize| if corner >> k & 1 == 0 { low.array()[k] } else { high.array()[k] };
            let c = vec3(end(0), end(1), end(2)) - centre;
            (c.dot(right).abs() / half).max(c.dot(above).abs() * aspect / half) - c.dot(forward)
        };
        let distance =
            (0..8).map(corner_distance).fold(MIN_OVERVIEW_DISTANCE * (high - low).length(), f64::max);
        let origin = centre - forward * distance;
        Camera { fov: OVERVIEW_FOV_DEGREES, ..Camera::look_at(origin.array(), centre.array()) }
    }

    /// Validates the camera.
    ///
    /// # Errors
    /// If a value is out of range; keys are `camera 'NAME'.KEY`.
    pub fn check(&self) -> Result<(), SceneError> {
        let fail = |key: &str, message: &str| invalid(format!("camera '{}'.{key}", self.name), message);
        let view = self.target - self.origin;
        if !(self.origin.is_finite() && self.target.is_finite() && view.length() > 0.0) {
            return fail("target", "origin and target must be finite and apart");
        }
        let up_sine = view.normalized().cross(self.up.normalized()).length();
        if up_sine <= MIN_UP_SINE || up_sine.is_nan() {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// All corners of a box are in the picture, and at least one is close to the border.
    #[test]
    fn overview_fills_the_picture() {
        let boxes = [vec3(2.0, 2.0, 4.0), vec3(1.0, 90.0, 3.0), vec3(5.0, 5.0, 0.0), vec3(0.0, 1e-3, 1e-3)];
        for size in boxes {
            for aspect in [0.3, 1.0, 4.0 / 3.0, 5.0] {
                let low = vec3(-3.0, 7.0, 1.0);
                let c = Camera::overview(low, low + size, aspect);
                c.check().unwrap();
                let f = (c.target - c.origin).normalized();
                let r = f.cross(c.up).normalized();
                let half = (0.5 * c.fov.to_radians()).tan();
                let border_fraction = |k: usize| {
                    let corner = Vec3::from_array(std::array::from_fn(|a| {
                        low[a] + if k >> a & 1 == 1 { size[a] } else { 0.0 }
                    }));
                    let view = corner - c.origin;
                    let [x, y] = [r, r.cross(f)].map(|u| (view.dot(u) / (view.dot(f) * half)).abs());
                    assert!(view.dot(f) > 0.0);
                    x.max(y * aspect)
                };
                let largest = (0..8).map(border_fraction).fold(0.0, f64::max);
                assert!((0.9..0.95).contains(&largest), "{size:?} {aspect}: {largest}");
            }
        }
    }
}
