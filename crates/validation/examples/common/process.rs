//! Resources used by a process, from Linux's `/proc`.

use std::path::PathBuf;

/// Clock ticks a second in `/proc/*/stat`: 100 on every Linux that programs see.
const TICKS_PER_SECOND: f64 = 100.0;

/// A process: its number, or `self`.
pub(crate) struct Process(PathBuf);

impl Process {
    /// The process of a number, or `self`.
    pub(crate) fn new(id: &str) -> Process {
        Process(PathBuf::from("/proc").join(id))
    }

    /// The fields of `stat` from the third, the state, on.
    pub(crate) fn stat(&self) -> Option<Vec<String>> {
        let text = std::fs::read_to_string(self.0.join("stat")).ok()?;
        // The second is the command's name in brackets, in which anything may stand.
        Some(text.rsplit_once(") ")?.1.split_whitespace().map(String::from).collect())
    }

    /// Processor time of all its threads, s; `None` where there is no `/proc`.
    pub(crate) fn seconds(&self) -> Option<f64> {
        let stat = self.stat()?;
        let ticks = |k: usize| stat.get(k)?.parse::<f64>().ok();
        Some((ticks(11)? + ticks(12)?) / TICKS_PER_SECOND)
    }
}
