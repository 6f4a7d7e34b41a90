//! What a report says where the solver ran out of steps or power does not add up: one note for both, with what to do.
//!
//! Light: the residual of the balance, relative to what is emitted and comes in. Heat: walls that are nearly equally warm emit far more than
//! they exchange, so what is missing is told relative to the net powers,
//!
//! ```text
//!     |Σ_i Q_i| / max(Σ_{Q_i > 0} Q_i, Σ_{Q_i < 0} −Q_i)        Q_i of every zone, of the surroundings, of black backs.
//! ```

use zonal_scene::scene::Options;
use zonal_scene::solution::Energy;
use zonal_scene::{Fields, Note, Report, Scene, SolveStatus, Zones};

/// Share that may be missing without a word.
const POOR: f64 = 1e-3;
/// Share of the power that is missing where none of it arrives for good.
const ALL_OF_IT: f64 = 1.0 - 1e-6;
/// Share of all that is emitted that rounding and the default residual may leave: no exchange is known better.
const ROUNDING: f64 = 1e-9;

/// The note where the steps were spent, with what is `off` in words, if anything.
fn spent(off: Option<String>) -> Note {
    let off = off.map_or_else(String::new, |off| format!(", and {off}"));
    let text = format!(
        "the solver ran out of steps before the residual that was asked for; errors have what it left{off}: allow more (max_iterations)"
    );
    Note::warning("not-converged", text)
}

/// What to do about factors that lose or make power.
fn of_factors(restored: bool) -> &'static str {
    if restored { "ask for a smaller tolerance" } else { "restore closure, or ask for a smaller tolerance" }
}

/// What to say of the balance of light, and of a solver that is `short` of steps.
pub(crate) fn of_light(energy: &Energy, options: &Options, restored: bool, short: bool) -> Option<Note> {
    let off = energy.residual.iter().fold(0.0f64, |m, r| m.max(r.abs()));
    let poor = off > POOR && options.sweeps.is_none();
    let told = format!("the energy balance is off by {off:.1e}");
    if poor && off > ALL_OF_IT {
        let text = format!(
            "{told}: nothing absorbs light and nothing lets it out; lower a reflectance or the albedo"
        );
        return Some(Note::warning("energy-balance", text));
    }
    if short {
        return Some(spent(poor.then_some(told)));
    }
    poor.then(|| Note::warning("energy-balance", format!("{told}: {}", of_factors(restored))))
}

/// What to say of the balance of heat of a settled solution, and of a solver that ran out of steps; nothing in light mode.
pub(crate) fn of_heat(scene: &Scene, zones: &Zones, fields: &Fields, report: &Report) -> Option<Note> {
    let (table, heat) = (report.heat.as_ref()?, fields.heat.as_ref()?);
    let patches = zones.patches.iter().map(|p| p.area);
    let sizes = patches.chain(zones.voxels.iter().map(|v| v.volume));
    let sizes = sizes.chain(zones.panes.iter().map(|p| p.area * p.thickness));
    let powers = sizes.zip(&heat.net).map(|(size, q)| size * q).chain([table.surroundings, -table.backs]);
    let [given, taken] = powers.fold([0.0; 2], |[g, t], q| [g + q.max(0.0), t - q.min(0.0)]);
    let (balance, exchanged) = (table.balance().abs(), given.max(taken));
    let e = &report.energy;
    let emitted = (0..3).fold(0.0f64, |m, b| m.max(e.emitted[b] + e.incoming[b]));
    let poor = balance > POOR * exchanged && balance > ROUNDING * emitted;
    let told = format!("the heat balance is off by {balance:.2e} W of {exchanged:.2e} W that are exchanged");
    if report.status.contains(&SolveStatus::Budget) {
        return Some(spent(poor.then_some(told)));
    }
    let left = report.residuals.iter().filter_map(|r| r.last()).fold(0.0f64, |m, r| m.max(*r));
    let coarse = report.engine != "hierarchical" && left * emitted > 0.5 * balance;
    let mend = if coarse { "ask for a smaller residual" } else { of_factors(scene.restores_closure()) };
    poor.then(|| Note::warning("heat-balance", format!("{told}: {mend}")))
}
