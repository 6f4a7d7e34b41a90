//! Emissivities that depend on temperature, ε_i = ε(T_i): a fixed-point iteration over solves with given reflectances.
//!
//! ```text
//!     f_i(T) = G_i(T) − T_i = 0          s_i = Δf_i/ΔT_i          T_i ← T_i − f_i/s_i          d = max_i |ρ(G_i) − ρ(T_i)|
//! ```
//!
//! G are the temperatures of the solve with the reflectances at T. No factor depends on a reflectance: the factors of the first solve serve all
//! others. Every patch takes secant steps of its own, within a bracket once f has had both signs; the first step goes to G. The iteration ends when d is
//! at most the residual of the scene. A solve takes its reflectances as exact, and an error δT of its temperatures changes them: with
//! s = dG/dT − 1 the errors of the fixed point are those of the solve over −s, and here never less than those of the solve. What the last change
//! leaves is added as an error of the emissivity: to powers times the power that the patches emit, to temperatures by δT/T = δε/(4ε). If the
//! iteration does not converge, the errors are unknown.

use super::spectral_balance::{BlockZones, SpectralBalances};
use crate::context::zonal_solution::ZonalSolution;
use crate::settings::{SolveSettings, check_interrupted};
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};
use zonal_scene::checkpoint_store::STATE_STAGE_PREFIX;
use zonal_scene::thermal::blackbody_emissive_power;
use zonal_scene::{
    CheckpointStore, Diagnostic, Scene, SceneError, SurfaceEmissivity, ThermalCondition, Zones,
};

/// Maximum number of solves.
const MAX_SOLVES: u64 = 60;
/// Change of T, relative to it, from which a slope is measured: smaller ones show the residual of the solves.
const MIN_STEP_OF_SLOPE: f64 = 1e-4;
/// Largest slope of a fixed point that is stable enough for an estimate of errors, and the factor of errors where the slope is unknown.
const LARGEST_SLOPE: f64 = -0.05;
const FACTOR_OF_UNKNOWN_SLOPE: f64 = 2.0;
/// Decrease of f in a step beyond which a bracket is halved.
const SLOW_DECREASE: f64 = 0.5;

/// Solves a scene on zones of all blocks of bands by `solve`, which takes zones with the reflectances of their temperatures.
///
/// # Errors
/// Those of `solve`, and if the observer interrupts the iteration.
pub(crate) fn solve(
    scenes: &[Scene],
    mut zones: Vec<Zones>,
    settings: &SolveSettings,
    solve: impl Fn(Vec<Zones>, &SolveSettings) -> Result<Vec<ZonalSolution>, SceneError>,
) -> Result<Vec<ZonalSolution>, SceneError> {
    let scene = &scenes[0];
    let Some(thermal) = scene.thermal().filter(|t| t.has_varied_emissivities()) else {
        return solve(zones, settings);
    };
    let mut temperatures = known_temperatures(scenes, &zones);
    if !thermal.emissivities.iter().any(SurfaceEmissivity::depends_on_temperature) {
        set_reflectances(scenes, &mut zones, &temperatures);
        return solve(zones, settings);
    }
    let stages = FactorStages { inner: settings.checkpoints, kept: Mutex::default() };
    let memory_limit = settings.memory_limit / 2;
    let own_settings = SolveSettings { checkpoints: &stages, memory_limit, ..*settings };
    let mut patches: Vec<PatchSecant> = temperatures.iter().map(|t| PatchSecant::at(*t)).collect();
    let mut solves = 0;
    loop {
        solves += 1;
        set_reflectances(scenes, &mut zones, &temperatures);
        let mut solved = solve(zones.clone(), &own_settings)?;
        check_interrupted(settings.progress)?;
        // A patch without a temperature keeps its reflectance.
        let found = solved[0].fields.heat.as_ref().map_or(&[][..], |h| &h.temperature);
        let found = temperatures.iter().zip(found).map(|(t, g)| if g.is_finite() { *g } else { *t });
        let found: Vec<f64> = found.collect();
        let step = ReflectanceStep::of(scene, &zones[0], &found);
        let is_converged = step.change <= scene.options().residual;
        if is_converged || solves == MAX_SOLVES {
            let largest = patches.iter().map(PatchSecant::error_factor).fold(1.0, f64::max);
            let factor = if is_converged { largest } else { f64::INFINITY };
            widen(&mut solved, factor, &step);
            let count = ("solves for emissivities by temperature".to_string(), solves);
            solved[0].report.counts.push(count);
            if factor.is_infinite() {
                solved[0].report.warnings.push(Diagnostic::warning(
                    "emissivity-by-temperature",
                    "temperatures and the emissivities that depend on them do not converge, and their errors are unknown; give a table that changes less with temperature",
                ));
            }
            return Ok(solved);
        }
        for ((patch, t), g) in patches.iter_mut().zip(&mut temperatures).zip(found) {
            *t = patch.step(g - *t);
        }
    }
}

