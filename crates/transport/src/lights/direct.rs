//! Direct light at a point: irradiance H on a surface, fluence G in free space.
//!
//! ```text
//! H = ∫ L τ cosθ⁺ dω      G = ∫ L τ dω      over the directions ω in which the light is seen
//! ```
//!
//! | light | sampled | contribution of one sample, before τ |
//! |---|---|---|
//! | sun, angular radius α, irradiance E⊥ on a plane normal to it | uniform over its cone | G: 2 E⊥/(1+cosα), times cosθ for H |
//! | sun that the plane of the receiver cuts | the part above the plane (`zonal_math::spherical_cap`) | E⊥/(π sin²α) times the weight of the sample |
//! | uniform sky of radiance L | cosine-weighted for H, uniform over the sphere for G | π L, 4π L |
//! | other sky of radiance L(ω), density p(ω) of its table | for H one half cosine-weighted, one half by p; by p for G | L cosθ/(½ cosθ⁺/π + ½ p), L/p |
//! | point light of intensity I₀ f(ω) | its position | I₀ f/r², times cosθ for H |
//! | emitter of flux E(x), solid angle Ω | uniform over Ω in front of the receiver (`emitter`) | Ω E/π, times cosθ for H |
//!
//! (The sun's radiance is E⊥/(π sin²α) and its solid angle 2π(1−cosα); their product is 2E⊥/(1+cosα).) τ is that of
//! [`Transport::transmittance`]: coloured by medium and panes, zero behind a facet; the emitter's own facet does not occlude, since
//! a segment's ends do not count. The unoccluded light of a uniform emitter of few facets is known in closed form, E/π times its
//! (projected) solid angle, and that of a sun, also where the plane of the receiver cuts its disc; samples then estimate only the fraction that arrives, so the
//! estimate has no noise near an emitter.
//! Samples are low-discrepancy points, shifted by a hash of the seed: equal calls give equal bits. All means are statistical; their
//! error falls as 1/samples where the light is fully visible.

use super::emitter::{Emitter, EmitterPoint};
use super::light_tree::LightBall;
use super::receiver::Receiver;
use super::samples::{EmissionSample, LightSample};
use crate::transport::Transport;
use std::f64::consts::PI;
use zonal_math::direction_sampling::{self, sin_cos_turns, uniform_sphere};
use zonal_math::spherical_cap::CapOverPlane;
use zonal_math::{Vec3, low_discrepancy};
use zonal_scene::{Bands, Light, Scene, SkyDistribution};

/// A light prepared for sampling.
///
/// ```
/// use zonal_math::{Vec3, vec3};
/// use zonal_scene::{Bands, Light, Pane, Plate, Scene, SceneParts};
/// use zonal_transport::Transport;
/// use zonal_transport::lights::{LightSampler, Receiver};
///
/// // A horizontal pane of optical thickness 0.1 under the sun at the zenith.
/// let pane = Pane {
///     name: "pane".into(),
///     plates: vec![Plate::parallelogram(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0))],
///     thickness: 0.01,
///     extinction: Bands::splat(10.0),
///     albedo: Bands::ZERO,
///     emission: Bands::ZERO,
/// };
/// let sun = Light::Sun {
///     name: "sun".into(),
///     direction: vec3(0.0, 0.0, -1.0),
///     irradiance: Bands::splat(1000.0),
///     angular_diameter: 0.0,
/// };
/// let parts = SceneParts { panes: vec![pane], lights: vec![sun], ..SceneParts::default() };
/// let scene = Scene::new(parts).unwrap();
/// let transport = Transport::new(&scene);
/// let sampler = LightSampler::new(&scene, &scene.lights()[0]);
/// let below = Receiver::Surface(vec3(0.0, 0.0, 1.0));
/// let h = sampler.gather(&transport, vec3(0.3, 0.6, -0.5), below, 1, 0);
/// assert!((h.first() - 1000.0 * (-0.1f64).exp()).abs() < 1e-9);
/// ```
#[derive(Clone, Debug)]
pub struct LightSampler<'a> {
    light: &'a Light,
    /// The emitting surface of an emitter.
    emitter: Option<Emitter<'a>>,
}

