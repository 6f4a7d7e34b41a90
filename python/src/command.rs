//! The command line in this process; gas models; validation; the reference of scene keys.

use crate::errors::{of_failure, refused};
use crate::long_call::{self, CallSettings};
use clap::{Args, Command};
use pyo3::prelude::*;
use std::ffi::OsString;
use std::path::PathBuf;
use zonal_cli::command_line::run_arguments;
use zonal_cli::commands::pairs::gas as gas_command;
use zonal_validation::validate::{self as validation, ValidationOptions};

/// Arguments of a subcommand.
pub(crate) fn parse<T: Args>(name: &'static str, arguments: &[String]) -> PyResult<T> {
    let command = T::augment_args(Command::new(name).no_binary_name(true));
    let matches = command.try_get_matches_from(arguments);
    matches.and_then(|m| T::from_arg_matches(&m)).map_err(|e| {
        let text = e.to_string();
        // The first paragraph: a list of missing arguments follows its line.
        let paragraph: Vec<&str> = text.lines().take_while(|l| !l.trim().is_empty()).map(str::trim).collect();
        let line = paragraph.join(" ");
        refused(format!("{}; see zonal {name} --help", line.trim_start_matches("error: ")))
    })
}

/// Runs the command line, the name of the program first; returns its exit code.
#[pyfunction]
pub(crate) fn run_command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| run_arguments(arguments))
}

/// The version of the package.
#[pyfunction]
pub(crate) fn version() -> &'static str {
    env!("CARGO_PKG_VERSION")
}

/// What `zonal gas --json` reports, as JSON.
#[pyfunction]
pub(crate) fn gas(arguments: Vec<String>) -> PyResult<String> {
    let arguments = parse::<gas_command::Args>("gas", &arguments)?;
    gas_command::report(&arguments).map(|json| json.to_string()).map_err(|e| of_failure(&e))
}

/// The keys of scene files: path, type, unit, default, description.
#[pyfunction]
pub(crate) fn keys() -> Vec<(String, &'static str, &'static str, &'static str, &'static str)> {
    let keys = zonal_io::input::scene_key_reference();
    keys.into_iter().map(|k| (k.path, k.value, k.unit, k.default, k.description)).collect()
}

/// The cases to validate, and where their results go.
#[derive(Clone, Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct CaseSettings {
    only: Vec<String>,
    quick: bool,
    list: bool,
    output: Option<PathBuf>,
    reference: Option<PathBuf>,
    scenes: Option<PathBuf>,
}

/// Runs cases with known answers: verdicts as JSON, and whether all hold.
#[pyfunction]
#[pyo3(signature = (settings, progress=None, threads=None))]
pub(crate) fn validate(
    py: Python<'_>,
    settings: CaseSettings,
    progress: Option<&Bound<'_, PyAny>>,
    threads: Option<i64>,
) -> PyResult<(String, bool)> {
    let CaseSettings { only, quick, list, output, reference, scenes } = settings;
    let options = ValidationOptions { only, quick, list, output, reference, scenes, json: true };
    let call = CallSettings { threads, progress };
    let results = long_call::run(py, call, move |observer| validation::results(&options, observer))?;
    results.map_err(|e| of_failure(&e))
}
