//! The words of a line: separated by blanks and commas, up to a comment.

use crate::input::reading::error::FileFault;
use zonal_math::Vec3;

/// The words of a line that are not read yet.
pub(super) struct LineFields<'a> {
    pub(super) file: &'a str,
    /// Number of the line, from 1.
    pub(super) line: usize,
    rest: &'a str,
}

impl<'a> LineFields<'a> {
    pub(super) fn new(file: &'a str, line: usize, text: &'a str) -> LineFields<'a> {
        LineFields { file, line, rest: text }
    }

    /// An error on this line.
    pub(super) fn fault(&self, message: impl std::fmt::Display) -> FileFault {
        FileFault::new(self.file, self.line, message)
    }

    /// The next word; none at a comment or at the end. `separators` are further characters between words.
    fn word_between(&mut self, separators: &[char]) -> Option<&'a str> {
        let is_separator = |c: char| c.is_whitespace() || c == ',' || separators.contains(&c);
        self.rest = self.rest.trim_start_matches(is_separator);
        if self.rest.is_empty() || self.rest.starts_with(['!', '/']) {
            self.rest = "";
            return None;
        }
        let end = self.rest.find(is_separator).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        Some(word)
    }

    pub(super) fn next_word(&mut self) -> Option<&'a str> {
        self.word_between(&[])
    }

    /// True if a word is left.
    pub(super) fn has_more(&self) -> bool {
        LineFields { ..*self }.next_word().is_some()
    }

    /// The next word of `word = value` pairs.
    pub(super) fn next_of_pair(&mut self) -> Option<&'a str> {
        self.word_between(&['='])
    }

    /// The next word; an error says that `noun` is missing.
    pub(super) fn word(&mut self, noun: &str) -> Result<&'a str, FileFault> {
        self.next_word()
            .ok_or_else(|| self.fault(format!("the {noun} is missing; write it on this line, in its column")))
    }

    /// The next word as a whole number from 0.
    pub(super) fn index(&mut self, noun: &str) -> Result<usize, FileFault> {
        let word = self.word(noun)?;
        word.parse().map_err(|_| self.fault(format!("'{word}' is no {noun}; give a whole number from 0")))
    }

    /// The next word as a finite number.
    pub(super) fn number(&mut self, noun: &str) -> Result<f64, FileFault> {
        let word = self.word(noun)?;
        finite(word).ok_or_else(|| self.fault(format!("'{word}' is no {noun}; give a finite number")))
    }

    /// Three coordinates.
    pub(super) fn vector(&mut self) -> Result<Vec3, FileFault> {
        let mut out = [0.0; 3];
        for (x, noun) in out.iter_mut().zip(["coordinate x", "coordinate y", "coordinate z"]) {
            *x = self.number(noun)?;
        }
        Ok(Vec3::from_array(out))
    }
}

/// The finite number that a word is.
pub(super) fn finite(word: &str) -> Option<f64> {
    word.parse().ok().filter(|x: &f64| x.is_finite())
}
