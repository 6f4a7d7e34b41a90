//! Validation cases and their results: quantities with references and acceptance limits stated in advance.

use super::case_context::CaseContext;
use super::richardson::ResolutionSequence;
use zonal_report::Failure;

/// A case of the suite.
pub(crate) struct ValidationCase {
    /// Its name on the command line.
    pub name: &'static str,
    /// The group that it stands under on the page.
    pub group: &'static str,
    /// Title, one line.
    pub title: &'static str,
    /// Description of the method and the reasons for the limits: a paragraph of the page, in Markdown.
    pub about: &'static str,
    /// True where it takes a second or two at most.
    pub quick: bool,
    /// A file or folder below the reference folder, without which the case is skipped.
    pub needs: Option<&'static str>,
    /// Computes it.
    pub run: fn(&CaseContext) -> Result<CaseOutcome, Failure>,
}

/// Largest acceptable difference from the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum AcceptanceLimit {
    /// |ours − reference|, in the unit of the quantity.
    Absolute(f64),
    /// |ours − reference| relative to |reference|.
    Relative(f64),
    /// The quantity is an error itself: its modulus.
    AtMost(f64),
    /// The quantity must reach this value.
    AtLeast(f64),
    /// None: the row is informational.
    None,
}

/// Verdict of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// Within its limit.
    Pass,
    /// Not within its limit, or not a number.
    Fail,
    /// Without a limit.
    Informational,
}

impl Verdict {
    /// The word of tables.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Verdict::Pass => "pass",
            Verdict::Fail => "FAIL",
            Verdict::Informational => "–",
        }
    }
}

/// A quantity beside its reference.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct QuantityCheck {
    /// Name of the quantity, with its unit.
    pub quantity: String,
    /// The reference; 0 where the quantity is an error itself.
    pub reference: f64,
    /// The program's value.
    pub ours: f64,
    /// The limit.
    pub limit: AcceptanceLimit,
}

impl QuantityCheck {
    /// The difference that the limit is for: relative where the limit is.
    pub(crate) fn difference(&self) -> f64 {
        match self.limit {
            AcceptanceLimit::Relative(_) => (self.ours - self.reference) / self.reference.abs(),
            _ => self.ours - self.reference,
        }
    }

    /// The verdict; NaN fails.
    pub(crate) fn verdict(&self) -> Verdict {
        let holds = match self.limit {
            AcceptanceLimit::Absolute(most)
            | AcceptanceLimit::Relative(most)
            | AcceptanceLimit::AtMost(most) => self.difference().abs() <= most,
            AcceptanceLimit::AtLeast(least) => self.ours >= least,
            AcceptanceLimit::None => return Verdict::Informational,
        };
        if holds { Verdict::Pass } else { Verdict::Fail }
    }

    /// The difference as a fraction of the limit; infinite for NaN. `None` without a limit.
    pub(crate) fn share(&self) -> Option<f64> {
        let share = match self.limit {
            AcceptanceLimit::Absolute(_) | AcceptanceLimit::Relative(_) | AcceptanceLimit::AtMost(_)
                if self.difference() == 0.0 =>
            {
                0.0
            }
            AcceptanceLimit::Absolute(most)
            | AcceptanceLimit::Relative(most)
            | AcceptanceLimit::AtMost(most) => self.difference().abs() / most,
            AcceptanceLimit::AtLeast(least) => least / self.ours.max(0.0),
            AcceptanceLimit::None => return None,
        };
        Some(if share.is_nan() { f64::INFINITY } else { share })
    }
}

/// A picture of a case for the page.
#[derive(Clone, Debug)]
pub(crate) struct CasePicture {
    /// PNG file, in the folder of plots.
    pub file: String,
    /// A line below it.
    pub caption: String,
}

/// Curves beside the points of a reference.
#[derive(Clone, Debug, Default)]
pub(crate) struct ProfilePlot {
    /// The plot's file without its ending.
    pub file: String,
    /// Title of the plot.
    pub title: String,
    /// Quantity along the horizontal axis, with its unit.
    pub x: String,
    /// Quantity along the vertical axis, with its unit.
    pub y: String,
    /// Our curves, by name.
    pub ours: Vec<(String, Vec<(f64, f64)>)>,
    /// The reference's points, by name.
    pub reference: Vec<(String, Vec<(f64, f64)>)>,
}

