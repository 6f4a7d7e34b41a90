//! Light at a point of a patch: the interpolated irradiance, and the direct light sampled there.
//!
//! Every point has 1 + n values per band: H_ind of all groups together, then H_dir of each of the n groups whose lights are sampled. All
//! points take the same samples of a light, so that soft shadows show fine steps in place of noise. Shadow rays are traced by the
//! light sampler (`gather`).

use super::group_fields::GroupField;
use super::lit_scene::LitScene;
use crate::surface::curved_facets::CurvedFacets;
use crate::surface::patch_field::{TileField, TileTopology};
use crate::surface::shading::ReceiverPoint;
use crate::surface::tiles::patch_tiles;
use zonal_math::Vec3;
use zonal_math::parallel;
use zonal_scene::{Band, Bands, PerBand, Solution};
use zonal_transport::Transport;
use zonal_transport::lights::{LightSampler, Receiver};

/// Share of the way from a border to the centre of a patch at which direct light is sampled, so that walls on the border occlude it.
const BORDER_INSET: f64 = 1e-3;
/// Samples of a sky that shares a group, over those of other lights: it fills the hemisphere.
const SKY_SAMPLE_FACTOR: usize = 16;

/// Evaluates the light at points of patches.
pub(super) struct VertexLighting<'a> {
    pub topology: TileTopology<'a>,
    pub solution: &'a Solution,
    curved: CurvedFacets,
    /// Shadow rays in the scene with the images of symmetry planes.
    transport: &'a Transport<'a>,
    /// H_ind of all groups together; `None` where it is zero.
    indirect: Option<TileField>,
    /// The index of the value to which each light adds, the light and its number of samples.
    light_samplers: Vec<(usize, LightSampler<'a>, usize)>,
    /// For each group the index of its direct light among the values, where it is sampled.
    pub slots: Vec<Option<usize>>,
    /// Largest band of the mean of each value over the patches by area, W/m².
    pub means: Vec<f64>,
    /// For each value true where the solution has its mean over a patch: direct light of a group without separate suns.
    pub has_zone_mean: Vec<bool>,
}

