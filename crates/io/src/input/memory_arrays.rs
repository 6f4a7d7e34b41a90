//! Arrays in memory in place of the files of a scene.
//!
//! A key that names a file (`density = { file = … }`, `mesh = { file = … }`, `temperature = { file = … }`) may name an array of [`ArraysInMemory`]
//! instead. The arrays are borrowed: values are read where they lie, and only what the scene itself holds is allocated. Checks, messages and results are
//! those of the same array in an npy file: voxel values are rounded to single precision, values by face are double.

use super::error::FileFault;
use super::mesh::model::{MeshData, MeshFace, MeshMaterial};
use super::mesh::polygon::push_polygon;
use super::npy::{ArrayValues, AxisOrder, ScalarArray};
use std::collections::BTreeMap;
use std::path::Path;
use zonal_math::Vec3;

/// Largest number of corners of a polygon; it bounds the cost of ear clipping.
const MAX_POLYGON_CORNERS: usize = 1024;

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

impl<'a> MemoryArray<'a> {
    fn what(&self) -> &'static str {
        match self {
            MemoryArray::Grid(_) => "an array of voxels",
            MemoryArray::Faces(_) => "an array of values by face",
            MemoryArray::Mesh(_) => "a mesh",
        }
    }

    fn mismatch<T>(&self, name: &str, wanted: &str) -> Result<T, FileFault> {
        Err(FileFault::new(name, "", format!("this is {}; give {wanted}", self.what())))
    }

    /// The array as a field of voxels; `noun` names a value in messages.
    pub(crate) fn grid(&self, name: &str, noun: &str) -> Result<ScalarArray<'a>, FileFault> {
        let MemoryArray::Grid(grid) = self else { return self.mismatch(name, "an array of three axes") };
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

    /// The array as values by face.
    pub(crate) fn faces(&self, name: &str) -> Result<Vec<f64>, FileFault> {
        match self {
            MemoryArray::Faces(values) => Ok(values.to_vec()),
            _ => self.mismatch(name, "an array with a value for each face of a mesh"),
        }
    }

    /// The mesh with its faces in the order of the array.
    pub(crate) fn mesh(&self, name: &str) -> Result<MeshData, FileFault> {
        match self {
            MemoryArray::Mesh(arrays) => MeshBuilder { name, arrays }.build(),
            _ => self.mismatch(name, "a mesh: an array of vertices and an array of faces"),
        }
    }
}

/// Makes a mesh of arrays.
struct MeshBuilder<'a> {
    name: &'a str,
    arrays: &'a MeshArrays<'a>,
}

