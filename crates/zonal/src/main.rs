//! The `zonal` command.

use clap::Parser;
use std::process::ExitCode;
use zonal::commands::{Cli, run};

/// Exit codes: 0 done, 1 a verdict of `validate` does not hold or all its cases were skipped, 2 bad input or an output that cannot be written.
fn main() -> ExitCode {
    hold_back_file_size_signal();
    match run(Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("error: {e}");
            ExitCode::from(e.code())
        }
    }
}

/// A file that grows beyond its limit (`ulimit -f`) then fails to be written, as on a full disk, and is told of; the signal would end the
/// process with a torn file beside the target. Threads inherit what is held back, so this comes before any of them.
#[cfg(unix)]
fn hold_back_file_size_signal() {
    use nix::sys::signal::{SigSet, Signal};
    let mut set = SigSet::empty();
    set.add(Signal::SIGXFSZ);
    // Nothing is lost where this fails but the message.
    let _ = set.thread_block();
}

#[cfg(not(unix))]
fn hold_back_file_size_signal() {}
