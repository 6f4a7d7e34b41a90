//! Power that a light sends into the scene, and power that leaves it or ends on black backs without being scattered, by rays from the light.
//!
//! A side that another surface covers, as the floor covers the bottom of a box that stands on it, has no zones and receives no light; it counts as a
//! black back.
//!
//! Quasi-Monte Carlo with [`LIGHT_RAYS`] rays of the four-dimensional R sequence (M. Roberts 2018) in blocks; the spread of the blocks gives the
//! standard errors. Blocks are summed in their order, so that the bits do not depend on the number of threads.

use crate::right_hand_side::surroundings::zone_rays::{LostRay, lost_transmittance};
use std::f64::consts::PI;
use zonal_math::direction_sampling::{cosine_hemisphere, sin_cos_turns, uniform_sphere};
use zonal_math::parallel;
use zonal_math::{Vec3, low_discrepancy};
use zonal_scene::{Band, Bands, Light, Zones};
use zonal_transport::lights::{EmissionSample, LightSampler};
use zonal_transport::patch_locator::{PatchLocator, facet_side_locator};
use zonal_transport::{Hit, Transport};

/// Attenuation below which a ray from outside has met nothing: rounding where the box of the medium and a wall coincide.
const MIN_ATTENUATION: f64 = 1e-9;
/// Angular diameter, radians, above which the rays of a distant disc start on a rectangle of their own direction.
const WIDE_DISC: f64 = 0.2;
/// Number of rays from a light.
pub(crate) const LIGHT_RAYS: usize = 1 << 17;
/// Rays of a block.
const BLOCK_RAYS: usize = 1 << 10;

/// Powers of a light, W per band.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LightPower {
    pub sent: Bands,
    pub escaped: Bands,
    pub absorbed_backfaces: Bands,
    /// Standard errors of the three.
    pub error: [Bands; 3],
    /// Standard error of the power that the zones receive, sent − escaped − absorbed by backs.
    pub received_error: Bands,
}

impl LightPower {
    /// The three powers, and the power that the zones receive.
    fn powers(&self) -> [Bands; 4] {
        let received = self.sent - self.escaped - self.absorbed_backfaces;
        [self.sent, self.escaped, self.absorbed_backfaces, received]
    }

    /// Measures the powers of a light.
    pub(super) fn measure(zones: &Zones, transport: &Transport, light: &Light) -> LightPower {
        let scene = transport.scene();
        let (lo, hi) = scene.bounds();
        let tracer = LightRays {
            transport,
            patches: facet_side_locator(scene, zones),
            sampler: LightSampler::new(scene, light),
            centre: (lo + hi) * 0.5,
            radius: 0.5 * scene.diagonal() * (1.0 + 1e-9),
        };
        let blocks: Vec<LightPower> = parallel::collect(LIGHT_RAYS / BLOCK_RAYS, |block| {
            let mut sum = LightPower::default();
            (block * BLOCK_RAYS..(block + 1) * BLOCK_RAYS).for_each(|k| tracer.trace(k, &mut sum));
            sum
        });
        let n = blocks.len() as f64;
        let powers: Vec<[Bands; 4]> = blocks.iter().map(LightPower::powers).collect();
        // The sum of a block over the rays of a block is one estimate of the power.
        let each = n / LIGHT_RAYS as f64;
        let mean =
            |k: usize| Bands::from_fn(|b| powers.iter().map(|p| p[k][b]).sum::<f64>() / LIGHT_RAYS as f64);
        let standard_error = |k: usize| {
            let mean = mean(k);
            Bands::from_fn(|b| {
                let square: f64 = powers.iter().map(|p| (p[k][b] * each - mean[b]).powi(2)).sum();
                (square / (n * (n - 1.0))).sqrt()
            })
        };
        LightPower {
            sent: mean(0),
            escaped: mean(1),
            absorbed_backfaces: mean(2),
            error: [standard_error(0), standard_error(1), standard_error(2)],
            received_error: standard_error(3),
        }
    }

    /// Reconciles the powers with the power `received` by the zones: the emission of a surface or of a point light is known, the power that enters from
    /// outside is not.
    pub(super) fn reconcile(&mut self, received: Bands, light: &Light) {
        let is_known = light.is_inside();
        for b in Band::all() {
            if received[b] <= 0.0 {
                continue;
            }
            let lost = self.escaped[b] + self.absorbed_backfaces[b];
            if is_known && lost > 0.0 && self.sent[b] >= received[b] {
                let factor = (self.sent[b] - received[b]) / lost;
                self.escaped[b] *= factor;
                self.absorbed_backfaces[b] *= factor;
            } else {
                self.sent[b] = received[b] + lost;
            }
        }
    }

    /// Adds a ray of power `power`, of which a part is lost on a black back or to the outside.
    fn add(&mut self, power: Bands, lost: LostRay) {
        self.sent += power;
        let sum = if lost.on_back { &mut self.absorbed_backfaces } else { &mut self.escaped };
        *sum += power * lost.share;
    }
}

/// Rays from one light.
struct LightRays<'a> {
    transport: &'a Transport<'a>,
    patches: PatchLocator,
    sampler: LightSampler<'a>,
    /// Centre and radius of a sphere around the scene, m.
    centre: Vec3,
    radius: f64,
}

