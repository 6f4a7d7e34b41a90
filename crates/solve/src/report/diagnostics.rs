//! Diagnostics of the balance and of the convergence of a solution.
//!
//! Light: the residual of the energy balance, relative to emitted + incoming power. Heat: walls at nearly equal temperatures emit far more than they
//! exchange, so the residual is relative to the net powers Q_i of the zones, the surroundings and black backs,
//!
//! ```text
//!     |Σ_i Q_i| / max(Σ_{Q_i > 0} Q_i, Σ_{Q_i < 0} −Q_i).
//! ```

use crate::distribution::sum_order::SumOrder;
use crate::engines::selection::EngineChoice;
use crate::engines::tolerance_advice;
use zonal_math::parallel;
use zonal_scene::{
    Band, Bands, Diagnostic, EnergyBalance, Engine, ErrorEstimate, Fields, Report, Scene, SolveOptions,
    SolveStatus, Zones,
};

/// Relative residual of a balance above which it is reported.
const MAX_BALANCE_RESIDUAL: f64 = 1e-3;
/// Relative residual of a balance from which no power is absorbed or escapes.
const NOTHING_ABSORBED: f64 = 1.0 - 1e-6;
/// Residual over the emitted power that rounding and the default residual of the solver may leave.
const ROUNDING_OF_EXCHANGE: f64 = 1e-9;
/// The same for iterations on rays, over the tolerance: they end at an error that is relative to it. Such a residual widens the stated errors.
const RESIDUAL_OF_RAYS: f64 = 1e-3;
/// Largest negative flux, over the largest incident flux, that is not reported.
const MAX_UNDERSHOOT: f64 = 1e-6;

/// The diagnostic of a solver with `status`; `imbalance` describes the residual of the balance if it is too large, and whether the stated errors leave a part
/// of it unexplained. None if the solver converged, or stalled without such a part.
fn not_converged(
    status: impl IntoIterator<Item = SolveStatus>,
    imbalance: Option<String>,
    is_unexplained: bool,
) -> Option<Diagnostic> {
    let [mut is_spent, mut is_stalled] = [false; 2];
    for s in status {
        is_spent |= s == SolveStatus::MaxIterations;
        is_stalled |= s == SolveStatus::Stalled;
    }
    let [what, advice] = if is_spent {
        ["reached the maximum number of iterations", "increase max_iterations"]
    } else if is_stalled && is_unexplained {
        ["stalled", "lower a reflectance or the albedo, or use the engine dense or spectral"]
    } else {
        return None;
    };
    let imbalance = imbalance.map_or_else(String::new, |text| format!(", and {text}"));
    let text = format!(
        "the solver {what} before the requested residual; the stated errors include the remainder{imbalance}: {advice}"
    );
    Some(Diagnostic::warning("not-converged", text))
}

/// The advice for factors that lose or create power.
fn closure_advice(restores_closure: bool) -> &'static str {
    if restores_closure {
        "use a smaller tolerance or smaller patches"
    } else {
        "restore closure, or use a smaller tolerance or smaller patches"
    }
}

/// The diagnostic of the balance of light, and of a solver with `status`. A residual within `explained`, the stated errors of the powers of the balance
/// (W per band) before they were widened by this residual, is none.
pub(crate) fn light_balance(
    energy: &EnergyBalance,
    explained: Bands,
    scene: &Scene,
    status: impl Iterator<Item = SolveStatus>,
) -> Option<Diagnostic> {
    let (options, restores_closure): (&SolveOptions, bool) = (scene.options(), scene.restores_closure());
    let given = energy.emitted + energy.incoming;
    let largest = |counts: &dyn Fn(Band) -> bool| {
        Band::all().filter(|b| counts(*b)).map(|b| energy.residual[b].abs()).fold(0.0, f64::max)
    };
    let off = largest(&|_| true);
    let unexplained = largest(&|b| (energy.residual[b] * given[b]).abs() > explained[b]);
    let is_poor = |off: f64| off > MAX_BALANCE_RESIDUAL && options.scattering_orders.is_none();
    let imbalance = |off: f64| format!("the energy balance is off by {off:.1e}");
    if is_poor(off) && off > NOTHING_ABSORBED {
        let text = format!(
            "{}: next to nothing absorbs light or lets it escape; lower a reflectance or the albedo, or use the engine dense or spectral",
            imbalance(off)
        );
        return Some(Diagnostic::warning("energy-balance", text));
    }
    let unfinished = not_converged(status, is_poor(off).then(|| imbalance(off)), is_poor(unexplained));
    if unfinished.is_some() {
        return unfinished;
    }
    is_poor(unexplained).then(|| {
        let text = format!("{}: {}", imbalance(unexplained), closure_advice(restores_closure));
        Diagnostic::warning("energy-balance", text)
    })
}

