//! Construction of the ray engine's solution for a tolerance: a few stored rays of every zone, the solution by them, and a final gather.

use super::memory_budget::MemoryBudget;
use crate::balance::closure;
use crate::context::{BuiltEngine, SolveContext};
use crate::distribution::sum_order::SharedZones;
use crate::engines::rays::gather::final_gather::Gathered;
use crate::engines::rays::gather::zone_gather::GatheredSky;
use crate::engines::rays::ray_operator::{OutsideRadiation, PathContinuation, RayOperator, light_factors};
use crate::engines::rays::stored_rays::padded_bands::PaddedBands;
use crate::engines::rays::stored_rays::ray_sampling::{
    COARSE_TOLERANCE, RaysPerZone, is_large, rays_measure_escape, rays_per_zone, rays_without_gather,
};
use crate::engines::tolerance_advice;
use crate::errors::direct_error::reflected_error;
use crate::errors::estimate::error_estimate;
use crate::iteration::IterationResult;
use crate::operator::IncidentPower;
use crate::right_hand_side::surroundings::SurroundingsExchange;
use crate::settings::{SolveSettings, check_interrupted};
use std::cmp::Ordering;
use zonal_exchange::pair::closure_target;
use zonal_math::Grade;
use zonal_scene::{Bands, Diagnostic, Engine, ErrorParts, Fields, Scene, SceneError};

/// Error by the noise of the radiosities over the tolerance above which more rays are traced, and the share that they aim at. The gather states
/// 1.6 times this error.
const MAX_NOISE_SHARE: f64 = 0.4;
const WANTED_NOISE_SHARE: f64 = 0.25;

/// Builds the engine for all light groups of a scene.
///
/// # Errors
/// If the scene has no zones, if memory allows too few rays, or if the solve is interrupted.
pub(crate) fn build<'a>(
    context: &SolveContext<'a>,
    surroundings: &mut SurroundingsExchange,
) -> Result<BuiltEngine<'a>, SceneError> {
    let (scene, zones, tolerance) = (context.scene, context.zones, context.scene.options().tolerance);
    if zones.is_empty() {
        return Err(SceneError::new("scene", "the scene has no zones; add a surface or a medium"));
    }
    let budget = MemoryBudget::new(scene, zones, context.transport, context.settings.memory_limit);
    let rays = budget.affordable_rays(zones, tolerance).ok_or_else(|| {
        SceneError::out_of_memory("solve.patch_size", "memory allows too few rays; allow more (--max-memory)")
    })?;
    let mut warnings: Vec<Diagnostic> = budget.ray_warning(zones, tolerance, rays).into_iter().collect();
    let rays = if context.settings.final_gather { rays } else { rays_without_gather(rays) };
    let (operator, solution) =
        trace_and_solve(context, surroundings, rays, budget.max_rays, continuation_of(scene))?;
    let closure = closure::measure(&operator, SharedZones::alone(zones), surroundings);
    let [traced, vertices] = operator.rays_and_vertices();
    let mut counts = vec![("transport_rays".into(), traced), ("rays that went on".into(), vertices)];
    let (mut solved, mut error_parts) = (None, None);
    match solution {
        Some(stored) if context.settings.final_gather => {
            let (gathered, columns) =
                gather(context, surroundings, &operator, stored, traced, &mut warnings)?;
            counts.push(("samples of the final gather".into(), gathered.samples));
            (solved, error_parts) = (Some(columns), Some(gathered.parts));
        }
        Some(StoredSolution { results, strengths, incident, noise }) => {
            let incident = operator.stored_power(&strengths, incident, &noise);
            solved = Some(solved_columns(results, strengths, incident));
        }
        None => {}
    }
    Ok(BuiltEngine { operator: Box::new(operator), closure, counts, warnings, solved, error_parts })
}

/// Numbers of a final gather beside the solution.
struct GatherSummary {
    /// Samples of all zones.
    samples: u64,
    /// The parts of the error of the patches, and of the volume zones and panes.
    parts: [ErrorParts; 2],
}

