//! Tables of the page: powers, surfaces, temperatures, light groups, accuracy, settings.

use crate::report_values::{
    heat_balance, heat_cells, light_group_powers, number, power_rows, thousands, value_with_error,
    value_with_errors,
};
use std::fmt::Write;
use zonal_scene::{HeatReport, Solution};

/// Most rows of a table.
const MAX_ROWS: usize = 400;

/// Text with the characters that have a meaning in HTML replaced.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            c => out.push(c),
        }
    }
    out
}

/// A table of text; the first cell of a row is its heading.
struct Table {
    title: &'static str,
    heading: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    fn new(title: &'static str, heading: &[&str]) -> Table {
        Table { title, heading: heading.iter().map(|h| (*h).to_string()).collect(), rows: Vec::new() }
    }

    /// Appends the table, unless it is empty.
    fn write(&self, out: &mut String) {
        if self.rows.is_empty() {
            return;
        }
        let _ = writeln!(out, "<h2>{}</h2>\n<div class=\"table\"><table>", self.title);
        if !self.heading.is_empty() {
            let cells: String = self.heading.iter().map(|h| format!("<th>{}</th>", escaped(h))).collect();
            let _ = writeln!(out, "<thead><tr>{cells}</tr></thead>");
        }
        *out += "<tbody>\n";
        for row in self.rows.iter().take(MAX_ROWS) {
            let mut cells = row.iter().map(|c| escaped(c));
            let first = cells.next().unwrap_or_default();
            let others: String = cells.map(|c| format!("<td>{c}</td>")).collect();
            let _ = writeln!(out, "<tr><th>{first}</th>{others}</tr>");
        }
        *out += "</tbody></table></div>\n";
        if self.rows.len() > MAX_ROWS {
            let rest = thousands((self.rows.len() - MAX_ROWS) as u64);
            let _ = writeln!(out, "<p>{rest} more rows; zonal export writes all of them.</p>");
        }
    }
}

/// True if all bands have the same value.
fn is_grey(v: &[f64]) -> bool {
    v.windows(2).all(|w| w[0] == w[1])
}

/// Results with errors.
pub(super) fn results(out: &mut String, s: &Solution) {
    if s.report.discretization_error.is_none() {
        *out += "<p class=\"aside\">Errors are those of the exchange and of the solver; the error by the size of the zones was not requested.</p>\n";
    }
    match &s.report.heat {
        Some(heat) => {
            heat_table(s, heat).write(out);
            node_table(heat).write(out);
        }
        None => {
            power_table(s).write(out);
            surface_table(s).write(out);
            group_table(s).write(out);
        }
    }
    accuracy_table(s).write(out);
}

/// The names of the bands, or one heading where all powers are grey.
fn band_headings(s: &Solution, grey: bool, unit: &str) -> Vec<String> {
    let bands = s.scene.bands();
    if grey {
        return vec![format!("each band, {unit}")];
    }
    (0..bands.count()).map(|b| format!("{}, {unit}", bands.name(b))).collect()
}

fn power_table(s: &Solution) -> Table {
    let rows = power_rows(s);
    let grey = rows.iter().all(|r| is_grey(&r.values) && r.errors.windows(2).all(|w| w[0] == w[1]));
    let shown = if grey { 1 } else { usize::MAX };
    let mut table = Table::new("Power", &[""]);
    table.heading.extend(band_headings(s, grey, "W"));
    for r in rows.iter().filter(|r| r.values.iter().any(|x| *x != 0.0)) {
        let cells = r.values.iter().zip(&r.errors).take(shown).map(|(v, e)| value_with_errors(*v, *e));
        table.rows.push(std::iter::once(r.name.clone()).chain(cells).collect());
    }
    table
}

fn surface_table(s: &Solution) -> Table {
    let mut table = Table::new("Surfaces", &["", "area, m²", "emitted less absorbed, W", "per area, W/m²"]);
    for r in s.surfaces() {
        let errors = [r.exchange_error, r.discretization_error.unwrap_or(0.0)];
        let per_area = |e: f64| if r.area > 0.0 { e / r.area } else { 0.0 };
        table.rows.push(vec![
            r.name.clone(),
            number(r.area),
            value_with_errors(r.net_power, errors),
            value_with_errors(r.net_flux(), errors.map(per_area)),
        ]);
    }
    table
}