impl<'a> VertexLighting<'a> {
    /// Prepares the lights of `lit`, for which `shadow_rays` traces, and the field of all groups together.
    pub(super) fn new(
        s: &'a Solution,
        transport: &'a Transport<'a>,
        lit: &'a LitScene<'a>,
        shadow_rays: &'a Transport<'a>,
        groups: &[GroupField],
        samples: usize,
    ) -> VertexLighting<'a> {
        let (mut light_samplers, mut slots, mut used) = (Vec::new(), vec![None; groups.len()], 1);
        for (g, group) in groups.iter().enumerate().filter(|(_, g)| !g.is_smooth()) {
            for light in lit.lights_of(group.kind) {
                let slot = *slots[g].get_or_insert(used);
                used = slot + 1;
                let n = if light.fills_sphere() { SKY_SAMPLE_FACTOR * samples } else { samples };
                light_samplers.push((slot, LightSampler::new(&lit.scene, light), n));
            }
        }
        let patches = s.zones.patches.len();
        let indirect = |i: usize| groups.iter().map(|g| interpolated(g, i)).sum::<Bands>();
        let values: Vec<Bands> = parallel::collect(patches, indirect);
        let (mut means, mut has_zone_mean) = (vec![mean(s, |i| values[i])], vec![false]);
        for (g, group) in groups.iter().enumerate().filter(|(g, _)| slots[*g].is_some()) {
            debug_assert_eq!(slots[g], Some(means.len()));
            means.push(mean(s, |i| group.direct(i)));
            has_zone_mean.push(!lit.has_separate_sun(group.kind));
        }
        let curved = CurvedFacets::of(s);
        let topology = TileTopology::new(patch_tiles(s), Some(transport));
        VertexLighting {
            topology,
            solution: s,
            indirect: on_curved_surfaces(&curved, values),
            curved,
            transport: shadow_rays,
            light_samplers,
            slots,
            means,
            has_zone_mean,
        }
    }

    /// Number of values a point.
    pub(super) fn value_count(&self) -> usize {
        self.means.len()
    }

    /// Appends the values at a point of a patch, given by the patch's parameters (u, v).
    pub(super) fn evaluate(&self, patch: usize, uv: [f64; 2], out: &mut Vec<PerBand<f32>>) {
        let first = out.len();
        let indirect = self.indirect.as_ref().map(|field| field.at(&self.topology, patch, uv));
        out.push(indirect.unwrap_or_default().map(|x| x as f32));
        out.resize(first + self.value_count(), PerBand::default());
        let p = &self.solution.zones.patches[patch];
        let point = self.point(patch, uv);
        let inside = point + (p.plate.centre() - point) * BORDER_INSET;
        let sheets = &self.solution.zones.sheets;
        let (rho, tau) = (p.reflectance, sheets.transmittance(patch));
        let is_sheet = sheets.opposite(patch).is_some();
        for (slot, light_sampler, n) in &self.light_samplers {
            let on = |normal: Vec3| {
                let at = ReceiverPoint::without_map(self.transport, p.facet, inside, normal);
                light_sampler.gather(self.transport, at.point, Receiver::Surface(at.normal), *n, 1)
            };
            let mut light = on(p.normal);
            if is_sheet {
                let sum = rho * light + tau * on(-p.normal);
                light = sum.zip_map(rho + tau, |s, w| if w > 0.0 { s / w } else { 0.0 });
            }
            let sum = &mut out[first + slot];
            Band::all().for_each(|b| sum[b] += light[b] as f32);
        }
    }

    /// H at a point of a patch, given by the patch's parameters (u, v), of all groups together, direct light included, W/m².
    pub(super) fn irradiance(&self, patch: usize, uv: [f64; 2]) -> Bands {
        let mut values = Vec::with_capacity(self.value_count());
        self.evaluate(patch, uv, &mut values);
        values.iter().map(|v| v.map(f64::from)).sum()
    }

    /// The field with these means, one a patch, as curved surfaces have them; `None` where all are zero.
    pub(super) fn field_unless_zero(&self, values: Vec<Bands>) -> Option<TileField> {
        on_curved_surfaces(&self.curved, values)
    }

    /// The point of a patch with the patch's parameters, m.
    pub(super) fn point(&self, patch: usize, [u, v]: [f64; 2]) -> Vec3 {
        self.solution.zones.patches[patch].plate.at(u, v)
    }

    /// The means of the values over a patch in the solution; only direct light that is sampled.
    pub(super) fn zone_means(&self, groups: &[GroupField], patch: usize) -> Vec<Bands> {
        let mut out = vec![Bands::ZERO; self.value_count()];
        for (group, slot) in groups.iter().zip(&self.slots) {
            if let Some(slot) = slot {
                out[*slot] = group.direct(patch);
            }
        }
        out
    }
}

/// The field with these means, one a patch, as curved surfaces have them; `None` where all are zero.
fn on_curved_surfaces(curved: &CurvedFacets, mut values: Vec<Bands>) -> Option<TileField> {
    curved.adjust(&mut values);
    values.iter().any(|v| *v != Bands::ZERO).then(|| TileField::new(values))
}

/// The part of a group that is interpolated on a patch, W/m².
pub(super) fn interpolated(group: &GroupField, patch: usize) -> Bands {
    if group.is_smooth() { group.fluence(patch) } else { group.incident(patch) }
}

/// Largest band of the mean over the patches by area, W/m².
fn mean(s: &Solution, value: impl Fn(usize) -> Bands) -> f64 {
    let (mut sum, mut area) = (Bands::ZERO, 0.0);
    for (i, p) in s.zones.patches.iter().enumerate() {
        sum += value(i) * p.area;
        area += p.area;
    }
    sum.into_iter().fold(0.0, f64::max) / f64::max(area, 1e-300)
}
