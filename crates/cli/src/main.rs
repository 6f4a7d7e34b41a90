//! The `zonal` command.

use std::process::ExitCode;
use zonal_cli::command_line::run_arguments;

fn main() -> ExitCode {
    block_file_size_signal();
    ExitCode::from(run_arguments(std::env::args_os().collect()))
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
