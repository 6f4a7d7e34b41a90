//! Temperatures of scenes with coupled bands: Newton's method for E with a linear solve of all bands in each step.
//!
//! About E⁰ a zone of known power emits w_b(E) ≈ w_b⁰ + ψ_b (E − E⁰), ψ = dw/dE. Its balance gives E from the incident flux, hence
//!
//! ```text
//!     B_b = a_b [ w_b⁰ + ψ_b (q − Σ_c m_c a_c w_c⁰)/S ] + r_b h_b + a_b ψ_b Σ_c m_c a_c h_c / S          S = Σ_c m_c a_c ψ_c
//! ```
//!
//! which is linear in the incident flux: light of one band is absorbed and reemitted in all bands, and power is conserved. The sums are over
//! all bands of the scene; their blocks have operators of their own, and the vectors of the linear solve hold one block after the other. Constant band fractions
//! are solved by one step. Otherwise E is updated and the next step is taken about it. The residual is the emission that the linearization
//! assigns to wrong bands, relative to all emission:
//!
//! ```text
//!     R = Σ_i V_i Σ_b m_b a_b |w_b(E) − w_b⁰ − ψ_b (E − E⁰)| / Σ_i V_i Σ_b m_b a_b |w_b(E)|
//! ```
//!
//! A linear solve need not be more accurate than the step that it serves: its residual is about R² of the step before, at most
//! [`FIRST_LINEAR_RESIDUAL`], at least a part of the wanted residual (inexact Newton; S. C. Eisenstat and H. F. Walker, SIAM J. Sci. Comput. 17, 1996).
//!
//! Safeguards: a step changes E by at most a factor [`MAX_CHANGE_FACTOR`]; where fractions decrease so fast that ψ_b < 0, ψ = a(T) replaces it
//! (Picard iteration); steps are halved when R no longer decreases. Every step is a stage of a checkpoint, and so is the linear solve in it.

use super::boundary_conditions::set_emissive_powers;
use super::coupled_bicgstab::{self, IterationCheckpoint};
use super::linearized_zone::{BandCoupling, CoupledOperator, CoupledScaling, Linearization, PowerScaling};
use super::nodes::NodeZones;
use super::spectral_balance::{BlockZones, SpectralBalances};
use super::zone_balance::ZoneBalance;
use crate::context::{BlockEngine, SolveContext};
use crate::distribution::multivector;
use crate::iteration::{IterationResult, StoppingCriterion};
use crate::operator::ExchangeOperator;
use crate::right_hand_side::surroundings::SurroundingsExchange;
use crate::settings::check_interrupted;
use crate::settings::stage_codec::{Decoder, Encoder};
use zonal_math::parallel;
use zonal_scene::thermal::blackbody_emissive_power;
use zonal_scene::{Bands, PerBand, SceneError, SolveStatus, ThermalCondition, Zones};

/// Maximum number of steps.
const MAX_STEPS: usize = 60;
/// Steps without a smaller residual after which steps are halved, and after which the iteration has stalled.
const MAX_STEPS_WITHOUT_PROGRESS: usize = 4;
const MAX_STEPS_BEFORE_STALL: usize = 20;
/// Largest factor by which E grows or falls in a step.
const MAX_CHANGE_FACTOR: f64 = 5.0;
/// Smallest residual of the linear solves over that of the temperatures, and their residual over the square of R of the step before.
const LINEAR_RESIDUAL_OVER_RESIDUAL: f64 = 0.1;
/// Residual of the first linear solve, where band fractions depend on temperature.
const FIRST_LINEAR_RESIDUAL: f64 = 1e-3;
/// Bytes of an unknown: its balance, its linearization, the vectors of the linear solve, and those of them that are saved as a stage.
const BYTES_PER_UNKNOWN: u64 = 400 + 12 * 24 + 5 * 24;
/// Names of the stages: temperatures after each step, and the linear solve of a step.
const STAGE: &str = "state-temperatures";
const LINEAR_STAGE: &str = "state-temperatures-linear";

/// Solution of a scene with coupled bands.
pub(crate) struct CoupledSolution {
    /// Zones with the emission of the temperatures found, for each block of bands.
    pub zones: Vec<Zones>,
    /// Strengths of each block, with the status of the iteration over temperatures in every band.
    pub results: Vec<IterationResult>,
    /// Number of products with the operators of all bands.
    pub products: usize,
}

