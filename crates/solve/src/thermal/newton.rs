//! Temperatures of scenes with coupled bands: Newton's method for E with a linear solve of all bands in each step.
//!
//! About E⁰ a zone of known power emits w_b(E) ≈ w_b⁰ + ψ_b (E − E⁰), ψ = dw/dE. Its balance gives E from the incident flux, hence
//!
//! ```text
//!     B_b = a_b [ w_b⁰ + ψ_b (q − Σ_c m_c a_c w_c⁰)/S ] + r_b h_b + a_b ψ_b Σ_c m_c a_c h_c / S          S = Σ_c m_c a_c ψ_c
//! ```
//!
//! which is linear in the incident flux: light of one band is absorbed and reemitted in all bands, and power is conserved. Constant band fractions
//! are solved by one step. Otherwise E is updated and the next step is taken about it. The residual is the emission that the linearization
//! assigns to wrong bands, relative to all emission:
//!
//! ```text
//!     R = Σ_i V_i Σ_b m_b a_b |w_b(E) − w_b⁰ − ψ_b (E − E⁰)| / Σ_i V_i Σ_b m_b a_b |w_b(E)|
//! ```
//!
//! Safeguards: a step changes E by at most a factor [`MAX_CHANGE_FACTOR`]; where fractions decrease so fast that ψ_b < 0, ψ = a(T) replaces it
//! (Picard iteration); steps are halved when R no longer decreases. Every step is a stage of a checkpoint, and so is the linear solve in it.

use super::boundary_conditions::set_emissive_powers;
use super::coupled_bicgstab::{self, IterationCheckpoint};
use super::linearized_zone::{BandCoupling, LinearizedZone, PowerScaling};
use super::zone_balance::{ZoneBalance, ZoneBalances};
use crate::iteration::{IterationResult, StoppingCriterion, multivector};
use crate::operator::ExchangeOperator;
use crate::settings::check_interrupted;
use crate::solve_context::{BuiltEngine, SolveContext};
use crate::stage_codec::{Decoder, Encoder};
use crate::surroundings::SurroundingsExchange;
use rayon::prelude::*;
use zonal_scene::thermal::blackbody_emissive_power;
use zonal_scene::{BandFractions, Bands, PerBand, Scene, SceneError, SolveStatus, ThermalCondition, Zones};

/// Maximum number of steps.
const MAX_STEPS: usize = 60;
/// Steps without a smaller residual after which steps are halved, and after which the iteration has stalled.
const MAX_STEPS_WITHOUT_PROGRESS: usize = 4;
const MAX_STEPS_BEFORE_STALL: usize = 20;
/// Largest factor by which E grows or falls in a step.
const MAX_CHANGE_FACTOR: f64 = 5.0;
/// Residual of the linear solves over that of the temperatures.
const LINEAR_RESIDUAL_OVER_RESIDUAL: f64 = 0.1;
/// Bytes of an unknown: its balance, its linearization, the vectors of the linear solve, and those of them that are saved as a stage.
const BYTES_PER_UNKNOWN: u64 = 400 + 12 * 24 + 5 * 24;
/// Names of the stages: temperatures after each step, and the linear solve of a step.
const STAGE: &str = "state-temperatures";
const LINEAR_STAGE: &str = "state-temperatures-linear";

/// Solution of a scene with coupled bands.
pub(crate) struct CoupledSolution {
    /// Zones with the emission of the temperatures found.
    pub zones: Zones,
    /// Strengths, with the status of the iteration over temperatures in every band.
    pub result: IterationResult,
    /// Number of products with the operator.
    pub products: usize,
}

/// True if some zone has a known net power and the scene is not grey.
pub(crate) fn is_needed(scene: &Scene) -> bool {
    let Some(thermal) = scene.thermal() else { return false };
    let open = |k: &ThermalCondition| !matches!(k, ThermalCondition::Temperature(_));
    let cells =
        || scene.voxel_grid().is_some_and(|m| (0..m.len()).any(|i| m.heat(i).as_ref().is_some_and(open)));
    !thermal.band_fractions.is_grey()
        && (thermal.surfaces.iter().any(open) || thermal.panes.iter().any(open) || cells())
}

