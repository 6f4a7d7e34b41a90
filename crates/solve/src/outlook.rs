//! Time and memory of a solve beforehand, for the engine that it will take.
//!
//! Rays from the zones, rays to the surroundings, rays of direct light and pairs of zones are known in number; what one of each takes on
//! this machine and in this scene a sample tells, timed by whoever asks. What remains are constants. Where rays may fall short of the
//! tolerance and links have to go on from there, nobody knows how many: a number to expect is told, and one that is hardly exceeded.

use crate::dense;
use crate::engine;
use crate::engine::Choice;
use crate::forecast::{self, Forecast};
use crate::groups;
use crate::hierarchical::budget::{self, Budget, PROGRAM};
use crate::hierarchical::build::{NO_LINKS, beyond_links, tells_escape, within_links};
use crate::hierarchical::seeing;
use crate::hierarchical::trial::trial;
use crate::spectral::basis::Variation;
use crate::spectral::kernels;
use crate::surroundings::Escape;
use crate::zoning;
use rayon::prelude::*;
use zonal_exchange::pair::{Counts, Exchange, Settings};
use zonal_scene::{Engine, Note, Scene, SceneError, Zones};
use zonal_transport::Transport;

/// Pairs of zones in the sample of the dense engine, and rows that they lie in.
const PAIRS: usize = 16_384;
const ROWS: usize = 128;
/// Zones whose rays to the surroundings are sampled.
const LOOKS: usize = 2048;
/// Rays of each.
const LOOK_RAYS: usize = 16;
/// Nanoseconds to bring light along a ray: with the zones' light at hand in the cache, and without; and the zones from which on.
const PASS: [f64; 2] = [1.8, 5.0];
const CACHED: usize = 300_000;
/// Microseconds a zone: smoothing, and all that is done once a zone and light group.
const SMOOTH: f64 = 16.0;
const FIELD: f64 = 3.0;
/// A link, all refinements until the tolerance is met, over a pair of zones in full.
const LINK: f64 = 2.0;
/// Links are hardly more than this many times those expected.
const HARDLY: f64 = 4.0;
/// Tolerance above which rays mostly meet it.
const MET: f64 = 0.04;
/// Bytes of a dense solve over those of its exchange areas: chunks on their way, factors kept by offset.
const DENSE: f64 = 1.8;
/// Microseconds of an offset of a table, and of the spectra for each point of a transform; nanoseconds of a product with all pairs by transforms, for each of their points.
const OFFSET: f64 = 0.4;
const SPECTRUM: f64 = 0.05;
const TRANSFORM: f64 = 8.0;
/// A multiplication with all pairs, nanoseconds a pair and band, and about how many are needed.
const PRODUCT: f64 = 0.6;
const PRODUCTS: f64 = 25.0;

/// Nanoseconds of the total exchange areas for each triple of zones.
const TRIPLE: f64 = 1.0;

/// What a solve will take.
#[derive(Clone, Debug, PartialEq)]
pub struct Outlook {
    /// The engine.
    pub engine: Engine,
    /// Why it.
    pub reason: String,
    /// Parts of the work with their seconds, in their order.
    pub parts: Vec<(String, f64)>,
    /// Seconds to expect, and hardly exceeded.
    pub seconds: [f64; 2],
    /// Bytes at the peak to expect, and hardly exceeded.
    pub bytes: [u64; 2],
    /// What memory changes.
    pub notes: Vec<Note>,
    /// True where radiosity varies inside zones.
    pub slopes: bool,
}

/// A solve to be looked at.
#[derive(Clone, Copy)]
pub struct Plan<'a> {
    /// Scene.
    pub scene: &'a Scene,
    /// Its zones.
    pub zones: &'a Zones,
    /// What rays meet.
    pub transport: &'a Transport<'a>,
    /// Counts.
    pub forecast: &'a Forecast,
    /// Formulas of pairs.
    pub settings: Settings,
    /// Largest memory, bytes.
    pub memory: u64,
    /// Threads.
    pub threads: usize,
}

