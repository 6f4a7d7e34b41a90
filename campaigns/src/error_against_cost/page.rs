//! The page `error-against-cost.md` with its plots.

use super::points::{self, Point, PointStatus};
use super::verdicts::Verdict;
use crate::harness::{Error, or_dash, percent};
use std::fmt::Write as _;
use std::path::Path;
use zonal_io::output;
use zonal_report::markdown;
use zonal_report::plot::{LOG_LOG, Plot, SeriesMark, tick_label};

const INTRODUCTION: &str = "# Error against cost

Each scene is solved with each engine from coarse to fine tolerances. *L2* is the relative error of indirect light (H of patches, G of volumes; the worse
of both, of the worst band) against the equations that the engine solves, on the same zones, with the noise of the reference subtracted. A star marks points whose noise is
more than a third of the error. *Total* is the error against path-traced means, the discretization error included. Times are processor seconds of the whole
solve, reading and writing included. The table is [error-against-cost.csv](error-against-cost.csv).

References are random walks that go on from a uniformly random point of each zone (`zonal_reference::path_tracer`), whose mean is the solution of the zonal
equations, or several independent solves of the dense engine at a small tolerance. Rays of the rays engine go on from the points where they hit patches
close by, which resolves light and shadow within these patches; its references are walks that do the same (`continued`). Shares of patches at contacts
rest on the few of them among the zones of a reference.

";

const REPRODUCTION: &str = "## Reproduction

```text
cargo build --release -p zonal-cli -p zonal-campaigns
target/release/campaigns error-against-cost references --references REFERENCES
target/release/campaigns error-against-cost references --references REFERENCES --method continued --error 0.007 --max-paths 2000000
target/release/campaigns error-against-cost references --references REFERENCES --method dense --scenes chapel,furnished-room
target/release/campaigns error-against-cost measure --references REFERENCES --csv docs/error-against-cost.csv --limit 600
target/release/campaigns error-against-cost page --csv docs/error-against-cost.csv --page docs/error-against-cost.md
target/release/campaigns error-against-cost compare --csv docs/error-against-cost.csv --compare OLDER.csv
```

`--zonal PATH` measures another binary, `--quick` takes three tolerances, and
`--scenes`, `--engines` and `--tolerances` choose. `scenes DIR` writes the scene files.
";

/// Columns of the table.
const COLUMNS: &str =
    "scene,engine,tolerance,L2,total,estimate,stated/true,within twice,at contacts,relit,seconds,MB,used";

/// The row of a point.
pub(super) fn row(p: &Point) -> Vec<String> {
    let share = |x: Option<f64>| or_dash(x, |x| format!("{:.0} %", 100.0 * x));
    let (m, e) = (&p.measured, p.error());
    let mut cells = vec![p.scene.clone(), p.engine.clone(), p.tolerance.to_string()];
    if p.status != PointStatus::Measured {
        cells.push(if p.status == PointStatus::Limit { "at the limit" } else { "refused" }.into());
        cells.resize(COLUMNS.split(',').count(), "–".into());
        return cells;
    }
    cells.push(percent(e.error) + if e.is_noisy() { " *" } else { "" });
    cells.push(or_dash(m.total.map(|t| t.error), percent));
    cells.push(percent(p.estimate[0].max(p.estimate[1])));
    cells.push(or_dash(m.ratio, |r| format!("{r:.2}")));
    cells.extend([share(m.within), share(m.within_at_contacts), share(m.within_relit)]);
    cells.extend([format!("{:.2}", p.cost.processor), format!("{:.0}", p.cost.memory), p.used.clone()]);
    cells
}

/// Draws error against processor time of a scene: a line for each engine with dots at its tolerances, dashed the total error, and dots at
/// the tolerances themselves.
fn plot(all: &[Point], scene: &str) -> Plot {
    let mut p = Plot::new(
        &format!("{scene}: error against cost (dots: tolerance; dashed: with the discretization error)"),
        "processor time, s",
        "L2 error, %",
        LOG_LOG,
    );
    for (k, engine) in points::names(all, |p| &p.engine).iter().enumerate() {
        let series = points::series(all, scene, engine);
        if series.is_empty() {
            continue;
        }
        let line = |of: &dyn Fn(&Point) -> Option<f64>| -> Vec<(f64, f64)> {
            let dots = series.iter().filter_map(|p| Some((p.cost.processor, 100.0 * of(p)?)));
            dots.filter(|d| d.0 > 0.0 && d.1 > 0.0).collect()
        };
        let label = format!("{engine}, from {}", tick_label(series[0].tolerance, LOG_LOG[0]));
        p.add(&label, SeriesMark::LineWithPoints, k, line(&|p| Some(p.error().error)));
        p.add("", SeriesMark::Dots, k + 4, line(&|p| Some(p.tolerance)));
        p.add("", SeriesMark::Dashed, k, line(&|p| Some(p.measured.total?.error)));
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
