//! Many solves of one scene with sampled numbers, written as arrays.

use crate::errors::of_failure;
use crate::long_call::{self, CallSettings};
use crate::scene::named;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use zonal_app::dataset::{self, DatasetInputs, DatasetObserver, DatasetOptions, VariedNumber};
use zonal_scene::Engine;

/// A data set to make.
#[derive(Clone, Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct DatasetSettings {
    template: PathBuf,
    output: PathBuf,
    /// Keys and distributions.
    vary: Vec<(String, String)>,
    /// A table in place of distributions.
    inputs: Option<PathBuf>,
    n: Option<usize>,
    seed: u64,
    /// Bytes.
    memory_limit: u64,
    engine: Option<String>,
    discretization_error: bool,
}

impl DatasetSettings {
    fn options(self) -> PyResult<DatasetOptions> {
        let sampled = || -> PyResult<DatasetInputs> {
            let varied = self.vary.iter().map(|(key, range)| VariedNumber::new(key, range));
            Ok(DatasetInputs::Sampled(varied.collect::<Result<_, _>>().map_err(|e| of_failure(&e))?))
        };
        Ok(DatasetOptions {
            inputs: self.inputs.clone().map_or_else(sampled, |path| Ok(DatasetInputs::Table(path)))?,
            template: self.template,
            count: self.n,
            seed: self.seed,
            output: self.output,
            memory_limit: self.memory_limit,
            engine: self
                .engine
                .map(|e| named("engine", &e, &Engine::NAMES, &Engine::VARIANTS))
                .transpose()?,
            discretization_error: self.discretization_error,
        })
    }
}

/// Writes the file of `zonal dataset`; returns the notes on samples.
#[pyfunction]
#[pyo3(signature = (settings, progress=None, threads=None))]
pub(crate) fn write_dataset(
    py: Python<'_>,
    settings: DatasetSettings,
    progress: Option<&Bound<'_, PyAny>>,
    threads: Option<i64>,
) -> PyResult<Vec<String>> {
    let options = settings.options()?;
    let call = CallSettings { threads, progress };
    long_call::run(py, call, move |observer| {
        let notes = Mutex::new(Vec::new());
        let keep = |text: &str| notes.lock().unwrap_or_else(PoisonError::into_inner).push(text.to_string());
        let written = dataset::write_dataset(&options, &DatasetObserver { progress: observer, note: &keep });
        written.map(|_| notes.into_inner().unwrap_or_else(PoisonError::into_inner))
    })?
    .map_err(|e| of_failure(&e))
}
