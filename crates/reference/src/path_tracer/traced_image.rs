//! Pictures of a pinhole camera with standard errors.
//!
//! With f the unit vector to the target, r = f × up and u = r × f (unit vectors), the point (x, y) of the picture, both from 0 to 1
//! with y down, is seen along f + (2x − 1) tan(φ/2) r + (1 − 2y) tan(φ/2) (h/w) u. A pixel is the mean over its square. Suns are not
//! visible as discs; surroundings and skies are.

use super::path::PathNumbers;
use super::tracer::PathTracer;
use crate::estimate::{SampleStatistics, add_sample};
use crate::rng::{Rng, hash};
use zonal_math::Vec3;
use zonal_math::parallel;
use zonal_scene::{Bands, Camera, PerBand};

/// A picture: radiance, W/(m² sr) per band, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct TracedImage {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Mean of each pixel.
    pub mean: Vec<Bands>,
    /// Standard error of each mean.
    pub error: Vec<Bands>,
}

impl PathTracer<'_> {
    /// The picture of a camera with `samples` paths per pixel, at least two. The same bits for any number of threads.
    pub fn picture(
        &self,
        camera: &Camera,
        width: usize,
        height: usize,
        samples: usize,
        seed: u64,
    ) -> TracedImage {
        let forward = (camera.target - camera.origin).normalized();
        let right = forward.cross(camera.up).normalized();
        let up = right.cross(forward);
        let half = (0.5 * camera.fov.to_radians()).tan();
        let direction = |x: f64, y: f64| -> Vec3 {
            let rise = (1.0 - 2.0 * y) * height as f64 / width as f64;
            (forward + (right * (2.0 * x - 1.0) + up * rise) * half).normalized()
        };
        let pixel = |i: usize| {
            let (x, y) = ((i % width) as f64, (i / width) as f64);
            let mut statistics = PerBand::<SampleStatistics>::default();
            for k in 0..samples.max(2) {
                let rng = Rng::new(hash(hash(seed, i as u64), k as u64));
                let mut numbers = PathNumbers { low_discrepancy: Vec::new(), rng };
                let [dx, dy]: [f64; 2] = numbers.next_array();
                let d = direction((x + dx) / width as f64, (y + dy) / height as f64);
                let radiance = self.paths.radiance(camera.origin, d, &mut numbers).total;
                add_sample(&mut statistics, radiance);
            }
            statistics.map(|t| t.estimate(1.0))
        };
        let pixels: Vec<_> = parallel::collect(width * height, pixel);
        TracedImage {
            width,
            height,
            mean: pixels.iter().map(|p| p.map(|e| e.value)).collect(),
            error: pixels.iter().map(|p| p.map(|e| e.error)).collect(),
        }
    }
}
