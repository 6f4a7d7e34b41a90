//! Radiance along one camera ray.
//!
//! ```text
//! L = L_m + τ L_end      L_end = B/π,   B = E(x) + ρ(x) (H(x) + H_dir(x)), and of a sheet that transmits with its τ(x) times the same of its other side
//! ```
//!
//! L_m is the radiance that the path adds: indirect emission and scattering of its segments, panes, and single scattering of direct
//! light. B is zero on the back of a one-sided surface. Where there is no surface, L_end is the radiance of the surroundings and skies.
//! H is interpolated between the patches, denoised, and corrected near contacts, or found by a final gather.

use super::contact_field::ContactField;
use super::direct_light::{DirectLights, LitPoint};
use super::final_gather::{FinalGather, GatherInputs};
use super::medium_segment::{CameraRayEnd, MediumSegment};
use super::node_lattice::Viewpoint;
use super::ray_sampler::RaySampler;
use super::sky_field::{SkyField, StoredSkies};
use crate::image::denoise::{NoisyField, denoise_patches};
use crate::medium::many_lights::ManyLights;
use crate::medium::path_builder::PathBuilder;
use crate::medium::radiosity_field::RadiosityField;
use crate::medium::ray_path::{RayPath, VoxelSegment, linear_source_integral};
use crate::surface::curved_facets::CurvedFacets;
use crate::surface::patch_field::PatchField;
use crate::surface::shading::ReceiverPoint;
use crate::surface::tiles::patch_field;
use crate::view_ray::ViewRay;
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_scene::{Band, Bands, Light, Sides, Solution};
use zonal_transport::lights::LightSampler;
use zonal_transport::{Hit, Transport};

pub(crate) use super::direct_light::DirectLightAccuracy;

/// The two Gauss–Legendre points on [0,1].
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// Radiance of rays through one solution.
pub(crate) struct Integrator<'a> {
    solution: &'a Solution,
    transport: &'a Transport<'a>,
    paths: PathBuilder<'a>,
    /// Indirect irradiance H of the patches, denoised.
    irradiance: PatchField<'a>,
    /// Indirect radiosity of the medium.
    medium: Option<RadiosityField<'a>>,
    lights: DirectLights<'a>,
    /// Radiance of the surroundings and of uniform skies where a ray leaves the scene, W/(m² sr).
    background: Bands,
    gather: Option<FinalGather<'a>>,
    /// Corrections near contacts for the camera of the picture.
    contacts: Option<ContactField<'a>>,
    /// Irradiance of skies for that camera.
    skies: Option<SkyField<'a>>,
    /// True if `medium` contains the light of skies that the medium scatters once.
    medium_has_skies: bool,
    /// True if transparent voxels emit.
    has_glow: bool,
}

impl<'a> Integrator<'a> {
    /// Prepares fields, lights and shadows.
    pub(crate) fn new(s: &'a Solution, transport: &'a Transport<'a>) -> Integrator<'a> {
        let scene = &s.scene;
        let mut background = scene.surroundings().radiance;
        for (radiance, distribution) in scene.lights().iter().filter_map(Light::sky) {
            if distribution.is_uniform() {
                background += radiance;
            }
        }
        let samplers: Vec<LightSampler> =
            scene.lights().iter().map(|l| LightSampler::new(scene, l)).collect();
        let field = NoisyField { incident: &s.fields.incident, error: &s.fields.error };
        let mut incident = denoise_patches(&s.zones.patches, &[field]).swap_remove(0);
        CurvedFacets::of(s).adjust(&mut incident);
        Integrator {
            solution: s,
            transport,
            paths: PathBuilder::new(s, transport),
            irradiance: patch_field(s, transport, &incident),
            medium: RadiosityField::new(s, transport, ManyLights::new(s, transport, &samplers)),
            lights: DirectLights::new(transport, samplers),
            background,
            gather: None,
            contacts: None,
            skies: None,
            medium_has_skies: false,
            has_glow: s.zones.has_transparent_sources(),
        }
    }

    /// The same with clustered emitters evaluated as `accuracy` says.
    pub(crate) fn with_accuracy(mut self, accuracy: DirectLightAccuracy) -> Integrator<'a> {
        self.lights.accuracy = accuracy;
        self
    }

