//! View factors of the faces of a mesh.
//!
//! A result is a dictionary of arrays, which own the memory of the computation: nothing is copied. Sums over groups and total exchange factors are made
//! from such a dictionary.

use crate::arrays::{self, BorrowedMesh};
use crate::errors::{DocumentOrigin, of_app, of_failure, of_file, of_input, of_scene, refused};
use crate::long_call::{self, CallSettings};
use crate::solution::{DiagnosticRow, diagnostic_row};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::collections::HashMap;
use std::path::PathBuf;
use zonal_app::pairs::view_factors::diagnostics::{FactorWords, diagnostics};
use zonal_app::pairs::view_factors::geometry::{self, FactorGeometry};
use zonal_app::pairs::view_factors::{FactorLabels, checkpoint_keys, choose_format, write_factors};
use zonal_io::input::{FacetFile, InputError, MeshArrays, read_facets};
use zonal_io::output::{CheckpointFolder, ViewFactorFormat};
use zonal_math::{Grade, Vec3};
use zonal_scene::{CheckpointStore, NoCheckpoints};
use zonal_view_factors::{
    ConvexPolygon, Openness, RowClosing, ViewFactorCounts, ViewFactorParts, ViewFactorSettings, ViewFactors,
    convex_parts,
};

/// Settings of `view_factors`.
#[derive(Clone, Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct FactorSettings {
    tolerance: f64,
    closing: bool,
    surroundings: bool,
    /// Whether backs have rows of their own, after those of the fronts.
    both_sides: bool,
    /// Axis that points up: 0, 1 or 2.
    up: usize,
    /// Periods along the two axes after `up`, m.
    periods: [Option<f64>; 2],
    /// Bytes.
    memory_limit: Option<u64>,
    /// Folder of finished parts of computations.
    cache: Option<PathBuf>,
}

impl FactorSettings {
    fn native(&self) -> ViewFactorSettings {
        let default = ViewFactorSettings::default();
        ViewFactorSettings {
            tolerance: self.tolerance,
            closure: if self.closing { RowClosing::Restore } else { RowClosing::Keep },
            surroundings: if self.surroundings { Openness::Open } else { Openness::Closed },
            up: self.up,
            periods: self.periods,
            memory_limit: self.memory_limit.unwrap_or(default.memory_limit),
        }
    }
}

/// Surfaces of a computation, with the name of the part or material of each.
fn read_faces(mesh: &Bound<'_, PyAny>) -> PyResult<FactorGeometry> {
    let Ok(tuple) = mesh.cast::<PyTuple>() else {
        let path: PathBuf = mesh.extract()?;
        return geometry::read(&path, None).map_err(|e| of_app(&e));
    };
    let borrowed = BorrowedMesh::borrow(tuple)?;
    let arrays = borrowed.as_memory()?;
    let facets = FacetFile::of_arrays(&arrays, "mesh").map_err(|e| of_input(&e, DocumentOrigin::File))?;
    let mut geometry = FactorGeometry::default();
    for (k, (parts, name)) in facets.facets.iter().zip(&facets.names).enumerate() {
        // A convex polygon stays whole.
        let whole = (parts.len() > 1).then(|| ConvexPolygon::new(corners_of(&arrays, k))).flatten();
        let parts = whole.map_or_else(|| parts.iter().flat_map(|c| convex_parts(c)).collect(), |w| vec![w]);
        geometry.add_surface(name, 1.0, parts);
    }
    geometry.notes = facets.notes;
    Ok(geometry)
}

/// Adds the faces of a mesh, which hide from both sides.
fn add_obstacles(geometry: &mut FactorGeometry, mesh: &Bound<'_, PyAny>) -> PyResult<()> {
    let input = |e: InputError| of_input(&e, DocumentOrigin::File);
    let facets = match mesh.cast::<PyTuple>() {
        Ok(tuple) => {
            let borrowed = BorrowedMesh::borrow(tuple)?;
            FacetFile::of_arrays(&borrowed.as_memory()?, "obstacles").map_err(input)?
        }
        Err(_) => read_facets(&mesh.extract::<PathBuf>()?).map_err(input)?,
    };
    geometry.add_obstructions(facets);
    Ok(())
}

