//! One error for the command: what is wrong, in one line.

use std::fmt;
use std::path::Path;
use zonal_scene::{printable, printable_lines};

/// Bad input or a file that cannot be written; the message names the file, the place and the mend. Exit code 2; that of a verdict that does
/// not hold, or of a validation that checked nothing, is 1.
#[derive(Debug)]
pub struct Failure {
    message: String,
    code: u8,
}

/// Exit code of bad input.
const BAD: u8 = 2;
/// Exit code of a verdict that does not hold.
const VERDICT: u8 = 1;

impl Failure {
    /// A failure with this message.
    pub fn new(message: impl Into<String>) -> Failure {
        Failure { message: message.into(), code: BAD }
    }
    /// A scene error that belongs to a file.
    pub fn in_file(path: &Path, error: impl fmt::Display) -> Failure {
        Failure::new(format!("{}: {error}", path.display()))
    }
    /// Verdicts of `zonal validate` that do not hold, or none at all.
    pub fn verdict(message: impl Into<String>) -> Failure {
        Failure { message: message.into(), code: VERDICT }
    }
    /// The exit code.
    pub fn code(&self) -> u8 {
        self.code
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // One line, whatever the parts said.
        write!(f, "{}", printable(&self.message.trim().replace('\n', "; ")))
    }
}

impl std::error::Error for Failure {}

impl From<zonal_io::input::InputError> for Failure {
    fn from(e: zonal_io::input::InputError) -> Failure {
        Failure::new(e.to_string())
    }
}
impl From<zonal_io::output::FileError> for Failure {
    fn from(e: zonal_io::output::FileError) -> Failure {
        Failure::new(e.to_string())
    }
}
impl From<zonal_scene::SceneError> for Failure {
    fn from(e: zonal_scene::SceneError) -> Failure {
        Failure::new(e.to_string())
    }
}

/// A line on standard error that is no error.
pub fn note(text: &str) {
    eprintln!("note: {}", printable(text));
}

/// Prints to standard output, without what would steer a terminal. A reader that has gone away is no failure; a full disk is.
pub fn say(text: &str) -> Result<(), Failure> {
    use std::io::{ErrorKind, Write};
    let mut out = std::io::stdout().lock();
    match out
        .write_all(printable_lines(text).as_bytes())
        .and_then(|()| out.write_all(b"\n"))
        .and_then(|()| out.flush())
    {
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(()),
        Err(e) => Err(Failure::new(format!("standard output cannot be written ({e})"))),
        Ok(()) => Ok(()),
    }
}
