//! Samples of one light at the points of one zone, and their statistics.

use super::params::{
    FIRST_FRESH_SAMPLE, FOUR_DIMENSIONAL_RATE, FOUR_DIMENSIONAL_SAMPLES, MIN_VISIBLE_FRACTION,
    SAMPLE_QUANTUM, SMALL_OPENING_RATE, SMALL_VISIBLE_FRACTION, ZONES_PER_TASK,
};
use super::point_light::{LitZones, PointLightOnZone};
use crate::distribution::{Execution, Message};
use crate::right_hand_side::surroundings::sky_openings::SkyLight;
use crate::right_hand_side::surroundings::zone_rays::voxel_point;
use zonal_math::parallel;
use zonal_math::{Vec3, scrambled_sobol};
use zonal_scene::{Bands, IntensityDistribution, Light, VoxelGrid, ZoneRef, Zones};
use zonal_transport::Transport;
use zonal_transport::lights::{LightSampler, Receiver};

/// Sums over the samples of one zone.
#[derive(Clone, Copy, Default)]
struct SampleTally {
    count: usize,
    /// Σ of U.
    unoccluded: Bands,
    /// Σ of the square of its largest band.
    unoccluded2: f64,
    /// Σ of w, and of w τ.
    sent: Bands,
    arrived: Bands,
    /// Σ of the largest band of w, of its square, and of w over the visible samples.
    weight: f64,
    square: f64,
    visible: f64,
    /// Σ over the visible samples of w τ and w τ², τ the largest band.
    through: f64,
    through2: f64,
}

/// The largest band.
pub(super) fn largest(v: Bands) -> f64 {
    v.max_element()
}

impl SampleTally {
    /// Adds a sample of contribution `flux` without occlusion; `tau` is its transmittance, `None` where it is not visible.
    fn add(&mut self, flux: Bands, tau: Option<Bands>) {
        let w = largest(flux);
        self.weight += w;
        self.square += w * w;
        self.sent += flux;
        if let Some(tau) = tau {
            self.visible += w;
            self.arrived += tau * flux;
            let tau = largest(tau);
            (self.through, self.through2) = (self.through + w * tau, self.through2 + w * tau * tau);
        }
    }

    /// Visible fraction of the light; ½ if no sample could contribute.
    fn visible_fraction(&self) -> f64 {
        if self.weight > 0.0 { self.visible / self.weight } else { 0.5 }
    }
    /// R: arrived over sent.
    fn ratio(&self) -> Bands {
        self.arrived.zip_map(self.sent, |arrived, sent| if sent > 0.0 { arrived / sent } else { 0.0 })
    }
}

/// Sampler of one light on the zones of a scene.
pub(super) struct ZoneLightSampler<'a> {
    pub(super) zones: &'a Zones,
    pub(super) transport: &'a Transport<'a>,
    pub(super) light: LightSampler<'a>,
    /// True if U has a closed form.
    has_closed_form: bool,
    grid: Option<&'a VoxelGrid>,
}

/// Estimate of one zone.
#[derive(Clone, Copy, Default)]
pub(super) struct DirectLightEstimate {
    /// ⟨U⟩.
    pub unoccluded: Bands,
    /// R.
    pub ratio: Bands,
    /// Visible fraction, ½ if unknown.
    pub visible: f32,
    /// Error relative to U, without the part that agreeing samples may have missed: [`DirectLightEstimate::relative_error`] has it.
    pub error: f32,
    pub count: u16,
    /// Number of agreeing samples in the neighbourhood.
    pub support: u32,
}

impl Message for DirectLightEstimate {
    fn size() -> usize {
        <([Bands; 2], ([f32; 2], (u16, u32)))>::size()
    }
    fn put(&self, out: &mut Vec<u8>) {
        let numbers = (self.count, self.support);
        ([self.unoccluded, self.ratio], ([self.visible, self.error], numbers)).put(out);
    }
    fn get(bytes: &[u8]) -> DirectLightEstimate {
        let ([unoccluded, ratio], ([visible, error], (count, support))) = Message::get(bytes);
        DirectLightEstimate { unoccluded, ratio, visible, error, count, support }
    }
}

