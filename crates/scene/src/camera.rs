//! Cameras: where they stand and how they see.

use crate::SceneError;
use zonal_math::{Vec3, vec3};

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
    /// The whole of a box (m) from a corner above it, as large as it fits into a picture of that aspect (width over height). The side
    /// from which one looks is that of the viewer's overview.
    pub fn overview((low, high): (Vec3, Vec3), aspect: f64) -> Camera {
        const FOV: f64 = 50.0;
        /// The share of the picture that the box may fill.
        const FILLED: f64 = 0.94;
        let centre = (low + high) * 0.5;
        let up = vec3(0.0, 0.0, 1.0);
        let forward = vec3(-1.0, -1.4, -0.8).normalized();
        let right = forward.cross(up).normalized();
        let above = right.cross(forward);
        let half = FILLED * (0.5 * FOV).to_radians().tan();
        // A corner c is in the picture from the distance |c·r|/tan − c·f on.
        let far = |corner: usize| {
            let end = |k: usize| if corner >> k & 1 == 0 { low.array()[k] } else { high.array()[k] };
            let c = vec3(end(0), end(1), end(2)) - centre;
            (c.dot(right).abs() / half).max(c.dot(above).abs() * aspect / half) - c.dot(forward)
        };
        let distance = (0..8).map(far).fold(1e-3 * (high - low).length(), f64::max);
        Camera {
            name: "overview".into(),
            origin: centre - forward * distance,
            target: centre,
            up,
            fov: FOV,
            lens: Lens::default(),
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// All corners of a box are in the picture, and some corner is close to its border.
    #[test]
    fn an_overview_fills_the_picture() {
        let boxes = [vec3(2.0, 2.0, 4.0), vec3(1.0, 90.0, 3.0), vec3(5.0, 5.0, 0.0), vec3(0.0, 1e-3, 1e-3)];
        for size in boxes {
            for aspect in [0.3, 1.0, 4.0 / 3.0, 5.0] {
                let low = vec3(-3.0, 7.0, 1.0);
                let c = Camera::overview((low, low + size), aspect);
                c.check().unwrap();
                let f = (c.target - c.origin).normalized();
                let r = f.cross(c.up).normalized();
                let half = (0.5 * c.fov.to_radians()).tan();
                let place = |k: usize| {
                    let corner = Vec3::from_array(std::array::from_fn(|a| {
                        low[a] + if k >> a & 1 == 1 { size[a] } else { 0.0 }
                    }));
                    let way = corner - c.origin;
                    let [x, y] = [r, r.cross(f)].map(|u| (way.dot(u) / (way.dot(f) * half)).abs());
                    assert!(way.dot(f) > 0.0);
                    x.max(y * aspect)
                };
                let most = (0..8).map(place).fold(0.0, f64::max);
                assert!((0.9..0.95).contains(&most), "{size:?} {aspect}: {most}");
            }
        }
    }
}
