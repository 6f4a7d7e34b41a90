//! Direct light: irradiance H_dir of surface points and light scattered once along a ray.
//!
//! | light | on a surface | in the medium |
//! |---|---|---|
//! | sun without extent | shadow ray, depth of the medium from [`SunDepthCache`] | exact lit intervals, [`SingleScattering`] |
//! | sun with an extent | the same, more samples in the penumbra | [`DeepShadowMap`] |
//! | sky | `sky_field`, or shadow rays of the light sampler | field of the zones, or lit intervals of sampled directions |
//! | point light | one shadow ray | lit intervals, [`SingleScattering`] |
//! | emitter of few facets | shadow rays of the light sampler | [`AnalyticAreaLight`], or lit intervals of sampled points |
//! | emitter of many facets | one sample a cluster, with Russian roulette where it is faint | field of [`crate::medium::many_lights`] |
//!
//! Cost of a surface point: one shadow ray a sample. Cost of a ray: lit intervals or a walk through the map for each light.

use super::ray_sampler::RaySampler;
use crate::lights::WIDE_SUN_DIAMETER;
use crate::lights::lit_intervals::ShadowCasters;
use crate::lights::shadow_ray::trace_shadow_ray;
use crate::lights::sun_depth_cache::SunDepthCache;
use crate::medium::analytic_area_light::AnalyticAreaLight;
use crate::medium::deep_shadow_map::{DeepShadowMap, MapSamples};
use crate::medium::ray_path::RayPath;
use crate::medium::single_scattering::SingleScattering;
use crate::options::DEPTH_NODE_SPACING;
use crate::view_ray::ViewRay;
use zonal_math::Vec3;
use zonal_scene::{Band, Bands};
use zonal_transport::Transport;
use zonal_transport::lights::{EmissionSample, LightSampler, Receiver};

// Sampling of direct light on surfaces.

/// Samples of a sky over those of other lights: it fills the hemisphere.
const SKY_SAMPLE_FACTOR: usize = 4;
/// Samples of a sun or an emitter in its penumbra over those elsewhere.
const PENUMBRA_SAMPLE_FACTOR: usize = 4;
/// Share of the indirect irradiance below which a clustered emitter has one shadow ray.
const SINGLE_RAY_SHARE: f64 = 0.04;
/// Points at which the extinction is sampled on the way to a clustered emitter.
const DEPTH_SAMPLES: usize = 4;
/// Share of the indirect irradiance below which Russian roulette decides about that ray.
const ROULETTE_SHARE: f64 = 0.015;

/// Evaluation of emitters of many facets on surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DirectLightAccuracy {
    /// Every sample is a point of a facet.
    PerFacet,
    /// A cluster of facets that looks small is one point, and faint clusters are left to Russian roulette.
    Clustered,
}

/// A light and the data that speed it up.
struct PreparedLight<'a> {
    sampler: LightSampler<'a>,
    /// For an emitter of few facets: its closed form.
    area_light: Option<AnalyticAreaLight>,
    /// For a sun with an extent.
    shadow_map: Option<DeepShadowMap<'a>>,
    /// For a sun without extent.
    sun_depths: Option<SunDepthCache<'a>>,
}

impl<'a> PreparedLight<'a> {
    fn new(transport: &'a Transport<'a>, sampler: LightSampler<'a>) -> PreparedLight<'a> {
        PreparedLight {
            area_light: AnalyticAreaLight::new(transport.scene(), &sampler),
            shadow_map: shadow_map(transport, &sampler),
            sun_depths: sun_depths(transport, &sampler),
            sampler,
        }
    }

    /// Optical depths towards a sun that is narrow enough for one direction to stand for all.
    fn narrow_sun_depths(&self) -> Option<&SunDepthCache<'a>> {
        let disc = self.sampler.light().distant_disc();
        let narrow = disc.is_some_and(|(_, diameter)| diameter < WIDE_SUN_DIAMETER);
        let depths = self.shadow_map.as_ref().map(DeepShadowMap::sun_depths).or(self.sun_depths.as_ref());
        depths.filter(|_| narrow)
    }
}

/// All lights of a scene, ready to light surfaces and rays.
pub(crate) struct DirectLights<'a> {
    transport: &'a Transport<'a>,
    lights: Vec<PreparedLight<'a>>,
    scattering: SingleScattering<'a>,
    /// Evaluation of emitters of many facets on surfaces.
    pub accuracy: DirectLightAccuracy,
}

/// A surface point that receives direct light.
pub(crate) struct LitPoint {
    pub point: Vec3,
    /// Unit normal.
    pub normal: Vec3,
    /// Indirect irradiance, W/m²: the scale below which light is faint.
    pub indirect: Bands,
}