impl<'a> LightSampler<'a> {
    /// Prepares a light of the scene.
    pub fn new(scene: &'a Scene, light: &'a Light) -> LightSampler<'a> {
        LightSampler { light, emitter: light.surface().map(|s| Emitter::new(scene, s)) }
    }

    /// The light.
    pub fn light(&self) -> &'a Light {
        self.light
    }

    /// True when every sample is the same: a point light, or a sun of zero angular diameter.
    pub fn is_delta(&self) -> bool {
        match self.light {
            Light::Sun { angular_diameter, .. } => *angular_diameter == 0.0,
            Light::Point { .. } => true,
            Light::Sky { .. } | Light::Emitter { .. } => false,
        }
    }

    /// True for an emitter of many facets, which are sampled by clusters.
    pub fn is_clustered(&self) -> bool {
        self.emitter.as_ref().is_some_and(Emitter::is_clustered)
    }

    /// Centre, m, and radius, m, of each cluster of an emitter's facets; none where facets are few.
    pub fn clusters(&self) -> Vec<(Vec3, f64)> {
        self.emitter.as_ref().map_or(Vec::new(), Emitter::clusters)
    }

    /// A ball about the light; `None` for lights that are infinitely far away.
    pub fn ball(&self) -> Option<LightBall> {
        match self.light {
            Light::Point { position, .. } => Some(LightBall { centre: *position, radius: 0.0 }),
            Light::Emitter { .. } => self.emitter.as_ref().and_then(Emitter::ball),
            Light::Sun { .. } | Light::Sky { .. } => None,
        }
    }

    /// Estimate of H or G without attenuation, W/m², of an emitter of many facets; zero for other lights.
    pub fn estimate_unoccluded(&self, point: Vec3, receiver: Receiver) -> Bands {
        self.emitter.as_ref().map_or(Bands::ZERO, |e| e.estimate_unoccluded(point, receiver))
    }

    /// [`LightSampler::sample_at`] with distant clusters of an emitter as seen from their centres: the contribution has an error of a
    /// few per cent at a fraction of the cost. Also returns the distance of the light, m.
    pub fn sample_approximate(
        &self,
        transport: &Transport,
        point: Vec3,
        receiver: Receiver,
        s: [f64; 3],
    ) -> Option<(LightSample, f64)> {
        let far = self.emitter.as_ref().and_then(|e| e.sample_far_cluster(point, receiver, s));
        match far {
            Some((spot, r)) => emitter_sample(spot, point, receiver).map(|b| (b, r)),
            None => self.sample_at(transport, point, receiver, s).map(|b| (b, (b.end - point).length())),
        }
    }

    /// G r² of cluster number `k` without attenuation, W/m² · m², far away in the unit direction `dir` from it.
    pub fn cluster_intensity(&self, k: usize, dir: Vec3) -> Bands {
        self.emitter.as_ref().map_or(Bands::ZERO, |e| e.cluster_intensity(k, dir))
    }

    /// True when [`LightSampler::unoccluded`] has a closed form.
    pub fn has_closed_form(&self) -> bool {
        match self.light {
            Light::Sun { .. } => true,
            Light::Sky { .. } | Light::Point { .. } => false,
            Light::Emitter { .. } => self.emitter.as_ref().is_some_and(Emitter::is_uniform),
        }
    }

    /// The sample of the light at `s` ∈ [0,1)³ as seen from `point`; `None` where it contributes nothing.
    pub fn sample_at(
        &self,
        transport: &Transport,
        point: Vec3,
        receiver: Receiver,
        s: [f64; 3],
    ) -> Option<LightSample> {
        match self.light {
            Light::Sun { direction, irradiance, angular_diameter, .. } => {
                let radius = 0.5 * angular_diameter;
                if let Some(cap) = cut_cap(-*direction, radius, receiver) {
                    let (towards, weight) = cap.sample_above([s[0], s[1]])?;
                    let over_radiance = PI * radius.sin().powi(2);
                    return distant_sample(transport, point, towards, weight / over_radiance, *irradiance);
                }
                let towards = sample_cone(-*direction, *angular_diameter, [s[0], s[1]]);
                let flux = *irradiance * 2.0 / (1.0 + radius.cos());
                distant_sample(transport, point, towards, cosine(receiver, towards), flux)
            }
            Light::Sky { radiance, distribution, .. } if !distribution.is_uniform() => {
                let (towards, weight) = sample_sky(distribution, receiver, [s[0], s[1]]);
                let flux = *radiance * distribution.relative(towards);
                distant_sample(transport, point, towards, weight, flux)
            }
            Light::Sky { radiance, .. } => {
                let (towards, weight) = match receiver {
                    Receiver::Surface(n) => (direction_sampling::cosine_hemisphere(n, [s[0], s[1]]), PI),
                    Receiver::Free => (uniform_sphere([s[0], s[1]]), 4.0 * PI),
                };
                distant_sample(transport, point, towards, weight, *radiance)
            }
            Light::Point { position, intensity, distribution, .. } => {
                let from = point - *position;
                let r2 = from.length2();
                let direction = -from / r2.sqrt();
                let cos = cosine(receiver, direction);
                let relative = distribution.relative(-direction);
                // No light arrives from behind the receiver; at the light itself the direction is not defined.
                (r2 > 0.0 && cos > 0.0 && relative > 0.0).then(|| LightSample {
                    direction,
                    end: *position,
                    flux: *intensity * (relative * cos / r2),
                })
            }
            Light::Emitter { .. } => {
                let spot = self.emitter.as_ref()?.sample_solid_angle(point, receiver, s)?;
                emitter_sample(spot, point, receiver)
            }
        }
    }

    /// [`LightSampler::unoccluded`] and [`LightSampler::sample_at`] together. In free space each sample of a light with a closed form
    /// carries the whole unoccluded fluence, which saves its evaluation.
    pub fn sample_with_unoccluded(
        &self,
        transport: &Transport,
        point: Vec3,
        receiver: Receiver,
        s: [f64; 3],
    ) -> (Bands, Option<LightSample>) {
        let sample = self.sample_at(transport, point, receiver, s);
        let unoccluded = match receiver {
            Receiver::Free if self.has_closed_form() => sample.map_or(Bands::ZERO, |b| b.flux),
            _ => self.unoccluded(point, receiver),
        };
        (unoccluded, sample)
    }

    /// The sample of the light at `s` ∈ [0,1)³, independent of the receiving point; `None` for an emitter without facets.
    pub fn sample_emission(&self, s: [f64; 3]) -> Option<EmissionSample<'a>> {
        match self.light {
            Light::Sun { direction, irradiance, angular_diameter, .. } => {
                let cos_radius = (0.5 * angular_diameter).cos();
                Some(EmissionSample::Distant {
                    direction: sample_cone(-*direction, *angular_diameter, [s[0], s[1]]),
                    fluence: *irradiance * 2.0 / (1.0 + cos_radius),
                })
            }
            Light::Sky { radiance, distribution, .. } if !distribution.is_uniform() => {
                let (direction, density) = distribution.sample_direction([s[0], s[1]]);
                let fluence = *radiance * distribution.relative(direction) / density;
                Some(EmissionSample::Distant { direction, fluence })
            }
            Light::Sky { radiance, .. } => Some(EmissionSample::Distant {
                direction: uniform_sphere([s[0], s[1]]),
                fluence: 4.0 * PI * *radiance,
            }),
            Light::Point { position, intensity, distribution, .. } => {
                Some(EmissionSample::Intensity { position: *position, intensity: *intensity, distribution })
            }
            Light::Emitter { .. } => self.emitter.as_ref()?.sample_area(s),
        }
    }

    /// Contribution of the sample after attenuation, W/m²; `None` behind a facet.
    pub fn attenuated(&self, transport: &Transport, point: Vec3, sample: &LightSample) -> Option<Bands> {
        let tau = transport.transmittance(point, sample.end)?;
        Some(tau * sample.flux)
    }

    /// H or G of this light alone, W/m²: the mean over `samples` points of the light.
    pub fn gather(
        &self,
        transport: &Transport,
        point: Vec3,
        receiver: Receiver,
        samples: usize,
        seed: u64,
    ) -> Bands {
        let (n, at) = self.stratified(samples, seed);
        self.gather_with(transport, point, receiver, n, at)
    }

    /// The number of samples for `samples` wanted ones, which is 1 where all are alike, and their points of the unit cube, stratified and shifted by `seed`.
    pub fn stratified(&self, samples: usize, seed: u64) -> (usize, impl Fn(usize) -> [f64; 3] + use<>) {
        let n = if self.is_delta() { 1 } else { samples.max(1) };
        let shift = [0, 1, 2].map(|k| low_discrepancy::hash_to_unit(seed.wrapping_mul(3).wrapping_add(k)));
        (n, move |i| stratified(i, n, shift))
    }

    /// H or G of this light alone, W/m², from `n` samples at the points `at(0)` … `at(n − 1)` of the unit cube.
    pub fn gather_with(
        &self,
        transport: &Transport,
        point: Vec3,
        receiver: Receiver,
        n: usize,
        at: impl Fn(usize) -> [f64; 3],
    ) -> Bands {
        self.gather_weighted(transport, point, receiver, n, at, |flux, _| flux)
    }

    /// The same with the contribution of each sample weighted by its direction: `weighted(flux, direction)` is W/m² for the attenuated contribution `flux`, W/m²,
    /// and the unit vector towards the light.
    pub fn gather_weighted(
        &self,
        transport: &Transport,
        point: Vec3,
        receiver: Receiver,
        n: usize,
        at: impl Fn(usize) -> [f64; 3],
        weighted: impl Fn(Bands, Vec3) -> Bands,
    ) -> Bands {
        // Sum the samples before and after attenuation.
        let (mut sent, mut arrived) = (Bands::ZERO, Bands::ZERO);
        let mut view = self.emitter.as_ref().filter(|_| n > 1).map(|e| e.view(point, receiver));
        for i in 0..n {
            let sample = match &mut view {
                Some(view) => view.sample(at(i)).and_then(|spot| emitter_sample(spot, point, receiver)),
                None => self.sample_at(transport, point, receiver, at(i)),
            };
            if let Some(sample) = sample {
                sent += sample.flux;
                let flux = self.attenuated(transport, point, &sample).unwrap_or_default();
                arrived += weighted(flux, sample.direction);
            }
        }
        if !self.has_closed_form() {
            return arrived / n as f64;
        }
        // Scale the closed form by the fraction that arrives.
        let unoccluded = self.unoccluded(point, receiver);
        Bands::from_fn(|b| if sent[b] > 0.0 { unoccluded[b] * arrived[b] / sent[b] } else { 0.0 })
    }

    /// The same with the number of samples by need: `few` first ones show whether the point lies in the penumbra, where some arrive and others do not. The value is
    /// the mean of as many others, in the penumbra of `many` others: samples that choose their number are not part of it, as it would be biased.
    pub fn gather_adaptively(
        &self,
        transport: &Transport,
        point: Vec3,
        receiver: Receiver,
        [few, many]: [usize; 2],
        at: impl Fn(usize) -> [f64; 3],
    ) -> Bands {
        let mut seen = [false; 2];
        let mut first = (0..few).filter_map(|i| self.sample_at(transport, point, receiver, at(i)));
        let in_penumbra = first.any(|sample| {
            seen[usize::from(transport.occluded(point, sample.end))] = true;
            seen == [true; 2]
        });
        let n = if in_penumbra { many } else { few };
        self.gather_with(transport, point, receiver, n, |i| at(few + i))
    }

    /// H or G of an emitter or a sun without attenuation, W/m², in closed form; zero for a light that has none.
    pub fn unoccluded(&self, point: Vec3, receiver: Receiver) -> Bands {
        match self.light {
            Light::Sun { direction, irradiance, angular_diameter, .. } => {
                *irradiance * sun_factor(-*direction, 0.5 * angular_diameter, receiver)
            }
            Light::Sky { .. } | Light::Point { .. } => Bands::ZERO,
            Light::Emitter { .. } => {
                self.emitter.as_ref().map_or(Bands::ZERO, |e| e.unoccluded(point, receiver))
            }
        }
    }

    /// An upper bound of H or G without occlusion, W/m², at any point of the convex hull of `corners`, which lies in the plane of the receiver: zero where the light is
    /// proved to lie behind it, or to shine elsewhere.
    pub fn upper_bound(&self, corners: &[Vec3], receiver: Receiver) -> Bands {
        match (self.light, receiver) {
            (Light::Sky { radiance, distribution, .. }, Receiver::Surface(n)) => {
                *radiance * distribution.irradiance_bound(n)
            }
            (Light::Sky { radiance, distribution, .. }, Receiver::Free) => {
                *radiance * distribution.solid_angle_integral()
            }
            (Light::Emitter { .. }, _) if !self.has_closed_form() => {
                self.emitter.as_ref().map_or(Bands::ZERO, |e| e.upper_bound(corners, receiver))
            }
            // Unbounded at the light.
            (Light::Point { intensity, .. }, _) => {
                intensity.map(|i| if i > 0.0 { f64::INFINITY } else { 0.0 })
            }
            // The cosine is largest at a corner, the solid angle not always.
            (Light::Sun { .. } | Light::Emitter { .. }, _) => {
                corners.iter().map(|x| self.unoccluded(*x, receiver)).fold(Bands::ZERO, Bands::max)
            }
        }
    }
}

