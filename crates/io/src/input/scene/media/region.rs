//! `[[medium.region]]`: boxes, the insides of closed meshes, and densities from files.

use super::interior;
use crate::input::mesh::shells;
use crate::input::reading::error::InputError;
use crate::input::scene::media::voxel_field::VoxelField;
use crate::input::scene::media::voxel_grid::VoxelGridBuilder;
use crate::input::scene::media::{density, voxel_arrays};
use crate::input::scene::mesh_surface::placement;
use crate::input::scene::mesh_surface::repeated_faces::drop_repeated_faces;
use crate::input::scene::quantities::medium_properties::MediumProperties;
use crate::input::scene::scene_reader::SceneReader;
use crate::input::scene::shapes;
use crate::input::toml::key_specs::all;
use crate::input::toml::medium_keys::{MEDIUM_PROPERTIES, MediumProperties as PropertyKeys, REGION, Region};
use crate::input::toml::node::{TomlNode, TomlTable};
use crate::input::toml::surface_keys::PlacedMesh;
use zonal_scene::{Bands, Plate};

/// Reads one region and fills it.
pub(crate) fn read_region(
    node: &TomlNode<'_>,
    grid: &mut VoxelGridBuilder,
    reader: &mut SceneReader<'_>,
) -> Result<(), InputError> {
    let t = node.table(Region::TABLE)?;
    let properties = MediumProperties::read(&t, reader.mode())?;
    let mut bounds = grid.bounds();
    let filled = match (t.get(&REGION.r#box), t.get(&REGION.mesh), t.get(&REGION.density)) {
        (Some(n), None, None) => {
            bounds = shapes::read_box_bounds(&n)?;
            grid.fill_box(bounds.0, bounds.1, &properties)
        }
        (None, Some(n), None) => {
            let (mut mesh, _) = placement::load_placed(&n, PlacedMesh::TABLE, reader)?;
            let kinds = vec![Some(0); mesh.materials.len()];
            drop_repeated_faces(&mut mesh, &kinds, "medium.region", reader);
            let plates: Vec<Plate> = mesh.faces.iter().map(|f| f.plate).collect();
            shells::check_closed(&plates).map_err(|message| n.error(message))?;
            interior::fill_interior(grid, &plates, &properties)
        }
        (None, None, Some(n)) => {
            if let Some(e) =
                t.get(&MEDIUM_PROPERTIES.extinction).or_else(|| t.get(&MEDIUM_PROPERTIES.absorption))
            {
                return Err(e.error(
                    "a density brings its own extinction; remove this key and set density.scale and albedo",
                ));
            }
            let of_density = |k: Bands| properties.with_extinction(k);
            density::read_density(&n, grid, &VoxelField::density(&of_density), reader)?
        }
        (None, None, None) if voxel_arrays::has_arrays(&t) => {
            check_arrays_only(&t)?;
            1
        }
        _ => {
            return Err(node.error("this region needs exactly one shape; write one of box, mesh, density"));
        }
    };
    if filled == 0 {
        return Err(node.error(
            "this region fills no cell of the medium; move it inside, enlarge it, or use smaller cells",
        ));
    }
    voxel_arrays::read_arrays(&t, grid, bounds, reader)
}

/// Refuses numbers in a region without a shape, since they would fill nothing.
fn check_arrays_only(t: &TomlTable<'_>) -> Result<(), InputError> {
    match all(PropertyKeys::TABLE).filter_map(|k| t.get(k.name)).find(|n| !n.is_table()) {
        Some(n) => Err(n.error(
            "a region without a shape has arrays alone, and a number fills nothing; write box = { min, max }, or move this key to [medium]",
        )),
        None => Ok(()),
    }
}
