//! Texture coordinates of a material: the TEXCOORD set and KHR_texture_transform.

use serde_json::Value;

/// (u, v) ↦ rotate(scale · (u, v)) + offset, of one TEXCOORD set.
#[derive(Clone, Copy)]
pub(super) struct TextureMapping {
    /// False without a texture.
    pub(super) used: bool,
    /// The TEXCOORD set.
    pub(super) set: u32,
    offset: [f64; 2],
    scale: [f64; 2],
    sin_cos: (f64, f64),
}

impl TextureMapping {
    /// Without a texture.
    pub(super) const NO_TEXTURE: TextureMapping =
        TextureMapping { used: false, set: 0, offset: [0.0; 2], scale: [1.0; 2], sin_cos: (0.0, 1.0) };
    /// The coordinates of a TEXCOORD set as they are.
    pub(super) fn of_set(set: u32) -> TextureMapping {
        TextureMapping { used: true, set, ..TextureMapping::NO_TEXTURE }
    }
    /// The mapping of a normal map.
    pub(super) fn of_normal_map(info: &gltf::material::NormalTexture<'_>) -> TextureMapping {
        let mut mapping = TextureMapping::of_set(info.tex_coord());
        let Some(t) = info.extension_value("KHR_texture_transform") else { return mapping };
        let number = |v: &Value| v.as_f64().filter(|x| x.is_finite());
        let pair = |key: &str| Some([number(t.get(key)?.get(0)?)?, number(t.get(key)?.get(1)?)?]);
        mapping.set = t.get("texCoord").and_then(Value::as_u64).map_or(mapping.set, |s| s as u32);
        // Single precision, as the transforms of the other textures have.
        let single = |x: f64| f64::from(x as f32);
        mapping.offset = pair("offset").map_or(mapping.offset, |o| o.map(single));
        mapping.scale = pair("scale").map_or(mapping.scale, |s| s.map(single));
        mapping.sin_cos = t.get("rotation").and_then(number).map_or(mapping.sin_cos, |r| single(r).sin_cos());
        mapping
    }
    pub(super) fn new(info: &gltf::texture::Info<'_>) -> TextureMapping {
        let mut mapping = TextureMapping { used: true, set: info.tex_coord(), ..TextureMapping::NO_TEXTURE };
        if let Some(t) = info.texture_transform() {
            mapping.set = t.tex_coord().unwrap_or(mapping.set);
            mapping.offset = t.offset().map(f64::from);
            mapping.scale = t.scale().map(f64::from);
            mapping.sin_cos = f64::from(t.rotation()).sin_cos();
        }
        mapping
    }
    /// The mapped coordinates.
    pub(super) fn apply(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let (u, v) = (u * self.scale[0], v * self.scale[1]);
        let (sin, cos) = self.sin_cos;
        [cos * u + sin * v + self.offset[0], cos * v - sin * u + self.offset[1]]
    }
    /// True if both map alike.
    pub(super) fn is_same_as(&self, other: &TextureMapping) -> bool {
        (self.set, self.offset, self.scale, self.sin_cos)
            == (other.set, other.offset, other.scale, other.sin_cos)
    }
}
