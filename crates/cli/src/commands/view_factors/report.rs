//! The report of `zonal view-factors`.

use super::Args;
use super::Context;
use super::geometry::FactorGeometry;
use zonal_report::{Failure, say};
use zonal_scene::{Diagnostic, printable};
use zonal_view_factors::{ViewFactorCounts, ViewFactors};

/// Rows that a warning names, at most.
const MAX_NAMED_ROWS: usize = 8;

/// Figures of a computation.
pub(super) struct FactorReport {
    facets: usize,
    factors: usize,
    counts: ViewFactorCounts,
    grade: &'static str,
    largest_factor: f64,
    largest_radius: f64,
    defect_before: f64,
    defect: f64,
    open_rows: Vec<usize>,
    diagnostics: Vec<Diagnostic>,
}

impl FactorReport {
    /// The figures of factors, before their arrays are taken.
    pub(super) fn of(geometry: &FactorGeometry, factors: &ViewFactors, tolerance: f64) -> FactorReport {
        let n = factors.len();
        let largest = |f: &dyn Fn(usize) -> f64| (0..n).map(f).fold(0.0, f64::max);
        let closed = closed_rows(factors);
        FactorReport {
            facets: n,
            factors: factors.entry_count(),
            counts: factors.counts,
            grade: factors.grade().name(),
            largest_factor: largest(&|i| factors.row(i).fold(0.0, |s, (_, b)| b.value.max(s))),
            largest_radius: largest(&|i| factors.row(i).fold(0.0, |s, (_, b)| b.radius.max(s))),
            defect_before: largest(&|i| if closed[i] { factors.defects()[i].abs() } else { 0.0 }),
            defect: factors.remaining_defect(),
            open_rows: factors.open_rows().to_vec(),
            diagnostics: diagnostics(geometry, factors, tolerance),
        }
    }

    /// Prints the figures with time, threads and memory; warns of open rows.
    pub(super) fn print(&self, args: &Args, seconds: f64, context: Context) -> Result<(), Failure> {
        let threads = rayon::current_num_threads();
        let memory = peak_memory();
        let (counts, path) = (self.counts, args.output.display());
        if context.json {
            let json = serde_json::json!({
                "facets": self.facets, "factors": self.factors, "occluders": counts.occluders,
                "examined_pairs": counts.examined, "unobstructed_pairs": counts.unobstructed,
                "hidden_pairs": counts.hidden, "partial_pairs": counts.partial,
                "grade": self.grade, "largest_factor": self.largest_factor, "largest_radius": self.largest_radius,
                "largest_defect_before_closing": self.defect_before, "largest_defect": self.defect,
                "open_rows": self.open_rows, "seconds": seconds, "threads": threads,
                "peak_memory_bytes": memory, "written": path.to_string(),
                "warnings": zonal_io::output::notes_json(&self.diagnostics),
            });
            say(&format!("{json:#}"))?;
            return context.check_warnings(&self.diagnostics);
        }
        let memory =
            memory.map_or(String::new(), |b| format!(", {:.2} GiB at most", b as f64 / f64::from(1 << 30)));
        say(&format!(
            "{} facets, {} factors, grade {}; pairs: {} unobstructed, {} hidden by one occluder, {} partly hidden or hidden by several",
            self.facets, self.factors, self.grade, counts.unobstructed, counts.hidden, counts.partial
        ))?;
        say(&format!(
            "largest factor {:.6}, largest error radius {:.1e}; rows miss one by {:.1e} at most before closing, {:.1e} after",
            self.largest_factor, self.largest_radius, self.defect_before, self.defect
        ))?;
        say(&format!("{seconds:.2} s, {threads} thread(s){memory}\nwritten: {path}"))?;
        for d in &self.diagnostics {
            say(&format!("  {}", printable(&d.line())))?;
        }
        context.check_warnings(&self.diagnostics)
    }
}

fn closed_rows(factors: &ViewFactors) -> Vec<bool> {
    let mut closed = vec![true; factors.len()];
    factors.open_rows().iter().for_each(|i| closed[*i] = false);
    closed
}

fn diagnostics(geometry: &FactorGeometry, factors: &ViewFactors, tolerance: f64) -> Vec<Diagnostic> {
    let mut all: Vec<Diagnostic> =
        geometry.notes.iter().map(|n| Diagnostic::note("facets", n.clone())).collect();
    let empty = factors.areas().iter().filter(|a| **a <= 0.0).count();
    if empty > 0 {
        all.push(Diagnostic::note(
            "facets_without_area",
            format!("{empty} facet(s) have no area; their rows are empty"),
        ));
    }
    let open = factors.open_rows();
    if !open.is_empty() {
        let first: Vec<String> = open.iter().take(MAX_NAMED_ROWS).map(|i| (i + 1).to_string()).collect();
        let more = if open.len() > MAX_NAMED_ROWS { ", …" } else { "" };
        all.push(Diagnostic::warning(
            "open_rows",
            format!(
                "{} row(s) are not closed ({}{more}, from 1): these facets lie partly inside a solid, or see backs of facets; cut the facets along the solids, turn the facets, or count both sides of all (--sides both)",
                open.len(),
                first.join(", ")
            ),
        ));
    }
    all.extend(wide_radii(factors, tolerance));
    all
}

/// A warning of factors whose error radii are larger than the tolerance.
fn wide_radii(factors: &ViewFactors, tolerance: f64) -> Option<Diagnostic> {
    let (mut count, mut widest) = (0u64, (0.0, 0, 0));
    for i in 0..factors.len() {
        for (j, b) in factors.row(i).filter(|(_, b)| b.radius > tolerance) {
            count += 1;
            if b.radius > widest.0 {
                widest = (b.radius, i + 1, j + 1);
            }
        }
    }
    let (radius, i, j) = widest;
    (count > 0).then(|| {
        Diagnostic::warning(
            "wide_radii",
            format!(
                "{count} factor(s) have error radii above the tolerance {tolerance:e}, the largest {radius:.1e} (row {i}, column {j}, from 1): their facets are partly hidden, or see images that are not represented; divide large facets, or count with these radii"
            ),
        )
    })
}

/// Largest memory of the process so far, bytes, where the system tells it.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kb| kb * 1024)
}
