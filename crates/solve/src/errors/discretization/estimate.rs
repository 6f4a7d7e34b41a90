//! Estimate of the discretization error for the report of a solve.

use super::comparison::{SolveFn, compare};
use super::near_surface_scattering;
use super::prescribed_temperatures::{RowTemperature, row_temperatures, temperature_error};
use crate::settings::SolveSettings;
use zonal_scene::{Diagnostic, DiscretizationError, Fields, Report, Scene, ZoneBasis, Zones};

/// True if the discretization error is requested: by an option, else in thermal mode.
pub(crate) fn is_requested(scene: &Scene) -> bool {
    scene.options().discretization_error.unwrap_or(scene.thermal().is_some())
}

/// One triple of the bands of the solve whose error is estimated.
pub(crate) struct FirstTriple<'a> {
    pub scene: &'a Scene,
    pub zones: &'a Zones,
    pub fields: &'a Fields,
    pub report: &'a mut Report,
}

/// Runs `solve` on larger or smaller zones with the same engine and basis, and adds the discretization error to the reports of all triples of bands.
/// Errors that the second solve does not cover are infinite.
pub(crate) fn estimate(
    scene: &Scene,
    basis: ZoneBasis,
    triples: &mut [FirstTriple],
    settings: &SolveSettings,
    solve: &SolveFn,
) {
    let reports: Vec<&Report> = triples.iter().map(|t| &*t.report).collect();
    let mut errors = match compare((scene, triples[0].zones, basis), &reports, settings, solve) {
        Ok(errors) => errors,
        Err(why) => {
            let text = format!("the discretization error is not known: {why}");
            let errors = reports.iter().map(|report| unknown(scene, report)).collect();
            triples[0].report.warnings.push(Diagnostic::warning("discretization", text));
            errors
        }
    };
    for t in 0..triples.len() {
        let FirstTriple { scene, zones, fields, .. } = &triples[t];
        let unresolved = near_surface_scattering::unresolved_powers(scene, zones, fields);
        near_surface_scattering::add_to_energy(&unresolved, &mut errors[t]);
        near_surface_scattering::add_to_heat(scene, &unresolved, triples[0].report, &mut errors[0]);
    }
    triples.iter_mut().zip(errors).for_each(|(t, error)| t.report.discretization_error = Some(error));
}

/// The error without a second solve: infinite except for prescribed values.
fn unknown(scene: &Scene, report: &Report) -> DiscretizationError {
    let error = |a: f64, b: f64| if a == 0.0 && b == 0.0 { 0.0 } else { f64::INFINITY };
    let rows = report.heat.iter().flat_map(|table| table.rows.iter().zip(row_temperatures(scene, table)));
    let heat = rows.map(|(row, given)| {
        // A net power without any error is a prescribed one, unless it is that of a prescribed temperature.
        let is_given_power = row.power_error == 0.0 && given == RowTemperature::Computed;
        let power = if is_given_power { 0.0 } else { f64::INFINITY };
        [temperature_error(row, given, f64::INFINITY), power]
    });
    DiscretizationError {
        zones: 0,
        ratio: f64::INFINITY,
        heat: heat.collect(),
        energy: report.energy.zip_map(&report.energy, error),
        notes: Vec::new(),
    }
}