/// Iterates over the temperatures of a scene.
///
/// # Errors
/// If the iteration exceeds the memory limit, or if the observer interrupts it.
pub(crate) fn solve(
    context: &SolveContext,
    built: &BuiltEngine,
    surroundings: &SurroundingsExchange,
) -> Result<CoupledSolution, SceneError> {
    let (scene, operator) = (context.scene, built.operator.as_ref());
    check_memory(context, operator.len())?;
    let table = ZoneBalances::new(scene, context.zones);
    let (fractions, balances) = (&table.thermal.band_fractions, table.all(context.zones));
    let scaling = PowerScaling::new(
        operator,
        context.zones,
        &balances,
        BandCoupling::Distinct,
        &operator.slope_zones(),
    );
    let iteration = NewtonIteration {
        context,
        operator,
        fractions,
        balances: &balances,
        outside: outside_flux(context, surroundings, &scaling),
        scaling: &scaling,
        residual: scene.options().residual,
    };
    let NewtonState { e, u, products, history } = iteration.run(table.initial_temperature())?;
    // Set the emission of the zones by their temperatures.
    let mut zones = context.zones.clone();
    let emissive: Vec<Bands> = e.iter().map(|e| fractions.emissive_powers(*e)[0]).collect();
    set_emissive_powers(scene, &mut zones, &emissive);
    let result = IterationResult {
        strengths: scaling.strengths(&u),
        status: PerBand::splat(history.status.unwrap_or(SolveStatus::MaxIterations)),
        residuals: PerBand::splat(history.residuals),
        power: Bands::splat(coupled_bicgstab::absolute_sum(&u)),
    };
    Ok(CoupledSolution { zones, result, products })
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
    operator: &'a dyn ExchangeOperator,
    fractions: &'a BandFractions,
    balances: &'a [ZoneBalance],
    scaling: &'a PowerScaling,
    /// h of every unknown from the surroundings, W/m².
    outside: Vec<Bands>,
    /// Wanted residual R.
    residual: f64,
}

impl NewtonIteration<'_> {
    /// Takes steps from the state of a checkpoint, or from a uniform temperature (K), until the iteration has ended.
    ///
    /// # Errors
    /// If the observer interrupts the iteration; the state of the step that it interrupts is not saved.
    fn run(&self, initial_temperature: f64) -> Result<NewtonState, SceneError> {
        let (context, balances) = (self.context, self.balances);
        let initial = blackbody_emissive_power(initial_temperature);
        let kept = context.checkpoints.load(STAGE);
        let kept =
            kept.and_then(|b| NewtonState::decode(&b, balances.len(), self.outside.len(), self.residual));
        let mut state = kept.unwrap_or_else(|| NewtonState {
            e: balances.iter().map(|l| known_emissive_power(l).unwrap_or(initial)).collect(),
            u: Vec::new(),
            products: 0,
            history: ConvergenceHistory::new(self.residual),
        });
        let first = state.history.residuals.len();
        context.progress.begin("temperatures", MAX_STEPS as u64);
        context.progress.advance(first as u64);
        while state.history.status.is_none() {
            state = self.step(state, first);
            check_interrupted(context.progress)?;
            if context.checkpoints.keeps() {
                context.checkpoints.save(STAGE, &state.encode());
            }
            context.progress.advance(1);
        }
        context.progress.end();
        Ok(state)
    }

    /// One step: a linear solve about E, and the emissive powers that follow. `first` is the number of steps before a resumed iteration.
    fn step(&self, state: NewtonState, first: usize) -> NewtonState {
        let NewtonState { e, u, products, mut history } = state;
        let (balances, scaling, outside) = (self.balances, self.scaling, &self.outside);
        let linearized: Vec<LinearizedZone> =
            balances.par_iter().zip(&e).map(|(l, e)| LinearizedZone::of(l, self.fractions, *e)).collect();
        // Sources of the zones and of the surroundings; higher-order unknowns have no source of their own.
        let source = |k: usize| {
            let zone = &linearized[scaling.zone(k)];
            let own = if k < balances.len() { zone.own } else { Bands::ZERO };
            let sky = zone.reflected(outside[k]);
            scaling.power_of(k, own + sky)
        };
        let source: Vec<Bands> = (0..outside.len()).into_par_iter().map(source).collect();
        // Solve the linear system from the last solution.
        let reflect = |u: &[Bands]| scaling.reflect(self.operator, u, |i, h| linearized[i].reflected(h));
        let start = if u.is_empty() { source.clone() } else { u };
        let number = history.residuals.len();
        let checkpoint = IterationCheckpoint {
            store: self.context.checkpoints,
            stage: LINEAR_STAGE,
            number,
            resumes: number == first,
            progress: self.context.progress,
        };
        let max_iterations = self.context.scene.options().max_iterations;
        let stop =
            StoppingCriterion { residual: LINEAR_RESIDUAL_OVER_RESIDUAL * self.residual, max_iterations };
        let end = coupled_bicgstab::solve(reflect, &source, start, stop, &checkpoint);
        // Update the emissive powers.
        let h = scaling.incident_flux(self.operator, &end.u);
        let incident = |i: usize| h[i] + outside[i];
        let (e, off) = update_emissive_powers(balances, self.fractions, &e, incident, history.step_length());
        history.record(off, end.residual);
        NewtonState { e, u: end.u, products: products + end.products + 1, history }
    }
}

