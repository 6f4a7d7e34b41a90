//! Stated errors of a solution: the only module that depends on the layout of reports.

use zonal_scene::{Bands, EnergyBalance, Report, Severity, Solution};

/// True where escaped power has a stated error.
pub(crate) const ESCAPED_POWER_HAS_ERROR: bool = true;

/// Stated error of the incident flux of a zone, W/m²: of the exchange.
pub(crate) fn zone(s: &Solution, i: usize) -> Bands {
    s.fields.total_error(i)
}

/// True where the report warns.
pub(crate) fn warned(report: &Report) -> bool {
    report.warnings.iter().any(|w| w.severity == Severity::Warning)
}

/// Stated errors of temperature (K) and net power (W) of each row of heat: of the exchange and of the zones.
pub(crate) fn heat(s: &Solution) -> Vec<[f64; 2]> {
    let Some(heat) = &s.report.heat else { return Vec::new() };
    let zoning = s.report.discretization_error.as_ref();
    let own = |k: usize, q: usize| zoning.and_then(|z| z.heat.get(k)).map_or(f64::INFINITY, |e| e[q]);
    (heat.rows.iter().enumerate())
        .map(|(k, r)| [r.temperature_error.unwrap_or(0.0) + own(k, 0), r.power_error + own(k, 1)])
        .collect()
}

/// Stated errors of the powers by name in light mode, W: of the exchange and of the zones.
pub(crate) fn energy(s: &Solution) -> EnergyBalance {
    let own = &s.report.energy_error;
    match &s.report.discretization_error {
        Some(z) => own.zip_map(&z.energy, |a, b| a + b),
        None => own.zip_map(own, |_, _| f64::INFINITY),
    }
}