    /// The same with skies that light the medium by the fluence of its zones, where the solution has it apart.
    pub(crate) fn with_skies_of_zones(mut self) -> Integrator<'a> {
        if let (Some(field), Some(skies)) = (&mut self.medium, StoredSkies::of(self.solution)) {
            field.add_radiosity(|zone| skies.scattered(zone));
            self.medium_has_skies = true;
        }
        self
    }

    /// The same with the indirect light of surfaces gathered by `rays` rays; 0: interpolated.
    pub(crate) fn with_gather(mut self, rays: usize) -> Integrator<'a> {
        self.gather = (rays > 0).then(|| FinalGather::new(self.solution, self.transport, rays));
        self
    }

    /// Prepares the fields of a camera: corrections near contacts, unless H is gathered or there is a medium, in which every ray of a node would pass
    /// tens of voxels, and the irradiance of skies, unless every sample is asked for.
    pub(crate) fn look_from(&mut self, viewpoint: Viewpoint) {
        let resolves_contacts = self.gather.is_none() && self.solution.scene.voxel_grid().is_none();
        match &mut self.contacts {
            Some(contacts) => contacts.look_from(viewpoint),
            None if resolves_contacts => {
                self.contacts = Some(ContactField::new(self.solution, self.transport, viewpoint));
            }
            None => {}
        }
        let fast = self.lights.accuracy == DirectLightAccuracy::Clustered;
        let skies = || SkyField::new(self.solution, self.transport, viewpoint);
        self.skies = fast.then(skies).flatten();
    }

    /// The solution.
    pub(crate) fn solution(&self) -> &'a Solution {
        self.solution
    }

    /// Traces a ray to its end and collects the panes before it.
    pub(crate) fn trace(&self, ray: ViewRay) -> CameraRayEnd {
        let hit = self.transport.closest_hit(ray.origin, ray.dir, 0.0, f64::INFINITY);
        let distance = match &hit {
            Some(h) => h.t,
            None => (self.transport.exterior_point(ray.origin, ray.dir) - ray.origin).length(),
        };
        let panes = self.paths.pane_crossings(ray.origin, ray.at(distance));
        CameraRayEnd { hit, distance, panes }
    }

    /// The medium up to `t` metres from the origin.
    pub(crate) fn medium_segment(&self, ray: ViewRay, t: f64, sampler: RaySampler) -> MediumSegment {
        let path = self.paths.build(ray, 0.0, t, Vec::new());
        let (indirect, direct) =
            (self.indirect_radiance(ray, &path), self.direct_radiance(ray, &path, sampler));
        let last = path.segments.last().filter(|p| p.t1 >= t * (1.0 - 1e-9));
        let end_extinction = last.map_or(Bands::ZERO, |p| p.extinction);
        let field = self.medium.as_ref().zip(last).map(|(v, p)| v.at(p.zone, ray.at(t)));
        let end_source = field.map_or(Bands::ZERO, |f| end_extinction * f / PI);
        MediumSegment {
            length: t,
            inscattered: indirect + direct,
            transmittance: path.transmittance,
            end_extinction,
            end_source,
        }
    }

    /// Radiance, W/(m² sr), at the end of the medium segment of a ray.
    pub(crate) fn radiance_behind_segment(
        &self,
        ray: ViewRay,
        end: &CameraRayEnd,
        sampler: RaySampler,
    ) -> Bands {
        let last = match &end.hit {
            Some(h) => self.surface_radiance(h, ray, sampler),
            None => self.background_radiance(ray.dir),
        };
        if end.panes.is_empty() {
            return last;
        }
        let path = self.paths.build(ray, end.segment_length(), end.distance, end.panes.clone());
        let (indirect, direct) =
            (self.indirect_radiance(ray, &path), self.direct_radiance(ray, &path, sampler));
        path.transmittance * last + path.pane_radiance + indirect + direct
    }

    /// Radiance, W/(m² sr), that arrives at the origin of a ray against its direction.
    pub(crate) fn radiance(&self, ray: ViewRay, sampler: RaySampler) -> Bands {
        let end = self.trace(ray);
        let segment = self.medium_segment(ray, end.segment_length(), sampler);
        segment.in_front_of(self.radiance_behind_segment(ray, &end, sampler))
    }

    /// Radiance of the zones that arrives at the origin of a ray, W/(m² sr), without direct light, with a gather ([`FinalGather::arriving_radiance`]); `None`
    /// without one and where the ray ends on the back of a one-sided surface.
    pub(crate) fn zonal_radiance(&self, ray: ViewRay, sampler: RaySampler) -> Option<Bands> {
        let inputs = GatherInputs { paths: &self.paths, lights: &self.lights };
        self.gather.as_ref()?.arriving_radiance(inputs, ray, sampler)
    }

    /// Radiance, W/(m² sr), of surroundings and skies in a direction.
    fn background_radiance(&self, direction: Vec3) -> Bands {
        let skies = self.solution.scene.lights().iter().filter_map(Light::sky);
        let varying = skies.filter(|(_, distribution)| !distribution.is_uniform());
        self.background + varying.map(|(radiance, d)| radiance * d.relative(direction)).sum::<Bands>()
    }

    /// Radiance of a surface point.
    fn surface_radiance(&self, hit: &Hit, ray: ViewRay, sampler: RaySampler) -> Bands {
        let scene = &self.solution.scene;
        let facet = &scene.facets()[hit.facet];
        if !hit.front && scene.surfaces()[facet.surface].sides == Sides::Front {
            return Bands::ZERO;
        }
        let normal = if hit.front { facet.plate.normal() } else { -facet.plate.normal() };
        let point = facet.plate.at(hit.u, hit.v) * 0.5 + ray.at(hit.t) * 0.5;
        let emission = scene.emission_at(hit.facet, hit.u, hit.v);
        let uv = [hit.u, hit.v];
        let rho = scene.reflectance_at(hit.facet, hit.u, hit.v);
        let tau = scene.transmittance_at(hit.facet, hit.u, hit.v);
        let scattered = |fraction: Bands, side: usize, normal: Vec3| match fraction {
            Bands::ZERO => Bands::ZERO,
            _ => {
                let at = ReceiverPoint::on_facet(self.transport, hit.facet, uv, point, normal);
                fraction * self.arriving_light(side, uv, point, at, sampler)
            }
        };
        // The sides of a facet have consecutive numbers.
        let behind = scattered(tau, hit.side() ^ 1, -normal);
        (emission + scattered(rho, hit.side(), normal) + behind) / PI
    }

    /// H of all light at a point of a side of a facet with the parameters `uv`, W/m²; `at` is the point as it is shaded.
    fn arriving_light(
        &self,
        side: usize,
        uv: [f64; 2],
        point: Vec3,
        at: ReceiverPoint,
        sampler: RaySampler,
    ) -> Bands {
        let inputs = GatherInputs { paths: &self.paths, lights: &self.lights };
        let patch = self.irradiance.tile_at(side, uv);
        let indirect = match (&self.gather, patch) {
            (Some(gather), _) => gather.irradiance(inputs, at, sampler),
            (None, Some(i)) => self.interpolated_irradiance(inputs, i, point),
            (None, None) => Bands::ZERO,
        };
        // Nodes of patches are too far apart for a normal map.
        let zones = &self.solution.zones;
        let has_map = |i: &usize| {
            let shading = self.solution.scene.shading();
            !shading.maps.is_empty() && shading.map_of(zones.patches[*i].surface).is_some()
        };
        let node_patch = patch.filter(|i| !has_map(i));
        let sky = self.skies.as_ref().zip(node_patch).and_then(|(f, i)| f.irradiance(i, point));
        let skip = |light: &LightSampler| sky.is_some() && light.light().fills_sphere();
        let receiver = LitPoint { point: at.point, normal: at.normal, indirect };
        let direct = sky.unwrap_or(Bands::ZERO) + self.lights.irradiance(&receiver, sampler, &skip);
        indirect + direct
    }

    /// H interpolated between the patches and corrected near contacts at a point of patch `i`, W/m².
    fn interpolated_irradiance(&self, inputs: GatherInputs, i: usize, point: Vec3) -> Bands {
        let correction = |c: &ContactField| c.correction(inputs, &self.irradiance, i, point);
        let smooth = self.irradiance.on_tile(i, point);
        self.contacts.as_ref().map_or(smooth, |c| (smooth + correction(c)).max(Bands::ZERO))
    }

    /// Radiance of sources q in transparent voxels, Σ τ q ℓ/(4π), W/(m² sr).
    fn transparent_radiance(&self, path: &RayPath) -> Bands {
        let zones = &self.solution.zones;
        let of = |p: &VoxelSegment| {
            let source = zones.transparent_source(zones.voxel_index(p.zone));
            p.transmittance * source * ((p.t1 - p.t0) / PI)
        };
        path.segments.iter().map(of).sum()
    }

    /// Radiance of the medium without direct light, W/(m² sr).
    fn indirect_radiance(&self, ray: ViewRay, path: &RayPath) -> Bands {
        let mut out = if self.has_glow { self.transparent_radiance(path) } else { Bands::ZERO };
        let Some(field) = &self.medium else {
            return out;
        };
        for p in path.segments.iter().filter(|p| p.extinction != Bands::ZERO) {
            let length = p.t1 - p.t0;
            // Evaluate the radiosity at two Gauss points of the segment.
            let [x, y] = GAUSS.map(|g| field.at(p.zone, ray.at(p.t0 + g * length)));
            // Add the near part of the light of many emitters, which the field leaves out.
            if let Some(lights) = field.many_lights() {
                out += lights.near_inscattered(ray, p);
            }
            // Integrate the linear radiosity through the points exactly.
            for b in Band::all() {
                let slope = (y[b] - x[b]) / (length * (GAUSS[1] - GAUSS[0]));
                let start = x[b] - slope * GAUSS[0] * length;
                out[b] +=
                    p.transmittance[b] * linear_source_integral(p.extinction[b], length, start, slope) / PI;
            }
        }
        out
    }

    /// Radiance of direct light scattered along the path, W/(m² sr).
    fn direct_radiance(&self, ray: ViewRay, path: &RayPath, sampler: RaySampler) -> Bands {
        let many_lights_in_field = self.medium.as_ref().is_some_and(|v| v.many_lights().is_some());
        let skip = |light: &LightSampler| {
            (many_lights_in_field && light.is_clustered())
                || (self.medium_has_skies && light.light().fills_sphere())
        };
        self.lights.inscattered(ray, path, sampler, &skip)
    }
}

