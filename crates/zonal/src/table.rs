//! Reports as tables for people.

use std::fmt::Write;
use zonal_scene::solution::Energy;
use zonal_scene::{Bands, HeatKind, HeatReport, Report, Solution, Zoning};

/// Significant digits enough for a table.
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

fn row(out: &mut String, name: &str, v: Bands) {
    // Grey light is one number.
    let cells = if v[0] == v[1] && v[1] == v[2] {
        format!("{:>12}", number(v[0]))
    } else {
        v.map(|x| format!("{:>12}", number(x))).concat()
    };
    let _ = writeln!(out, "  {name:<33} {cells}");
}

/// The report of a solution: what was computed, the balance, closure, the solver's end.
pub fn report(s: &Solution) -> String {
    let r = &s.report;
    let mut out = String::new();
    let _ = writeln!(out, "computed");
    for (name, count) in r.counts.iter().filter(|c| c.1 > 0) {
        let _ = writeln!(out, "  {name:<34}{:>12}", grouped(*count));
    }
    match &r.heat {
        Some(heat) => self::heat(&mut out, heat, r.zoning.as_ref()),
        None => {
            balance(&mut out, r);
        }
    }
    if s.groups.len() > 1 {
        out += &groups(s);
    }
    let c = &r.closure;
    let _ = writeln!(out, "quality");
    let _ = writeln!(out, "  {:<34}{:>12}", "engine", format!("{} ({})", r.engine, r.reason));
    if !s.zones.patches.is_empty() {
        row(&mut out, "estimated error of H, relative", r.estimate.patches);
    }
    if s.zones.len() > s.zones.patches.len() {
        row(&mut out, "estimated error of G, relative", r.estimate.volumes);
    }
    let _ = writeln!(out, "  {:<34}{:>12}", "grade of the estimate", r.estimate.grade.word());
    row(&mut out, "closure, largest defect", c.worst);
    row(&mut out, "closure, rms defect", c.rms);
    if c.restored {
        row(&mut out, "closure restored: largest change", c.largest_change);
        row(&mut out, "closure after", c.after);
    }
    for (band, (status, history)) in r.status.iter().zip(&r.residuals).enumerate() {
        let last = history.last().copied().unwrap_or(0.0);
        let text =
            format!("{} in {} steps, residual {}", status.word(), history.len().max(1) - 1, number(last));
        let _ = writeln!(out, "  {:<34}{text:>12}", format!("solver, band {band}"));
    }
    let _ = writeln!(out, "  {:<34}{:>12}", "grade of the exchange areas", r.grade.word());
    for w in r.warnings.iter().chain(r.zoning.iter().flat_map(|z| &z.notes)) {
        let _ = writeln!(out, "  {}", w.line());
    }
    out
}

/// The light groups: the power that each gives.
pub fn groups(s: &Solution) -> String {
    let mut out = String::from("light groups (W given)\n");
    for g in &s.groups {
        let e = &g.energy;
        row(&mut out, &g.name, [0, 1, 2].map(|b| e.emitted[b] + e.incoming[b]));
    }
    out
}

/// Temperatures and net powers by name, and their balance. Errors are those of the exchange and of the zones; where nobody asked for the latter,
/// those of the exchange alone, which the heading says.
fn heat(out: &mut String, r: &HeatReport, zoning: Option<&Zoning>) {
    const MOST: usize = 40;
    let only = if zoning.is_none() { "; ± of the exchange only" } else { "" };
    let _ = writeln!(out, "heat given (net; temperatures of mean T^4{only})");
    let _ = writeln!(
        out,
        "  {:<26}{:>14}{:>20}{:>30}{:>28}",
        "", "size", "temperature, K", "net flux", "net power, W"
    );
    for (i, x) in r.rows.iter().enumerate().take(MOST) {
        let unit = if x.kind == HeatKind::Surface { "2" } else { "3" };
        let [kelvin, watts] = match zoning {
            Some(z) => z.heat.get(i).copied().unwrap_or([f64::INFINITY; 2]),
            None => [0.0; 2],
        };
        let warm = |t| with(t, x.temperature_error.unwrap_or(f64::INFINITY) + kelvin);
        let power = x.power_error + watts;
        let _ = writeln!(
            out,
            "  {:<26}{:>14}{:>20}{:>30}{:>28}",
            x.name,
            format!("{} m{unit}", number(x.size)),
            x.temperature.map_or("undefined".into(), warm),
            format!("{} W/m{unit}", with(x.over_size(x.power), x.over_size(power))),
            with(x.power, power)
        );
    }
    if r.rows.len() > MOST {
        let rest: f64 = r.rows[MOST..].iter().map(|x| x.power).sum();
        let _ = writeln!(out, "  {:<90}{:>28}", format!("{} more", r.rows.len() - MOST), large(rest));
    }
    for (name, power) in [
        ("from the surroundings, less what escapes", r.surroundings),
        ("lost on cold black backs", -r.backs),
        ("balance", r.balance()),
    ] {
        let _ = writeln!(out, "  {name:<90}{:>28}", large(power));
    }
    let most = r.rows.iter().fold(0.0f64, |m, x| m.max(x.power_error));
    let most = if most.is_finite() { format!("up to {} W", rough(most)) } else { "unknown".into() };
    let _ = match zoning {
        Some(z) if z.zones > 0 => {
            writeln!(out, "  errors: of the zones, estimated from {}, and of the exchange, {most}", others(z))
        }
        Some(_) => writeln!(out, "  errors: of the zones, unknown, and of the exchange, {most}"),
        None => {
            writeln!(out, "  errors are those of the exchange only: those of the zones were not asked for")
        }
    };
}

