//! The page `validation.md` with its plots.

use super::case::{CaseResult, ProfilePlot, Verdict};
use super::richardson::ResolutionSequence;
use super::tables::{cells, counts, summary};
use std::path::{Path, PathBuf};
use zonal_io::output;
use zonal_report::Failure;
use zonal_report::plot::{LINEAR, LOG_LOG, LegendPlacement, Plot, SeriesMark};
use zonal_report::{PageFolder, markdown, number};

/// Largest number of rows that the page shows unfolded.
const MAX_UNFOLDED_ROWS: usize = 14;
/// Largest number of curves in a plot of convergence.
const MAX_CURVES: usize = 6;
/// Smallest level drawn, relative to the lowest point of all curves.
const MIN_LEVEL_OVER_CURVE: f64 = 0.2;

/// Writes the page and its plots; its path.
pub(crate) fn write(folder: &Path, plots: &PageFolder, done: &[CaseResult]) -> Result<PathBuf, Failure> {
    let mut page = include_str!("head.md").to_string();
    page += &overview(done);
    let mut group = "";
    for d in done {
        if d.case.group != group {
            group = d.case.group;
            page += &format!("## {group}\n\n");
        }
        page += &case_section(d, plots)?;
    }
    let path = folder.join("validation.md");
    output::write_bytes(&path, page.as_bytes())?;
    Ok(path)
}

/// The largest share of a limit that a case uses.
fn largest_share(d: &CaseResult) -> String {
    let worst = d
        .outcome
        .checks
        .iter()
        .filter_map(|c| c.share())
        .fold(None, |m: Option<f64>, s| Some(m.map_or(s, |m| m.max(s))));
    worst.map_or("–".into(), |s| {
        if s < 1e-3 { "< 0.1 %".into() } else { format!("{} %", number(100.0 * s, 2)) }
    })
}

fn overview(done: &[CaseResult]) -> String {
    let [held, failed, skipped] = counts(done);
    let seconds: f64 = done.iter().map(|d| d.seconds).sum();
    let cases = done.len();
    let mut out = format!(
        "**{held}/{} verdicts pass**, {failed} fail; {cases} cases, {skipped} skipped; {seconds:.0} s on {} threads, version {}.\n\n",
        held + failed,
        rayon::current_num_threads(),
        env!("CARGO_PKG_VERSION")
    );
    let rows: Vec<Vec<String>> = (done.iter())
        .map(|d| {
            let name = format!("[{0}](#{0})", d.case.name);
            vec![
                name,
                d.case.title.into(),
                summary(&d.outcome),
                largest_share(d),
                format!("{:.1}", d.seconds),
            ]
        })
        .collect();
    out += &failures(done);
    out += &markdown(&["case", "title", "verdicts", "largest share of a limit used", "s"], &rows);
    out.push('\n');
    out
}

/// The rows that fail, all in one place.
fn failures(done: &[CaseResult]) -> String {
    let mut rows = Vec::new();
    for d in done {
        for c in d.outcome.checks.iter().filter(|c| c.verdict() == Verdict::Fail) {
            let [reference, ours, difference, limit] = cells(c);
            rows.push(vec![
                format!("[{0}](#{0})", d.case.name),
                c.quantity.clone(),
                reference,
                ours,
                difference,
                limit,
            ]);
        }
    }
    if rows.is_empty() {
        return String::new();
    }
    let head = ["failing case", "quantity", "reference", "ours", "difference", "limit"];
    format!("{}\nThe cases give the reasons.\n\n", markdown(&head, &rows))
}

fn case_section(d: &CaseResult, plots: &PageFolder) -> Result<String, Failure> {
    let name = d.case.name;
    let mut out =
        format!("### {name}\n\n**{}**: {}. {}\n\n", d.case.title, summary(&d.outcome), d.case.about);
    if let Some(why) = &d.outcome.skipped {
        return Ok(out + &format!("Skipped: {why}.\n\n"));
    }
    for p in &d.outcome.profiles {
        profile(p, plots)?;
        out += &format!("![{}](validation/{}.svg)\n\n", p.title, p.file);
    }
    if !d.outcome.sequences.is_empty() {
        convergence(d, plots)?;
        out += &format!("![convergence of {name}](validation/{name}.svg)\n\n");
        out += &extrapolations(&d.outcome.sequences);
    }
    for p in &d.outcome.pictures {
        out += &format!("![{0}](validation/{1})\n\n{0}\n\n", p.caption, p.file);
    }
    let rows: Vec<Vec<String>> = (d.outcome.checks.iter())
        .map(|c| {
            let [reference, ours, difference, limit] = cells(c);
            vec![c.quantity.clone(), reference, ours, difference, limit, c.verdict().word().into()]
        })
        .collect();
    let table = markdown(&["quantity", "reference", "ours", "difference", "limit", "verdict"], &rows);
    out += &if rows.len() > MAX_UNFOLDED_ROWS {
        format!("<details><summary>{} rows</summary>\n\n{table}\n</details>\n\n", rows.len())
    } else {
        format!("{table}\n")
    };
    d.outcome.notes.iter().for_each(|n| out += &format!("{n}\n\n"));
    Ok(out)
}

