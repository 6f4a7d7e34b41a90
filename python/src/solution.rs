//! Solutions: fields as arrays, reports, files, relighting.
//!
//! **Memory.** The fields of all zones move from the solver into arrays of numpy without a copy; they are read-only. The rest of the solution stays here. What
//! needs a whole solution (pictures, files) takes the rest out of its [`Store`], puts copies of the fields into it for as long as it runs, and puts the rest
//! back; other threads wait for it. Solutions of more than three bands keep their fields by blocks of bands, and their arrays are copies.

use crate::arrays;
use crate::errors::{of_app, of_failure, of_file, refused};
use crate::long_call::{self, CallSettings, Observer};
use crate::picture::{FileSettings, SOLUTION};
use crate::scene::{Scene, named};
use crate::zone_arrays;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;
use zonal_app::export::{self, ColourQuantity, ExportOptions, GlbOptions, LightmapSettings, VolumeSettings};
use zonal_app::pictures::draw;
use zonal_app::relight::{RelightSettings, SolutionChanges};
use zonal_app::report_values::distinct_diagnostics;
use zonal_app::shown_solution::with_shown_bands;
use zonal_app::solving::{SharedSolve, SolveCheckpoint, SolveInput, VoxelFactors};
use zonal_io::output::{self, ToneCurve};
use zonal_scene::{Bands, Diagnostic, Fields};
use zonal_solve::distribution::SingleProcess;

/// Interval at which a thread that waits for a solution handles signals.
const INTERVAL: Duration = Duration::from_millis(20);

/// The fields of thermal mode, in the order of [`HeatFields`].
const HEAT_FIELDS: [&str; 4] = ["temperature", "temperature_error", "net", "net_error"];

