//! glTF 2.0: nodes, primitives and materials of diffuse surfaces and panes.
//!
//! Reference: the Khronos glTF 2.0 specification and KHR_materials_{emissive_strength, pbrSpecularGlossiness, transmission, unlit, volume},
//! KHR_texture_transform, KHR_mesh_quantization, KHR_draco_mesh_compression, EXT_meshopt_compression, KHR_lights_punctual. The y axis stays up: turn with `rotate_degrees = [90, 0, 0]`.
//!
//! | module | contents |
//! |---|---|
//! | `container`, `accessors` | GLB chunks and URIs; buffers and accessors with checked bounds |
//! | `compression` | geometry compressed by Draco and meshopt |
//! | `document`, `nodes`, `primitives` | the validated JSON; the node tree; faces |
//! | `cameras` | perspective cameras |
//! | `broken_textures` | textures, images and samplers that name what is not there |
//! | `materials`, `specular_glossiness`, `texture_mapping` | materials as surfaces and panes; texture coordinates |
//! | `material_notes` | properties of materials that are not read |
//! | `lights` | lights of nodes |

mod accessors;
mod broken_textures;
mod cameras;
mod compression;
mod container;
mod document;
mod lights;
mod material_notes;
mod materials;
mod nodes;
mod primitives;
mod sheets;
mod specular_glossiness;
mod texture_mapping;

use crate::files::FileSource;
use crate::input::mesh::model::MeshData;
use crate::input::reading::error::FileFault;
use accessors::Buffers;
use primitives::PrimitiveReader;
use std::collections::{BTreeSet, HashMap};
use std::path::Path;

/// Reads a GLB or glTF file; `file` names it in messages.
pub(crate) fn read_mesh_file(files: FileSource<'_>, path: &Path, file: &str) -> Result<MeshData, FileFault> {
    let bytes = files.read(path, container::MAX_GLTF_FILE_BYTES).map_err(|e| FileFault::new(file, "", e))?;
    let (json, binary) = container::split_chunks(file, &bytes)?;
    let (document, notes) = document::parse_document(file, json)?;
    let buffers = Buffers::open(files, file, path, document.as_json(), json.len(), binary)?;
    let mut mesh = MeshData { notes, ..MeshData::default() };
    mesh.notes.extend(container::trailing_note(file, &bytes));
    mesh.notes.extend(document::unread_extensions(file, &document));
    let instances = nodes::node_instances(file, &document)?;
    let materials = materials::read_materials(&document, &instances, files, path, &buffers, &mut mesh)?;
    let mut reader = PrimitiveReader {
        buffers: &buffers,
        materials,
        mesh,
        skipped: 0,
        shown: 0,
        coloured: BTreeSet::new(),
        draco: HashMap::new(),
    };
    for instance in &instances {
        reader.read_node(&document, instance)?;
        reader.mesh.cameras.extend(cameras::camera_of_node(&document, instance));
    }
    let of_contents = reader.notes(&document, &instances);
    let mut mesh = reader.mesh;
    mesh.notes.extend(of_contents);
    cameras::name_uniquely(&mut mesh.cameras);
    let (lights, notes) = lights::read_lights(file, &document, &instances)?;
    mesh.lights = lights;
    mesh.notes.extend(notes);
    if mesh.faces.is_empty() {
        return Err(FileFault::new(
            file,
            "",
            "this file shows no triangles; export it again with its meshes",
        ));
    }
    Ok(mesh)
}