/// The corners of a polygon of arrays that were checked.
fn corners_of(a: &MeshArrays<'_>, face: usize) -> Vec<Vec3> {
    let range = if a.starts.is_empty() {
        face * a.corners_of_face..(face + 1) * a.corners_of_face
    } else {
        a.starts[face] as usize..a.starts[face + 1] as usize
    };
    let point = |v: &i64| Vec3::from_array([0, 1, 2].map(|k| a.vertices[3 * *v as usize + k]));
    a.corners[range].iter().map(point).collect()
}

/// The index of the name of each surface, and the names in the order of their first surface.
fn materials_of(names: &[String]) -> (Vec<i64>, Vec<String>) {
    let mut order: HashMap<&str, i64> = HashMap::new();
    let (mut materials, mut material) = (Vec::new(), Vec::with_capacity(names.len()));
    for name in names {
        let next = order.len() as i64;
        let index = *order.entry(name.as_str()).or_insert(next);
        if index == next {
            materials.push(name.clone());
        }
        material.push(index);
    }
    (material, materials)
}

/// The view factors of the faces of a mesh: arrays by name.
#[pyfunction]
#[pyo3(signature = (mesh, obstacles, settings, progress=None, threads=None) -> "dict[str, typing.Any]")]
pub(crate) fn view_factors<'py>(
    py: Python<'py>,
    mesh: &Bound<'py, PyAny>,
    obstacles: Vec<Bound<'py, PyAny>>,
    settings: FactorSettings,
    progress: Option<&Bound<'py, PyAny>>,
    threads: Option<i64>,
) -> PyResult<Bound<'py, PyDict>> {
    let mut geometry = read_faces(mesh)?;
    obstacles.iter().try_for_each(|o| add_obstacles(&mut geometry, o))?;
    if settings.both_sides {
        geometry.add_backs();
    }
    let mut native = settings.native();
    if geometry.is_enclosure() {
        native.surroundings = Openness::Closed;
    }
    let FactorGeometry { set, names, emissivities, notes, .. } = geometry;
    let enclosure = native.surroundings == Openness::Closed;
    let folder =
        settings.cache.as_ref().map(|path| CheckpointFolder::within(path, checkpoint_keys(&set, &native)));
    if let Some(folder) = &folder {
        folder.open_shared().map_err(|e| of_file(&e))?;
    }
    let own = native.clone();
    let computed = long_call::run(py, CallSettings { threads, progress }, move |observer| {
        let store: &dyn CheckpointStore = folder.as_ref().map_or(&NoCheckpoints, |f| f);
        let factors = set.compute(&own, observer, store);
        (factors, folder.and_then(|f| f.failure()))
    })?;
    if let Some(failure) = computed.1 {
        return Err(of_file(&failure));
    }
    let factors = computed.0.map_err(|e| of_scene(&e))?;
    let told = diagnostics(&notes, &factors, &native, &FactorWords::PYTHON);
    let told: Vec<DiagnosticRow> = told.iter().map(diagnostic_row).collect();
    let out = dictionary(py, factors.into_parts())?;
    let (material, materials) = materials_of(&names);
    out.set_item("material", PyArray1::from_vec(py, material))?;
    out.set_item("materials", materials)?;
    out.set_item("emissivities", arrays::list(py, emissivities))?;
    out.set_item("enclosure", enclosure)?;
    out.set_item("diagnostics", told)?;
    Ok(out)
}

