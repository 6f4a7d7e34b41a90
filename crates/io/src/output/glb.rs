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
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;
use std::io::{self, Write};
use std::path::Path;

mod check;

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
    /// PNG files that materials name by index; texture coordinates repeat beyond [0,1]², v runs down.
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

/// Arrays to write, with the JSON that describes them.
#[derive(Default)]
struct Layout<'a> {
    views: Vec<Value>,
    accessors: Vec<Value>,
    parts: Vec<Part<'a>>,
    length: u64,
}

enum Part<'a> {
    Bytes(&'a [u8]),
    Floats3(&'a [[f32; 3]]),
    Floats2(&'a [[f32; 2]]),
    Colours(&'a [[f32; 4]]),
    Triangles(&'a [[u32; 3]]),
}

impl Part<'_> {
    fn size(&self) -> u64 {
        (match self {
            Part::Bytes(b) => b.len(),
            Part::Floats3(x) => 12 * x.len(),
            Part::Floats2(x) => 8 * x.len(),
            Part::Colours(x) => 8 * x.len(),
            Part::Triangles(x) => 12 * x.len(),
        }) as u64
    }
    fn write(&self, out: &mut impl Write) -> io::Result<()> {
        match self {
            Part::Bytes(b) => out.write_all(b),
            Part::Floats3(x) => x.as_flattened().iter().try_for_each(|v| out.write_all(&v.to_le_bytes())),
            Part::Floats2(x) => x.as_flattened().iter().try_for_each(|v| out.write_all(&v.to_le_bytes())),
            Part::Triangles(x) => x.as_flattened().iter().try_for_each(|v| out.write_all(&v.to_le_bytes())),
            Part::Colours(x) => x.as_flattened().iter().try_for_each(|v| {
                out.write_all(&((v.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes())
            }),
        }
    }
}

const FLOAT: u32 = 5126;
const SHORT: u32 = 5123;
const INT: u32 = 5125;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

impl<'a> Layout<'a> {
    fn view(&mut self, part: Part<'a>, target: Option<u32>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.length, "byteLength": part.size() });
        if let Some(t) = target {
            view["target"] = t.into();
        }
        self.length += part.size().next_multiple_of(4);
        self.parts.push(part);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, part: Part<'a>, target: u32, kind: &str, component: u32, count: usize) -> usize {
        let view = self.view(part, Some(target));
        let mut accessor =
            json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        if component == SHORT {
            accessor["normalized"] = true.into();
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn mesh(&mut self, m: &'a Mesh) -> Value {
        let n = m.positions.len();
        let mut attributes = Map::new();
        let at = self.accessor(Part::Floats3(&m.positions), VERTICES, "VEC3", FLOAT, n);
        let (lo, hi) = bounds(&m.positions);
        (self.accessors[at]["min"], self.accessors[at]["max"]) = (json!(lo), json!(hi));
        attributes.insert("POSITION".into(), at.into());
        if !m.normals.is_empty() {
            let at = self.accessor(Part::Floats3(&m.normals), VERTICES, "VEC3", FLOAT, n);
            attributes.insert("NORMAL".into(), at.into());
        }
        if !m.uvs.is_empty() {
            let at = self.accessor(Part::Floats2(&m.uvs), VERTICES, "VEC2", FLOAT, n);
            attributes.insert("TEXCOORD_0".into(), at.into());
        }
        if !m.colours.is_empty() {
            let at = self.accessor(Part::Colours(&m.colours), VERTICES, "VEC4", SHORT, n);
            attributes.insert("COLOR_0".into(), at.into());
        }
        for (name, values) in &m.values {
            let at = self.accessor(Part::Floats3(values), VERTICES, "VEC3", FLOAT, n);
            attributes.insert(format!("_{name}"), at.into());
        }
        let indices =
            self.accessor(Part::Triangles(&m.triangles), INDICES, "SCALAR", INT, 3 * m.triangles.len());
        let mut primitive = json!({ "attributes": attributes, "indices": indices, "mode": 4 });
        if let Some(i) = m.material {
            primitive["material"] = i.into();
        }
        json!({ "name": m.name, "primitives": [primitive] })
    }
}

/// Writes a model as GLB. Lists of other lengths than the positions', indices out of range and values that are not numbers are refused.
pub fn write_glb(path: &Path, model: &Model) -> Result<(), FileError> {
    check::model(path, model)?;
    let mut layout = Layout::default();
    let json = document(model, &mut layout).to_string().into_bytes();
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

fn document<'a>(model: &'a Model, layout: &mut Layout<'a>) -> Value {
    let shown: Vec<&Mesh> = model.meshes.iter().filter(|m| !m.triangles.is_empty()).collect();
    let meshes: Vec<Value> = shown.iter().map(|m| layout.mesh(m)).collect();
    let mut nodes: Vec<Value> =
        shown.iter().enumerate().map(|(i, m)| json!({ "name": m.name, "mesh": i })).collect();
    for (i, c) in model.cameras.iter().enumerate() {
        nodes.push(json!({ "name": c.name, "camera": i, "matrix": placed(c) }));
    }
    let children: Vec<usize> = (0..nodes.len()).collect();
    let roots = if model.up == Up::Z && !nodes.is_empty() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        nodes.push(json!({ "name": "z up", "rotation": [-half, 0.0, 0.0, half], "children": children }));
        vec![nodes.len() - 1]
    } else {
        children
    };
    let images: Vec<Value> = (model.pictures.iter())
        .map(|p| json!({ "bufferView": layout.view(Part::Bytes(p), None), "mimeType": "image/png" }))
        .collect();
    let generator = format!("zonal {}", env!("CARGO_PKG_VERSION"));
    let mut used = BTreeSet::new();
    let materials: Vec<Value> = model.materials.iter().map(|m| material(m, &mut used)).collect();
    let mut scene = Map::from_iter([("name".to_string(), json!(model.name))]);
    if !roots.is_empty() {
        scene.insert("nodes".into(), json!(roots));
    }
    if !model.extras.is_null() {
        scene.insert("extras".into(), model.extras.clone());
    }
    let mut root =
        json!({ "asset": { "version": "2.0", "generator": generator }, "scene": 0, "scenes": [scene] });
    let mut put = |key: &str, list: Vec<Value>| {
        if !list.is_empty() {
            root[key] = list.into();
        }
    };
    put("textures", (0..images.len()).map(|i| json!({ "source": i, "sampler": 0 })).collect());
    if !images.is_empty() {
        put(
            "samplers",
            vec![json!({ "magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497 })],
        );
    }
    put("images", images);
    put("meshes", meshes);
    put("nodes", nodes);
    put("materials", materials);
    put("cameras", model.cameras.iter().map(lens).collect());
    put("extensionsUsed", used.into_iter().map(Value::from).collect());
    put("bufferViews", std::mem::take(&mut layout.views));
    put("accessors", std::mem::take(&mut layout.accessors));
    if layout.length > 0 {
        put("buffers", vec![json!({ "byteLength": layout.length })]);
    }
    root
}

fn material(m: &Material, used: &mut BTreeSet<&'static str>) -> Value {
    let mut pbr =
        json!({ "baseColorFactor": m.colour, "metallicFactor": 0.0, "roughnessFactor": m.roughness });
    if let Some(i) = m.picture {
        pbr["baseColorTexture"] = json!({ "index": i });
    }
    let mut out = json!({ "name": m.name, "pbrMetallicRoughness": pbr });
    let mut extensions = Map::new();
    let mut extend = |name: &'static str, value: Value| {
        used.insert(name);
        extensions.insert(name.into(), value);
    };
    let strength = m.emissive.iter().fold(1.0f32, |a, b| a.max(*b));
    if m.emissive != [0.0; 3] || m.emissive_picture.is_some() {
        out["emissiveFactor"] = json!(m.emissive.map(|e| e / strength));
        if let Some(i) = m.emissive_picture {
            out["emissiveTexture"] = json!({ "index": i });
        }
        if strength > 1.0 {
            extend("KHR_materials_emissive_strength", json!({ "emissiveStrength": strength }));
        }
    }
    if m.double_sided {
        out["doubleSided"] = true.into();
    }
    if m.blend {
        out["alphaMode"] = "BLEND".into();
    }
    if m.unlit {
        extend("KHR_materials_unlit", json!({}));
    }
    if let Some(g) = &m.glass {
        extend("KHR_materials_transmission", json!({ "transmissionFactor": g.transmission }));
        let volume = json!({ "thicknessFactor": g.thickness, "attenuationDistance": g.distance, "attenuationColor": g.colour });
        extend("KHR_materials_volume", volume);
    }
    if !extensions.is_empty() {
        out["extensions"] = extensions.into();
    }
    out
}

fn lens(c: &View) -> Value {
    let vertical = 2.0 * ((0.5 * c.fov.to_radians()).tan() / c.aspect).atan();
    json!({ "name": c.name, "type": "perspective", "perspective":
        { "yfov": vertical, "aspectRatio": c.aspect, "znear": c.range[0], "zfar": c.range[1] } })
}

/// The camera's frame: it looks along its own −z, y up; column by column.
fn placed(c: &View) -> [f64; 16] {
    let v = zonal_math::Vec3::from_array;
    let back = (v(c.origin) - v(c.target)).normalized();
    let side = v(c.up).cross(back);
    let right = if side.length() > 1e-9 { side.normalized() } else { back.frame().0 };
    let up = back.cross(right);
    let mut m = [0.0; 16];
    for (k, axis) in [right, up, back, v(c.origin)].iter().enumerate() {
        m[4 * k..4 * k + 3].copy_from_slice(&axis.array());
    }
    m[15] = 1.0;
    m
}

fn bounds(p: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    p.iter().fold(([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]), |(lo, hi), p| {
        ([0, 1, 2].map(|k| lo[k].min(p[k])), [0, 1, 2].map(|k| hi[k].max(p[k])))
    })
}

#[cfg(test)]
mod tests;
