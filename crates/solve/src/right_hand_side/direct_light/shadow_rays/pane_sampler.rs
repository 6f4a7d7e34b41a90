//! Direct light inside panes.
//!
//! The fluence of a pane follows from the power that it takes from the light, κ G t = Σ g c (1 − e^{−κt/c}) with g the fluence that a sample of the light
//! brings in free space and c its cosine with the normal. Its error follows from the spread of parts of the points; that of a point light also from the part of its beam that all points may miss, 1/(2(n + 1)) of the bound of its
//! light for n points; that of other lights likewise where no sample arrives.

use super::params::{
    ERROR_SHARE, FINE_TOLERANCE, MAX_PANE_GROWTH, MAX_SAMPLES_PER_ZONE, MIN_RELATIVE_LEVEL, PANE_PARTS,
    PANE_POINTS, SAMPLES_PER_PANE_POINT,
};
use super::point_light::irradiance_bound;
use super::zone_sampler::{ZoneLightSampler, largest};
use crate::distribution::Execution;
use zonal_math::{Vec3, low_discrepancy};
use zonal_scene::{Bands, PaneZone};
use zonal_transport::lights::Receiver;

/// Smallest cosine of light with the normal of a pane.
const MIN_COSINE: f64 = 1e-6;

impl ZoneLightSampler<'_> {
    /// G_dir of pane zone `k` and its standard error, from `count` points.
    pub(super) fn pane(&self, k: usize, count: usize) -> [Bands; 2] {
        let (p, i) = (&self.zones.panes[k], self.zones.pane_index(k));
        let shift = [0, 1].map(|m| low_discrepancy::hash_to_unit((i as u64) << 3 | m));
        let mut parts = [Bands::ZERO; PANE_PARTS];
        for n in 0..count {
            let [u, v] = p.plate.warp(low_discrepancy::r2(n, shift));
            let seed = if n < PANE_POINTS {
                (i * PANE_POINTS + n) as u64
            } else {
                low_discrepancy::split_mix64((i as u64) << 20 | n as u64)
            };
            let g = self.pane_fluence(p, p.plate.at(u, v), seed);
            parts[n % PANE_PARTS] += g / (count / PANE_PARTS) as f64;
        }
        const N: f64 = PANE_PARTS as f64;
        let mean = Bands::from_fn(|b| parts.iter().map(|p| p[b]).sum::<f64>() / N);
        let square = Bands::from_fn(|b| parts.iter().map(|p| (p[b] - mean[b]).powi(2)).sum::<f64>());
        let spread = square / (N * (N - 1.0));
        let missed = self.missed_light(p, count, mean);
        [mean, (spread + missed * missed).sqrt()]
    }

    /// Error by the part of the light that all of `count` points may miss, W/m²: of the beam of a point light, and of any other light of which the samples find nothing,
    /// so that their `mean` is zero.
    fn missed_light(&self, p: &PaneZone, count: usize, mean: Bands) -> Bands {
        let Some((position, intensity, distribution)) = self.light.light().point() else {
            if largest(mean) > 0.0 {
                return Bands::ZERO;
            }
            let (corners, n) = p.plate.corners();
            let samples = (count * SAMPLES_PER_PANE_POINT) as f64;
            return self.light.upper_bound(&corners[..n], Receiver::Free) * (0.5 / (samples + 1.0));
        };
        let share = 0.5 / (count as f64 + 1.0);
        intensity * (share * irradiance_bound(&p.plate, position, distribution))
    }

    /// G_dir of all pane zones with their errors, and the number of rays: pilot points everywhere, more where the error exceeds a share of the
    /// tolerance. The spread of few parts is itself uncertain, so the stated error is the mean square of a zone's own error and of the relative
    /// error of all panes.
    pub(super) fn panes(&self, tolerance: f64, execution: Execution) -> (Vec<[Bands; 2]>, u64) {
        let n = self.zones.panes.len();
        let (blocks, communicator) = (execution.blocks(n, 1), execution.communicator);
        let pilot: Vec<[Bands; 2]> = blocks.map(communicator, |k| self.pane(k, PANE_POINTS));
        let square =
            |of: usize, found: &[[Bands; 2]]| found.iter().map(|f| largest(f[of]).powi(2)).sum::<f64>();
        let level = (square(0, &pilot) / n.max(1) as f64).sqrt();
        let refined = |k: usize| {
            let f = pilot[k];
            let clamped = largest(f[0]).clamp(MIN_RELATIVE_LEVEL[1] * level, level);
            let wanted = ERROR_SHARE[1] * tolerance * clamped;
            let off = largest(f[1]) / wanted;
            if level <= 0.0 || off <= 1.0 {
                return (f, 0);
            }
            let finer = (FINE_TOLERANCE / tolerance).max(1.0);
            let most =
                (MAX_PANE_GROWTH as f64 * finer * finer).min((MAX_SAMPLES_PER_ZONE / PANE_POINTS) as f64);
            let count = PANE_POINTS * (off * off).min(most).ceil() as usize;
            (self.pane(k, count), count as u64)
        };
        let (mut found, more): (Vec<[Bands; 2]>, Vec<u64>) =
            blocks.map(communicator, refined).into_iter().unzip();
        let light = square(0, &found);
        let pooled = if light > 0.0 { square(1, &found) / light } else { 0.0 };
        // A pane without light has its own error alone.
        for [g, e] in found.iter_mut().filter(|f| largest(f[0]) > 0.0) {
            *e = (0.5 * (*e * *e + pooled * *g * *g)).sqrt();
        }
        let points = more.iter().sum::<u64>() + (n * PANE_POINTS) as u64;
        (found, points * SAMPLES_PER_PANE_POINT as u64)
    }

    /// Fluence inside a pane at a point, by the absorbed power.
    fn pane_fluence(&self, p: &PaneZone, at: Vec3, seed: u64) -> Bands {
        let (n, sample) = self.light.stratified(SAMPLES_PER_PANE_POINT, seed);
        self.light.gather_weighted(self.transport, at, Receiver::Free, n, sample, |flux, towards| {
            let cos = p.normal.dot(towards).abs().max(MIN_COSINE);
            Bands::from_fn(|b| {
                let depth = p.extinction[b] * p.thickness;
                // c (1 − e^{−κt/c}) / κt, which tends to 1 for thin glass.
                let share = if depth > 1e-12 { -(-depth / cos).exp_m1() * cos / depth } else { 1.0 };
                flux[b] * share
            })
        })
    }
}
