//! Warnings and notes of view factors, for the command and for Python.

use zonal_scene::Diagnostic;
use zonal_view_factors::{RowClosing, ViewFactorSettings, ViewFactors};

/// Rows that a warning names, at most.
const MAX_NAMED_ROWS: usize = 8;

/// How an entry point numbers rows and names its settings.
#[derive(Clone, Copy, Debug)]
pub struct FactorWords {
    /// Number of the first row.
    pub first_row: usize,
    /// The setting that gives backs rows of their own.
    pub both_sides: &'static str,
}

impl FactorWords {
    /// The command: rows from 1.
    pub const COMMAND: FactorWords = FactorWords { first_row: 1, both_sides: "--sides both" };
    /// The Python package: rows from 0.
    pub const PYTHON: FactorWords = FactorWords { first_row: 0, both_sides: "sides=\"both\"" };
}

/// Notes of the reader, and what users have to know of a result: facets without area, rows that stay open where rows are closed, and radii above the tolerance.
pub fn diagnostics(
    reader_notes: &[String],
    factors: &ViewFactors,
    settings: &ViewFactorSettings,
    words: &FactorWords,
) -> Vec<Diagnostic> {
    let mut all: Vec<Diagnostic> =
        reader_notes.iter().map(|n| Diagnostic::note("facets", n.clone())).collect();
    let empty = factors.areas().iter().filter(|a| **a <= 0.0).count();
    if empty > 0 {
        all.push(Diagnostic::note(
            "facets-without-area",
            format!("{empty} facet(s) have no area; their rows are empty"),
        ));
    }
    if settings.closure == RowClosing::Restore {
        all.extend(open_rows(factors, words));
    }
    all.extend(wide_radii(factors, settings.tolerance, words));
    all
}

/// A warning of rows that stay open.
fn open_rows(factors: &ViewFactors, words: &FactorWords) -> Option<Diagnostic> {
    let open = factors.open_rows();
    if open.is_empty() {
        return None;
    }
    let FactorWords { first_row, both_sides } = words;
    let first: Vec<String> = open.iter().take(MAX_NAMED_ROWS).map(|i| (i + first_row).to_string()).collect();
    let more = if open.len() > MAX_NAMED_ROWS { ", …" } else { "" };
    Some(Diagnostic::warning(
        "open-rows",
        format!(
            "{} row(s) are not closed ({}{more}, from {first_row}): these facets lie partly inside a solid, or see backs of facets or obstacles, which are no part of a row; cut the facets along the solids, turn the facets, give obstacles as facets, or count both sides of all ({both_sides})",
            open.len(),
            first.join(", ")
        ),
    ))
}

/// A warning of factors whose error radii are larger than the tolerance.
fn wide_radii(factors: &ViewFactors, tolerance: f64, words: &FactorWords) -> Option<Diagnostic> {
    let (mut count, mut widest) = (0u64, (0.0, 0, 0));
    for i in 0..factors.len() {
        for (j, b) in factors.row(i).filter(|(_, b)| b.radius > tolerance) {
            count += 1;
            if b.radius > widest.0 {
                widest = (b.radius, i, j);
            }
        }
    }
    let (radius, i, j) = widest;
    let first = words.first_row;
    (count > 0).then(|| {
        Diagnostic::warning(
            "wide-radii",
            format!(
                "{count} factor(s) have error radii above the tolerance {tolerance:e}, the largest {radius:.1e} (row {}, column {}, from {first}): their facets are partly hidden, or see images that are not represented; divide large facets, or count with these radii",
                i + first,
                j + first
            ),
        )
    })
}
