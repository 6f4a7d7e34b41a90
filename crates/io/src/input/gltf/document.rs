//! The JSON of a glTF document, validated: indices in range, no required extension that is not read.

use crate::input::error::FileFault;
use gltf::Document;
use gltf::json::{Root, mesh::Semantic, validation::Checked};
use std::collections::BTreeSet;

/// Extensions that a file may require, besides those of materials.
const READ_EXTENSIONS: [&str; 3] = ["KHR_texture_transform", "KHR_mesh_quantization", "KHR_lights_punctual"];

/// Parses and validates the JSON of a document.
pub(super) fn parse_document(file: &str, json: &[u8]) -> Result<Document, FileFault> {
    let mut root: Root = gltf::json::deserialize::from_slice(json).map_err(|e| {
        let place = format!("JSON line {} column {}", e.line(), e.column());
        FileFault::new(file, place, format!("{e}; export the file again"))
    })?;
    let readable = |e: &str| e.starts_with("KHR_materials_") || READ_EXTENSIONS.contains(&e);
    if let Some(e) = root.extensions_required.iter().find(|e| !readable(e)) {
        let message = format!("this file needs the extension {e}, which is not read; export it without");
        return Err(FileFault::new(file, "extensionsRequired", message));
    }
    root.extensions_required.clear();
    // Drop attributes of applications; their names begin with an underscore.
    for primitive in root.meshes.iter_mut().flat_map(|m| &mut m.primitives) {
        primitive.attributes.retain(|name, _| matches!(name, Checked::Valid(_)));
    }
    check_positions(file, &mut root)?;
    Document::from_json(root).map_err(|e| match e {
        gltf::Error::Validation(list) => match list.first() {
            Some((path, defect)) => {
                let defect = defect.to_string().to_lowercase();
                FileFault::new(file, path, format!("{defect}; export the file again"))
            }
            None => FileFault::new(file, "", "this file is not valid glTF; export it again"),
        },
        e => FileFault::new(file, "", format!("{e}; export the file again")),
    })
}

/// Checks the accessors of positions, which the crate's validation indexes unchecked, and sets their min and max, which it requires and
/// many files lack; neither is read here.
fn check_positions(file: &str, root: &mut Root) -> Result<(), FileFault> {
    let primitives = root.meshes.iter().flat_map(|m| &m.primitives);
    let positions = primitives.filter_map(|p| p.attributes.get(&Checked::Valid(Semantic::Positions)));
    for index in positions.map(|i| i.value()).collect::<BTreeSet<_>>() {
        let Some(accessor) = root.accessors.get_mut(index) else {
            let message = "POSITION names an accessor that is not there; export the file again";
            return Err(FileFault::new(file, format!("accessor {index}"), message));
        };
        let unread = || Some(gltf::json::Value::from(vec![0.0; 3]));
        (accessor.min, accessor.max) = (unread(), unread());
    }
    Ok(())
}
