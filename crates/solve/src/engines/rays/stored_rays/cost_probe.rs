//! The time of the rays of a scene, estimated from a short sample that the caller's clock measures.
//!
//! Runs of neighbouring zones are spread evenly over the patches and over the volume zones; the time of their rays is scaled to all
//! rays. The number of iterations n follows from the mean response q of the zones hit: q^n = [`REMAINING_RADIATION`].

use super::path_continuation::PathLights;
use super::ray_sampling::RaysPerZone;
use super::ray_tracer::{FIRST_CODE, RayNumber, RayTracer};
use crate::right_hand_side::direct_light::light_field::{DirectLight, LightField};
use crate::settings::zone_power::reflected_fraction;
use std::ops::Range;
use zonal_math::parallel;
use zonal_scene::{Bands, Scene, ZoneRef, Zones};
use zonal_transport::Transport;

/// Neighbouring zones of one run, so that their rays find the same parts of the scene in the cache as in a solve.
const ZONES_PER_RUN: usize = 64;
/// Most runs of patches, and of volume zones.
const MAX_RUNS: usize = 64;
/// Rays of a zone in the sample.
const RAYS_PER_ZONE: usize = 16;
/// Share of the radiation that remains when the iteration ends.
const REMAINING_RADIATION: f64 = 2e-3;
/// Most iterations.
const MAX_ITERATIONS: f64 = 200.0;

/// Cost of the rays of a solve, scaled from the sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RayCost {
    /// Seconds to trace all rays.
    pub seconds: f64,
    /// Path vertices of all rays.
    pub path_vertices: f64,
    /// Iterations of the solution.
    pub iterations: f64,
}

/// The sample of patches, or of volume zones.
#[derive(Default)]
struct ProbeSample {
    rays: usize,
    vertices: usize,
    /// Sum of the responses of the zones hit.
    response: f64,
}

/// Traces a sample of the rays of a solve; `clock` returns seconds.
pub(crate) fn probe_ray_cost(
    scene: &Scene,
    zones: &Zones,
    transport: &Transport,
    rays_per_zone: RaysPerZone,
    clock: &dyn Fn() -> f64,
) -> RayCost {
    let tracer = RayTracer::new(scene, zones, transport);
    let patches = zones.patches.len();
    // Vertices sample per light; the choice of the light hardly changes the time.
    let lit = |_| LightField { fields: vec![Bands::ONE; patches], ..LightField::default() };
    let direct = DirectLight { lights: scene.lights().iter().map(lit).collect() };
    let lights = PathLights::new(scene, &direct);
    let mut out = RayCost::default();
    let (mut traced, mut response) = (0.0, 0.0);
    for (range, rays) in [(0..patches, rays_per_zone[0]), (patches..zones.len(), rays_per_zone[1])] {
        let all = (range.len() * rays) as f64;
        if range.is_empty() {
            continue;
        }
        let timed = || {
            let start = clock();
            let sample = trace_sample(&tracer, &lights, range.clone());
            (sample, clock() - start)
        };
        // The first pass also loads the scene into the cache.
        let (sample, first) = timed();
        let seconds = timed().1.min(first);
        let scale = all / sample.rays as f64;
        out.seconds += seconds * scale;
        out.path_vertices += sample.vertices as f64 * scale;
        (traced, response) = (traced + all, response + sample.response * scale);
    }
    let mean_response = if traced > 0.0 { (response / traced).clamp(0.0, 1.0) } else { 0.0 };
    out.iterations = if mean_response <= REMAINING_RADIATION {
        1.0
    } else {
        (REMAINING_RADIATION.ln() / mean_response.ln()).clamp(1.0, MAX_ITERATIONS)
    };
    out
}

fn trace_sample(tracer: &RayTracer, lights: &PathLights, range: Range<usize>) -> ProbeSample {
    let runs = range.len().div_ceil(ZONES_PER_RUN).min(MAX_RUNS);
    let stride = range.len() / runs;
    let one = |run: usize| {
        let start = range.start + run * stride;
        let mut sample = ProbeSample::default();
        let mut vertices = Vec::new();
        let end = (start + ZONES_PER_RUN.min(stride)).min(range.end);
        let source = |r: usize| RayNumber { zone: start + r / RAYS_PER_ZONE, number: r % RAYS_PER_ZONE };
        sample.rays = RAYS_PER_ZONE * (end - start);
        tracer.trace_batch(sample.rays, source, |r, end| {
            sample.response += largest_response(tracer.zones, end.zone);
            tracer.continue_path(lights, source(r), end, &mut vertices);
        });
        sample.vertices = vertices.len();
        sample
    };
    let add = |a: ProbeSample, b: ProbeSample| ProbeSample {
        rays: a.rays + b.rays,
        vertices: a.vertices + b.vertices,
        response: a.response + b.response,
    };
    let done: Vec<ProbeSample> = parallel::collect_tasks(runs, one);
    done.into_iter().fold(ProbeSample::default(), add)
}

/// The largest ρ or Ω of the bands of a zone hit; zero for a ray that ends in no zone.
fn largest_response(zones: &Zones, zone: u32) -> f64 {
    if zone >= FIRST_CODE {
        return 0.0;
    }
    let response = match zones.zone(zone as usize) {
        ZoneRef::Patch(_) => reflected_fraction(zones, zone as usize),
        ZoneRef::Voxel(_, v) => v.albedo,
        ZoneRef::Pane(_, p) => p.albedo,
    };
    response.max_element()
}