/// The solution by a final gather from that of the stored rays, of which there are `traced`; a missed tolerance is added to `warnings`.
fn gather(
    context: &SolveContext,
    surroundings: &mut SurroundingsExchange,
    operator: &RayOperator,
    stored: StoredSolution,
    traced: u64,
    warnings: &mut Vec<Diagnostic>,
) -> Result<(GatherSummary, (Vec<IterationResult>, IncidentPower)), SceneError> {
    let (scene, zones, tolerance) = (context.scene, context.zones, context.scene.options().tolerance);
    let StoredSolution { results, strengths, incident: stored, noise } = stored;
    let sky = scene.surroundings().radiosity();
    let gathered_sky = gathered_sky(context, surroundings);
    let mut known = known_radiation(context, surroundings, gathered_sky.is_some());
    add_error_of_direct_light(context, operator, &stored, &mut known);
    let SolveSettings { checkpoints, progress, .. } = context.settings;
    let direct = |i: usize| context.direct.lights.iter().map(|l| l.fields[i]).sum::<Bands>();
    let all = |i: usize| stored.iter().map(|c| c[i]).sum::<Bands>() + known[i][0] + direct(i);
    let thickness = operator.error_of_thick_panes(all, progress);
    let light_factors = context.sources.iter().map(|s| light_factors(context, s)).collect();
    let outside = OutsideRadiation { known: &known, sky: gathered_sky, thickness, light_factors };
    let mut gathered =
        operator.gather_incident(&strengths, &|| stored.clone(), noise, outside, checkpoints, progress);
    check_interrupted(context.settings.progress)?;
    if !gathered.sky.is_empty() {
        surroundings.set_incident(&gathered.sky, sky, |i| zones.response(i).1, traced + gathered.rays());
        known.iter_mut().zip(&gathered.sky).for_each(|(k, sky)| k[0] = *sky);
    }
    operator.solve_pane_self_exchange(&stored, &mut gathered);
    let error = relative_error(context, &gathered, &known).max(gathered.relative_error);
    if error > tolerance {
        warnings.push(tolerance_missed(error, tolerance, &gathered.parts, warnings));
    }
    let summary = GatherSummary { samples: gathered.samples, parts: gathered.parts };
    let incident = operator.incident_power_of(gathered);
    Ok((summary, solved_columns(results, strengths, incident)))
}

/// H or G of every zone from the surroundings, W/m², and its error: none where a gather samples them.
fn known_radiation(
    context: &SolveContext,
    surroundings: &SurroundingsExchange,
    is_gathered: bool,
) -> Vec<[Bands; 2]> {
    let (zones, sky) = (context.zones, context.scene.surroundings().radiosity());
    let known = |i: usize| {
        if is_gathered {
            [Bands::ZERO; 2]
        } else {
            surroundings.incoming(i, sky).map(|v| v / zones.response(i).1)
        }
    };
    (0..zones.len()).map(known).collect()
}

/// The results of all groups with their strengths, and their incident power.
fn solved_columns(
    mut results: Vec<IterationResult>,
    strengths: Vec<Vec<Bands>>,
    incident: IncidentPower,
) -> (Vec<IterationResult>, IncidentPower) {
    results.iter_mut().zip(strengths).for_each(|(e, s)| e.strengths = s);
    (results, incident)
}

/// Paths end at the first zone where a fixed scattering order counts exchanges between zones, and where temperatures couple the bands, so that the
/// sources at path vertices are unknown.
fn continuation_of(scene: &Scene) -> PathContinuation {
    let continues = scene.options().scattering_orders.is_none() && !scene.couples_bands();
    if continues { PathContinuation::On } else { PathContinuation::Off }
}

/// The surroundings as a gather samples them, where the stored rays measured them; these give the shares of the zones.
fn gathered_sky(context: &SolveContext, surroundings: &SurroundingsExchange) -> Option<GatheredSky> {
    let (scene, zones) = (context.scene, context.zones);
    if !rays_measure_escape(scene, zones) || !scene.surroundings().has_radiance() {
        return None;
    }
    let share = |i: usize| (surroundings.sky_of(i) / closure_target(zones, i)).mean();
    Some(GatheredSky {
        radiosity: scene.surroundings().radiosity(),
        column: context.sources.iter().position(|s| s.sky(scene) != Bands::ZERO)?,
        shares: (0..zones.len()).map(share).collect(),
    })
}

/// Traces rays of every zone; they measure the exchange with the surroundings where zones are many.
fn trace<'a>(
    context: &SolveContext<'a>,
    surroundings: &mut SurroundingsExchange,
    rays: RaysPerZone,
    continuation: PathContinuation,
) -> Result<RayOperator<'a>, SceneError> {
    let operator = RayOperator::new(context, rays, continuation);
    check_interrupted(context.settings.progress)?;
    if rays_measure_escape(context.scene, context.zones) {
        operator.measure_escape(surroundings);
    }
    Ok(operator)
}

/// Traces rays and solves by them, with more rays where the noise of the radiosities would reach too much of the result. No solution where temperatures
/// couple the bands.
fn trace_and_solve<'a>(
    context: &SolveContext<'a>,
    surroundings: &mut SurroundingsExchange,
    rays: RaysPerZone,
    max_rays: f64,
    continuation: PathContinuation,
) -> Result<(RayOperator<'a>, Option<StoredSolution>), SceneError> {
    let mut operator = trace(context, surroundings, rays, continuation)?;
    if context.scene.couples_bands() {
        return Ok((operator, None));
    }
    let mut solution = StoredSolution::new(context, surroundings, &mut operator)?;
    if let Some(more) = solution.more_rays(context, &operator, rays, max_rays) {
        operator = trace(context, surroundings, more, continuation)?;
        solution = StoredSolution::new(context, surroundings, &mut operator)?;
    }
    Ok((operator, Some(solution)))
}

/// The solution by the stored rays.
struct StoredSolution {
    /// Results of the iteration without the strengths.
    results: Vec<IterationResult>,
    /// Strengths of every group.
    strengths: Vec<Vec<Bands>>,
    /// H or G of every group by the stored rays, W/m².
    incident: Vec<Vec<Bands>>,
    /// One realization of the noise of the radiosities of all groups together, W/m².
    noise: Vec<PaddedBands>,
}

