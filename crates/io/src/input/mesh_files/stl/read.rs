//! Reading of an STL file: text or binary, as facets or as a mesh.

use super::facets::{StlBuilder, StlFacet, StlFile};
use super::{ascii, binary};
use crate::files::{self, FileSource};
use crate::input::mesh::model::{MeshData, MeshFace, MeshMaterial};
use crate::input::reading::error::{FileFault, InputError};
use std::path::Path;
use zonal_scene::Plate;

/// Largest file, bytes.
const MAX_STL_FILE_BYTES: u64 = 1 << 30;

/// Reads an STL file.
///
/// # Errors
///
/// The file cannot be read, is cut short, has a number that is not finite, or has no facet with an area.
///
/// ```
/// let path = std::env::temp_dir().join(format!("zonal-doc-stl-{}.stl", std::process::id()));
/// let facet = "facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet";
/// std::fs::write(&path, format!("solid floor\n{facet}\nendsolid floor\n"))?;
/// let stl = zonal_io::input::read_stl(&path)?;
/// assert_eq!((stl.facets.len(), stl.parts), (1, vec!["floor".to_string()]));
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_stl(path: &Path) -> Result<StlFile, InputError> {
    let file = path.display().to_string();
    let bytes =
        files::read(path, MAX_STL_FILE_BYTES).map_err(|e| FileFault::new(&file, "", e).into_error())?;
    parse(&file, &bytes).map_err(FileFault::into_error)
}

/// Reads an STL as a mesh with a material for each part.
pub(crate) fn read_mesh_file(files: FileSource<'_>, path: &Path, file: &str) -> Result<MeshData, FileFault> {
    let bytes = files.read(path, MAX_STL_FILE_BYTES).map_err(|e| FileFault::new(file, "", e))?;
    let stl = parse(file, &bytes)?;
    let face = |f: &StlFacet| {
        let [a, b, c] = f.corners;
        MeshFace { plate: Plate::triangle(a, b, c), ..MeshFace::template(f.part, f.number) }
    };
    Ok(MeshData {
        lights: Vec::new(),
        materials: stl.parts.iter().map(|name| MeshMaterial::named(name)).collect(),
        faces: stl.facets.iter().map(face).collect(),
        face_count: stl.facet_count,
        notes: stl.notes,
        ..MeshData::default()
    })
}

/// The facets of the bytes of a file, which `file` names in messages.
fn parse(file: &str, bytes: &[u8]) -> Result<StlFile, FileFault> {
    let mut builder = StlBuilder::default();
    if !binary::has_declared_length(bytes) && is_text(bytes) {
        ascii::read(file, &String::from_utf8_lossy(bytes), &mut builder)?;
    } else {
        binary::read(file, bytes, &mut builder)?;
    }
    builder.finish(file)
}

/// True for bytes that begin as a text and hold no zero, which every binary file has.
fn is_text(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) && !bytes.contains(&0)
}
