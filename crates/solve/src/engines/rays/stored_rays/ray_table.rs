//! The ray table: the zones in which the rays of every zone end, and the radiation that they transport.
//!
//! A ray of zone i has the density of the kernel of i (cosine on a patch, isotropic in a volume). It ends in one zone: the volume zone
//! in which the medium absorbs it, otherwise a patch; or it escapes. With m rays that end in the zones j,
//!
//! ```text
//! H_i = ⟨B_j⟩      G_i = 4 ⟨B_j⟩      B_i = B⁰_i + ρ_i ⟨B_j⟩     (Ω_i for ρ_i in a volume)
//! ```
//!
//! which is the Monte Carlo estimate of the exchange factors of row i (Howell). Every ray ends once, so every row closes exactly, and a
//! wall between two zones separates them at any distance. The error is noise: it falls as 1/√m. Panes absorb rays as the medium does and
//! emit rays of their own; the fraction that a pane absorbs of its own emission closes its row.
//!
//! Bands of different extinction share one ray, sampled by their mean; each has a weight, its own probability over that of the ray.
//!
//! **Ranks.** The table is cut into stages of consecutive zones of a kind; a rank holds the rays of its own stages. A product computes its rows on the rank that
//! has their rays, and every rank receives all of them.
//!
//! **Cost.** 4 bytes a ray, 12 more where the bands differ, and [`VERTEX_BYTES`](super::path_continuation::VERTEX_BYTES) a path vertex.

use super::padded_bands::{LANES, PaddedBands, padded, padded_f32, without_padding};
use super::path_continuation::{
    PathField, PathLights, PathVertex, VertexSource, ZONES_PER_BLOCK, first_zone, vertex_index,
};
use super::ray_checkpoint;
use super::ray_sampling::RaysPerZone;
use super::ray_tracer::{BACK_FACE, ESCAPED, FIRST_CODE, NO_ZONE, RayNumber, RayTracer};
use crate::context::SolveContext;
use crate::distribution::{Blocks, Communicator, Message};
use crate::right_hand_side::surroundings::SurroundingsExchange;
use rayon::prelude::*;
use std::ops::Range;
use zonal_exchange::pair::closure_target;
use zonal_scene::{Bands, PerBand, Zones};

/// The ends of the rays of every zone.
pub(crate) struct RayTable<'a> {
    communicator: &'a dyn Communicator,
    /// Number of patches.
    patches: usize,
    /// Stages of the patches, and of the volume zones.
    stages: [Blocks; 2],
    rays_per_zone: RaysPerZone,
    /// Rays of the own patches; those of volume zones follow.
    own_patch_rays: usize,
    /// End of every own ray: a zone, a path vertex or a code.
    ends: Vec<u32>,
    /// Weight of every own ray in each band; empty where all are 1.
    weights: Vec<PerBand<f32>>,
    /// Path vertices of the own patches, and of the own volume zones, in blocks of [`ZONES_PER_BLOCK`] zones.
    vertices: [Vec<Vec<PathVertex>>; 2],
    /// Path vertices of all ranks.
    vertex_count: u64,
    /// ρ of the patches where paths continue; otherwise empty.
    reflectance: Vec<PaddedBands>,
    /// Fraction of its own emission that each pane zone absorbs.
    pane_self_exchange: Vec<Bands>,
}

/// The radiation that the rays of a zone transport.
#[derive(Clone, Copy)]
struct RadiatedField<'a> {
    /// The path vertices of the block of the zone.
    vertices: &'a [PathVertex],
    /// Radiosities of the zones, W/m².
    b: &'a [PaddedBands],
    /// Radiosity of the surroundings, W/m².
    sky: PaddedBands,
    extent: PathExtent<'a>,
}

/// Part of a path that a product includes.
#[derive(Clone, Copy)]
pub(crate) enum PathExtent<'a> {
    /// Up to the zone hit first.
    FirstZone,
    /// Up to the last zone, without the source term at the vertices.
    Continued,
    /// Up to the last zone, with the source term at the vertices.
    WithSource(&'a VertexSource),
}

/// Tracing of the rays of one kind of zones.
struct KindTracing<'a> {
    context: &'a SolveContext<'a>,
    tracer: &'a RayTracer<'a>,
    lights: Option<&'a PathLights<'a>>,
    rays_per_zone: RaysPerZone,
    /// 0 for patches, 1 for volume zones.
    kind: usize,
    first_zone: usize,
    stages: Blocks,
}

