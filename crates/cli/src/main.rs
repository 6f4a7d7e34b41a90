//! The `zonal` command.

use clap::Parser;
use std::process::ExitCode;
use zonal_cli::commands::{Cli, former_flags, run};
use zonal_report::note;

/// Exit codes: 0 success; 1 a failed verdict of `validate`, no case run, or a warning with `--strict`; 2 bad input, or an output that cannot be written.
fn main() -> ExitCode {
    block_file_size_signal();
    let cli = Cli::parse();
    for (former, present) in former_flags::used(&cli.command, std::env::args_os()) {
        note(&format!("{former} is now {present}"));
    }
    match run(cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("error: {e}");
            ExitCode::from(e.code())
        }
    }
}

/// Blocks SIGXFSZ, so that a file beyond its size limit (`ulimit -f`) fails with an error as on a full disk, instead of ending the process with a
/// partial file beside the target. Threads inherit the mask; it is therefore set before any thread starts.
#[cfg(unix)]
fn block_file_size_signal() {
    use nix::sys::signal::{SigSet, Signal};
    let mut set = SigSet::empty();
    set.add(Signal::SIGXFSZ);
    // A failure loses only the error message.
    let _ = set.thread_block();
}

#[cfg(not(unix))]
fn block_file_size_signal() {}