/// Iterates over the temperatures of a scene, given as its blocks of bands.
///
/// # Errors
/// If the blocks have different unknowns, if the iteration exceeds the memory limit, or if the observer interrupts it.
pub(crate) fn solve(blocks: &[BlockEngine]) -> Result<CoupledSolution, SceneError> {
    let context = &blocks[0].context;
    let zones: Vec<BlockZones> =
        blocks.iter().map(|t| BlockZones { scene: t.context.scene, zones: t.context.zones }).collect();
    check_memory(context, blocks.iter().map(|t| t.built.operator.len()).sum())?;
    let balances = SpectralBalances::new(&zones);
    let coupled = coupled_operator(blocks, &balances, BandCoupling::of(&balances), true);
    let surfaces: Vec<usize> = context.zones.patches.iter().map(|p| p.surface).collect();
    let nodes = NodeZones::new(&balances, &surfaces);
    let iteration = NewtonIteration {
        context,
        balances: &balances,
        outside: outside_flux(blocks, &balances, &coupled.scaling),
        operator: &coupled,
        residual: context.scene.options().residual,
        is_linear: (0..balances.len()).all(|i| balances.is_linear(i))
            && nodes.as_ref().is_none_or(|n| n.is_linear(&balances)),
        nodes: nodes.as_ref(),
    };
    let NewtonState { e, u, products, history } = iteration.run(balances.tables[0].initial_temperature())?;
    // Set the emission of the zones by their temperatures.
    let of_block = |t: usize| {
        let emissive: Vec<Bands> =
            (0..balances.len()).map(|i| balances.emissive_powers(t, i, e[i])).collect();
        let mut zones = blocks[t].context.zones.clone();
        set_emissive_powers(blocks[t].context.scene, &mut zones, &emissive);
        let own = &u[coupled.scaling.range(t)];
        let result = IterationResult {
            strengths: coupled.scaling.blocks[t].strengths(own),
            status: PerBand::splat(history.status.unwrap_or(SolveStatus::MaxIterations)),
            residuals: PerBand::from_fn(|_| history.residuals.clone()),
            power: Bands::splat(coupled_bicgstab::absolute_sum(&u)),
        };
        (zones, result)
    };
    let (zones, results) = (0..blocks.len()).map(of_block).unzip();
    Ok(CoupledSolution { zones, results, products })
}

/// E of a zone with known temperature, W/m².
fn known_emissive_power(l: &ZoneBalance) -> Option<f64> {
    match l.condition {
        ThermalCondition::Temperature(t) => Some(blackbody_emissive_power(t)),
        _ => None,
    }
}

/// The data of the iteration that do not change.
struct NewtonIteration<'a> {
    context: &'a SolveContext<'a>,
    balances: &'a SpectralBalances<'a>,
    operator: &'a CoupledOperator<'a>,
    /// h of every unknown from the surroundings and from direct light, W/m².
    outside: Vec<Bands>,
    /// Wanted residual R.
    residual: f64,
    /// True if the balances of all zones and nodes are linear in E.
    is_linear: bool,
    nodes: Option<&'a NodeZones<'a>>,
}