impl DirectLightEstimate {
    /// H or G, W/m².
    pub(super) fn value(&self) -> Bands {
        self.unoccluded * self.ratio
    }
    /// Bit 0: some sample was not visible; bit 1: some was.
    pub(super) fn visibility_bits(&self) -> u8 {
        u8::from(self.visible < 1.0) | u8::from(self.visible > 0.0) << 1
    }
    /// The estimate of a sky through openings.
    pub(super) fn of_sky(light: &SkyLight) -> DirectLightEstimate {
        let unoccluded = light.unoccluded;
        let ratio = light.field.zip_map(unoccluded, |f, u| if u > 0.0 { f / u } else { 0.0 });
        let error = (light.error / largest(unoccluded).max(f64::MIN_POSITIVE)) as f32;
        let count = light.rays.min(u16::MAX as usize) as u16;
        DirectLightEstimate { unoccluded, ratio, visible: 0.5, error, count, support: 0 }
    }
    /// True if all samples were visible, or none.
    pub(super) fn agrees(&self) -> bool {
        self.visible == 0.0 || self.visible == 1.0
    }
    /// Error relative to U that `samples` agreeing samples leave; 0 where samples disagree.
    fn agreement_error(&self, samples: f64) -> f64 {
        if self.agrees() { 0.5 / (samples + 1.0) } else { 0.0 }
    }
    /// Error relative to U.
    pub(super) fn relative_error(&self) -> f64 {
        (self.error as f64).hypot(self.agreement_error(self.count as f64 + self.support as f64))
    }
    /// Error, W/m².
    pub(super) fn absolute_error(&self) -> f64 {
        largest(self.unoccluded) * self.relative_error()
    }
}

