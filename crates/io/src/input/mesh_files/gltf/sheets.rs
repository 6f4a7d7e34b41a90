//! glTF materials that transmit diffusely, as sheets of reflectance ρ and transmittance τ.
//!
//! | material | ρ | τ |
//! |---|---|---|
//! | KHR_materials_diffuse_transmission, factor f | base colour × (1 − f) | diffuse transmission colour × f |
//! | KHR_materials_transmission, factor f, without a volume, roughness of at least [`MIN_ROUGHNESS`] | base colour × (1 − f) | base colour × f |
//!
//!
//! Textures of the factor (alpha and red channel) and of the colours are read; all have the mapping of the base colour, if it has a texture. A rough transmission is taken as
//! diffuse in all directions.

use super::texture_mapping::TextureMapping;
use serde_json::Value;
use zonal_scene::Bands;

/// Roughness from which on a transmission is diffuse, not specular.
pub(super) const MIN_ROUGHNESS: f64 = 0.25;
/// Name of the extension.
pub(super) const DIFFUSE_TRANSMISSION: &str = "KHR_materials_diffuse_transmission";

/// The transmission of a sheet by its file.
pub(super) struct SheetFactors {
    /// Fraction of the light that is not reflected but transmitted.
    pub(super) factor: f64,
    /// Index of the texture that multiplies the factor.
    pub(super) factor_texture: Option<usize>,
    /// True if the factor is in the red channel of that texture, not in alpha.
    pub(super) factor_in_red: bool,
    /// Colour of the transmitted light, and the index of its texture.
    pub(super) colour: Bands,
    pub(super) colour_texture: Option<usize>,
    /// Mapping of these textures.
    pub(super) mapping: Option<TextureMapping>,
    /// True if colour and texture are those of the base colour.
    pub(super) base_colour: bool,
}

impl SheetFactors {
    /// The factors of a material; `None` where it does not transmit diffusely.
    pub(super) fn of(m: &gltf::Material<'_>) -> Option<SheetFactors> {
        if let Some(v) = m.extension_value(DIFFUSE_TRANSMISSION) {
            let number = |v: &Value| v.as_f64().filter(|x| x.is_finite()).map(|x| x.clamp(0.0, 1.0));
            let texture = |key: &str| v.get(key)?.get("index")?.as_u64().map(|i| i as usize);
            let set = |key: &str| {
                let info = v.get(key)?;
                info.get("index")?;
                Some(info.get("texCoord").and_then(Value::as_u64).unwrap_or(0) as u32)
            };
            let (of_factor, of_colour) = ("diffuseTransmissionTexture", "diffuseTransmissionColorTexture");
            let factor = v.get("diffuseTransmissionFactor").and_then(number).unwrap_or(0.0);
            let colour = v.get("diffuseTransmissionColorFactor").and_then(Value::as_array);
            let colour = colour
                .map_or([1.0; 3], |c| std::array::from_fn(|k| c.get(k).and_then(number).unwrap_or(1.0)));
            return (factor > 0.0).then(|| SheetFactors {
                factor,
                factor_texture: texture(of_factor),
                factor_in_red: false,
                colour: Bands::from_rgb(colour),
                colour_texture: texture(of_colour),
                mapping: set(of_factor).or_else(|| set(of_colour)).map(TextureMapping::of_set),
                base_colour: false,
            });
        }
        let t = m.transmission().filter(|_| m.volume().is_none())?;
        let factor = f64::from(t.transmission_factor()).clamp(0.0, 1.0);
        let pbr = m.pbr_metallic_roughness();
        // A texture may make parts of the material smooth.
        let rough =
            pbr.metallic_roughness_texture().is_none() && f64::from(pbr.roughness_factor()) >= MIN_ROUGHNESS;
        (factor > 0.0 && rough).then(|| SheetFactors {
            factor,
            factor_texture: t.transmission_texture().map(|info| info.texture().index()),
            factor_in_red: true,
            colour: Bands::ONE,
            colour_texture: None,
            mapping: t.transmission_texture().map(|info| TextureMapping::new(&info)),
            base_colour: true,
        })
    }
}