/// Secant iteration for the temperature of one patch.
struct PatchSecant {
    /// T, K.
    t: f64,
    /// T and f of the step before, K.
    before: Option<[f64; 2]>,
    /// Largest T with f > 0 and smallest T with f < 0, K.
    bracket: [Option<f64>; 2],
    /// s, as far as it has been measured.
    slope: Option<f64>,
}

impl PatchSecant {
    fn at(t: f64) -> PatchSecant {
        PatchSecant { t, before: None, bracket: [None; 2], slope: None }
    }
    /// The next temperature, K, after f at the present one.
    fn step(&mut self, f: f64) -> f64 {
        let t = self.t;
        if f == 0.0 {
            return t;
        }
        let side = usize::from(f < 0.0);
        self.bracket[side] = Some(t);
        if let [Some(low), Some(high)] = self.bracket
            && low >= high
        {
            // Other patches have moved the root.
            self.bracket[1 - side] = None;
        }
        let mut is_slow = false;
        if let Some([t0, f0]) = self.before {
            if (t - t0).abs() > MIN_STEP_OF_SLOPE * t {
                self.slope = Some((f - f0) / (t - t0));
            }
            is_slow = f.abs() > SLOW_DECREASE * f0.abs();
        }
        let slope = self.slope.filter(|s| *s < LARGEST_SLOPE).unwrap_or(-1.0);
        let mut next = t - f / slope;
        if let [Some(low), Some(high)] = self.bracket
            && (is_slow || !(low < next && next < high))
        {
            next = 0.5 * (low + high);
        }
        self.before = Some([t, f]);
        self.t = next.clamp(0.5 * t, 2.0 * t);
        self.t
    }
    /// Factor of the errors of its temperature; infinite if the fixed point is hardly stable.
    fn error_factor(&self) -> f64 {
        match self.slope {
            Some(s) if s < LARGEST_SLOPE => (-1.0 / s).max(1.0),
            Some(_) => f64::INFINITY,
            None if self.before.is_some() => FACTOR_OF_UNKNOWN_SLOPE,
            None => 1.0,
        }
    }
}

/// Sets the reflectances of patches at the known temperatures of their scene. No effect where no emissivity depends on temperature or side.
///
/// # Errors
/// If a patch whose emissivity depends on temperature has no known one.
pub(crate) fn set_known_reflectances(scene: &Scene, zones: &mut Zones) -> Result<(), SceneError> {
    let Some(thermal) = scene.thermal().filter(|t| t.has_varied_emissivities()) else { return Ok(()) };
    let is_open = |p: &zonal_scene::Patch| {
        !matches!(scene.facet_condition(p.facet), Some(ThermalCondition::Temperature(_)))
            && thermal.emissivities[p.surface].depends_on_temperature()
    };
    if let Some(p) = zones.patches.iter().find(|p| is_open(p)) {
        let key = format!("surface '{}'.emissivity", scene.surfaces()[p.surface].name);
        let what = "the emissivity depends on a temperature that only `zonal solve` finds; give a temperature, or one emissivity";
        return Err(SceneError::new(key, what));
    }
    let (scenes, own) = (std::slice::from_ref(scene), std::slice::from_mut(zones));
    let temperatures = known_temperatures(scenes, own);
    set_reflectances(scenes, own, &temperatures);
    Ok(())
}

/// The known temperature of each patch, or the initial temperature of the iteration, K.
fn known_temperatures(scenes: &[Scene], zones: &[Zones]) -> Vec<f64> {
    let blocks: Vec<BlockZones> =
        scenes.iter().zip(zones).map(|(scene, zones)| BlockZones { scene, zones }).collect();
    let balances = SpectralBalances::new(&blocks);
    let initial = balances.tables[0].initial_temperature();
    let of_patch = |i: usize| match balances.first(i).condition {
        ThermalCondition::Temperature(t) => t,
        _ => initial,
    };
    (0..zones[0].patches.len()).map(of_patch).collect()
}

