//! Thermal states of one geometry from its exchange areas.

use crate::arrays;
use crate::errors::{of_file, of_scene, refused};
use crate::exchange::ExchangeAreas;
use crate::long_call::{self, CallSettings};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use zonal_app::pairs::exchange_areas::read_state;
use zonal_scene::{SceneError, ThermalCondition};
use zonal_solve::state::{ExchangeData, StatePart, ThermalState};

/// A solver that keeps its factorization between states.
#[pyclass(frozen, module = "zonal._zonal")]
pub(crate) struct StateSolver {
    /// Taken out while it solves.
    solver: Arc<Mutex<Option<zonal_solve::state::StateSolver>>>,
}

/// Quantities that a state can be given.
#[derive(Clone, Copy)]
enum Quantity {
    Temperature,
    Flux,
    Power,
    Emissivity,
}

impl StateSolver {
    fn new(data: ExchangeData) -> PyResult<StateSolver> {
        let solver = zonal_solve::state::StateSolver::new(data).map_err(|e| of_scene(&e))?;
        Ok(StateSolver { solver: Arc::new(Mutex::new(Some(solver))) })
    }
    fn lock(&self) -> MutexGuard<'_, Option<zonal_solve::state::StateSolver>> {
        self.solver.lock().unwrap_or_else(PoisonError::into_inner)
    }
    fn with<T>(&self, f: impl FnOnce(&mut zonal_solve::state::StateSolver) -> PyResult<T>) -> PyResult<T> {
        match &mut *self.lock() {
            Some(solver) => f(solver),
            None => {
                Err(refused("the solver is at work in another thread, or was interrupted; make another one"))
            }
        }
    }
}

fn part_columns<'py>(py: Python<'py>, parts: &[StatePart]) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let column = |of: &dyn Fn(&StatePart) -> f64| arrays::list(py, parts.iter().map(of).collect());
    out.set_item("size", column(&|p| p.size))?;
    out.set_item("net_power", column(&|p| p.power[0]))?;
    out.set_item("net_power_exchange_error", column(&|p| p.power[1]))?;
    out.set_item("net_flux", column(&|p| p.flux()[0]))?;
    out.set_item("net_flux_exchange_error", column(&|p| p.flux()[1]))?;
    out.set_item("temperature", column(&|p| p.temperature[0]))?;
    out.set_item("temperature_exchange_error", column(&|p| p.temperature[1]))?;
    out.set_item("incident", column(&|p| p.incident[0]))?;
    out.set_item("incident_exchange_error", column(&|p| p.incident[1]))?;
    out.set_item("radiosity", column(&|p| p.radiosity[0]))?;
    out.set_item("radiosity_exchange_error", column(&|p| p.radiosity[1]))?;
    Ok(out)
}

#[pymethods]
impl StateSolver {
    /// A solver of the states of a scene whose areas are known.
    #[staticmethod]
    #[pyo3(signature = (areas, progress=None, threads=None))]
    fn of_areas(
        py: Python<'_>,
        areas: &ExchangeAreas,
        progress: Option<&Bound<'_, PyAny>>,
        threads: Option<i64>,
    ) -> PyResult<StateSolver> {
        let data = areas.state(py, CallSettings { threads, progress })?;
        StateSolver::new(data.map_err(|e| of_scene(&e))?)
    }

