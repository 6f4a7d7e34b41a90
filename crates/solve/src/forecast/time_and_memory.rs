//! Expected time and memory of a solve, for the engine that is selected.
//!
//! The numbers of rays from the zones, to the surroundings and to the lights, and of pairs of zones are known. The time of one of each is measured by a
//! sample on this machine, with the caller's clock; other costs are constants. The number of samples of a final gather depends on
//! the solution: an expected value and an upper bound are returned.

use crate::device::basis::BasisOrder;
use crate::engines::dense::band_groups;
use crate::engines::dense::row_blocks::packed_length;
use crate::engines::engine_memory::{layered_solve_bytes, spectral_solve_bytes};
use crate::engines::problem_size::{self, ProblemSize};
use crate::engines::rays::gather::final_gather;
use crate::engines::rays::memory_budget::{MemoryBudget, PROGRAM_BYTES};
use crate::engines::rays::stored_rays::cost_probe::probe_ray_cost;
use crate::engines::rays::stored_rays::ray_sampling::{rays_measure_escape, rays_per_zone, total_rays};
use crate::engines::selection::{self, EngineChoice};
use crate::engines::spectral::{box_in_blocks, kernels};
use crate::errors::discretization;
use crate::forecast::distribution_cost::Traffic;
use crate::right_hand_side::light_groups;
use crate::right_hand_side::surroundings::SurroundingsExchange;
use rayon::prelude::*;
use zonal_exchange::pair::{Exchange, PairCounts, PairSettings};
use zonal_scene::{Band, Diagnostic, Engine, Scene, SceneError, ZoneBasis, Zones};
use zonal_transport::Transport;

/// Pairs of zones in the sample of the dense engine, and rows that they lie in.
const SAMPLED_PAIRS: usize = 16_384;
const SAMPLED_ROWS: usize = 128;
/// Zones whose rays to the surroundings are sampled.
const SAMPLED_ZONES: usize = 2048;
/// Rays of each of them.
const RAYS_PER_SAMPLED_ZONE: usize = 16;
/// Nanoseconds of a ray in an iteration: with the radiosities in the cache, and without; and the maximum number of zones in the cache.
const NANOSECONDS_PER_RAY: [f64; 2] = [1.8, 5.0];
const MAX_CACHED_ZONES: usize = 300_000;
/// Microseconds of a zone: smoothing, and the fields of a light group.
const SMOOTHING_MICROSECONDS: f64 = 16.0;
const FIELD_MICROSECONDS: f64 = 3.0;
/// Cost of a sample of the final gather, a ray and a connection, over that of a stored ray; upper bound of their number over the expected one.
const SAMPLE_OVER_RAY_COST: f64 = 2.5;
const SAMPLES_UPPER_BOUND_FACTOR: f64 = 5.0;
/// Bytes of a dense solve over those of its exchange areas: unfinished chunks, and factors cached by offset.
const DENSE_MEMORY_FACTOR: f64 = 1.8;
/// Microseconds of an offset of a table, and of the spectra for each point of a transform; nanoseconds of a product for each point of its transforms.
const OFFSET_MICROSECONDS: f64 = 0.4;
const SPECTRUM_MICROSECONDS: f64 = 0.05;
const TRANSFORM_NANOSECONDS: f64 = 8.0;
/// Microseconds of a pair of layers.
const LAYER_PAIR_MICROSECONDS: f64 = 0.3;
/// Nanoseconds of a dense product for each pair and band, and expected number of products.
const PRODUCT_NANOSECONDS: f64 = 0.6;
const EXPECTED_PRODUCTS: f64 = 25.0;
/// The same where blocks of voxels correct the iteration, their own products included.
const PRODUCTS_WITH_BLOCKS: f64 = 12.0;

/// Nanoseconds of the total exchange areas for each block of zones.
const TRIPLE_NANOSECONDS: f64 = 1.0;

/// Expected cost of a solve.
#[derive(Clone, Debug, PartialEq)]
pub struct CostEstimate {
    /// The engine.
    pub engine: Engine,
    /// The reason for it.
    pub reason: String,
    /// Phases with their seconds, in their order.
    pub parts: Vec<(String, f64)>,
    /// Expected seconds, and an upper bound.
    pub seconds: [f64; 2],
    /// Expected peak of the memory, and an upper bound, bytes.
    pub bytes: [u64; 2],
    /// Diagnostics of the memory limit.
    pub notes: Vec<Diagnostic>,
    /// True if the radiosity has slopes inside zones.
    pub has_slopes: bool,
    /// Bytes that the first of several processes sends; none of one process.
    pub traffic: Option<Traffic>,
}

