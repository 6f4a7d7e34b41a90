//! Errors with their cause, so that a caller chooses words and exceptions by it.

use std::fmt;
use std::path::Path;
use zonal_io::input::InputError;
use zonal_io::output::FileError;
use zonal_report::Failure;
use zonal_scene::SceneError;

/// Why a call failed.
#[derive(Debug)]
pub enum Error {
    /// The scene or its solve.
    Scene(SceneError),
    /// An input file.
    Input(InputError),
    /// An output file, a solution or a checkpoint.
    File(FileError),
    /// An option.
    Refused(Failure),
}

impl Error {
    /// One line; errors of a scene name its file.
    #[must_use]
    pub fn in_scene(self, file: &Path) -> Failure {
        match self {
            Error::Scene(e) => Failure::in_file(file, e),
            other => other.into(),
        }
    }
}

impl From<Error> for Failure {
    fn from(e: Error) -> Failure {
        match e {
            Error::Scene(e) => e.into(),
            Error::Input(e) => e.into(),
            Error::File(e) => e.into(),
            Error::Refused(e) => e,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Scene(e) => e.fmt(f),
            Error::Input(e) => e.fmt(f),
            Error::File(e) => e.fmt(f),
            Error::Refused(e) => e.fmt(f),
        }
    }
}

impl From<SceneError> for Error {
    fn from(e: SceneError) -> Error {
        Error::Scene(e)
    }
}

impl From<InputError> for Error {
    fn from(e: InputError) -> Error {
        Error::Input(e)
    }
}

impl From<Failure> for Error {
    fn from(e: Failure) -> Error {
        Error::Refused(e)
    }
}

impl From<FileError> for Error {
    fn from(e: FileError) -> Error {
        Error::File(e)
    }
}