/// The `i`-th of `n` points of the unit cube: a shifted R₂ sequence, and an evenly spaced third coordinate.
fn stratified(i: usize, n: usize, shift: [f64; 3]) -> [f64; 3] {
    let [x, y] = low_discrepancy::r2(i, [shift[0], shift[1]]);
    [x, y, (i as f64 + shift[2]) / n as f64]
}

/// The sample of an emitter's point; `None` behind the receiver.
fn emitter_sample(spot: EmitterPoint, point: Vec3, receiver: Receiver) -> Option<LightSample> {
    let direction = (spot.at - point).normalized();
    let cos = cosine(receiver, direction);
    (cos > 0.0).then(|| LightSample { direction, end: spot.at, flux: spot.fluence * cos })
}

/// Cosine with the receiver's normal; 1 in free space.
fn cosine(receiver: Receiver, direction: Vec3) -> f64 {
    match receiver {
        Receiver::Surface(n) => n.dot(direction),
        Receiver::Free => 1.0,
    }
}

/// The sample of a light at infinity; `None` where its weight is not positive.
fn distant_sample(
    transport: &Transport,
    point: Vec3,
    direction: Vec3,
    weight: f64,
    light: Bands,
) -> Option<LightSample> {
    (weight > 0.0).then(|| LightSample {
        direction,
        end: transport.exterior_point(point, direction),
        flux: light * weight,
    })
}

