//! The `zonal` command.

use clap::Parser;
use std::process::ExitCode;
use zonal::commands::{Cli, run};

/// Exit codes: 0 done, 1 a verdict of `validate` does not hold or all its cases were skipped, 2 bad input or an output that cannot be written.
fn main() -> ExitCode {
    match run(Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("error: {e}");
            ExitCode::from(e.code())
        }
    }
}
