//! Direct light of a sky through the openings of a scene, by importance sampling of the openings (`opening_sampling`).
//!
//! With g the mean over the rays of a zone of radiance times transmittance, distributed by the kernel, cosine-weighted on a patch and uniform over the sphere in a volume,
//!
//! ```text
//!     H = π ⟨L τ⟩ of a patch,      G = 4π ⟨L τ⟩ of a volume zone
//! ```
//!
//! Rays to the cells of an opening have a smooth integrand, so that the light through a window that fills 1 % of a hemisphere converges as that of an open sky does. The cells are
//! sampled uniformly, not by radiance: a sky whose radiance exceeds its mean by more than [`MAX_PEAK_OVER_MEAN`], such as a picture with its sun, is left to samples of its table.
//!
//! The error is the root of the sum of squares of the spread of the batches of rays, of cells that no ray reached, and of openings that all marking rays missed.

use super::box_cells::CELLS_ALONG_LONGEST_SIDE;
use super::opening_sampling::{FIRST_ROUND_RAYS, MIN_RAYS_FOR_OPENINGS, OpeningSampler};
use super::ray_tally::TracedScene;
use std::f64::consts::PI;
use zonal_scene::{Bands, Light, Scene, Zones};
use zonal_transport::Transport;

/// Largest radiance of a sky over its mean over all directions.
const MAX_PEAK_OVER_MEAN: f64 = 100.0;
/// Cells along the longest side of the bounding box: fine ones, else coarse ones for large openings.
const DIVISIONS: [f64; 2] = [CELLS_ALONG_LONGEST_SIDE, 0.5 * CELLS_ALONG_LONGEST_SIDE];
/// Seed of the rays.
const SEED: u64 = 0x5b7a_91d3_0c4e_e6f1;

/// Minimum of the largest number of rays of a zone with which openings are sampled.
pub(crate) const MIN_SKY_RAYS: usize = MIN_RAYS_FOR_OPENINGS;
/// Number of rays of the first estimate of a zone.
pub(crate) const FIRST_SKY_RAYS: usize = FIRST_ROUND_RAYS;

/// A sky seen through the openings of a scene.
pub(crate) struct SkyOpenings<'a> {
    sampler: OpeningSampler<'a>,
    /// Mean radiance, W/(m² sr).
    mean: Bands,
}

/// Light of a sky on one zone.
pub(crate) struct SkyLight {
    /// H or G, W/m².
    pub field: Bands,
    /// The same without occlusion from a sky of the mean radiance, W/m².
    pub unoccluded: Bands,
    /// Standard error, root of the sum of squares over the bands, W/m².
    pub error: f64,
    /// Number of rays.
    pub rays: usize,
}

impl<'a> SkyOpenings<'a> {
    /// Finds the openings for `light` by rays of every `step`-th zone; `None` for a light that is no sky or has a peak, and for a scene that is open.
    pub(crate) fn find(
        (scene, zones): (&'a Scene, &'a Zones),
        transport: &'a Transport<'a>,
        light: &'a Light,
        step: usize,
    ) -> Option<SkyOpenings<'a>> {
        let Light::Sky { radiance, distribution, .. } = light else { return None };
        let (peak, mean) = (distribution.upper_bound(), distribution.mean());
        if peak.zip_map(mean, |p, m| p - MAX_PEAK_OVER_MEAN * m).max_element() > 0.0 {
            return None;
        }
        let traced = TracedScene { scene, zones, transport, seed: SEED, sky: Some(light) };
        let sampler = OpeningSampler::find(traced, &DIVISIONS, step)?;
        Some(SkyOpenings { sampler, mean: *radiance * mean })
    }

    /// The light on zone `i`, with rays until its error is at most `wanted` (W/m²), and with about `max_rays` at most.
    pub(crate) fn light_on_zone(&self, i: usize, wanted: f64, max_rays: usize) -> SkyLight {
        let scale = if i < self.sampler.patches() { PI } else { 4.0 * PI };
        let found = self.sampler.measure(i, wanted / scale, max_rays);
        let tally = found.tally;
        let unmarked = self.mean.max_element() / (self.sampler.marking_rays as f64 + 1.0);
        let error = found.error.hypot(unmarked);
        SkyLight {
            field: tally.mean_sky() * scale,
            unoccluded: self.mean * scale,
            error: error * scale,
            rays: (tally.traced + tally.pilot) as usize,
        }
    }
}
