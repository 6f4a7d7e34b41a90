//! A solution as one page of HTML for readers: pictures, tables with errors, convergence and provenance.
//!
//! The page loads nothing, runs no script, and is the same for the same solution. Values and errors are those of the table of `zonal solve`; an error that is
//! not known is written as unknown.

mod figures;
mod tables;

pub use figures::{Figure, FigureSettings, figures};

use crate::pages::base64::base64;
use crate::report_values::{distinct_diagnostics, thousands};
use std::fmt::Write;
use tables::escaped;
use zonal_report::plot::{LINEAR_LOG, Plot, SeriesMark};
use zonal_scene::Solution;

const STYLE: &str = include_str!("report.css");

/// The page of a solution; `file` is the name of its file.
#[must_use]
pub fn page(s: &Solution, file: &str, figures: &[Figure]) -> String {
    let name = escaped(s.scene.name());
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\">\n\
         <title>{name}: report</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{name}</h1>\n"
    );
    let mode = if s.scene.thermal().is_some() { "heat" } else { "light" };
    let report = &s.report;
    let _ = writeln!(
        out,
        "<p>{} zones, {mode}, solved by the {} engine ({}).</p>",
        thousands(s.zones.len() as u64),
        escaped(&report.engine),
        escaped(&report.reason)
    );
    notes(&mut out, s);
    pictures(&mut out, figures);
    tables::results(&mut out, s);
    convergence(&mut out, s);
    tables::provenance(&mut out, s, file);
    out += "</main>\n</body>\n</html>\n";
    out
}

/// Warnings first, then notes, each once.
fn notes(out: &mut String, s: &Solution) {
    let mut all = distinct_diagnostics(s);
    if all.is_empty() {
        return;
    }
    all.sort_by_key(|d| !d.is_warning());
    *out += "<h2>Notes</h2>\n<ul class=\"notes\">\n";
    for d in all {
        let class = d.severity.name();
        let _ = writeln!(out, "<li class=\"{class}\"><b>{class}</b> {}</li>", escaped(&d.to_string()));
    }
    *out += "</ul>\n";
}

fn pictures(out: &mut String, figures: &[Figure]) {
    if figures.is_empty() {
        return;
    }
    *out += "<h2>Pictures</h2>\n<div class=\"pictures\">\n";
    for f in figures {
        let caption = escaped(&f.caption);
        let _ = writeln!(
            out,
            "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{}\"><figcaption>{caption}</figcaption></figure>",
            base64(&f.png)
        );
    }
    *out += "</div>\n";
}

/// Residual against iteration for every band.
fn convergence(out: &mut String, s: &Solution) {
    let histories: Vec<Vec<f64>> = s
        .blocks()
        .flat_map(|t| t.report.residuals.iter().take(t.scene.window().len()).cloned().collect::<Vec<_>>())
        .collect();
    // A solve in one step has no curve.
    if histories.iter().all(|h| h.len() < 3) {
        return;
    }
    let mut plot = Plot::new("Convergence", "iteration", "relative residual", LINEAR_LOG);
    let names = s.scene.bands();
    let mut drawn: Vec<&Vec<f64>> = Vec::new();
    for (band, history) in histories.iter().enumerate().filter(|(_, h)| !h.is_empty()) {
        // Bands of one grey scene have one curve.
        if drawn.contains(&history) || drawn.len() == MAX_CURVES {
            continue;
        }
        let points = history.iter().enumerate().map(|(k, r)| (k as f64, *r)).collect();
        plot.add(&names.name(band), SeriesMark::Line, drawn.len(), points);
        drawn.push(history);
    }
    if let Some(svg) = plot.svg() {
        *out += "<h2>Convergence</h2>\n<div class=\"plot\">\n";
        *out += &svg;
        *out += "</div>\n";
    }
}

/// Most curves in the plot of residuals.
const MAX_CURVES: usize = 8;