impl LightRays<'_> {
    /// Traces the `k`-th ray and adds its power.
    fn trace(&self, k: usize, sum: &mut LightPower) {
        let (centre, radius) = (self.centre, self.radius);
        let (u, v) = r4(k);
        match self.sampler.light() {
            Light::Sun { angular_diameter, .. } if *angular_diameter > WIDE_DISC => self.wide_disc(k, u, sum),
            Light::Sun { direction, irradiance, angular_diameter, .. } => {
                // Start on the rectangle that is the projection of the bounds along the beam.
                let disc = low_discrepancy::sobol_2d(k as u32, [0, 0]);
                let dir = direction_from_sun(*direction, *angular_diameter, disc);
                let (t, s) = direction.frame();
                let (lo, hi) = self.transport.scene().bounds();
                let half = (hi - lo) * 0.5;
                let extent = |w: Vec3| half.x * w.x.abs() + half.y * w.y.abs() + half.z * w.z.abs();
                let slack = 1.0 + angular_diameter;
                let (wt, ws) = (extent(t) * slack, extent(s) * slack);
                let at = centre + t * (wt * (2.0 * u[0] - 1.0)) + s * (ws * (2.0 * u[1] - 1.0));
                let power = *irradiance * 4.0 * wt * ws;
                self.enter(at - dir * (2.0 * radius), dir, power, sum);
            }
            Light::Sky { distribution, .. } if !distribution.is_uniform() => self.varying_sky(k, u, sum),
            Light::Sky { radiance, .. } => {
                let out = uniform_sphere(u);
                let dir = cosine_hemisphere(-out, v);
                let power = *radiance * PI * 4.0 * PI * radius * radius;
                self.enter(centre + out * radius, dir, power, sum);
            }
            Light::Point { position, intensity, distribution, .. } => {
                // All rays have the same power.
                let dir = distribution.sample_direction(low_discrepancy::sobol_2d(k as u32, [0, 0]));
                sum.add(*intensity * distribution.solid_angle_integral(), self.lost(*position, dir));
            }
            Light::Emitter { .. } => self.emit(k, u, v, sum),
        }
    }

    /// Adds a ray from a wide disc: from a square normal to it that covers the bounds.
    fn wide_disc(&self, k: usize, u: [f64; 2], sum: &mut LightPower) {
        let (centre, radius) = (self.centre, self.radius);
        let disc = low_discrepancy::sobol_2d(k as u32, [0, 0]);
        let sample = self.sampler.sample_emission([disc[0], disc[1], 0.0]);
        let Some(EmissionSample::Distant { direction: towards, fluence }) = sample else { return };
        let (t, s) = towards.frame();
        let at = centre + t * (radius * (2.0 * u[0] - 1.0)) + s * (radius * (2.0 * u[1] - 1.0));
        self.enter(at + towards * (2.0 * radius), -towards, fluence * (4.0 * radius * radius), sum);
    }

    /// Adds a ray from a sky that is not uniform: from a disc normal to it that covers the bounds.
    fn varying_sky(&self, k: usize, u: [f64; 2], sum: &mut LightPower) {
        let (centre, radius) = (self.centre, self.radius);
        let [x, y] = low_discrepancy::sobol_2d(k as u32, [0, 0]);
        let sample = self.sampler.sample_emission([x, y, 0.0]);
        let Some(EmissionSample::Distant { direction: towards, fluence }) = sample else { return };
        let (t, s) = towards.frame();
        let ((sin, cos), across) = (sin_cos_turns(u[1]), radius * u[0].sqrt());
        let at = centre + (t * cos + s * sin) * across + towards * (2.0 * radius);
        self.enter(at, -towards, fluence * (PI * radius * radius), sum);
    }

    /// The part of a ray that leaves the scene, or that a side without zones absorbs.
    fn lost(&self, origin: Vec3, dir: Vec3) -> LostRay {
        let is_without_zones = |h: &Hit| self.patches.locate(h.side(), [h.u, h.v]).is_none();
        lost_transmittance(self.transport, origin, dir, &is_without_zones)
    }

    /// Adds a ray from outside if it meets a medium, a pane or a surface; a ray that ends on a side without zones has met nothing.
    fn enter(&self, origin: Vec3, dir: Vec3, power: Bands, sum: &mut LightPower) {
        let lost = self.lost(origin, dir);
        if lost.share.all(|s| s > 1.0 - MIN_ATTENUATION) {
            return;
        }
        sum.add(power, lost);
    }

    /// Adds a ray from the surface of an emitter.
    fn emit(&self, k: usize, u: [f64; 2], v: [f64; 2], sum: &mut LightPower) {
        let sample = [u[0], u[1], low_discrepancy::sobol_third_dimension(k as u32, 0)];
        let Some(EmissionSample::Point { position: at, normal, two_sided: both, power, .. }) =
            self.sampler.sample_emission(sample)
        else {
            return;
        };
        let normal = if both && k % 2 == 1 { -normal } else { normal };
        let sides = if both { 2.0 } else { 1.0 };
        let power = power * PI * sides;
        let dir = cosine_hemisphere(normal, v);
        sum.add(power, self.lost(at, dir));
    }
}

/// The `k`-th point of the four-dimensional R sequence in two pairs: φ^{−m} with φ⁵ = φ + 1.
fn r4(k: usize) -> ([f64; 2], [f64; 2]) {
    const ALPHA: [f64; 4] =
        [0.856_674_883_854_502_9, 0.733_891_856_627_126, 0.628_706_721_037_808_7, 0.538_597_257_223_610_1];
    let x = ALPHA.map(|a| low_discrepancy::wrap(0.5 + k as f64 * a));
    ([x[0], x[1]], [x[2], x[3]])
}

/// A direction of light from the disc of the sun.
fn direction_from_sun(direction: Vec3, angular_diameter: f64, u: [f64; 2]) -> Vec3 {
    let (t, b) = direction.frame();
    let r = (0.5 * angular_diameter).tan() * u[0].sqrt();
    let (s, c) = sin_cos_turns(u[1]);
    (direction + t * (r * c) + b * (r * s)).normalized()
}
