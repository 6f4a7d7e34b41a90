//! Progress bars on standard error, with rate and remaining time.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::Mutex;
use zonal_scene::Progress;

/// Redraws of a bar per second.
const REDRAWS_PER_SECOND: u8 = 8;

/// Whether progress bars are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProgressVisibility {
    /// If standard error is a terminal.
    Automatic,
    /// Never.
    Hidden,
}

/// One progress bar at a time, for the current phase.
pub struct ProgressBars {
    bar: Mutex<Option<ProgressBar>>,
    hidden: bool,
}

impl ProgressBars {
    /// Progress bars of this visibility.
    #[must_use]
    pub fn new(visibility: ProgressVisibility) -> ProgressBars {
        let hidden = visibility == ProgressVisibility::Hidden || !std::io::stderr().is_terminal();
        ProgressBars { bar: Mutex::new(None), hidden }
    }
    fn with_bar(&self, f: impl FnOnce(&mut Option<ProgressBar>)) {
        if let Ok(mut bar) = self.bar.lock() {
            f(&mut bar);
        }
    }
}

impl Progress for ProgressBars {
    fn begin(&self, stage: &str, total: u64) {
        if self.hidden {
            return;
        }
        let bar = ProgressBar::with_draw_target(
            Some(total),
            ProgressDrawTarget::stderr_with_hz(REDRAWS_PER_SECOND),
        );
        let style =
            ProgressStyle::with_template("{msg:>16} [{bar:32}] {percent:>3} %  {per_sec}  {eta} left");
        if let Ok(style) = style {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message(stage.to_string());
        self.with_bar(|b| *b = Some(bar));
    }
    fn advance(&self, steps: u64) {
        if !self.hidden {
            self.with_bar(|b| {
                if let Some(b) = b {
                    b.inc(steps);
                }
            });
        }
    }
    fn end(&self) {
        self.with_bar(|b| {
            if let Some(b) = b.take() {
                b.finish_and_clear();
            }
        });
    }
}
