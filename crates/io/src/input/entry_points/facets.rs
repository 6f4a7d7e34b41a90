//! Meshes as lists of polygons, without a scene: for view factors.

use crate::files::FileSource;
use crate::input::mesh::mesh_arrays::mesh as mesh_of_array;
use crate::input::mesh::model::MeshData;
use crate::input::mesh_files::load::read_mesh_file;
use crate::input::reading::error::{FileFault, InputError};
use crate::memory_arrays::{MemoryArray, MeshArrays};
use std::path::Path;
use zonal_math::Vec3;

/// The polygons of a mesh file, in its unit, axes and order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FacetFile {
    /// Corners of the flat convex parts of each polygon, counter-clockwise from its front; none for a polygon without area.
    pub facets: Vec<Vec<Vec<Vec3>>>,
    /// Name of each polygon's material or part.
    pub names: Vec<String>,
    /// Repairs and ignored contents.
    pub notes: Vec<String>,
}

/// Reads a mesh file of a format that scenes read, by its extension.
///
/// # Errors
///
/// The file cannot be read or is not such a mesh.
///
/// ```
/// let path = std::env::temp_dir().join(format!("zonal-doc-facets-{}.obj", std::process::id()));
/// std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 1 3 4\n").unwrap();
/// let mesh = zonal_io::input::read_facets(&path)?;
/// assert_eq!((mesh.facets.len(), mesh.facets[0][0].len()), (2, 4));
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), zonal_io::input::InputError>(())
/// ```
pub fn read_facets(path: &Path) -> Result<FacetFile, InputError> {
    let file = path.display().to_string();
    Ok(FacetFile::new(read_mesh_file(FileSource::DISK, path, &file).map_err(FileFault::into_error)?))
}

impl FacetFile {
    /// The polygons of a mesh of arrays, which `name` stands for in messages.
    ///
    /// # Errors
    ///
    /// Arrays that do not fit together.
    pub fn of_arrays(arrays: &MeshArrays<'_>, name: &str) -> Result<FacetFile, InputError> {
        let mesh = mesh_of_array(&MemoryArray::Mesh(*arrays), name).map_err(FileFault::into_error)?;
        Ok(FacetFile::new(mesh))
    }

    fn new(mesh: MeshData) -> FacetFile {
        let mut facets = vec![Vec::new(); mesh.face_count];
        let mut names = vec![String::new(); mesh.face_count];
        for face in &mesh.faces {
            let (corners, count) = face.plate.corners();
            facets[face.face].push(corners[..count].to_vec());
            names[face.face].clone_from(&mesh.materials[face.material].name);
        }
        let mut notes = mesh.notes;
        let cut =
            |m: &usize| mesh.materials[*m].alpha.is_some() && mesh.faces.iter().any(|f| f.material == *m);
        if let Some(m) = (0..mesh.materials.len()).find(cut) {
            let name = &mesh.materials[m].name;
            notes.push(format!(
                "material '{name}' has holes in its alpha; view factors take its faces as whole"
            ));
        }
        FacetFile { facets, names, notes }
    }
}