impl<'a> ZoneLightSampler<'a> {
    pub(super) fn new(
        zones: &'a Zones,
        transport: &'a Transport<'a>,
        light: &'a Light,
    ) -> ZoneLightSampler<'a> {
        let scene = transport.scene();
        let sampler = LightSampler::new(scene, light);
        ZoneLightSampler {
            zones,
            transport,
            // The weights of a point light are those of full intensity.
            has_closed_form: sampler.has_closed_form() || light.point().is_some(),
            grid: scene.voxel_grid(),
            light: sampler,
        }
    }

    /// True if the light is a surface of the scene.
    fn is_surface(&self) -> bool {
        self.light.light().surface().is_some()
    }

    /// Adds the samples of `range` of zone `i`.
    fn trace_shadow_rays(&self, t: &mut SampleTally, i: usize, range: std::ops::Range<usize>) {
        let Some(patch) = self.zones.patches.get(i) else {
            let zone = i - self.zones.patches.len();
            for k in range {
                let [p, q, u, v, w, r, ..] = scrambled_sobol::point_of_blocks(k, i as u64);
                let x = voxel_point(self.transport, self.zones, zone, [u, v, w]);
                self.trace_shadow_ray(t, x, Receiver::Free, [p, q, r]);
            }
            return;
        };
        for k in range {
            // Only emitters take a third number.
            let ([p, q, u, v], r) = if self.is_surface() {
                let [p, q, u, v, _, r, ..] = scrambled_sobol::point_of_blocks(k, i as u64);
                ([p, q, u, v], r)
            } else {
                (scrambled_sobol::first_dimensions_of_blocks(k, i as u64), 0.0)
            };
            let [u, v] = patch.plate.warp([u, v]);
            self.trace_shadow_ray(t, patch.plate.at(u, v), Receiver::Surface(patch.normal), [p, q, r]);
        }
    }

    fn trace_shadow_ray(&self, t: &mut SampleTally, x: Vec3, receiver: Receiver, s: [f64; 3]) {
        t.count += 1;
        let (unoccluded, sample) = self.light.sample_with_unoccluded(self.transport, x, receiver, s);
        t.unoccluded += unoccluded;
        t.unoccluded2 += largest(unoccluded).powi(2);
        let Some(sample) = sample else {
            return;
        };
        let tau = if self.is_surface() {
            self.transport.transmittance_inside(x, sample.end)
        } else {
            self.transport.transmittance(x, sample.end)
        };
        t.add(sample.flux, tau);
    }

    /// The estimate of zone `i` from the samples of a range of a point light of unit intensity `intensity`.
    fn sample_point_light(
        &self,
        position: Vec3,
        intensity: Bands,
        distribution: &IntensityDistribution,
        i: usize,
        range: std::ops::Range<usize>,
    ) -> DirectLightEstimate {
        let mut t = SampleTally { count: range.len(), ..SampleTally::default() };
        let scene = LitZones { zones: self.zones, transport: self.transport, grid: self.grid };
        let on_zone = PointLightOnZone::new(scene, position, distribution, i);
        for k in range {
            let [u, v, w, _] = scrambled_sobol::first_dimensions_of_blocks(k, i as u64);
            let Some(one) = on_zone.as_ref().and_then(|z| z.sample([u, v, w])) else { continue };
            let flux = intensity * one.weight;
            t.unoccluded += flux;
            t.unoccluded2 += largest(flux).powi(2);
            let tau = if one.share > 0.0 {
                self.transport.transmittance(one.at, position).map(|tau| tau * one.share)
            } else {
                None
            };
            t.add(flux, tau);
        }
        self.estimate(&t, 1.0)
    }

    /// The estimate of a tally, with its error, if `share` of its samples are stratified together.
    fn estimate(&self, t: &SampleTally, share: f64) -> DirectLightEstimate {
        let m = t.count as f64;
        let unoccluded = if self.has_closed_form { t.unoccluded } else { t.sent } / m;
        let s = t.visible_fraction();
        let equal = if t.weight > 0.0 { t.weight * t.weight / (m * t.square) } else { 1.0 };
        // Without a closed form the flux is itself a mean over samples; with one a few strong samples determine the visible fraction.
        let (flux, effective) = if self.has_closed_form {
            let square = largest(t.unoccluded).powi(2);
            (if square > 0.0 { m * t.unoccluded2 / square - 1.0 } else { 0.0 }, m * equal)
        } else {
            (1.0 / equal - 1.0, m * share)
        };
        // Variance of the transmittance over the visible samples.
        let dim =
            if t.visible > 0.0 { t.through2 / t.visible - (t.through / t.visible).powi(2) } else { 0.0 };
        let slow = (effective / FOUR_DIMENSIONAL_SAMPLES).max(1.0).powf(0.75 - FOUR_DIMENSIONAL_RATE);
        // Small openings of a sky are narrower than the strata of the samples.
        let of_strata = match self.light.light() {
            light if light.is_varying_sky() => s,
            light if light.fills_sphere() => (s / SMALL_VISIBLE_FRACTION).min(1.0),
            _ => 1.0,
        };
        let small = of_strata.max(MIN_VISIBLE_FRACTION).powf(-SMALL_OPENING_RATE);
        let error = (s * (1.0 - s + dim.max(0.0)) + s * s * flux.max(0.0)).sqrt()
            * effective.powf(-0.75)
            * slow
            * small;
        DirectLightEstimate {
            unoccluded,
            ratio: t.ratio(),
            visible: s as f32,
            error: error as f32,
            count: t.count.min(u16::MAX as usize) as u16,
            support: 0,
        }
    }

    /// Estimates zone `i` from the samples of a range.
    pub(super) fn sample_zone(&self, i: usize, samples: std::ops::Range<usize>) -> DirectLightEstimate {
        if let Some((position, intensity, distribution)) = self.light.light().point() {
            return self.sample_point_light(position, intensity, distribution, i, samples);
        }
        let mut t = SampleTally::default();
        self.trace_shadow_rays(&mut t, i, samples);
        if t.weight == 0.0 {
            return self.estimate_unlit(i, t.count);
        }
        // On a patch the samples of a varying sky are two sequences.
        let share =
            if self.light.light().is_varying_sky() && i < self.zones.patches.len() { 0.5 } else { 1.0 };
        self.estimate(&t, share)
    }

    /// Estimates zone `i` if none of `count` points sees light, even without occlusion: no light, with an upper bound of the light as the one that the samples may
    /// have missed. The bound is zero where the light is proved to be behind the zone.
    fn estimate_unlit(&self, i: usize, count: usize) -> DirectLightEstimate {
        let unoccluded = match (self.zones.zone(i), self.grid) {
            (ZoneRef::Patch(p), _) => {
                let (corners, n) = p.plate.corners();
                self.light.upper_bound(&corners[..n], Receiver::Surface(p.normal))
            }
            (ZoneRef::Voxel(_, v), Some(grid)) => {
                let [x, y, z] = grid.coordinates(v.cell);
                let corner = |k: usize| grid.corner([x + (k & 1), y + (k >> 1 & 1), z + (k >> 2)]);
                self.light.upper_bound(&std::array::from_fn::<Vec3, 8, _>(corner), Receiver::Free)
            }
            _ => Bands::ZERO,
        };
        let visible = if unoccluded == Bands::ZERO { 0.5 } else { 0.0 };
        let count = count.min(u16::MAX as usize) as u16;
        DirectLightEstimate { unoccluded, visible, count, ..DirectLightEstimate::default() }
    }

    /// Estimates zone `i` from as many fresh samples as, by the `pilot` estimate, bring its error to `wanted` (W/m²), at most `most`; where the samples of its
    /// neighbours support them, `saving` times fewer make sure of what all samples agree on.
    ///
    /// The samples are fresh because a number of samples must not depend on the samples that are averaged; zones with little visible light would
    /// otherwise be biased to the dark side.
    pub(super) fn resample(
        &self,
        i: usize,
        pilot: &DirectLightEstimate,
        most: usize,
        saving: f64,
        wanted: f64,
    ) -> DirectLightEstimate {
        let count = samples_needed(pilot, most as f64, saving, wanted).ceil() as usize;
        let samples = count.next_multiple_of(SAMPLE_QUANTUM).clamp(SAMPLE_QUANTUM, most);
        // Behind the samples of the estimate, which may itself be of fresh samples.
        let used = pilot.count as usize;
        let behind =
            if used >= SAMPLE_QUANTUM { 2 * used.next_power_of_two().max(FIRST_FRESH_SAMPLE) } else { 0 };
        let first = samples.next_power_of_two().max(FIRST_FRESH_SAMPLE).max(behind);
        self.sample_zone(i, first..first + samples)
    }

    /// `f` of the first `n` zones, by all threads of all ranks.
    pub(super) fn for_zones(
        n: usize,
        execution: Execution,
        f: impl Fn(usize) -> DirectLightEstimate + Sync,
    ) -> Vec<DirectLightEstimate> {
        let blocks = execution.blocks(n, ZONES_PER_TASK);
        let of_block = |b: usize| {
            let list: Vec<DirectLightEstimate> = blocks.range(b).map(&f).collect();
            execution.progress.advance(list.len() as u64);
            list
        };
        let own_blocks: Vec<usize> = blocks.own().collect();
        let own = parallel::collect_tasks(own_blocks.len(), |k| of_block(own_blocks[k]));
        blocks.gather(execution.communicator, own.concat())
    }

    /// The cell of a voxel zone, or the cell in front of a patch.
    pub(super) fn cell_of(&self, grid: &VoxelGrid, i: usize) -> Option<usize> {
        let p = match self.zones.zone(i) {
            ZoneRef::Patch(p) => p,
            ZoneRef::Voxel(_, v) => return Some(v.cell),
            ZoneRef::Pane(..) => return None,
        };
        let before = p.plate.centre() + p.normal * (0.25 * grid.cell().max_abs());
        grid.cell_at(before).map(|c| grid.index(c))
    }
}

/// Number of samples, at most `most`, that, by the estimate `pilot`, brings the error of its zone to `wanted`, W/m².
fn samples_needed(pilot: &DirectLightEstimate, most: f64, saving: f64, wanted: f64) -> f64 {
    let m = pilot.count as f64;
    let needed = |error: f64| m * largest(pilot.unoccluded) * error / wanted;
    if pilot.agrees() {
        // The error of agreeing samples falls like 1/m, and with the support of neighbours.
        let of_agreement = (needed(pilot.agreement_error(pilot.count as f64)) / saving).min(most / saving);
        return needed(pilot.error as f64).hypot(of_agreement).min(most);
    }
    // That of others falls like m^(−3/4).
    let count = m * (needed(pilot.error as f64) / m).powf(4.0 / 3.0);
    let count = if count <= FOUR_DIMENSIONAL_SAMPLES {
        count
    } else {
        FOUR_DIMENSIONAL_SAMPLES * (count / FOUR_DIMENSIONAL_SAMPLES).powf(0.75 / FOUR_DIMENSIONAL_RATE)
    };
    count.min(most)
}
