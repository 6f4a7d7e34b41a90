//! Gas models; validation; the reference of scene keys; the version.

use crate::errors::of_failure;
use crate::long_call::{self, CallSettings};
use pyo3::prelude::*;
use std::path::PathBuf;
use zonal_app::gas::{GasTable, models_json};
use zonal_gas::GasState;
use zonal_validation::validate::{self as validation, ValidationOptions};

/// The version of the package.
#[pyfunction]
pub(crate) fn version() -> &'static str {
    env!("CARGO_PKG_VERSION")
}

/// State of a gas, and path lengths.
#[derive(Clone, Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct GasSettings {
    /// K.
    temperature: f64,
    /// Pa.
    pressure: f64,
    h2o: f64,
    co2: f64,
    soot: f64,
    /// m.
    lengths: Vec<f64>,
}

/// What `zonal gas --json` reports, as JSON; without a model the models.
#[pyfunction]
#[pyo3(signature = (model, settings))]
pub(crate) fn gas(model: Option<&str>, settings: GasSettings) -> PyResult<String> {
    let Some(model) = model else { return Ok(models_json().to_string()) };
    let GasSettings { temperature, pressure, h2o, co2, soot, lengths } = settings;
    let state = GasState { temperature, pressure, h2o, co2, soot };
    let table = GasTable::new(model, state, lengths).map_err(|e| of_failure(&e))?;
    Ok(table.json().to_string())
}

/// The keys of scene files: path, type, unit, default, description.
#[pyfunction]
pub(crate) fn keys() -> Vec<(String, String, &'static str, &'static str, &'static str)> {
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