/// A solve whose cost is estimated.
#[derive(Clone, Copy)]
pub struct CostModelInput<'a> {
    /// Scene.
    pub scene: &'a Scene,
    /// Its zones.
    pub zones: &'a Zones,
    /// Ray tracing in the scene.
    pub transport: &'a Transport<'a>,
    /// Counts and memory.
    pub size: &'a ProblemSize,
    /// Methods and samples for pairs of zones.
    pub pair_settings: PairSettings,
    /// Memory limit, bytes.
    pub memory_limit: u64,
    /// Number of threads of each process.
    pub threads: usize,
    /// Number of processes that share the solve.
    pub ranks: usize,
}

impl CostEstimate {
    /// Estimates the cost; `clock` returns seconds.
    ///
    /// # Errors
    /// If the solve would be refused.
    pub fn new(input: &CostModelInput, clock: &dyn Fn() -> f64) -> Result<CostEstimate, SceneError> {
        let CostModelInput { scene, zones, transport, size, pair_settings, memory_limit, threads, ranks } =
            *input;
        let choice =
            selection::select_engine(scene, zones, transport, size, pair_settings, memory_limit, ranks)?;
        let (engine, reason) = (choice.engine, choice.reason.clone());
        let (_, light) = problem_size::direct_light_cost(scene, zones, transport, threads);
        let products = EXPECTED_PRODUCTS * light_groups::select_groups(scene, zones).0.len() as f64;
        let mut parts = vec![("direct light".to_string(), light)];
        if !selection::knows_escaping_power(engine, scene)
            && (engine != Engine::Rays || !rays_measure_escape(scene, zones))
        {
            parts.push(("surroundings".to_string(), surroundings_cost(input, clock)));
        }
        let mut out = CostEstimate {
            engine,
            reason,
            parts,
            seconds: [0.0; 2],
            bytes: [0; 2],
            notes: Vec::new(),
            has_slopes: false,
            traffic: Traffic::expected(&choice, zones, ranks, products),
        };
        let more = match engine {
            Engine::Rays => out.rays(input, clock),
            Engine::Spectral => out.spectral(input, choice),
            Engine::Layered => out.layered(input, choice),
            Engine::Dense | Engine::Auto => out.dense(input, clock),
        };
        let more = out.share_among(ranks, more);
        let heat = crate::thermal::memory_bytes(scene, zones);
        let smaller = if discretization::is_requested(scene) {
            discretization::refined_zone_count(scene, zones, out.basis())
        } else {
            None
        };
        // Smaller zones of a second solve may need more memory than the first, at most that of all pairs.
        let second = |m: usize| {
            (DENSE_MEMORY_FACTOR * band_groups::matrix_bytes(m, 0, size.groups) as f64) as u64 + PROGRAM_BYTES
        };
        out.bytes = out.bytes.map(|b| (b + heat).max(smaller.map_or(0, second).min(memory_limit)));
        let word = if smaller.is_some() { "smaller" } else { "larger" };
        let sum = out.parts.iter().map(|p| p.1).sum::<f64>();
        let second_solve = second_solve_cost(scene, zones, engine, smaller);
        out.parts
            .extend((second_solve > 0.0).then(|| (format!("the same on {word} zones"), second_solve * sum)));
        out.seconds = [sum, sum + more].map(|s| (1.0 + second_solve) * s);
        Ok(out)
    }

    /// Divides all phases, and the seconds `more` of an upper bound, among processes, which exchange messages.
    fn share_among(&mut self, ranks: usize, more: f64) -> f64 {
        self.parts.iter_mut().for_each(|(_, seconds)| *seconds /= ranks as f64);
        self.parts.extend(self.traffic.map(|t| ("messages".to_string(), t.seconds())));
        more / ranks as f64
    }

    /// Phases of the spectral engine.
    fn spectral(&mut self, input: &CostModelInput, choice: EngineChoice) -> f64 {
        let Some((e, order)) = &choice.enclosure else { return 0.0 };
        self.notes.extend(choice.note);
        self.has_slopes = *order == BasisOrder::Linear;
        // With slopes all fields have components, and all kernels are matrices between these.
        let [fields, matrices] =
            [order.voxel_components(), order.volume_layout().terms.len()].map(|n| n as f64);
        let threads = input.threads.max(1) as f64;
        let (_, kappa) = e.extinction_groups();
        let points: f64 = e.grid.lengths().iter().map(|n| *n as f64).product();
        let work: f64 = kappa.iter().map(|&k| kernels::table_work(&e.grid, k, *order)).sum();
        self.parts.push((
            "exchange areas by offset".into(),
            (work * OFFSET_MICROSECONDS + matrices * points * SPECTRUM_MICROSECONDS) * 1e-6 / threads,
        ));
        let columns = light_groups::select_groups(input.scene, input.zones).0.len() as f64;
        let each = if box_in_blocks::grid_of_blocks(&e.grid).is_some() {
            PRODUCTS_WITH_BLOCKS
        } else {
            EXPECTED_PRODUCTS
        };
        let products = each * columns * kappa.len() as f64;
        self.parts
            .push(("solving".into(), products * fields * points * TRANSFORM_NANOSECONDS * 1e-9 / threads));
        self.parts.push((
            "fields".into(),
            input.zones.len() as f64 * 0.2 * FIELD_MICROSECONDS * columns * 1e-6 / threads,
        ));
        self.bytes = [spectral_solve_bytes(input.scene, input.zones, input.size, e, *order, input.ranks)
            + PROGRAM_BYTES; 2];
        0.0
    }

