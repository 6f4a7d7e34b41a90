//! Perspective camera: pinhole or thin lens.
//!
//! With f the unit vector to the target, r = f × up and u = r × f (unit vectors), the point (x, y) of the picture, both from 0 to 1 with y
//! down, is seen along d = f + (2x − 1) tan(φ/2) r + (1 − 2y) tan(φ/2) (h/w) u, where φ is the full angle across the width w.
//!
//! A lens of diameter A in focus at the distance F along f sends the rays of that point from its whole disc, o + (A/2)(p r + q u) with
//! p² + q² < 1, through the one point o + F d. At the distance D along f they fill a disc of diameter A |D − F|/F (circle of confusion).

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use zonal_math::{Vec3, low_discrepancy};
use zonal_scene::Camera;

/// Focus distance of a lens without a focus, diameters of the lens: numerically infinite.
const INFINITE_FOCUS: f64 = 1e9;

/// A camera with the size of its picture.
pub(crate) struct PerspectiveCamera {
    pub origin: Vec3,
    forward: Vec3,
    right: Vec3,
    up: Vec3,
    lens: Option<LensDisc>,
}

/// The opening of a lens.
struct LensDisc {
    /// r A/2 and u A/2, m.
    right: Vec3,
    up: Vec3,
    /// F, m.
    focus: f64,
}

impl PerspectiveCamera {
    /// A camera for a picture of `width` × `height` pixels; a lens without a focus is in focus at infinity.
    pub(crate) fn new(camera: &Camera, width: usize, height: usize) -> PerspectiveCamera {
        let forward = (camera.target - camera.origin).normalized();
        let right = forward.cross(camera.up).normalized();
        let up = right.cross(forward);
        let half = (0.5 * camera.fov.to_radians()).tan();
        let aperture = camera.lens.aperture;
        let (radius, focus) = (0.5 * aperture, camera.lens.focus.unwrap_or(INFINITE_FOCUS * aperture));
        PerspectiveCamera {
            origin: camera.origin,
            forward,
            right: right * half,
            up: up * (half * height as f64 / width as f64),
            lens: (aperture > 0.0).then(|| LensDisc { right: right * radius, up: up * radius, focus }),
        }
    }
    /// Picture coordinates of a point, x and y ∈ [0,1] with y down; `None` behind the camera.
    pub(crate) fn project(&self, point: Vec3) -> Option<[f64; 2]> {
        let offset = point - self.origin;
        let depth = offset.dot(self.forward);
        let across = |axis: Vec3| offset.dot(axis) / (axis.length2() * depth);
        (depth > 0.0).then(|| [0.5 + 0.5 * across(self.right), 0.5 - 0.5 * across(self.up)])
    }
    /// True where rays start at points of a lens.
    pub(crate) fn has_lens(&self) -> bool {
        self.lens.is_some()
    }
    /// The vector d of the module header.
    fn view_vector(&self, x: f64, y: f64) -> Vec3 {
        self.forward + self.right * (2.0 * x - 1.0) + self.up * (1.0 - 2.0 * y)
    }
    /// Unit direction from the origin through (x, y) ∈ [0,1]², y down.
    pub(crate) fn direction(&self, x: f64, y: f64) -> Vec3 {
        self.view_vector(x, y).normalized()
    }
    /// Origin and unit direction of the `i`-th ray through (x, y) ∈ [0,1]², y down; a pixel's rays share a shift.
    pub(crate) fn ray(&self, [x, y]: [f64; 2], i: usize, shift: [f64; 2]) -> (Vec3, Vec3) {
        let Some(lens) = &self.lens else {
            return (self.origin, self.direction(x, y));
        };
        let [p, q] = concentric_disc(low_discrepancy::r2(i, shift));
        let off = lens.right * p + lens.up * q;
        (self.origin + off, (self.view_vector(x, y) * lens.focus - off).normalized())
    }
}

