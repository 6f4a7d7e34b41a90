//! Names of the stages of a computation in a display of its progress.

use std::collections::HashMap;

/// The names of stages with the number of their repetition.
#[derive(Default)]
pub struct StageNames {
    counts: HashMap<String, usize>,
}

impl StageNames {
    /// The name of a stage that begins: `gather`, then `gather (2)`.
    pub fn next(&mut self, stage: &str) -> String {
        let count = self.counts.entry(stage.to_string()).or_default();
        *count += 1;
        match *count {
            1 => stage.to_string(),
            n => format!("{stage} ({n})"),
        }
    }
}
