//! Notes about properties of glTF materials that are not read, one for each property and material; those of a property are merged where they are printed.

use super::sheets::{DIFFUSE_TRANSMISSION, MIN_ROUGHNESS};
use super::specular_glossiness::SPECULAR_GLOSSINESS;

/// Longest name of an extension in a note, characters.
pub(super) const MAX_EXTENSION_NAME: usize = 48;
/// Most extensions of a material, or of a file, that have notes.
pub(super) const MAX_EXTENSIONS: usize = 16;

/// The properties of a material that are not read.
pub(super) fn ignored_properties(m: &gltf::Material<'_>) -> Vec<String> {
    let mut out = Vec::new();
    let pbr = m.pbr_metallic_roughness();
    let (metallic, rough) = (pbr.metallic_factor() > 0.0, f64::from(pbr.roughness_factor()) >= MIN_ROUGHNESS);
    let has_specular_glossiness = m.extension_value(SPECULAR_GLOSSINESS).is_some();
    let is_lit = !m.unlit() && !has_specular_glossiness;
    if is_lit && pbr.metallic_roughness_texture().is_some() && (metallic || pbr.roughness_factor() > 0.0) {
        out.push("its metallic-roughness texture is not read, and it is diffuse".into());
    } else if is_lit && metallic && m.transmission().is_none() {
        out.push("it is metallic, and was read as diffuse".into());
    } else if is_lit && !rough && m.transmission().is_none() {
        out.push(format!("its gloss (roughness below {MIN_ROUGHNESS}) is not read, and it is diffuse"));
    }
    if m.occlusion_texture().is_some() {
        out.push("its occlusion texture is not read, since the solve finds what it shows".into());
    }
    if has_specular_glossiness {
        out.push("its specular colour and glossiness are not read, and it is diffuse".into());
    }
    let extensions = m.extensions().into_iter().flatten().map(|(name, _)| name.as_str());
    let is_read = |name: &&str| ![DIFFUSE_TRANSMISSION, SPECULAR_GLOSSINESS].contains(name);
    out.extend(extensions.filter(is_read).take(MAX_EXTENSIONS).map(|name| {
        let name: String = name.chars().take(MAX_EXTENSION_NAME).collect();
        format!("{name} is not read")
    }));
    out
}
