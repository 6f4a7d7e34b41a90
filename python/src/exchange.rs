//! Exchange areas of all pairs of zones as arrays.
//!
//! The matrices move into arrays of numpy without a copy, as the fields of solutions do.

use crate::arrays;
use crate::errors::{of_app, of_failure, of_scene};
use crate::long_call::{self, CallSettings, Observer};
use crate::scene::Scene;
use crate::solution::{DiagnosticRow, diagnostic_row};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use zonal_app::pairs::{check_tolerance, exchange_areas};
use zonal_scene::SceneError;
use zonal_solve::areas::exchange_areas::{
    AreaMatrices, ExchangeAreaContents, ExchangeAreaSettings, ExchangeAreas as Areas,
};
use zonal_solve::state::ExchangeData;

/// Arrays of direct areas, their radii and row sums, then of total ones.
const NAMES: [&str; 6] = [
    "exchange_areas",
    "error_radius",
    "closure",
    "total_exchange_areas",
    "total_error_radius",
    "total_closure",
];

/// Exchange areas of a scene.
#[pyclass(frozen, module = "zonal._zonal")]
pub(crate) struct ExchangeAreas {
    scene: Arc<zonal_scene::Scene>,
    /// The areas without their matrices.
    areas: Arc<Mutex<Areas>>,
    arrays: Vec<Py<PyArray1<f64>>>,
    matrices: usize,
    zones: usize,
}

fn matrices_of(m: AreaMatrices) -> [Vec<f64>; 3] {
    [m.areas, m.radii, m.closure]
}

impl ExchangeAreas {
    fn new(py: Python<'_>, scene: Arc<zonal_scene::Scene>, mut areas: Areas) -> PyResult<ExchangeAreas> {
        let (matrices, zones) = (areas.matrices, areas.zone_count());
        let direct = matrices_of(std::mem::take(&mut areas.direct));
        let total = areas.total.as_mut().map(|t| matrices_of(std::mem::take(t)));
        let mut arrays = Vec::new();
        for values in direct.into_iter().chain(total.into_iter().flatten()) {
            let array = arrays::list(py, values);
            arrays::read_only(array.as_any())?;
            arrays.push(array.unbind());
        }
        Ok(ExchangeAreas { scene, areas: Arc::new(Mutex::new(areas)), arrays, matrices, zones })
    }