/// The zones of the second solve.
fn others(z: &Zoning) -> String {
    format!("{} of another size, a factor of {:.2} across", grouped(z.zones as u64), z.ratio)
}

/// As [`number`], with a tenth of a unit where that is large.
fn large(x: f64) -> String {
    if (1e5..1e12).contains(&x.abs()) { format!("{x:.1}") } else { number(x) }
}

/// Decimals that an error is told with: two digits of it.
fn decimals(e: f64) -> usize {
    (1.0 - e.log10().floor()).clamp(0.0, 12.0) as usize
}

/// An error to two digits.
fn rough(e: f64) -> String {
    if e == 0.0 {
        "0".into()
    } else if (1e-3..1e5).contains(&e) {
        format!("{e:.0$}", decimals(e))
    } else {
        format!("{e:.1e}")
    }
}

/// A value and its error; digits that the error leaves open are not shown.
fn with(x: f64, e: f64) -> String {
    match e > 0.0 || e.is_nan() {
        true if !e.is_finite() => format!("{} ± unknown", large(x)),
        true if e >= 1e-3 && (1e-3..1e12).contains(&x.abs()) => {
            format!("{x:.0$} ± {1}", decimals(e), rough(e))
        }
        true => format!("{} ± {}", large(x), rough(e)),
        false => large(x),
    }
}

/// The balance of light, each power with its error: that of the exchange and, where it is known, that of the zones.
fn balance(out: &mut String, r: &Report) {
    let _ = writeln!(out, "power (W)");
    let all = r.energy_error.clone();
    let errors = match &r.zoning {
        Some(z) => all.compared(&z.energy, |a, b| a + b),
        None => all,
    };
    powers(out, &r.energy, &errors);
    row(out, "residual, relative", r.energy.residual);
    let _ = match &r.zoning {
        Some(z) if z.zones > 0 => {
            writeln!(out, "  errors: of the zones, estimated from {}, and of the exchange", others(z))
        }
        Some(_) => writeln!(out, "  errors: of the zones, unknown, and of the exchange"),
        None => writeln!(
            out,
            "  errors are those of the exchange only: those of the zones were not asked for (--zoning-error true)"
        ),
    };
}

/// A row of values with their errors, of grey light once.
fn row_with_errors(out: &mut String, name: &str, v: Bands, e: Bands) {
    let grey = v[0] == v[1] && v[1] == v[2] && e[0] == e[1] && e[1] == e[2];
    let bands = if grey { 1 } else { 3 };
    let text: Vec<String> = (0..bands).map(|b| with(v[b], e[b])).collect();
    let _ = writeln!(out, "  {name:<33} {:>12}", text.join("   "));
}

fn powers(out: &mut String, v: &Energy, e: &Energy) {
    let plus = |a: Bands, b: Bands| [0, 1, 2].map(|k| a[k] + b[k]);
    row_with_errors(out, "emitted", v.emitted, e.emitted);
    row_with_errors(out, "incoming", v.incoming, e.incoming);
    const MOST: usize = 12;
    let errors = |k: usize| e.absorbed_surfaces.get(k).map_or([f64::INFINITY; 3], |x| x.1);
    for (k, (name, power)) in v.absorbed_surfaces.iter().enumerate().take(MOST) {
        row_with_errors(out, &format!("absorbed by {name}"), *power, errors(k));
    }
    let all = v.absorbed_surfaces.len();
    if all > MOST {
        let rest = (MOST..all).fold([0.0; 3], |s, k| plus(s, v.absorbed_surfaces[k].1));
        let error = (MOST..all).fold([0.0; 3], |s, k| plus(s, errors(k)));
        row_with_errors(out, &format!("absorbed by {} more surfaces", all - MOST), rest, error);
    }
    row_with_errors(out, "absorbed by the medium", v.absorbed_volumes, e.absorbed_volumes);
    row_with_errors(out, "absorbed by panes", v.absorbed_panes, e.absorbed_panes);
    row_with_errors(out, "escaped", v.escaped, e.escaped);
    row_with_errors(out, "lost on black backs", v.backs, e.backs);
}

fn grouped(n: u64) -> String {
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
