//! Final gather: the indirect irradiance of a surface point by rays, in place of the interpolated one.
//!
//! ```text
//! H = π/N Σ_i L(ω_i),   ω_i of cosine density:   L = Σ_k τ_k ∫ κ e^{−κs} B/π ds + Σ_panes + τ_end B_end/π
//! ```
//!
//! B is the interpolated radiosity, direct light included, of the zones along a ray and at its end; rays that leave the scene see the
//! radiance of the surroundings. Skies and emitters that count as lights are excluded: their light is direct. The gather resolves
//! creases and contact shadows that the patches average, and no light comes through walls. The rays of a point are a shifted R₂
//! sequence, the shift a hash of the pixel. Method: final gather of radiosity solutions (Cohen & Wallace, *Radiosity and Realistic
//! Image Synthesis*, 1993). Cost: N rays a surface point.
//!
//! A ray that hits a patch close by (`Patch::continues_rays`), as do the rays of a solve, sees the radiosity of the point hit, which the patch averages:
//! light is sampled there, and the ray goes on in a direction of cosine density,
//!
//! ```text
//! B(y) = E + ρ (H_dir(y) + π L(ω))
//! ```

use super::direct_light::{DirectLights, LitPoint};
use super::ray_sampler::RaySampler;
use crate::medium::path_builder::PathBuilder;
use crate::medium::radiosity_field::RadiosityField;
use crate::surface::patch_field::PatchField;
use crate::surface::shading::ReceiverPoint;
use crate::surface::tiles::patch_field;
use crate::view_ray::ViewRay;
use std::f64::consts::PI;
use zonal_math::{Vec3, direction_sampling, low_discrepancy};
use zonal_scene::{Bands, Sides, Solution};
use zonal_transport::{Hit, Transport};

/// Optical depth below which a segment takes the mean of its zone in place of the interpolated value.
const MAX_DEPTH_OF_ZONE_MEAN: f64 = 0.1;

/// Most vertices of a ray that goes on.
const MAX_VERTICES: usize = 4;

/// The inputs of a gather other than its own fields.
#[derive(Clone, Copy)]
pub(crate) struct GatherInputs<'b> {
    /// Segments of rays.
    pub paths: &'b PathBuilder<'b>,
    /// Lights at the points where rays go on.
    pub lights: &'b DirectLights<'b>,
}

/// A ray of a gather: its number, which all its random numbers derive from, and its vertices so far.
#[derive(Clone, Copy)]
struct GatherRay {
    ray: ViewRay,
    sampler: RaySampler,
    vertices: usize,
}

/// H at a point, and how near the surfaces about it are.
#[derive(Clone, Copy)]
pub(crate) struct GatheredIrradiance {
    /// H without direct light, W/m².
    pub irradiance: Bands,
    /// Mean of (1 − t/reach)⁺ over the rays of length t.
    pub nearness: f64,
}

/// Fields that gather rays look up.
pub(crate) struct FinalGather<'a> {
    solution: &'a Solution,
    transport: &'a Transport<'a>,
    rays: usize,
    surfaces: PatchField<'a>,
    medium: Option<RadiosityField<'a>>,
    /// B of the voxel zones, W/m².
    means: &'a [Bands],
}

