//! A participating medium from arrays.

use super::values::VoxelValues;
use crate::{BandSet, Bands, SceneError, ThermalCondition, VoxelGrid};
use zonal_math::{Vec3, vec3};

/// A participating medium on a regular grid of voxels.
///
/// ```
/// use zonal_scene::Medium;
/// let smoke = Medium::grid([0.0; 3], [1.0, 1.0, 2.0], [2, 2, 4]).extinction(vec![0.3; 16]).albedo(0.9);
/// # let _ = smoke;
/// ```
#[derive(Clone, Debug)]
pub struct Medium {
    min: [f64; 3],
    max: [f64; 3],
    cells: [usize; 3],
    extinction: VoxelValues,
    albedo: VoxelValues,
    /// κ and Ω of sunlight.
    solar: [Option<f64>; 2],
    emission: VoxelValues,
    source: VoxelValues,
    temperature: Option<VoxelValues>,
    heat_source: Option<VoxelValues>,
}

impl Medium {
    /// A grid of `cells` voxels between two corners, m; κ = 0 until [`Medium::extinction`] is given.
    #[must_use]
    pub fn grid(min: [f64; 3], max: [f64; 3], cells: [usize; 3]) -> Medium {
        let zero = || VoxelValues::from(0.0);
        Medium {
            min,
            max,
            cells,
            extinction: zero(),
            albedo: zero(),
            solar: [None; 2],
            emission: zero(),
            source: zero(),
            temperature: None,
            heat_source: None,
        }
    }

    /// Sets the extinction coefficient κ = absorption + scattering, 1/m.
    #[must_use]
    pub fn extinction(mut self, extinction: impl Into<VoxelValues>) -> Medium {
        self.extinction = extinction.into();
        self
    }

    /// Sets the scattering albedo Ω, 0 to 1; 0 where not given.
    #[must_use]
    pub fn albedo(mut self, albedo: impl Into<VoxelValues>) -> Medium {
        self.albedo = albedo.into();
        self
    }

    /// Sets the extinction coefficient (1/m) and the albedo for sunlight, in thermal scenes with lights; those of the infrared where not given.
    #[must_use]
    pub fn solar(mut self, extinction: f64, albedo: f64) -> Medium {
        self.solar = [Some(extinction), Some(albedo)];
        self
    }

    /// Sets the blackbody emissive power E, W/m².
    #[must_use]
    pub fn emission(mut self, emission: impl Into<VoxelValues>) -> Medium {
        self.emission = emission.into();
        self
    }

    /// Sets the volumetric source q, W/m³.
    #[must_use]
    pub fn source(mut self, source: impl Into<VoxelValues>) -> Medium {
        self.source = source.into();
        self
    }

    /// Sets the temperature, K. It makes the scene thermal.
    #[must_use]
    pub fn temperature(mut self, temperature: impl Into<VoxelValues>) -> Medium {
        self.temperature = Some(temperature.into());
        self
    }

    /// Sets the net heat that the medium gives, W/m³; 0 is radiative equilibrium. It makes the scene thermal.
    #[must_use]
    pub fn heat_source(mut self, heat: impl Into<VoxelValues>) -> Medium {
        self.heat_source = Some(heat.into());
        self
    }

    /// Whether a temperature or a heat source is given.
    pub(super) fn is_thermal(&self) -> bool {
        self.temperature.is_some() || self.heat_source.is_some()
    }

    /// Whether values for sunlight are given.
    pub(super) fn has_solar_values(&self) -> bool {
        self.solar.iter().any(Option::is_some)
    }

    /// The validated grid in a scene of these bands.
    pub(super) fn build(&self, bands: &BandSet) -> Result<VoxelGrid, SceneError> {
        let [nx, ny, nz] = self.cells;
        let (min, max) = (Vec3::from_array(self.min), Vec3::from_array(self.max));
        let edges = max - min;
        let cell = vec3(edges.x / nx as f64, edges.y / ny as f64, edges.z / nz as f64);
        let mut grid = VoxelGrid::new(min, cell, self.cells)?;
        let given = [
            ("extinction", Some(&self.extinction)),
            ("albedo", Some(&self.albedo)),
            ("emission", Some(&self.emission)),
            ("source", Some(&self.source)),
            ("temperature", self.temperature.as_ref()),
            ("heat_source", self.heat_source.as_ref()),
        ];
        for (key, values) in given {
            if let Some(n) = values.and_then(VoxelValues::len)
                && n != grid.len()
            {
                let what = format!("{n} values are given for {nx} × {ny} × {nz} = {} voxels", grid.len());
                return Err(SceneError::new(format!("medium.{key}"), what));
            }
        }
        if self.temperature.is_some() && self.heat_source.is_some() {
            let what = "a medium has a temperature or a heat source; give one of them";
            return Err(SceneError::new("medium.heat_source", what));
        }
        let condition = |i: usize| match (&self.temperature, &self.heat_source) {
            (Some(t), _) => Some(ThermalCondition::Temperature(t.at(i).first())),
            (None, Some(q)) => Some(ThermalCondition::Flux(q.at(i).first())),
            (None, None) => None,
        };
        // The first voxel stands for all where every property is uniform.
        let uniform = given.iter().all(|(_, values)| values.and_then(VoxelValues::len).is_none());
        let with_solar = |v: Bands, solar: Option<f64>| solar.map_or(v, |x| bands.with_solar_value(0, v, x));
        let extinction = |i: usize| with_solar(self.extinction.at(i), self.solar[0]);
        let albedo = |i: usize| with_solar(self.albedo.at(i), self.solar[1]);
        grid.fill(extinction(0), albedo(0), self.emission.at(0), self.source.at(0));
        if let Some(condition) = condition(0) {
            grid.fill_heat(condition);
        }
        for i in 1..if uniform { 1 } else { grid.len() } {
            grid.set(i, extinction(i), albedo(i), self.emission.at(i), self.source.at(i));
            if let Some(condition) = condition(i) {
                grid.set_heat(i, condition, condition);
            }
        }
        grid.seal()
    }
}
