//! Direct lights and the surroundings.

use crate::bands::Bands;
use crate::model::intensity_distribution::IntensityDistribution;
use crate::model::sky_distribution::SkyDistribution;
use crate::model::surface::Surface;
use zonal_math::Vec3;

/// Name of the group of the surroundings' radiance.
const SURROUNDINGS_GROUP: &str = "surroundings";

/// A source of direct light, which is computed apart from the zonal exchange.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Light {
    /// A distant disc.
    Sun {
        /// Name.
        name: String,
        /// Unit vector along which the light travels.
        direction: Vec3,
        /// Irradiance on a plane normal to the direction, W/m².
        irradiance: Bands,
        /// Angular diameter, radians.
        angular_diameter: f64,
    },
    /// A sky: light from infinitely far away, from all directions.
    Sky {
        /// Name.
        name: String,
        /// Unit radiance L₀, W/(m² sr), by which the relative radiance is multiplied.
        radiance: Bands,
        /// Relative radiance over directions.
        #[serde(default, skip_serializing_if = "SkyDistribution::is_uniform")]
        distribution: SkyDistribution,
    },
    /// A light without extent: a bulb, a spot, or a luminaire known by its photometric table.
    Point {
        /// Name.
        name: String,
        /// Position, m.
        position: Vec3,
        /// Unit intensity I₀, W/sr, by which the relative intensity is multiplied.
        intensity: Bands,
        /// Relative intensity over directions.
        distribution: IntensityDistribution,
    },
    /// A small emitting surface whose emission is direct light and not part of the zonal exchange.
    Emitter {
        /// Name; that of the surface if `None`.
        name: Option<String>,
        /// Index of the surface.
        surface: usize,
    },
}

impl Light {
    /// The name of the light; `surfaces` are those of the scene.
    pub fn name<'a>(&'a self, surfaces: &'a [Surface]) -> &'a str {
        match self {
            Light::Sun { name, .. } | Light::Sky { name, .. } | Light::Point { name, .. } => name,
            Light::Emitter { name, surface } => name.as_ref().unwrap_or(&surfaces[*surface].name),
        }
    }
}

/// The surroundings of the scene: a zone of its own.
#[derive(Clone, Debug, Default, PartialEq, serde::Deserialize, serde::Serialize)]
pub struct Surroundings {
    /// Name of their light; "surroundings" if `None`.
    pub name: Option<String>,
    /// Radiance incident from all directions, W/(m² sr); zero for black surroundings.
    pub radiance: Bands,
}

impl Surroundings {
    /// The name of their light.
    pub fn name(&self) -> &str {
        self.name.as_deref().unwrap_or(SURROUNDINGS_GROUP)
    }

    /// True unless the surroundings are black.
    pub fn has_radiance(&self) -> bool {
        self.radiance != Bands::ZERO
    }

    /// Radiosity of the surroundings as a zone, πL, W/m².
    ///
    /// ```
    /// use zonal_scene::{Bands, Surroundings};
    /// let sky = Surroundings { name: None, radiance: Bands::from_rgb([1.0, 0.5, 0.0]) };
    /// assert_eq!(sky.radiosity().to_rgb(), [std::f64::consts::PI, 0.5 * std::f64::consts::PI, 0.0]);
    /// assert_eq!((sky.name(), sky.has_radiance()), ("surroundings", true));
    /// ```
    pub fn radiosity(&self) -> Bands {
        std::f64::consts::PI * self.radiance
    }
}