/// Severity, code, part (empty for the whole) and text of a note or warning.
pub(crate) type DiagnosticRow = (&'static str, String, String, String);

/// A note or warning for the package.
pub(crate) fn diagnostic_row(d: &Diagnostic) -> DiagnosticRow {
    (d.severity.name(), d.code.clone(), d.location.clone(), d.text.clone())
}

/// The arrays of [`Fields::LISTS`].
type BandFields = Vec<Py<PyArray2<f64>>>;
type HeatFields = [Py<PyArray1<f64>>; HEAT_FIELDS.len()];

/// A solution without its fields, unless it has more than three bands; taken out while it is used.
struct Store {
    solution: Mutex<Option<zonal_scene::Solution>>,
    returned: Condvar,
}

/// A solution that is put back without its fields when it is dropped.
struct Taken {
    store: Arc<Store>,
    solution: Option<zonal_scene::Solution>,
    keeps_fields: bool,
}

impl Drop for Taken {
    fn drop(&mut self) {
        let Some(mut solution) = self.solution.take() else { return };
        if !self.keeps_fields {
            solution.fields = Fields::default();
        }
        *self.store.solution.lock().unwrap_or_else(PoisonError::into_inner) = Some(solution);
        self.store.returned.notify_one();
    }
}

/// A solution.
#[pyclass(frozen, module = "zonal._zonal")]
pub(crate) struct Solution {
    store: Arc<Store>,
    bands: usize,
    /// The fields; none where they stay in the store.
    band_fields: Option<BandFields>,
    heat_fields: Option<HeatFields>,
    report: String,
}

impl Solution {
    /// Takes a solution over; its fields become arrays.
    pub(crate) fn new(py: Python<'_>, mut solution: zonal_scene::Solution) -> PyResult<Solution> {
        let report = output::report_json(&solution).to_string();
        let bands = solution.scene.bands().count();
        let (mut band_fields, mut heat_fields) = (None, None);
        if solution.scene.bands().block_count() == 1 {
            let mut f = std::mem::take(&mut solution.fields);
            f.direct.resize(f.radiosity.len(), Bands::ZERO);
            let own = |values: Vec<Bands>| -> PyResult<Py<PyArray2<f64>>> {
                let array = arrays::bands(py, values)?;
                arrays::read_only(array.as_any())?;
                Ok(array.unbind())
            };
            let lists = Fields::LISTS.map(|list| std::mem::take((list.of_mut)(&mut f)));
            band_fields = Some(lists.into_iter().map(own).collect::<PyResult<BandFields>>()?);
            heat_fields = f
                .heat
                .map(|h| -> PyResult<HeatFields> {
                    let own = |values: Vec<f64>| -> PyResult<Py<PyArray1<f64>>> {
                        let array = arrays::list(py, values);
                        arrays::read_only(array.as_any())?;
                        Ok(array.unbind())
                    };
                    Ok([own(h.temperature)?, own(h.temperature_error)?, own(h.net)?, own(h.net_error)?])
                })
                .transpose()?;
        }
        let store = Arc::new(Store { solution: Mutex::new(Some(solution)), returned: Condvar::new() });
        Ok(Solution { store, bands, band_fields, heat_fields, report })
    }

    /// Copies of the fields, for work on a whole solution.
    fn copied_fields(&self, py: Python<'_>) -> Option<Fields> {
        let arrays = self.band_fields.as_ref()?;
        let copy = |k: usize| -> Vec<Bands> {
            let array = arrays[k].bind(py).readonly();
            let rows = array.as_slice().unwrap_or_default().as_chunks::<3>().0;
            rows.iter().map(|x| Bands::from_rgb(*x)).collect()
        };
        let heat = self.heat_fields.as_ref().map(|h| {
            let [temperature, temperature_error, net, net_error] =
                [0, 1, 2, 3].map(|k: usize| h[k].bind(py).readonly().as_slice().unwrap_or_default().to_vec());
            zonal_scene::ThermalFields { temperature, temperature_error, net, net_error }
        });
        let mut fields = Fields { heat, ..Fields::default() };
        let lists = Fields::LISTS.iter().enumerate();
        lists.for_each(|(k, list)| *(list.of_mut)(&mut fields) = copy(k));
        Some(fields)
    }

    /// Takes the solution out of its store; waits while another thread has it.
    fn take(&self, py: Python<'_>) -> PyResult<Taken> {
        loop {
            let taken = py.detach(|| {
                let guard = self.store.solution.lock().unwrap_or_else(PoisonError::into_inner);
                let waited = self.store.returned.wait_timeout_while(guard, INTERVAL, |s| s.is_none());
                waited.unwrap_or_else(PoisonError::into_inner).0.take()
            });
            if taken.is_some() {
                let keeps_fields = self.band_fields.is_none();
                return Ok(Taken { store: self.store.clone(), solution: taken, keeps_fields });
            }
            py.check_signals()?;
        }
    }

    /// Runs a long computation on the whole solution.
    pub(crate) fn run<T: Send + 'static>(
        &self,
        py: Python<'_>,
        settings: CallSettings<'_, '_>,
        work: impl FnOnce(&zonal_scene::Solution, &Observer) -> T + Send + 'static,
    ) -> PyResult<T> {
        let fields = self.copied_fields(py);
        let mut taken = self.take(py)?;
        if let (Some(solution), Some(fields)) = (&mut taken.solution, fields) {
            solution.fields = fields;
        }
        let result = long_call::run(py, settings, move |observer| {
            let solution = taken.solution.as_ref();
            solution.map(|s| work(s, observer))
        })?;
        result.ok_or_else(|| PyKeyError::new_err("the solution is in use"))
    }

    /// Evaluates a function of the solution without its fields.
    pub(crate) fn with<T>(
        &self,
        py: Python<'_>,
        f: impl FnOnce(&zonal_scene::Solution) -> PyResult<T>,
    ) -> PyResult<T> {
        let taken = self.take(py)?;
        match &taken.solution {
            Some(solution) => f(solution),
            None => Err(PyKeyError::new_err("the solution is in use")),
        }
    }

    /// The array of a field; none for other names.
    fn field<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        if let Some(k) = Fields::LISTS.iter().position(|list| list.name == name) {
            let Some(fields) = &self.band_fields else {
                return self.with(py, |s| zone_arrays::field_of_blocks(py, s, k)).map(Some);
            };
            let mut array = fields[k].bind(py).as_any().clone();
            // Errors that no zone has are zero.
            let zones = fields[0].bind(py).len() / 3;
            if fields[k].bind(py).is_empty() && zones > 0 {
                array = arrays::bands(py, vec![Bands::ZERO; zones])?.into_any();
                arrays::read_only(&array)?;
            }
            if self.bands == 3 {
                return Ok(Some(array));
            }
            // The first columns.
            let all = pyo3::types::PySlice::full(py);
            let columns = pyo3::types::PySlice::new(py, 0, self.bands as isize, 1);
            return array.get_item((all, columns)).map(Some);
        }
        let Some(k) = HEAT_FIELDS.iter().position(|n| *n == name) else { return Ok(None) };
        match (&self.heat_fields, &self.band_fields) {
            (Some(fields), _) => Ok(Some(fields[k].bind(py).as_any().clone())),
            (None, Some(_)) => Ok(None),
            (None, None) => self.with(py, |s| Ok(zone_arrays::heat_of_blocks(py, s, k))),
        }
    }
}

