//! Light samples of a camera ray: low-discrepancy sequences, shifted by a hash of the pixel (Cranley–Patterson rotation).

use crate::options::MAX_SUN_STEPS;
use zonal_math::low_discrepancy;

/// The light samples of one ray: `first..first + count` of a shifted sequence.
#[derive(Clone, Copy)]
pub(crate) struct RaySampler {
    pub first: usize,
    pub count: usize,
    pub shift: [f64; 3],
    /// Maximum number of steps along the ray for suns with an extent.
    pub max_sun_steps: usize,
    /// Number of times that the steps for suns, and the points of emitters of few facets, are sampled along the ray.
    pub medium_repeats: usize,
}

impl RaySampler {
    /// Samples of ray number `i` of a pixel, `count` of each light.
    pub(crate) fn of_ray(i: usize, count: usize, shift: [f64; 3]) -> RaySampler {
        let max_sun_steps = MAX_SUN_STEPS;
        RaySampler { first: i * count, count, shift, max_sun_steps, medium_repeats: 1 }
    }

    /// The same ray with `n` samples of each light.
    pub(crate) fn with_count(&self, n: usize) -> RaySampler {
        RaySampler { first: self.first / self.count * n, count: n, ..*self }
    }

    /// Index of the ray in its pixel.
    pub(crate) fn ray_index(&self) -> usize {
        self.first / self.count
    }

    /// Light sample number `i` of the ray, in [0,1)³.
    pub(crate) fn sample(&self, i: usize) -> [f64; 3] {
        low_discrepancy::r3(self.first + i, self.shift)
    }

    /// One more number in [0,1), distinct for each ray of the pixel: for Russian roulette.
    pub(crate) fn roulette(&self) -> f64 {
        low_discrepancy::r1(self.first / self.count, (self.shift[0] * 4096.0 + self.shift[1]).fract())
    }
}

/// Shifts of the light samples of a pixel: a hash, since a lattice over the pixels would show as a pattern in soft light.
pub(crate) fn pixel_shift(x: usize, y: usize) -> [f64; 3] {
    let seed = (x as u64) << 32 | y as u64;
    [0, 1, 2].map(|k| low_discrepancy::hash_to_unit(seed.wrapping_mul(3).wrapping_add(k)))
}
