//! Powers, temperatures and notes of a report as rows.

use super::numbers::{number, value_with_errors};
use std::collections::HashSet;
use zonal_scene::{
    Bands, Diagnostic, DiscretizationError, EnergyBalance, HeatReport, HeatRowKind, Report, Solution,
};

/// Largest number of surfaces in the energy balance.
const MAX_SURFACE_ROWS: usize = 12;

/// The name of each light group, and its power in every band, W.
#[must_use]
pub fn light_group_powers(s: &Solution) -> Vec<(&str, Vec<f64>)> {
    let power = |k: usize| s.all_bands(|t| t.groups[k].energy.emitted + t.groups[k].energy.incoming);
    s.groups.iter().enumerate().map(|(k, g)| (g.name.as_str(), power(k))).collect()
}

/// Diagnostics of the solve, and of the second solve for the discretization error, in all blocks of bands; those of the same text once.
#[must_use]
pub fn distinct_diagnostics(s: &Solution) -> Vec<&Diagnostic> {
    let mut lines = HashSet::new();
    s.blocks().flat_map(|t| diagnostics(&t.report)).filter(|d| lines.insert(d.line())).collect()
}

fn diagnostics(r: &Report) -> impl Iterator<Item = &Diagnostic> {
    r.warnings.iter().chain(r.discretization_error.iter().flat_map(|z| &z.notes))
}

/// The powers that belong to no part, and their sum with those of the parts, W.
#[must_use]
pub fn heat_balance(r: &HeatReport) -> Vec<(&'static str, f64)> {
    let emitters = (r.emitters != 0.0).then_some(("light of emitters", r.emitters));
    let others = [
        ("from the surroundings, less escaped power", r.surroundings),
        ("absorbed by backfaces", -r.absorbed_backfaces),
        ("balance", r.balance()),
    ];
    emitters.into_iter().chain(others).collect()
}

/// Size, temperature, net flux and net power of part number `row`, each with its error; `powers` are the signs of m² and m³.
#[must_use]
pub fn heat_cells(
    r: &HeatReport,
    row: usize,
    discretization: Option<&DiscretizationError>,
    powers: [&str; 2],
) -> [String; 4] {
    let x = &r.rows[row];
    let [of_temperature, of_power] = match discretization {
        Some(z) => z.heat.get(row).copied().unwrap_or([f64::INFINITY; 2]),
        None => [0.0; 2],
    };
    let unit = powers[usize::from(x.kind != HeatRowKind::Surface)];
    let power = [x.power_error, of_power];
    let temperature =
        |t| value_with_errors(t, [x.temperature_error.unwrap_or(f64::INFINITY), of_temperature]);
    [
        format!("{} m{unit}", number(x.size)),
        x.temperature.map_or("undefined".into(), temperature),
        format!("{} W/m{unit}", value_with_errors(x.over_size(x.power), power.map(|e| x.over_size(e)))),
        value_with_errors(x.power, power),
    ]
}

/// A power of the energy balance in every band, W.
pub struct PowerRow {
    /// Its name in tables.
    pub name: String,
    /// The power in each band, W.
    pub values: Vec<f64>,
    /// Its errors in each band, W: of the exchange, and of the zones (0 where that was not requested).
    pub errors: Vec<[f64; 2]>,
}

/// The powers of the energy balance of light with errors: exchange error, plus discretization error if it is known.
#[must_use]
pub fn power_rows(s: &Solution) -> Vec<PowerRow> {
    let row = |name: &str, of: &dyn Fn(&EnergyBalance) -> Bands| {
        let zones =
            |t: &Solution| t.report.discretization_error.as_ref().map_or(Bands::ZERO, |z| of(&z.energy));
        let values = s.all_bands(|t| of(&t.report.energy));
        let exchange = s.all_bands(|t| of(&t.report.energy_error));
        let errors = exchange.into_iter().zip(s.all_bands(zones)).map(|(e, z)| [e, z]).collect();
        PowerRow { name: name.into(), values, errors }
    };
    let absorbed = &s.report.energy.absorbed_surfaces;
    let by =
        |e: &EnergyBalance, k: usize| e.absorbed_surfaces.get(k).map_or(Bands::splat(f64::INFINITY), |x| x.1);
    let of_surface = |(k, (name, _)): (usize, &(String, Bands))| {
        row(&format!("absorbed by {name}"), &|e: &EnergyBalance| by(e, k))
    };
    let mut out = vec![row("emitted", &|e| e.emitted), row("incoming", &|e| e.incoming)];
    out.extend(absorbed.iter().enumerate().take(MAX_SURFACE_ROWS).map(of_surface));
    let all = absorbed.len();
    if all > MAX_SURFACE_ROWS {
        let name = format!("absorbed by {} more surfaces", all - MAX_SURFACE_ROWS);
        out.push(row(&name, &|e| (MAX_SURFACE_ROWS..all).fold(Bands::ZERO, |s, k| s + by(e, k))));
    }
    out.push(row("absorbed by the medium", &|e| e.absorbed_volumes));
    out.push(row("absorbed by panes", &|e| e.absorbed_panes));
    out.push(row("escaped", &|e| e.escaped));
    out.push(row("absorbed by backfaces", &|e| e.absorbed_backfaces));
    out
}