/// The diagnostic of the balance of heat, and of a solver that reached its maximum of iterations; none in light mode. A residual within `explained`, the
/// stated errors of the powers of the balance (W) before they were widened by this residual, is none.
pub(crate) fn heat_balance(
    scene: &Scene,
    zones: &Zones,
    fields: &Fields,
    report: &Report,
    explained: f64,
) -> Option<Diagnostic> {
    let (table, heat) = (report.heat.as_ref()?, fields.heat.as_ref()?);
    // Sum the net powers given and taken.
    let patches = zones.patches.iter().map(|p| p.area);
    let sizes = patches.chain(zones.voxels.iter().map(|v| v.volume));
    let sizes = sizes.chain(zones.panes.iter().map(|p| p.area * p.thickness));
    let powers = sizes.zip(&heat.net).map(|(size, q)| size * q);
    let powers = powers.chain([table.surroundings, -table.absorbed_backfaces]);
    let [given, taken] = powers.fold([0.0; 2], |[g, t], q| [g + q.max(0.0), t - q.min(0.0)]);
    let (balance, exchanged) = (table.balance().abs(), given.max(taken));
    let e = &report.energy;
    let emitted = (e.emitted + e.incoming).iter().fold(0.0f64, |m, x| m.max(*x));
    let left_by_solver = match report.engine.as_str() {
        "rays" => RESIDUAL_OF_RAYS * scene.options().tolerance,
        _ => ROUNDING_OF_EXCHANGE,
    };
    let poor = balance > MAX_BALANCE_RESIDUAL * exchanged && balance > left_by_solver * emitted;
    let imbalance =
        format!("the heat balance is off by {balance:.2e} W of {exchanged:.2e} W that are exchanged");
    let described = poor.then(|| imbalance.clone());
    let unfinished = not_converged(report.status.iter().copied(), described, poor && balance > explained);
    if unfinished.is_some() {
        return unfinished;
    }
    // Attribute the residual to the solver or to the factors.
    let left = report.residuals.iter().filter_map(|r| r.last()).fold(0.0f64, |m, r| m.max(*r));
    let by_solver = report.engine != "rays" && left * emitted > 0.5 * balance;
    let advice = if by_solver { "use a smaller residual" } else { closure_advice(scene.restores_closure()) };
    (poor && balance > explained)
        .then(|| Diagnostic::warning("heat-balance", format!("{imbalance}: {advice}")))
}

/// The advice where light that varies within zones has most of the error.
const ADVICE_OF_ZONING: &str = "most of it is light that varies within zones; use engine = \"rays\", which follows it, or smaller patches and cells";

/// The diagnostic of an estimated error above the tolerance; none if an engine reported it already. Errors of the spectral and of the layered engine are those of
/// rounding.
pub(crate) fn missed_tolerance(
    choice: &EngineChoice,
    tolerance: f64,
    estimate: &ErrorEstimate,
    reported: &[Diagnostic],
) -> Option<Diagnostic> {
    let engine = choice.engine;
    let has_samples = choice.has_patches_outside() || !matches!(engine, Engine::Spectral | Engine::Layered);
    let error = estimate.patches.into_iter().chain(estimate.volumes).fold(0.0f64, f64::max);
    let is_reported = reported.iter().any(|n| n.code == "tolerance");
    let is_of_zones = estimate.parts.is_some_and(|[a, b]| {
        let parts = a.max(b);
        engine != Engine::Rays && parts.zoning > parts.sampling
    });
    (error > tolerance && !is_reported && (has_samples || is_of_zones)).then(|| {
        let advice = if is_of_zones { ADVICE_OF_ZONING } else { tolerance_advice(engine, reported) };
        let text =
            format!("the estimated error, {error:.2e}, misses the tolerance, {tolerance:.2e}: {advice}");
        Diagnostic::warning("tolerance", text)
    })
}

/// The diagnostic of negative fluxes, beyond their stated errors, in zones whose slopes are too steep. An error that is no larger than the amount of a negative
/// flux was widened to it.
pub(crate) fn negative_flux(fields: &Fields, order: SumOrder) -> Option<Diagnostic> {
    let incident = &fields.incident;
    let most = parallel::reduce(incident.len(), 0.0, |i| incident[i].max_element(), f64::max);
    let most = order.over_processes(most, f64::max);
    if most <= 0.0 {
        return None;
    }
    let is_below = |h: Bands, e: Bands| Band::all().any(|b| h[b] < -MAX_UNDERSHOOT * most && e[b] <= -h[b]);
    let below = |i: usize| {
        let h = incident[i];
        if is_below(h, fields.error[i]) { (h.iter().fold(0.0f64, |m, x| m.min(*x)), 1) } else { (0.0, 0) }
    };
    let both = |a: (f64, u64), b: (f64, u64)| (a.0.min(b.0), a.1 + b.1);
    let (least, count) = parallel::reduce(incident.len(), (0.0, 0), below, both);
    let least = order.over_processes(least, f64::min);
    let count = order.over_processes(count, |a, b| a + b);
    (least < 0.0).then(|| {
        let text = format!(
            "negative incident flux in {} zone(s), down to {:.1e} of the largest flux: the light decays too steeply for these voxels; use more cells",
            count,
            least / most
        );
        Diagnostic::warning("negative-flux", text)
    })
}
