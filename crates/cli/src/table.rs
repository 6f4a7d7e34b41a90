//! Reports as text tables.

use std::collections::HashSet;
use std::fmt::Write;
use zonal_scene::{
    Bands, Diagnostic, DiscretizationError, EnergyBalance, HeatReport, HeatRowKind, Report, Solution,
};

/// Largest number of parts in the table of heat.
const MAX_HEAT_ROWS: usize = 40;
/// Largest number of surfaces in the energy balance.
const MAX_SURFACE_ROWS: usize = 12;

/// The report of a solution: counts, energy balance, engine, errors, closure, status of the iteration, diagnostics.
#[must_use]
pub fn report(s: &Solution) -> String {
    let mut out = String::new();
    counts(&mut out, &s.report);
    match &s.report.heat {
        Some(heat) => self::heat(&mut out, heat, s.report.discretization_error.as_ref()),
        None => energy_balance(&mut out, s),
    }
    if s.groups.len() > 1 {
        out += &light_groups(s);
    }
    quality(&mut out, s);
    distinct_diagnostics(s).iter().for_each(|d| _ = writeln!(out, "  {}", d.line()));
    out
}

/// The light groups with their power.
#[must_use]
pub fn light_groups(s: &Solution) -> String {
    let mut out = String::from("light groups (emitted power, W)\n");
    for (name, power) in light_group_powers(s) {
        band_row(&mut out, name, &power);
    }
    out
}

/// The name of each light group, and its power in every band, W.
#[must_use]
pub fn light_group_powers(s: &Solution) -> Vec<(&str, Vec<f64>)> {
    let power = |k: usize| s.all_bands(|t| t.groups[k].energy.emitted + t.groups[k].energy.incoming);
    s.groups.iter().enumerate().map(|(k, g)| (g.name.as_str(), power(k))).collect()
}

/// A number with enough digits for a table.
#[must_use]
pub fn number(x: f64) -> String {
    if x == 0.0 {
        "0".into()
    } else if !x.is_finite() {
        "unknown".into()
    } else if (1e-3..1e5).contains(&x.abs()) {
        format!("{x:.4}").trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        format!("{x:.2e}")
    }
}

fn counts(out: &mut String, r: &Report) {
    let _ = writeln!(out, "counts");
    for (name, count) in r.counts.iter().filter(|c| c.1 > 0) {
        let _ = writeln!(out, "  {name:<34}{:>12}", thousands(*count));
    }
}

/// Engine, errors, closure, status of the iteration.
fn quality(out: &mut String, s: &Solution) {
    let r = &s.report;
    let _ = writeln!(out, "quality");
    let _ = writeln!(out, "  {:<34}{:>12}", "engine", format!("{} ({})", r.engine, r.reason));
    if !s.zones.patches.is_empty() {
        band_row(out, "estimated error of H, relative", &s.all_bands(|t| t.report.estimate.patches));
    }
    if s.zones.len() > s.zones.patches.len() {
        band_row(out, "estimated error of G, relative", &s.all_bands(|t| t.report.estimate.volumes));
    }
    let _ = writeln!(out, "  {:<34}{:>12}", "grade of the estimate", r.estimate.grade.name());
    band_row(out, "closure, largest defect", &s.all_bands(|t| t.report.closure.worst));
    band_row(out, "closure, rms defect", &s.all_bands(|t| t.report.closure.rms));
    if s.blocks().any(|t| t.report.closure.restored) {
        band_row(out, "closure, largest change", &s.all_bands(|t| t.report.closure.largest_change));
        band_row(out, "closure, residual defect", &s.all_bands(|t| t.report.closure.residual_defect));
    }
    let of_block = |t: &'_ Solution| {
        let bands = t.report.status.iter().zip(&t.report.residuals).take(t.scene.window().len());
        bands.map(|(status, history)| (*status, history.clone())).collect::<Vec<_>>()
    };
    for (band, (status, history)) in s.blocks().flat_map(of_block).enumerate() {
        let last = history.last().copied().unwrap_or(0.0);
        let iterations = history.len().max(1) - 1;
        let text = format!("{} after {iterations} iterations, residual {}", status.name(), number(last));
        let _ = writeln!(out, "  {:<34}{text:>12}", format!("solver, band {band}"));
    }
    let _ = writeln!(out, "  {:<34}{:>12}", "grade of the exchange areas", r.grade.name());
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

