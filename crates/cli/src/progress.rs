//! Progress on standard error: a bar with rate and remaining time on a terminal, elsewhere lines from time to time.
//!
//! A stage that is repeated, such as a round of the final gather, counts its repetitions, so that its percentage never falls:
//!
//! ```text
//!     progress: gather 40 %, 12 s left
//!     progress: gather (2) 15 %, 8 s left
//! ```
//!
//! The remaining time is that of the stage, t (total − done)/done after t seconds of it.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use zonal_app::stage_names::StageNames;
use zonal_scene::Progress;

/// Redraws of a bar per second.
const REDRAWS_PER_SECOND: u8 = 8;
/// Time before the first line: short runs write none.
const FIRST_LINE_AFTER: Duration = Duration::from_secs(5);
/// Time between two lines, over the time that has passed, and the least one.
const LINE_INTERVAL_SHARE: f64 = 0.1;
const MIN_LINE_INTERVAL: Duration = Duration::from_secs(5);
/// Fraction of a stage, and time since its beginning, from which its remaining time is known.
const MIN_FRACTION_OF_FORECAST: f64 = 0.01;
const MIN_TIME_OF_FORECAST: Duration = Duration::from_secs(1);

/// Whether progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProgressVisibility {
    /// As a bar if standard error is a terminal, else as lines.
    Automatic,
    /// Never.
    Hidden,
}

/// Progress of the current stage.
pub struct ProgressBars {
    state: Mutex<BarState>,
    kind: ProgressKind,
    /// Time of the next line, ms after `begun`.
    next_line: AtomicU64,
    begun: Instant,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum ProgressKind {
    Bar,
    Lines,
    Hidden,
}

#[derive(Default)]
struct BarState {
    /// The bar of the innermost stage.
    bar: Option<ProgressBar>,
    names: StageNames,
    /// The stages that have begun, the innermost last.
    open: Vec<Stage>,
}

/// A stage that has begun.
struct Stage {
    name: String,
    done: u64,
    total: u64,
    begun: Instant,
}

impl ProgressBars {
    /// Progress of this visibility.
    #[must_use]
    pub fn new(visibility: ProgressVisibility) -> ProgressBars {
        let kind = match visibility {
            ProgressVisibility::Hidden => ProgressKind::Hidden,
            ProgressVisibility::Automatic if std::io::stderr().is_terminal() => ProgressKind::Bar,
            ProgressVisibility::Automatic => ProgressKind::Lines,
        };
        ProgressBars {
            state: Mutex::default(),
            kind,
            next_line: AtomicU64::new(FIRST_LINE_AFTER.as_millis() as u64),
            begun: Instant::now(),
        }
    }
    fn with_state(&self, f: impl FnOnce(&mut BarState)) {
        if let Ok(mut state) = self.state.lock() {
            f(&mut state);
        }
    }
    /// Shows the innermost stage.
    fn show(&self, state: &mut BarState) {
        if let Some(bar) = state.bar.take() {
            bar.finish_and_clear();
        }
        let Some(stage) = state.open.last() else { return };
        if self.kind == ProgressKind::Lines {
            return self.write_line(stage);
        }
        let target = ProgressDrawTarget::stderr_with_hz(REDRAWS_PER_SECOND);
        let bar = ProgressBar::with_draw_target(Some(stage.total), target).with_message(stage.name.clone());
        bar.set_position(stage.done);
        let template = match stage.total {
            0 => "{msg:>16}",
            _ => "{msg:>16} [{bar:32}] {percent:>3} %  {per_sec}  {eta} left",
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("=> "));
        }
        state.bar = Some(bar);
    }
    /// Writes a line about a stage if it is time for one.
    fn write_line(&self, stage: &Stage) {
        let now = self.begun.elapsed();
        if (now.as_millis() as u64) < self.next_line.load(Ordering::Relaxed) {
            return;
        }
        // Nobody may read standard error any more.
        _ = writeln!(std::io::stderr(), "progress: {}", stage.line(stage.begun.elapsed()));
        let next = now + now.mul_f64(LINE_INTERVAL_SHARE).max(MIN_LINE_INTERVAL);
        self.next_line.store(next.as_millis() as u64, Ordering::Relaxed);
    }
}

impl Stage {
    /// The line about this stage after a time in it.
    fn line(&self, elapsed: Duration) -> String {
        if self.total == 0 {
            return self.name.clone();
        }
        let fraction = (self.done as f64 / self.total as f64).min(1.0);
        let percent = (100.0 * fraction).floor();
        if fraction < MIN_FRACTION_OF_FORECAST || elapsed < MIN_TIME_OF_FORECAST {
            return format!("{} {percent} %", self.name);
        }
        let left = elapsed.as_secs_f64() * (1.0 - fraction) / fraction;
        format!("{} {percent} %, {} left", self.name, duration(left))
    }
}

/// A duration of seconds in words.
#[must_use]
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{s:.0} s"),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

impl Progress for ProgressBars {
    fn begin(&self, stage: &str, total: u64) {
        if self.kind == ProgressKind::Hidden {
            return;
        }
        self.with_state(|s| {
            let name = s.names.next(stage);
            s.open.push(Stage { name, done: 0, total, begun: Instant::now() });
            self.show(s);
        });
    }
    fn advance(&self, steps: u64) {
        if self.kind == ProgressKind::Hidden {
            return;
        }
        self.with_state(|s| {
            let Some(stage) = s.open.last_mut() else { return };
            stage.done += steps;
            match &s.bar {
                Some(bar) => bar.inc(steps),
                None => self.write_line(stage),
            }
        });
    }
    fn end(&self) {
        if self.kind == ProgressKind::Hidden {
            return;
        }
        self.with_state(|s| {
            s.open.pop();
            self.show(s);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeated_stages_are_numbered_and_lines_have_a_forecast() {
        let mut names = StageNames::default();
        assert_eq!(
            ["gather", "gather", "solving", "gather"].map(|s| names.next(s)),
            ["gather", "gather (2)", "solving", "gather (3)"]
        );
        let stage = |done, total| Stage { name: "gather".into(), done, total, begun: Instant::now() };
        assert_eq!(stage(0, 10).line(Duration::from_secs(9)), "gather 0 %");
        assert_eq!(stage(1, 4).line(Duration::from_secs(30)), "gather 25 %, 90 s left");
        assert_eq!(stage(9, 4).line(Duration::from_secs(30)), "gather 100 %, 0 s left");
        assert_eq!(stage(0, 0).line(Duration::from_secs(30)), "gather");
        assert_eq!(duration(400.0), "7 min");
    }
}
