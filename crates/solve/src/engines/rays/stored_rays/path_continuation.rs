//! Continuation of rays from patches that they hit close by: radiation that varies within a patch.
//!
//! A zone has one radiosity. In a crease, below a ledge or behind an ornament that nearly touches a wall, the point that a ray hits is
//! darker than the mean of its patch. A ray from a patch that hits patch j at x close by ([`zonal_scene::Patch::continues_rays`]) continues from x in a
//! direction of cosine density and ends in another zone k. One shadow ray goes to a light l of the patch, chosen with probability p_l (next-event estimation, pbrt):
//!
//! ```text
//! B(x) = B⁰_j + ρ_j (H_l(x)/p_l + B_k)        B⁰_j the source term of patch j without the lights sampled here
//! ```
//!
//! replaces B_j. From the second patch on ρ_j is that of the texture at x; the first is that of the gather (`gather::point_light`). The estimate is unbiased
//! for the radiosity at x, whose mean over the patch is B_j. The path may continue again at k.
//! A continued ray costs one further ray and one shadow ray for each vertex.

use super::padded_bands::{LANES, PaddedBands, padded_f32};
use super::ray_tracer::{FIRST_CODE, RAY_SEED, RayEnd, RayNumber, RayTracer};
use crate::engines::rays::weighted_choice;
use crate::right_hand_side::direct_light::light_field::DirectLight;
use zonal_math::direction_sampling::cosine_hemisphere;
use zonal_math::{Vec3, low_discrepancy};
use zonal_scene::{Bands, Patch, PerBand, Scene};
use zonal_transport::Transport;
use zonal_transport::lights::{LightSampler, Receiver};

/// Most vertices of a path from a patch. A volume zone averages over more of a close patch, so its rays do not continue.
const MAX_PATH_VERTICES: u64 = 8;

/// Bit that marks the index of a vertex in place of a zone.
const VERTEX_FLAG: u32 = 1 << 31;
/// Light index of a vertex without light.
const NO_LIGHT: u32 = u32::MAX;
/// Zones whose vertices are stored in one list.
pub(crate) const ZONES_PER_BLOCK: usize = 256;

/// A point at which a ray continues.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathVertex {
    /// The patch hit.
    patch: u32,
    /// The end of the next segment: a zone, another vertex, or no zone.
    next: u32,
    /// The light sampled.
    light: u32,
    /// H of the light over its probability, W/m².
    light_irradiance: PerBand<f32>,
    /// Weight of the next segment.
    weight: PerBand<f32>,
}

impl PathVertex {
    /// Words of a vertex in a checkpoint.
    pub(crate) const WORDS_PER_VERTEX: usize = 9;
    /// The vertex as words.
    pub(crate) fn words(&self) -> [u32; 9] {
        let [light, weight] = [self.light_irradiance, self.weight].map(|v| v.map(f32::to_bits));
        let ([a, b, c], [d, e, f]) = (light.into_rgb(), weight.into_rgb());
        [self.patch, self.next, self.light, a, b, c, d, e, f]
    }
    /// The vertex of these words.
    pub(crate) fn from_words([patch, next, light, a, b, c, d, e, f]: [u32; 9]) -> PathVertex {
        let [light_irradiance, weight] =
            [[a, b, c], [d, e, f]].map(|v| PerBand::from_rgb(v).map(f32::from_bits));
        PathVertex { patch, next, light, light_irradiance, weight }
    }
    /// Share of a radiosity that the vertex passes on from its next segment.
    pub(crate) fn passed_on(&self, patches: &[Patch]) -> Bands {
        patches[self.patch as usize].reflectance * self.weight.map(f64::from)
    }
    /// The end of the next segment.
    pub(crate) fn next(&self) -> u32 {
        self.next
    }
    /// True where the patch exists among `patches` patches.
    pub(crate) fn has_patch_below(&self, patches: usize) -> bool {
        (self.patch as usize) < patches
    }
}

/// Bytes of a vertex.
pub(crate) const VERTEX_BYTES: usize = size_of::<PathVertex>();

