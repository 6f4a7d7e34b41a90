//! One error type for programs that read scenes, solve them and write the results.

use crate::input::InputError;
use crate::output::FileError;
use std::fmt;
use zonal_scene::{SceneError, SceneErrorKind};

/// Why a scene was refused, a solve ended, or a file could not be read or written: one line that names the place and the remedy.
#[derive(Clone, Debug, PartialEq)]
pub struct Error {
    kind: ErrorKind,
    message: String,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum ErrorKind {
    Solve(SceneErrorKind),
    File,
}

impl Error {
    /// True where the scene, or a file that it was read from, is at fault.
    ///
    /// ```
    /// let error = zonal_io::Error::from(zonal_scene::Scene::builder().build().unwrap_err());
    /// assert!(error.is_input() && !error.is_memory());
    /// ```
    #[must_use]
    pub fn is_input(&self) -> bool {
        self.kind == ErrorKind::Solve(SceneErrorKind::Input)
    }

    /// True where the solve would exceed its memory limit.
    #[must_use]
    pub fn is_memory(&self) -> bool {
        self.kind == ErrorKind::Solve(SceneErrorKind::Memory)
    }

    /// True where the observer interrupted the solve.
    #[must_use]
    pub fn is_interrupted(&self) -> bool {
        self.kind == ErrorKind::Solve(SceneErrorKind::Interrupted)
    }

    /// True where a solution or a picture could not be read or written.
    #[must_use]
    pub fn is_file(&self) -> bool {
        self.kind == ErrorKind::File
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Error {}

impl From<SceneError> for Error {
    fn from(e: SceneError) -> Error {
        Error { kind: ErrorKind::Solve(e.kind()), message: e.to_string() }
    }
}

impl From<InputError> for Error {
    fn from(e: InputError) -> Error {
        Error { kind: ErrorKind::Solve(SceneErrorKind::Input), message: e.to_string() }
    }
}

impl From<FileError> for Error {
    fn from(e: FileError) -> Error {
        Error { kind: ErrorKind::File, message: e.to_string() }
    }
}