impl<'a> FinalGather<'a> {
    /// Prepares the fields for `rays` rays a point.
    pub(crate) fn new(s: &'a Solution, transport: &'a Transport<'a>, rays: usize) -> FinalGather<'a> {
        let [_, voxels, _] = s.zones.ranges_of_kinds();
        let radiosity = &s.fields.radiosity;
        FinalGather {
            solution: s,
            transport,
            rays,
            surfaces: patch_field(s, transport, radiosity),
            medium: RadiosityField::from_means(s, transport, radiosity[voxels.clone()].to_vec()),
            means: &radiosity[voxels],
        }
    }

    /// H without direct light, W/m², at a surface point.
    pub(crate) fn irradiance(&self, inputs: GatherInputs, at: ReceiverPoint, sampler: RaySampler) -> Bands {
        self.irradiance_and_nearness(inputs, at, f64::MAX, sampler).irradiance
    }

    /// The same with the nearness of surfaces within `reach` metres.
    pub(crate) fn irradiance_and_nearness(
        &self,
        inputs: GatherInputs,
        surface: ReceiverPoint,
        reach: f64,
        sampler: RaySampler,
    ) -> GatheredIrradiance {
        let ray = sampler.ray_index();
        let (mut sum, mut near) = (Bands::ZERO, 0.0);
        for i in 0..self.rays {
            let number = ray * self.rays + i;
            let at = low_discrepancy::r2(number, [sampler.shift[1], sampler.shift[2]]);
            let dir = surface.above_facet(direction_sampling::cosine_hemisphere(surface.normal, at));
            let ray = ViewRay { origin: surface.point, dir };
            let sampler = RaySampler::of_ray(number, 1, sampler.shift);
            let (radiance, length) = self.zonal_radiance(inputs, GatherRay { ray, sampler, vertices: 0 });
            sum += radiance;
            near += (1.0 - length / reach).max(0.0);
        }
        let n = self.rays as f64;
        GatheredIrradiance { irradiance: sum * PI / n, nearness: near / n }
    }

    /// Radiance of the zones that arrives at the origin of a ray, W/(m² sr), without direct light; `None` where the ray ends on the back of a one-sided
    /// surface.
    pub(crate) fn arriving_radiance(
        &self,
        inputs: GatherInputs,
        ray: ViewRay,
        sampler: RaySampler,
    ) -> Option<Bands> {
        let hit = self.transport.closest_hit(ray.origin, ray.dir, 0.0, f64::INFINITY);
        if hit.as_ref().is_some_and(|h| self.is_unlit_back(h)) {
            return None;
        }
        let last = self.end_radiance(inputs, GatherRay { ray, sampler, vertices: 0 }, hit);
        Some(self.radiance_of_path(inputs.paths, ray, hit, last))
    }

    /// True for the back of a one-sided surface.
    fn is_unlit_back(&self, hit: &Hit) -> bool {
        let scene = &self.solution.scene;
        !hit.front && scene.surfaces()[scene.facets()[hit.facet].surface].sides == Sides::Front
    }

    /// Radiance, W/(m² sr), of the zones along a ray, and its length, m; infinite where it leaves the scene.
    fn zonal_radiance(&self, inputs: GatherInputs, gather_ray: GatherRay) -> (Bands, f64) {
        let ray = gather_ray.ray;
        let hit = self.transport.closest_hit(ray.origin, ray.dir, 0.0, f64::INFINITY);
        let last = self.end_radiance(inputs, gather_ray, hit);
        (self.radiance_of_path(inputs.paths, ray, hit, last), hit.map_or(f64::INFINITY, |h| h.t))
    }

    /// Radiance, W/(m² sr), of a ray with the radiance `last` at its end.
    fn radiance_of_path(&self, paths: &PathBuilder, ray: ViewRay, hit: Option<Hit>, last: Bands) -> Bands {
        let exterior_point = || (self.transport.exterior_point(ray.origin, ray.dir) - ray.origin).length();
        let end = hit.map_or_else(exterior_point, |h| h.t);
        let panes = paths.pane_crossings(ray.origin, ray.at(end));
        if !panes.is_empty() {
            let path = paths.build(ray, 0.0, end, panes);
            let mut out = path.transmittance * last + path.pane_radiance;
            for p in &path.segments {
                let l = self.segment_radiance(p.zone, p.extinction, p.t1 - p.t0, ray.at(0.5 * (p.t0 + p.t1)));
                out += p.transmittance * l;
            }
            return out;
        }
        let (mut out, mut tau) = (Bands::ZERO, Bands::ONE);
        self.transport.traverse_grid(ray.origin, ray.at(end), &mut |cell, t0, t1| {
            let middle = ray.at(0.5 * (t0 + t1));
            if let Some(zone) = self.transport.volume_zone_at(&self.solution.zones, cell, middle) {
                let kappa = self.solution.zones.voxels.at(zone).extinction;
                let l = self.segment_radiance(zone, kappa, t1 - t0, middle);
                out += tau * l;
                tau *= transmittance(kappa, t1 - t0);
            }
        });
        out + tau * last
    }

    /// Radiance, W/(m² sr), at the end of a ray.
    fn end_radiance(&self, inputs: GatherInputs, gather_ray: GatherRay, hit: Option<Hit>) -> Bands {
        let scene = &self.solution.scene;
        let Some(h) = hit else { return scene.surroundings().radiance };
        if self.is_unlit_back(&h) {
            return Bands::ZERO;
        }
        let tile = self.surfaces.tile_at(h.side(), [h.u, h.v]);
        let Some(i) = tile else { return Bands::ZERO };
        let patch = &self.solution.zones.patches[i];
        let point = gather_ray.ray.at(h.t);
        let radiosity = self.surfaces.on_tile(i, point);
        let is_sheet = self.solution.zones.sheets.opposite(i).is_some();
        if is_sheet || !patch.continues_rays(h.t) || gather_ray.vertices >= MAX_VERTICES {
            return radiosity / PI;
        }
        let reflectance = scene.reflectance_at(h.facet, h.u, h.v);
        let sampler = gather_ray.sampler;
        let receiver = LitPoint { point, normal: patch.normal, indirect: radiosity };
        let direct = inputs.lights.irradiance(&receiver, sampler, &|_| false);
        let number = (sampler.ray_index() * MAX_VERTICES + gather_ray.vertices) as u64;
        let uniform = |k: usize| {
            let hash = low_discrepancy::hash_to_unit(number << 1 | k as u64);
            (hash + sampler.shift[k]).fract()
        };
        let dir = direction_sampling::cosine_hemisphere(patch.normal, [uniform(0), uniform(1)]);
        let ray = ViewRay { origin: point, dir };
        let next = GatherRay { ray, vertices: gather_ray.vertices + 1, ..gather_ray };
        patch.emission / PI + reflectance * (direct / PI + self.zonal_radiance(inputs, next).0)
    }

    /// Radiance, W/(m² sr), that a segment of a ray in a voxel zone emits and scatters, at its border. Optically thin segments take the
    /// zone's mean.
    fn segment_radiance(&self, zone: usize, kappa: Bands, length: f64, middle: Vec3) -> Bands {
        let glow = self.solution.zones.transparent_source(self.solution.zones.voxel_index(zone));
        let glow = glow * (length / PI);
        if kappa == Bands::ZERO {
            return glow;
        }
        let thin = kappa.all(|k| k * length < MAX_DEPTH_OF_ZONE_MEAN);
        let radiosity = match self.medium.as_ref().filter(|_| !thin) {
            Some(field) => field.at(zone, middle),
            None => self.means[zone],
        };
        let passed = transmittance(kappa, length);
        radiosity * (1.0 - passed) / PI + glow
    }
}

/// e^{−κℓ}.
fn transmittance(kappa: Bands, length: f64) -> Bands {
    if kappa.is_grey() {
        return Bands::splat((-kappa.first() * length).exp());
    }
    (-kappa * length).exp()
}