/// Temperatures and net powers by part, and their balance. Errors are the sum of exchange error and discretization error; without the latter the heading
/// says so.
fn heat(out: &mut String, r: &HeatReport, discretization: Option<&DiscretizationError>) {
    let restriction = if discretization.is_none() { "; ± of the exchange only" } else { "" };
    let _ = writeln!(out, "net power by part (temperature: fourth root of the mean of T^4{restriction})");
    let sunlight = if r.rows.iter().any(|x| x.absorbed_sunlight.is_some()) { "sunlight, W" } else { "" };
    let heading = format!(
        "  {:<26}{:>14}{:>20}{:>30}{:>28}{sunlight:>18}",
        "", "size", "temperature, K", "net flux", "net power, W"
    );
    let _ = writeln!(out, "{}", heading.trim_end());
    for i in 0..r.rows.len().min(MAX_HEAT_ROWS) {
        heat_row(out, r, (i, discretization));
    }
    if r.rows.len() > MAX_HEAT_ROWS {
        let rest: f64 = r.rows[MAX_HEAT_ROWS..].iter().map(|x| x.power).sum();
        let name = format!("{} more", r.rows.len() - MAX_HEAT_ROWS);
        let _ = writeln!(out, "  {name:<90}{:>28}", large_number(rest));
    }
    node_rows(out, r);
    for (name, power) in heat_balance(r) {
        let _ = writeln!(out, "  {name:<90}{:>28}", large_number(power));
    }
    let largest = r.rows.iter().fold(0.0f64, |m, x| m.max(x.power_error));
    let largest =
        if largest.is_finite() { format!("up to {} W", two_digits(largest)) } else { "unknown".into() };
    let _ = match discretization {
        Some(z) => writeln!(out, "  errors: {} plus exchange error ({largest})", discretization_text(z)),
        None => writeln!(out, "  errors: exchange error only; the discretization error was not requested"),
    };
}