impl NewtonIteration<'_> {
    /// Takes steps from the state of a checkpoint, or from a uniform temperature (K), until the iteration has ended.
    ///
    /// # Errors
    /// If the observer interrupts the iteration; the state of the step that it interrupts is not saved.
    fn run(&self, initial_temperature: f64) -> Result<NewtonState, SceneError> {
        let (context, balances) = (self.context, self.balances);
        let initial = blackbody_emissive_power(initial_temperature);
        let kept = context.settings.checkpoints.load(STAGE);
        let unknowns = balances.len() + self.nodes.map_or(0, NodeZones::len);
        let kept = kept.and_then(|b| NewtonState::decode(&b, unknowns, self.outside.len(), self.residual));
        let mut state = kept.unwrap_or_else(|| NewtonState {
            e: (0..balances.len())
                .map(|i| known_emissive_power(balances.first(i)).unwrap_or(initial))
                .chain(self.nodes.into_iter().flat_map(|n| n.initial_emissive_powers(initial)))
                .collect(),
            u: Vec::new(),
            products: 0,
            history: ConvergenceHistory::new(self.residual),
        });
        let first = state.history.residuals.len();
        context.settings.progress.begin("temperatures", MAX_STEPS as u64);
        context.settings.progress.advance(first as u64);
        while state.history.status.is_none() {
            state = self.step(state, first);
            check_interrupted(context.settings.progress)?;
            if context.settings.checkpoints.keeps() {
                context.settings.checkpoints.save(STAGE, &state.encode());
            }
            context.settings.progress.advance(1);
        }
        context.settings.progress.end();
        Ok(state)
    }

    /// One step: a linear solve about E, and the emissive powers that follow. `first` is the number of steps before a resumed iteration.
    fn step(&self, state: NewtonState, first: usize) -> NewtonState {
        let NewtonState { e, u, products, mut history } = state;
        let (balances, operator, outside) = (self.balances, self.operator, &self.outside);
        let mut linearized = Linearization::of(balances, |i| e[i]);
        if let Some(nodes) = self.nodes {
            linearized = linearized.with_nodes(balances, nodes, &e[balances.len()..]);
        }
        let scaling = &operator.scaling;
        // Sources of the zones and of the surroundings; higher-order unknowns have no source of their own.
        let first_of: Vec<usize> = (0..balances.blocks()).map(|t| scaling.range(t).start).collect();
        let absorbed = |h: &[Bands]| {
            self.nodes.map_or_else(Vec::new, |n| n.absorbed(balances, |t, i| h[first_of[t] + i]))
        };
        let response = |h: &[Bands]| linearized.node_response(|| absorbed(h));
        let from_outside = response(outside);
        let source = scaling.powers(outside, |place, h| {
            let own =
                if place.is_slope { Bands::ZERO } else { linearized.blocks[place.block][place.zone].own };
            own + linearized.reflected(place, h, &from_outside)
        });
        // Solve the linear system from the last solution.
        let reflect = |u: &[Bands]| {
            let h = operator.incident_flux(u);
            let nodes = response(&h);
            scaling.powers(&h, |place, h| linearized.reflected(place, h, &nodes))
        };
        let start = if u.is_empty() { source.clone() } else { u };
        let number = history.residuals.len();
        let checkpoint = IterationCheckpoint {
            store: self.context.settings.checkpoints,
            stage: LINEAR_STAGE,
            number,
            resumes: number == first,
            progress: self.context.settings.progress,
        };
        let max_iterations = self.context.scene.options().max_iterations;
        let stop = StoppingCriterion { residual: history.linear_residual(self.is_linear), max_iterations };
        let end = coupled_bicgstab::solve(reflect, &source, start, stop, &checkpoint);
        // Update the emissive powers.
        let h = operator.incident_flux(&end.u);
        let incident = |t: usize, i: usize| h[first_of[t] + i] + outside[first_of[t] + i];
        let update = EmissiveUpdate { balances, linearized: &linearized, nodes: self.nodes, old: &e };
        let (e, off) = update.run(incident, history.step_length());
        history.record(off, end.residual, stop.residual);
        NewtonState { e, u: end.u, products: products + end.products + 1, history }
    }
}

/// Refuses an iteration that exceeds the memory limit.
fn check_memory(context: &SolveContext, unknowns: usize) -> Result<(), SceneError> {
    let bytes = BYTES_PER_UNKNOWN * unknowns as u64;
    if bytes <= context.settings.memory_limit {
        return Ok(());
    }
    let what = format!(
        "the iteration over temperatures of {} zones needs {:.3} GB, more than the {:.3} GB allowed; use larger patches or fewer cells, or allow more (--max-memory)",
        context.zones.len(),
        bytes as f64 / 1e9,
        context.settings.memory_limit as f64 / 1e9
    );
    Err(SceneError::out_of_memory("solve.patch_size", what))
}

/// h of every unknown from the surroundings and from direct light, W/m².
fn outside_flux(blocks: &[BlockEngine], balances: &SpectralBalances, scaling: &CoupledScaling) -> Vec<Bands> {
    let surroundings: Vec<&SurroundingsExchange> = blocks.iter().map(|t| &t.surroundings).collect();
    let sky: Vec<Bands> = blocks.iter().map(|t| t.context.scene.surroundings().radiosity()).collect();
    let direct = blocks.iter().map(|t| {
        if t.context.direct.lights.is_empty() { Vec::new() } else { t.context.direct.fields(balances.len()) }
    });
    let direct: Vec<Vec<Bands>> = direct.collect();
    let one = |k: usize| {
        let (t, k) = scaling.place(k);
        let incoming = surroundings[t].incoming(k, sky[t])[0] * scaling.blocks[t].flux_over_power[k];
        match direct[t].get(k) {
            Some(light) => incoming + balances.first(k).incident_share * light,
            None => incoming,
        }
    };
    parallel::collect(scaling.len(), one)
}

