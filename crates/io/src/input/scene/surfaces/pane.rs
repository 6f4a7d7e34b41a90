//! `[[pane]]`: thin plane sheets of absorbing and scattering material.

use crate::input::reading::error::InputError;
use crate::input::scene::scene_reader::SceneReader;
use crate::input::scene::shapes;
use crate::input::scene::thermal;
use crate::input::toml::medium_keys::{PANE, Pane as PaneKeys};
use crate::input::toml::node::TomlNode;
use zonal_scene::{Bands, Pane};

/// Reads entry `index` of `[[pane]]`.
pub(crate) fn read_pane(
    node: &TomlNode<'_>,
    index: usize,
    reader: &mut SceneReader<'_>,
) -> Result<(), InputError> {
    let (name, mut table) = node.named_table("pane", index)?;
    table.check(PaneKeys::TABLE)?;
    table.key = format!("pane '{name}'");
    table.record_place();
    thermal::check_mode(&table, reader.mode())?;
    let plates = shapes::read_polygon(&table.require(&PANE.polygon)?)?;
    let thickness = table.required(&PANE.thickness)?;
    let [extinction, albedo] = thermal::read_extinction_and_albedo(&table)?;
    let Some(extinction) = extinction else {
        return Err(match table.require(&PANE.extinction) {
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
        emission: table.or_default(&PANE.emission)?,
    });
    Ok(())
}
