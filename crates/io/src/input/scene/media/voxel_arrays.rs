//! `albedo`, `emission`, `temperature`, `heat_source` = `{ file, … }`: a value for each voxel from a file.
//!
//! A voxel gets the mean over its volume: of Ω, of E, of T⁴ and of the heat source. An array without bounds fills the box of its region,
//! or the medium.

use super::density;
use super::voxel_field::VoxelField;
use super::voxel_grid::VoxelGridBuilder;
use crate::input::reading::error::InputError;
use crate::input::scene::quantities::gas_composition::{GAS_QUANTITIES, GasValues};
use crate::input::scene::quantities::medium_properties::MediumProperties;
use crate::input::scene::scene_reader::SceneReader;
use crate::input::toml::medium_keys::MEDIUM_PROPERTIES;
use crate::input::toml::node::TomlTable;
use zonal_math::Vec3;
use zonal_scene::{Bands, ThermalCondition};

/// The keys that may be arrays.
const ARRAY_KEYS: [&str; 4] = ["albedo", "emission", "temperature", "heat_source"];

/// True if some key of the table is an array.
pub(crate) fn has_arrays(t: &TomlTable<'_>) -> bool {
    ARRAY_KEYS.iter().any(|k| t.get(k).is_some_and(|n| n.is_table()))
        || t.get(&MEDIUM_PROPERTIES.gas).is_some()
}

/// Fills in the arrays of a table; `bounds` is the box of arrays without one.
pub(crate) fn read_arrays(
    t: &TomlTable<'_>,
    grid: &mut VoxelGridBuilder,
    bounds: (Vec3, Vec3),
    reader: &mut SceneReader<'_>,
) -> Result<(), InputError> {
    for key in ARRAY_KEYS {
        let Some(node) = t.get(key).filter(|n| n.is_table()) else { continue };
        let properties = |v: Bands| {
            let none = MediumProperties::default();
            // Temperatures and heat sources have one number for all bands.
            let grey = v.first();
            let temperature = || ThermalCondition::Temperature(grey.sqrt().sqrt());
            match key {
                "albedo" => MediumProperties { albedo: Some(v), ..none },
                "emission" => MediumProperties { emission: Some(v), ..none },
                "temperature" => MediumProperties { condition: Some(temperature()), ..none },
                _ => MediumProperties { condition: Some(ThermalCondition::Flux(grey)), ..none },
            }
        };
        let fourth_power = key == "temperature";
        let field = VoxelField {
            averaged: if fourth_power { |x| x.powi(4) } else { |x| x },
            scale_exponent: if fourth_power { 4 } else { 1 },
            properties: &properties,
            has_bands: matches!(key, "albedo" | "emission"),
            default_bounds: Some(bounds),
            is_density: false,
            noun: if key == "heat_source" { "heat source" } else { key },
        };
        if density::read_density(&node, grid, &field, reader)? == 0 {
            return Err(
                node.error("this array fills no cell of the medium; move it inside, or use smaller cells")
            );
        }
    }
    let Some(gas) = t.get(&MEDIUM_PROPERTIES.gas) else { return Ok(()) };
    read_gas_arrays(&gas.any_table()?, grid, bounds, reader)
}

/// Fills in the quantities of a gas that are arrays.
fn read_gas_arrays(
    t: &TomlTable<'_>,
    grid: &mut VoxelGridBuilder,
    bounds: (Vec3, Vec3),
    reader: &mut SceneReader<'_>,
) -> Result<(), InputError> {
    for (k, key) in GAS_QUANTITIES.into_iter().enumerate() {
        let Some(node) = t.get(key).filter(|n| n.is_table()) else { continue };
        let properties = |v: Bands| {
            let mut gas = GasValues::default();
            gas[k] = Some(v.first());
            MediumProperties { gas, ..MediumProperties::default() }
        };
        let field = VoxelField {
            averaged: |x| x,
            scale_exponent: 1,
            properties: &properties,
            has_bands: false,
            default_bounds: Some(bounds),
            is_density: false,
            noun: key,
        };
        if density::read_density(&node, grid, &field, reader)? == 0 {
            return Err(
                node.error("this array fills no cell of the medium; move it inside, or use smaller cells")
            );
        }
    }
    Ok(())
}
