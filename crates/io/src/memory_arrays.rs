//! Arrays in memory in place of the files of a scene.
//!
//! A key that names a file (`density = { file = … }`, `mesh = { file = … }`, `temperature = { file = … }`) may name an array of [`ArraysInMemory`]
//! instead. The arrays are borrowed: values are read where they lie, and only what the scene itself holds is allocated. Checks, messages and results are
//! those of the same array in an npy file: voxel values are rounded to single precision, values by face are double.

use std::collections::BTreeMap;
use std::path::Path;

/// Arrays by the names under which a scene refers to them.
#[derive(Default)]
pub struct ArraysInMemory<'a> {
    arrays: BTreeMap<String, MemoryArray<'a>>,
}

/// An array that a scene refers to.
#[derive(Clone, Copy)]
pub enum MemoryArray<'a> {
    /// A value for each voxel of a box.
    Grid(GridArray<'a>),
    /// A value for each face of a mesh, in the unit of its key.
    Faces(&'a [f64]),
    /// A mesh.
    Mesh(MeshArrays<'a>),
}

/// A value for each voxel of a box.
#[derive(Clone, Copy)]
pub struct GridArray<'a> {
    /// Number of elements along x, y and z.
    pub shape: [usize; 3],
    /// The axis that runs fastest in memory.
    pub order: GridOrder,
    /// The elements.
    pub values: GridValues<'a>,
}

/// The axis that runs fastest in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GridOrder {
    /// z, as in C.
    LastAxisFastest,
    /// x, as in Fortran.
    FirstAxisFastest,
}

/// Elements of a grid.
#[derive(Clone, Copy)]
pub enum GridValues<'a> {
    /// Single precision.
    Single(&'a [f32]),
    /// Double precision, rounded to single.
    Double(&'a [f64]),
}

/// A mesh: vertices in the unit of the mesh, and polygons as lists of indices.
#[derive(Clone, Copy)]
pub struct MeshArrays<'a> {
    /// Three coordinates for each vertex.
    pub vertices: &'a [f64],
    /// Vertices of all polygons, one polygon after the other, counter-clockwise seen from the front.
    pub corners: &'a [i64],
    /// Index of the first corner of each polygon, and the number of all corners at the end; empty where every polygon has `corners_of_face` corners.
    pub starts: &'a [i64],
    /// Number of corners of every polygon; it applies without `starts`.
    pub corners_of_face: usize,
    /// The material of each polygon as an index into `materials`; empty for a mesh of one material.
    pub material_of_face: &'a [i64],
    /// Names of the materials; none for one material called `default`.
    pub materials: &'a [String],
}

impl<'a> ArraysInMemory<'a> {
    /// Adds an array, or replaces the one of that name.
    ///
    /// ```
    /// use zonal_io::input::{ArraysInMemory, GridArray, GridOrder, GridValues, MemoryArray, parse_scene_with_arrays};
    /// let values = vec![0.5; 8];
    /// let grid = GridArray { shape: [2, 2, 2], order: GridOrder::LastAxisFastest, values: GridValues::Double(&values) };
    /// let mut arrays = ArraysInMemory::default();
    /// arrays.insert("smoke", MemoryArray::Grid(grid));
    /// let text = "[medium]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\ncells = [2, 2, 2]\n[[medium.region]]\ndensity = { file = 'smoke', min = [0, 0, 0], max = [1, 1, 1] }";
    /// let scene = parse_scene_with_arrays(text, "".as_ref(), &arrays, "room", "room")?;
    /// assert_eq!(scene.voxel_grid().unwrap().extinction(7).to_rgb(), [0.5; 3]);
    /// # Ok::<(), zonal_io::input::InputError>(())
    /// ```
    pub fn insert(&mut self, name: impl Into<String>, array: MemoryArray<'a>) {
        self.arrays.insert(name.into(), array);
    }

    /// The array that a path names.
    pub(crate) fn get(&self, path: &Path) -> Option<MemoryArray<'a>> {
        self.arrays.get(path.file_name()?.to_str()?).copied()
    }
}
