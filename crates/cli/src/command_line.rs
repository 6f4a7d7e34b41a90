//! A whole command line: parsing, the error, the exit code.

use crate::commands::{Cli, run};
use clap::Parser;
use std::ffi::OsString;

/// Runs a command line, the name of the program first, prints its error, and returns its exit code: 0 success; 1 a failed verdict of `validate`, no case
/// run, or a warning with `--strict`; 2 bad input, or an output that cannot be written.
#[must_use]
pub fn run_arguments(arguments: Vec<OsString>) -> u8 {
    let cli = match Cli::try_parse_from(&arguments) {
        Ok(cli) => cli,
        Err(e) => {
            // A closed pipe is not an error.
            let _ = e.print();
            return u8::try_from(e.exit_code()).unwrap_or(u8::MAX);
        }
    };
    match run(cli) {
        Ok(()) => 0,
        Err(e) => {
            eprintln!("error: {e}");
            e.code()
        }
    }
}