/// The operators of all blocks with their scaling, with the higher-order unknowns or without them.
pub(super) fn coupled_operator<'a>(
    blocks: &'a [BlockEngine],
    balances: &SpectralBalances,
    coupling: BandCoupling,
    with_slopes: bool,
) -> CoupledOperator<'a> {
    let operators: Vec<&dyn ExchangeOperator> =
        blocks.iter().map(|t| t.built.operator.as_ref() as &dyn ExchangeOperator).collect();
    let scaling = |t: usize| {
        let slopes = if with_slopes { operators[t].slope_zones() } else { Vec::new() };
        PowerScaling::new(operators[t], blocks[t].context.zones, &balances.zones[t], coupling, &slopes)
    };
    let scaling = CoupledScaling::new((0..blocks.len()).map(scaling).collect());
    let is_shared = blocks[0].context.settings.communicator.size() > 1;
    CoupledOperator { operators, is_shared, scaling }
}

/// State of the iteration between two steps.
struct NewtonState {
    /// E of every zone, W/m².
    e: Vec<f64>,
    /// Powers of all unknowns, W.
    u: Vec<Bands>,
    products: usize,
    history: ConvergenceHistory,
}

impl NewtonState {
    /// Encodes the state as a stage.
    fn encode(&self) -> Vec<u8> {
        let history = &self.history;
        let mut encoder = Encoder::default();
        encoder.reals(&self.e);
        encoder.bands(&self.u);
        encoder.reals(&history.residuals);
        encoder.reals(&[history.best]);
        let status = history.status.and_then(|s| SolveStatus::VARIANTS.iter().position(|x| *x == s));
        [self.products, history.since_best, usize::from(history.halves_steps), status.map_or(0, |k| k + 1)]
            .into_iter()
            .for_each(|n| encoder.int(n));
        encoder.bytes()
    }

    /// Decodes a stage of [`NewtonState::encode`] for a number of zones and unknowns.
    fn decode(bytes: &[u8], zones: usize, unknowns: usize, wanted: f64) -> Option<NewtonState> {
        let mut decoder = Decoder::new(bytes);
        let (e, u, residuals) = (decoder.reals()?, decoder.bands()?, decoder.reals()?);
        let best = *decoder.reals()?.first()?;
        let [products, since_best, halved, status] =
            [decoder.int()?, decoder.int()?, decoder.int()?, decoder.int()?];
        let status = if status == 0 { None } else { Some(*SolveStatus::VARIANTS.get(status - 1)?) };
        let history =
            ConvergenceHistory { wanted, residuals, best, since_best, halves_steps: halved > 0, status };
        let fits = decoder.at_end() && e.len() == zones && u.len() == unknowns;
        fits.then_some(NewtonState { e, u, products, history })
    }
}

/// Residuals and status of the iteration.
struct ConvergenceHistory {
    wanted: f64,
    residuals: Vec<f64>,
    best: f64,
    /// Steps since the smallest residual.
    since_best: usize,
    halves_steps: bool,
    status: Option<SolveStatus>,
}

impl ConvergenceHistory {
    fn new(wanted: f64) -> ConvergenceHistory {
        ConvergenceHistory {
            wanted,
            residuals: Vec::new(),
            best: f64::INFINITY,
            since_best: 0,
            halves_steps: false,
            status: None,
        }
    }
    /// Fraction of a Newton step that is taken.
    fn step_length(&self) -> f64 {
        if self.halves_steps { 0.5 } else { 1.0 }
    }
    /// Wanted residual of the next linear solve; `is_linear` if no band fraction depends on temperature, so that one step is enough.
    fn linear_residual(&self, is_linear: bool) -> f64 {
        let least = LINEAR_RESIDUAL_OVER_RESIDUAL * self.wanted;
        let useful = match self.residuals.last() {
            _ if is_linear => least,
            None => FIRST_LINEAR_RESIDUAL,
            Some(r) => (LINEAR_RESIDUAL_OVER_RESIDUAL * r * r).min(FIRST_LINEAR_RESIDUAL),
        };
        // A residual that is no number asks for the most accurate solve.
        if useful > least { useful } else { least }
    }
    /// Records R of a step, and the residual of its linear solve, found and asked for.
    fn record(&mut self, off: f64, linear: f64, asked: f64) {
        self.residuals.push(off.max(linear));
        self.since_best = if off < self.best { 0 } else { self.since_best + 1 };
        self.best = self.best.min(off);
        self.halves_steps |= self.since_best >= MAX_STEPS_WITHOUT_PROGRESS;
        self.status = if off <= self.wanted && linear <= self.wanted {
            Some(SolveStatus::Converged)
        } else if off <= self.wanted && asked <= LINEAR_RESIDUAL_OVER_RESIDUAL * self.wanted
            || self.since_best >= MAX_STEPS_BEFORE_STALL
            || !off.is_finite()
        {
            Some(SolveStatus::Stalled)
        } else {
            (self.residuals.len() >= MAX_STEPS).then_some(SolveStatus::MaxIterations)
        };
    }
}

