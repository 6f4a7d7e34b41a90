//! Meshes apart from scenes: the plates of their polygons.

use super::load::read_mesh_file;
use super::mesh_arrays;
use super::model::MeshData;
use crate::files::FileSource;
use crate::input::error::{FileFault, InputError};
use crate::memory_arrays::{MemoryArray, MeshArrays};
use std::path::Path;
use zonal_scene::Plate;

/// A mesh as plates, in its own unit and axes. A polygon that is neither a triangle nor a parallelogram is several triangles.
///
/// ```
/// let path = std::env::temp_dir().join(format!("zonal-doc-plates-{}.obj", std::process::id()));
/// std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl floor\nf 1 2 3 4\nf 1 2 3")?;
/// let mesh = zonal_io::input::MeshPlates::read(&path)?;
/// assert_eq!((mesh.face_count, mesh.plates.len(), mesh.materials[mesh.plates[1].material].as_str()), (2, 2, "floor"));
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct MeshPlates {
    /// The plates, in the order of the polygons.
    pub plates: Vec<MeshPlate>,
    /// Number of polygons.
    pub face_count: usize,
    /// Names of the materials.
    pub materials: Vec<String>,
    /// Repairs and ignored contents.
    pub notes: Vec<String>,
}

/// A plate of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct MeshPlate {
    /// The geometry.
    pub plate: Plate,
    /// Index of its polygon.
    pub face: usize,
    /// Index of its material.
    pub material: usize,
}

impl MeshPlates {
    /// Reads a mesh file by its extension, as scenes do.
    ///
    /// # Errors
    /// A file that cannot be read or is no valid mesh.
    pub fn read(path: &Path) -> Result<MeshPlates, InputError> {
        let read = read_mesh_file(FileSource::Disk, path, &path.display().to_string());
        read.map(MeshPlates::new).map_err(FileFault::into_error)
    }

    /// The plates of a mesh of arrays, which `name` stands for in messages.
    ///
    /// # Errors
    /// Arrays that do not fit together.
    pub fn of_arrays(arrays: &MeshArrays<'_>, name: &str) -> Result<MeshPlates, InputError> {
        let made = mesh_arrays::mesh(&MemoryArray::Mesh(*arrays), name);
        made.map(MeshPlates::new).map_err(FileFault::into_error)
    }

    fn new(mesh: MeshData) -> MeshPlates {
        let mut plates: Vec<MeshPlate> = mesh
            .faces
            .iter()
            .map(|f| MeshPlate { plate: f.plate, face: f.face, material: f.material })
            .collect();
        plates.sort_by_key(|p| p.face);
        MeshPlates {
            plates,
            face_count: mesh.face_count,
            materials: mesh.materials.into_iter().map(|m| m.name).collect(),
            notes: mesh.notes,
        }
    }
}
