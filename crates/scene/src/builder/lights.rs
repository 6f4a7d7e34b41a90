//! Lights and panes of glass for a [`crate::SceneBuilder`].

use super::values::BandValues;
use crate::thermal::blackbody_emissive_power;
use crate::{BandSet, Bands, IntensityDistribution, Light, Pane, Plate, SkyDistribution};
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

    /// Sets the irradiance on a plane perpendicular to the direction, W/m²; in thermal scenes that of sunlight, a number.
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

/// A sky, gathered as direct light: uniform in all directions where no distribution is given.
#[derive(Clone, Debug)]
pub struct Sky {
    name: String,
    radiance: Bands,
    distribution: SkyDistribution,
}

impl Sky {
    /// A sky of a radiance, W/(m² sr): that of a uniform sky, or where the relative radiance is 1.
    #[must_use]
    pub fn new(radiance: impl BandValues) -> Sky {
        let distribution = SkyDistribution::uniform();
        Sky { name: "sky".into(), radiance: radiance.into_bands(), distribution }
    }

    /// Sets the relative radiance over directions.
    #[must_use]
    pub fn distribution(mut self, distribution: SkyDistribution) -> Sky {
        self.distribution = distribution;
        self
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
        Light::Sky { name: sky.name, radiance: sky.radiance, distribution: sky.distribution }
    }
}

/// A light without extent: a bulb, a spot, or a luminaire known by its photometric table.
#[derive(Clone, Debug)]
pub struct PointLight {
    name: String,
    position: Vec3,
    intensity: Bands,
    distribution: IntensityDistribution,
}

impl PointLight {
    /// An isotropic light at a position, m, of no intensity yet.
    #[must_use]
    pub fn new(position: [f64; 3]) -> PointLight {
        PointLight {
            name: "point".into(),
            position: Vec3::from_array(position),
            intensity: Bands::ZERO,
            distribution: IntensityDistribution::isotropic(),
        }
    }

    /// Sets the intensity where the relative intensity is 1, W/sr: that of an isotropic light, or on the axis of a spot.
    #[must_use]
    pub fn intensity(mut self, intensity: impl BandValues) -> PointLight {
        self.intensity = intensity.into_bands();
        self
    }

    /// Makes the light a spot along `direction` (any length) with full intensity within the inner half-angle and none beyond the outer one, degrees.
    #[must_use]
    pub fn spot(self, direction: [f64; 3], half_angles_degrees: [f64; 2]) -> PointLight {
        let half_angles = half_angles_degrees.map(f64::to_radians);
        self.distribution(IntensityDistribution::spot(Vec3::from_array(direction), half_angles))
    }

    /// Sets the relative intensity over directions.
    #[must_use]
    pub fn distribution(mut self, distribution: IntensityDistribution) -> PointLight {
        self.distribution = distribution;
        self
    }

    /// Sets the name of its light group; `point` where not given.
    #[must_use]
    pub fn name(mut self, name: impl Into<String>) -> PointLight {
        self.name = name.into();
        self
    }
}

impl From<PointLight> for Light {
    fn from(light: PointLight) -> Light {
        let PointLight { name, position, intensity, distribution } = light;
        Light::Point { name, position, intensity, distribution }
    }
}

/// A distant disc that emits in the infrared and reflects sunlight, uniformly; for thermal scenes.
#[derive(Clone, Debug)]
pub struct Planet {
    name: String,
    direction: Vec3,
    angular_diameter: f64,
    /// Infrared and reflected flux at its surface, W/m².
    flux: [f64; 2],
}

impl Planet {
    /// A planet whose radiation travels along `direction` (any length), of an angular diameter in degrees: 2 arcsin(R/(R + h)) at the height h above a
    /// planet of radius R. It sends nothing yet.
    #[must_use]
    pub fn new(direction: [f64; 3], angular_diameter_degrees: f64) -> Planet {
        Planet {
            name: "planet".into(),
            direction: Vec3::from_array(direction),
            angular_diameter: angular_diameter_degrees.to_radians(),
            flux: [0.0; 2],
        }
    }

    /// Sets the black-body temperature of its infrared radiation, K.
    #[must_use]
    pub fn temperature(mut self, temperature: f64) -> Planet {
        self.flux[0] = blackbody_emissive_power(temperature);
        self
    }

    /// Sets the flux of reflected sunlight at its surface, W/m².
    #[must_use]
    pub fn reflected_flux(mut self, flux: f64) -> Planet {
        self.flux[1] = flux;
        self
    }

    /// Sets its name; `planet` where not given.
    #[must_use]
    pub fn name(mut self, name: impl Into<String>) -> Planet {
        self.name = name.into();
        self
    }
}

impl From<Planet> for Light {
    fn from(planet: Planet) -> Light {
        let over_flux = (0.5 * planet.angular_diameter).sin().powi(2);
        let [infrared, reflected] = planet.flux;
        Light::Sun {
            name: planet.name,
            direction: planet.direction.normalized(),
            irradiance: Bands::from_rgb([infrared * over_flux, reflected * over_flux, 0.0]),
            angular_diameter: planet.angular_diameter,
        }
    }
}

/// Moves the power of a light that is the same in all bands to the band of sunlight of a thermal scene.
pub(super) fn to_sunlight(light: &mut Light, bands: &BandSet) {
    if let Some(flux) = light.strength_mut().filter(|flux| flux.is_grey()) {
        *flux = bands.in_solar_band(0, flux.first());
    }
}

/// An emission that is the same in all bands, in the band of sunlight of a thermal scene; the emission itself in other scenes.
pub(super) fn emission_of_light(emission: Bands, bands: &BandSet) -> Bands {
    if bands.has_solar_band() && emission.is_grey() {
        bands.in_solar_band(0, emission.first())
    } else {
        emission
    }
}

/// A pane: a thin parallelogram of absorbing and scattering glass.
#[derive(Clone, Debug)]
pub struct GlassPane {
    pane: Pane,
    solar_extinction: Option<f64>,
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
        GlassPane { pane, solar_extinction: None }
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

    /// Sets the extinction coefficient for sunlight, 1/m, in thermal scenes with lights; that of the infrared where not given.
    #[must_use]
    pub fn solar_extinction(mut self, extinction: f64) -> GlassPane {
        self.solar_extinction = Some(extinction);
        self
    }

    pub(super) fn into_pane(self, number: usize, bands: &BandSet) -> Pane {
        let name = if self.pane.name.is_empty() { format!("pane{number}") } else { self.pane.name };
        let own = self.pane.extinction;
        let extinction = self.solar_extinction.map_or(own, |k| bands.with_solar_value(0, own, k));
        Pane { name, extinction, ..self.pane }
    }
}