    /// A solver from the file of `zonal exchange`.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<StateSolver> {
        let data = py.detach(|| read_state(&path));
        StateSolver::new(data.map_err(|e| of_file(&e))?)
    }

    /// Names of surfaces, of the medium and of panes.
    #[getter]
    fn names(&self) -> PyResult<Vec<String>> {
        self.with(|s| Ok(s.data().names.clone()))
    }

    /// Number of zones, of patches, and of faces of meshes.
    #[getter]
    fn counts(&self) -> PyResult<(usize, usize, usize)> {
        self.with(|s| Ok((s.data().zone_count(), s.data().patches, s.data().face_count())))
    }

    /// The index into `names` of each zone.
    #[pyo3(signature = () -> "numpy.typing.NDArray[numpy.int64]")]
    fn name_index<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i64>>> {
        self.with(|s| Ok(arrays::integers(py, s.data().name_of_zone.iter().copied())))
    }

    /// The face of each zone among those of all meshes, −1 for none.
    #[pyo3(signature = () -> "numpy.typing.NDArray[numpy.int64]")]
    fn face_index<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i64>>> {
        self.with(|s| {
            let faces = s.data().face_of_zone.iter().map(|f| f.map_or(-1, |f| f as i64));
            Ok(PyArray1::from_vec(py, faces.collect()))
        })
    }

    /// Area of patches, m², and volume of volume zones, m³.
    #[pyo3(signature = () -> "numpy.typing.NDArray[numpy.float64]")]
    fn size<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.with(|s| Ok(arrays::list(py, s.data().sizes.clone())))
    }

    /// Sets a quantity of zones: `temperature` (K), `flux` (W/m², W/m³), `power` (W) or `emissivity`.
    fn set(
        &self,
        quantity: &str,
        zones: PyReadonlyArray1<'_, i64>,
        values: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<()> {
        let quantity = match quantity {
            "temperature" => Quantity::Temperature,
            "flux" => Quantity::Flux,
            "power" => Quantity::Power,
            "emissivity" => Quantity::Emissivity,
            _ => return Err(refused(format!("'{quantity}' is no quantity of a state; give another"))),
        };
        let zones = arrays::contiguous(&zones)?;
        let values = arrays::contiguous(&values)?;
        self.with(|s| {
            for (zone, x) in zones.iter().zip(values) {
                let found = usize::try_from(*zone).ok().filter(|i| *i < s.data().zone_count());
                let zone = found.ok_or_else(|| {
                    refused(format!("zone {zone} is out of range: there are {}", s.data().zone_count()))
                })?;
                let set = match quantity {
                    Quantity::Temperature => s.set_condition(zone, ThermalCondition::Temperature(*x)),
                    Quantity::Flux => s.set_condition(zone, ThermalCondition::Flux(*x)),
                    Quantity::Power => s.set_condition(zone, ThermalCondition::Power(*x)),
                    Quantity::Emissivity => s.set_reflectance(zone, &[1.0 - x]),
                };
                set.map_err(|e| of_scene(&e))?;
            }
            Ok(())
        })
    }

    /// Sets the temperature of the surroundings, K; none for cold ones.
    fn set_surroundings(&self, kelvin: Option<f64>) -> PyResult<()> {
        self.with(|s| s.set_surroundings_temperature(kelvin).map_err(|e| of_scene(&e)))
    }

    /// Solves the state: columns by zone, by name and by face, and the balance.
    #[pyo3(signature = (progress=None, threads=None) -> "dict[str, typing.Any]")]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        progress: Option<&Bound<'py, PyAny>>,
        threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let Some(mut solver) = self.lock().take() else {
            return Err(refused("the solver is at work in another thread; make another one"));
        };
        let store = self.solver.clone();
        let call = CallSettings { threads, progress };
        let solved = long_call::run(py, call, move |_| {
            let state: Result<ThermalState, SceneError> = solver.solve();
            *store.lock().unwrap_or_else(PoisonError::into_inner) = Some(solver);
            state
        })?;
        let state = solved.map_err(|e| of_scene(&e))?;
        self.with(|s| {
            let data = s.data();
            let out = PyDict::new(py);
            let zones = state.sums(&data.sizes, data.zone_count(), Some);
            out.set_item("zones", part_columns(py, &zones)?)?;
            out.set_item("names", part_columns(py, &state.by_name(data))?)?;
            out.set_item("faces", part_columns(py, &state.by_face(data))?)?;
            out.set_item("surroundings", state.surroundings)?;
            out.set_item("absorbed_backfaces", state.absorbed_backfaces)?;
            out.set_item("emitters", state.emitters)?;
            out.set_item("balance", state.balance(data))?;
            Ok(out)
        })
    }
}