    /// Runs work on the areas with copies of their matrices.
    fn run<T: Send + 'static>(
        &self,
        py: Python<'_>,
        settings: CallSettings<'_, '_>,
        work: impl FnOnce(&zonal_scene::Scene, &Areas, &Observer) -> T + Send + 'static,
    ) -> PyResult<T> {
        let copy = |k: usize| -> Vec<f64> {
            self.arrays
                .get(k)
                .map_or(Vec::new(), |a| a.bind(py).readonly().as_slice().unwrap_or_default().to_vec())
        };
        let whole = |first: usize| AreaMatrices {
            areas: copy(first),
            radii: copy(first + 1),
            closure: copy(first + 2),
        };
        let mut areas = self.areas.lock().unwrap_or_else(PoisonError::into_inner).clone();
        areas.direct = whole(0);
        if areas.total.is_some() {
            areas.total = Some(whole(3));
        }
        let scene = self.scene.clone();
        long_call::run(py, settings, move |observer| work(&scene, &areas, observer))
    }

    /// The data of thermal states.
    pub(crate) fn state(
        &self,
        py: Python<'_>,
        settings: CallSettings<'_, '_>,
    ) -> PyResult<Result<ExchangeData, SceneError>> {
        self.run(py, settings, |scene, areas, observer| ExchangeData::new(scene, areas, observer))
    }

    fn facts<T>(&self, f: impl FnOnce(&Areas) -> T) -> T {
        f(&self.areas.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Settings of `exchange`.
#[derive(Clone, Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct AreaSettings {
    /// Relative tolerance.
    tolerance: f64,
    /// Bytes.
    memory_limit: u64,
    /// Leaves out the total areas.
    direct_only: bool,
}

/// Computes the exchange areas of a scene.
#[pyfunction]
#[pyo3(signature = (scene, settings, progress=None, threads=None))]
pub(crate) fn exchange(
    py: Python<'_>,
    scene: &Scene,
    settings: AreaSettings,
    progress: Option<&Bound<'_, PyAny>>,
    threads: Option<i64>,
) -> PyResult<ExchangeAreas> {
    let AreaSettings { tolerance, memory_limit, direct_only } = settings;
    check_tolerance(tolerance).map_err(|e| of_failure(&e))?;
    let contents =
        if direct_only { ExchangeAreaContents::Direct } else { ExchangeAreaContents::DirectAndTotal };
    let settings = ExchangeAreaSettings { tolerance, memory_limit, contents };
    let (shared, call) = (scene.scene.clone(), CallSettings { threads, progress });
    let areas = long_call::run(py, call, move |observer| Areas::compute(&shared, &settings, observer))?;
    ExchangeAreas::new(py, scene.scene.clone(), areas.map_err(|e| of_scene(&e))?)
}

#[pymethods]
impl ExchangeAreas {
    /// Number of zones.
    #[getter]
    fn zones(&self) -> usize {
        self.zones
    }

    /// Number of matrices: 1, or one for each band.
    #[getter]
    fn matrices(&self) -> usize {
        self.matrices
    }

    /// Names of surfaces, of the medium and of panes.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.facts(|a| a.names.clone())
    }

    /// The weakest grade among the areas.
    #[getter]
    fn grade(&self) -> String {
        self.facts(|a| a.grade().name().to_string())
    }

    /// Notes and warnings: severity, code, part and text.
    #[getter]
    fn diagnostics(&self) -> Vec<DiagnosticRow> {
        self.facts(|a| a.diagnostics.iter().map(diagnostic_row).collect())
    }

    /// Numbers of pairs by method, and of rays.
    #[getter]
    fn counts(&self) -> (u64, u64, u64) {
        self.facts(|a| (a.counts.aligned, a.counts.general, a.counts.rays))
    }

    /// The index into `names` of each zone.
    #[pyo3(signature = () -> "numpy.typing.NDArray[numpy.int64]")]
    fn name_index<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.facts(|a| arrays::integers(py, a.name_of_zone.iter().copied()))
    }

    /// Area of patches, m², and volume of volume zones, m³.
    #[pyo3(signature = () -> "numpy.typing.NDArray[numpy.float64]")]
    fn size<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.facts(|a| arrays::list(py, (0..a.zone_count()).map(|i| a.zones.response(i).1).collect()))
    }

    /// A matrix by its name, [matrices, zones, zones], or its row sums, [matrices, zones]; m².
    fn array<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let index = NAMES.iter().position(|n| *n == name);
        let found = index.and_then(|k| Some((k, self.arrays.get(k)?)));
        let (k, array) = found.ok_or_else(|| PyKeyError::new_err(name.to_string()))?;
        let array = array.bind(py);
        let (m, n) = (self.matrices, self.zones);
        let shaped =
            if k % 3 == 2 { array.reshape([m, n])?.into_any() } else { array.reshape([m, n, n])?.into_any() };
        arrays::read_only(&shaped)
    }

    /// Sums of a matrix over names, [matrices, names, names], m².
    fn by_name<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let index = NAMES.iter().position(|n| *n == name).filter(|k| k % 3 != 2);
        let array = index.and_then(|k| self.arrays.get(k));
        let array = array.ok_or_else(|| PyKeyError::new_err(name.to_string()))?.bind(py).readonly();
        let values = array.as_slice().unwrap_or_default();
        let (sums, k) = self.facts(|a| (a.by_name(values), a.names.len()));
        Ok(arrays::list(py, sums).reshape([self.matrices, k, k])?.into_any())
    }

    /// Writes the areas: `.npz`, `.csv` or `.mtx`; returns the paths of all files.
    #[pyo3(signature = (path, progress=None, threads=None))]
    fn write(
        &self,
        py: Python<'_>,
        path: PathBuf,
        progress: Option<&Bound<'_, PyAny>>,
        threads: Option<i64>,
    ) -> PyResult<Vec<PathBuf>> {
        zonal_report::check_output(&path, &["npz", "csv", "mtx"]).map_err(|e| of_failure(&e))?;
        let call = CallSettings { threads, progress };
        let written = self.run(py, call, move |scene, areas, observer| {
            exchange_areas::write(&path, scene, areas, observer)
        })?;
        written.map_err(|e| of_app(&e))
    }
}