/// Gives the patches of every block the reflectances at temperatures in K.
fn set_reflectances(scenes: &[Scene], zones: &mut [Zones], temperatures: &[f64]) {
    for (scene, zones) in scenes.iter().zip(zones) {
        zones.own_reflectances =
            zones.patches.iter().zip(temperatures).map(|(p, t)| scene.patch_reflectance(p, *t)).collect();
        for (p, own) in zones.patches.iter_mut().zip(&zones.own_reflectances) {
            p.reflectance = *own;
        }
    }
}

/// The change of the reflectances by the temperatures of a solve.
struct ReflectanceStep {
    /// d: largest change of a reflectance.
    change: f64,
    /// Largest relative change of an emissivity.
    relative_change: f64,
    /// Power that patches of changed reflectance emit, as if they were black, W.
    emitted: f64,
}

impl ReflectanceStep {
    /// From the reflectances of the zones of the first block to those at temperatures in K.
    fn of(scene: &Scene, zones: &Zones, temperatures: &[f64]) -> ReflectanceStep {
        let mut step = ReflectanceStep { change: 0.0, relative_change: 0.0, emitted: 0.0 };
        for ((p, t), old) in zones.patches.iter().zip(temperatures).zip(&zones.own_reflectances) {
            let new = scene.patch_reflectance(p, *t);
            let change = (new - *old).abs().max_element();
            if change > 0.0 {
                step.change = step.change.max(change);
                let relative =
                    new.zip_map(*old, |a, b| (a - b).abs() / (1.0 - a.max(b)).max(f64::MIN_POSITIVE));
                step.relative_change = step.relative_change.max(relative.max_element());
                step.emitted += p.area * blackbody_emissive_power(*t);
            }
        }
        step
    }
}

/// Widens the errors of temperatures and powers by a factor, and by what the last step leaves.
fn widen(solved: &mut [ZonalSolution], factor: f64, step: &ReflectanceStep) {
    let [of_power, of_temperature] = if factor.is_finite() {
        [factor * step.change * step.emitted, 0.25 * factor * step.relative_change]
    } else {
        [f64::INFINITY; 2]
    };
    let area: f64 = solved[0].zones.patches.iter().map(|p| p.area).sum();
    let widened = |error: f64, more: f64| if more.is_infinite() { more } else { factor * error + more };
    let first = &mut solved[0];
    if let Some(heat) = &mut first.fields.heat {
        heat.net_error.iter_mut().for_each(|e| *e = widened(*e, of_power / area));
        let kelvin = heat.temperature_error.iter_mut().zip(&heat.temperature).filter(|(e, _)| **e > 0.0);
        kelvin.for_each(|(e, t)| *e = widened(*e, of_temperature * t));
    }
    if let Some(heat) = &mut first.report.heat {
        for row in &mut heat.rows {
            row.power_error = widened(row.power_error, of_power);
            if let (Some(e), Some(t)) = (&mut row.temperature_error, row.temperature)
                && *e > 0.0
            {
                *e = widened(*e, of_temperature * t);
            }
        }
        for node in heat.nodes.iter_mut().filter(|n| n.temperature_error > 0.0) {
            node.temperature_error = widened(node.temperature_error, of_temperature * node.temperature);
        }
    }
}

/// Store that keeps the stages of factors in memory for the next solve, and in another store; states of an iteration are not kept.
struct FactorStages<'a> {
    inner: &'a dyn CheckpointStore,
    kept: Mutex<HashMap<String, Vec<u8>>>,
}

impl CheckpointStore for FactorStages<'_> {
    fn load(&self, stage: &str) -> Option<Vec<u8>> {
        if stage.starts_with(STATE_STAGE_PREFIX) {
            return None;
        }
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.get(stage).cloned().or_else(|| self.inner.load(stage))
    }
    fn save(&self, stage: &str, bytes: &[u8]) {
        if stage.starts_with(STATE_STAGE_PREFIX) {
            return;
        }
        if self.inner.keeps() {
            self.inner.save(stage, bytes);
        } else {
            self.kept.lock().unwrap_or_else(PoisonError::into_inner).insert(stage.into(), bytes.into());
        }
    }
}