impl Outlook {
    /// Looks ahead; `clock` tells seconds. An error where the solve would be refused.
    pub fn new(plan: &Plan, clock: &dyn Fn() -> f64) -> Result<Outlook, SceneError> {
        let Plan { scene, zones, transport, forecast, settings, memory, threads } = *plan;
        let choice = engine::choose(scene, zones, transport, forecast, settings, memory)?;
        let (engine, reason) = (choice.engine, choice.reason.clone());
        let (_, light) = forecast::direct_light(scene, zones, transport, threads);
        let mut parts = vec![("direct light".to_string(), light)];
        if !engine::knows_escape(engine, scene)
            && (engine != Engine::Hierarchical || !tells_escape(scene, zones))
        {
            parts.push(("surroundings".to_string(), surroundings(plan, clock)));
        }
        let mut out = Outlook {
            engine,
            reason,
            parts,
            seconds: [0.0; 2],
            bytes: [0; 2],
            notes: Vec::new(),
            slopes: false,
        };
        let more = match engine {
            Engine::Hierarchical => out.hierarchical(plan, clock),
            Engine::Spectral => out.spectral(plan, choice),
            Engine::Dense | Engine::Auto => out.dense(plan, clock),
        };
        let heat = crate::thermal::bytes(scene, zones);
        let smaller = if zoning::wanted(scene) { zoning::smaller(scene, zones, out.slopes) } else { None };
        // Smaller zones of a second solve may hold more than the first: every pair at worst.
        let second = |m: usize| (DENSE * dense::bytes(m, 0, forecast.groups) as f64) as u64 + PROGRAM;
        out.bytes = out.bytes.map(|b| (b + heat).max(smaller.map_or(0, second).min(memory)));
        let word = if smaller.is_some() { "smaller" } else { "larger" };
        let sum = out.parts.iter().map(|p| p.1).sum::<f64>();
        let again = again(scene, zones, engine, smaller);
        out.parts.extend((again > 0.0).then(|| (format!("the same on {word} zones"), again * sum)));
        out.seconds = [sum, sum + more].map(|s| (1.0 + again) * s);
        Ok(out)
    }

    /// The parts of the spectral engine.
    fn spectral(&mut self, plan: &Plan, choice: Choice) -> f64 {
        let Some((e, variation)) = &choice.boxed else { return 0.0 };
        self.notes.extend(choice.note);
        self.slopes = *variation == Variation::Linear;
        // Of slopes all fields have components, and all kernels are matrices between these.
        let [fields, matrices] = [variation.voxel(), variation.volume().terms.len()].map(|n| n as f64);
        let threads = plan.threads.max(1) as f64;
        let (_, kappa) = e.groups();
        let points: f64 = e.grid.lengths().iter().map(|n| *n as f64).product();
        let work: f64 = kappa.iter().map(|&k| kernels::work(&e.grid, k, *variation)).sum();
        self.parts.push((
            "exchange areas by offset".into(),
            (work * OFFSET + matrices * points * SPECTRUM) * 1e-6 / threads,
        ));
        let columns = groups::chosen(plan.scene, plan.zones).0.len() as f64;
        let products = PRODUCTS * columns * kappa.len() as f64;
        self.parts.push(("solving".into(), products * fields * points * TRANSFORM * 1e-9 / threads));
        self.parts.push(("fields".into(), plan.zones.len() as f64 * 0.2 * FIELD * columns * 1e-6 / threads));
        self.bytes =
            [engine::spectral_bytes(plan.scene, plan.zones, plan.forecast, e, *variation) + PROGRAM; 2];
        0.0
    }

    fn dense(&mut self, plan: &Plan, clock: &dyn Fn() -> f64) -> f64 {
        let f = plan.forecast;
        self.parts.push(("exchange areas".into(), f.pairs as f64 * pair(plan, clock)));
        let columns = groups::chosen(plan.scene, plan.zones).0.len() as f64;
        let products = PRODUCTS * columns * 3.0 * PRODUCT * 1e-9 * f.pairs as f64;
        self.parts.push(("solving".into(), products / plan.threads.max(1) as f64));
        let bytes = (DENSE * f.bytes as f64) as u64 + f.zone_bytes + f.field_bytes + PROGRAM;
        self.bytes = [bytes; 2];
        0.0
    }

    /// The parts of the hierarchical engine; seconds that links, or more rays, may take beyond those expected.
    fn hierarchical(&mut self, plan: &Plan, clock: &dyn Fn() -> f64) -> f64 {
        let Plan { scene, zones, transport, memory, .. } = *plan;
        let tolerance = scene.options().tolerance;
        let budget = Budget::new(scene, zones, transport, memory);
        let each =
            budget.each(zones, tolerance).unwrap_or_else(|| seeing::rays(zones, tolerance, f64::INFINITY));
        self.notes.extend(budget.note(zones, tolerance, each));
        let rays = seeing::count(zones, each);
        let t = trial(scene, zones, transport, each, clock);
        let (n, threads) = (zones.len() as f64, plan.threads.max(1) as f64);
        let columns = groups::chosen(scene, zones).0.len() as f64;
        let pass = PASS[usize::from(zones.len() > CACHED)] * 1e-9;
        self.parts.push((format!("{rays} rays from the zones"), t.seconds));
        let passed = (t.passes + 2.0) * columns * (rays as f64 + t.onward) * pass;
        self.parts.push(("passing light on".into(), passed / threads));
        self.parts.push(("smoothing".into(), n * (SMOOTH + FIELD * columns) * 1e-6 / threads));
        let by_rays = budget.with_trial(rays, t.onward);
        self.bytes = [by_rays; 2];
        if beyond_links(zones) {
            return 0.0;
        }
        if !within_links(zones) {
            // Rays that fall short are shot again, as many as may be.
            let most = seeing::count(zones, seeing::more(zones, each, f64::INFINITY, budget.rays, false));
            self.bytes[1] = by_rays.max(budget.with_trial(most, 0.0));
            return most as f64 / rays.max(1) as f64 * (t.seconds + passed / threads);
        }
        if !budget.holds_links(zones, tolerance) {
            self.notes.push(Note::warning("memory", NO_LINKS));
            return 0.0;
        }
        let expected = budget::links(zones, tolerance);
        let most = (HARDLY * expected).min(n * n);
        let one = LINK * pair(plan, clock);
        let fits = |links: f64| budget.with_links(links).min(memory).max(by_rays);
        self.bytes[1] = fits(most);
        if tolerance > MET {
            return most * one;
        }
        self.bytes[0] = fits(expected);
        self.parts.push((format!("about {:.1e} links", expected), expected * one));
        (most - expected) * one
    }
}

