//! Progress bars for long work: with rate and remaining time, silent when nobody watches.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::Mutex;
use zonal_scene::Progress;

/// A bar on standard error; draws nothing when standard error is not a terminal, or when asked to be quiet.
pub struct Meter {
    bar: Mutex<Option<ProgressBar>>,
    quiet: bool,
}

impl Meter {
    /// A meter; `quiet` silences it even on a terminal.
    pub fn new(quiet: bool) -> Meter {
        Meter { bar: Mutex::new(None), quiet: quiet || !std::io::stderr().is_terminal() }
    }
    fn with(&self, f: impl FnOnce(&mut Option<ProgressBar>)) {
        if let Ok(mut bar) = self.bar.lock() {
            f(&mut bar);
        }
    }
}

impl Progress for Meter {
    fn begin(&self, stage: &str, total: u64) {
        if self.quiet {
            return;
        }
        let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr_with_hz(8));
        let style =
            ProgressStyle::with_template("{msg:>16} [{bar:32}] {percent:>3} %  {per_sec}  {eta} left");
        if let Ok(style) = style {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message(stage.to_string());
        self.with(|b| *b = Some(bar));
    }
    fn advance(&self, steps: u64) {
        if !self.quiet {
            self.with(|b| {
                if let Some(b) = b {
                    b.inc(steps);
                }
            });
        }
    }
    fn end(&self) {
        self.with(|b| {
            if let Some(b) = b.take() {
                b.finish_and_clear();
            }
        });
    }
}