fn group_table(s: &Solution) -> Table {
    let all = light_group_powers(s);
    let grey = all.iter().all(|(_, power)| is_grey(power));
    let mut table = Table::new("Light groups", &["emitted power"]);
    table.heading.extend(band_headings(s, grey, "W"));
    if all.len() > 1 {
        for (name, power) in &all {
            let cells = power.iter().take(if grey { 1 } else { usize::MAX }).map(|x| number(*x));
            table.rows.push(std::iter::once(name.to_string()).chain(cells).collect());
        }
    }
    table
}

fn heat_table(s: &Solution, heat: &HeatReport) -> Table {
    let mut table =
        Table::new("Net power by part", &["", "size", "temperature, K", "net flux", "net power, W"]);
    for (k, r) in heat.rows.iter().enumerate() {
        let cells = heat_cells(heat, k, s.report.discretization_error.as_ref(), ["²", "³"]);
        table.rows.push(std::iter::once(r.name.clone()).chain(cells).collect());
    }
    for (name, power) in heat_balance(heat) {
        let blank = String::new;
        table.rows.push(vec![name.to_string(), blank(), blank(), blank(), number(power)]);
    }
    table
}

fn node_table(heat: &HeatReport) -> Table {
    let mut table =
        Table::new("Bodies", &["", "temperature, K", "radiated, W", "convected, W", "conducted, W"]);
    for n in &heat.nodes {
        let temperature = value_with_error(n.temperature, n.temperature_error);
        let [radiated, convected, conducted] = [n.radiated, n.convected, n.conducted].map(number);
        table.rows.push(vec![n.name.clone(), temperature, radiated, convected, conducted]);
    }
    table
}

/// Largest value over the bands.
fn largest(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |m: f64, x| if x.is_nan() { f64::INFINITY } else { m.max(*x) })
}

fn accuracy_table(s: &Solution) -> Table {
    let mut table = Table::new("Accuracy", &[]);
    let mut row = |name: &str, text: String| table.rows.push(vec![name.to_string(), text]);
    let grade = s.report.estimate.grade.name();
    let relative = |v: Vec<f64>| format!("{} ({grade}, worst band)", percent(largest(&v)));
    row("tolerance", percent(s.scene.options().tolerance));
    if !s.zones.patches.is_empty() {
        row("error of H, relative", relative(s.all_bands(|t| t.report.estimate.patches)));
    }
    if s.zones.len() > s.zones.patches.len() {
        row("error of G, relative", relative(s.all_bands(|t| t.report.estimate.volumes)));
    }
    for (name, parts) in s.error_parts() {
        row(&format!("parts of the error of {name}"), parts.to_string());
    }
    row("grade of the exchange areas", s.report.grade.name().into());
    row("largest defect of a row sum", number(largest(&s.all_bands(|t| t.report.closure.worst))));
    row("imbalance of power, relative", number(largest(&s.all_bands(|t| t.report.energy.residual.abs()))));
    for (b, t) in s.blocks().flat_map(|t| t.scene.window().zip(t.report.status.iter())).collect::<Vec<_>>() {
        row(&format!("iteration, {}", s.scene.bands().name(b)), t.name().into());
    }
    table
}

fn percent(x: f64) -> String {
    if x.is_finite() { format!("{} %", number(100.0 * x)) } else { "unknown".into() }
}

/// Settings, counts and origin.
pub(super) fn provenance(out: &mut String, s: &Solution, file: &str) {
    let o = s.scene.options();
    let mut table = Table::new("Provenance", &[]);
    let mut row = |name: &str, text: String| table.rows.push(vec![name.to_string(), text]);
    row("solution", file.into());
    row("hash of the scene", s.scene_hash.clone());
    row("solved by", format!("zonal {}", s.version));
    row("page by", format!("zonal {}", env!("CARGO_PKG_VERSION")));
    row("patch size", format!("{} m, by {}", number(s.scene.patch_size()), o.patch_rule.name()));
    row("engine asked for", o.engine.name().into());
    let (low, high) = s.scene.bounds();
    let size = (high - low).array().map(number).join(" × ");
    row("extent", format!("{size} m"));
    for (name, count) in s.report.counts.iter().filter(|c| c.1 > 0) {
        row(name, thousands(*count));
    }
    table.write(out);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_write_markup() {
        assert_eq!(escaped("<b>&\"x\""), "&lt;b&gt;&amp;&quot;x&quot;");
    }
}