/// What the second solve takes over the first, where it is wanted: on zones twice as large, a quarter of the patches and an eighth of the voxels;
/// or on so many smaller ones.
fn again(scene: &Scene, zones: &Zones, engine: Engine, smaller: Option<usize>) -> f64 {
    if !zoning::wanted(scene) || zones.is_empty() {
        return 0.0;
    }
    let sheets = (zones.patches.len() + zones.panes.len()) as f64;
    let fewer = match smaller {
        Some(others) => others as f64 / zones.len() as f64,
        None => (sheets / 4.0 + zones.voxels.len() as f64 / 8.0) / zones.len() as f64,
    };
    match engine {
        Engine::Dense | Engine::Auto => fewer * fewer,
        Engine::Hierarchical | Engine::Spectral => fewer,
    }
}

/// Seconds of the rays to the surroundings.
fn surroundings(plan: &Plan, clock: &dyn Fn() -> f64) -> f64 {
    let (scene, zones) = (plan.scene, plan.zones);
    let step = zones.len().div_ceil(LOOKS).max(1);
    let start = clock();
    let found = Escape::sample(scene, zones, plan.transport, LOOK_RAYS, step);
    let one = (clock() - start) / found.rays.max(1) as f64;
    one * Escape::forecast(scene, zones.len(), found.closed()) as f64
}

/// Seconds of a pair of zones on all threads.
fn pair(plan: &Plan, clock: &dyn Fn() -> f64) -> f64 {
    let n = plan.zones.len();
    if n == 0 {
        return 0.0;
    }
    let exchange = Exchange::with_settings(plan.scene, plan.zones, plan.transport, plan.settings);
    // Rows by the share of the pairs that they have.
    let rows: Vec<usize> = (0..ROWS)
        .map(|k| ((n as f64 * ((k as f64 + 0.5) / ROWS as f64).sqrt()) as usize).min(n - 1))
        .collect();
    let each = PAIRS / ROWS;
    let one = |k: usize| {
        let (i, mut counts) = (rows[k], Counts::default());
        let row = exchange.row(i);
        let js = (0..each.min(i + 1)).map(|m| (m * (i + 1) + k) / each.min(i + 1));
        js.filter(|&j| j <= i).map(|j| exchange.pair_in(&row, j, &mut counts)).count()
    };
    let all = || (0..ROWS).into_par_iter().with_max_len(1).map(one).sum::<usize>();
    // The first time some factors are new that all pairs of a solve share.
    all();
    let start = clock();
    let done = all();
    (clock() - start) / done.max(1) as f64
}

/// Seconds that all direct and total exchange areas of a periodic scene take, in so many matrices, where there are no more than [`engine::DENSE_ZONES`]
/// zones; images take no time of their own. `None` of other scenes, whose pairs the dense engine's forecast tells.
pub fn exchange_areas(plan: &Plan, clock: &dyn Fn() -> f64) -> Option<f64> {
    let n = plan.zones.len();
    if !plan.scene.is_periodic()
        || n > engine::DENSE_ZONES
        || engine::check_pairs(plan.scene, plan.zones).is_err()
    {
        return None;
    }
    let matrices = plan.forecast.groups as f64;
    let totals = matrices * (n as f64).powi(3) * TRIPLE * 1e-9 / plan.threads.max(1) as f64;
    let start = clock();
    let one = pair(plan, clock);
    // The tables are made anew by the command.
    Some((clock() - start) + plan.forecast.pairs as f64 * one + totals)
}

impl Outlook {
    /// The same with what it takes to read the scene and make its zones, in seconds.
    pub fn beginning(mut self, seconds: f64) -> Outlook {
        self.parts.insert(0, ("reading".into(), seconds));
        self.seconds = self.seconds.map(|s| s + seconds);
        self
    }
}
