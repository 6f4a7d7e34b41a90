//! A pinhole camera.
//!
//! With f the unit vector to the target, r = f × up and u = r × f (unit vectors) the point (x, y) of the picture, both from 0 to
//! 1 with y down, is seen along f + (2x − 1) tan(φ/2) r + (1 − 2y) tan(φ/2) (h/w) u: φ is the full angle across the width w.

use zonal_math::Vec3;
use zonal_scene::Camera;

/// A camera with the size of its picture.
pub(crate) struct Pinhole {
    pub origin: Vec3,
    forward: Vec3,
    right: Vec3,
    up: Vec3,
}

impl Pinhole {
    pub fn new(camera: &Camera, width: usize, height: usize) -> Pinhole {
        let forward = (camera.target - camera.origin).normalized();
        let right = forward.cross(camera.up).normalized();
        let half = (0.5 * camera.fov.to_radians()).tan();
        Pinhole {
            origin: camera.origin,
            forward,
            right: right * half,
            up: right.cross(forward) * (half * height as f64 / width as f64),
        }
    }
    /// Where in the picture, x and y ∈ [0,1] with y down, a point is seen; `None` behind the camera.
    pub fn place(&self, point: Vec3) -> Option<[f64; 2]> {
        let way = point - self.origin;
        let depth = way.dot(self.forward);
        let across = |axis: Vec3| way.dot(axis) / (axis.length2() * depth);
        (depth > 0.0).then(|| [0.5 + 0.5 * across(self.right), 0.5 - 0.5 * across(self.up)])
    }
    /// Unit direction through (x, y) ∈ [0,1]², y down.
    pub fn direction(&self, x: f64, y: f64) -> Vec3 {
        (self.forward + self.right * (2.0 * x - 1.0) + self.up * (1.0 - 2.0 * y)).normalized()
    }
}

/// The `i`-th of `n` points of a pixel: a regular grid where n is a square, else the R₂ sequence.
pub(crate) fn subpixel(i: usize, n: usize) -> [f64; 2] {
    let side = (n as f64).sqrt().round() as usize;
    if side * side == n {
        let at = |k: usize| (k as f64 + 0.5) / side as f64;
        [at(i % side), at(i / side)]
    } else {
        zonal_math::sequence::r2(i, [0.0; 2])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    #[test]
    fn the_field_of_view_spans_the_width() {
        let camera = Camera {
            name: "c".into(),
            origin: Vec3::ZERO,
            target: vec3(0.0, 3.0, 0.0),
            up: vec3(0.0, 0.0, 1.0),
            fov: 90.0,
        };
        let p = Pinhole::new(&camera, 200, 100);
        let edge = |x, y| p.direction(x, y);
        assert!((edge(1.0, 0.5) - vec3(1.0, 1.0, 0.0).normalized()).length() < 1e-15);
        assert!((edge(0.5, 0.0) - vec3(0.0, 1.0, 0.5).normalized()).length() < 1e-15);
        let [x, y] = p.place(edge(0.3, 0.8) * 5.0).unwrap();
        assert!(
            (x - 0.3).abs() < 1e-12 && (y - 0.8).abs() < 1e-12 && p.place(edge(0.3, 0.8) * -5.0).is_none()
        );
        assert!((edge(0.5, 0.5) - vec3(0.0, 1.0, 0.0)).length() < 1e-15);
    }
}
