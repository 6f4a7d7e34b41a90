//! What a solution says of its own errors: the one place that knows where reports keep them, so that the campaign can be taken to other
//! versions of the program.

use zonal::scene::solution::{Energy, Report};
use zonal::scene::{Bands, Severity, Solution};

/// True where escaped power has a stated error.
pub(crate) const ESCAPED: bool = true;

/// Stated error of all that arrives at a zone, W/m²: of the exchange.
pub(crate) fn zone(s: &Solution, i: usize) -> Bands {
    s.fields.error_of_all(i)
}

/// True where the report warns.
pub(crate) fn warned(report: &Report) -> bool {
    report.warnings.iter().any(|w| w.severity == Severity::Warning)
}

/// Stated errors of temperature (K) and net power (W) of each row of heat: of the exchange and of the zones.
pub(crate) fn heat(s: &Solution) -> Vec<[f64; 2]> {
    let Some(heat) = &s.report.heat else { return Vec::new() };
    let zoning = s.report.zoning.as_ref();
    let own = |k: usize, q: usize| zoning.and_then(|z| z.heat.get(k)).map_or(f64::INFINITY, |e| e[q]);
    (heat.rows.iter().enumerate())
        .map(|(k, r)| [r.temperature_error.unwrap_or(0.0) + own(k, 0), r.power_error + own(k, 1)])
        .collect()
}

/// Stated errors of the powers by name in light mode, W: of the exchange and of the zones.
pub(crate) fn energy(s: &Solution) -> Energy {
    let own = &s.report.energy_error;
    match &s.report.zoning {
        Some(z) => own.compared(&z.energy, |a, b| a + b),
        None => own.compared(own, |_, _| f64::INFINITY),
    }
}