/// Bodies at one temperature, with the powers that leave them.
fn node_rows(out: &mut String, r: &HeatReport) {
    if !r.nodes.is_empty() {
        let _ = writeln!(
            out,
            "  {:<26}{:>34}{:>18}{:>18}{:>18}",
            "nodes", "temperature, K", "radiated, W", "convected, W", "conducted, W"
        );
    }
    for n in r.nodes.iter().take(MAX_HEAT_ROWS) {
        let [radiated, convected, conducted] = [n.radiated, n.convected, n.conducted].map(large_number);
        let temperature = value_with_error(n.temperature, n.temperature_error);
        let _ =
            writeln!(out, "  {:<26}{temperature:>34}{radiated:>18}{convected:>18}{conducted:>18}", n.name);
    }
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
    (row, discretization): (usize, Option<&DiscretizationError>),
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

/// One part: size, temperature, net flux and net power.
fn heat_row(out: &mut String, r: &HeatReport, part: (usize, Option<&DiscretizationError>)) {
    let x = &r.rows[part.0];
    let sunlight = x.absorbed_sunlight.map_or(String::new(), |w| format!("{:>18}", large_number(w)));
    let [size, temperature, flux, power] = heat_cells(r, part, ["2", "3"]);
    let _ = writeln!(out, "  {:<26}{size:>14} {temperature:>19} {flux:>29} {power:>27}{sunlight}", x.name);
}

/// Origin of the discretization error.
fn discretization_text(z: &DiscretizationError) -> String {
    if z.zones == 0 && z.notes.iter().any(|n| n.code == "thick-scattering") {
        return "discretization error (an estimate for thick cells that scatter)".into();
    }
    if z.zones == 0 {
        return "discretization error (unknown)".into();
    }
    let zones = thousands(z.zones as u64);
    format!("discretization error (from {zones} zones of another size, ratio {:.2})", z.ratio)
}

/// The energy balance of light; the error of each power is exchange error plus discretization error, if known.
fn energy_balance(out: &mut String, s: &Solution) {
    let _ = writeln!(out, "power (W)");
    let discretization = s.report.discretization_error.as_ref();
    powers(out, s);
    band_row(out, "residual, relative", &s.all_bands(|t| t.report.energy.residual));
    let _ = match discretization {
        Some(z) => writeln!(out, "  errors: {} plus exchange error", discretization_text(z)),
        None => writeln!(
            out,
            "  errors: exchange error only; the discretization error was not requested (--discretization-error true)"
        ),
    };
}

fn powers(out: &mut String, s: &Solution) {
    power_rows(s).iter().for_each(|r| band_row_with_errors(out, &r.name, &r.values, &r.errors));
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

/// Number of bands in a line of a table.
const BANDS_PER_LINE: usize = 6;

/// A row of the values of all bands, or of one if they are equal.
fn band_row(out: &mut String, name: &str, v: &[f64]) {
    let shown = if v.windows(2).all(|w| w[0] == w[1]) { &v[..v.len().min(1)] } else { v };
    for (line, values) in shown.chunks(BANDS_PER_LINE).enumerate() {
        let cells: String = values.iter().map(|x| format!("{:>12}", number(*x))).collect();
        let _ = writeln!(out, "  {:<33} {cells}", if line == 0 { name } else { "" });
    }
}

/// A row of the values of all bands with errors, or of one if they are equal.
fn band_row_with_errors(out: &mut String, name: &str, v: &[f64], e: &[[f64; 2]]) {
    let is_grey = v.windows(2).all(|w| w[0] == w[1]) && e.windows(2).all(|w| w[0] == w[1]);
    let shown = if is_grey { 1 } else { v.len() };
    let text: Vec<String> = v.iter().zip(e).take(shown).map(|(v, e)| value_with_errors(*v, *e)).collect();
    for (line, cells) in text.chunks(BANDS_PER_LINE).enumerate() {
        let _ = writeln!(out, "  {:<33} {:>12}", if line == 0 { name } else { "" }, cells.join("   "));
    }
}

/// As [`number`], with one decimal up to 1e12.
fn large_number(x: f64) -> String {
    if (1e5..1e12).contains(&x.abs()) { format!("{x:.1}") } else { number(x) }
}

/// Number of decimals that shows two digits of an error.
fn error_decimals(e: f64) -> usize {
    (1.0 - e.log10().floor()).clamp(0.0, 12.0) as usize
}

/// An error to two digits.
fn two_digits(e: f64) -> String {
    if e == 0.0 {
        "0".into()
    } else if (1e-3..1e5).contains(&e) {
        format!("{e:.0$}", error_decimals(e))
    } else {
        format!("{e:.1e}")
    }
}

/// A value and its error; digits of the value below those of the error are left out.
#[must_use]
pub fn value_with_error(x: f64, e: f64) -> String {
    match e > 0.0 || e.is_nan() {
        true if !e.is_finite() => format!("{} ± unknown", large_number(x)),
        true if e >= 1e-3 && (1e-3..1e12).contains(&x.abs()) => {
            format!("{x:.0$} ± {1}", error_decimals(e), two_digits(e))
        }
        true => format!("{} ± {}", large_number(x), two_digits(e)),
        false => large_number(x),
    }
}

/// A value and the sum of two errors, of the exchange and of the zones; where one of them is unknown, the other is named beside it.
#[must_use]
pub fn value_with_errors(x: f64, [exchange, zones]: [f64; 2]) -> String {
    let text = value_with_error(x, exchange + zones);
    match [exchange, zones] {
        [e, z] if e > 0.0 && e.is_finite() && !z.is_finite() => {
            format!("{text} (exchange {})", two_digits(e))
        }
        [e, z] if z > 0.0 && z.is_finite() && !e.is_finite() => format!("{text} (zones {})", two_digits(z)),
        _ => text,
    }
}

/// A whole number with spaces between groups of three digits.
#[must_use]
pub fn thousands(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (k, d) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            out.push(' ');
        }
        out.push(d);
    }
    out
}