/// Settings of `solve` that are not options of the scene.
#[derive(Clone, Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct RunSettings {
    /// Bytes.
    memory_limit: u64,
    /// Folder of finished stages.
    checkpoint: Option<PathBuf>,
    /// Continues with the stages of the folder.
    resume: bool,
    /// Folder for the exchange factors; they are kept after the solve.
    keep_factors: Option<PathBuf>,
    /// Formula of pairs of voxels.
    factors: String,
}

/// Solves a scene.
#[pyfunction]
#[pyo3(signature = (scene, settings, run, progress=None, threads=None))]
pub(crate) fn solve(
    py: Python<'_>,
    scene: &Scene,
    settings: &str,
    run: RunSettings,
    progress: Option<&Bound<'_, PyAny>>,
    threads: Option<i64>,
) -> PyResult<Solution> {
    let scene = scene.with_settings(settings)?;
    let RunSettings { memory_limit, checkpoint, resume, keep_factors, factors } = run;
    let factors = named("factors", &factors, &VoxelFactors::NAMES, &VoxelFactors::VARIANTS)?;
    let checkpoint = checkpoint.map(|folder| SolveCheckpoint { folder, resume, keep_factors });
    let call = CallSettings { threads, progress };
    let solution = long_call::run(py, call, move |observer| {
        let solve = SharedSolve {
            pair_settings: factors.pair_settings(),
            checkpoint: checkpoint.as_ref(),
            progress: observer,
            communicator: &SingleProcess,
            note: &|_| {},
        };
        solve.solve(SolveInput { scene, memory_limit })
    })?;
    Solution::new(py, solution.map_err(|e| of_app(&e))?)
}

/// Changes of lights and surfaces.
#[derive(Clone, Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct RelightChanges {
    /// Light groups with their factors.
    lights: Vec<(String, [f64; 3])>,
    /// Surfaces with their reflectances.
    reflectances: Vec<(String, [f64; 3])>,
    albedo: Option<[f64; 3]>,
    /// Folder of the exchange factors, for other reflectances and albedo.
    kept_factors: Option<PathBuf>,
    /// Bytes.
    memory_limit: u64,
}

impl RelightChanges {
    fn apply(self, solution: zonal_scene::Solution, observer: &Observer) -> PyResult<zonal_scene::Solution> {
        let named = |list: Vec<(String, [f64; 3])>| -> Vec<(String, Bands)> {
            list.into_iter().map(|(name, x)| (name, Bands::from_rgb(x))).collect()
        };
        let changes = SolutionChanges {
            lights: named(self.lights),
            reflectances: named(self.reflectances),
            albedo: self.albedo.map(Bands::from_rgb),
        };
        const REMEDY: &str = "solve the scene with keep_factors=FOLDER, and give kept_factors=FOLDER";
        if changes.needs_solve() && self.kept_factors.is_none() {
            return Err(refused(format!(
                "kept_factors: other reflectances need the exchange factors; {REMEDY}"
            )));
        }
        let settings = RelightSettings {
            kept_factors: &self.kept_factors.unwrap_or_default(),
            remedy: REMEDY,
            memory_limit: self.memory_limit,
            progress: observer,
        };
        changes.apply(solution, &settings).map_err(|e| of_app(&e))
    }
}

/// What `export` writes.
#[derive(Clone, Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct ExportSettings {
    output: PathBuf,
    faces: bool,
    points: bool,
    first_band: Option<usize>,
    colours: Option<String>,
    curve: Option<String>,
    stops: Option<f64>,
    finest: Option<f64>,
    vertices: Option<usize>,
    light_groups: bool,
    lightmap: bool,
    texel: Option<f64>,
    atlas: Option<usize>,
    irradiance_volume: bool,
    grid: Option<Vec<usize>>,
    rays: Option<usize>,
}

