//! The sections of a scene file, and the order in which they are read.
//!
//! | module | section |
//! |---|---|
//! | `scene_reader` | the scene while it is read |
//! | `bands`, `thermal`, `options`, `network`, `camera` | `bands`; `mode`, `[thermal]` and the thermal keys of all sections; `[solve]`; `[[node]]` and convection; `[[camera]]` |
//! | `shapes` | inline geometry |
//! | `surfaces` | `[[surface]]`, `[[pane]]`, `[boundary]` |
//! | `surface_keys`, `emissivity` | properties of a surface |
//! | `mesh_surface` | `mesh` of a surface: materials as surfaces, panes and regions, with the scene's overrides |
//! | `media` | `[medium]`, its regions and gases |
//! | `light_sources` | `[[light]]`, `[surroundings]` |
//! | `quantities` | properties of surfaces, media and lights |

pub(crate) mod bands;
pub(crate) mod camera;
mod emissivity;
pub(crate) mod light_sources;
pub(crate) mod media;
pub(crate) mod mesh_surface;
mod network;
pub(crate) mod options;
pub(crate) mod quantities;
pub(crate) mod scene_reader;
pub(crate) mod shapes;
pub(crate) mod surface_keys;
pub(crate) mod surfaces;
pub(crate) mod thermal;

use super::toml::key_tables::{ROOT, Root, SOLVE};
use super::toml::light_keys::{SURROUNDINGS, Surroundings as SurroundingsKeys};
use super::toml::node::{TomlNode, TomlTable};
use crate::input::reading::error::InputError;
use crate::input::reading::notes::merge_notes;
use crate::input::scene::scene_reader::{ReadContext, SceneReader};
use light_sources::lights;
use media::medium;
use quantities::gas_composition::SceneGas;
use surfaces::{boundary, pane, surface, white_walls};
use zonal_scene::{PatchRule, Scene, SolveOptions, Surroundings};

/// Reads a parsed document into a scene. Surfaces precede the medium, which their closed meshes may fill, and the lights, which name them.
pub(crate) fn read_document(
    root: TomlTable<'_>,
    context: ReadContext<'_>,
    gas: Option<SceneGas>,
    default_name: &str,
) -> Result<Scene, InputError> {
    root.check(Root::TABLE)?;
    let mut reader = SceneReader::new(root.source, context);
    reader.has_medium = root.get(&ROOT.medium).is_some();
    (reader.parts.bands, reader.parts.block) = (root.source.bands().clone(), root.source.block());
    // Read the mode and the settings.
    reader.parts.thermal = thermal::read_mode(&root)?;
    reader.gas = gas;
    if let (Some(_), Some(node)) = (gas, root.get(&ROOT.thermal)) {
        return Err(node.error("the gas model gives the band fractions; remove this table or the gas"));
    }
    if gas.is_some() && reader.parts.thermal.is_none() {
        return Err(
            root.error("a gas belongs to thermal mode; write mode = \"thermal\" at the top of the file")
        );
    }
    if let Some(t) = &reader.parts.thermal
        && reader.parts.bands.block_count() == 1
    {
        // Check the band fractions before anything is computed with them.
        t.band_fractions.check().map_err(|e| reader.source.scene_error(&e))?;
    }
    reader.parts.name = root.value(&ROOT.name)?.unwrap_or_else(|| default_name.to_string());
    if let Some(node) = root.get(&ROOT.solve) {
        reader.parts.options = options::read_options(&node.any_table()?, SolveOptions::default())?;
    }
    // Read the geometry.
    read_geometry(&root, &mut reader)?;
    // Read the boundary conditions, the lights and the cameras.
    if let Some(node) = root.get(&ROOT.boundary) {
        boundary::read_boundary(&node, &mut reader.parts)?;
    }
    read_lights(&root, &mut reader)?;
    if let Some(node) = root.get(&ROOT.surroundings) {
        reader.parts.surroundings = read_surroundings(&node, &mut reader)?;
    }
    for (i, node) in root.list(&ROOT.camera)?.iter().enumerate() {
        reader.parts.cameras.push(camera::read_camera(node, i)?);
    }
    // Validate the whole scene.
    let mut notes = merge_notes(std::mem::take(&mut reader.parts.notes));
    notes.extend(white_walls::white_walls(&reader.parts));
    reader.parts.notes = notes;
    Scene::new(reader.parts).map_err(|e| root.source.scene_error(&e))
}

/// Reads the direct lights.
fn read_lights(root: &TomlTable<'_>, reader: &mut SceneReader<'_>) -> Result<(), InputError> {
    for (i, node) in root.list(&ROOT.light)?.iter().enumerate() {
        let light = lights::read_light(node, i, reader)?;
        reader.parts.lights.push(light);
    }
    Ok(())
}

/// Reads surfaces, panes and the medium; refuses a scene without any of them.
fn read_geometry(root: &TomlTable<'_>, reader: &mut SceneReader<'_>) -> Result<(), InputError> {
    network::read_nodes(root, reader)?;
    let surfaces = root.list(&ROOT.surface)?;
    for (i, node) in surfaces.iter().enumerate() {
        surface::read_surface(node, i, reader)?;
    }
    for (i, node) in root.list(&ROOT.pane)?.iter().enumerate() {
        pane::read_pane(node, i, reader)?;
    }
    // A network without nodes and convection says nothing.
    if let Some(thermal) = &mut reader.parts.thermal {
        thermal.network = thermal.network.take().filter(|n| !n.is_empty());
    }
    if !has_patch_rule(root)? && !reader.parts.faces.is_empty() {
        reader.parts.options.patch_rule = PatchRule::Area;
    }
    let medium_node = root.get(&ROOT.medium);
    if surfaces.is_empty() && reader.parts.panes.is_empty() && medium_node.is_none() {
        return Err(root.error("the scene is empty; add a [[surface]], a [[pane]] or a [medium]"));
    }
    if reader.parts.options.patch_rule == PatchRule::Voxels && medium_node.is_none() {
        let at =
            root.get(&ROOT.solve).map(|n| n.any_table()).transpose()?.and_then(|t| t.get(&SOLVE.patch_rule));
        let message =
            "there is no medium whose voxels walls could follow; add a [medium], or remove this key";
        return Err(at.map_or_else(|| root.error(message), |n| n.error(message)));
    }
    if let Some(node) = medium_node {
        let voxel_grid = medium::read_medium(&node, reader)?;
        reader.parts.voxel_grid = Some(voxel_grid);
    }
    Ok(())
}

/// True if the scene says what the patch size limits.
fn has_patch_rule(root: &TomlTable<'_>) -> Result<bool, InputError> {
    let settings = root.get(&ROOT.solve).map(|n| n.any_table()).transpose()?;
    Ok(settings.is_some_and(|t| t.get(&SOLVE.patch_rule).is_some()))
}

/// The surroundings; in thermal mode their radiance follows from their temperature.
fn read_surroundings(node: &TomlNode<'_>, reader: &mut SceneReader<'_>) -> Result<Surroundings, InputError> {
    let t = node.table(SurroundingsKeys::TABLE)?;
    thermal::check_mode(&t, reader.mode())?;
    let name = t.value(&SURROUNDINGS.name)?;
    let mut radiance = t.value(&SURROUNDINGS.radiance)?;
    if let Some(thermal) = &mut reader.parts.thermal {
        thermal.surroundings = t.value(&SURROUNDINGS.temperature)?;
        radiance = Some(thermal.surroundings_radiance());
    }
    Ok(Surroundings { name, radiance: radiance.unwrap_or_default() })
}
