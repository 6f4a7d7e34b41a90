//! Reports as text tables.

use std::fmt::Write;
use zonal_app::report_values::{
    distinct_diagnostics, heat_balance, heat_cells, large_number, light_group_powers, number, power_rows,
    thousands, two_digits, value_with_error, value_with_errors,
};
use zonal_app::timeline::{self, Phase};
use zonal_scene::{DiscretizationError, HeatReport, Report, Solution};

/// Largest number of parts in the table of heat.
const MAX_HEAT_ROWS: usize = 40;

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

/// Wall time, processor time and threads at work of phases, and of all of them.
#[must_use]
pub fn timeline(phases: &[Phase]) -> String {
    let mut out = format!("{:<40}{:>9}{:>14}{:>10}\n", "timings", "wall, s", "processor, s", "threads");
    for p in phases.iter().chain([&timeline::total(phases)]) {
        let name = if p.count > 1 { format!("{} ({} times)", p.name, p.count) } else { p.name.clone() };
        let [processor, threads] = [(p.processor_seconds(), 3), (p.threads_at_work(), 2)]
            .map(|(x, digits)| x.map_or("unknown".into(), |x| format!("{x:.digits$}")));
        let _ = writeln!(out, "  {name:<38}{:>9.3}{processor:>14}{threads:>10}", p.wall.as_secs_f64());
    }
    out
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
    for (name, parts) in s.error_parts() {
        let _ = writeln!(out, "  parts of the error of {name}: {parts}");
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
        heat_row(out, r, i, discretization);
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

/// One part: size, temperature, net flux and net power.
fn heat_row(out: &mut String, r: &HeatReport, row: usize, discretization: Option<&DiscretizationError>) {
    let x = &r.rows[row];
    let sunlight = x.absorbed_sunlight.map_or(String::new(), |w| format!("{:>18}", large_number(w)));
    let [size, temperature, flux, power] = heat_cells(r, row, discretization, ["2", "3"]);
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
    for r in power_rows(s) {
        band_row_with_errors(out, &r.name, &r.values, &r.errors);
    }
    band_row(out, "residual, relative", &s.all_bands(|t| t.report.energy.residual));
    let _ = match discretization {
        Some(z) => writeln!(out, "  errors: {} plus exchange error", discretization_text(z)),
        None => writeln!(
            out,
            "  errors: exchange error only; the discretization error was not requested (--discretization-error true)"
        ),
    };
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
