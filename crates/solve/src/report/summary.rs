//! Assembly of the report of a solve: status, counts, grade and diagnostics.

use crate::context::{BuiltEngine, SolveContext};
use crate::engines::problem_size::scene_diagnostics;
use crate::errors::estimate::error_estimate;
use crate::iteration::IterationResult;
use crate::right_hand_side::surroundings::SurroundingsExchange;
use zonal_math::Grade;
use zonal_scene::{Band, Diagnostic, EnergyBalance, Fields, PerBand, Report, SolveStatus, ZoneBasis, Zones};

/// The status of all groups together: the worst one in each band, and the residuals weighted with the power of the groups.
fn combine_results(results: &[IterationResult]) -> (PerBand<SolveStatus>, PerBand<Vec<f64>>) {
    let rank = |s: SolveStatus| SolveStatus::VARIANTS.iter().position(|x| *x == s);
    let worst = |b: Band| results.iter().map(|e| e.status[b]).max_by_key(|s| rank(*s));
    let status = PerBand::from_fn(|b| worst(b).unwrap_or(SolveStatus::Converged));
    let residuals = PerBand::from_fn(|b| {
        let steps = results.iter().map(|e| e.residuals[b].len()).max().unwrap_or(0);
        let power: f64 = results.iter().map(|e| e.power[b]).sum();
        let at = |e: &IterationResult, k: usize| {
            e.residuals[b].get(k).or(e.residuals[b].last()).copied().unwrap_or(0.0)
        };
        let left = |k: usize| results.iter().map(|e| at(e, k) * e.power[b]).sum::<f64>();
        (0..steps).map(|k| if power > 0.0 { left(k) / power } else { 0.0 }).collect()
    });
    (status, residuals)
}

/// The report of a solve, without engine, reason and power errors. `thickness` is the largest optical depth across a voxel.
pub(crate) fn summarize(
    context: &SolveContext,
    built: &BuiltEngine,
    surroundings: &SurroundingsExchange,
    fields: &Fields,
    energy: EnergyBalance,
    results: &[IterationResult],
    thickness: f64,
) -> Report {
    let (scene, zones) = (context.scene, context.shared_zones());
    // Collect the diagnostics in the order of the phases.
    let basis = if built.operator.len() == zones.len() { ZoneBasis::Constant } else { ZoneBasis::Linear };
    let mut warnings = scene_diagnostics(scene, context.zones, thickness, basis);
    warnings.extend(built.warnings.iter().cloned());
    if !surroundings.is_closed() {
        let text = "the scene is open: power escapes to the surroundings or onto black backs";
        warnings.push(Diagnostic::note("open-scene", text));
    }
    warnings.extend(context.direct.warnings());
    let (status, residuals) = combine_results(results);
    let mut closure = built.closure.summary.clone();
    closure.largest_change = closure.largest_change.map(|c| c.max(context.direct.largest_change()));
    // Find the weakest grade; the spectral engine determines the escaping power without rays.
    let samples_surroundings = surroundings.rays > 0 && !surroundings.is_closed();
    let grade = if samples_surroundings { Grade::Statistical } else { built.operator.grade() };
    let samples_lights = context.direct.lights.iter().any(|l| !l.by_exchange);
    let direct_grade = if samples_lights { Grade::Statistical } else { Grade::Estimated };
    Report {
        status,
        residuals,
        estimate: error_estimate(zones, fields, grade.max(direct_grade)),
        closure,
        energy,
        counts: counts(&zones, built, surroundings),
        warnings,
        grade,
        ..Report::default()
    }
}

/// Names and values of all counters.
fn counts(zones: &Zones, built: &BuiltEngine, surroundings: &SurroundingsExchange) -> Vec<(String, u64)> {
    let of_zones = [
        ("zones", zones.total()),
        ("patches", zones.patches.len()),
        ("voxel zones", zones.voxels.total()),
        ("pane zones", zones.panes.len()),
    ];
    let mut out: Vec<(String, u64)> = of_zones.into_iter().map(|(k, v)| (k.to_string(), v as u64)).collect();
    out.extend(built.counts.iter().cloned());
    out.extend((surroundings.rays > 0).then(|| ("rays to the surroundings".into(), surroundings.rays)));
    out
}
