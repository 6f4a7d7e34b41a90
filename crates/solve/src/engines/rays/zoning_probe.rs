//! The zoning error of a solution by exchange among zones, from samples that follow how light varies within zones.
//!
//! Zones of the dense engine send and receive as wholes. A sample of a gather (`zone_gather`) of their solution is read twice: v⁰ with the
//! means of the zones that it meets, whose mean is the incident radiation of the solution, and v¹ with paths that go on from near patches, and with
//! direct light and textures at points. Over zones i chosen at random, with the two halves A and B of the samples,
//!
//! ```text
//! D_i = ⟨v¹ − v⁰⟩          z² = (max(0, Σ D_A,i D_B,i) + √(Σ s_i⁴))/Σ H_i²          s_i² = (D_A,i − D_B,i)²/2
//! ```
//!
//! is the squared relative error from above, as in `point_zoning`. Reflections repeat the common part b = Σ w D/Σ w H (w the area, or 4κV) of it: with the mean
//! share ρ of the incident radiation that zones send on, the stated error is √(z² + (b ρ/(1 − ρ))²).
//!
//! Both readings have the same rays, so that D is 0 to the last bit where light does not vary, and its noise is that of near hits and of light at points.
//! Cost: some hundred zones, with at most [`MAX_SAMPLES`] samples of each half, and a few shadow rays of every zone. Every process takes all samples.

use super::gather::gather_error::{HalfProducts, ratio};
use super::gather::point_light::{LightPlace, PointLights};
use super::gather::zone_gather::{DirectReading, GatherField, GatherScratch, Gatherer, SampleRange};
use super::ray_operator::{mean_brightness, typical_radiosity};
use super::stored_rays::padded_bands::{padded, widened};
use super::stored_rays::path_continuation::{PathLights, VertexSource};
use super::stored_rays::ray_tracer::RayTracer;
use crate::context::SolveContext;
use crate::engines::merged_operator::PatchGroups;
use crate::errors::discretization;
use crate::right_hand_side::surroundings::SurroundingsExchange;
use crate::settings::SolvePurpose;
use crate::settings::zone_power::{fluence_factor, interception_area, reflected_fraction};
use std::ops::Range;
use zonal_math::{low_discrepancy, parallel};
use zonal_scene::{Bands, Engine, Fields, Zones};

/// Most zones of each kind.
const ZONES_OF_KIND: usize = 256;
/// Seed of their choice.
const CHOICE_SEED: u64 = 0x1f83_d9ab_fb41_bd6b;
/// First and most samples of each half.
const FIRST_SAMPLES: usize = 16;
const MAX_SAMPLES: usize = 128;
/// Noise of z over the tolerance that needs no further samples, and z² over its noise from which it is known.
const MAX_NOISE: f64 = 0.3;
const KNOWN_OVER_NOISE: f64 = 2.0;
/// Nodes of the cut by which connections are aimed.
const CUT_NODES: usize = 32;
/// Largest ρ of the repeated part.
const MAX_REFLECTED_SHARE: f64 = 0.98;

/// Relative zoning errors of the patches and of the volume zones of a solution; `None` where the engine is another, where a second solve gives the error, or
/// where samples do not follow the equations: temperatures, a fixed scattering order, periodic images, formulas of the paper.
pub(crate) fn measure(
    context: &SolveContext,
    surroundings: &SurroundingsExchange,
    engine: Engine,
    fields: &Fields,
) -> Option<[Bands; 2]> {
    if !applies(context, engine) {
        return None;
    }
    let (scene, zones) = (context.scene, context.zones);
    let tracer = RayTracer::new(scene, zones, context.transport);
    let radiosity = parallel::map(&fields.radiosity, |b| padded(*b));
    let source = vertex_source(context, surroundings);
    let (lights, groups) = (PathLights::new(scene, context.direct), PatchGroups::of(zones));
    let place = LightPlace { lights: &lights, transport: context.transport, zones };
    let brightest = |i: usize| radiosity[i].iter().copied().fold(0.0, f32::max);
    let points = zones
        .sheets
        .is_empty()
        .then(|| PointLights::new(place, vec![vec![1.0; scene.lights().len()]], groups.as_ref(), brightest));
    let points = points.filter(|points| points.has_light() || tracer.has_textures());
    let typical = vec![typical_radiosity(zones, &radiosity)];
    let columns = vec![radiosity];
    let brightness = mean_brightness(&columns, &typical);
    let field = |sources, points| GatherField {
        columns: columns.clone(),
        typical: typical.clone(),
        sources,
        sky: None,
        points,
    };
    let probe = ZoningProbe {
        zones,
        fields,
        of_zones: Gatherer::new(&tracer, None, field(Vec::new(), None), &brightness),
        within: Gatherer::new(&tracer, Some(lights), field(vec![&source], points), &brightness),
    };
    Some(probe.errors(scene.options().tolerance))
}

/// True for a solution whose equations the samples follow.
fn applies(context: &SolveContext, engine: Engine) -> bool {
    let (scene, zones, settings) = (context.scene, context.zones, &context.settings);
    engine == Engine::Dense
        && settings.final_gather
        && settings.purpose != SolvePurpose::Comparison
        && scene.thermal().is_none()
        && scene.options().scattering_orders.is_none()
        && !scene.is_periodic()
        && context.images.is_none()
        && settings.pair_settings.volume_factors.is_none()
        && !discretization::is_requested(scene)
        && !zones.is_empty()
        && context.direct.lights.iter().all(|l| l.fields.len() == zones.len())
}

