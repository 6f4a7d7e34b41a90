//! The JSON chunk: scene, nodes, materials, cameras.

use super::layout::{ArrayData, BinaryLayout};
use super::model::{GlbCamera, GlbMaterial, GlbMesh, GlbModel, UpAxis};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

/// The JSON of a file.
pub(super) fn document<'a>(model: &'a GlbModel, layout: &mut BinaryLayout<'a>) -> Value {
    // Lay out the meshes.
    let shown: Vec<&GlbMesh> = model.meshes.iter().filter(|m| !m.triangles.is_empty()).collect();
    let meshes: Vec<Value> = shown.iter().map(|m| layout.add_mesh(m)).collect();
    let mut nodes: Vec<Value> =
        shown.iter().enumerate().map(|(i, m)| json!({ "name": m.name, "mesh": i })).collect();
    for (i, c) in model.cameras.iter().enumerate() {
        nodes.push(json!({ "name": c.name, "camera": i, "matrix": camera_matrix(c) }));
    }
    // Turn z up by a root node.
    let children: Vec<usize> = (0..nodes.len()).collect();
    let roots = if model.up == UpAxis::Z && !nodes.is_empty() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        nodes.push(json!({ "name": "z up", "rotation": [-half, 0.0, 0.0, half], "children": children }));
        vec![nodes.len() - 1]
    } else {
        children
    };
    let images: Vec<Value> = (model.pictures.iter())
        .map(|p| json!({ "bufferView": layout.add_view(ArrayData::Bytes(p), None), "mimeType": "image/png" }))
        .collect();
    let mut used_extensions = BTreeSet::new();
    let materials: Vec<Value> =
        model.materials.iter().map(|m| material_json(m, &mut used_extensions)).collect();
    let scene = scene_json(model, &roots);
    // Assemble the document; empty lists are not allowed.
    let asset = json!({ "version": "2.0", "generator": format!("zonal {}", env!("CARGO_PKG_VERSION")) });
    let mut root = json!({ "asset": asset, "scene": 0, "scenes": [scene] });
    let sampler = json!({ "magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497 });
    let samplers = if images.is_empty() { Vec::new() } else { vec![sampler] };
    let buffers = if layout.length > 0 { vec![json!({ "byteLength": layout.length })] } else { Vec::new() };
    for (key, list) in [
        ("textures", (0..images.len()).map(|i| json!({ "source": i, "sampler": 0 })).collect()),
        ("samplers", samplers),
        ("images", images),
        ("meshes", meshes),
        ("nodes", nodes),
        ("materials", materials),
        ("cameras", model.cameras.iter().map(camera_json).collect()),
        ("extensionsUsed", used_extensions.into_iter().map(Value::from).collect()),
        ("bufferViews", std::mem::take(&mut layout.views)),
        ("accessors", std::mem::take(&mut layout.accessors)),
        ("buffers", buffers),
    ] {
        if !list.is_empty() {
            root[key] = list.into();
        }
    }
    root
}

/// The scene with its root nodes.
fn scene_json(model: &GlbModel, roots: &[usize]) -> Map<String, Value> {
    let mut scene = Map::from_iter([("name".to_string(), json!(model.name))]);
    if !roots.is_empty() {
        scene.insert("nodes".into(), json!(roots));
    }
    if !model.extras.is_null() {
        scene.insert("extras".into(), model.extras.clone());
    }
    scene
}

fn material_json(m: &GlbMaterial, used: &mut BTreeSet<&'static str>) -> Value {
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

fn camera_json(c: &GlbCamera) -> Value {
    let vertical = 2.0 * ((0.5 * c.fov.to_radians()).tan() / c.aspect).atan();
    json!({ "name": c.name, "type": "perspective", "perspective":
        { "yfov": vertical, "aspectRatio": c.aspect, "znear": c.range[0], "zfar": c.range[1] } })
}

/// The camera's matrix in column order: it looks along its own −z, y up.
fn camera_matrix(c: &GlbCamera) -> [f64; 16] {
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
