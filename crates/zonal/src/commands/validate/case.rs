//! What a case is, and what comes out of one: quantities beside their references, each with a limit that was stated before.

use super::bench::Bench;
use super::richardson::Sequence;
use crate::Failure;

/// A case of the suite.
pub struct Case {
    /// Its name on the command line.
    pub name: &'static str,
    /// The group that it stands under on the page.
    pub group: &'static str,
    /// What is checked, in a line.
    pub title: &'static str,
    /// How it is checked, and why the limits are what they are: a paragraph of the page, in Markdown.
    pub about: &'static str,
    /// True where it takes a second or two at most.
    pub quick: bool,
    /// A file or folder below the reference folder, without which the case is skipped.
    pub needs: Option<&'static str>,
    /// Computes it.
    pub run: fn(&Bench) -> Result<Outcome, Failure>,
}

/// The most by which ours may differ from the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// |ours − reference|, in the unit of the quantity.
    Absolute(f64),
    /// |ours − reference| relative to |reference|.
    Relative(f64),
    /// The quantity is an error itself: its modulus.
    AtMost(f64),
    /// The quantity is a factor that is to be reached.
    AtLeast(f64),
    /// None: the row informs.
    None,
}

/// How a row ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Within its limit.
    Holds,
    /// Not within its limit, or not a number.
    Fails,
    /// Without a limit.
    Information,
}

impl Verdict {
    /// The word of tables.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Holds => "holds",
            Verdict::Fails => "FAILS",
            Verdict::Information => "–",
        }
    }
}

/// A quantity beside its reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// What it is, with its unit where it has one.
    pub quantity: String,
    /// The reference; 0 where the quantity is an error itself.
    pub reference: f64,
    /// What the program finds.
    pub ours: f64,
    /// The limit.
    pub limit: Limit,
}

impl Check {
    /// The difference that the limit is for: relative where the limit is.
    pub fn difference(&self) -> f64 {
        match self.limit {
            Limit::Relative(_) => (self.ours - self.reference) / self.reference.abs(),
            _ => self.ours - self.reference,
        }
    }

    /// The verdict; what is no number fails.
    pub fn verdict(&self) -> Verdict {
        let holds = match self.limit {
            Limit::Absolute(most) | Limit::Relative(most) | Limit::AtMost(most) => {
                self.difference().abs() <= most
            }
            Limit::AtLeast(least) => self.ours >= least,
            Limit::None => return Verdict::Information,
        };
        if holds { Verdict::Holds } else { Verdict::Fails }
    }

    /// The difference as a share of the limit; what is no number is infinite. `None` without a limit.
    pub fn share(&self) -> Option<f64> {
        let share = match self.limit {
            Limit::Absolute(_) | Limit::Relative(_) | Limit::AtMost(_) if self.difference() == 0.0 => 0.0,
            Limit::Absolute(most) | Limit::Relative(most) | Limit::AtMost(most) => {
                self.difference().abs() / most
            }
            Limit::AtLeast(least) => least / self.ours.max(0.0),
            Limit::None => return None,
        };
        Some(if share.is_nan() { f64::INFINITY } else { share })
    }
}

/// A picture that a case draws for the page: its name without folder, and what it shows.
#[derive(Clone, Debug)]
pub struct Picture {
    /// PNG file, in the folder of plots.
    pub file: String,
    /// A line below it.
    pub caption: String,
}

/// Curves beside the points of a reference.
#[derive(Clone, Debug, Default)]
pub struct Profile {
    /// The plot's file without its ending.
    pub file: String,
    /// What is to be seen.
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

/// What a case finds.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// The rows.
    pub checks: Vec<Check>,
    /// Values at growing resolution.
    pub sequences: Vec<Sequence>,
    /// Curves for the page.
    pub profiles: Vec<Profile>,
    /// Why it was not computed; such a case counts neither as passed nor as failed.
    pub skipped: Option<String>,
    /// Sentences for the page.
    pub notes: Vec<String>,
    /// Pictures for the page.
    pub pictures: Vec<Picture>,
}

impl Outcome {
    /// Of a case that cannot be computed here.
    pub fn skipped(why: impl Into<String>) -> Outcome {
        Outcome { skipped: Some(why.into()), ..Outcome::default() }
    }

    /// Adds a row.
    pub fn check(&mut self, quantity: impl Into<String>, reference: f64, ours: f64, limit: Limit) {
        self.checks.push(Check { quantity: quantity.into(), reference, ours, limit });
    }

    /// Adds a row of a quantity that is an error itself.
    pub fn error(&mut self, quantity: impl Into<String>, ours: f64, most: f64) {
        self.check(quantity, 0.0, ours, Limit::AtMost(most));
    }

    /// Adds a row without a verdict.
    pub fn inform(&mut self, quantity: impl Into<String>, reference: f64, ours: f64) {
        self.check(quantity, reference, ours, Limit::None);
    }

    /// Adds a sentence for the page.
    pub fn note(&mut self, text: impl Into<String>) {
        self.notes.push(text.into());
    }

    /// Number of rows with a verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.checks.iter().filter(|c| c.verdict() == verdict).count()
    }

    /// The word for the whole case.
    pub fn word(&self) -> &'static str {
        match (&self.skipped, self.count(Verdict::Fails), self.count(Verdict::Holds)) {
            (Some(_), ..) => "skipped",
            (None, 0, 0) => "informs",
            (None, 0, _) => "holds",
            _ => "FAILS",
        }
    }
}

/// A case that has run.
pub(super) struct Done {
    /// The case.
    pub case: &'static Case,
    /// What it found.
    pub outcome: Outcome,
    /// Wall time, s.
    pub seconds: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(reference: f64, ours: f64, limit: Limit) -> Verdict {
        Check { quantity: String::new(), reference, ours, limit }.verdict()
    }

    #[test]
    fn a_wrong_reference_fails() {
        assert_eq!(verdict(2.0, 2.001, Limit::Absolute(2e-3)), Verdict::Holds);
        assert_eq!(verdict(2.0, 2.003, Limit::Absolute(2e-3)), Verdict::Fails);
        assert_eq!(verdict(-2.0, -2.003, Limit::Relative(2e-3)), Verdict::Holds);
        assert_eq!(verdict(-2.0, -2.005, Limit::Relative(2e-3)), Verdict::Fails);
        assert_eq!(verdict(0.0, -0.1, Limit::AtMost(0.05)), Verdict::Fails);
        assert_eq!(verdict(0.0, 2.9, Limit::AtLeast(3.0)), Verdict::Fails);
        assert_eq!(verdict(0.0, f64::NAN, Limit::AtMost(1.0)), Verdict::Fails);
        assert_eq!(verdict(f64::NAN, 1.0, Limit::Relative(1.0)), Verdict::Fails);
        assert_eq!(verdict(1.0, 9.0, Limit::None), Verdict::Information);
    }

    #[test]
    fn skipped_is_not_passed() {
        assert_eq!(Outcome::skipped("no files").word(), "skipped");
        let mut o = Outcome::default();
        assert_eq!(o.word(), "informs");
        o.error("x", 0.0, 1.0);
        assert_eq!(o.word(), "holds");
        o.error("y", 2.0, 1.0);
        assert_eq!(o.word(), "FAILS");
    }
}