/// A result as arrays, which take over its memory.
fn dictionary(py: Python<'_>, parts: ViewFactorParts) -> PyResult<Bound<'_, PyDict>> {
    let out = PyDict::new(py);
    let counts = parts.counts;
    let pairs = |list: Vec<[f64; 2]>| arrays::rows(py, list.into_flattened(), 2);
    out.set_item("areas", arrays::list(py, parts.areas))?;
    out.set_item("row_starts", PyArray1::from_vec(py, parts.row_starts))?;
    out.set_item("columns", PyArray1::from_vec(py, parts.columns))?;
    out.set_item("exchange_areas", arrays::list(py, parts.exchange_areas))?;
    out.set_item("radii", PyArray1::from_vec(py, parts.radii))?;
    out.set_item("sky", pairs(parts.sky)?)?;
    out.set_item("ground", pairs(parts.ground)?)?;
    out.set_item("defects", arrays::list(py, parts.defects))?;
    out.set_item("open_rows", arrays::integers(py, parts.open_rows.into_iter()))?;
    out.set_item("remaining_defect", parts.remaining_defect)?;
    out.set_item("grade", parts.grade.name())?;
    let counts = [
        counts.facets as u64,
        counts.occluders as u64,
        counts.solids as u64,
        counts.examined,
        counts.unobstructed,
        counts.hidden,
        counts.partial,
    ];
    out.set_item("counts", PyArray1::from_slice(py, &counts))?;
    Ok(out)
}

/// A dictionary of `view_factors`, borrowed.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct FactorArrays<'py> {
    areas: PyReadonlyArray1<'py, f64>,
    row_starts: PyReadonlyArray1<'py, u64>,
    columns: PyReadonlyArray1<'py, u32>,
    exchange_areas: PyReadonlyArray1<'py, f64>,
    radii: PyReadonlyArray1<'py, f32>,
    sky: PyReadonlyArray2<'py, f64>,
    ground: PyReadonlyArray2<'py, f64>,
    defects: PyReadonlyArray1<'py, f64>,
    open_rows: PyReadonlyArray1<'py, i64>,
    remaining_defect: f64,
    grade: String,
    counts: PyReadonlyArray1<'py, u64>,
}

impl FactorArrays<'_> {
    /// The view factors, with lists of their own.
    fn native(&self) -> PyResult<ViewFactors> {
        fn list<T: numpy::Element + Copy>(a: &PyReadonlyArray1<'_, T>) -> Vec<T> {
            a.as_array().to_vec()
        }
        let pairs = |a: &PyReadonlyArray2<'_, f64>| -> Vec<[f64; 2]> {
            a.as_array().outer_iter().map(|r| [0, 1].map(|k| r.get(k).copied().unwrap_or(f64::NAN))).collect()
        };
        let counts = list(&self.counts);
        let count = |k: usize| counts.get(k).copied().unwrap_or(0);
        let parts = ViewFactorParts {
            areas: list(&self.areas),
            row_starts: list(&self.row_starts),
            columns: list(&self.columns),
            exchange_areas: list(&self.exchange_areas),
            radii: list(&self.radii),
            sky: pairs(&self.sky),
            ground: pairs(&self.ground),
            defects: list(&self.defects),
            open_rows: list(&self.open_rows)
                .iter()
                .map(|i| usize::try_from(*i).unwrap_or(usize::MAX))
                .collect(),
            remaining_defect: self.remaining_defect,
            grade: if self.grade == Grade::Proved.name() { Grade::Proved } else { Grade::Estimated },
            counts: ViewFactorCounts {
                facets: count(0) as usize,
                occluders: count(1) as usize,
                solids: count(2) as usize,
                examined: count(3),
                unobstructed: count(4),
                hidden: count(5),
                partial: count(6),
            },
        };
        ViewFactors::from_parts(parts).map_err(|e| of_scene(&e))
    }
}

