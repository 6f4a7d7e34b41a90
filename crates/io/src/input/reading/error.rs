//! Errors of the readers: file, place, key, defect and remedy in one line.

use std::fmt;

/// Why an input was refused: file, line, column, key, what is wrong and what to do.
///
/// Displays as `FILE:LINE:COLUMN: KEY: what is wrong; what to do`. An error in a referenced file is placed on the line of the scene
/// that refers to it; its text names that file and the place in it.
#[derive(Clone, PartialEq, Eq)]
pub struct InputError(Box<ErrorDetail>);

#[derive(Clone, PartialEq, Eq)]
struct ErrorDetail {
    file: String,
    place: Option<(usize, usize)>,
    key: String,
    message: String,
}

impl InputError {
    /// `place` is (line, column), both from 1; none for an error of the file as a whole.
    pub(crate) fn new(
        file: &str,
        place: Option<(usize, usize)>,
        key: impl Into<String>,
        message: impl Into<String>,
    ) -> InputError {
        let (file, key, message) = (file.to_string(), key.into(), message.into());
        InputError(Box::new(ErrorDetail { file, place, key, message }))
    }
}

impl InputError {
    /// The file, or what stands for it.
    #[must_use]
    pub fn file(&self) -> &str {
        &self.0.file
    }
    /// Line and column, both from 1; none for an error of the file as a whole.
    #[must_use]
    pub fn line_and_column(&self) -> Option<(usize, usize)> {
        self.0.place
    }
    /// The key of the faulty value; empty where there is none.
    #[must_use]
    pub fn key(&self) -> &str {
        &self.0.key
    }
    /// What is wrong and, after a semicolon, what to do.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.0.message
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ErrorDetail { file, place, key, message } = &*self.0;
        write!(f, "{file}")?;
        if let Some((line, column)) = place {
            write!(f, ":{line}:{column}")?;
        }
        if !key.is_empty() {
            write!(f, ": {key}")?;
        }
        write!(f, ": {message}")
    }
}

impl fmt::Debug for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

impl std::error::Error for InputError {}

/// An error in a referenced file: its name, the place in it, what is wrong and what to do. The scene reader adds the line that refers
/// to the file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FileFault {
    /// The file and the place in it.
    place: String,
    message: String,
}

impl FileFault {
    /// An error at `place` (a line number, `accessor 3`, …; empty for the whole file) of `file`.
    pub(crate) fn new(file: &str, place: impl fmt::Display, message: impl fmt::Display) -> FileFault {
        let place = place.to_string();
        let place = if place.is_empty() { file.to_string() } else { format!("{file}:{place}") };
        FileFault { place, message: message.to_string() }
    }
}

impl FileFault {
    /// The error of a file that no scene refers to.
    pub(crate) fn into_error(self) -> InputError {
        InputError::new(&self.place, None, "", self.message)
    }
}

impl fmt::Display for FileFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.message)
    }
}