fn extrapolations(all: &[ResolutionSequence]) -> String {
    let rows: Vec<Vec<String>> = (all.iter())
        .map(|s| {
            let last = s.steps.last().map_or((f64::NAN, f64::NAN), |l| *l);
            let reference = s.reference.map_or("–".into(), |(value, bracket)| match bracket {
                b if value == 0.0 => format!("standard error {}", number(b, 2)),
                0.0 => number(value, 7),
                b => format!("{} ± {}", number(value, 7), number(b, 1)),
            });
            let (value, order) = match &s.limit {
                Ok(e) => {
                    let orders: Vec<String> = e.orders.iter().map(|p| format!("{p:.2}")).collect();
                    (format!("{} ± {}", number(e.value, 7), number(e.uncertainty, 1)), orders.join(", "))
                }
                Err(why) => (format!("none: {why}"), "–".into()),
            };
            vec![s.name.clone(), format!("{} at {}", number(last.1, 7), last.0), order, value, reference]
        })
        .collect();
    markdown(&["sequence", "finest", "observed orders", "extrapolated", "reference"], &rows) + "\n"
}

/// A curve of convergence: distances, and the level of the dashed line.
struct ConvergenceCurve {
    points: Vec<(f64, f64)>,
    level: f64,
}

impl ConvergenceCurve {
    /// From the extrapolated value, with the reference's own distance from it as level; without one from the reference, with its uncertainty.
    fn new(s: &ResolutionSequence) -> ConvergenceCurve {
        let (reference, bracket) = s.reference.unwrap_or((f64::NAN, f64::NAN));
        let (to, level) = match &s.limit {
            Ok(e) => (e.value, (reference - e.value).abs()),
            Err(_) => (reference, bracket),
        };
        let size = if to == 0.0 { 1.0 } else { to.abs() };
        ConvergenceCurve {
            points: s.steps.iter().map(|&(n, v)| (n, (v - to).abs() / size)).collect(),
            level: level / size,
        }
    }
}

/// Distance from the limit against resolution.
fn convergence(d: &CaseResult, plots: &PageFolder) -> Result<(), Failure> {
    let all = &d.outcome.sequences;
    let errors = all.iter().all(|s| s.reference.is_some_and(|r| r.0 == 0.0));
    let what = if errors {
        all[0].name.split_once(", ").map_or("error", |n| n.1)
    } else {
        "relative distance from the extrapolated value"
    };
    let mut plot =
        Plot::new(&format!("{}: {}", d.case.name, d.case.title), "zones along an edge", what, LOG_LOG);
    plot.legend = LegendPlacement::Beside;
    let step = all.len().div_ceil(MAX_CURVES);
    let curves: Vec<(&ResolutionSequence, ConvergenceCurve)> =
        all.iter().step_by(step).map(|s| (s, ConvergenceCurve::new(s))).collect();
    let points = || curves.iter().flat_map(|c| c.1.points.iter()).filter(|p| p.1 > 0.0);
    let least = points().fold(f64::INFINITY, |m, p| m.min(p.1));
    let (first, last) = points().fold((f64::INFINITY, 0.0f64), |(a, b), p| (a.min(p.0), b.max(p.0)));
    let top = points().fold(0.0f64, |m, p| m.max(p.1));
    for (k, (s, c)) in curves.iter().enumerate() {
        plot.add(
            s.name.split_once(": ").map_or(&s.name, |n| if all.len() > 3 { n.0 } else { &s.name }),
            SeriesMark::LineWithPoints,
            k,
            c.points.clone(),
        );
        if c.level > MIN_LEVEL_OVER_CURVE * least {
            let ends = [c.points.first(), c.points.last()];
            plot.add("", SeriesMark::Dashed, k, ends.into_iter().flatten().map(|p| (p.0, c.level)).collect());
        }
    }
    // Orders, above all curves.
    for (order, name) in [(1, "orders 1 and 2, dashed"), (2, "")] {
        let guide = |n: f64| 1.5 * top * (first / n).powi(order);
        plot.add(name, SeriesMark::Dashed, 7, vec![(first, guide(first)), (last, guide(last))]);
    }
    plots.plot(&format!("{}.svg", d.case.name), &plot)
}

/// Ours as a line, the reference as spots.
fn profile(p: &ProfilePlot, plots: &PageFolder) -> Result<(), Failure> {
    let mut plot = Plot::new(&p.title, &p.x, &p.y, LINEAR);
    for (k, (name, points)) in p.ours.iter().enumerate() {
        plot.add(name, SeriesMark::Line, k, points.clone());
    }
    for (k, (name, points)) in p.reference.iter().enumerate() {
        plot.add(name, SeriesMark::Dots, p.ours.len() + k, points.clone());
    }
    plots.plot(&format!("{}.svg", p.file), &plot)
}
