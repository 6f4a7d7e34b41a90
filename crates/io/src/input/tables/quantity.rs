//! Quantities of tables: names of their columns, units and ranges.

use zonal_scene::limits::{MAX_NET_POWER, MAX_TEMPERATURE};

/// A quantity that a table gives by face, zone or name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Temperature, K.
    Temperature,
    /// Net flux that leaves, W/m² (W/m³ of a volume).
    HeatFlux,
    /// Net power that leaves, W.
    NetPower,
    /// Emissivity, 0 to 1.
    Emissivity,
    /// Reflectance, 0 to 1.
    Reflectance,
    /// Emitted flux, W/m².
    Emission,
    /// A wavelength or a value of a spectrum.
    Spectral,
}

impl Quantity {
    /// The names of columns that stand for the quantity, in small letters.
    fn column_names(self) -> &'static [&'static str] {
        match self {
            Quantity::Temperature => &["temperature", "temperature_k", "temperature [k]", "t"],
            Quantity::HeatFlux => &["heat_flux", "net_flux", "net_flux_w_m2", "net flux [w/m2]", "q"],
            Quantity::NetPower => &["net_power", "net_power_w", "net power [w]", "power"],
            Quantity::Emissivity => &["emissivity"],
            Quantity::Reflectance => &["reflectance"],
            Quantity::Emission => &["emission", "emission [w/m2]"],
            Quantity::Spectral => &["value"],
        }
    }

    /// True if a column of this name holds the quantity.
    pub(crate) fn has_column_name(self, name: &str) -> bool {
        self.column_names().contains(&name.trim().to_lowercase().as_str())
    }

    /// The defect and the remedy of a value out of range.
    pub(crate) fn check(self, x: f64) -> Result<(), String> {
        if x.is_nan() {
            return Err("the value is not a number (NaN); give a number in this row, or leave the face out of the mesh".into());
        }
        let (valid, noun, remedy) = match self {
            Quantity::Temperature => {
                (x > 0.0 && x <= MAX_TEMPERATURE, "K", "give kelvin above 0 (0 °C is 273.15)")
            }
            Quantity::HeatFlux => (x.abs() <= MAX_NET_POWER, "W/m2", "give a flux of a modulus up to 1e18"),
            Quantity::NetPower => (x.abs() <= MAX_NET_POWER, "W", "give a power of a modulus up to 1e18"),
            Quantity::Emissivity => {
                ((0.0..=1.0).contains(&x), "as an emissivity", "give a value from 0 to 1")
            }
            Quantity::Reflectance => {
                ((0.0..=1.0).contains(&x), "as a reflectance", "give a value from 0 to 1")
            }
            Quantity::Emission => ((0.0..=1e30).contains(&x), "W/m2", "give an emitted flux from 0 to 1e30"),
            Quantity::Spectral => ((0.0..=1e30).contains(&x), "in a spectrum", "give a value from 0 to 1e30"),
        };
        if valid { Ok(()) } else { Err(format!("{x} {noun} is out of range; {remedy}")) }
    }
}
