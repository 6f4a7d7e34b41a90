//! Many solves of one scene with sampled numbers, written as arrays.

use crate::command::parse;
use crate::errors::of_failure;
use crate::long_call::{self, CallSettings};
use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};
use zonal_cli::commands::dataset::{self, DatasetObserver};

/// Writes the file of `zonal dataset` with its arguments; returns the notes on samples.
#[pyfunction]
#[pyo3(signature = (arguments, progress=None, threads=None))]
pub(crate) fn write_dataset(
    py: Python<'_>,
    arguments: Vec<String>,
    progress: Option<&Bound<'_, PyAny>>,
    threads: Option<i64>,
) -> PyResult<Vec<String>> {
    let arguments = parse::<dataset::Args>("dataset", &arguments)?;
    let call = CallSettings { threads, progress };
    long_call::run(py, call, move |observer| {
        let notes = Mutex::new(Vec::new());
        let keep = |text: &str| notes.lock().unwrap_or_else(PoisonError::into_inner).push(text.to_string());
        let written =
            dataset::write_dataset(&arguments, &DatasetObserver { progress: observer, note: &keep });
        written.map(|_| notes.into_inner().unwrap_or_else(PoisonError::into_inner))
    })?
    .map_err(|e| of_failure(&e))
}
