//! The page of a campaign: verdicts, tables and a plot.

use super::measure::{Quantity, QuantityKind};
use super::model::CampaignSize;
use super::run::{CampaignPlan, SceneResult};
use super::summary::{CampaignSummary, CoverageCounts};
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
pub(crate) fn tables(s: &CampaignSummary) -> String {
    const HEAD: &str = "| | scenes | sums by name covered | zones covered by twice their error | unknown | beyond ten times, silent / warned |\n|---|---:|---:|---:|---:|---:|\n";
    let mut t = String::from("| asked | found | |\n|---|---|---|\n");
    for (asked, found, holds) in s.verdicts() {
        let _ = writeln!(t, "| {asked} | {found} | {} |", if holds { "holds" } else { "FAILS" });
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

/// Writes the page, and the plot beside it.
pub(crate) fn write(
    path: &Path,
    plan: &CampaignPlan,
    done: &[SceneResult],
    s: &CampaignSummary,
) -> Result<(), String> {
    let plot = path.with_extension("svg");
    draw(done).write(&plot).map_err(|e| e.to_string())?;
    let file = plot.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let (n, seed, walks) = (plan.scenes.len(), plan.seed, plan.walks);
    let small = if plan.size == CampaignSize::Small { " --small yes" } else { "" };
    let text = format!(
        "# Coverage: stated errors beside true ones\n\n\
        Written by\n\n    cargo run --release -p zonal-validation --example coverage -- --random {n} --seed {seed} --walks {walks}{small} --page docs/coverage.md\n\n\
        {n} random scenes (boxes; rooms with solids, nested and touching; panes; plates; turned rooms; hollow shells; periodic ones; thin, thick and\n\
        varying media; every kind of light; thermal mode with every kind of condition; one to three bands), each solved by every engine that applies and\n\
        by {walks} walks of the reference a band. A sum by name (power absorbed, net power, temperature) is compared with the continuous problem: its\n\
        stated error is that of the exchange and of the size of the zones. What arrives at a zone, and its temperature, is compared with the exact\n\
        solution of the zonal equations on the same zones. *Covered*: |difference| ≤ stated + 3σ of the reference, of zones 2 stated + 3σ.\n\n\
        What is not plain in the tables:\n\n\
        - *Beyond ten times* is |difference| > 10 stated + 6σ. Where the exchange is exact the stated error of a zone is next to nothing, and of a hundred\n  \
        thousand means over random walks some hundred are more than 3σ off; beyond 6σ there should be none.\n\
        - A scene of which a sum by name is not covered, or a zone is beyond ten times, is walked once more, ten times as often, and judged by that.\n\
        - Zones that few walks meet, at which σ is more than 4 % of the value, are not compared: the spread of few walks does not tell their error.\n\
        - In a thin medium between two plates without end light goes farther than any of the walks; what they lack of it is part of σ (`reference/src/forward_monte_carlo/grazing_error.rs`).\n\
        - What the scene gives (a temperature, a net power) is not counted. Unknown errors count as not covered.\n\
        - The median is over quantities that are more than 3σ off the reference, of estimated and statistical grade.\n\n\
        A single scene is `--index K`; `--keep FOLDER` writes those on which something fails.\n\n{}\n\
        ![stated errors against differences]({file})\n\n\
        Each point is a quantity whose difference from the reference is more than 3σ, which is there in the limit too: of zones twice the stated error\n\
        and 3σ, of sums by name the stated error and 3σ. Both are relative to the quantity, and {MAX_PLOTTED_DIFFERENCE} at most. What lies below the dashed line is not\n\
        covered.\n",
        tables(s)
    );
    std::fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))
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
