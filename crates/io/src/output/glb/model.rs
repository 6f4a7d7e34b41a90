//! The contents of a GLB file.

use serde_json::Value;

/// The axis of the coordinates that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// y, as in glTF.
    Y,
    /// z.
    #[default]
    Z,
}

/// The contents of a file.
#[derive(Clone, Debug, Default)]
pub struct GlbModel {
    /// Name of the scene.
    pub name: String,
    /// The upward axis of positions, normals and cameras.
    pub up: UpAxis,
    /// Meshes; those without triangles are omitted.
    pub meshes: Vec<GlbMesh>,
    /// Materials; meshes refer to them by index.
    pub materials: Vec<GlbMaterial>,
    /// PNG files; materials refer to them by index. Texture coordinates repeat beyond 0 to 1, v runs down.
    pub pictures: Vec<Vec<u8>>,
    /// Cameras.
    pub cameras: Vec<GlbCamera>,
    /// Extra information about the scene: an object, or null for none.
    pub extras: Value,
}

/// Triangles of one material. Lists have one entry for each vertex, or none.
#[derive(Clone, Debug, Default)]
pub struct GlbMesh {
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
    /// Second texture coordinates, `TEXCOORD_1`, for a lightmap; only with `uvs`.
    pub lightmap_uvs: Vec<[f32; 2]>,
    /// Linear colours with opacity, 0 to 1, written in 16 bits; they multiply the material's base colour.
    pub colours: Vec<[f32; 4]>,
    /// Application-specific attributes by name; the format's underscore is added.
    pub values: Vec<(String, Vec<[f32; 3]>)>,
    /// Corners of each triangle, counter-clockwise as seen from the front.
    pub triangles: Vec<[u32; 3]>,
}

/// A material: by default a rough dielectric.
#[derive(Clone, Debug)]
pub struct GlbMaterial {
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
    /// Shown without lighting (KHR_materials_unlit).
    pub unlit: bool,
    /// Blended by its opacity.
    pub blend: bool,
    /// Roughness, 0 to 1.
    pub roughness: f32,
    /// Clear glass (KHR_materials_transmission, KHR_materials_volume).
    pub glass: Option<GlbGlass>,
}

impl GlbMaterial {
    /// A rough diffuse material of this linear colour.
    pub fn diffuse(name: impl Into<String>, colour: [f32; 3]) -> GlbMaterial {
        let [r, g, b] = colour;
        GlbMaterial {
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

/// A sheet of coloured glass: its transmittance in a band is colour^(thickness/distance).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlbGlass {
    /// Fraction of light that enters, 0 to 1.
    pub transmission: f32,
    /// Thickness, m.
    pub thickness: f32,
    /// Distance over which white light becomes `colour`, m, above 0.
    pub distance: f32,
    /// Linear colour after `distance`, 0 to 1.
    pub colour: [f32; 3],
}

/// A camera.
#[derive(Clone, Debug, PartialEq)]
pub struct GlbCamera {
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
    /// Near and far clipping distance, m.
    pub range: [f64; 2],
}
