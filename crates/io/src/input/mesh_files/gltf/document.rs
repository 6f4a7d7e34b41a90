//! The JSON of a glTF document, validated: indices in range, no required extension that is not read.

use super::broken_textures;
use super::compression::{DRACO, MESHOPT, draco_extension, draco_view};
use super::material_notes::{MAX_EXTENSION_NAME, MAX_EXTENSIONS};
use crate::input::reading::error::FileFault;
use gltf::Document;
use gltf::json::{Index, Root, mesh::Semantic, validation::Checked};
use serde_json::Value;
use std::collections::BTreeSet;

/// Extensions that a file may require, besides those of materials.
const READ_EXTENSIONS: [&str; 5] =
    ["KHR_texture_transform", "KHR_mesh_quantization", "KHR_lights_punctual", DRACO, MESHOPT];

/// Extensions that are not read, with commands of glTF Transform 4 that write a file without them.
const CONVERSIONS: [(&str, &str); 4] = [
    ("KHR_meshopt_compression", "npx @gltf-transform/cli copy in.glb out.glb"),
    ("EXT_texture_webp", "npx @gltf-transform/cli png in.glb out.glb --formats \"*\""),
    ("EXT_texture_avif", "npx @gltf-transform/cli png in.glb out.glb --formats \"*\""),
    ("KHR_texture_basisu", "npx @gltf-transform/cli ktxdecompress in.glb out.glb (with ktx of KTX-Software)"),
];

/// Consequences of extensions that are not read: the name and the text of the note.
const LOSSES: [(&str, &str); 2] = [
    (
        "EXT_mesh_gpu_instancing",
        "each mesh stands once in place of its instances; write an object for each instance",
    ),
    ("KHR_node_visibility", "hidden nodes are read too; delete them from the file"),
];
/// Most broken references that have notes of their own.
const MAX_NOTED_DEFECTS: usize = 16;

/// True for an extension that is read, or whose materials have notes of their own.
fn is_read(extension: &str) -> bool {
    extension.starts_with("KHR_materials_") || READ_EXTENSIONS.contains(&extension)
}

/// Notes of extensions that a document uses without need, and that are not read. Those of materials have notes with their materials.
pub(super) fn unread_extensions(file: &str, document: &Document) -> Vec<String> {
    let of_material = |e: &str| document.materials().any(|m| m.extension_value(e).is_some());
    let unread = document.extensions_used().filter(|e| !is_read(e) && !of_material(e));
    let unread = unread.take(MAX_EXTENSIONS);
    let note = |extension: &str| {
        let loss = LOSSES.iter().find(|(name, _)| *name == extension).map(|(_, loss)| format!(": {loss}"));
        let name: String = extension.chars().take(MAX_EXTENSION_NAME).collect();
        format!("{file}: the extension {name} is not read{}", loss.unwrap_or_default())
    };
    unread.map(note).collect()
}

/// Parses and validates the JSON of a document. Broken references of textures do not make it invalid; they are returned as notes.
pub(super) fn parse_document(file: &str, json: &[u8]) -> Result<(Document, Vec<String>), FileFault> {
    let parsed = gltf::json::deserialize::from_slice(json).map_err(|e| json_fault(file, &e));
    let fault = match parsed.and_then(|root| validated(file, root)) {
        Ok(document) => return Ok((document, Vec::new())),
        Err(fault) => fault,
    };
    // Repair textures only where the document is not valid, which takes a second reading.
    let Ok(mut value) = serde_json::from_slice::<Value>(json) else { return Err(fault) };
    let defects = broken_textures::repair(&mut value);
    if defects.is_empty() {
        return Err(fault);
    }
    let root = match serde_json::from_value(value) {
        Ok(root) => root,
        // The defect of before has a line.
        Err(e) if fault.to_string().contains(&e.to_string()) => return Err(fault),
        Err(e) => return Err(json_fault(file, &e)),
    };
    let document = validated(file, root)?;
    let rest = defects.len().saturating_sub(MAX_NOTED_DEFECTS);
    let mut notes: Vec<String> = defects.into_iter().take(MAX_NOTED_DEFECTS).collect();
    notes.iter_mut().for_each(|defect| *defect = format!("{file}: {defect}; it is not used"));
    if rest > 0 {
        notes.push(format!("{file}: {rest} further textures, images or samplers are broken, and not used"));
    }
    Ok((document, notes))
}

fn json_fault(file: &str, e: &serde_json::Error) -> FileFault {
    let place = match e.line() {
        0 => "JSON".to_string(),
        line => format!("JSON line {line} column {}", e.column()),
    };
    FileFault::new(file, place, format!("{e}; export the file again"))
}

/// The validated document of a parsed JSON.
fn validated(file: &str, mut root: Root) -> Result<Document, FileFault> {
    if let Some(e) = root.extensions_required.iter().find(|e| !is_read(e)) {
        let command = CONVERSIONS.iter().find(|(name, _)| name == e).map(|(_, command)| *command);
        let remedy = command.map_or("export it without".to_string(), |c| format!("convert it: {c}"));
        let message = format!("this file needs the extension {e}, which is not read; {remedy}");
        return Err(FileFault::new(file, "extensionsRequired", message));
    }
    root.extensions_required.clear();
    // Drop attributes of applications; their names begin with an underscore.
    for primitive in root.meshes.iter_mut().flat_map(|m| &mut m.primitives) {
        primitive.attributes.retain(|name, _| matches!(name, Checked::Valid(_)));
    }
    check_positions(file, &mut root)?;
    place_draco_accessors(&mut root);
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

/// Gives the accessors of primitives that Draco compresses the buffer view of its data, since the crate's validation requires one; their values come from
/// the decoded data.
fn place_draco_accessors(root: &mut Root) {
    for primitive in root.meshes.iter().flat_map(|m| &m.primitives) {
        let view = draco_extension(primitive).and_then(draco_view).and_then(|v| u32::try_from(v).ok());
        let Some(view) = view else { continue };
        for index in primitive.attributes.values().chain(&primitive.indices) {
            if let Some(accessor) = root.accessors.get_mut(index.value()) {
                accessor.buffer_view.get_or_insert(Index::new(view));
            }
        }
    }
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