/// The update of the black emissive powers after a linear solve.
struct EmissiveUpdate<'a> {
    balances: &'a SpectralBalances<'a>,
    linearized: &'a Linearization,
    nodes: Option<&'a NodeZones<'a>>,
    /// E of all zones, then of all nodes, about which the step was linearized, W/m².
    old: &'a [f64],
}

impl EmissiveUpdate<'_> {
    /// E after the step, and R. `h` gives the incident flux of a block and a zone.
    fn run(&self, h: impl Fn(usize, usize) -> Bands + Sync, step_length: f64) -> (Vec<f64>, f64) {
        let (balances, count) = (self.balances, self.balances.len());
        let (found, response) = match self.nodes {
            Some(nodes) => {
                let absorbed = nodes.absorbed(balances, &h);
                let found = nodes.balance(balances, &absorbed, &self.old[count..]);
                (found, self.linearized.node_response(|| absorbed))
            }
            None => (Vec::new(), Vec::new()),
        };
        let old = self.old[count..].iter();
        let of_nodes: Vec<f64> =
            old.zip(&found).map(|(old, found)| old + step_length * (found - old)).collect();
        let one = |i: usize| self.zone(i, |t| h(t, i), step_length, &of_nodes, &response);
        let all: Vec<(f64, [f64; 2])> = parallel::collect(count, one);
        let [off, given] = multivector::sum(all.len(), |i| all[i].1);
        let e = all.into_iter().map(|x| x.0).chain(of_nodes).collect();
        (e, if given > 0.0 { off / given } else { 0.0 })
    }
    /// E of a zone after the step, and its terms of the sums of R. `of_nodes` are the new E of the nodes, and `response` their changes by the linearization.
    fn zone(
        &self,
        i: usize,
        h: impl Fn(usize) -> Bands,
        step_length: f64,
        of_nodes: &[f64],
        response: &[f64],
    ) -> (f64, [f64; 2]) {
        let (balances, old) = (self.balances, self.old[i]);
        let first = balances.first(i);
        let change = match first.node {
            Some(k) => response[k as usize],
            None => self.linearized.absorbed(i, &h),
        };
        let e = match (first.node, first.condition) {
            (Some(k), _) => of_nodes[k as usize],
            (None, ThermalCondition::Temperature(_)) => old,
            (None, ThermalCondition::Flux(q) | ThermalCondition::Power(q)) => {
                let found = balances.emissive_power_in_balance(i, q, &h).unwrap_or(old);
                // A linear balance is solved by one step.
                let (low, high) = if balances.is_linear(i) || found.is_nan() || found <= 0.0 {
                    (f64::NEG_INFINITY, f64::INFINITY)
                } else {
                    (old.max(0.0) / MAX_CHANGE_FACTOR, old.max(1e-3 * found) * MAX_CHANGE_FACTOR)
                };
                (old + step_length * (found - old)).clamp(low, high)
            }
        };
        let (mut off, mut all) = (0.0, 0.0);
        for t in 0..balances.blocks() {
            let zone = &self.linearized.blocks[t][i];
            let (l, w) = (&balances.zones[t][i], balances.emissive_powers(t, i, e));
            // Emission in each band by the linearization.
            let linear = zone.own + zone.reemitted * change;
            off += (l.weight * (l.absorb * w - linear).abs()).sum();
            all += (l.absorption_weight() * w.abs()).sum();
        }
        let moves = !matches!(first.condition, ThermalCondition::Temperature(_));
        (e, [if moves { off * first.measure } else { 0.0 }, all * first.measure])
    }
}