impl ExportSettings {
    fn options(self) -> PyResult<ExportOptions> {
        let colours =
            |name: String| named("colours", &name, &ColourQuantity::NAMES, &ColourQuantity::VARIANTS);
        let curve = |name: String| {
            named("curve", &name, &["filmic", "linear"], &[ToneCurve::Filmic, ToneCurve::Linear])
        };
        if !self.lightmap && (self.texel.is_some() || self.atlas.is_some()) {
            return Err(refused(
                "texel, atlas: these are settings of a lightmap; add lightmap=True, or leave them out",
            ));
        }
        if !self.irradiance_volume && (self.grid.is_some() || self.rays.is_some()) {
            return Err(refused(
                "grid, rays: these are settings of an irradiance volume; add irradiance_volume=True, or leave them out",
            ));
        }
        let dims = self.grid.map(<[usize; 3]>::try_from).transpose();
        let dims = dims.map_err(|_| refused("grid: give three numbers of points, as [32, 32, 16]"))?;
        let lightmap = LightmapSettings { texel: self.texel, atlas: self.atlas };
        let volume = VolumeSettings { dims, rays: self.rays };
        Ok(ExportOptions {
            source: SOLUTION.into(),
            output: self.output,
            faces: self.faces,
            points: self.points,
            photometric: None,
            first_band: self.first_band,
            glb: GlbOptions {
                colours: self.colours.map(colours).transpose()?,
                curve: self.curve.map(curve).transpose()?,
                stops: self.stops,
                finest: self.finest,
                vertices: self.vertices,
                light_groups: self.light_groups,
            },
            lightmap: self.lightmap.then_some(lightmap),
            irradiance_volume: self.irradiance_volume.then_some(volume),
        })
    }
}