impl KindTracing<'_> {
    fn rays(&self) -> usize {
        self.rays_per_zone[self.kind]
    }

    /// Traces all rays of this rank, several stages at a time: a stage of few zones is a single block. `weights` is empty where all are 1. Returns the path
    /// vertices by blocks.
    fn trace(&self, ends: &mut [u32], weights: &mut [PerBand<f32>]) -> Vec<Vec<PathVertex>> {
        let mut stages = Vec::new();
        let (mut ends, mut weights) = (ends, weights);
        for number in self.stages.own() {
            let rays = self.rays() * self.stages.range(number).len();
            let (own, rest) = ends.split_at_mut(rays);
            let (own_weights, rest_of_weights) =
                weights.split_at_mut(if self.tracer.grey { 0 } else { rays });
            (ends, weights) = (rest, rest_of_weights);
            stages.push((number, own, own_weights));
        }
        let traced: Vec<_> = stages.into_par_iter().map(|(n, e, w)| self.trace_stage(n, e, w)).collect();
        traced.into_iter().flatten().collect()
    }

    /// Reads a stage from the checkpoint, or traces and saves it.
    fn trace_stage(
        &self,
        number: usize,
        ends: &mut [u32],
        weights: &mut [PerBand<f32>],
    ) -> Vec<Vec<PathVertex>> {
        let (rays, zones, checkpoints) = (self.rays(), self.context.zones, self.context.settings.checkpoints);
        let name = ray_checkpoint::stage_name(self.rays_per_zone, self.kind, number);
        let size = ray_checkpoint::StageLimits {
            rays_per_block: rays * ZONES_PER_BLOCK,
            patches: zones.patches.len(),
            zones: zones.len(),
        };
        if let Some(vertices) =
            checkpoints.load(&name).and_then(|b| ray_checkpoint::decode(&b, ends, weights, size))
        {
            self.context.settings.progress.advance(ends.len() as u64 / rays.max(1) as u64);
            return vertices;
        }
        let start = self.first_zone + self.stages.range(number).start;
        let first = |b: usize| start + b * ZONES_PER_BLOCK;
        let by_block =
            ends.par_chunks_mut(rays * ZONES_PER_BLOCK).enumerate().map(|(b, ends)| (first(b), ends));
        let vertices: Vec<Vec<PathVertex>> = if self.tracer.grey {
            by_block.map(|(zone, ends)| self.trace_block(zone, ends, &mut [])).collect()
        } else {
            let weighted = by_block.zip(weights.par_chunks_mut(rays * ZONES_PER_BLOCK));
            weighted.map(|((zone, ends), w)| self.trace_block(zone, ends, w)).collect()
        };
        // An interrupted stage lacks rays.
        if checkpoints.keeps() && !self.context.settings.progress.is_interrupted() {
            checkpoints.save(&name, &ray_checkpoint::encode(ends, weights, &vertices));
        }
        vertices
    }

    /// Traces the rays of a block of zones from `zone` on; none after an interruption.
    fn trace_block(&self, zone: usize, ends: &mut [u32], weights: &mut [PerBand<f32>]) -> Vec<PathVertex> {
        let rays = self.rays();
        let mut vertices = Vec::new();
        if self.context.settings.progress.is_interrupted() {
            return vertices;
        }
        let source = |r: usize| RayNumber { zone: zone + r / rays, number: r % rays };
        self.tracer.trace_batch(ends.len(), source, |r, end| {
            if let Some(w) = weights.get_mut(r) {
                *w = end.weight;
            }
            ends[r] = match self.lights {
                Some(lights) => self.tracer.continue_path(lights, source(r), end, &mut vertices).0,
                None => end.zone,
            };
        });
        self.context.settings.progress.advance(ends.len() as u64 / rays.max(1) as u64);
        vertices.shrink_to_fit();
        vertices
    }
}