impl MeshBuilder<'_> {
    fn fault(&self, place: String, message: impl std::fmt::Display) -> FileFault {
        FileFault::new(self.name, place, message)
    }

    fn build(&self) -> Result<MeshData, FileFault> {
        let a = self.arrays;
        let faces = if a.starts.is_empty() {
            a.corners.len() / a.corners_of_face.max(1)
        } else {
            a.starts.len() - 1
        };
        if faces == 0 {
            return Err(self.fault(String::new(), "this mesh has no faces; give an array of faces"));
        }
        if let Some(v) = a.vertices.iter().position(|x| !x.is_finite()) {
            let message = "this coordinate is not a finite number; mend the array of vertices";
            return Err(self.fault(format!("vertex {}", v / 3), message));
        }
        if !a.material_of_face.is_empty() && a.material_of_face.len() != faces {
            let message = format!(
                "there are {faces} faces and {} materials of faces; give one material for each face",
                a.material_of_face.len()
            );
            return Err(self.fault(String::new(), message));
        }
        let names: Vec<&str> = match a.materials {
            [] => vec!["default"],
            list => list.iter().map(String::as_str).collect(),
        };
        let mut mesh = MeshData {
            materials: names.into_iter().map(MeshMaterial::named).collect(),
            face_count: faces,
            ..MeshData::default()
        };
        let mut crossed = 0;
        for face in 0..faces {
            let template = MeshFace::template(self.material(face, mesh.materials.len())?, face);
            let corners = self.corners(face)?.iter().map(|v| Ok((self.vertex(face, *v)?, [0.0; 2])));
            let corners = corners.collect::<Result<Vec<_>, FileFault>>()?;
            crossed += usize::from(!push_polygon(&mut mesh.faces, &template, &corners));
        }
        if crossed > 0 {
            let note = format!("{}: {crossed} polygons cross themselves and were cut as fans", self.name);
            mesh.notes.push(note);
        }
        Ok(mesh)
    }

    fn material(&self, face: usize, count: usize) -> Result<usize, FileFault> {
        let Some(m) = self.arrays.material_of_face.get(face) else { return Ok(0) };
        let index = usize::try_from(*m).ok().filter(|m| *m < count);
        index.ok_or_else(|| {
            let message = format!("material {m} is out of range: there are {count}; mend the index");
            self.fault(format!("face {face}"), message)
        })
    }

    /// The corners of a polygon as indices of vertices.
    fn corners(&self, face: usize) -> Result<&[i64], FileFault> {
        let a = self.arrays;
        let range = match a.starts {
            [] => Some(face * a.corners_of_face..(face + 1) * a.corners_of_face),
            starts => usize::try_from(starts[face])
                .ok()
                .zip(usize::try_from(starts[face + 1]).ok())
                .map(|(first, end)| first..end),
        };
        let corners = range.and_then(|r| a.corners.get(r)).unwrap_or_default();
        if (3..=MAX_POLYGON_CORNERS).contains(&corners.len()) {
            return Ok(corners);
        }
        let message = format!(
            "this face has {} corners; give polygons of 3 to {MAX_POLYGON_CORNERS} corners",
            corners.len()
        );
        Err(self.fault(format!("face {face}"), message))
    }

    fn vertex(&self, face: usize, index: i64) -> Result<Vec3, FileFault> {
        let vertices = self.arrays.vertices.as_chunks::<3>().0;
        let found = usize::try_from(index).ok().and_then(|i| vertices.get(i));
        found.map(|v| Vec3::from_array(*v)).ok_or_else(|| {
            let message = format!(
                "vertex index {index} is out of range: there are {} vertices; mend the index",
                vertices.len()
            );
            self.fault(format!("face {face}"), message)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_of_arrays_are_checked() {
        let vertices = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];
        let mesh = |corners: &[i64], starts: &[i64], materials: &[i64]| {
            let arrays = MeshArrays {
                vertices: &vertices,
                corners,
                starts,
                corners_of_face: 3,
                material_of_face: materials,
                materials: &[],
            };
            MemoryArray::Mesh(arrays).mesh("m").map_err(|e| e.to_string())
        };
        let two = mesh(&[0, 1, 2, 0, 2, 3], &[], &[]).map(|m| (m.faces.len(), m.face_count));
        assert_eq!(two.unwrap(), (2, 2));
        let quad = mesh(&[0, 1, 2, 3], &[0, 4], &[]).unwrap();
        assert_eq!((quad.face_count, quad.faces[0].face), (1, 0));
        for (corners, starts, materials, message) in [
            (&[0, 1, 4][..], &[][..], &[][..], "face 0: vertex index 4 is out of range"),
            (&[0, 1, -1], &[], &[], "face 0: vertex index -1 is out of range"),
            (&[0, 1], &[0, 2], &[], "face 0: this face has 2 corners"),
            (&[0, 1, 2], &[0, 9], &[], "face 0: this face has 0 corners"),
            (&[0, 1, 2], &[], &[1], "face 0: material 1 is out of range"),
            (&[0, 1, 2], &[], &[0, 0], "there are 1 faces and 2 materials"),
            (&[], &[], &[], "this mesh has no faces"),
        ] {
            let Err(error) = mesh(corners, starts, materials) else { panic!("{message}") };
            assert!(error.contains(message), "{error}");
        }
    }
}
