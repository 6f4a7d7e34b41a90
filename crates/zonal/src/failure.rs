//! One error for the command: what is wrong, in one line.

use std::fmt;
use std::path::Path;

/// Bad input or a file that cannot be written; the message names the file, the place and the mend. Exit code 2.
#[derive(Debug)]
pub struct Failure(String);

impl Failure {
    /// A failure with this message.
    pub fn new(message: impl Into<String>) -> Failure {
        Failure(message.into())
    }
    /// A scene error that belongs to a file.
    pub fn in_file(path: &Path, error: impl fmt::Display) -> Failure {
        Failure(format!("{}: {error}", path.display()))
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // One line, whatever the parts said.
        write!(f, "{}", self.0.trim().replace('\n', "; "))
    }
}

impl std::error::Error for Failure {}

impl From<zonal_io::input::InputError> for Failure {
    fn from(e: zonal_io::input::InputError) -> Failure {
        Failure(e.to_string())
    }
}
impl From<zonal_io::output::FileError> for Failure {
    fn from(e: zonal_io::output::FileError) -> Failure {
        Failure(e.to_string())
    }
}
impl From<zonal_scene::SceneError> for Failure {
    fn from(e: zonal_scene::SceneError) -> Failure {
        Failure(e.to_string())
    }
}

/// Prints to standard output. A reader that has gone away is no failure; a full disk is.
pub fn say(text: &str) -> Result<(), Failure> {
    use std::io::{ErrorKind, Write};
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.write_all(b"\n")).and_then(|()| out.flush()) {
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(()),
        Err(e) => Err(Failure::new(format!("standard output cannot be written ({e})"))),
        Ok(()) => Ok(()),
    }
}
