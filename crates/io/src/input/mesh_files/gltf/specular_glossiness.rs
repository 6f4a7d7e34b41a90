//! KHR_materials_pbrSpecularGlossiness: its diffuse colour and texture, which take the place of the base colour.

use super::texture_mapping::TextureMapping;
use serde_json::Value;

/// Name of the extension.
pub(super) const SPECULAR_GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";

/// The diffuse part of a material of this extension.
pub(super) struct DiffuseFactors {
    /// Red, green, blue and alpha.
    pub(super) colour: [f64; 4],
    /// Index and mapping of the texture.
    pub(super) texture: Option<(usize, TextureMapping)>,
}

impl DiffuseFactors {
    /// The diffuse part of a material; `None` without the extension.
    pub(super) fn of(m: &gltf::Material<'_>) -> Option<DiffuseFactors> {
        let v = m.extension_value(SPECULAR_GLOSSINESS)?;
        let given = v.get("diffuseFactor").and_then(Value::as_array);
        let part = |k: usize| given.and_then(|c| c.get(k)?.as_f64()).unwrap_or(1.0);
        let texture = v.get("diffuseTexture").and_then(|info| {
            let set = info.get("texCoord").and_then(Value::as_u64).unwrap_or(0);
            Some((info.get("index")?.as_u64()? as usize, TextureMapping::of_set(set as u32)))
        });
        Some(DiffuseFactors { colour: std::array::from_fn(part), texture })
    }
}
