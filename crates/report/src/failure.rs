//! The error of a command: one line with an exit code.

use std::fmt;
use std::path::Path;
use zonal_scene::{printable, printable_lines};

/// Error of a command, one line. The message of bad input or of a file that cannot be written names file, place and remedy; its exit code is 2. The exit code
/// of a failed verdict, or of a validation without any case, is 1.
#[derive(Debug)]
pub struct Failure {
    message: String,
    code: u8,
}

/// Exit code of bad input.
const BAD_INPUT_CODE: u8 = 2;
/// Exit code of a failed verdict.
const FAILED_VERDICT_CODE: u8 = 1;

impl Failure {
    /// Bad input, with this message.
    pub fn new(message: impl Into<String>) -> Failure {
        Failure { message: message.into(), code: BAD_INPUT_CODE }
    }
    /// An error in a file.
    pub fn in_file(path: &Path, error: impl fmt::Display) -> Failure {
        Failure::new(format!("{}: {error}", path.display()))
    }
    /// A failed verdict.
    pub fn verdict(message: impl Into<String>) -> Failure {
        Failure { message: message.into(), code: FAILED_VERDICT_CODE }
    }
    /// The exit code.
    #[must_use]
    pub fn code(&self) -> u8 {
        self.code
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Line breaks become semicolons.
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

/// Prints a note to standard error.
pub fn note(text: &str) {
    eprintln!("note: {}", printable(text));
}

/// Prints to standard output, with control characters escaped. A closed pipe is not an error.
///
/// # Errors
/// If standard output cannot be written, for example on a full disk.
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