#[pymethods]
impl Solution {
    /// Reads a solution from a file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Solution> {
        let read = py.detach(|| output::read_solution(&path));
        Solution::new(py, read.map_err(|e| of_file(&e))?)
    }

    /// Reads a solution from the bytes of a file.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, data: &[u8]) -> PyResult<Solution> {
        let read = py.detach(|| output::read_solution_from_bytes(data));
        Solution::new(py, read.map_err(|e| of_file(&e))?)
    }

    /// Writes the file that `zonal solve` writes.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let settings = CallSettings { threads: None, progress: None };
        self.run(py, settings, move |s, _| output::write_solution(&path, s))?.map_err(|e| of_file(&e))
    }

    /// The bytes of the file.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let settings = CallSettings { threads: None, progress: None };
        let bytes = self.run(py, settings, |s, _| output::solution_bytes(s))?;
        Ok(PyBytes::new(py, &bytes?))
    }

    /// The report as JSON.
    #[getter]
    fn report(&self) -> &str {
        &self.report
    }

    /// Name of the scene.
    #[getter]
    fn name(&self, py: Python<'_>) -> PyResult<String> {
        self.with(py, |s| Ok(s.scene.name().to_string()))
    }

    /// True for a solution of thermal mode.
    #[getter]
    fn is_thermal(&self, py: Python<'_>) -> PyResult<bool> {
        self.with(py, |s| Ok(s.scene.thermal().is_some()))
    }

    /// Names of the bands.
    #[getter]
    fn bands(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.with(py, |s| Ok((0..self.bands).map(|b| s.scene.bands().name(b)).collect()))
    }

    /// Numbers of patches, voxel zones and pane zones.
    #[getter]
    fn zone_counts(&self, py: Python<'_>) -> PyResult<(usize, usize, usize)> {
        self.with(py, |s| Ok((s.zones.patches.len(), s.zones.voxels.len(), s.zones.panes.len())))
    }

    /// Names of surfaces, of the medium and of panes.
    #[getter]
    fn names(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.with(py, |s| Ok(zone_arrays::names(s)))
    }

    /// Names of the cameras.
    #[getter]
    fn cameras(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.with(py, |s| Ok(s.scene.cameras().iter().map(|c| c.name.clone()).collect()))
    }

    /// Names of the light groups.
    #[getter]
    fn light_groups(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.with(py, |s| Ok(s.groups.iter().map(|g| g.name.clone()).collect()))
    }

    /// Cells of the medium along each axis, lower and upper corner (m); none without a medium.
    #[getter]
    #[allow(clippy::type_complexity)]
    fn grid(&self, py: Python<'_>) -> PyResult<Option<([usize; 3], [f64; 3], [f64; 3])>> {
        self.with(py, |s| Ok(s.scene.voxel_grid().map(|g| (g.dims(), g.min().array(), g.max().array()))))
    }

    /// The names of all arrays.
    #[staticmethod]
    fn array_names() -> Vec<&'static str> {
        let fields = Fields::LISTS.into_iter().map(|list| list.name).chain(HEAT_FIELDS);
        fields.chain(zone_arrays::NAMES).collect()
    }

    /// An array by its name: a field, or a property of zones.
    fn array<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        if let Some(array) = self.field(py, name)? {
            return Ok(array);
        }
        let found = self.with(py, |s| zone_arrays::array(py, s, name))?;
        found.ok_or_else(|| PyKeyError::new_err(name.to_string()))
    }

    /// The part of a light group in a field: `incident`, `direct`, `error` or `direct_error`, W/m².
    fn group_array<'py>(&self, py: Python<'py>, group: &str, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let found = self.with(py, |s| zone_arrays::group_array(py, s, group, name))?;
        found.ok_or_else(|| PyKeyError::new_err(format!("{group}, {name}")))
    }

    /// Columns of results by name.
    #[pyo3(signature = () -> "dict[str, typing.Any]")]
    fn table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.with(py, |s| zone_arrays::table(py, s))
    }

    /// Columns of the power that surfaces absorb in light mode.
    #[pyo3(signature = () -> "dict[str, typing.Any]")]
    fn absorbed<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.with(py, |s| zone_arrays::absorbed(py, s))
    }

    /// Columns of results by face of the meshes.
    #[pyo3(signature = () -> "dict[str, typing.Any]")]
    fn face_table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let fields = self.copied_fields(py);
        let mut taken = self.take(py)?;
        if let (Some(solution), Some(fields)) = (&mut taken.solution, fields) {
            solution.fields = fields;
        }
        match &taken.solution {
            Some(solution) => zone_arrays::face_table(py, solution),
            None => Err(PyKeyError::new_err("the solution is in use")),
        }
    }

    /// Notes and warnings of the solve and of its discretization error: severity, code, part and text.
    #[getter]
    fn diagnostics(&self, py: Python<'_>) -> PyResult<Vec<DiagnosticRow>> {
        self.with(py, |s| Ok(distinct_diagnostics(s).into_iter().map(diagnostic_row).collect()))
    }

    /// The solution with other light groups, reflectances or albedo.
    #[pyo3(signature = (changes, progress=None, threads=None))]
    fn relight(
        &self,
        py: Python<'_>,
        changes: RelightChanges,
        progress: Option<&Bound<'_, PyAny>>,
        threads: Option<i64>,
    ) -> PyResult<Solution> {
        let call = CallSettings { threads, progress };
        let relit = self.run(py, call, move |s, observer| changes.apply(s.clone(), observer))?;
        Solution::new(py, relit?)
    }

    /// Writes a picture, or the frames of an animation.
    #[pyo3(signature = (settings, progress=None, threads=None))]
    fn draw(
        &self,
        py: Python<'_>,
        settings: FileSettings,
        progress: Option<&Bound<'_, PyAny>>,
        threads: Option<i64>,
    ) -> PyResult<()> {
        let options = settings.options()?;
        let call = CallSettings { threads, progress };
        let drawn = self.run(py, call, move |s, observer| draw(&options, s, observer, &SingleProcess))?;
        drawn.map(|_| ()).map_err(|e| of_failure(&e))
    }

    /// Writes the solution for other programs; returns the paths of the files.
    #[pyo3(signature = (settings, progress=None, threads=None))]
    fn export(
        &self,
        py: Python<'_>,
        settings: ExportSettings,
        progress: Option<&Bound<'_, PyAny>>,
        threads: Option<i64>,
    ) -> PyResult<Vec<PathBuf>> {
        let options = settings.options()?;
        let call = CallSettings { threads, progress };
        let written = self.run(py, call, move |s, observer| {
            let shown = options.first_band.map(|first| with_shown_bands(s.clone(), first)).transpose()?;
            export::write(&options, shown.as_ref().unwrap_or(s), observer)
        })?;
        written.map(|files| files.paths).map_err(|e| of_failure(&e))
    }
}
