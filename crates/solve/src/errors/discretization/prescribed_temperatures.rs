//! Rows of the heat table with prescribed temperatures.

use zonal_scene::{HeatReport, HeatRow, HeatRowKind, Scene, ThermalCondition};

/// For each row of a table, whether the temperature of all of its zones is prescribed.
pub(super) fn row_temperatures(scene: &Scene, table: &HeatReport) -> Vec<RowTemperature> {
    let is_temperature = |k: &ThermalCondition| matches!(k, ThermalCondition::Temperature(_));
    let (surfaces, panes) = scene.thermal().map_or((&[][..], &[][..]), |t| (&t.surfaces[..], &t.panes[..]));
    let medium = || {
        let grid = scene.voxel_grid()?;
        let cells = if grid.is_uniform() { 1 } else { grid.len() };
        Some((0..cells).all(|i| grid.heat(i).is_some_and(|k| is_temperature(&k))))
    };
    let (mut surfaces, mut panes) = (surfaces.iter(), panes.iter());
    let one = |row: &HeatRow| {
        let is_prescribed = match row.kind {
            HeatRowKind::Surface => surfaces.next().is_some_and(is_temperature),
            HeatRowKind::Medium => medium().unwrap_or(false),
            HeatRowKind::Pane => panes.next().is_some_and(is_temperature),
        };
        if is_prescribed { RowTemperature::Prescribed } else { RowTemperature::Computed }
    };
    table.rows.iter().map(one).collect()
}

/// Whether the temperature of a row is prescribed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RowTemperature {
    Prescribed,
    Computed,
}

/// The error of a row's temperature: 0 if it is prescribed, NaN if there is none.
pub(super) fn temperature_error(row: &HeatRow, kind: RowTemperature, error: f64) -> f64 {
    match (kind, row.temperature) {
        (RowTemperature::Prescribed, _) => 0.0,
        (RowTemperature::Computed, Some(_)) => error,
        (RowTemperature::Computed, None) => f64::NAN,
    }
}