impl StoredSolution {
    fn new(
        context: &SolveContext,
        surroundings: &SurroundingsExchange,
        operator: &mut RayOperator,
    ) -> Result<StoredSolution, SceneError> {
        let mut results = operator.solve_groups(context, surroundings);
        check_interrupted(context.settings.progress)?;
        let strengths: Vec<Vec<Bands>> =
            results.iter_mut().map(|e| std::mem::take(&mut e.strengths)).collect();
        let incident = operator.stored_fields(&strengths);
        let noise = operator.radiosity_noise(&strengths, context.settings.progress);
        check_interrupted(context.settings.progress)?;
        Ok(StoredSolution { results, strengths, incident, noise })
    }

    /// The numbers of rays with which the noise of the radiosities has its share of the tolerance; `None` where `rays` suffice or are the most, for
    /// coarse tolerances, and for large scenes, whose few rays of each zone show too much noise: the gather states what reaches the result.
    fn more_rays(
        &self,
        context: &SolveContext,
        operator: &RayOperator,
        rays: RaysPerZone,
        max_rays: f64,
    ) -> Option<RaysPerZone> {
        let (zones, tolerance) = (context.zones, context.scene.options().tolerance);
        if is_large(zones) || tolerance > COARSE_TOLERANCE {
            return None;
        }
        let fields = Fields {
            error: operator.incident_noise(&self.noise),
            incident: (0..zones.len()).map(|i| self.incident.iter().map(|c| c[i]).sum()).collect(),
            ..Fields::default()
        };
        let e = error_estimate(SharedZones::alone(zones), &fields, Grade::Estimated);
        let noise = e.patches.iter().chain(&e.volumes).fold(0.0, |m: f64, x| m.max(*x));
        if noise.partial_cmp(&(MAX_NOISE_SHARE * tolerance)) != Some(Ordering::Greater) {
            return None;
        }
        let growth = (noise / (WANTED_NOISE_SHARE * tolerance)).powi(2);
        let more = rays_per_zone(zones, tolerance / growth, max_rays);
        (more[0] > rays[0]).then_some(more)
    }
}

/// Adds to the errors of `known` radiation that of reflected direct light, by the incident radiation `stored` of every group by the stored rays.
fn add_error_of_direct_light(
    context: &SolveContext,
    operator: &RayOperator,
    stored: &[Vec<Bands>],
    known: &mut [[Bands; 2]],
) {
    for (source, incident) in context.sources.iter().zip(stored) {
        let more =
            reflected_error(context.shared_zones(), operator, source, context.direct, &|i| incident[i]);
        known.iter_mut().zip(more).for_each(|(k, e)| k[1] = k[1].hypot(e));
    }
}

/// Estimated relative error with the radiation from the surroundings, the largest over kinds of zones and bands.
fn relative_error(context: &SolveContext, gathered: &Gathered, known: &[[Bands; 2]]) -> f64 {
    let sum = |i: usize| gathered.columns.iter().map(|c| c[i]).sum::<Bands>();
    let fields = Fields {
        error: gathered.error.iter().zip(known).map(|(e, k)| e.hypot(k[1])).collect(),
        incident: (0..known.len()).map(|i| sum(i) + known[i][0]).collect(),
        ..Fields::default()
    };
    let e = error_estimate(SharedZones::alone(context.zones), &fields, Grade::Estimated);
    e.patches.iter().chain(&e.volumes).fold(0.0, |m, x| m.max(*x))
}

/// The warning of a gather that misses the tolerance, with the part of the error that is the cause; `reported` has the earlier warnings of the engine.
fn tolerance_missed(
    estimate: f64,
    tolerance: f64,
    parts: &[ErrorParts; 2],
    reported: &[Diagnostic],
) -> Diagnostic {
    if estimate.is_infinite() {
        return Diagnostic::warning(
            "tolerance",
            "no ray met light, though surfaces or media that send some lie in front of others: the errors are absolute; use a smaller tolerance for more rays",
        );
    }
    let worst = |part: fn(&ErrorParts) -> f64| part(&parts[0]).max(part(&parts[1]));
    let (sampling, direct) = (worst(|p| p.sampling.max(p.radiosities)), worst(|p| p.direct));
    let zoning = worst(|p| p.zoning);
    let advice = if reported.iter().any(|d| d.code == "memory") {
        tolerance_advice(Engine::Rays, reported)
    } else if zoning > sampling.max(direct) {
        "most of it is light that varies within zones, or over the thickness of panes that scatter; use smaller patches and cells where shadows and beams fall and near lamps, and a lower albedo of dark panes"
    } else if direct > sampling {
        "most of it is that of the surroundings and of reflected direct light; a smaller tolerance samples them more"
    } else {
        "rays or samples are at their maximum; use a larger tolerance, a smaller one has no effect"
    };
    let text = format!("the estimated error, {estimate:.1e}, is above the tolerance {tolerance}: {advice}");
    Diagnostic::warning("tolerance", text)
}
