//! Printed results: tables, or JSON.

use super::case::{AcceptanceLimit, CaseOutcome, CaseResult, QuantityCheck, ValidationCase, Verdict};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::Path;
use zonal_report::number;

/// Digits that show a difference as large as the limit, and one more.
fn digits(c: &QuantityCheck) -> usize {
    let size = match c.limit {
        AcceptanceLimit::Relative(most) => most,
        AcceptanceLimit::Absolute(most) => most / c.reference.abs().max(c.ours.abs()),
        _ => return 4,
    };
    (1.0 - size.log10().floor()).clamp(4.0, 15.0) as usize
}

/// Reference, ours, difference, limit, as text; a dash where there is none.
pub(crate) fn cells(c: &QuantityCheck) -> [String; 4] {
    let n = digits(c);
    let relative = |x: f64| format!("{} (relative)", number(x, 2));
    match c.limit {
        AcceptanceLimit::Absolute(most) => {
            [number(c.reference, n), number(c.ours, n), number(c.difference(), 2), number(most, 2)]
        }
        AcceptanceLimit::Relative(most) => {
            [number(c.reference, n), number(c.ours, n), relative(c.difference()), relative(most)]
        }
        AcceptanceLimit::AtMost(most) => {
            ["–".into(), number(c.ours, 3), "–".into(), format!("at most {}", number(most, 3))]
        }
        AcceptanceLimit::AtLeast(least) => {
            ["–".into(), number(c.ours, 3), "–".into(), format!("at least {}", number(least, 3))]
        }
        AcceptanceLimit::None if c.reference == 0.0 => {
            ["–".into(), number(c.ours, 3), "–".into(), "–".into()]
        }
        AcceptanceLimit::None => {
            [number(c.reference, 7), number(c.ours, 7), number(c.difference(), 2), "–".into()]
        }
    }
}

/// How the case ended, in a few words.
pub(crate) fn summary(o: &CaseOutcome) -> String {
    let (held, failed) = (o.count(Verdict::Pass), o.count(Verdict::Fail));
    match (&o.skipped, held, failed) {
        (Some(_), ..) => "skipped".into(),
        (None, 0, 0) => "informational".into(),
        (None, held, 0) => format!("{held}/{held} pass"),
        (None, held, failed) => format!("{failed}/{} FAIL", held + failed),
    }
}

/// The rows of a case.
pub(crate) fn table(d: &CaseResult) -> String {
    let mut out = format!("{}: {}  [{}; {:.1} s]", d.case.name, d.case.title, summary(&d.outcome), d.seconds);
    if let Some(why) = &d.outcome.skipped {
        let _ = write!(out, "\n  skipped: {why}");
    }
    let rows: Vec<[String; 6]> = (d.outcome.checks.iter())
        .map(|c| {
            let [reference, ours, difference, limit] = cells(c);
            [c.quantity.clone(), reference, ours, difference, limit, c.verdict().word().into()]
        })
        .collect();
    let head = ["quantity", "reference", "ours", "difference", "limit", "verdict"].map(String::from);
    let width = |k: usize| rows.iter().chain([&head]).map(|r| r[k].chars().count()).max().unwrap_or(0);
    let widths = [0, 1, 2, 3, 4, 5].map(width);
    for row in [&head].into_iter().chain(&rows).take(if rows.is_empty() { 0 } else { usize::MAX }) {
        let _ = write!(out, "\n  {:<w$}", row[0], w = widths[0]);
        for (cell, w) in row.iter().zip(widths).skip(1) {
            let _ = write!(out, "  {cell:>w$}");
        }
    }
    for s in &d.outcome.sequences {
        let _ = match &s.limit {
            Ok(e) => write!(
                out,
                "\n  {}: extrapolated {} ± {} (order {:.2})",
                s.name,
                number(e.value, 9),
                number(e.uncertainty, 2),
                e.order()
            ),
            Err(why) => write!(out, "\n  {}: not extrapolated, {why}", s.name),
        };
    }
    d.outcome.notes.iter().for_each(|n| {
        let _ = write!(out, "\n  note: {n}");
    });
    out
}

