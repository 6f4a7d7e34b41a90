//! Where light comes from beside what surfaces and media emit: sun, sky, small emitters, the surroundings.

use crate::{Bands, Scene};
use zonal_math::Vec3;

/// Direct light: the third source, apart from emission.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// A distant disc.
    Sun {
        /// Name.
        name: String,
        /// Unit vector along which the light travels.
        direction: Vec3,
        /// Irradiance on a plane square to it, W/m².
        irradiance: Bands,
        /// Angular diameter, radians.
        angular_diameter: f64,
    },
    /// A uniform sky all around, treated as direct light.
    Sky {
        /// Name.
        name: String,
        /// Radiance, W/(m² sr).
        radiance: Bands,
    },
    /// A small emitting surface, treated as direct light: its emission leaves the zonal exchange.
    Emitter {
        /// Name; the surface's where not given.
        name: Option<String>,
        /// Index of the surface.
        surface: usize,
    },
}

impl Light {
    /// The name by which the light is known.
    pub fn name<'a>(&'a self, scene: &'a Scene) -> &'a str {
        match self {
            Light::Sun { name, .. } | Light::Sky { name, .. } => name,
            Light::Emitter { name, surface } => name.as_ref().unwrap_or(&scene.surfaces()[*surface].name),
        }
    }
}

/// What lies beyond the scene: a zone of its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surroundings {
    /// Name of their light; "surroundings" where not given.
    pub name: Option<String>,
    /// Radiance that comes in from everywhere, W/(m² sr); zero for black surroundings.
    pub radiance: Bands,
}

impl Surroundings {
    /// The name by which their light is known.
    pub fn name(&self) -> &str {
        self.name.as_deref().unwrap_or(crate::group::SURROUNDINGS)
    }

    /// True where light comes in from them.
    pub fn shine(&self) -> bool {
        self.radiance != [0.0; 3]
    }

    /// Its radiosity as a zone, W/m².
    pub fn radiosity(&self) -> Bands {
        self.radiance.map(|l| std::f64::consts::PI * l)
    }
}