/// The index of the vertex that an end refers to; `None` for a zone or a code.
pub(crate) fn vertex_index(end: u32) -> Option<usize> {
    (VERTEX_FLAG..FIRST_CODE).contains(&end).then_some((end & !VERTEX_FLAG) as usize)
}

/// The zone that a ray hits first.
pub(crate) fn first_zone(end: u32, vertices: &[PathVertex]) -> u32 {
    vertex_index(end).map_or(end, |v| vertices[v].patch)
}

/// The source term at path vertices, of one column.
#[derive(Clone, Debug, Default)]
pub(crate) struct VertexSource {
    /// B⁰ of the patches without the lights sampled at vertices, W/m².
    pub patches: Vec<PaddedBands>,
    /// Factor on each light.
    pub lights: Vec<f32>,
}

impl VertexSource {
    /// Adds `factor` times `other`.
    pub(crate) fn add_scaled(&mut self, other: &VertexSource, factor: f32) {
        self.patches.resize(other.patches.len(), [0.0; LANES]);
        self.lights.resize(other.lights.len(), 0.0);
        for (o, z) in self.patches.iter_mut().zip(&other.patches) {
            (0..LANES).for_each(|k| o[k] += factor * z[k]);
        }
        self.lights.iter_mut().zip(&other.lights).for_each(|(o, l)| *o += factor * l);
    }
}

/// The vertices and radiosities that the contribution of a path depends on.
pub(crate) struct PathField<'a> {
    /// Vertices of the block.
    pub vertices: &'a [PathVertex],
    /// ρ of the patches.
    pub reflectance: &'a [PaddedBands],
    /// B of the zones, W/m².
    pub radiosity: &'a [PaddedBands],
    /// Source term at the vertices; `None` leaves it out.
    pub source: Option<&'a VertexSource>,
}

impl PathField<'_> {
    /// Radiosity that a ray of weight `weight` transports from vertex `first` on.
    pub(crate) fn transported(&self, first: usize, weight: PaddedBands) -> PaddedBands {
        let (mut throughput, mut sum, mut next) = (weight, [0.0; LANES], Some(first));
        while let Some(at) = next {
            let vertex = &self.vertices[at];
            let rho = self.reflectance[vertex.patch as usize];
            // Add the source term and the light sampled at the vertex.
            if let Some(source) = self.source {
                let light = source.lights.get(vertex.light as usize).copied().unwrap_or(0.0);
                let b = source.patches[vertex.patch as usize];
                let light_irradiance = padded_f32(vertex.light_irradiance);
                (0..LANES).for_each(|k| {
                    sum[k] += throughput[k] * (b[k] + rho[k] * light * light_irradiance[k]);
                });
            }
            // Continue with the reflected part; the last segment adds the radiosity of its zone.
            let weight = padded_f32(vertex.weight);
            (0..LANES).for_each(|k| throughput[k] *= rho[k] * weight[k]);
            next = vertex_index(vertex.next);
            if next.is_none() && vertex.next < FIRST_CODE {
                let b = self.radiosity[vertex.next as usize];
                (0..LANES).for_each(|k| sum[k] += throughput[k] * b[k]);
            }
        }
        sum
    }
}

/// The lights of the scene, for next-event estimation at path vertices.
pub(crate) struct PathLights<'a> {
    samplers: Vec<LightSampler<'a>>,
    direct: &'a DirectLight,
}