/// The view factors of unions of faces: `group` numbers the union of each face, below `groups`.
#[pyfunction]
#[pyo3(signature = (factors: "dict[str, typing.Any]", group, groups) -> "dict[str, typing.Any]")]
pub(crate) fn combined_view_factors<'py>(
    py: Python<'py>,
    factors: FactorArrays<'py>,
    group: PyReadonlyArray1<'py, i64>,
    groups: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let native = factors.native()?;
    let index = |g: &i64| u32::try_from(*g).ok().filter(|g| (*g as usize) < groups);
    let group: Option<Vec<u32>> = group.as_array().iter().map(index).collect();
    let group = group.filter(|g| g.len() == native.len());
    let group =
        group.ok_or_else(|| refused(format!("groups: give one for each of the {} faces", native.len())))?;
    dictionary(py, py.detach(|| native.combined(&group, groups)).into_parts())
}

/// A matrix and its error radii.
type MatrixWithRadii<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

/// Total exchange factors and their error radii, (faces, faces) each.
#[pyfunction]
#[pyo3(signature = (factors: "dict[str, typing.Any]", emissivity, progress=None, threads=None)
    -> "tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]")]
pub(crate) fn script_factors<'py>(
    py: Python<'py>,
    factors: FactorArrays<'py>,
    emissivity: Vec<f64>,
    progress: Option<&Bound<'py, PyAny>>,
    threads: Option<i64>,
) -> PyResult<MatrixWithRadii<'py>> {
    let native = factors.native()?;
    let n = native.len();
    let call = CallSettings { threads, progress };
    let made = long_call::run(py, call, move |_| native.script_factors(&emissivity))?;
    let made = made.map_err(|e| of_scene(&e))?;
    let entries = (0..n * n).map(|k| made.get(k / n, k % n));
    let (values, radii) = entries.map(|b| (b.value, b.radius)).unzip();
    Ok((arrays::rows(py, values, n)?, arrays::rows(py, radii, n)?))
}

/// How a file of factors is written.
#[derive(Clone, Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct FileSettings {
    /// Name of View3D's format, for files without one of their own.
    format: Option<String>,
    /// Name of each row.
    names: Vec<String>,
    /// Emissivity of each row.
    emissivities: Vec<f64>,
    enclosure: bool,
    /// Writes total exchange factors in place of view factors.
    script: bool,
}

/// Writes the file that `zonal view-factors` writes.
#[pyfunction]
#[pyo3(signature = (factors: "dict[str, typing.Any]", path, settings, threads=None))]
pub(crate) fn write_view_factors(
    py: Python<'_>,
    factors: FactorArrays<'_>,
    path: PathBuf,
    settings: FileSettings,
    threads: Option<i64>,
) -> PyResult<()> {
    zonal_report::check_output(&path, &["csv", "mtx", "txt", "out", "bin"]).map_err(|e| of_failure(&e))?;
    let asked = settings.format.as_deref().map(|name| match name {
        "text" => Ok(ViewFactorFormat::View3dText),
        "binary" => Ok(ViewFactorFormat::View3dBinary),
        "sparse" => Ok(ViewFactorFormat::SparseText),
        _ => Err(refused(format!("format: '{name}' is not known; give text, binary or sparse"))),
    });
    let format = choose_format(&path, asked.transpose()?, None).map_err(|e| of_failure(&e))?;
    let native = factors.native()?;
    if [settings.names.len(), settings.emissivities.len()] != [native.len(); 2] {
        let n = native.len();
        return Err(refused(format!("names, emissivity: there are {n} rows; give one value for each")));
    }
    let call = CallSettings { threads, progress: None };
    long_call::run(py, call, move |_| {
        let FileSettings { names, emissivities, enclosure, script, .. } = settings;
        let script = script.then(|| native.script_factors(&emissivities)).transpose();
        let script = script.map_err(|e| of_scene(&e))?;
        let labels = FactorLabels { names: &names, emissivities: &emissivities, enclosure };
        let written = write_factors(&path, format, native, script.as_ref(), &labels);
        written.map(|_| ()).map_err(|e| of_failure(&e))
    })?
}
