//! glTF 2.0 as one binary file (GLB): meshes, materials, textures and cameras.
//!
//! ```text
//! header   "glTF", 2, length                                  u32 each, little-endian
//! chunk    length, "JSON", text padded with blanks to 4 bytes
//! chunk    length, "BIN\0", arrays one after the other, each at a multiple of 4 bytes
//! ```
//!
//! A [`GlbModel`] is independent of solutions: triangles and their colours. Coordinates are written unchanged; a model with
//! [`UpAxis::Z`] hangs below one node that turns its z axis up, since y is up in glTF. Each mesh becomes a node of its own, so that
//! programs list it by name. Colours and factors are linear, textures sRGB, as the format requires.
//!
//! Reference: the Khronos glTF 2.0 specification, KHR_materials_{unlit, emissive_strength, transmission, volume, ior}.

mod json;
mod layout;
mod model;
mod validation;

pub use model::{GlbCamera, GlbGlass, GlbMaterial, GlbMesh, GlbModel, UpAxis};

use super::atomic::write_atomic;
use super::error::FileError;
use layout::BinaryLayout;
use std::io::Write;
use std::path::Path;

/// Writes a model as GLB.
///
/// # Errors
///
/// A list has another length than the positions, an index is out of range, a value is not finite, the file would exceed 4 GiB, or it
/// cannot be written.
///
/// ```
/// use zonal_io::output::glb::{GlbMesh, GlbModel, write_glb};
///
/// let triangle = GlbMesh {
///     positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
///     triangles: vec![[0, 1, 2]],
///     ..GlbMesh::default()
/// };
/// let path = std::env::temp_dir().join(format!("zonal-doc-{}.glb", std::process::id()));
/// write_glb(&path, &GlbModel { meshes: vec![triangle], ..GlbModel::default() })?;
/// assert!(std::fs::read(&path).unwrap().starts_with(b"glTF"));
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), zonal_io::output::FileError>(())
/// ```
pub fn write_glb(path: &Path, model: &GlbModel) -> Result<(), FileError> {
    validation::check_model(path, model)?;
    let mut layout = BinaryLayout::default();
    let json = json::document(model, &mut layout).to_string().into_bytes();
    let text = json.len().next_multiple_of(4) as u64;
    let binary = if layout.length == 0 { 0 } else { 8 + layout.length };
    let Ok(total) = u32::try_from(12 + 8 + text + binary) else {
        let message = "more than the 4 GiB that a GLB may have; export fewer vertices";
        return Err(FileError::new(path, "", message));
    };
    write_atomic(path, |out| {
        let word = |x: u64| (x as u32).to_le_bytes();
        out.write_all(b"glTF")?;
        out.write_all(&[word(2), word(total as u64), word(text), *b"JSON"].concat())?;
        out.write_all(&json)?;
        out.write_all(&b"   "[..text as usize - json.len()])?;
        if layout.length > 0 {
            out.write_all(&[word(layout.length), *b"BIN\0"].concat())?;
        }
        for part in &layout.parts {
            part.write(out)?;
            out.write_all(&[0; 3][..(part.size().next_multiple_of(4) - part.size()) as usize])?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests;
