//! Pictures of a pinhole camera, with their standard errors.
//!
//! With f the unit vector to the target, r = f × up and u = r × f (unit vectors), the point (x, y) of the picture, both from 0 to 1
//! with y down, is seen along f + (2x − 1) tan(φ/2) r + (1 − 2y) tan(φ/2) (h/w) u. A pixel is the mean over its square. Suns are not
//! seen as discs; surroundings and skies are.

use super::path::Draws;
use super::{Judge, hash};
use crate::{Dice, Tally};
use rayon::prelude::*;
use zonal_math::Vec3;
use zonal_scene::{Bands, Camera};

/// A picture: radiance, W/(m² sr) a band, row by row, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Mean of each pixel.
    pub mean: Vec<Bands>,
    /// Standard error of that mean.
    pub error: Vec<Bands>,
}

impl Judge<'_> {
    /// The picture of a camera by `samples` paths a pixel, at least two. The same bits for any number of threads.
    pub fn picture(
        &self,
        camera: &Camera,
        width: usize,
        height: usize,
        samples: usize,
        seed: u64,
    ) -> Picture {
        let forward = (camera.target - camera.origin).normalized();
        let right = forward.cross(camera.up).normalized();
        let up = right.cross(forward);
        let half = (0.5 * camera.fov.to_radians()).tan();
        let through = |x: f64, y: f64| -> Vec3 {
            let rise = (1.0 - 2.0 * y) * height as f64 / width as f64;
            (forward + (right * (2.0 * x - 1.0) + up * rise) * half).normalized()
        };
        let pixel = |i: usize| {
            let (x, y) = ((i % width) as f64, (i / width) as f64);
            let mut tally = [Tally::default(); 3];
            for k in 0..samples.max(2) {
                let mut draws =
                    Draws { spread: Vec::new(), dice: Dice::new(hash(hash(seed, i as u64), k as u64)) };
                let [dx, dy]: [f64; 2] = draws.some();
                let d = through((x + dx) / width as f64, (y + dy) / height as f64);
                let found = self.paths.radiance(camera.origin, d, &mut draws).total;
                (0..3).for_each(|b| tally[b].add(found[b]));
            }
            tally.map(|t| t.estimate(1.0))
        };
        let pixels: Vec<_> = (0..width * height).into_par_iter().map(pixel).collect();
        Picture {
            width,
            height,
            mean: pixels.iter().map(|p| p.map(|e| e.value)).collect(),
            error: pixels.iter().map(|p| p.map(|e| e.error)).collect(),
        }
    }
}
