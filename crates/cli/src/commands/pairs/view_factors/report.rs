//! The report of `zonal view-factors`.

use super::Args;
use super::Context;
use zonal_app::pairs::view_factors::diagnostics::{FactorWords, diagnostics};
use zonal_app::pairs::view_factors::geometry::FactorGeometry;
use zonal_report::{Failure, say};
use zonal_scene::{Diagnostic, printable};
use zonal_view_factors::{ViewFactorCounts, ViewFactorSettings, ViewFactors};

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
    pub(super) fn of(
        geometry: &FactorGeometry,
        factors: &ViewFactors,
        settings: &ViewFactorSettings,
    ) -> FactorReport {
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
            diagnostics: diagnostics(&geometry.notes, factors, settings, &FactorWords::COMMAND),
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
            context.say_json(json)?;
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

/// Largest memory of the process so far, bytes, where the system tells it.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kb| kb * 1024)
}
