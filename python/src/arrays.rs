//! Arrays of numpy as arrays of a scene, borrowed where they lie, and results as arrays of numpy, handed over with their memory.

use crate::errors::refused;
use numpy::ndarray::Dimension;
use numpy::{
    Element, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3, PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use zonal_io::input::{ArraysInMemory, GridArray, GridOrder, GridValues, MemoryArray, MeshArrays};
use zonal_scene::Bands;

/// An array that a document refers to, while it is borrowed.
pub(crate) enum BorrowedArray<'py> {
    Single(PyReadonlyArray3<'py, f32>),
    Double(PyReadonlyArray3<'py, f64>),
    Faces(PyReadonlyArray1<'py, f64>),
    Mesh(BorrowedMesh<'py>),
}

/// A mesh of arrays, while they are borrowed.
pub(crate) struct BorrowedMesh<'py> {
    vertices: PyReadonlyArray2<'py, f64>,
    corners: PyReadonlyArray1<'py, i64>,
    starts: PyReadonlyArray1<'py, i64>,
    corners_of_face: usize,
    material_of_face: PyReadonlyArray1<'py, i64>,
    materials: Vec<String>,
}

const NOT_CONTIGUOUS: &str = "the array is not contiguous; give numpy.ascontiguousarray(array)";

/// The elements of an array where they lie.
pub(crate) fn contiguous<'a, T: Element, D: Dimension>(
    array: &'a PyReadonlyArray<'_, T, D>,
) -> PyResult<&'a [T]> {
    array.as_slice().map_err(|_| refused(NOT_CONTIGUOUS))
}

impl<'py> BorrowedMesh<'py> {
    /// Borrows a mesh: a tuple of vertices, corners, starts, corners of a face, materials of faces, and names.
    pub(crate) fn borrow(mesh: &Bound<'py, PyTuple>) -> PyResult<BorrowedMesh<'py>> {
        let (vertices, corners, starts, corners_of_face, material_of_face, materials) = mesh.extract()?;
        Ok(BorrowedMesh { vertices, corners, starts, corners_of_face, material_of_face, materials })
    }

    /// The arrays for readers.
    pub(crate) fn as_memory(&self) -> PyResult<MeshArrays<'_>> {
        Ok(MeshArrays {
            vertices: contiguous(&self.vertices)?,
            corners: contiguous(&self.corners)?,
            starts: contiguous(&self.starts)?,
            corners_of_face: self.corners_of_face,
            material_of_face: contiguous(&self.material_of_face)?,
            materials: &self.materials,
        })
    }
}

impl<'py> BorrowedArray<'py> {
    /// Borrows an array: `(n, n, n)` of f4 or f8, `(n,)` of f8, or a mesh.
    fn borrow(value: &Bound<'py, PyAny>) -> PyResult<BorrowedArray<'py>> {
        if let Ok(mesh) = value.cast::<PyTuple>() {
            return Ok(BorrowedArray::Mesh(BorrowedMesh::borrow(mesh)?));
        }
        if let Ok(array) = value.extract() {
            return Ok(BorrowedArray::Single(array));
        }
        if let Ok(array) = value.extract() {
            return Ok(BorrowedArray::Double(array));
        }
        Ok(BorrowedArray::Faces(value.extract()?))
    }

    /// The array for the reader of scenes.
    fn as_memory(&self) -> PyResult<MemoryArray<'_>> {
        Ok(match self {
            BorrowedArray::Single(a) => {
                let (shape, order) = layout(a.shape(), a.is_c_contiguous());
                let values = GridValues::Single(contiguous(a)?);
                MemoryArray::Grid(GridArray { shape, order, values })
            }
            BorrowedArray::Double(a) => {
                let (shape, order) = layout(a.shape(), a.is_c_contiguous());
                let values = GridValues::Double(contiguous(a)?);
                MemoryArray::Grid(GridArray { shape, order, values })
            }
            BorrowedArray::Faces(a) => MemoryArray::Faces(contiguous(a)?),
            BorrowedArray::Mesh(m) => MemoryArray::Mesh(m.as_memory()?),
        })
    }
}

fn layout(shape: &[usize], is_c_contiguous: bool) -> ([usize; 3], GridOrder) {
    let order = if is_c_contiguous { GridOrder::LastAxisFastest } else { GridOrder::FirstAxisFastest };
    ([shape[0], shape[1], shape[2]], order)
}

/// Borrows the arrays of a dictionary.
pub(crate) fn borrow_all<'py>(arrays: &Bound<'py, PyDict>) -> PyResult<Vec<(String, BorrowedArray<'py>)>> {
    arrays.iter().map(|(name, value)| Ok((name.extract()?, BorrowedArray::borrow(&value)?))).collect()
}

/// The arrays for the reader of scenes.
pub(crate) fn in_memory<'a>(arrays: &'a [(String, BorrowedArray<'_>)]) -> PyResult<ArraysInMemory<'a>> {
    let mut out = ArraysInMemory::default();
    for (name, array) in arrays {
        out.insert(name.clone(), array.as_memory()?);
    }
    Ok(out)
}

/// A list of numbers as an array.
pub(crate) fn list(py: Python<'_>, values: Vec<f64>) -> Bound<'_, PyArray1<f64>> {
    PyArray1::from_vec(py, values)
}

/// A list of whole numbers as an array.
pub(crate) fn integers(py: Python<'_>, values: impl Iterator<Item = usize>) -> Bound<'_, PyArray1<i64>> {
    PyArray1::from_vec(py, values.map(|i| i as i64).collect())
}

/// Rows of `columns` numbers as an array.
pub(crate) fn rows(py: Python<'_>, values: Vec<f64>, columns: usize) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let count = values.len() / columns.max(1);
    PyArray1::from_vec(py, values).reshape([count, columns])
}

/// Three bands of each zone as the rows of an array, in the same memory.
pub(crate) fn bands(py: Python<'_>, values: Vec<Bands>) -> PyResult<Bound<'_, PyArray2<f64>>> {
    // The elements keep their size, so that the list keeps its memory.
    let flat = values.into_iter().map(Bands::to_rgb).collect::<Vec<[f64; 3]>>().into_flattened();
    rows(py, flat, 3)
}

/// Makes an array read-only.
pub(crate) fn read_only<'py>(array: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let options = PyDict::new(array.py());
    options.set_item("write", false)?;
    array.call_method("setflags", (), Some(&options))?;
    Ok(array.clone())
}
