//! The command line in this process, the entry point `zonal` of the package. Nothing else here knows the command or its arguments.

use pyo3::prelude::*;
use std::ffi::OsString;
use zonal_cli::command_line::run_arguments;

/// Runs the command line, the name of the program first; returns its exit code.
#[pyfunction]
pub(crate) fn run_command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| run_arguments(arguments))
}
