//! Estimate of the discretization error for the report of a solve.

use super::comparison::{SolveFn, compare};
use super::near_surface_scattering;
use super::prescribed_temperatures::{row_temperatures, temperature_error};
use crate::settings::SolveSettings;
use zonal_scene::{Diagnostic, DiscretizationError, Fields, Report, Scene, ZoneBasis, Zones};

/// True if the discretization error is requested: by an option, else in thermal mode.
pub(crate) fn is_requested(scene: &Scene) -> bool {
    scene.options().discretization_error.unwrap_or(scene.thermal().is_some())
}

/// The solve whose error is estimated.
pub(crate) struct FirstSolve<'a> {
    pub scene: &'a Scene,
    pub zones: &'a Zones,
    pub fields: &'a Fields,
    /// The basis inside the zones.
    pub basis: ZoneBasis,
}

/// Runs `solve` on larger or smaller zones with the same engine and basis, and adds the discretization error to the report. Errors that the second
/// solve does not cover are infinite.
pub(crate) fn estimate(first: &FirstSolve, report: &mut Report, settings: &SolveSettings, solve: &SolveFn) {
    let FirstSolve { scene, zones, fields, basis } = *first;
    let mut error = match compare((scene, zones, basis), report, settings, solve) {
        Ok(error) => error,
        Err(why) => {
            let text = format!("the discretization error is not known: {why}");
            report.warnings.push(Diagnostic::warning("discretization", text));
            unknown(scene, report)
        }
    };
    near_surface_scattering::add_to_errors(scene, zones, fields, report, &mut error);
    report.discretization_error = Some(error);
}

/// The error without a second solve: infinite except for prescribed values.
fn unknown(scene: &Scene, report: &Report) -> DiscretizationError {
    let error = |a: f64, b: f64| if a == 0.0 && b == 0.0 { 0.0 } else { f64::INFINITY };
    let rows = report.heat.iter().flat_map(|table| table.rows.iter().zip(row_temperatures(scene, table)));
    let heat = rows.map(|(row, given)| [temperature_error(row, given, f64::INFINITY), f64::INFINITY]);
    DiscretizationError {
        zones: 0,
        ratio: f64::INFINITY,
        heat: heat.collect(),
        energy: report.energy.zip_map(&report.energy, error),
        notes: Vec::new(),
    }
}