impl<'a> DirectLights<'a> {
    /// Prepares the lights of `samplers`.
    pub(crate) fn new(transport: &'a Transport<'a>, samplers: Vec<LightSampler<'a>>) -> DirectLights<'a> {
        let scene = transport.scene();
        let spacing = DEPTH_NODE_SPACING;
        let node_spacing = scene.voxel_grid().map_or(1.0, |v| spacing * v.cell().product().cbrt());
        let casters = ShadowCasters::new(scene);
        DirectLights {
            transport,
            lights: samplers.into_iter().map(|l| PreparedLight::new(transport, l)).collect(),
            scattering: SingleScattering { scene, transport, casters, node_spacing },
            accuracy: DirectLightAccuracy::PerFacet,
        }
    }

    /// H_dir, W/m², at a surface point, of the lights but those that `skip` selects.
    pub(crate) fn irradiance(
        &self,
        receiver: &LitPoint,
        sampler: RaySampler,
        skip: &dyn Fn(&LightSampler) -> bool,
    ) -> Bands {
        let point = receiver.point;
        let mut sum = Bands::ZERO;
        for light in self.lights.iter().filter(|l| !skip(&l.sampler)) {
            let (light_sampler, map) = (&light.sampler, &light.shadow_map);
            if map.as_ref().is_some_and(|c| c.is_dark(point)) {
                continue;
            }
            let n = match light_sampler.light() {
                _ if light_sampler.is_delta() => 1,
                light if light.fills_sphere() => SKY_SAMPLE_FACTOR * sampler.count,
                _ => sampler.count,
            };
            let penumbra = || map.as_ref().is_some_and(|c| c.may_be_penumbra(point, sampler.shift));
            let factor = if n > 1 && penumbra() { PENUMBRA_SAMPLE_FACTOR } else { 1 };
            let own = sampler.with_count(factor * n);
            let clustered = self.accuracy == DirectLightAccuracy::Clustered && light_sampler.is_clustered();
            let h = match light.narrow_sun_depths() {
                Some(depths) => self.sun_irradiance(light_sampler, depths, receiver, &own),
                None if clustered => self.clustered_irradiance(light_sampler, receiver, &own),
                None => self.sampled_irradiance(light_sampler, receiver, &own),
            };
            sum += h;
        }
        sum
    }

    /// H_dir by the samples of a ray; more of them in the penumbra of an emitter.
    fn sampled_irradiance(&self, light_sampler: &LightSampler, at: &LitPoint, own: &RaySampler) -> Bands {
        let (point, receiver, few) = (at.point, Receiver::Surface(at.normal), own.count);
        if light_sampler.is_delta() || !light_sampler.light().is_inside() {
            return light_sampler.gather_with(self.transport, point, receiver, few, |i| own.sample(i));
        }
        let many = PENUMBRA_SAMPLE_FACTOR * few;
        let all = own.with_count(few + many);
        light_sampler.gather_adaptively(self.transport, point, receiver, [few, many], |i| all.sample(i))
    }

    /// H_dir of an emitter of many facets, each cluster as one point. Where the whole emitter is faint, one shadow ray is traced with
    /// the probability p and weighted by 1/p.
    fn clustered_irradiance(&self, light_sampler: &LightSampler, at: &LitPoint, own: &RaySampler) -> Bands {
        let (point, receiver) = (at.point, Receiver::Surface(at.normal));
        // Compare the unoccluded irradiance with the indirect one.
        let unoccluded = light_sampler.estimate_unoccluded(point, receiver);
        let share = Band::all().fold(0.0, |s: f64, b| s.max(unoccluded[b] / at.indirect[b].max(1e-300)));
        let (n, probability) =
            if share > SINGLE_RAY_SHARE { (own.count, 1.0) } else { (1, (share / ROULETTE_SHARE).min(1.0)) };
        let mut sum = Bands::ZERO;
        if own.roulette() >= probability {
            return sum;
        }
        for i in 0..n {
            let sample = light_sampler.sample_approximate(self.transport, point, receiver, own.sample(i));
            let Some((sample, _)) = sample.filter(|s| trace_shadow_ray(self.transport, point, s.0.end))
            else {
                continue;
            };
            let depth = self.sampled_depth(point, sample.end);
            sum += sample.flux * (-depth).exp() / (probability * n as f64);
        }
        sum
    }

    /// Optical depth between two points by the midpoint rule: the extinction at a few points, and the panes.
    fn sampled_depth(&self, a: Vec3, b: Vec3) -> Bands {
        let n = DEPTH_SAMPLES;
        let mut sum = self.transport.pane_depth_inside(a, b);
        if let Some(map) = self.transport.scene().voxel_grid() {
            let part = (b - a).length() / n as f64;
            for k in 0..n {
                let at = map.cell_at(a + (b - a) * ((k as f64 + 0.5) / n as f64));
                let kappa = at.map_or(Bands::ZERO, |c| map.extinction(map.index(c)));
                sum += kappa * part;
            }
        }
        sum
    }

    /// H_dir of a sun, with the depth of the medium towards its centre.
    fn sun_irradiance(
        &self,
        light_sampler: &LightSampler,
        depths: &SunDepthCache,
        at: &LitPoint,
        own: &RaySampler,
    ) -> Bands {
        let (mut sum, mut lit) = (Bands::ZERO, false);
        for i in 0..own.count {
            let sample = light_sampler.sample_at(
                self.transport,
                at.point,
                Receiver::Surface(at.normal),
                own.sample(i),
            );
            let Some(sample) = sample else { continue };
            if !trace_shadow_ray(self.transport, at.point, sample.end) {
                continue;
            }
            lit = true;
            let mut passed = Bands::ONE;
            self.transport.pane_crossings(at.point, sample.end, &mut |h| {
                let pane = &self.transport.scene().panes()[h.pane];
                passed *= (-pane.extinction * pane.thickness / h.cos).exp();
            });
            sum += passed * sample.flux / own.count as f64;
        }
        if !lit {
            return sum;
        }
        let depth = depths.depth(at.point);
        sum * (-depth).exp()
    }

    /// Radiance, W/(m² sr), of direct light scattered once along a path, but for the lights that `skip` selects.
    pub(crate) fn inscattered(
        &self,
        ray: ViewRay,
        path: &RayPath,
        sampler: RaySampler,
        skip: &dyn Fn(&LightSampler) -> bool,
    ) -> Bands {
        let mut out = Bands::ZERO;
        if path.segments.iter().all(|p| p.scattering == Bands::ZERO) {
            return out;
        }
        for light in self.lights.iter().filter(|l| !skip(&l.sampler)) {
            if let Some(map) = &light.shadow_map {
                for i in 0..sampler.medium_repeats {
                    let samples = MapSamples {
                        first: sampler.first * sampler.medium_repeats + i,
                        shift: sampler.shift,
                        max_steps: sampler.max_sun_steps,
                    };
                    out +=
                        map.inscattered(&self.scattering, ray, path, samples) / sampler.medium_repeats as f64;
                }
                continue;
            }
            let n = if light.sampler.is_delta() { 1 } else { sampler.count.div_ceil(2) };
            if let Some(area_light) = &light.area_light {
                let n = sampler.count * sampler.medium_repeats;
                let own = sampler.with_count(n);
                let points: Vec<EmissionSample> =
                    (0..n).filter_map(|i| light.sampler.sample_emission(own.sample(i))).collect();
                out += area_light.inscattered(&self.scattering, &light.sampler, ray, path, &points);
                continue;
            }
            let own = sampler.with_count(n);
            for i in 0..n {
                if let Some(source) = light.sampler.sample_emission(own.sample(i)) {
                    let l = self.scattering.inscattered(ray, path, &source, light.sun_depths.as_ref());
                    out += l / n as f64;
                }
            }
        }
        out
    }
}

#[cfg(test)]
impl DirectLights<'_> {
    /// Leaves every emitter to sampled points.
    pub(crate) fn disable_analytic_area_lights(&mut self) {
        self.lights.iter_mut().for_each(|l| l.area_light = None);
    }

