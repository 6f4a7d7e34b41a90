//! The page of a campaign: verdicts, tables and a plot.

use super::CoverageOptions;
use super::result::{Quantity, QuantityKind, SceneResult};
use super::summary::{CampaignSummary, CoverageCounts};
use crate::harness::Error;
use std::fmt::Write as _;
use std::path::Path;
use zonal_report::plot::{LOG_LOG, LegendPlacement, Plot, SeriesMark};

/// The largest relative difference in the plot.
const MAX_PLOTTED_DIFFERENCE: f64 = 10.0;
/// The most points of a cloud in the plot.
const MAX_PLOTTED_POINTS: usize = 1500;

fn row(name: &str, l: &CoverageCounts) -> String {
    let far = format!("{} / {}", l.far[0], l.far[1]);
    let [names, zones] = [[l.names_covered, l.names], [l.zones_covered, l.zones]].map(|[part, of]| {
        if of == 0 { "–".into() } else { format!("{:.2} % of {of}", CoverageCounts::percent(part, of)) }
    });
    format!("| {name} | {} | {names} | {zones} | {} | {far} |\n", l.scenes, l.unknown)
}

/// Verdicts and tables, in Markdown.
pub(super) fn tables(s: &CampaignSummary) -> String {
    const HEAD: &str = "| | scenes | sums by name covered | zones covered by twice their error | unknown | beyond ten times, silent / warned |\n|---|---:|---:|---:|---:|---:|\n";
    let mut t = String::from("| requirement | result | |\n|---|---|---|\n");
    for (asked, found, holds) in s.verdicts() {
        let _ = writeln!(t, "| {asked} | {found} | {} |", if holds { "pass" } else { "FAIL" });
    }
    let _ = write!(t, "\n{HEAD}{}", row("all", &s.all));
    for (name, l) in s.by_engine.iter().filter(|l| l.1.scenes > 0) {
        t += &row(name, l);
    }
    let _ = writeln!(t, "\n{} scenes were refused by every engine.\n", s.refused);
    t += HEAD;
    for (name, l) in &s.by_feature {
        t += &row(name, l);
    }
    t += "\n| equivalent form | scenes | sums compared | unknown | beyond the stated errors |\n|---|---:|---:|---:|---:|\n";
    for (name, [scenes, sums, unknown, broken]) in &s.invariances {
        let _ = writeln!(t, "| {name} | {scenes} | {sums} | {unknown} | {broken} |");
    }
    t
}

impl CoverageOptions {
    /// Writes the page, and the plot beside it.
    pub(super) fn write_page(
        &self,
        path: &Path,
        done: &[SceneResult],
        s: &CampaignSummary,
    ) -> Result<(), Error> {
        let plot = path.with_extension("svg");
        draw(done).write(&plot)?;
        let file = plot.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let (n, seed, walks) = (done.len(), self.seed, self.walks);
        let small = if self.small { " --small" } else { "" };
        let text = format!(
            "# Coverage: stated against true errors\n\n\
        Written by\n\n<!-- test: skip: it solves 1000 scenes and walks for 45 minutes -->\n\n    cargo run --release -p zonal-campaigns -- coverage --random {n} --seed {seed} --walks {walks}{small} --page docs/coverage.md\n\n\
        {n} random scenes (boxes; rooms with solids, nested and touching; panes; plates; rotated rooms; hollow shells; periodic boxes; thin, thick and\n\
        varying media; all kinds of light; thermal mode with all boundary conditions; one to three bands; in four of ten scenes patches outside the box of the\n\
        medium, media that fill a part of a room, white media of depth 1 to 100, suns partly below the horizon, flawed mesh files, needles, rooms turned inside\n\
        out, panes between symmetry planes, small emitters in haze, many small solids) are solved by every applicable engine and\n\
        by {walks} random walks per band. A sum by name (absorbed power, net power, temperature) is compared with the continuous problem; its\n\
        stated error includes the discretization error. The incident radiation and the temperature of a zone are compared with the exact\n\
        solution of the zonal equations on the same zones; those of the rays engine with walks that go on from patches close by, as its rays do. *Covered* means |difference| ≤ stated error + 3σ of the reference for sums, 2 × stated error + 3σ for zones.\n\n\
        - *Beyond ten times* means |difference| > 10 × stated error + 6σ. Where the exchange is exact, the stated error of a zone is nearly zero, and among a hundred\n  \
        thousand Monte Carlo means several hundred differ by more than 3σ; none should differ by more than 6σ.\n\
        - A scene with a sum that is not covered, or a zone beyond ten times, is repeated with ten times as many walks, and that result counts.\n\
        - Zones with σ above 4 % of the value are not compared: the spread of few walks is no reliable standard error.\n\
        - In a thin medium between two infinite plates some radiation travels farther than any walk; its estimate is part of σ (`reference/src/forward_monte_carlo/grazing_error.rs`).\n\
        - Given quantities (a temperature, a net power) do not count. Unknown errors count as not covered.\n\
        - The median is over quantities of estimated and statistical grade that differ from the reference by more than 3σ.\n\n\
        `--index K` runs a single scene; `--keep FOLDER` writes the scenes with failures.\n\n{}\n\
        ![stated errors against differences]({file})\n\n\
        Each point is a quantity that differs from the reference by more than 3σ. The ordinate is its limit: 2 × stated error + 3σ for zones, stated error + 3σ\n\
        for sums by name. Both are relative to the quantity, and at most {MAX_PLOTTED_DIFFERENCE}. Points below the dashed line are not\n\
        covered.\n",
            tables(s)
        );
        Ok(zonal_io::output::write_bytes(path, text.as_bytes())?)
    }
}

fn draw(done: &[SceneResult]) -> Plot {
    let mut plot = Plot::new(
        "what covers a difference, against the difference",
        "difference from the reference, relative",
        "stated error and 3σ of the reference, relative",
        LOG_LOG,
    );
    plot.legend = LegendPlacement::LowerRight;
    for (k, (kind, name)) in
        [(QuantityKind::Zone, "zones"), (QuantityKind::Name, "sums by name")].into_iter().enumerate()
    {
        let all = done.iter().flat_map(|d| &d.quantities);
        let all = all.filter(|q| q.kind == kind && q.is_significant() && !q.is_unknown() && q.truth != 0.0);
        let point = |x: f64, q: &Quantity| (x / q.truth.abs()).min(MAX_PLOTTED_DIFFERENCE);
        let points: Vec<(f64, f64)> = all.map(|q| (point(q.difference(), q), point(q.limit(), q))).collect();
        let step = points.len().div_ceil(MAX_PLOTTED_POINTS).max(1);
        plot.add(name, SeriesMark::Dots, 1 - k, points.into_iter().step_by(step).collect());
    }
    plot.add(
        "equal",
        SeriesMark::Dashed,
        7,
        vec![(1e-4, 1e-4), (MAX_PLOTTED_DIFFERENCE, MAX_PLOTTED_DIFFERENCE)],
    );
    plot
}