/// Concentric map of the unit square onto the unit disc, areas kept (Shirley and Chiu, 1997).
fn concentric_disc([x, y]: [f64; 2]) -> [f64; 2] {
    let (a, b) = (2.0 * x - 1.0, 2.0 * y - 1.0);
    if a == 0.0 && b == 0.0 {
        return [0.0; 2];
    }
    let (radius, angle) =
        if a.abs() > b.abs() { (a, FRAC_PI_4 * b / a) } else { (b, FRAC_PI_2 - FRAC_PI_4 * a / b) };
    [radius * angle.cos(), radius * angle.sin()]
}

/// The `i`-th of `n` points of a pixel: a regular grid where n is a square, else the R₂ sequence.
pub(crate) fn subpixel(i: usize, n: usize) -> [f64; 2] {
    let side = (n as f64).sqrt().round() as usize;
    if side * side == n {
        let at = |k: usize| (k as f64 + 0.5) / side as f64;
        [at(i % side), at(i / side)]
    } else {
        zonal_math::low_discrepancy::r2(i, [0.0; 2])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;
    use zonal_scene::Lens;

    fn camera(aperture: f64, focus: Option<f64>) -> Camera {
        let ahead = Camera::look_at([0.0; 3], [0.0, 3.0, 0.0]);
        Camera { fov: 90.0, lens: Lens { aperture, focus }, ..ahead }
    }

    #[test]
    fn field_of_view_spans_the_width() {
        let p = PerspectiveCamera::new(&camera(0.0, Some(2.0)), 200, 100);
        let edge = |x, y| p.ray([x, y], 7, [0.3, 0.1]);
        let same = |x, y, d: Vec3| {
            let (origin, dir) = edge(x, y);
            assert!(origin == Vec3::ZERO && (dir - d.normalized()).length() < 1e-15);
        };
        same(1.0, 0.5, vec3(1.0, 1.0, 0.0));
        same(0.5, 0.0, vec3(0.0, 1.0, 0.5));
        same(0.5, 0.5, vec3(0.0, 1.0, 0.0));
        let far = p.direction(0.3, 0.8) * 5.0;
        let [x, y] = p.project(far).unwrap();
        assert!((x - 0.3).abs() < 1e-12 && (y - 0.8).abs() < 1e-12 && p.project(-far).is_none());
    }

    /// The rays of one point of the picture meet in the focal plane, and fill the circle of confusion elsewhere.
    #[test]
    fn lens_rays_fill_the_circle_of_confusion() {
        let (aperture, focus, n) = (0.2, 2.0, 4096);
        let p = PerspectiveCamera::new(&camera(aperture, Some(focus)), 200, 100);
        for distance in [2.0, 1.0, 3.0, 8.0] {
            let at = |i: usize| {
                let (o, d) = p.ray([0.7, 0.4], i, [0.2, 0.6]);
                o + d * ((distance - o.y) / d.y)
            };
            let blur = aperture * (distance - focus).abs() / focus;
            let middle = vec3(0.4, 1.0, 0.1) * distance;
            let off: Vec<f64> = (0..n).map(|i| (at(i) - middle).length()).collect();
            let widest = off.iter().fold(0.0f64, |m, x| m.max(*x));
            assert!(widest <= 0.5 * blur + 1e-12 && widest > 0.49 * blur - 1e-12, "{distance}: {widest}");
            // Uniformly: the mean square distance in a disc is half its radius squared.
            let square = off.iter().map(|x| x * x).sum::<f64>() / n as f64;
            assert!((square - blur * blur / 8.0).abs() <= 1e-3 * blur * blur + 1e-24, "{distance}: {square}");
        }
        // Without a focus the rays are parallel.
        let far = PerspectiveCamera::new(&camera(aperture, None), 200, 100);
        let (a, b) = (far.ray([0.7, 0.4], 0, [0.0; 2]), far.ray([0.7, 0.4], 1, [0.0; 2]));
        assert!((a.1 - b.1).length() < 1e-8 && (a.0 - b.0).length() > 1e-3);
    }
}
