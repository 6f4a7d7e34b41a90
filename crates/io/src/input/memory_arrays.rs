//! Arrays in memory in place of files, for the readers: voxel values, values by face. `mesh::mesh_arrays` makes meshes.

use crate::input::reading::error::FileFault;
use crate::input::reading::npy::{ArrayValues, AxisOrder, ScalarArray};
use crate::memory_arrays::{GridOrder, GridValues, MemoryArray};

/// The error of an array of another kind.
pub(super) fn mismatch<T>(array: &MemoryArray<'_>, name: &str, wanted: &str) -> Result<T, FileFault> {
    let found = match array {
        MemoryArray::Grid(_) => "an array of voxels",
        MemoryArray::Faces(_) => "an array of values by face",
        MemoryArray::Mesh(_) => "a mesh",
    };
    Err(FileFault::new(name, "", format!("this is {found}; give {wanted}")))
}

/// An array as a field of voxels; `noun` names a value in messages.
pub(super) fn grid<'a>(
    array: &MemoryArray<'a>,
    name: &str,
    noun: &str,
) -> Result<ScalarArray<'a>, FileFault> {
    let MemoryArray::Grid(grid) = array else { return mismatch(array, name, "an array of three axes") };
    let values = match grid.values {
        GridValues::Single(v) => ArrayValues::Single(v),
        GridValues::Double(v) => ArrayValues::Double(v),
    };
    let order = match grid.order {
        GridOrder::LastAxisFastest => AxisOrder::LastFastest,
        GridOrder::FirstAxisFastest => AxisOrder::FirstFastest,
    };
    ScalarArray::new(name, grid.shape, order, values, noun)
}

/// An array as values by face.
pub(super) fn faces(array: &MemoryArray<'_>, name: &str) -> Result<Vec<f64>, FileFault> {
    match array {
        MemoryArray::Faces(values) => Ok(values.to_vec()),
        _ => mismatch(array, name, "an array with a value for each face of a mesh"),
    }
}
