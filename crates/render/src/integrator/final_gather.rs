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

use super::ray_sampler::RaySampler;
use crate::medium::path_builder::PathBuilder;
use crate::medium::radiosity_field::RadiosityField;
use crate::surface::patch_field::PatchField;
use crate::surface::tiles::patch_field;
use crate::view_ray::ViewRay;
use std::f64::consts::PI;
use zonal_math::{Vec3, direction_sampling, low_discrepancy};
use zonal_scene::{Bands, Sides, Solution};
use zonal_transport::Transport;

/// Optical depth below which a segment takes the mean of its zone in place of the interpolated value.
const MAX_DEPTH_OF_ZONE_MEAN: f64 = 0.1;

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
        let (first, last) = (s.zones.voxel_offset(), s.zones.pane_offset());
        let radiosity = &s.fields.radiosity;
        FinalGather {
            solution: s,
            transport,
            rays,
            surfaces: patch_field(s, transport, radiosity),
            medium: RadiosityField::from_means(s, transport, radiosity[first..last].to_vec()),
            means: &radiosity[first..last],
        }
    }

    /// H without direct light, W/m², at a surface point with the unit normal `normal`.
    pub(crate) fn irradiance(
        &self,
        paths: &PathBuilder,
        point: Vec3,
        normal: Vec3,
        sampler: RaySampler,
    ) -> Bands {
        let ray = sampler.ray_index();
        let mut sum = Bands::ZERO;
        for i in 0..self.rays {
            let at = low_discrepancy::r2(ray * self.rays + i, [sampler.shift[1], sampler.shift[2]]);
            let gather_ray =
                ViewRay { origin: point, dir: direction_sampling::cosine_hemisphere(normal, at) };
            sum += self.zonal_radiance(paths, gather_ray);
        }
        sum * PI / self.rays as f64
    }

    /// Radiance, W/(m² sr), of the zones along a ray.
    fn zonal_radiance(&self, paths: &PathBuilder, ray: ViewRay) -> Bands {
        let hit = self.transport.closest_hit(ray.origin, ray.dir, 0.0, f64::INFINITY);
        let exterior_point = || (self.transport.exterior_point(ray.origin, ray.dir) - ray.origin).length();
        let end = hit.map_or_else(exterior_point, |h| h.t);
        let last = self.end_radiance(ray, hit);
        let panes = paths.pane_crossings(ray.origin, ray.at(end));
        if !panes.is_empty() {
            let path = paths.build(ray, (0.0, end), panes);
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
    fn end_radiance(&self, ray: ViewRay, hit: Option<zonal_transport::Hit>) -> Bands {
        let scene = &self.solution.scene;
        match hit {
            None => scene.surroundings().radiance,
            Some(h)
                if !h.front && scene.surfaces()[scene.facets()[h.facet].surface].sides == Sides::Front =>
            {
                Bands::ZERO
            }
            Some(h) => {
                let b = self.surfaces.at(2 * h.facet + usize::from(!h.front), [h.u, h.v], ray.at(h.t));
                b.unwrap_or(Bands::ZERO) / PI
            }
        }
    }

    /// Radiance, W/(m² sr), that a segment of a ray in a voxel zone emits and scatters, at its border. Optically thin segments take the
    /// zone's mean.
    fn segment_radiance(&self, zone: usize, kappa: Bands, length: f64, middle: Vec3) -> Bands {
        if kappa == Bands::ZERO {
            return kappa;
        }
        let thin = kappa.all(|k| k * length < MAX_DEPTH_OF_ZONE_MEAN);
        let radiosity = match self.medium.as_ref().filter(|_| !thin) {
            Some(field) => field.at(zone, middle),
            None => self.means[zone],
        };
        let passed = transmittance(kappa, length);
        radiosity * (1.0 - passed) / PI
    }
}

/// e^{−κℓ}.
fn transmittance(kappa: Bands, length: f64) -> Bands {
    if kappa.is_grey() {
        return Bands::splat((-kappa.first() * length).exp());
    }
    (-kappa * length).exp()
}
