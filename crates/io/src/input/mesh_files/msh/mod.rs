//! Gmsh meshes (.msh), versions 2.x, 4.0 and 4.1, as text or in binary form of either byte order.
//!
//! | in the file | in the mesh |
//! |---|---|
//! | triangles and quadrilaterals of any order | faces by their corner nodes; a note counts those of higher order, which become flat |
//! | physical group of dimension 2 | material: its name in `$PhysicalNames`, else `physical-N`; `ungrouped` without a group |
//! | group of an entity with a minus sign (4.x) | its faces are turned; in 2.x Gmsh has turned them |
//! | tetrahedra, hexahedra, prisms, pyramids | where the file has no face: the sides that belong to one element, turned outward, with the physical group of dimension 3 as material |
//! | an element for each of several groups | the first one; a note counts the others |
//! | other sections | passed over |
//!
//! Reference: C. Geuzaine, J.-F. Remacle, Gmsh reference manual, sections "MSH file format" and "Legacy formats"; node orders of section "Node ordering".
//!
//! | module | contents |
//! |---|---|
//! | `element_types` | shapes and numbers of nodes |
//! | `content` | nodes, elements and groups as the file gives them |
//! | `sections` | the sections of all versions; `legacy_sections`, `entity_sections`: of 2.x and of 4.x |
//! | `values` | values that the sections share |
//! | `faces`, `boundary` | faces of elements as polygons; the boundary of volumes |

mod boundary;
mod content;
mod element_types;
mod entity_sections;
mod faces;
mod legacy_sections;
mod sections;
mod values;

use crate::files::FileSource;
use crate::input::mesh::model::MeshData;
use crate::input::reading::error::FileFault;
use std::path::Path;

/// Largest file, bytes.
const MAX_MSH_FILE_BYTES: u64 = 1 << 30;

/// Reads a file of Gmsh; `file` names it in messages.
pub(crate) fn read_mesh_file(files: FileSource<'_>, path: &Path, file: &str) -> Result<MeshData, FileFault> {
    let bytes = files.read(path, MAX_MSH_FILE_BYTES).map_err(|e| FileFault::new(file, "", e))?;
    let content = sections::read(file, &bytes)?;
    drop(bytes);
    faces::mesh(file, &content)
}
