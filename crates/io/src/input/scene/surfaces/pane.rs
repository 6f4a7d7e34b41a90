//! `[[pane]]`: thin plane sheets of absorbing and scattering material.

use crate::input::reading::error::InputError;
use crate::input::scene::scene_reader::SceneReader;
use crate::input::scene::shapes;
use crate::input::scene::thermal;
use crate::input::toml::key_tables::PANE;
use crate::input::toml::node::TomlNode;
use zonal_scene::{Bands, Pane};

/// Reads entry `index` of `[[pane]]`.
pub(crate) fn read_pane(
    node: &TomlNode<'_>,
    index: usize,
    reader: &mut SceneReader<'_>,
) -> Result<(), InputError> {
    let (name, mut table) = node.named_table("pane", index)?;
    table.check(PANE)?;
    table.key = format!("pane '{name}'");
    table.record_place();
    thermal::check_mode(&table, reader.mode())?;
    let plates =
        shapes::read_polygon(&table.require("polygon", "polygon = [[x, y, z], [x, y, z], [x, y, z]]")?)?;
    let thickness = table.require("thickness", "thickness = 0.01 (metres)")?.positive()?;
    let [extinction, albedo] = thermal::read_extinction_and_albedo(&table)?;
    let Some(extinction) = extinction else {
        let example =
            "extinction = [red, green, blue] (1/m; the transmittance is exp(-extinction × thickness))";
        return Err(match table.require("extinction", example) {
            Err(e) => e,
            Ok(n) => n.error("this key is missing"),
        });
    };
    reader.add_pane_condition(thermal::read_volume_condition(&table)?);
    reader.parts.panes.push(Pane {
        name,
        plates,
        thickness,
        extinction,
        albedo: albedo.unwrap_or(Bands::ZERO),
        emission: table.read("emission", |n| n.flux_bands())?.unwrap_or(Bands::ZERO),
    });
    Ok(())
}
