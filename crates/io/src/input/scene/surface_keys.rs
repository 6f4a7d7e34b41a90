//! Reading of surface properties from a table.

use super::surface_properties::SurfaceProperties;
use super::thermal;
use crate::input::error::InputError;
use crate::input::scene_reader::SceneReader;
use crate::input::toml::node::TomlTable;
use zonal_scene::Sides;

/// The properties that a table gives.
pub(crate) fn read_properties(
    table: &TomlTable<'_>,
    reader: &mut SceneReader<'_>,
) -> Result<SurfaceProperties, InputError> {
    thermal::check_mode(table, reader.mode())?;
    Ok(SurfaceProperties {
        condition: thermal::read_surface_condition(table)?,
        reflectance: thermal::read_reflectance(table)?,
        emission: table.read("emission", |n| n.bands(f64::INFINITY))?,
        sides: table.read("sides", |n| Ok([Sides::Front, Sides::Both][n.choice(&["front", "both"])?]))?,
        patch_size: table.read("patch_size", |n| n.positive())?,
        texture: table.read("texture", |n| reader.texture(&n))?,
    })
}