#[cfg(test)]
impl<'a> Integrator<'a> {
    /// The same with every emitter sampled by points only, as a reference.
    pub(crate) fn with_sampled_lights_only(mut self) -> Integrator<'a> {
        self.lights.disable_analytic_area_lights();
        self.medium = RadiosityField::new(self.solution, self.transport, None);
        self
    }

    fn path_between(&self, ray: ViewRay, length: f64) -> RayPath {
        let panes = self.paths.pane_crossings(ray.origin, ray.at(length));
        self.paths.build(ray, 0.0, length, panes)
    }

    /// Direct light scattered between two points, from `count` samples, with the indirect light of the medium.
    pub(crate) fn scattered(&self, ray: ViewRay, length: f64, count: usize) -> Bands {
        let path = self.path_between(ray, length);
        let direct = self.direct_radiance(ray, &path, RaySampler::of_ray(0, count, [0.3, 0.6, 0.9]));
        let medium = self.indirect_radiance(ray, &path);
        direct + medium
    }

    /// Light of suns by their deep shadow maps, scattered between two points.
    pub(crate) fn scattered_by_suns(&self, ray: ViewRay, length: f64, sampler: RaySampler) -> Bands {
        self.lights.inscattered_by_shadow_maps(ray, &self.path_between(ray, length), sampler)
    }

    /// Light of one point of a light, scattered between two points.
    pub(crate) fn scattered_exactly(
        &self,
        ray: ViewRay,
        length: f64,
        source: &zonal_transport::lights::EmissionSample,
    ) -> Bands {
        self.lights.inscattered_by_sample(ray, &self.path_between(ray, length), source)
    }
}
