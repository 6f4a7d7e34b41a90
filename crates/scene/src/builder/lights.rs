//! Lights and panes of glass for a [`crate::SceneBuilder`].

use super::values::BandValues;
use crate::{Bands, Light, Pane, Plate};
use zonal_math::Vec3;

/// Angular diameter of the sun as seen from the earth, degrees.
const SUN_ANGULAR_DIAMETER_DEGREES: f64 = 0.53;

/// A distant disc, such as the sun.
#[derive(Clone, Debug)]
pub struct Sun {
    name: String,
    direction: Vec3,
    irradiance: Bands,
    angular_diameter_degrees: f64,
}

impl Sun {
    /// A sun whose light travels along `direction` (any length), of no irradiance yet.
    #[must_use]
    pub fn new(direction: [f64; 3]) -> Sun {
        Sun {
            name: "sun".into(),
            direction: Vec3::from_array(direction),
            irradiance: Bands::ZERO,
            angular_diameter_degrees: SUN_ANGULAR_DIAMETER_DEGREES,
        }
    }

    /// Sets the irradiance on a plane perpendicular to the direction, W/m².
    #[must_use]
    pub fn irradiance(mut self, irradiance: impl BandValues) -> Sun {
        self.irradiance = irradiance.into_bands();
        self
    }

    /// Sets the name of its light group; `sun` where not given.
    #[must_use]
    pub fn name(mut self, name: impl Into<String>) -> Sun {
        self.name = name.into();
        self
    }

    /// Sets the angular diameter, degrees; 0.53 where not given.
    #[must_use]
    pub fn angular_diameter_degrees(mut self, degrees: f64) -> Sun {
        self.angular_diameter_degrees = degrees;
        self
    }
}

impl From<Sun> for Light {
    fn from(sun: Sun) -> Light {
        Light::Sun {
            name: sun.name,
            direction: sun.direction.normalized(),
            irradiance: sun.irradiance,
            angular_diameter: sun.angular_diameter_degrees.to_radians(),
        }
    }
}

/// A uniform sky in all directions, gathered as direct light.
#[derive(Clone, Debug)]
pub struct Sky {
    name: String,
    radiance: Bands,
}

impl Sky {
    /// A sky of a radiance, W/(m² sr).
    #[must_use]
    pub fn new(radiance: impl BandValues) -> Sky {
        Sky { name: "sky".into(), radiance: radiance.into_bands() }
    }

    /// Sets the name of its light group; `sky` where not given.
    #[must_use]
    pub fn name(mut self, name: impl Into<String>) -> Sky {
        self.name = name.into();
        self
    }
}

impl From<Sky> for Light {
    fn from(sky: Sky) -> Light {
        Light::Sky { name: sky.name, radiance: sky.radiance }
    }
}

/// A pane: a thin parallelogram of absorbing and scattering glass.
#[derive(Clone, Debug)]
pub struct GlassPane {
    pane: Pane,
}

impl GlassPane {
    /// A pane of a thickness (m) and an extinction coefficient (1/m), spanned by two edges at a corner (m); exp(−extinction × thickness)
    /// of perpendicular light passes.
    #[must_use]
    pub fn new(
        [corner, edge1, edge2]: [[f64; 3]; 3],
        thickness: f64,
        extinction: impl BandValues,
    ) -> GlassPane {
        let [corner, edge1, edge2] = [corner, edge1, edge2].map(Vec3::from_array);
        let pane = Pane {
            name: String::new(),
            plates: vec![Plate::parallelogram(corner, edge1, edge2)],
            thickness,
            extinction: extinction.into_bands(),
            albedo: Bands::ZERO,
            emission: Bands::ZERO,
        };
        GlassPane { pane }
    }

    /// Sets the name; `pane1`, `pane2`, … where not given.
    #[must_use]
    pub fn name(mut self, name: impl Into<String>) -> GlassPane {
        self.pane.name = name.into();
        self
    }

    /// Sets the scattering albedo, 0 to 1.
    #[must_use]
    pub fn albedo(mut self, albedo: impl BandValues) -> GlassPane {
        self.pane.albedo = albedo.into_bands();
        self
    }

    pub(super) fn into_pane(self, number: usize) -> Pane {
        let name = if self.pane.name.is_empty() { format!("pane{number}") } else { self.pane.name };
        Pane { name, ..self.pane }
    }
}
