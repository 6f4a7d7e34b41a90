//! Reading of a mesh file by its extension.

use crate::files::FileSource;
use crate::input::mesh::mesh_arrays;
use crate::input::mesh::model::MeshData;
use crate::input::mesh::reflectance_limit::limit_reflectance;
use crate::input::mesh_files::converters::{self, FileContents};
use crate::input::mesh_files::{gltf, msh, obj, ply, stl, vtk_mesh};
use crate::input::reading::error::FileFault;
use crate::input::toml::surface_keys::PLACED_MESH;
use std::path::Path;

/// The extensions of the mesh formats that are read, as a phrase.
#[must_use]
pub fn mesh_extensions() -> &'static str {
    PLACED_MESH.file.spec.description
}

/// Largest OBJ file, bytes.
const MAX_OBJ_FILE_BYTES: u64 = 1 << 30;

/// Reads a mesh file by its extension, with limited reflectances; `file` names it in messages.
pub(crate) fn read_mesh_file(files: FileSource<'_>, path: &Path, file: &str) -> Result<MeshData, FileFault> {
    let mut mesh = read_by_extension(files, path, file)?;
    mesh.materials.iter_mut().for_each(limit_reflectance);
    Ok(mesh)
}

fn read_by_extension(files: FileSource<'_>, path: &Path, file: &str) -> Result<MeshData, FileFault> {
    if let Some(memory) = files.array(path) {
        return mesh_arrays::mesh(&memory, file);
    }
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("vtu" | "vtp") => vtk_mesh::read_mesh_file(files, path, file),
        Some("glb" | "gltf") => gltf::read_mesh_file(files, path, file),
        Some("msh") => msh::read_mesh_file(files, path, file),
        Some("ply") => ply::read_mesh_file(files, path, file),
        Some("stl") => stl::read_mesh_file(files, path, file),
        Some("obj") => {
            let bytes = files.read(path, MAX_OBJ_FILE_BYTES).map_err(|e| FileFault::new(file, "", e))?;
            if bytes.contains(&0) {
                return Err(FileFault::new(file, "", "this is not an OBJ text; export the mesh again"));
            }
            obj::parse(files, path, file, &String::from_utf8_lossy(&bytes))
        }
        _ => {
            let known = converters::conversion_hint(path, FileContents::Mesh);
            let other = || format!("this kind of mesh is not read; convert it to {}", mesh_extensions());
            Err(FileFault::new(file, "", known.unwrap_or_else(other)))
        }
    }
}