impl<'a> PathLights<'a> {
    /// Lights of the scene; `direct` gives the probabilities of their choice.
    pub(crate) fn new(scene: &'a Scene, direct: &'a DirectLight) -> PathLights<'a> {
        PathLights { samplers: scene.lights().iter().map(|l| LightSampler::new(scene, l)).collect(), direct }
    }

    /// A light at `x` on patch `j`, chosen in proportion to its direct irradiance of the patch, and its H at x over the probability;
    /// `u` in [0,1)⁴.
    fn sample(&self, tracer: &RayTracer, j: usize, x: Vec3, u: [f64; 4]) -> (u32, PerBand<f32>) {
        let weight = |l: usize| self.direct.lights[l].fields[j].iter().fold(0.0f64, |m, v| m.max(*v));
        let total: f64 = (0..self.samplers.len()).map(weight).sum();
        if total <= 0.0 {
            return (NO_LIGHT, PerBand::splat(0.0));
        }
        let lights = (0..self.samplers.len()).map(|l| (l, weight(l)));
        let Some(chosen) = weighted_choice::choose(lights, u[3] * total) else {
            return (NO_LIGHT, PerBand::splat(0.0));
        };
        let p = weight(chosen) / total;
        let receiver = Receiver::Surface(tracer.zones.patches[j].normal);
        let light = self.incident(tracer.transport, chosen, x, receiver, [u[0], u[1], u[2]]);
        (chosen as u32, light.map(|h| (h / p) as f32))
    }

    /// H or G of light `l` at a point by the sample at `u`, W/m².
    pub(crate) fn incident(
        &self,
        transport: &Transport,
        l: usize,
        x: Vec3,
        receiver: Receiver,
        u: [f64; 3],
    ) -> Bands {
        let sampler = &self.samplers[l];
        let sample = sampler.sample_at(transport, x, receiver, u);
        sample.and_then(|s| sampler.attenuated(transport, x, &s)).unwrap_or_default()
    }

    /// The lights.
    pub(crate) fn samplers(&self) -> &[LightSampler<'a>] {
        &self.samplers
    }

    /// Their light on all zones.
    pub(crate) fn direct(&self) -> &'a DirectLight {
        self.direct
    }
}

impl RayTracer<'_> {
    /// The patch from which a ray with this end continues.
    fn continuing_patch(&self, end: &RayEnd) -> Option<usize> {
        let patch = self.zones.patches.get(end.zone as usize)?;
        // The radiosity of a sheet depends on the light behind it too.
        let i = end.zone as usize;
        (patch.continues_rays(end.distance) && self.zones.sheets.opposite(i).is_none()).then_some(i)
    }

    /// Continues a ray from its end and appends the vertices. Returns the zone or the first vertex of the path, and the end of its last segment.
    pub(crate) fn continue_path(
        &self,
        lights: &PathLights,
        ray: RayNumber,
        mut end: RayEnd,
        vertices: &mut Vec<PathVertex>,
    ) -> (u32, RayEnd) {
        let first = end.zone;
        let zone_hash = low_discrepancy::split_mix64(ray.zone as u64 ^ RAY_SEED);
        let seed = low_discrepancy::split_mix64(zone_hash.wrapping_add(ray.number as u64));
        let mut head = None;
        let max_vertices = if ray.zone < self.zones.patches.len() { MAX_PATH_VERTICES } else { 0 };
        for depth in 0..max_vertices {
            let Some(j) = self.continuing_patch(&end) else { break };
            // Independent numbers: a rotation of the ray's first numbers would correlate its end with its start.
            let uniform = |m: u64| low_discrepancy::hash_to_unit(seed.wrapping_add(depth << 3 | m));
            let (x, normal) = (end.position, self.zones.patches[j].normal);
            let (light, light_irradiance) =
                lights.sample(self, j, x, [uniform(0), uniform(1), uniform(2), uniform(3)]);
            let next = self.trace(x, cosine_hemisphere(normal, [uniform(4), uniform(5)]), uniform(6));
            let number = VERTEX_FLAG | vertices.len() as u32;
            if head.is_none() {
                head = Some(number);
            } else if let Some(last) = vertices.last_mut() {
                last.next = number;
                let texture = self.texture_ratio(j, x);
                last.weight = PerBand::from_fn(|b| last.weight[b] * texture[b] as f32);
            }
            let weight = next.weight;
            vertices.push(PathVertex { patch: end.zone, next: next.zone, light, light_irradiance, weight });
            end = next;
        }
        (head.unwrap_or(first), end)
    }
}
