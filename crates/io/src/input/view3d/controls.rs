//! `C` lines: controls as `word = value`, also `word value`.

use super::fields::{LineFields, finite};
use super::model::{View3dControls, View3dOutput, View3dSurface, View3dSurfaceKind};
use crate::input::reading::error::FileFault;

/// Largest whole number that View3D accepts as a control.
const MAX_CONTROL_INTEGER: i64 = 32_767;
/// Unknown words that a note lists.
const MAX_LISTED_WORDS: usize = 8;

/// The controls while they are read.
#[derive(Default)]
pub(super) struct ControlReader {
    controls: View3dControls,
    /// Line of the last row or column.
    selection_line: usize,
    /// Unknown words with their line, the first of them.
    unknown_words: Vec<(usize, String)>,
    /// Number of unknown words.
    unknown: usize,
}

impl ControlReader {
    /// Reads a line behind its letter.
    pub(super) fn read_line(&mut self, mut fields: LineFields<'_>) -> Result<(), FileFault> {
        while let Some(word) = fields.next_of_pair() {
            let value = fields.next_of_pair();
            self.set(word, value, &fields)?;
        }
        let c = &self.controls;
        if c.column.is_some() && c.row.is_none() {
            return Err(fields.fault("col selects a column of no row; write row = NUMBER before it"));
        }
        Ok(())
    }

    fn set(&mut self, word: &str, value: Option<&str>, fields: &LineFields<'_>) -> Result<(), FileFault> {
        let bad = |remedy: &str| match value {
            Some(v) => fields.fault(format!("{word} = {v} is no control; give {remedy}")),
            None => fields.fault(format!("the value of {word} is missing; give {remedy}")),
        };
        let integer = || {
            let value = value.and_then(|v| v.parse::<i64>().ok());
            value.filter(|v| v.abs() <= MAX_CONTROL_INTEGER).ok_or_else(|| bad("a whole number up to 32767"))
        };
        let positive = || {
            let value = value.and_then(finite).filter(|x| *x > 0.0);
            value.ok_or_else(|| bad("a number above 0"))
        };
        let selected = || Ok(usize::try_from(integer()?).ok().and_then(|n| n.checked_sub(1)));
        let c = &mut self.controls;
        match word.to_ascii_lowercase().as_str() {
            "eps" => c.eps = positive()?,
            "maxd" => c.max_distance = Some(positive()?),
            "encl" => c.enclosure = integer()? != 0,
            "emit" => c.emittances = integer()? != 0,
            "out" => {
                c.output = match integer()? {
                    0 => View3dOutput::Text,
                    1 => View3dOutput::Binary,
                    2 => View3dOutput::SparseText,
                    _ => return Err(bad("0 (text), 1 (binary) or 2 (sparse text)")),
                }
            }
            "row" => (c.row, self.selection_line) = (selected()?, fields.line),
            "col" => (c.column, self.selection_line) = (selected()?, fields.line),
            "maxu" | "maxo" | "mino" | "list" | "prjd" | "maxv" => {
                integer()?;
            }
            _ => {
                self.unknown += 1;
                if self.unknown_words.len() < MAX_LISTED_WORDS {
                    self.unknown_words.push((fields.line, word.chars().take(40).collect()));
                }
            }
        }
        Ok(())
    }

    /// The controls, and notes on unknown words. A row and a column must be among those of the surfaces with factors.
    pub(super) fn finish(
        self,
        file: &str,
        surfaces: &[View3dSurface],
    ) -> Result<(View3dControls, Vec<String>), FileFault> {
        let rows = surfaces.iter().filter(|s| s.kind != View3dSurfaceKind::Obstruction).count();
        for (word, index) in [("row", self.controls.row), ("col", self.controls.column)] {
            if let Some(index) = index.filter(|i| *i >= rows) {
                let message = format!(
                    "{word} = {} is none of the {rows} surfaces; give one of their numbers, or 0 for all",
                    index + 1
                );
                return Err(FileFault::new(file, self.selection_line, message));
            }
        }
        let mut notes: Vec<String> = self
            .unknown_words
            .iter()
            .map(|(line, word)| format!("{file}:{line}: control '{word}' is unknown and was ignored"))
            .collect();
        if self.unknown > notes.len() {
            notes.push(format!("{file}: {} further controls are unknown", self.unknown - notes.len()));
        }
        Ok((self.controls, notes))
    }
}
