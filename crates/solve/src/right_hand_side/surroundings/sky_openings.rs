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
//! Patches of one surface that face the same way, and all voxels, are groups: each has the openings that its own pilot rays found. The error is the root of the sum of squares of the spread of the batches of rays,
//! of cells that no ray of a zone reached, and of openings that the pilot rays of its group missed.

use super::box_cells::CELLS_ALONG_LONGEST_SIDE;
use super::open_cells::OpenCells;
use super::opening_sampling::{
    FIRST_ROUND_RAYS, MIN_RAYS_FOR_OPENINGS, OpeningSampler, RAYS_OVER_ERROR_EXPONENT,
};
use super::ray_tally::TracedScene;
use std::collections::HashMap;
use std::f64::consts::PI;
use zonal_math::parallel;
use zonal_scene::{Bands, Light, Patch, Zones};
use zonal_transport::Transport;

/// Largest radiance of a sky over its mean over all directions.
const MAX_PEAK_OVER_MEAN: f64 = 100.0;
/// Cells along the longest side of the bounding box: fine ones, else coarse ones for large openings.
const DIVISIONS: [f64; 2] = [CELLS_ALONG_LONGEST_SIDE, 0.5 * CELLS_ALONG_LONGEST_SIDE];
/// Rays that mark open cells over the other samples that they save.
const SEARCH_SHARE: f64 = 1.0 / 8.0;
/// Largest share of the rays of a group that may leave through cells that are not marked.
const MAX_MISSED_SHARE: f64 = 1e-4;
/// Maximum number of groups of zones that are marked apart.
const MAX_GROUPS: usize = 1024;
/// Bound of the light of a zone without occlusion over that of a sky of the mean radiance: it faces the brighter half.
const MAX_UNOCCLUDED_OVER_MEAN: f64 = 2.0;
/// Seed of the rays.
const OPENING_RAY_SEED: u64 = 0x5b7a_91d3_0c4e_e6f1;

/// Minimum of the largest number of rays of a zone with which openings are sampled.
pub(crate) const MIN_SKY_RAYS: usize = MIN_RAYS_FOR_OPENINGS;

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
    /// Finds the openings for the zones of `needs`, every `step`-th of the scene; `None` for a light that is no sky or has a peak, and where the search would cost more than it gains.
    pub(crate) fn find(
        zones: &'a Zones,
        transport: &'a Transport<'a>,
        light: &'a Light,
        needs: &[SampleNeed],
        step: usize,
    ) -> Option<SkyOpenings<'a>> {
        let (radiance, distribution) = light.sky()?;
        let (peak, mean) = (distribution.upper_bound(), distribution.mean());
        if peak.zip_map(mean, |p, m| p - MAX_PEAK_OVER_MEAN * m).max_element() > 0.0 {
            return None;
        }
        let traced = TracedScene { zones, transport, seed: OPENING_RAY_SEED, sky: Some(light) };
        let (groups, group_of) = groups(zones, needs);
        let mark = |group: &ZoneGroup| {
            // The rays must suffice to say that they missed little.
            let rays = (SEARCH_SHARE * group.samples(needs) / group.zones.len() as f64) as usize;
            let all = (rays * group.zones.len() * step) as f64;
            if all * MAX_MISSED_SHARE < 1.0 {
                return None;
            }
            let open = OpenCells::mark(traced, &DIVISIONS, &group.zones, rays)?;
            (open.missed <= MAX_MISSED_SHARE * step as f64).then_some(open)
        };
        let open: Vec<Option<OpenCells>> = parallel::map(&groups, mark);
        if open.iter().all(Option::is_none) {
            return None;
        }
        let sampler = OpeningSampler::of_groups(traced, open, group_of);
        Some(SkyOpenings { sampler, mean: radiance * mean })
    }

    /// True for a zone that sees few openings, not an open sky.
    pub(crate) fn serve(&self, i: usize) -> bool {
        self.sampler.open_cells(i).is_some()
    }

    /// A first estimate of the light on zone `i`, with few rays.
    pub(crate) fn first_light(&self, i: usize) -> Option<SkyLight> {
        self.light_on_zone(i, 0.0, FIRST_ROUND_RAYS)
    }

    /// Expected number of rays of zone `i` for the error `wanted`, W/m², from a first estimate.
    pub(crate) fn expected_rays(&self, i: usize, wanted: f64, max_rays: usize) -> Option<f64> {
        let first = self.first_light(i)?;
        let growth = (first.error / wanted).powf(RAYS_OVER_ERROR_EXPONENT);
        let again = (growth * FIRST_ROUND_RAYS as f64).min(max_rays as f64);
        Some(first.rays as f64 + if growth > 1.0 { again } else { 0.0 })
    }

    /// The light on zone `i`, with rays until its error is at most `wanted` (W/m²), and with about `max_rays` at most; `None` for a zone that [`SkyOpenings::serve`] excludes.
    pub(crate) fn light_on_zone(&self, i: usize, wanted: f64, max_rays: usize) -> Option<SkyLight> {
        let scale = if i < self.sampler.patches() { PI } else { 4.0 * PI };
        let found = self.sampler.measure(i, wanted / scale, max_rays)?;
        let tally = found.tally;
        let unmarked = MAX_UNOCCLUDED_OVER_MEAN * self.mean.max_element() * found.missed;
        let error = found.error.hypot(unmarked);
        Some(SkyLight {
            field: tally.mean_sky() * scale,
            unoccluded: self.mean * scale,
            error: error * scale,
            rays: (tally.traced + tally.pilot) as usize,
        })
    }
}

