//! glTF 2.0 as one binary file (GLB): meshes, materials, pictures and cameras, for every engine and viewer.
//!
//! ```text
//! header   "glTF", 2, length                                  u32 each, little-endian
//! chunk    length, "JSON", text padded with blanks to 4 bytes
//! chunk    length, "BIN\0", arrays one after the other, each at a multiple of 4 bytes
//! ```
//!
//! Nothing here knows a solution: a [`Model`] is triangles with what colours them. Coordinates are written as they are; a model
//! with [`Up::Z`] hangs below one node that turns its z axis up, as glTF wants y there. A mesh becomes a node of its own, so that the
//! engines' lists show its name. Colours and factors are linear, pictures sRGB, as the format demands.
//!
//! Reference: the Khronos glTF 2.0 specification, KHR_materials_{unlit, emissive_strength, transmission, volume, ior}.

use super::FileError;
use super::atomic::write_atomic;
use serde_json::Value;
use std::io::Write;
use std::path::Path;

mod check;
mod json;
mod layout;

use layout::Layout;

/// Which axis of the coordinates points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// y, as in glTF.
    Y,
    /// z.
    #[default]
    Z,
}

/// What a file holds.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Name of the scene.
    pub name: String,
    /// Which axis of positions, normals and cameras points up.
    pub up: Up,
    /// Meshes; those without triangles are left out.
    pub meshes: Vec<Mesh>,
    /// Materials that meshes name by index.
    pub materials: Vec<Material>,
    /// PNG files that materials name by index; texture coordinates repeat beyond 0 to 1, v runs down.
    pub pictures: Vec<Vec<u8>>,
    /// Cameras.
    pub cameras: Vec<View>,
    /// What else to say about the scene; an object, or null for nothing.
    pub extras: Value,
}

/// Triangles of one material. Lists have one entry a vertex or none at all.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name of mesh and node.
    pub name: String,
    /// Index of the material; `None` for the format's own white one.
    pub material: Option<usize>,
    /// Positions, m.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates.
    pub uvs: Vec<[f32; 2]>,
    /// Linear colours with opacity, 0 to 1, written in 16 bits; they multiply the material's base colour.
    pub colours: Vec<[f32; 4]>,
    /// Values of one's own by name; the name gets an underscore before it, as the format wants.
    pub values: Vec<(String, Vec<[f32; 3]>)>,
    /// Corners of each triangle, counter-clockwise as seen from the front.
    pub triangles: Vec<[u32; 3]>,
}

/// What a mesh is made of: a rough dielectric unless something else is said.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name.
    pub name: String,
    /// Linear base colour and opacity, 0 to 1.
    pub colour: [f32; 4],
    /// Index of the picture that multiplies it.
    pub picture: Option<usize>,
    /// Linear emitted colour, from 0; above 1 by KHR_materials_emissive_strength.
    pub emissive: [f32; 3],
    /// Index of the picture that multiplies it.
    pub emissive_picture: Option<usize>,
    /// Seen from both sides.
    pub double_sided: bool,
    /// Shown as it is, without lights (KHR_materials_unlit).
    pub unlit: bool,
    /// Let through by opacity.
    pub blend: bool,
    /// Roughness, 0 to 1.
    pub roughness: f32,
    /// Clear glass (KHR_materials_transmission, KHR_materials_volume).
    pub glass: Option<Glass>,
}

impl Material {
    /// A rough diffuse material of this linear colour.
    pub fn diffuse(name: impl Into<String>, colour: [f32; 3]) -> Material {
        let [r, g, b] = colour;
        Material {
            name: name.into(),
            colour: [r, g, b, 1.0],
            picture: None,
            emissive: [0.0; 3],
            emissive_picture: None,
            double_sided: false,
            unlit: false,
            blend: false,
            roughness: 1.0,
            glass: None,
        }
    }
}

/// A sheet of coloured glass: over `thickness` light of a band falls to colour^(thickness/distance).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glass {
    /// Share of light that enters, 0 to 1.
    pub transmission: f32,
    /// Thickness, m.
    pub thickness: f32,
    /// Distance after which `colour` is left of white light, m, above 0.
    pub distance: f32,
    /// Linear colour after `distance`, 0 to 1.
    pub colour: [f32; 3],
}

/// A camera.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Name.
    pub name: String,
    /// Pinhole, m.
    pub origin: [f64; 3],
    /// A point in the middle of the picture, m.
    pub target: [f64; 3],
    /// Upward direction.
    pub up: [f64; 3],
    /// Full angle of view across the picture's width, degrees.
    pub fov: f64,
    /// Width of the picture over its height.
    pub aspect: f64,
    /// Distances between which things are shown, m.
    pub range: [f64; 2],
}

/// Writes a model as GLB. Lists of other lengths than the positions', indices out of range and values that are not numbers are refused.
pub fn write_glb(path: &Path, model: &Model) -> Result<(), FileError> {
    check::model(path, model)?;
    let mut layout = Layout::default();
    let json = json::document(model, &mut layout).to_string().into_bytes();
    let text = json.len().next_multiple_of(4) as u64;
    let binary = if layout.length == 0 { 0 } else { 8 + layout.length };
    let Ok(total) = u32::try_from(12 + 8 + text + binary) else {
        let what = "more than the 4 GiB that a GLB may have; export fewer vertices";
        return Err(FileError::new(path, "", what));
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
