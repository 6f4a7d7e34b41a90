//! `[medium]`: the voxel grid, its background, its regions, and the bodies of meshes that fill it.

use super::gas::apply_gas;
use super::voxel_arrays;
use super::voxel_grid::{NO_CONDITION, VoxelGridBuilder};
use crate::input::reading::error::InputError;
use crate::input::scene::media::{interior, region};
use crate::input::scene::quantities::gas_composition::no_gas;
use crate::input::scene::quantities::medium_properties::MediumProperties;
use crate::input::scene::scene_reader::SceneReader;
use crate::input::scene::shapes;
use crate::input::scene::thermal::SceneMode;
use crate::input::toml::medium_keys::{MEDIUM, Medium};
use crate::input::toml::node::{TomlNode, TomlTable};
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, SceneError, ThermalCondition, VoxelGrid, limits::MAX_UNIFORM_CELLS};

/// Reads `[medium]`.
pub(crate) fn read_medium(
    node: &TomlNode<'_>,
    reader: &mut SceneReader<'_>,
) -> Result<VoxelGrid, InputError> {
    let t = node.table(Medium::TABLE)?;
    let (min, max) = shapes::read_bounds(&t)?;
    let mut builder = read_grid(&t, min, max, reader)?;
    // Fill the background.
    let background = MediumProperties::read(&t, reader.mode())?;
    let regions = t.list(&MEDIUM.region)?;
    if let Some(composition) = reader.gas.map(|_| no_gas()) {
        let own = [0, 1, 2, 3].map(|k| background.gas[k].unwrap_or(composition[k]));
        builder.gas = vec![own; builder.grid.len()];
    }
    let is_empty = background.extinction.is_none() && builder.gas.is_empty();
    if is_empty && regions.is_empty() && reader.interior_fills.is_empty() {
        let message = "nothing fills the medium; write extinction = 0.1 (1/m) or add a [[medium.region]]";
        return Err(node.error(message));
    }
    let or_zero = |x: Option<Bands>| x.unwrap_or_default();
    let MediumProperties { extinction, albedo, emission, source, condition, .. } = background;
    builder.grid.fill(or_zero(extinction), or_zero(albedo), or_zero(emission), or_zero(source));
    let is_thermal = reader.mode() == SceneMode::Thermal;
    if is_thermal {
        builder.grid.fill_heat(condition.unwrap_or(NO_CONDITION));
    }
    voxel_arrays::read_arrays(&t, &mut builder, (min, max), reader)?;
    // Fill the regions in order, then the bodies of meshes.
    for region in &regions {
        region::read_region(region, &mut builder, reader)?;
    }
    for fill in std::mem::take(&mut reader.interior_fills) {
        interior::fill_interior(&mut builder, &fill.plates, &fill.properties);
    }
    if let Some(gas) = reader.gas {
        apply_gas(&mut builder, gas, reader)?;
    }
    if is_thermal {
        set_missing_conditions(&mut builder.grid).map_err(|e| reader.source.scene_error(&e))?;
    }
    builder.grid.seal().map_err(|e| reader.source.scene_error(&e))
}

/// The empty voxel grid between two corners.
fn read_grid(
    t: &TomlTable<'_>,
    min: Vec3,
    max: Vec3,
    reader: &SceneReader<'_>,
) -> Result<VoxelGridBuilder, InputError> {
    let dims = read_dims(t, max - min)?;
    let count = dims.iter().fold(1usize, |n, d| n.saturating_mul(*d));
    let limit = reader.context.max_cells;
    if count > limit && count <= MAX_UNIFORM_CELLS {
        let message = format!("{count} cells are more than the {limit} that are read here; use fewer");
        return Err(reader.source.scene_error(&SceneError::new("medium.cells", message)));
    }
    let size = max - min;
    let cell = vec3(size.x / dims[0] as f64, size.y / dims[1] as f64, size.z / dims[2] as f64);
    let voxel_grid = VoxelGrid::new(min, cell, dims).map_err(|e| reader.source.scene_error(&e))?;
    Ok(VoxelGridBuilder { min, cell, dims, grid: voxel_grid, gas: Vec::new() })
}

/// Refuses voxels that absorb without a thermal condition; sets the others to radiative equilibrium.
fn set_missing_conditions(map: &mut VoxelGrid) -> Result<(), SceneError> {
    for i in 0..if map.is_uniform() { 1 } else { map.len() } {
        if !map.heat(i).is_some_and(|k| matches!(k, ThermalCondition::Flux(q) if q.is_nan())) {
            continue;
        }
        if map.extinction(i) != Bands::ZERO {
            let [x, y, z] = map.coordinates(i);
            let message = format!(
                "nothing is known of the medium in cell ({x}, {y}, {z}); write temperature (K) or heat_source (W/m3), 0 for radiative equilibrium"
            );
            return Err(SceneError::new("medium.temperature", message));
        }
        if map.is_uniform() {
            map.fill_heat(ThermalCondition::Flux(0.0))
        } else {
            map.set_heat(i, ThermalCondition::Flux(0.0), NO_CONDITION)
        }
    }
    Ok(())
}

/// `cells = [nx, ny, nz]` or `cell_size`, rounded to whole voxels.
fn read_dims(t: &TomlTable<'_>, size: Vec3) -> Result<[usize; 3], InputError> {
    match (t.get(&MEDIUM.cells), t.get(&MEDIUM.cell_size)) {
        (Some(n), None) => n.counts(),
        (None, Some(n)) => {
            let wanted = n.lengths()?;
            // An overflow becomes usize::MAX; the voxel grid refuses it on the line of this key.
            t.source.record_place("medium.cells", n.offset());
            Ok([0, 1, 2].map(|axis| ((size[axis] / wanted[axis]).round() as usize).max(1)))
        }
        (Some(_), Some(n)) => Err(n.error("cells and cell_size are both given; keep one of them")),
        (None, None) => {
            Err(t
                .error("neither cells nor cell_size is given; write cells = [20, 30, 15] or cell_size = 0.2"))
        }
    }
}
