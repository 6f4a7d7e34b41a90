//! Notes of a report for the page, with advice by cause.
//!
//! A solution that a better one follows has notes on its accuracy that no user can act on: the page shows one line in their place. Other notes whose
//! message does not say what to do have an advice for the reader of the page.

use serde_json::{Value, json};
use zonal_scene::{Diagnostic, Report, Severity};

/// The place of a solution in the series that a live page shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShownStage {
    /// Emission and the suns that the page draws; direct light follows.
    Sunlight,
    /// Direct light alone; a draft follows.
    DirectLight,
    /// A draft that a better solution follows.
    Draft,
    /// The solution of a file.
    #[default]
    Only,
    /// The last of a series, of this quality.
    Last(&'static str),
}

impl ShownStage {
    /// The name in progress and header.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            ShownStage::Sunlight => "sunlight",
            ShownStage::DirectLight => "direct light",
            ShownStage::Draft => "draft",
            ShownStage::Only => "solution",
            ShownStage::Last(quality) => quality,
        }
    }

    /// True where no better solution follows.
    #[must_use]
    pub fn is_last(self) -> bool {
        matches!(self, ShownStage::Only | ShownStage::Last(_))
    }
}

/// Codes of notes whose cause the solution that follows removes.
const CAUSES_OF_DRAFTS: [&str; 7] = [
    "tolerance",
    "light-power",
    "energy-balance",
    "not-converged",
    "memory",
    "discretization",
    "rough-discretization",
];

/// Advice on notes of a code, where the message has none.
const ADVICE: [(&str, &str); 5] = [
    (
        "open-scene",
        "this is right for windows and open tops; elsewhere look for gaps, through which the background shows",
    ),
    ("sky-noise", "this concerns zonal render alone: the page has no such noise"),
    ("relit", "solve again with these lights for errors of the same kind as before"),
    ("cells-outside", "this is right where the grid of the medium is larger than the room"),
    ("default-material", "name the material in the model, or give the surface its reflectance in the scene"),
];

/// The notes of a report: a list of `{ "severity", "text", "advice" }`, the advice null where the text suffices.
#[must_use]
pub fn notes(report: &Report, stage: ShownStage) -> Vec<Value> {
    let is_shown = |d: &&Diagnostic| stage.is_last() || !CAUSES_OF_DRAFTS.contains(&d.code.as_str());
    let shown: Vec<&Diagnostic> = report.warnings.iter().filter(is_shown).collect();
    let entry = |severity: Severity, text: String, advice: Option<&str>| json!({ "severity": severity.name(), "text": text, "advice": advice });
    let advice_on = |d: &Diagnostic| ADVICE.iter().find(|a| a.0 == d.code).map(|a| a.1);
    let mut out: Vec<Value> = shown.iter().map(|d| entry(d.severity, d.to_string(), advice_on(d))).collect();
    let left_out = report.warnings.len() - shown.len();
    if left_out > 0 {
        let text = format!("{left_out} note(s) on the accuracy of this solution are left out");
        out.push(entry(
            Severity::Note,
            text,
            Some("nothing is to be done: a better solution is being computed"),
        ));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report() -> Report {
        let warnings = vec![
            Diagnostic::warning(
                "tolerance",
                "the estimated error misses the tolerance: use a smaller tolerance",
            ),
            Diagnostic::note("open-scene", "the scene is open"),
            Diagnostic::note("symmetry-planes", "symmetry planes at x0").at("scene"),
        ];
        Report { warnings, ..Report::default() }
    }

    #[test]
    fn drafts_have_no_advice_on_their_tolerance() {
        for stage in [ShownStage::DirectLight, ShownStage::Draft] {
            let list = notes(&report(), stage);
            assert_eq!(list.len(), 3);
            assert!(list.iter().all(|n| !n["text"].as_str().unwrap().contains("tolerance")), "{list:?}");
            assert!(list[2]["advice"].as_str().unwrap().contains("better solution"), "{list:?}");
        }
        assert!(notes(&Report::default(), ShownStage::Draft).is_empty());
    }

    #[test]
    fn last_solutions_have_all_notes_with_advice_by_cause() {
        for stage in [ShownStage::Only, ShownStage::Last("normal")] {
            let list = notes(&report(), stage);
            let column = |key: &str| list.iter().map(|n| n[key].clone()).collect::<Vec<_>>();
            assert_eq!(column("severity"), ["warning", "note", "note"]);
            assert_eq!(list[2]["text"], "scene: symmetry planes at x0");
            let advice = column("advice");
            assert!(
                advice[0].is_null() && advice[2].is_null(),
                "the text says what to do, or there is nothing"
            );
            assert!(advice[1].as_str().unwrap().contains("windows"), "{advice:?}");
        }
    }
}
