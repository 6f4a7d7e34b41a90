//! Estimate of the discretization error for the report of a solve.

use super::comparison::SecondSolve;
use super::near_surface_scattering;
use super::prescribed_temperatures::{RowTemperature, row_temperatures, temperature_error};
use super::thick_scattering;
use crate::context::zonal_solution::ZonalSolution;
use crate::distribution::Communicator;
use crate::distribution::sum_order::SharedZones;
use zonal_scene::{Diagnostic, DiscretizationError, Report, Scene, ZoneBasis};

/// True if the discretization error is requested: by an option, else in thermal mode.
pub(crate) fn is_requested(scene: &Scene) -> bool {
    scene.options().discretization_error.unwrap_or(scene.thermal().is_some())
}

/// Adds the discretization error to the reports of all blocks of bands, from a second solve by the same method on other zones, or the reason why there is
/// none. Errors that the second solve does not cover are infinite.
pub(crate) fn estimate(scene: &Scene, blocks: &mut [ZonalSolution], second: Result<SecondSolve, String>) {
    let reports: Vec<&Report> = blocks.iter().map(|b| &b.report).collect();
    let mut errors = match second {
        Ok(second) => second.errors(scene, &reports),
        Err(why) => {
            let text = format!("the discretization error is not known: {why}");
            let errors = reports.iter().map(|report| unknown(scene, report)).collect();
            blocks[0].report.warnings.push(Diagnostic::warning("discretization", text));
            errors
        }
    };
    for b in 0..blocks.len() {
        let ZonalSolution { scene, zones, fields, .. } = &blocks[b];
        let unresolved = near_surface_scattering::unresolved_powers(scene, zones, fields);
        near_surface_scattering::add_to_energy(&unresolved, &mut errors[b]);
        near_surface_scattering::add_to_heat(scene, &unresolved, &blocks[0].report, &mut errors[0]);
    }
    blocks.iter_mut().zip(errors).for_each(|(b, error)| b.report.discretization_error = Some(error));
}

/// Adds the discretization error of light in thick cells that scatter, where a second solve was neither requested nor refused.
pub(crate) fn state_thick_scattering(
    basis: ZoneBasis,
    blocks: &mut [ZonalSolution],
    communicator: &dyn Communicator,
) {
    let scene = &blocks[0].scene;
    if basis == ZoneBasis::Linear
        || scene.thermal().is_some()
        || scene.options().discretization_error.is_some()
    {
        return;
    }
    for t in blocks {
        t.report.discretization_error = thick_scattering::estimate(
            &t.scene,
            SharedZones::new(&t.zones, communicator),
            &t.fields,
            &t.report,
        );
    }
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
