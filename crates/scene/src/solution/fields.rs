//! Fields of a solution: one array a quantity over all zones, in the order of [`crate::Zones`].

use crate::bands::Bands;

/// Radiative quantities of all zones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fields {
    /// Radiosity B, W/m², direct light included.
    pub radiosity: Vec<Bands>,
    /// Irradiance H of patches, fluence G of volume zones, W/m², **without** direct light.
    pub incident: Vec<Bands>,
    /// H_dir of patches, G_dir of volume zones, W/m²: direct light only. Empty without direct light.
    pub direct: Vec<Bands>,
    /// Estimated error of `incident`, W/m², including the part caused by the error of `direct`.
    pub error: Vec<Bands>,
    /// Estimated error of `direct`, W/m²: of shadow rays, or of the exchange areas used. Empty without direct light.
    pub direct_error: Vec<Bands>,
    /// The part of `error` due to the surroundings, W/m²; the other part adds as √(other² + part²). Empty for black surroundings.
    pub surroundings_error: Vec<Bands>,
    /// Temperatures and net powers; `None` in light mode.
    pub heat: Option<ThermalFields>,
}

impl Fields {
    /// The field `direct` from the direct light of all zones: empty where there is none.
    #[must_use]
    pub fn direct_unless_zero(all: Vec<Bands>) -> Vec<Bands> {
        if all.iter().all(|b| *b == Bands::ZERO) { Vec::new() } else { all }
    }
    /// The radiative fields, each list over the zones replaced by `f` of it.
    #[must_use]
    pub fn map_lists(&self, f: impl Fn(&[Bands]) -> Vec<Bands>) -> Fields {
        Fields {
            radiosity: f(&self.radiosity),
            incident: f(&self.incident),
            direct: f(&self.direct),
            error: f(&self.error),
            direct_error: f(&self.direct_error),
            surroundings_error: f(&self.surroundings_error),
            heat: None,
        }
    }
    /// Direct light of zone `i`, W/m²; 0 without.
    pub fn direct_light(&self, i: usize) -> Bands {
        self.direct.get(i).copied().unwrap_or_default()
    }
    /// Estimated error of the total incident flux of zone `i`, direct light included, W/m².
    pub fn total_error(&self, i: usize) -> Bands {
        let direct = self.direct_error.get(i).copied().unwrap_or_default();
        self.error[i] + direct
    }
}

/// Thermal quantities of all zones, summed over the bands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ThermalFields {
    /// T, K; NaN where undefined: perfect mirrors, volumes that do not absorb, zones that would have to emit negative power.
    pub temperature: Vec<f64>,
    /// Estimated error of T, K; 0 for prescribed temperatures, NaN where T is.
    pub temperature_error: Vec<f64>,
    /// Net emitted power: W/m² of patches, W/m³ of volume zones.
    pub net: Vec<f64>,
    /// Estimated error of `net`; 0 for prescribed powers.
    pub net_error: Vec<f64>,
}