    /// Light of suns with an extent, scattered along a path.
    pub(crate) fn inscattered_by_shadow_maps(&self, ray: ViewRay, path: &RayPath, s: RaySampler) -> Bands {
        let samples = MapSamples { first: s.first, shift: s.shift, max_steps: s.max_sun_steps };
        let one = |m: &DeepShadowMap| m.inscattered(&self.scattering, ray, path, samples);
        let maps = self.lights.iter().filter_map(|l| l.shadow_map.as_ref());
        maps.map(one).sum()
    }

    /// Light of one sample, scattered along a path.
    pub(crate) fn inscattered_by_sample(
        &self,
        ray: ViewRay,
        path: &RayPath,
        source: &EmissionSample,
    ) -> Bands {
        self.scattering.inscattered(ray, path, source, None)
    }
}

/// The deep shadow map of a sun that has an extent; shadows of one without are exact otherwise.
fn shadow_map<'a>(transport: &'a Transport<'a>, light_sampler: &LightSampler) -> Option<DeepShadowMap<'a>> {
    let (direction, angular_diameter) = light_sampler.light().distant_disc()?;
    match light_sampler.sample_emission([0.0; 3])? {
        EmissionSample::Distant { fluence, .. } if angular_diameter > 0.0 => {
            Some(DeepShadowMap::new(transport, -direction, angular_diameter, fluence))
        }
        _ => None,
    }
}

/// Optical depths towards a sun without extent.
fn sun_depths<'a>(transport: &'a Transport<'a>, light_sampler: &LightSampler) -> Option<SunDepthCache<'a>> {
    match light_sampler.sample_emission([0.0; 3])? {
        EmissionSample::Distant { direction: towards, .. } if light_sampler.is_delta() => {
            Some(SunDepthCache::new(transport, towards))
        }
        _ => None,
    }
}