/// Samples of a zone that see the sky or not.
pub(crate) struct SampleNeed {
    pub zone: usize,
    /// Number of its pilot samples, and how many of them see the sky.
    pub pilot: f64,
    pub visible: f64,
    /// Its light without occlusion over the wanted error.
    pub unoccluded_over_error: f64,
    /// Maximum number of other samples.
    pub limit: f64,
}

impl SampleNeed {
    /// Number of other samples that a zone needs of which the fraction `s` sees the sky: their error is √(s(1−s)) s^(−1/6) (m/2)^(−3/4), as of shadow rays; 0 where these are few.
    fn samples(&self, s: f64) -> f64 {
        let spread = (s * (1.0 - s)).sqrt() * s.max(f64::MIN_POSITIVE).powf(-1.0 / 6.0);
        let count = 2.0 * (spread * self.unoccluded_over_error).powf(RAYS_OVER_ERROR_EXPONENT);
        if count > MIN_SKY_RAYS as f64 { count.min(self.limit) } else { 0.0 }
    }
}

/// Zones that see the same openings.
#[derive(Default)]
struct ZoneGroup {
    zones: Vec<usize>,
    /// Indices of the needs of its zones.
    needs: Vec<usize>,
}

impl ZoneGroup {
    /// Sum of the samples that its zones need. The few pilot samples of one zone miss a small opening; those of the group give the visible fraction by the rule of succession.
    fn samples(&self, needs: &[SampleNeed]) -> f64 {
        let sum = |of: fn(&SampleNeed) -> f64| self.needs.iter().map(|k| of(&needs[*k])).sum::<f64>();
        let visible = (sum(|n| n.visible) + 0.5) / (sum(|n| n.pilot) + 1.0);
        self.needs.iter().map(|k| needs[*k].samples(visible)).sum()
    }
}

/// The groups, and the number of the group of each zone: patches by surface and axis of the normal, or by axis alone where surfaces are many; all others together.
fn groups(zones: &Zones, needs: &[SampleNeed]) -> (Vec<ZoneGroup>, Vec<Option<u32>>) {
    let axis = |p: &Patch| {
        let n = p.normal.array();
        let k = (1..3).fold(0, |k, m| if n[m].abs() > n[k].abs() { m } else { k });
        2 * k + usize::from(n[k] > 0.0)
    };
    let grouped = |surface: &dyn Fn(&Patch) -> usize| {
        let (mut numbers, mut group_of) = (HashMap::new(), vec![None; zones.len()]);
        let mut groups: Vec<ZoneGroup> = Vec::new();
        for (k, i) in needs.iter().map(|n| n.zone).enumerate() {
            let key = zones.patches.get(i).map(|p| (surface(p), axis(p)));
            let number = *numbers.entry(key).or_insert(groups.len());
            if number == groups.len() {
                groups.push(ZoneGroup::default());
            }
            groups[number].zones.push(i);
            groups[number].needs.push(k);
            group_of[i] = Some(number as u32);
        }
        (groups, group_of)
    };
    let by_surface = grouped(&|p| p.surface);
    if by_surface.0.len() <= MAX_GROUPS { by_surface } else { grouped(&|_| 0) }
}