/// The disc of angular radius `radius` about the unit vector `towards` over the plane of a receiver that cuts it; `None` where no plane cuts it.
fn cut_cap(towards: Vec3, radius: f64, receiver: Receiver) -> Option<CapOverPlane> {
    let Receiver::Surface(n) = receiver else { return None };
    let may_be_cut = n.dot(towards).abs() < radius;
    may_be_cut.then(|| CapOverPlane::new(radius, towards, n)).filter(CapOverPlane::is_cut)
}

/// H or G over E⊥ of the disc of angular radius `radius` about the unit vector `towards`, without attenuation.
fn sun_factor(towards: Vec3, radius: f64, receiver: Receiver) -> f64 {
    match (receiver, cut_cap(towards, radius, receiver)) {
        (Receiver::Free, _) => 2.0 / (1.0 + radius.cos()),
        (Receiver::Surface(_), Some(cap)) => cap.mean_cosine(),
        (Receiver::Surface(n), None) => n.dot(towards).max(0.0),
    }
}

/// A direction towards a sky that is not uniform, and the factor of its radiance in H or G, sr: the balance heuristic (Veach 1997) over a cosine-weighted sample, drawn
/// by the first half of the unit interval, and one of the table of the sky. The factor is bounded by 2π, also where the table has no light.
fn sample_sky(distribution: &SkyDistribution, receiver: Receiver, u: [f64; 2]) -> (Vec3, f64) {
    let Receiver::Surface(n) = receiver else {
        let (towards, density) = distribution.sample_direction(u);
        return (towards, 1.0 / density);
    };
    let towards = if u[0] < 0.5 {
        direction_sampling::cosine_hemisphere(n, [2.0 * u[0], u[1]])
    } else {
        distribution.sample_direction([2.0 * u[0] - 1.0, u[1]]).0
    };
    let cos = n.dot(towards).max(0.0);
    let density = 0.5 * (cos / PI + distribution.density(towards));
    (towards, if cos > 0.0 { cos / density } else { 0.0 })
}

