//! Statistics of the rays of one zone that leave the scene.
//!
//! The standard error follows from the spread of batches of successive rays. If none of n rays escapes, the error is 1/(n + 2) (rule of
//! succession).

use super::zone_rays::{
    LostRay, WeightedRay, ZoneRaySample, escape_transmittance, ray_from_sample, sample_point,
};
use crate::distribution::Message;
use std::ops::Range;
use zonal_exchange::pair::SUCCESSION_PSEUDO_COUNTS;
use zonal_math::Vec3;
use zonal_scene::{Band, Bands, Light, ZoneRef, Zones};
use zonal_transport::Transport;

/// Number of batches whose spread gives the variance.
pub(super) const BATCHES: usize = 8;

/// The scene in which rays of zones are traced.
#[derive(Clone, Copy, Debug)]
pub(super) struct TracedScene<'a> {
    pub zones: &'a Zones,
    pub transport: &'a Transport<'a>,
    /// Seed of the sample.
    pub seed: u64,
    /// The sky whose radiance, W/(m² sr), is part of the weights of rays; `None` for surroundings of radiance 1.
    pub sky: Option<&'a Light>,
}

impl TracedScene<'_> {
    /// Edges of a cell of the voxel grid, m.
    pub(super) fn cell(&self) -> Vec3 {
        self.transport.scene().voxel_grid().map_or(Vec3::ZERO, |v| v.cell())
    }

    /// The weighted part of a ray that leaves the scene or ends on a black back, which is nothing for the light of a sky.
    pub(super) fn trace(&self, ray: WeightedRay) -> LostRay {
        let nothing = LostRay { share: Bands::ZERO, on_back: false };
        if ray.weight == Bands::ZERO {
            return nothing;
        }
        let lost = escape_transmittance(self.transport, ray.origin, ray.dir);
        if lost.on_back && self.sky.is_some() {
            return nothing;
        }
        LostRay { share: lost.share * ray.weight, ..lost }
    }

    /// The ray of zone `i` for a sample of origin and direction.
    pub(super) fn ray(&self, i: usize, sample: ZoneRaySample) -> WeightedRay {
        let ray = ray_from_sample(self.zones, self.transport, i, sample);
        WeightedRay { weight: ray.weight * self.radiance(ray.dir), ..ray }
    }

    /// Radiance from the direction `dir`.
    pub(super) fn radiance(&self, dir: Vec3) -> Bands {
        let sky = self.sky.and_then(Light::sky);
        sky.map_or(Bands::ONE, |(radiance, distribution)| radiance * distribution.relative(dir))
    }

    /// Centre and half the diagonal of zone `i`.
    pub(super) fn bounding_sphere(&self, i: usize) -> (Vec3, f64) {
        let plate = |p: &zonal_scene::Plate| (p.centre(), 0.5 * p.diameter());
        match self.zones.zone(i) {
            ZoneRef::Patch(p) => plate(&p.plate),
            ZoneRef::Voxel(_, v) => (v.centre, 0.5 * self.cell().length()),
            ZoneRef::Pane(_, p) => plate(&p.plate),
        }
    }
}

/// Sums over the rays of one zone.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RayTally {
    /// Σ of the weighted transmittances to the sky, and to black backs.
    pub sums: [Bands; 2],
    /// Variance of the first sum.
    pub variance: Bands,
    /// Number of rays that escaped.
    pub escaped: u32,
    /// Number of rays that enter the estimate.
    pub traced: u32,
    /// Number of pilot rays, which do not enter it.
    pub pilot: u32,
}

impl Message for RayTally {
    fn size() -> usize {
        <([Bands; 3], [u32; 3])>::size()
    }
    fn put(&self, out: &mut Vec<u8>) {
        ([self.sums[0], self.sums[1], self.variance], [self.escaped, self.traced, self.pilot]).put(out);
    }
    fn get(bytes: &[u8]) -> RayTally {
        let ([to_sky, to_backs, variance], [escaped, traced, pilot]) = Message::get(bytes);
        RayTally { sums: [to_sky, to_backs], variance, escaped, traced, pilot }
    }
}

impl RayTally {
    /// Tallies the rays of `range`, in batches of successive rays; `outcome` gives the weighted part of a ray that is lost.
    pub(super) fn of(range: Range<usize>, outcome: impl Fn(usize) -> LostRay) -> RayTally {
        let mut tally = RayTally { traced: range.len() as u32, ..RayTally::default() };
        // Sum over the sky and number of rays of each batch.
        let mut batches = Vec::with_capacity(BATCHES);
        for batch in 0..BATCHES {
            let at = |b: usize| range.start + b * range.len() / BATCHES;
            let before = tally.sums[0];
            for k in at(batch)..at(batch + 1) {
                let LostRay { share, on_back } = outcome(k);
                tally.escaped += u32::from(share != Bands::ZERO);
                tally.sums[usize::from(on_back)] += share;
            }
            if at(batch) < at(batch + 1) {
                let sum = tally.sums[0] - before;
                batches.push((sum, (at(batch + 1) - at(batch)) as f64));
            }
        }
        if batches.len() > 1 {
            let (mean, n) = (tally.sums[0] / range.len() as f64, batches.len() as f64);
            let squares =
                |b: Band| batches.iter().map(|(sum, rays)| (sum[b] - rays * mean[b]).powi(2)).sum::<f64>();
            tally.variance = Bands::from_fn(|b| squares(b) * n / (n - 1.0));
        }
        tally
    }

    /// Tallies the rays of `range` of zone `i`, distributed by the kernel.
    pub(super) fn of_zone(traced: &TracedScene, i: usize, range: Range<usize>) -> RayTally {
        RayTally::of(range, |k| traced.trace(traced.ray(i, sample_point(traced.zones, i, traced.seed, k))))
    }

    /// Adds another tally.
    pub(super) fn add(&mut self, o: &RayTally) {
        self.sums = [0, 1].map(|k| self.sums[k] + o.sums[k]);
        self.variance += o.variance;
        (self.escaped, self.traced) = (self.escaped + o.escaped, self.traced + o.traced);
    }

    /// Mean transmittance to the sky.
    pub(super) fn mean_sky(&self) -> Bands {
        self.sums[0] / self.traced.max(1) as f64
    }

    /// Standard error of [`RayTally::mean_sky`].
    pub(super) fn standard_error(&self) -> Bands {
        match self.escaped {
            0 => Bands::splat(1.0 / (self.traced as f64 + SUCCESSION_PSEUDO_COUNTS)),
            _ => self.variance.sqrt() / self.traced.max(1) as f64,
        }
    }

    /// Combines strata whose means add up into one tally of all rays.
    pub(super) fn combine_strata(strata: &[RayTally]) -> RayTally {
        let traced: u32 = strata.iter().map(|s| s.traced).sum();
        let mut all =
            RayTally { traced, escaped: strata.iter().map(|s| s.escaped).sum(), ..RayTally::default() };
        for s in strata.iter().filter(|s| s.traced > 0) {
            let weight = traced as f64 / s.traced as f64;
            all.sums = [0, 1].map(|k| all.sums[k] + weight * s.sums[k]);
            all.variance += weight * weight * s.variance;
        }
        all
    }
}
