//! Reading of surface properties from a table.

use super::{emissivity, network, thermal};
use crate::input::reading::error::InputError;
use crate::input::scene::quantities::surface_properties::SurfaceProperties;
use crate::input::scene::scene_reader::SceneReader;
use crate::input::toml::node::TomlTable;
use crate::input::toml::surface_keys::{SHAPES, SURFACE_PROPERTIES as KEYS};
use zonal_scene::{Sides, ThermalCondition};

/// Keys that a file may give by face or by material of a mesh.
pub(crate) const FACE_VALUE_KEYS: [&str; 6] =
    ["temperature", "heat_flux", "net_power", "emissivity", "reflectance", "emission"];

/// Refuses files by face in tables that have no mesh of their own.
fn check_files(table: &TomlTable<'_>) -> Result<(), InputError> {
    let file = FACE_VALUE_KEYS.iter().filter_map(|k| table.get(k)).find(|n| n.is_value_file());
    match file {
        Some(n) if table.get(&SHAPES.mesh).is_none() => Err(n.error(
            "a file of values belongs to the table of a [[surface]] that has a mesh, beside the key mesh; move it there, or give a number",
        )),
        _ => Ok(()),
    }
}

/// The properties that a table gives.
pub(crate) fn read_properties(
    table: &TomlTable<'_>,
    reader: &mut SceneReader<'_>,
) -> Result<SurfaceProperties, InputError> {
    thermal::check_surface_mode(table, reader.mode())?;
    check_files(table)?;
    let (node, mut condition) =
        (network::read_surface_node(table, reader)?, thermal::read_surface_condition(table)?);
    if let Some((_, of_node)) = node
        && condition.replace(of_node).is_some()
    {
        return Err(table.error(
            "a surface of a node has the temperature of the node; remove temperature, heat_flux and net_power, or the node",
        ));
    }
    let emissivity_table = emissivity::read_emissivity_table(table, reader)?;
    let kelvin = match condition {
        Some(ThermalCondition::Temperature(t)) => Some(t),
        _ => None,
    };
    // Values by face are read with the mesh.
    let emission = table.get(&KEYS.emission).filter(|n| !n.is_value_file());
    let emission = emission.map(|n| KEYS.emission.read(&n)).transpose()?;
    let of_table = emissivity_table.map(|k| emissivity::representative(reader, k, kelvin));
    Ok(SurfaceProperties {
        emissivity_table,
        back: emissivity::read_back(table, reader)?,
        condition,
        node: node.map(|n| n.0),
        convection: network::read_convection(table)?,
        reflectance: thermal::read_reflectance(table)?.or(of_table),
        transmittance: table.value(&KEYS.transmittance)?,
        solar_absorptance: thermal::read_solar(table, &KEYS.solar_absorptance)?,
        emission,
        sides: table.value(&KEYS.sides)?.map(|k| [Sides::Front, Sides::Both][k]),
        patch_size: table.value(&KEYS.patch_size)?,
        texture: table.get(&KEYS.texture).map(|n| reader.texture(&n)).transpose()?,
    })
}