    /// Phases of the layered engine.
    fn layered(&mut self, input: &CostModelInput, choice: EngineChoice) -> f64 {
        let Some(stack) = &choice.layers else { return 0.0 };
        self.notes.extend(choice.note);
        let (groups, threads) = (stack.band_groups().firsts.len() as f64, input.threads.max(1) as f64);
        let pairs = packed_length(stack.elements()) as f64;
        self.parts.push((
            "exchange areas of layers".into(),
            groups * pairs * LAYER_PAIR_MICROSECONDS * 1e-6 / threads,
        ));
        let columns = light_groups::select_groups(input.scene, input.zones).0.len() as f64;
        let products = EXPECTED_PRODUCTS * columns * Band::count() as f64 * PRODUCT_NANOSECONDS * 1e-9;
        self.parts.push(("solving".into(), products * pairs / threads));
        self.bytes = [layered_solve_bytes(input.size, stack) + PROGRAM_BYTES; 2];
        0.0
    }

    /// Phases of the dense engine.
    fn dense(&mut self, input: &CostModelInput, clock: &dyn Fn() -> f64) -> f64 {
        let f = input.size;
        self.parts.push(("exchange areas".into(), f.pairs as f64 * pair_cost(input, clock)));
        let columns = light_groups::select_groups(input.scene, input.zones).0.len() as f64;
        let products =
            EXPECTED_PRODUCTS * columns * Band::count() as f64 * PRODUCT_NANOSECONDS * 1e-9 * f.pairs as f64;
        self.parts.push(("solving".into(), products / input.threads.max(1) as f64));
        let bytes = (DENSE_MEMORY_FACTOR * f.bytes as f64 / input.ranks as f64) as u64
            + f.zone_bytes
            + f.field_bytes
            + PROGRAM_BYTES;
        self.bytes = [bytes; 2];
        0.0
    }

    /// Phases of the rays engine. Returns the seconds of samples beyond the expected ones.
    fn rays(&mut self, input: &CostModelInput, clock: &dyn Fn() -> f64) -> f64 {
        let CostModelInput { scene, zones, transport, memory_limit, .. } = *input;
        let tolerance = scene.options().tolerance;
        let budget = MemoryBudget::new(scene, zones, transport, memory_limit);
        let each = budget
            .affordable_rays(zones, tolerance)
            .unwrap_or_else(|| rays_per_zone(zones, tolerance, f64::INFINITY));
        self.notes.extend(budget.ray_warning(zones, tolerance, each));
        let rays = total_rays(zones, each);
        let t = probe_ray_cost(scene, zones, transport, each, clock);
        let (n, threads) = (zones.len() as f64, input.threads.max(1) as f64);
        let columns = light_groups::select_groups(scene, zones).0.len() as f64;
        let pass = NANOSECONDS_PER_RAY[usize::from(zones.len() > MAX_CACHED_ZONES)] * 1e-9;
        self.parts.push((format!("{rays} rays from the zones"), t.seconds));
        let passed = (t.iterations + 2.0) * columns * (rays as f64 + t.path_vertices) * pass;
        self.parts.push(("passing light on".into(), passed / threads));
        let samples = n * final_gather::expected_samples(tolerance);
        let gather = SAMPLE_OVER_RAY_COST * t.seconds / rays.max(1) as f64 * samples;
        self.parts.push((format!("final gather, about {samples:.1e} samples"), gather));
        self.parts.push((
            "smoothing".into(),
            n * (SMOOTHING_MICROSECONDS + FIELD_MICROSECONDS * columns) * 1e-6 / threads,
        ));
        let ranks = input.ranks as u64;
        self.bytes = [budget.with_rays_and_vertices(rays / ranks, t.path_vertices / ranks as f64); 2];
        gather * (SAMPLES_UPPER_BOUND_FACTOR - 1.0)
    }
}

