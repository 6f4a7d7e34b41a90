//! Direct lights and the surroundings.

use crate::bands::Bands;
use crate::base::limits::{MAX_COORDINATE, MAX_FLUX};
use crate::base::scene_error::{SceneError, invalid};
use crate::model::intensity_distribution::IntensityDistribution;
use crate::model::sky_distribution::SkyDistribution;
use crate::model::surface::Surface;
use zonal_math::Vec3;

/// Name of the group of the surroundings' radiance.
const SURROUNDINGS_GROUP: &str = "surroundings";
/// Largest deviation of the length of a sun's direction from 1.
const UNIT_LENGTH_TOLERANCE: f64 = 1e-9;

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

    /// The light's own name, for editing; `None` for an emitter with the name of its surface.
    pub(crate) fn name_mut(&mut self) -> Option<&mut String> {
        match self {
            Light::Sun { name, .. } | Light::Sky { name, .. } | Light::Point { name, .. } => Some(name),
            Light::Emitter { name, .. } => name.as_mut(),
        }
    }

    /// Removes the name.
    pub fn clear_name(&mut self) {
        match self {
            Light::Sun { name, .. } | Light::Sky { name, .. } | Light::Point { name, .. } => name.clear(),
            Light::Emitter { name, .. } => *name = None,
        }
    }

    /// Irradiance of a sun, W/m², unit radiance of a sky, W/(m² sr), or unit intensity of a point light, W/sr; `None` for an emitter, whose light is the emission of its surface.
    pub fn strength(&self) -> Option<Bands> {
        match self {
            Light::Sun { irradiance: own, .. }
            | Light::Sky { radiance: own, .. }
            | Light::Point { intensity: own, .. } => Some(*own),
            Light::Emitter { .. } => None,
        }
    }

    /// [`Light::strength`], for editing.
    pub fn strength_mut(&mut self) -> Option<&mut Bands> {
        match self {
            Light::Sun { irradiance: own, .. }
            | Light::Sky { radiance: own, .. }
            | Light::Point { intensity: own, .. } => Some(own),
            Light::Emitter { .. } => None,
        }
    }

    /// True if the strength, or the emission of the surface of an emitter, is not zero; `surfaces` are those of the scene.
    pub fn is_emitting(&self, surfaces: &[Surface]) -> bool {
        let emission = || self.surface().map(|s| surfaces[s].emission);
        self.strength().or_else(emission).is_some_and(|light| light != Bands::ZERO)
    }

    /// True if the bands of the strength and of its distribution are equal; true of an emitter.
    pub fn is_grey(&self) -> bool {
        self.strength().is_none_or(Bands::is_grey) && self.sky().is_none_or(|(_, d)| d.is_grey())
    }

    /// Index of the surface of an emitter.
    pub fn surface(&self) -> Option<usize> {
        match self {
            Light::Emitter { surface, .. } => Some(*surface),
            Light::Sun { .. } | Light::Sky { .. } | Light::Point { .. } => None,
        }
    }

    /// Unit radiance, W/(m² sr), and relative radiance of a sky.
    pub fn sky(&self) -> Option<(Bands, &SkyDistribution)> {
        match self {
            Light::Sky { radiance, distribution, .. } => Some((*radiance, distribution)),
            Light::Sun { .. } | Light::Point { .. } | Light::Emitter { .. } => None,
        }
    }

    /// The relative radiance of a sky, for editing.
    pub fn sky_distribution_mut(&mut self) -> Option<&mut SkyDistribution> {
        match self {
            Light::Sky { distribution, .. } => Some(distribution),
            Light::Sun { .. } | Light::Point { .. } | Light::Emitter { .. } => None,
        }
    }

    /// True for a sky that is not uniform.
    pub fn is_varying_sky(&self) -> bool {
        self.sky().is_some_and(|(_, d)| !d.is_uniform())
    }

    /// Position, m, unit intensity, W/sr, and relative intensity of a light without extent.
    pub fn point(&self) -> Option<(Vec3, Bands, &IntensityDistribution)> {
        match self {
            Light::Point { position, intensity, distribution, .. } => {
                Some((*position, *intensity, distribution))
            }
            Light::Sun { .. } | Light::Sky { .. } | Light::Emitter { .. } => None,
        }
    }

    /// Unit vector of travel and angular diameter, radians, of a distant disc.
    pub fn distant_disc(&self) -> Option<(Vec3, f64)> {
        match self {
            Light::Sun { direction, angular_diameter, .. } => Some((*direction, *angular_diameter)),
            Light::Sky { .. } | Light::Point { .. } | Light::Emitter { .. } => None,
        }
    }

    /// True for a light at a finite distance: its power is emitted in the scene and does not enter from outside.
    pub fn is_inside(&self) -> bool {
        match self {
            Light::Point { .. } | Light::Emitter { .. } => true,
            Light::Sun { .. } | Light::Sky { .. } => false,
        }
    }

    /// True for a light of so small an extent that its penumbra is narrower than a cell of the medium.
    pub fn has_narrow_penumbra(&self) -> bool {
        match self {
            Light::Sun { .. } | Light::Point { .. } => true,
            Light::Sky { .. } | Light::Emitter { .. } => false,
        }
    }

    /// True for a light that arrives from all directions; a mean over them needs more samples.
    pub fn fills_sphere(&self) -> bool {
        match self {
            Light::Sky { .. } => true,
            Light::Sun { .. } | Light::Point { .. } | Light::Emitter { .. } => false,
        }
    }

    /// The mirror image by a reflection of points and of vectors; the light itself where images are part of it or of its surface.
    pub(crate) fn image(&self, point: impl Fn(Vec3) -> Vec3, vector: impl Fn(Vec3) -> Vec3) -> Light {
        let mut out = self.clone();
        match &mut out {
            Light::Sun { direction, .. } => *direction = vector(*direction),
            Light::Point { position, distribution, .. } => {
                (*position, *distribution) = (point(*position), distribution.reflected(vector));
            }
            Light::Sky { .. } | Light::Emitter { .. } => {}
        }
        out
    }

    /// The key of errors of the light.
    pub(crate) fn key(&self) -> String {
        match self {
            Light::Sun { name, .. } | Light::Sky { name, .. } | Light::Point { name, .. } => {
                format!("light '{name}'")
            }
            Light::Emitter { .. } => "light.surface".into(),
        }
    }

    /// Validates ranges and the index of a surface, of which there are `surfaces`.
    pub(crate) fn check(&self, surfaces: usize) -> Result<(), SceneError> {
        let key = |k: &str| format!("{}.{k}", self.key());
        match self {
            Light::Sun { direction, irradiance, angular_diameter, .. } => {
                if !(direction.is_finite() && (direction.length() - 1.0).abs() < UNIT_LENGTH_TOLERANCE) {
                    return invalid(key("direction"), "the direction must be a vector with a length");
                }
                irradiance.check(&key("irradiance"), MAX_FLUX)?;
                if !(*angular_diameter >= 0.0 && *angular_diameter < std::f64::consts::PI) {
                    return invalid(
                        key("angular_diameter"),
                        "the angular diameter must lie between 0 and 180 degrees",
                    );
                }
            }
            Light::Sky { radiance, distribution, .. } => {
                radiance.check(&key("radiance"), MAX_FLUX)?;
                if distribution.lacks_pixels() {
                    return invalid(key("image"), "the picture of this sky is missing");
                }
            }
            Light::Point { position, intensity, distribution, .. } => {
                if !(position.is_finite() && position.max_abs() <= MAX_COORDINATE) {
                    return invalid(
                        key("position"),
                        format!("the position must be finite, within ±{MAX_COORDINATE:e} m"),
                    );
                }
                intensity.check(&key("intensity"), MAX_FLUX)?;
                if let Err(what) = distribution.check() {
                    return invalid(key("distribution"), what);
                }
            }
            Light::Emitter { surface, .. } if *surface >= surfaces => {
                return invalid(self.key(), "there is no such surface");
            }
            Light::Emitter { .. } => {}
        }
        Ok(())
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
