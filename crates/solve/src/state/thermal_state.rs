//! A thermal state: temperatures and fluxes of all zones with errors, sums by name and by face, and their balance.

use super::exchange_data::ExchangeData;
use zonal_scene::thermal::{blackbody_emissive_power, blackbody_temperature};

/// Temperatures and fluxes of all zones, totals over the bands. Errors are infinite where they are unknown; the error of the finite zones is not included.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ThermalState {
    /// T, K; NaN where it is undefined.
    pub temperature: Vec<f64>,
    /// Error of T, K; 0 for known temperatures.
    pub temperature_error: Vec<f64>,
    /// Net flux that leaves, W/m² of patches and W/m³ of volumes.
    pub net: Vec<f64>,
    /// Error of `net`; 0 for known powers.
    pub net_error: Vec<f64>,
    /// Incident flux H of patches, G/4 of volumes, W/m²; of volumes in the bands in which they absorb or scatter.
    pub incident: Vec<f64>,
    /// Error of `incident`, W/m².
    pub incident_error: Vec<f64>,
    /// Radiosity B, W/m².
    pub radiosity: Vec<f64>,
    /// Error of `radiosity`, W/m².
    pub radiosity_error: Vec<f64>,
    /// Power from the surroundings, suns and skies less power that escapes to them, W.
    pub surroundings: f64,
    /// Power absorbed by the black backs of one-sided surfaces, W.
    pub absorbed_backfaces: f64,
    /// Power that emitters send as direct light, W.
    pub emitters: f64,
}

/// Sums and means over some zones.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StatePart {
    /// Area in m² or volume in m³.
    pub size: f64,
    /// Net power that leaves and its error, W.
    pub power: [f64; 2],
    /// (mean of T⁴)^¼ and its error, K; NaN where no zone has a temperature.
    pub temperature: [f64; 2],
    /// Mean incident flux and its error, W/m².
    pub incident: [f64; 2],
    /// Mean radiosity and its error, W/m².
    pub radiosity: [f64; 2],
}

impl StatePart {
    /// Net flux, power over size, and its error; NaN without zones.
    #[must_use]
    pub fn flux(&self) -> [f64; 2] {
        self.power.map(|p| p / self.size)
    }
}

impl ThermalState {
    /// Sums over groups of zones: `group` gives the group of a zone, below `count`, or none. Errors add up as if they had one sign.
    #[must_use]
    pub fn sums(
        &self,
        sizes: &[f64],
        count: usize,
        group: impl Fn(usize) -> Option<usize>,
    ) -> Vec<StatePart> {
        let mut parts = vec![StatePart::default(); count];
        let mut emissive = vec![[0.0; 3]; count];
        for (i, size) in sizes.iter().enumerate() {
            let Some(k) = group(i) else { continue };
            let part = &mut parts[k];
            part.size += size;
            let add =
                |sum: &mut [f64; 2], x: [f64; 2]| [0, 1].into_iter().for_each(|e| sum[e] += size * x[e]);
            add(&mut part.power, [self.net[i], self.net_error[i]]);
            add(&mut part.incident, [self.incident[i], self.incident_error[i]]);
            add(&mut part.radiosity, [self.radiosity[i], self.radiosity_error[i]]);
            let (t, dt) = (self.temperature[i], self.temperature_error[i]);
            if !t.is_nan() {
                let e = blackbody_emissive_power(t);
                let own = [1.0, e, if dt > 0.0 { 4.0 * e * dt / t } else { 0.0 }];
                emissive[k].iter_mut().zip(own).for_each(|(s, x)| *s += size * x);
            }
        }
        for (part, [size, e, de]) in parts.iter_mut().zip(emissive) {
            let t = if size > 0.0 { blackbody_temperature(e / size) } else { f64::NAN };
            part.temperature = [t, if e > 0.0 { 0.25 * t * de / e } else { t * 0.0 }];
            part.incident = part.incident.map(|x| x / part.size);
            part.radiosity = part.radiosity.map(|x| x / part.size);
        }
        parts
    }

    /// Sums by name, in the order of [`ExchangeData::names`].
    #[must_use]
    pub fn by_name(&self, data: &ExchangeData) -> Vec<StatePart> {
        self.sums(&data.sizes, data.names.len(), |i| Some(data.name_of_zone[i]))
    }

    /// Sums by face of the mesh files.
    #[must_use]
    pub fn by_face(&self, data: &ExchangeData) -> Vec<StatePart> {
        self.sums(&data.sizes, data.face_count(), |i| data.face_of_zone[i])
    }

    /// Sum of all net powers, 0 up to errors, W.
    #[must_use]
    pub fn balance(&self, data: &ExchangeData) -> f64 {
        let zones: f64 = self.net.iter().zip(&data.sizes).map(|(q, s)| q * s).sum();
        zones + self.surroundings + self.emitters - self.absorbed_backfaces
    }
}