/// The radiosities of patches without the lights that path vertices sample: emission, and reflected radiation of the surroundings.
fn vertex_source(context: &SolveContext, surroundings: &SurroundingsExchange) -> VertexSource {
    let (zones, sky) = (context.zones, context.scene.surroundings().radiosity());
    let one = |i: usize| {
        let of_sky = surroundings.incoming(i, sky)[0] / zones.response(i).1;
        padded(zones.emission(i) + zones.patches[i].reflectance * of_sky)
    };
    VertexSource {
        patches: parallel::collect(zones.patches.len(), one),
        lights: vec![1.0; context.scene.lights().len()],
    }
}

/// A solution and its two readings.
struct ZoningProbe<'a> {
    zones: &'a Zones,
    fields: &'a Fields,
    of_zones: Gatherer<'a>,
    within: Gatherer<'a>,
}

/// A chosen zone with the sums of the samples of v¹ − v⁰ of both halves.
#[derive(Clone, Copy)]
struct ProbedZone {
    zone: usize,
    sums: [Bands; 2],
}

/// Sums over the chosen zones of a kind.
#[derive(Clone, Copy, Default)]
struct KindSums {
    products: HalfProducts,
    level: Bands,
    /// Σ w D and Σ w H, times the number of zones for which a chosen one stands.
    common: Bands,
    power: Bands,
}

impl KindSums {
    /// True where z² is known well enough for a tolerance.
    fn is_known(&self, tolerance: f64) -> bool {
        let limit = (MAX_NOISE * tolerance).powi(2);
        let [square, noise] = self.products.square_and_noise(self.level);
        square.iter().zip(noise.iter()).all(|(s, n)| *n <= limit || *s >= KNOWN_OVER_NOISE * *n)
    }
}

/// At most [`ZONES_OF_KIND`] of a range of zones, one of each of as many equal parts.
fn chosen(range: &Range<usize>) -> Vec<ProbedZone> {
    let count = range.len().min(ZONES_OF_KIND);
    let place = |k: usize| {
        let u = low_discrepancy::hash_to_unit((range.start + k) as u64 ^ CHOICE_SEED);
        range.start + ((k as f64 + u) * range.len() as f64 / count as f64) as usize
    };
    (0..count).map(|k| ProbedZone { zone: place(k).min(range.end - 1), sums: [Bands::ZERO; 2] }).collect()
}

impl ZoningProbe<'_> {
    /// The errors of patches and of volume zones; those of panes are those of the volume zones.
    fn errors(&self, tolerance: f64) -> [Bands; 2] {
        let [patches, volumes, _] = self.zones.ranges_of_kinds();
        let kinds = [patches, volumes].map(|range| {
            let (mut zones, mut taken, mut wanted) = (chosen(&range), 0, FIRST_SAMPLES);
            loop {
                let more = parallel::map(&zones, |z| self.sampled(*z, taken..wanted));
                (zones, taken) = (more, wanted);
                let sums = self.sums(&zones, taken, &range);
                if taken == MAX_SAMPLES || sums.is_known(tolerance) {
                    return sums;
                }
                wanted *= 2;
            }
        });
        let sum = |of: fn(&KindSums) -> Bands| of(&kinds[0]) + of(&kinds[1]);
        let common = sum(|k| k.common).zip_map(sum(|k| k.power), ratio);
        let share = self.reflected_share().map(|r| r.min(MAX_REFLECTED_SHARE));
        let repeated = common * share / (Bands::ONE - share);
        kinds.map(|k| (k.products.square_from_above(k.level) + repeated * repeated).sqrt())
    }

    /// Adds samples of a zone.
    fn sampled(&self, mut of: ProbedZone, numbers: Range<usize>) -> ProbedZone {
        let mut scratch = GatherScratch::default();
        for (half, sum) in of.sums.iter_mut().enumerate() {
            for (gatherer, direct, sign) in
                [(&self.of_zones, DirectReading::OfZones, -1.0), (&self.within, DirectReading::AtPoints, 1.0)]
            {
                gatherer.aim(of.zone..of.zone + 1, CUT_NODES, &mut scratch);
                let range = SampleRange { zone: of.zone, half, numbers: numbers.clone(), direct };
                gatherer.samples(range, &mut scratch, |sample| {
                    *sum += sign * (widened(sample.value(0)) + widened(sample.change(0)));
                });
            }
        }
        of
    }

    fn sums(&self, zones: &[ProbedZone], samples: usize, range: &Range<usize>) -> KindSums {
        let stands_for = range.len() as f64 / zones.len().max(1) as f64;
        let mut out = KindSums::default();
        for ProbedZone { zone, sums } in zones {
            let i = *zone;
            let factor = fluence_factor(self.zones, i) / samples as f64;
            let ([a, b], h) = (sums.map(|s| factor * s), self.fields.incident[i]);
            let weight = stands_for * interception_area(self.zones, i);
            out.products.add(a, b);
            out.level += h * h;
            out.common += 0.5 * weight * (a + b);
            out.power += weight * h;
        }
        out
    }

    /// ρ: the share of the incident radiation of all zones that they send on.
    fn reflected_share(&self) -> Bands {
        let [sent, all] = (0..self.zones.len()).fold([Bands::ZERO; 2], |[sent, all], i| {
            let power = interception_area(self.zones, i) * self.fields.incident[i];
            [sent + reflected_fraction(self.zones, i) * power, all + power]
        });
        sent.zip_map(all, ratio)
    }
}
