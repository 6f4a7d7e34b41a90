//! Options of all subcommands, their effect on exit codes, and shared checks of arguments.

use crate::progress::{ProgressBars, ProgressVisibility};
use crate::table;
use serde_json::Value;
use zonal_app::timeline::{Timed, Timeline};
use zonal_report::{Failure, say};
use zonal_scene::{Diagnostic, Report, SceneError};

/// Options of all subcommands.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// Reports as JSON instead of tables.
    pub json: bool,
    /// No progress bars.
    pub quiet: bool,
    /// A warning ends with exit code 1.
    pub strict: bool,
    /// The timeline that `--timings` reports.
    pub timeline: Option<&'a Timeline>,
}

impl<'a> Context<'a> {
    /// The progress bars of the command.
    #[must_use]
    pub fn bars(self) -> ProgressBars {
        ProgressBars::new(if self.quiet { ProgressVisibility::Hidden } else { ProgressVisibility::Automatic })
    }

    /// The observer of the command: its progress bars and its timeline.
    #[must_use]
    pub fn progress(self) -> Timed<'a, ProgressBars> {
        Timed { observer: self.bars(), timeline: self.timeline }
    }

    /// Runs a part of the command as a stage.
    pub fn in_stage<T>(self, stage: &str, run: impl FnOnce() -> T) -> T {
        zonal_scene::in_stage(&self.progress(), stage, run)
    }

    /// Prints a report as JSON, the timeline as its key `timings`.
    ///
    /// # Errors
    /// If standard output cannot be written.
    pub fn say_json(self, mut report: Value) -> Result<(), Failure> {
        if let (Some(timeline), Some(object)) = (self.timeline, report.as_object_mut()) {
            object.insert("timings".into(), timeline.json());
        }
        say(&format!("{report:#}"))
    }

    /// Prints the timeline as a table, where it is no part of a report as JSON.
    ///
    /// # Errors
    /// If standard output cannot be written.
    pub fn say_timings(self) -> Result<(), Failure> {
        match self.timeline.filter(|_| !self.json) {
            Some(timeline) => say(table::timeline(&timeline.phases()).trim_end()),
            None => Ok(()),
        }
    }

    /// Fails with exit code 1 if `--strict` is given and a diagnostic is a warning.
    ///
    /// # Errors
    /// The number of warnings, and the first.
    pub fn check_warnings<'d>(
        self,
        diagnostics: impl IntoIterator<Item = &'d Diagnostic>,
    ) -> Result<(), Failure> {
        let warnings: Vec<&Diagnostic> = diagnostics.into_iter().filter(|n| n.is_warning()).collect();
        match warnings.first() {
            Some(first) if self.strict => {
                Err(Failure::verdict(format!("{} warning(s) with --strict, first: {first}", warnings.len())))
            }
            _ => Ok(()),
        }
    }

    /// [`Context::check_warnings`] of all diagnostics of a report.
    ///
    /// # Errors
    /// As [`Context::check_warnings`].
    pub fn check_report(self, report: &Report) -> Result<(), Failure> {
        self.check_warnings(
            report.warnings.iter().chain(report.discretization_error.iter().flat_map(|z| &z.notes)),
        )
    }
}

/// The memory limit in bytes from `--max-memory` in GB.
///
/// # Errors
/// If the number is not positive and finite.
pub fn memory_limit(gigabytes: f64) -> Result<u64, Failure> {
    if gigabytes > 0.0 && gigabytes.is_finite() {
        return Ok((gigabytes * 1e9) as u64);
    }
    Err(Failure::new("--max-memory: give a positive number of gigabytes"))
}

/// The failure of an option of a scene that was set by a flag: the key `solve.zone_basis` is the flag `--zone-basis`.
#[must_use]
pub fn option_failure(e: &SceneError) -> Failure {
    let flag = e.key().strip_prefix("solve.").unwrap_or(e.key()).replace('_', "-");
    Failure::new(format!("--{flag}: {}", e.message()))
}
