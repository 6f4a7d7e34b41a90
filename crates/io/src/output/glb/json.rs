//! The JSON chunk: scene, nodes, materials, cameras.

use super::layout::{Layout, Part};
use super::{Material, Mesh, Model, Up, View};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

/// The JSON of a file.
pub(super) fn document<'a>(model: &'a Model, layout: &mut Layout<'a>) -> Value {
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
