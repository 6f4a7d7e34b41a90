//! Scenes from files and from documents with arrays in memory.

use crate::arrays;
use crate::errors::{DocumentOrigin, of_input, of_scene, refused};
use crate::long_call::{self, CallSettings};
use crate::threads;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;
use zonal_app::scene_check::{CheckSettings, SceneCheck};

/// A validated scene.
#[pyclass(frozen, module = "zonal._zonal")]
pub(crate) struct Scene {
    pub(crate) scene: Arc<zonal_scene::Scene>,
}

/// The value of a name in a list of names.
pub(crate) fn named<T: Copy>(key: &str, name: &str, names: &[&str], values: &[T]) -> PyResult<T> {
    let found = names.iter().position(|n| *n == name).map(|i| values[i]);
    found.ok_or_else(|| refused(format!("{key}: '{name}' is not known; give one of {}", names.join(", "))))
}

impl Scene {
    /// The scene with other settings: lines of keys as in `[solve]`.
    pub(crate) fn with_settings(&self, settings: &str) -> PyResult<zonal_scene::Scene> {
        let scene = zonal_scene::Scene::clone(&self.scene);
        let options = zonal_io::input::read_solve_settings(settings, scene.options().clone());
        let options = options.map_err(|e| of_input(&e, DocumentOrigin::Memory))?;
        scene.with_options(options).map_err(|e| of_scene(&e))
    }
}

#[pymethods]
impl Scene {
    /// Reads a scene file.
    #[staticmethod]
    #[pyo3(signature = (path, threads=None))]
    fn read(py: Python<'_>, path: PathBuf, threads: Option<i64>) -> PyResult<Scene> {
        let pool = threads::pool(threads)?;
        let read = py.detach(|| pool.install(|| zonal_io::input::read_scene(&path)));
        let scene = read.map_err(|e| of_input(&e, DocumentOrigin::File))?;
        Ok(Scene { scene: Arc::new(scene) })
    }

    /// Reads a document in which names of files may stand for arrays. Other files are looked for in the folder `base`.
    #[staticmethod]
    #[pyo3(signature = (text, base, arrays: "dict[str, typing.Any]", name, threads=None))]
    fn parse(
        py: Python<'_>,
        text: &str,
        base: PathBuf,
        arrays: &Bound<'_, PyDict>,
        name: &str,
        threads: Option<i64>,
    ) -> PyResult<Scene> {
        let borrowed = arrays::borrow_all(arrays)?;
        let memory = arrays::in_memory(&borrowed)?;
        let pool = threads::pool(threads)?;
        let base: &Path = &base;
        let read = py.detach(|| {
            pool.install(|| zonal_io::input::parse_scene_with_arrays(text, base, &memory, "scene", name))
        });
        let scene = read.map_err(|e| of_input(&e, DocumentOrigin::Memory))?;
        Ok(Scene { scene: Arc::new(scene) })
    }

    /// Name of the scene.
    #[getter]
    fn name(&self) -> &str {
        self.scene.name()
    }

    /// Lower and upper corner, m.
    #[getter]
    fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        let (low, high) = self.scene.bounds();
        (low.array(), high.array())
    }

    /// Names of the cameras.
    #[getter]
    fn cameras(&self) -> Vec<String> {
        self.scene.cameras().iter().map(|c| c.name.clone()).collect()
    }

    /// Notes and warnings of the reader.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.scene.notes().iter().map(ToString::to_string).collect()
    }
}

/// What `zonal check --json` reports of a scene, as JSON.
#[pyfunction]
#[pyo3(signature = (scene, settings, memory_limit, progress=None, threads=None))]
pub(crate) fn check(
    py: Python<'_>,
    scene: &Scene,
    settings: &str,
    memory_limit: u64,
    progress: Option<&Bound<'_, PyAny>>,
    threads: Option<i64>,
) -> PyResult<String> {
    let scene = scene.with_settings(settings)?;
    let check = CheckSettings { memory_limit, ranks: 1, start: Instant::now() };
    let call = CallSettings { threads, progress };
    let report = long_call::run(py, call, move |_| {
        SceneCheck::new(&scene, &check).map(|check| check.json().to_string())
    })?;
    report.map_err(|e| of_scene(&e))
}