/// Refuses an iteration that exceeds the memory limit.
fn check_memory(context: &SolveContext, unknowns: usize) -> Result<(), SceneError> {
    let bytes = BYTES_PER_UNKNOWN * unknowns as u64;
    if bytes <= context.memory_limit {
        return Ok(());
    }
    let what = format!(
        "the iteration over temperatures of {} zones needs {:.3} GB, more than the {:.3} GB allowed; use larger patches or fewer cells, or allow more (--max-memory)",
        context.zones.len(),
        bytes as f64 / 1e9,
        context.memory_limit as f64 / 1e9
    );
    Err(SceneError::out_of_memory("solve.patch_size", what))
}

/// h of every unknown from the surroundings, W/m².
fn outside_flux(
    context: &SolveContext,
    surroundings: &SurroundingsExchange,
    scaling: &PowerScaling,
) -> Vec<Bands> {
    let sky = context.scene.surroundings().radiosity();
    let one = |k: usize| surroundings.incoming(k, sky)[0] * scaling.flux_over_power[k];
    (0..scaling.flux_over_power.len()).into_par_iter().map(one).collect()
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
    /// Records R of a step, and the residual of its linear solve.
    fn record(&mut self, off: f64, linear: f64) {
        self.residuals.push(off.max(linear));
        self.since_best = if off < self.best { 0 } else { self.since_best + 1 };
        self.best = self.best.min(off);
        self.halves_steps |= self.since_best >= MAX_STEPS_WITHOUT_PROGRESS;
        self.status = if off <= self.wanted {
            Some(if linear <= self.wanted { SolveStatus::Converged } else { SolveStatus::Stalled })
        } else if self.since_best >= MAX_STEPS_BEFORE_STALL || !off.is_finite() {
            Some(SolveStatus::Stalled)
        } else {
            (self.residuals.len() >= MAX_STEPS).then_some(SolveStatus::MaxIterations)
        };
    }
}

/// E after a step, and R.
fn update_emissive_powers(
    balances: &[ZoneBalance],
    fractions: &BandFractions,
    old: &[f64],
    h: impl Fn(usize) -> Bands + Sync,
    step_length: f64,
) -> (Vec<f64>, f64) {
    let one = |i: usize| {
        let l = &balances[i];
        let (linearized, absorption) = (LinearizedZone::of(l, fractions, old[i]), l.absorption_weight());
        let absorbed = (linearized.absorption * h(i)).sum();
        // Emission in each band by the linearization.
        let linear = linearized.own + linearized.reemitted * absorbed;
        let e = match l.condition {
            ThermalCondition::Temperature(_) => old[i],
            ThermalCondition::Flux(q) | ThermalCondition::Power(q) => {
                let found = l.emissive_power_in_balance(fractions, q, h(i)).unwrap_or(old[i]);
                // Constant band fractions are linear already.
                let (low, high) = if fractions.is_constant() || found.is_nan() || found <= 0.0 {
                    (f64::NEG_INFINITY, f64::INFINITY)
                } else {
                    (old[i].max(0.0) / MAX_CHANGE_FACTOR, old[i].max(1e-3 * found) * MAX_CHANGE_FACTOR)
                };
                (old[i] + step_length * (found - old[i])).clamp(low, high)
            }
        };
        let w = fractions.emissive_powers(e)[0];
        let off = (l.weight * (l.absorb * w - linear).abs()).sum();
        let all = (absorption * w.abs()).sum();
        let moves = !matches!(l.condition, ThermalCondition::Temperature(_));
        (e, [if moves { off * l.measure } else { 0.0 }, all * l.measure])
    };
    let all: Vec<(f64, [f64; 2])> = (0..balances.len()).into_par_iter().map(one).collect();
    let [off, given] = multivector::sum(all.len(), |i| all[i].1);
    (all.into_iter().map(|x| x.0).collect(), if given > 0.0 { off / given } else { 0.0 })
}
