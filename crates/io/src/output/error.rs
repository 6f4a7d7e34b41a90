//! Errors of writers, and of readers of our own files: file, place, defect and remedy in one line.

use std::fmt;
use std::path::{Path, PathBuf};

/// An error in a file: place, defect and remedy in one line.
#[derive(Clone, Debug, PartialEq)]
pub struct FileError {
    path: PathBuf,
    entry: String,
    message: String,
}

impl FileError {
    /// An error in `path`, at `entry` (empty for the file as a whole).
    pub fn new(path: &Path, entry: impl Into<String>, message: impl Into<String>) -> FileError {
        FileError { path: path.into(), entry: entry.into(), message: message.into() }
    }
}

impl FileError {
    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }
    /// The place in the file; empty for the file as a whole.
    #[must_use]
    pub fn entry(&self) -> &str {
        &self.entry
    }
    /// What is wrong and, after a semicolon, what to do.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.message
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = self.path.display();
        if self.entry.is_empty() {
            write!(f, "{path}: {}", self.message)
        } else {
            write!(f, "{path}: {}: {}", self.entry, self.message)
        }
    }
}

impl std::error::Error for FileError {}