/// Cost of the second solve for the discretization error over that of the first: on zones twice as large with a quarter of the patches and an eighth
/// of the voxels, or on `smaller` zones.
fn second_solve_cost(scene: &Scene, zones: &Zones, engine: Engine, smaller: Option<usize>) -> f64 {
    if !discretization::is_requested(scene) || zones.is_empty() {
        return 0.0;
    }
    let sheets = (zones.patches.len() + zones.panes.len()) as f64;
    let fewer = match smaller {
        Some(others) => others as f64 / zones.len() as f64,
        None => (sheets / 4.0 + zones.voxels.len() as f64 / 8.0) / zones.len() as f64,
    };
    match engine {
        Engine::Dense | Engine::Auto => fewer * fewer,
        Engine::Rays | Engine::Spectral | Engine::Layered => fewer,
    }
}

/// Seconds of the rays to the surroundings.
fn surroundings_cost(input: &CostModelInput, clock: &dyn Fn() -> f64) -> f64 {
    let (scene, zones) = (input.scene, input.zones);
    let step = zones.len().div_ceil(SAMPLED_ZONES).max(1);
    let start = clock();
    let found = SurroundingsExchange::sample(zones, input.transport, RAYS_PER_SAMPLED_ZONE, step);
    let one = (clock() - start) / found.rays.max(1) as f64;
    one * found.expected_rays(scene, zones.len()) as f64
}

/// Seconds of a pair of zones on all threads.
fn pair_cost(input: &CostModelInput, clock: &dyn Fn() -> f64) -> f64 {
    let n = input.zones.len();
    if n == 0 {
        return 0.0;
    }
    let exchange = Exchange::with_settings(input.scene, input.zones, input.transport, input.pair_settings);
    // Rows are sampled in proportion to their numbers of pairs.
    let rows: Vec<usize> = (0..SAMPLED_ROWS)
        .map(|k| ((n as f64 * ((k as f64 + 0.5) / SAMPLED_ROWS as f64).sqrt()) as usize).min(n - 1))
        .collect();
    let each = SAMPLED_PAIRS / SAMPLED_ROWS;
    let one = |k: usize| {
        let (i, mut counts) = (rows[k], PairCounts::default());
        let row = exchange.row(i);
        let js = (0..each.min(i + 1)).map(|m| (m * (i + 1) + k) / each.min(i + 1));
        js.filter(|&j| j <= i).map(|j| exchange.pair_in_row(&row, j, &mut counts)).count()
    };
    let all = || (0..SAMPLED_ROWS).into_par_iter().with_max_len(1).map(one).sum::<usize>();
    // The first pass also computes factors that all pairs share.
    all();
    let start = clock();
    let done = all();
    (clock() - start) / done.max(1) as f64
}

/// Seconds of all direct and total exchange areas of a periodic scene with at most `MAX_DENSE_ZONES` zones. `None` for other scenes, whose
/// cost is that of the dense engine.
#[must_use]
pub fn exchange_areas_cost(input: &CostModelInput, clock: &dyn Fn() -> f64) -> Option<f64> {
    let n = input.zones.len();
    if !input.scene.is_periodic()
        || n > selection::MAX_DENSE_ZONES
        || selection::check_periodic_pairs(input.scene, input.zones).is_err()
    {
        return None;
    }
    let matrices = input.size.groups as f64;
    let totals = matrices * (n as f64).powi(3) * TRIPLE_NANOSECONDS * 1e-9 / input.threads.max(1) as f64;
    let start = clock();
    let one = pair_cost(input, clock);
    // The command computes the tables again.
    Some((clock() - start) + input.size.pairs as f64 * one + totals)
}

impl CostEstimate {
    /// The basis inside the zones.
    #[must_use]
    pub fn basis(&self) -> ZoneBasis {
        discretization::basis_of(self.has_slopes)
    }

    /// For a scene of several blocks of bands, each at the cost of this one; temperatures that couple them keep all operators in memory.
    #[must_use]
    pub fn for_bands(mut self, scene: &Scene) -> CostEstimate {
        let blocks = scene.bands().block_count();
        self.parts.iter_mut().for_each(|p| p.1 *= blocks as f64);
        self.seconds = self.seconds.map(|s| s * blocks as f64);
        if scene.couples_bands() {
            self.bytes = self.bytes.map(|b| b * blocks as u64);
        }
        self
    }
    /// Adds the seconds for reading the scene and for its zones.
    #[must_use]
    pub fn with_reading_time(mut self, seconds: f64) -> CostEstimate {
        self.parts.insert(0, ("reading".into(), seconds));
        self.seconds = self.seconds.map(|s| s + seconds);
        self
    }
}
