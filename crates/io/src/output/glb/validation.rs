//! Validation of a model before a byte is written.

use super::model::{GlbCamera, GlbMaterial, GlbMesh, GlbModel};
use crate::output::error::FileError;
use std::path::Path;

/// Refuses a model that would make an invalid file.
pub(super) fn check_model(path: &Path, model: &GlbModel) -> Result<(), FileError> {
    let fail = |entry: String, message: String| Err(FileError::new(path, entry, message));
    for (i, m) in model.meshes.iter().enumerate() {
        if let Some(message) = mesh_defect(m, model.materials.len()) {
            return fail(format!("mesh {i} '{}'", m.name), message);
        }
    }
    for (i, m) in model.materials.iter().enumerate() {
        if let Some(message) = material_defect(m, model.pictures.len()) {
            return fail(format!("material {i} '{}'", m.name), message);
        }
    }
    for (i, p) in model.pictures.iter().enumerate() {
        if !p.starts_with(b"\x89PNG\r\n\x1a\n") {
            return fail(format!("picture {i}"), "is no PNG file; encode it as one".into());
        }
    }
    for (i, c) in model.cameras.iter().enumerate() {
        if let Some(message) = camera_defect(c) {
            return fail(format!("camera {i} '{}'", c.name), message);
        }
    }
    Ok(())
}

/// The first defect of a mesh.
fn mesh_defect(m: &GlbMesh, materials: usize) -> Option<String> {
    let n = m.positions.len();
    let lists = [
        ("normals", m.normals.len()),
        ("uvs", m.uvs.len()),
        ("lightmap_uvs", m.lightmap_uvs.len()),
        ("colours", m.colours.len()),
    ];
    let own = m.values.iter().map(|(name, v)| (name.as_str(), v.len()));
    for (name, len) in lists.into_iter().filter(|l| l.1 != 0).chain(own) {
        if len != n {
            return Some(format!("{len} {name} for {n} positions; give one a position"));
        }
    }
    if !m.lightmap_uvs.is_empty() && m.uvs.is_empty() {
        return Some("lightmap_uvs without uvs; give both".into());
    }
    let finite = |list: &[f32]| list.iter().all(|x| x.is_finite());
    let numbers = finite(m.positions.as_flattened())
        && finite(m.normals.as_flattened())
        && finite(m.uvs.as_flattened())
        && finite(m.lightmap_uvs.as_flattened())
        && finite(m.colours.as_flattened())
        && m.values.iter().all(|(_, v)| finite(v.as_flattened()));
    if !numbers {
        return Some("a value is not finite".into());
    }
    let not_unit = |v: &&[f32; 3]| (v.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() > 1e-3;
    if let Some(v) = m.normals.iter().find(not_unit) {
        return Some(format!("the normal {v:?} has not the length 1"));
    }
    if let Some(i) = m.triangles.as_flattened().iter().find(|i| **i as usize >= n) {
        return Some(format!("a triangle names vertex {i}, but there are {n}"));
    }
    if let Some((name, _)) = m.values.iter().find(|(s, _)| s.is_empty() || !s.bytes().all(is_name_byte)) {
        return Some(format!("'{name}' is no name for values; use capitals, digits and underscores"));
    }
    m.material.filter(|i| *i >= materials).map(|i| format!("names material {i}, but there are {materials}"))
}

/// True for a character of an attribute name.
fn is_name_byte(b: u8) -> bool {
    b.is_ascii_uppercase() || b.is_ascii_digit() || b == b'_'
}

/// The first defect of a material.
fn material_defect(m: &GlbMaterial, pictures: usize) -> Option<String> {
    let unit = |list: &[f32]| list.iter().all(|x| (0.0..=1.0).contains(x));
    let named = [m.picture, m.emissive_picture].into_iter().flatten();
    if let Some(i) = named.into_iter().find(|i| *i >= pictures) {
        return Some(format!("names picture {i}, but there are {pictures}"));
    }
    if !unit(&m.colour) || !unit(&[m.roughness]) {
        return Some("colour, opacity and roughness must lie between 0 and 1".into());
    }
    if !m.emissive.iter().all(|x| x.is_finite() && *x >= 0.0) {
        return Some("the emitted colour must be finite and not negative".into());
    }
    let g = m.glass?;
    let valid = unit(&g.colour)
        && unit(&[g.transmission])
        && g.thickness.is_finite()
        && g.thickness >= 0.0
        && g.distance.is_finite()
        && g.distance > 0.0;
    (!valid).then(|| "glass needs a colour from 0 to 1, a thickness from 0 and a distance above 0".into())
}

/// The first defect of a camera.
fn camera_defect(c: &GlbCamera) -> Option<String> {
    let finite = c.origin.iter().chain(&c.target).chain(&c.up).all(|x| x.is_finite());
    if !finite || c.origin == c.target {
        return Some("origin, target and up must be finite, and the target not the origin".into());
    }
    let valid_view = c.fov > 0.0 && c.fov < 180.0 && c.aspect > 0.0 && c.aspect.is_finite();
    let [near, far] = c.range;
    let valid_range = near > 0.0 && far > near && far.is_finite();
    (!(valid_view && valid_range))
        .then(|| "fov, aspect and range must be positive and finite, fov below 180".into())
}