impl<'a> RayTable<'a> {
    /// Traces the rays of every zone; with `lights` paths continue from close patches. Finished stages are kept in the checkpoint.
    pub(crate) fn trace(
        context: &SolveContext<'a>,
        rays_per_zone: RaysPerZone,
        lights: Option<&PathLights>,
    ) -> RayTable<'a> {
        let zones = context.zones;
        let tracer = RayTracer::new(context.scene, zones, context.transport);
        let patches = zones.patches.len();
        let of_kind = [patches, zones.len() - patches];
        let stages = [0, 1].map(|k| {
            let zones_per_stage = ray_checkpoint::zones_per_stage(of_kind[k], rays_per_zone[k]);
            Blocks::new(context.settings.communicator, of_kind[k], zones_per_stage)
        });
        let own_rays = [0, 1].map(|k| rays_per_zone[k] * stages[k].own_items().count());
        let total = own_rays[0] + own_rays[1];
        context.settings.progress.begin("rays", zones.len() as u64);
        let reflectance = match lights {
            Some(_) => zones.patches.iter().map(|p| padded(p.reflectance)).collect(),
            None => Vec::new(),
        };
        let [_, _, pane_zones] = zones.ranges_of_kinds();
        let mut table = RayTable {
            communicator: context.settings.communicator,
            patches,
            stages,
            rays_per_zone,
            own_patch_rays: own_rays[0],
            ends: vec![NO_ZONE; total],
            weights: if tracer.grey { Vec::new() } else { vec![PerBand::splat(1.0); total] },
            vertices: Default::default(),
            vertex_count: 0,
            reflectance,
            pane_self_exchange: pane_zones.map(|i| tracer.self_exchange(i, rays_per_zone[1])).collect(),
        };
        // Trace patches, then volume zones.
        let (patch_ends, volume_ends) = table.ends.split_at_mut(own_rays[0]);
        let (patch_weights, volume_weights) =
            table.weights.split_at_mut(if tracer.grey { 0 } else { own_rays[0] });
        let kinds = [(0, patch_ends, patch_weights), (patches, volume_ends, volume_weights)];
        for (kind, (first_zone, ends, weights)) in kinds.into_iter().enumerate() {
            let stages = stages[kind];
            let tracing =
                KindTracing { context, tracer: &tracer, lights, rays_per_zone, kind, first_zone, stages };
            table.vertices[kind] = tracing.trace(ends, weights);
        }
        let own: u64 = table.vertices.iter().flatten().map(|v| v.len() as u64).sum();
        table.vertex_count = context.execution().sum_of_ranks(own);
        context.settings.progress.end();
        table
    }

    /// The processes that share the rays.
    pub(crate) fn communicator(&self) -> &'a dyn Communicator {
        self.communicator
    }

    /// Number of rays, and of path vertices.
    pub(crate) fn rays_and_vertices(&self) -> [u64; 2] {
        let of_kind = [0, 1].map(|k| (self.rays_per_zone[k] * self.stages[k].items()) as u64);
        [of_kind[0] + of_kind[1], self.vertex_count]
    }

    /// `f` of every zone, each on the rank that has its rays.
    fn map_zones<T: Message>(&self, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
        let mut out = self.stages[0].map(self.communicator, &f);
        out.extend(self.stages[1].map(self.communicator, |z| f(self.patches + z)));
        out
    }

    /// Writes into `surroundings` the exchange of every zone with the surroundings and with back faces.
    pub(crate) fn measure_escape(&self, zones: &Zones, surroundings: &mut SurroundingsExchange) {
        let one = |i: usize| {
            let (mut found, range) = ([Bands::ZERO; 2], self.rays_of(i));
            let per_ray = closure_target(zones, i) / range.len() as f64;
            for r in range.filter(|&r| self.ends[r] == ESCAPED || self.ends[r] == BACK_FACE) {
                let weight = self.weights.get(r).map_or(Bands::ONE, |w| w.map(f64::from));
                found[usize::from(self.ends[r] == BACK_FACE)] += per_ray * weight;
            }
            found
        };
        let found = self.map_zones(one);
        let each = surroundings.sky.iter_mut().zip(&mut surroundings.backfaces).zip(found);
        each.for_each(|((sky, backfaces), found)| [*sky, *backfaces] = found);
    }

    /// The kind of an own zone `i`, and its number among the own zones of that kind.
    fn place(&self, i: usize) -> (usize, usize) {
        match i.checked_sub(self.patches) {
            None => (0, self.stages[0].place(i)),
            Some(z) => (1, self.stages[1].place(z)),
        }
    }

    /// Indices of the rays of an own zone `i`.
    fn rays_of(&self, i: usize) -> Range<usize> {
        let (kind, place) = self.place(i);
        let before = if kind == 0 { 0 } else { self.own_patch_rays };
        let start = before + self.rays_per_zone[kind] * place;
        start..start + self.rays_per_zone[kind]
    }

    /// Path vertices of the block of an own zone `i`.
    fn vertices_of(&self, i: usize) -> &[PathVertex] {
        let (kind, place) = self.place(i);
        &self.vertices[kind][place / ZONES_PER_BLOCK]
    }

    /// Calls `each` with the radiosity that every ray of `range` transports.
    #[inline(always)]
    fn for_each_ray(&self, range: Range<usize>, field: &RadiatedField, mut each: impl FnMut(PaddedBands)) {
        if self.weights.is_empty() {
            for &end in &self.ends[range] {
                each(match field.b.get(end as usize) {
                    Some(b) => *b,
                    None => self.transported(field, end, PerBand::splat(1.0)),
                });
            }
        } else {
            for (end, weight) in self.ends[range.clone()].iter().zip(&self.weights[range]) {
                each(self.transported(field, *end, *weight));
            }
        }
    }

    /// Radiosity that a ray of this end and weight transports.
    #[inline]
    fn transported(&self, field: &RadiatedField, end: u32, weight: PerBand<f32>) -> PaddedBands {
        let RadiatedField { vertices, b, sky, extent } = *field;
        let weight = padded_f32(weight);
        let weighted = |b: PaddedBands| std::array::from_fn(|k| weight[k] * b[k]);
        let from_zone = |zone: u32| weighted(b[zone as usize]);
        let along_path = |first: usize, source| {
            let field = PathField { vertices, reflectance: &self.reflectance, radiosity: b, source };
            field.transported(first, weight)
        };
        match (vertex_index(end), extent) {
            _ if end == ESCAPED => weighted(sky),
            _ if end >= FIRST_CODE => [0.0; LANES],
            (None, _) => from_zone(end),
            (Some(_), PathExtent::FirstZone) => from_zone(first_zone(end, vertices)),
            (Some(first), PathExtent::Continued) => along_path(first, None),
            (Some(first), PathExtent::WithSource(source)) => along_path(first, Some(source)),
        }
    }

    /// H or G of every zone for zones of radiosity `b`, by the first 1/`divisor` of its rays, W/m².
    pub(crate) fn incident(&self, b: &[PaddedBands], extent: PathExtent, divisor: usize) -> Vec<Bands> {
        let one = |i: usize| {
            let (range, factor) = (self.rays_of(i), self.incident_factor(i));
            let count = range.len().div_ceil(divisor);
            let mut sum: PaddedBands = [0.0; LANES];
            let rays = range.start..range.start + count;
            let field = RadiatedField { vertices: self.vertices_of(i), b, sky: [0.0; LANES], extent };
            self.for_each_ray(rays, &field, |v| {
                (0..LANES).for_each(|k| sum[k] += v[k]);
            });
            let own = self.self_irradiation(i, b);
            factor * (without_padding(sum.map(|s| (s / count as f32) as f64)) + own)
        };
        self.map_zones(one)
    }

    /// Standard error of H or G of every zone by the variance of its rays, from zones of radiosity `b` and surroundings of radiosity `sky`, W/m².
    pub(crate) fn standard_error(
        &self,
        b: &[PaddedBands],
        sky: PaddedBands,
        extent: PathExtent,
    ) -> Vec<Bands> {
        let one = |i: usize| {
            let range = self.rays_of(i);
            let (m, factor) = (range.len() as f64, self.incident_factor(i));
            let (mut sum, mut square) = ([0.0; LANES], [0.0; LANES]);
            let field = RadiatedField { vertices: self.vertices_of(i), b, sky, extent };
            self.for_each_ray(range, &field, |v| {
                let v = v.map(f64::from);
                (0..LANES).for_each(|k| sum[k] += v[k]);
                (0..LANES).for_each(|k| square[k] += v[k] * v[k]);
            });
            let (h, mean_square) = (without_padding(sum) / m, without_padding(square) / m);
            let e = (mean_square - h * h).map(|variance| (variance.max(0.0) / m).sqrt());
            e * factor
        };
        self.map_zones(one)
    }

    /// Rays of a patch, and of a volume zone or pane.
    pub(crate) fn rays_per_zone(&self) -> [usize; 2] {
        self.rays_per_zone
    }

    /// Mean radiosity that zone `i` receives from itself beside its rays; zero except for a pane zone.
    pub(crate) fn self_irradiation(&self, i: usize, b: &[PaddedBands]) -> Bands {
        let pane = (i + self.pane_self_exchange.len()).checked_sub(b.len());
        pane.map_or(Bands::ZERO, |p| self.pane_self_exchange[p] * without_padding(b[i].map(f64::from)))
    }

    /// Incident radiation over the mean radiosity of the rays: 1 for H, 4 for G.
    pub(crate) fn incident_factor(&self, i: usize) -> f64 {
        if i < self.patches { 1.0 } else { 4.0 }
    }
}