/// A direction uniform over the cone of full angle `angle` about the unit vector `axis`.
fn sample_cone(axis: Vec3, angle: f64, s: [f64; 2]) -> Vec3 {
    if angle == 0.0 {
        return axis;
    }
    // 1 − cosα without cancellation.
    let height = 2.0 * (0.25 * angle).sin().powi(2) * s[0];
    let (z, r) = (1.0 - height, (height * (2.0 - height)).max(0.0).sqrt());
    let (t, b) = axis.frame();
    let (sin, cos) = sin_cos_turns(s[1]);
    (axis * z + (t * cos + b * sin) * r).normalized()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;
    use zonal_math::vec3;
    use zonal_scene::{Facet, Pane, Plate, SceneParts, Surface, VoxelGrid};

    fn surface(name: &str, emission: f64) -> Surface {
        Surface { name: name.into(), emission: Bands::splat(emission), ..Surface::default() }
    }

    fn facet(surface: usize, plate: Plate) -> Facet {
        let uv = [[0.0; 2]; 3];
        Facet { surface, plate, uv }
    }

    fn square(z: f64, half: f64, up: bool) -> Plate {
        let (x, y) = (vec3(2.0 * half, 0.0, 0.0), vec3(0.0, 2.0 * half, 0.0));
        let o = vec3(-half, -half, z);
        if up { Plate::parallelogram(o, x, y) } else { Plate::parallelogram(o, y, x) }
    }

    fn irradiance(scene: &Scene, light: &Light, at: (Vec3, Vec3), samples: usize, seed: u64) -> Bands {
        let transport = Transport::new(scene);
        let sampler = LightSampler::new(scene, light);
        sampler.gather(&transport, at.0, Receiver::Surface(at.1), samples, seed)
    }

    fn fluence(scene: &Scene, light: &Light, point: Vec3, samples: usize, seed: u64) -> Bands {
        let transport = Transport::new(scene);
        LightSampler::new(scene, light).gather(&transport, point, Receiver::Free, samples, seed)
    }

    fn sun(angle: f64) -> Light {
        Light::Sun {
            name: "sun".into(),
            direction: vec3(0.0, 0.6, -0.8),
            irradiance: Bands::from_rgb([1.0, 2.0, 4.0]),
            angular_diameter: angle,
        }
    }

    /// Form factor of a rectangle a × b seen from a parallel element at distance c below one of its corners.
    fn corner_view_factor(a: f64, b: f64, c: f64) -> f64 {
        let (x, y) = (a / c, b / c);
        let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
        (x / p * (y / p).atan() + y / q * (x / q).atan()) / TAU
    }

    #[test]
    fn irradiance_of_rectangular_emitter_matches_closed_form() {
        let scene = Scene::new(SceneParts {
            surfaces: vec![surface("lamp", 7.0), surface("floor", 0.0)],
            facets: vec![facet(0, square(1.0, 0.5, false)), facet(1, square(0.0, 2.0, true))],
            lights: vec![Light::Emitter { surface: 0, name: None }],
            ..SceneParts::default()
        })
        .unwrap();
        let light = &scene.lights()[0];
        let up = vec3(0.0, 0.0, 1.0);
        let h = irradiance(&scene, light, (Vec3::ZERO, up), 4096, 1);
        let exact = 7.0 * 4.0 * corner_view_factor(0.5, 0.5, 1.0);
        assert!((h.first() / exact - 1.0).abs() < 1e-3, "{h:?} {exact}");
        let away = irradiance(&scene, light, (Vec3::ZERO, -up), 64, 1);
        assert_eq!(away, Bands::ZERO);
        let above = fluence(&scene, light, vec3(0.0, 0.0, 2.0), 64, 1);
        assert_eq!(above, Bands::ZERO, "the emitter emits downwards only");
    }

    #[test]
    fn sunlight_is_attenuated_by_medium_and_pane_and_occluded_by_walls() {
        let mut map = VoxelGrid::new(vec3(-1.0, -1.0, 0.0), Vec3::splat(1.0), [2, 2, 2]).unwrap();
        (0..8).for_each(|i| map.set(i, Bands::splat(0.3), Bands::splat(0.5), Bands::ZERO, Bands::ZERO));
        let pane = Pane {
            name: "pane".into(),
            plates: vec![square(3.0, 9.0, true)],
            thickness: 0.01,
            extinction: Bands::from_rgb([10.0, 0.0, 20.0]),
            albedo: Bands::ZERO,
            emission: Bands::ZERO,
        };
        let parts = SceneParts {
            panes: vec![pane],
            voxel_grid: Some(map.seal().unwrap()),
            lights: vec![sun(0.0)],
            ..SceneParts::default()
        };
        let scene = Scene::new(parts.clone()).unwrap();
        let p = vec3(0.0, 0.5, 1.0);
        let g = fluence(&scene, &scene.lights()[0], p, 16, 3);
        // Towards (0, −0.6, 0.8): one metre up takes 1.25 m.
        let depth = Bands::from_rgb([0.3 * 1.25 + 0.1 / 0.8, 0.3 * 1.25, 0.3 * 1.25 + 0.2 / 0.8]);
        let exact = Bands::from_rgb([1.0, 2.0, 4.0]) * (-depth).exp();
        assert!((g / exact - 1.0).abs().all(|e| e < 1e-12), "{g:?} {exact:?}");
        let h = irradiance(&scene, &scene.lights()[0], (p, vec3(0.0, 0.0, 1.0)), 16, 3);
        assert!(((h / g).first() - 0.8).abs() < 1e-12);
        let walled = SceneParts {
            surfaces: vec![surface("roof", 0.0)],
            facets: vec![facet(0, square(2.5, 9.0, true))],
            ..parts
        };
        let scene = Scene::new(walled).unwrap();
        assert_eq!(fluence(&scene, &scene.lights()[0], p, 16, 3), Bands::ZERO);
    }

    #[test]
    fn wide_suns_and_skies_have_exact_means() {
        let floor = SceneParts {
            surfaces: vec![surface("floor", 0.0)],
            facets: vec![facet(0, square(0.0, 1.0, true))],
            ..SceneParts::default()
        };
        let scene = Scene::new(floor).unwrap();
        let towards = vec3(0.0, -0.6, 0.8);
        let h = irradiance(&scene, &sun(0.8), (Vec3::ZERO, towards), 1024, 5);
        let exact = Bands::from_rgb([1.0, 2.0, 4.0]);
        assert!((h / exact - 1.0).abs().all(|e| e < 2e-3), "irradiance of a wide sun: {h:?}");
        let sky = Light::Sky {
            name: "sky".into(),
            radiance: Bands::splat(2.0),
            distribution: SkyDistribution::uniform(),
        };
        let up = vec3(0.0, 0.0, 1.0);
        let h = irradiance(&scene, &sky, (Vec3::ZERO, up), 64, 5);
        assert!((h.first() / TAU - 1.0).abs() < 1e-9, "{h:?}");
        let g = fluence(&scene, &sky, vec3(0.0, 0.0, 1e-4), 1024, 5);
        assert!((g.first() / (4.0 * PI) - 1.0).abs() < 0.01, "the floor covers half the sphere: {g:?}");
    }

    #[test]
    fn more_samples_in_the_penumbra_do_not_change_the_mean() {
        // A lamp of 2 m hangs 2 m above; a plate 1 m above hides its edge from the point, a tenth of it.
        let hides = Plate::parallelogram(vec3(0.4, -1.0, 1.0), vec3(2.0, 0.0, 0.0), vec3(0.0, 2.0, 0.0));
        let scene = Scene::new(SceneParts {
            surfaces: vec![surface("lamp", 1.0), surface("plate", 0.0)],
            facets: vec![facet(0, square(2.0, 1.0, false)), facet(1, hides)],
            lights: vec![Light::Emitter { surface: 0, name: None }],
            ..SceneParts::default()
        })
        .unwrap();
        let (transport, sampler) = (Transport::new(&scene), LightSampler::new(&scene, &scene.lights()[0]));
        let receiver = (Vec3::ZERO, Receiver::Surface(vec3(0.0, 0.0, 1.0)));
        let at = |shift: [f64; 3]| move |i: usize| low_discrepancy::r3(i, shift);
        let exact = sampler.gather_with(&transport, receiver.0, receiver.1, 20_000, at([0.5; 3])).first();
        let open = sampler.unoccluded(receiver.0, receiver.1).first();
        assert!(exact > 0.8 * open && exact < 0.95 * open, "{exact} of {open}");
        let n = 4000;
        let shift = |k: u64| [0, 1, 2].map(|i| low_discrepancy::hash_to_unit(3 * k + i));
        let mean = (0..n)
            .map(|k| {
                sampler.gather_adaptively(&transport, receiver.0, receiver.1, [4, 16], at(shift(k))).first()
            })
            .sum::<f64>()
            / n as f64;
        assert!((mean / exact - 1.0).abs() < 0.005, "{mean} {exact}");
    }
}
