//! Propagation of the errors of the incident flux through reflection and reemission.
//!
//! δh is known from the factors for the powers that the zones send out, but these powers err too. With M as in the linear equations (no entry
//! negative), δu = t c M|δh| + M δu and δh' = |δh| + g δu/t bound both. Cost: a linear solve to a residual of [`ERROR_SOLVE`].

use super::coupled_bicgstab::{self, IterationCheckpoint};
use super::linearized_zone::{BandCoupling, LinearizedZone, PowerScaling};
use super::zone_balance::ZoneBalances;
use crate::iteration::StoppingCriterion;
use crate::solve_context::{BuiltEngine, SolveContext};
use rayon::prelude::*;
use zonal_scene::{Bands, Fields};

/// How temperatures follow from the zonal equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TemperatureSolve {
    /// From one linear solve of each band.
    Direct,
    /// By Newton's method for coupled bands.
    Newton,
}

/// Stopping criterion of the solve for the errors.
const ERROR_SOLVE: StoppingCriterion = StoppingCriterion { residual: 0.1, max_iterations: 200 };
/// Name of its stage.
const STAGE: &str = "state-errors";

/// Adds to the errors of the incident fields those of the powers that the zones send out because of them.
pub(crate) fn propagate_errors(
    context: &SolveContext,
    built: &BuiltEngine,
    fields: &mut Fields,
    solve: TemperatureSolve,
) {
    let table = ZoneBalances::new(context.scene, context.zones);
    let balances = table.all(context.zones);
    let (n, fractions) = (context.zones.len(), &table.thermal.band_fractions);
    let share = |i: usize| balances[i].incident_share * fields.error[i];
    // Linearize zones of known power about the temperatures of the radiosities found.
    let linearize = |i: usize| {
        let l = &balances[i];
        LinearizedZone::of(l, fractions, l.emissive_and_net_power(fractions, l.incident_flux(fields, i)).0)
    };
    let linearized: Vec<LinearizedZone> = match solve {
        TemperatureSolve::Newton => (0..n).into_par_iter().map(linearize).collect(),
        TemperatureSolve::Direct => Vec::new(),
    };
    let reflected_uncoupled = |i: usize, h: Bands| {
        let (rho, _) = context.zones.response(i);
        rho / balances[i].incident_share * h
    };
    let reflected =
        |i: usize, h: Bands| linearized.get(i).map_or_else(|| reflected_uncoupled(i, h), |t| t.reflected(h));
    // Solve for the errors of the powers sent out.
    let operator = built.operator.as_ref();
    let scaling = PowerScaling::new(operator, context.zones, &balances, BandCoupling::of(fractions), &[]);
    let source: Vec<Bands> =
        (0..n).into_par_iter().map(|i| scaling.power_of(i, reflected(i, share(i)))).collect();
    if coupled_bicgstab::absolute_sum(&source) == 0.0 {
        return;
    }
    let checkpoint = IterationCheckpoint {
        store: context.checkpoints,
        stage: STAGE,
        number: 0,
        resumes: true,
        progress: context.progress,
    };
    let reflect = |u: &[Bands]| scaling.reflect(operator, u, reflected);
    let end = coupled_bicgstab::solve(reflect, &source, source.clone(), ERROR_SOLVE, &checkpoint);
    // Add the errors that they cause.
    let more = scaling.incident_flux(operator, &end.u);
    for (i, e) in fields.error.iter_mut().enumerate() {
        *e += more[i].abs() / balances[i].incident_share;
    }
}