/// The outcome of a case.
#[derive(Clone, Debug, Default)]
pub(crate) struct CaseOutcome {
    /// The rows.
    pub checks: Vec<QuantityCheck>,
    /// Values at growing resolution.
    pub sequences: Vec<ResolutionSequence>,
    /// Curves for the page.
    pub profiles: Vec<ProfilePlot>,
    /// Why it was not computed; such a case counts neither as passed nor as failed.
    pub skipped: Option<String>,
    /// Sentences for the page.
    pub notes: Vec<String>,
    /// Pictures for the page.
    pub pictures: Vec<CasePicture>,
}

impl CaseOutcome {
    /// Of a case that cannot be computed here.
    pub(crate) fn skipped(why: impl Into<String>) -> CaseOutcome {
        CaseOutcome { skipped: Some(why.into()), ..CaseOutcome::default() }
    }

    /// Adds a row.
    pub(crate) fn check(
        &mut self,
        quantity: impl Into<String>,
        reference: f64,
        ours: f64,
        limit: AcceptanceLimit,
    ) {
        self.checks.push(QuantityCheck { quantity: quantity.into(), reference, ours, limit });
    }

    /// Adds a row of a quantity that is an error itself.
    pub(crate) fn error(&mut self, quantity: impl Into<String>, ours: f64, most: f64) {
        self.check(quantity, 0.0, ours, AcceptanceLimit::AtMost(most));
    }

    /// Adds a row without a verdict.
    pub(crate) fn informational(&mut self, quantity: impl Into<String>, reference: f64, ours: f64) {
        self.check(quantity, reference, ours, AcceptanceLimit::None);
    }

    /// Adds a sentence for the page.
    pub(crate) fn note(&mut self, text: impl Into<String>) {
        self.notes.push(text.into());
    }

    /// Number of rows with a verdict.
    pub(crate) fn count(&self, verdict: Verdict) -> usize {
        self.checks.iter().filter(|c| c.verdict() == verdict).count()
    }

    /// The word for the whole case.
    pub(crate) fn word(&self) -> &'static str {
        match (&self.skipped, self.count(Verdict::Fail), self.count(Verdict::Pass)) {
            (Some(_), ..) => "skipped",
            (None, 0, 0) => "informational",
            (None, 0, _) => "pass",
            _ => "FAIL",
        }
    }
}

/// A case that has run.
pub(crate) struct CaseResult {
    /// The case.
    pub case: &'static ValidationCase,
    /// Its outcome.
    pub outcome: CaseOutcome,
    /// Wall time, s.
    pub seconds: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(reference: f64, ours: f64, limit: AcceptanceLimit) -> Verdict {
        QuantityCheck { quantity: String::new(), reference, ours, limit }.verdict()
    }

    #[test]
    fn difference_beyond_the_limit_fails() {
        assert_eq!(verdict(2.0, 2.001, AcceptanceLimit::Absolute(2e-3)), Verdict::Pass);
        assert_eq!(verdict(2.0, 2.003, AcceptanceLimit::Absolute(2e-3)), Verdict::Fail);
        assert_eq!(verdict(-2.0, -2.003, AcceptanceLimit::Relative(2e-3)), Verdict::Pass);
        assert_eq!(verdict(-2.0, -2.005, AcceptanceLimit::Relative(2e-3)), Verdict::Fail);
        assert_eq!(verdict(0.0, -0.1, AcceptanceLimit::AtMost(0.05)), Verdict::Fail);
        assert_eq!(verdict(0.0, 2.9, AcceptanceLimit::AtLeast(3.0)), Verdict::Fail);
        assert_eq!(verdict(0.0, f64::NAN, AcceptanceLimit::AtMost(1.0)), Verdict::Fail);
        assert_eq!(verdict(f64::NAN, 1.0, AcceptanceLimit::Relative(1.0)), Verdict::Fail);
        assert_eq!(verdict(1.0, 9.0, AcceptanceLimit::None), Verdict::Informational);
    }

    #[test]
    fn skipped_case_does_not_pass() {
        assert_eq!(CaseOutcome::skipped("no files").word(), "skipped");
        let mut o = CaseOutcome::default();
        assert_eq!(o.word(), "informational");
        o.error("x", 0.0, 1.0);
        assert_eq!(o.word(), "pass");
        o.error("y", 2.0, 1.0);
        assert_eq!(o.word(), "FAIL");
    }
}
