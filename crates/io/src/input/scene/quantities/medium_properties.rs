//! Properties of a medium or region, as a table gives them in numbers.

use super::gas_composition::{self, GasValues};
use crate::input::reading::error::InputError;
use crate::input::scene::thermal::{self, SceneMode};
use crate::input::toml::medium_keys::MEDIUM_PROPERTIES;
use crate::input::toml::node::TomlTable;
use zonal_scene::{Bands, ThermalCondition};

/// κ (1/m), Ω, E (W/m²), q (W/m³), temperature or heat; voxels keep the values of quantities that are none.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MediumProperties {
    pub(crate) extinction: Option<Bands>,
    pub(crate) albedo: Option<Bands>,
    pub(crate) emission: Option<Bands>,
    pub(crate) source: Option<Bands>,
    /// In thermal mode.
    pub(crate) condition: Option<ThermalCondition>,
    /// The composition of a gas.
    pub(crate) gas: GasValues,
}

impl MediumProperties {
    /// The numbers of a table; arrays from files are read apart.
    pub(crate) fn read(t: &TomlTable<'_>, mode: SceneMode) -> Result<MediumProperties, InputError> {
        thermal::check_mode(t, mode)?;
        let [extinction, albedo] = thermal::read_extinction_and_albedo(t)?;
        let key = &MEDIUM_PROPERTIES.emission;
        let emission = t.get(key).filter(|n| !n.is_table()).map(|n| key.read(&n)).transpose()?;
        Ok(MediumProperties {
            extinction,
            albedo,
            emission,
            source: t.value(&MEDIUM_PROPERTIES.source)?,
            condition: thermal::read_volume_condition(t)?,
            gas: gas_composition::read_gas_values(t)?.unwrap_or_default(),
        })
    }
    /// These properties with an extinction from a file; sources stay only where the extinction is above 0.
    pub(crate) fn with_extinction(&self, extinction: Bands) -> MediumProperties {
        let source = self.source.map(|q| q.zip_map(extinction, |q, k| if k > 0.0 { q } else { 0.0 }));
        let condition = match self.condition {
            Some(ThermalCondition::Flux(_)) if extinction == Bands::ZERO => Some(ThermalCondition::Flux(0.0)),
            condition => condition,
        };
        MediumProperties { extinction: Some(extinction), source, condition, ..*self }
    }
}