/// Verdicts that hold and fail, and cases that were skipped.
pub(crate) fn counts(done: &[CaseResult]) -> [usize; 3] {
    let sum = |v: Verdict| done.iter().map(|d| d.outcome.count(v)).sum();
    [sum(Verdict::Pass), sum(Verdict::Fail), done.iter().filter(|d| d.outcome.skipped.is_some()).count()]
}

/// The last lines.
pub(crate) fn end(done: &[CaseResult], page: Option<&Path>) -> String {
    let [held, failed, skipped] = counts(done);
    let seconds: f64 = done.iter().map(|d| d.seconds).sum();
    let mut out = format!(
        "{held}/{} verdicts pass; {} cases in {seconds:.0} s, {skipped} of them skipped",
        held + failed,
        done.len()
    );
    if let Some(page) = page {
        let _ = write!(out, "\nwritten: {}", page.display());
    }
    out
}

/// How the list of cases is printed.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum ListFormat {
    Text,
    Json,
}

/// The cases, without running them.
pub(crate) fn list(cases: &[&ValidationCase], format: ListFormat) -> String {
    if format == ListFormat::Json {
        let all: Vec<Value> = (cases.iter())
            .map(|c| json!({"name": c.name, "group": c.group, "title": c.title, "quick": c.quick, "needs": c.needs}))
            .collect();
        return format!("{:#}", json!({ "cases": all }));
    }
    let width = cases.iter().map(|c| c.name.len()).max().unwrap_or(0);
    let line = |c: &&ValidationCase| {
        let quick = if c.quick { "quick" } else { "" };
        let needs = c.needs.map_or(String::new(), |n| format!("  (needs {n})"));
        format!("{:<width$}  {quick:<5}  {}: {}{needs}", c.name, c.group, c.title)
    };
    cases.iter().map(line).collect::<Vec<_>>().join("\n")
}

fn limit(l: AcceptanceLimit) -> Value {
    match l {
        AcceptanceLimit::Absolute(x) => json!({"kind": "absolute", "value": x}),
        AcceptanceLimit::Relative(x) => json!({"kind": "relative", "value": x}),
        AcceptanceLimit::AtMost(x) => json!({"kind": "at most", "value": x}),
        AcceptanceLimit::AtLeast(x) => json!({"kind": "at least", "value": x}),
        AcceptanceLimit::None => Value::Null,
    }
}

/// Everything as JSON.
pub(crate) fn json(done: &[CaseResult], page: Option<&Path>) -> String {
    let word = |v: Verdict| match v {
        Verdict::Pass => "pass",
        Verdict::Fail => "fail",
        Verdict::Informational => "informational",
    };
    let row = |c: &QuantityCheck| {
        json!({"quantity": c.quantity, "reference": c.reference, "ours": c.ours, "difference": c.difference(),
               "limit": limit(c.limit), "verdict": word(c.verdict())})
    };
    let one = |d: &CaseResult| {
        let sequences: Vec<Value> = (d.outcome.sequences.iter())
            .map(|s| {
                let e = s.limit.as_ref();
                json!({"name": s.name, "steps": s.steps, "reference": s.reference.map(|r| r.0), "bracket": s.reference.map(|r| r.1),
                       "extrapolated": e.ok().map(|e| e.value), "uncertainty": e.ok().map(|e| e.uncertainty),
                       "orders": e.ok().map(|e| e.orders.clone()), "why_not": e.err()})
            })
            .collect();
        json!({"name": d.case.name, "group": d.case.group, "title": d.case.title, "seconds": d.seconds,
               "verdict": d.outcome.word().to_lowercase(), "skipped": d.outcome.skipped,
               "checks": d.outcome.checks.iter().map(row).collect::<Vec<_>>(), "sequences": sequences, "notes": d.outcome.notes})
    };
    let [held, failed, skipped] = counts(done);
    format!(
        "{:#}",
        json!({"cases": done.iter().map(one).collect::<Vec<_>>(), "held": held, "failed": failed, "skipped": skipped,
               "seconds": done.iter().map(|d| d.seconds).sum::<f64>(), "page": page.map(|p| p.display().to_string())})
    )
}
