//! The page `error-against-cost.md` with its plots.

use super::halves::TotalError;
use super::measure::KindErrors;
use super::points::{self, Point, PointStatus};
use super::verdicts::Verdict;
use crate::harness::{Error, or_dash, percent};
use std::fmt::Write as _;
use std::path::Path;
use zonal_io::output;
use zonal_report::markdown;
use zonal_report::plot::{LOG_LOG, Plot, SeriesMark, tick_label};

const INTRODUCTION: &str = "# Error against cost

Each scene is solved with each engine from coarse to fine tolerances. *H* and *G* are the relative L2 errors of indirect light on patches and on volumes, of the
worst band: the total error, of sampling, direct light and zoning together, against path-traced means over zones at random. *By area* and *by volume* count
zones by their size, the others count each zone alike. *Bound* is the upper bound of the worst of the four, at two standard errors; a star marks points whose
bound is more than 1.5 times the error. *Stated* is the error that the solver states. Times are processor seconds of the whole solve, reading and writing
included. The table is [error-against-cost.csv](error-against-cost.csv).

References are means over zones and surfaces by path tracing without zones ([the path tracer](path-tracer.md)), in two independent halves a and b for each
light group. The square of the error of a value v is the mean of (v − a)(v − b), in which the noise of the halves drops out. *Within twice* is the share of
zones that lie within twice their stated error, *names* the share of powers absorbed by a surface within their stated error, *relit* the smallest shares of zones
and of powers within twice their stated error after a light group was scaled by 0 or 10; the noise of the reference is allowed for.

";

const REPRODUCTION: &str = "## Reproduction

```text
cargo build --release -p zonal-cli -p zonal-campaigns
target/release/campaigns error-against-cost references --references REFERENCES
target/release/campaigns error-against-cost measure --references REFERENCES --csv docs/error-against-cost.csv --limit 600
target/release/campaigns error-against-cost page --csv docs/error-against-cost.csv --page docs/error-against-cost.md
target/release/campaigns error-against-cost compare --csv docs/error-against-cost.csv --compare OLDER.csv
```

`--zonal PATH` measures another binary, `--quick` takes three tolerances, and
`--scenes`, `--engines` and `--tolerances` choose. `scenes DIR` writes the scene files.
";

/// Columns of the table.
const COLUMNS: &str = "scene,engine,tolerance,H,H by area,G,G by volume,bound,stated,stated/true,within twice,names,relit,seconds,MB,used";

/// The row of a point.
pub(super) fn row(p: &Point) -> Vec<String> {
    let share = |x: Option<f64>| or_dash(x, |x| format!("{:.0} %", 100.0 * x));
    let (m, total) = (&p.measured, p.total());
    let mut cells = vec![p.scene.clone(), p.engine.clone(), p.tolerance.to_string()];
    if p.status != PointStatus::Measured {
        cells.push(if p.status == PointStatus::Limit { "at the limit" } else { "refused" }.into());
        cells.resize(COLUMNS.split(',').count(), "–".into());
        return cells;
    }
    // Without zones of a kind there is no error of it.
    let error = |e: TotalError| if e == TotalError::default() { "–".into() } else { percent(e.error) };
    cells.extend([m.patches.by_count, m.patches.by_size, m.volumes.by_count, m.volumes.by_size].map(error));
    cells.push(percent(total.upper) + if total.is_noisy() { " *" } else { "" });
    cells.push(percent(p.estimate[0].max(p.estimate[1])));
    cells.push(or_dash(m.ratio, |r| format!("{r:.2}")));
    cells.extend([share(m.within), share(m.names_within)]);
    cells.push(or_dash(m.within_relit, |_| {
        format!("{}, {}", share(m.within_relit), share(m.names_within_relit))
    }));
    cells.extend([format!("{:.2}", p.cost.processor), format!("{:.0}", p.cost.memory), p.used.clone()]);
    cells
}

/// The error of the worse kind of zones by one weighting.
fn worse_kind(p: &Point, weighting: fn(&KindErrors) -> TotalError) -> f64 {
    weighting(&p.measured.patches).max(weighting(&p.measured.volumes)).error
}

/// Draws the total error of the worse kind of zones against the processor time of a scene: a line for each engine, zones counted alike, dashed by size, and
/// dots at the tolerances.
fn plot(all: &[Point], scene: &str) -> Plot {
    let mut p = Plot::new(
        &format!("{scene}: total error against cost (dots: tolerance; dashed: by area or volume)"),
        "processor time, s",
        "total L2 error, %",
        LOG_LOG,
    );
    for (k, engine) in points::names(all, |p| &p.engine).iter().enumerate() {
        let series = points::series(all, scene, engine);
        if series.is_empty() {
            continue;
        }
        let line = |of: fn(&Point) -> f64| -> Vec<(f64, f64)> {
            let dots = series.iter().map(|p| (p.cost.processor, 100.0 * of(p)));
            dots.filter(|d| d.0 > 0.0 && d.1 > 0.0).collect()
        };
        let label = format!("{engine}, from {}", tick_label(series[0].tolerance, LOG_LOG[0]));
        p.add(&label, SeriesMark::LineWithPoints, k, line(|p| worse_kind(p, |e| e.by_count)));
        p.add("", SeriesMark::Dots, k + 4, line(|p| p.tolerance));
        p.add("", SeriesMark::Dashed, k, line(|p| worse_kind(p, |e| e.by_size)));
    }
    p
}

/// Writes the page and a plot for each scene beside it.
pub(crate) fn write(page: &Path, all: &[Point], verdicts: &[Verdict]) -> Result<(), Error> {
    let mut t = String::from(INTRODUCTION);
    let rows: Vec<Vec<String>> =
        verdicts.iter().map(|v| vec![v.requirement.into(), v.met.to_string(), v.all.to_string()]).collect();
    t += &markdown(&["requirement", "met", "of"], &rows);
    t += "\n## Scenes\n\n";
    for scene in points::names(all, |p| &p.scene) {
        let file = format!("error-against-cost-{scene}.svg");
        plot(all, &scene).write(&page.with_file_name(&file)).map_err(|e| e.to_string())?;
        let _ = writeln!(t, "![{scene}]({file})\n");
    }
    t += "## Points\n\n";
    t += &markdown(&COLUMNS.split(',').collect::<Vec<_>>(), &all.iter().map(row).collect::<Vec<_>>());
    t += "\n";
    t += REPRODUCTION;
    Ok(output::write_bytes(page, t.as_bytes())?)
}
