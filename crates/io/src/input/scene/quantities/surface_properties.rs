//! Properties of a surface as a table gives them: those of a face or a material take precedence over those of the whole.

use zonal_scene::{Bands, Convection, DEFAULT_REFLECTANCE, Sides, Surface, ThermalCondition, Transmission};

/// Whether a surface bounds a solid body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SurfaceShape {
    /// An open sheet or the inside of a room.
    Sheet,
    /// The boundary of a solid.
    Solid,
}

/// Reflectance of the back of a surface, and the index of its table by temperature.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BackProperties {
    pub(crate) reflectance: Bands,
    pub(crate) table: Option<usize>,
}

/// The properties that a table gives; none for those it omits.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SurfaceProperties {
    pub(crate) reflectance: Option<Bands>,
    /// Index of the table of emissivities by temperature, of which the reflectance is a value.
    pub(crate) emissivity_table: Option<usize>,
    /// The back, where it differs.
    pub(crate) back: Option<BackProperties>,
    /// Diffuse transmittance of a sheet.
    pub(crate) transmittance: Option<Bands>,
    /// Absorptance of sunlight, in place of that of the reflectance.
    pub(crate) solar_absorptance: Option<f64>,
    /// W/m².
    pub(crate) emission: Option<Bands>,
    pub(crate) sides: Option<Sides>,
    /// m.
    pub(crate) patch_size: Option<f64>,
    /// Index of a texture.
    pub(crate) texture: Option<usize>,
    /// Temperature or net power, in thermal mode.
    pub(crate) condition: Option<ThermalCondition>,
    /// Index of the node that gives the condition.
    pub(crate) node: Option<usize>,
    /// Convection, in thermal mode.
    pub(crate) convection: Option<Convection>,
}

impl SurfaceProperties {
    /// These properties, with gaps filled from `other`.
    pub(crate) fn or(self, other: SurfaceProperties) -> SurfaceProperties {
        SurfaceProperties {
            reflectance: self.reflectance.or(other.reflectance),
            emissivity_table: match self.reflectance {
                Some(_) => self.emissivity_table,
                None => other.emissivity_table,
            },
            back: self.back.or(other.back),
            transmittance: self.transmittance.or(other.transmittance),
            solar_absorptance: self.solar_absorptance.or(other.solar_absorptance),
            emission: self.emission.or(other.emission),
            sides: self.sides.or(other.sides),
            patch_size: self.patch_size.or(other.patch_size),
            texture: self.texture.or(other.texture),
            condition: self.condition.or(other.condition),
            // A temperature or power takes the place of a node.
            node: if self.condition.is_some() { self.node } else { other.node },
            convection: match self.condition {
                // A given temperature takes the place of convection too.
                Some(ThermalCondition::Temperature(_)) if self.node.is_none() => self.convection,
                _ => self.convection.or(other.convection),
            },
        }
    }
    /// The diffuse transmission that these properties give.
    pub(crate) fn transmission(&self) -> Option<Transmission> {
        let given = self.transmittance.filter(|t| *t != Bands::ZERO);
        given.map(|transmittance| Transmission { transmittance, texture: None })
    }
    /// An inline surface with these properties.
    pub(crate) fn surface(&self, name: String, shape: SurfaceShape) -> Surface {
        let transmission = self.transmission();
        // Light passes to the other side of a sheet.
        let default = if transmission.is_some() { Sides::Both } else { Sides::Front };
        let sides = self.sides.unwrap_or(default);
        Surface {
            name,
            reflectance: self.reflectance.unwrap_or(DEFAULT_REFLECTANCE),
            emission: self.emission.unwrap_or(Bands::ZERO),
            reflectance_texture: self.texture,
            emission_texture: None,
            transmission,
            sides,
            patch_size: self.patch_size,
            // A body whose inside exchanges too is hollow.
            solid: shape == SurfaceShape::Solid && sides == Sides::Front,
        }
    }
}
