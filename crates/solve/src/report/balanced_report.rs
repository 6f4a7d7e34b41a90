//! Balance of the powers of a solution, and its report.

use crate::context::BlockEngine;
use crate::errors::direct_error;
use crate::errors::{consistency, propagation};
use crate::iteration::IterationResult;
use crate::report::{diagnostics, summary};
use zonal_scene::{Bands, EnergyBalance, Fields, LightGroup, Report};

/// Balances the energy of a solution, widens its errors by the residual of the balance, and writes the report with the errors of all powers.
pub(crate) fn balance_and_report(
    block: &BlockEngine,
    fields: &mut Fields,
    groups: &[LightGroup],
    results: &[IterationResult],
    thickness: f64,
) -> Report {
    let BlockEngine { context, built, surroundings: exterior } = block;
    let (scene, zones, direct) = (context.scene, context.zones, context.direct);
    let shared = context.shared_zones();
    let mut energy = EnergyBalance::default();
    groups.iter().for_each(|g| energy.add(&g.energy));
    let mut lost = propagation::escaped_power_error(zones, exterior, results);
    lost = direct_error::light_power_errors(direct).into_iter().fold(lost, Bands::hypot);
    // Diagnose negative fluxes and the balance by the errors that these have not widened.
    let negative =
        (!shared.has_negative_source()).then(|| diagnostics::negative_flux(fields, shared.order())).flatten();
    let stated = |fields: &Fields, energy: &EnergyBalance| {
        let mut error = consistency::power_errors(shared, energy, fields, |i| fields.error[i]);
        direct_error::add_to_power_errors(shared, energy, direct, &mut error);
        error
    };
    let explained = match scene.thermal() {
        Some(_) => Bands::ZERO,
        None => consistency::explained_residual(&stated(fields, &energy), lost),
    };
    // Heat is balanced after the temperatures are recovered.
    if scene.thermal().is_none() && scene.options().scattering_orders.is_none() {
        consistency::widen_by_balance(shared, &energy, lost, fields);
    }
    let mut report = summary::summarize(context, built, exterior, fields, energy, results, thickness);
    if scene.thermal().is_none() {
        let status = results.iter().flat_map(|e| e.status);
        report.warnings.extend(diagnostics::light_balance(&report.energy, explained, scene, status));
    }
    report.warnings.extend(negative);
    report.energy_error = match scene.thermal() {
        Some(_) => EnergyBalance { escaped: lost, ..EnergyBalance::default() },
        None => stated(fields, &report.energy),
    };
    report
}
