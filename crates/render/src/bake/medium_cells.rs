//! The medium on the voxel grid of the scene.
//!
//! The values of a cell are means over its zones j by volume, B = Σ B_j V_j / Σ V_j. With the free volume V = Σ V_j the sums of κBV and
//! κGV over the cells are those over the zones, since κ is constant in a cell.

use super::baked::BakedMedium;
use super::group_fields::GroupField;
use crate::image::to_single_precision;
use zonal_math::parallel;
use zonal_scene::{Bands, Solution};

/// The cell values of the medium; `None` without one.
pub(super) fn average_cells(s: &Solution, groups: &[GroupField]) -> Option<BakedMedium> {
    let (map, zones) = (s.scene.voxel_grid()?, &s.zones);
    let cells = map.len();
    let volume = |c: usize| zones.voxel_zones_of_cell(c).map(|i| zones.voxels.at(i).volume).sum::<f64>();
    let mean = |c: usize, value: &(dyn Fn(usize) -> Bands + Sync)| {
        let whole = volume(c);
        let mut sum = Bands::ZERO;
        for i in zones.voxel_zones_of_cell(c) {
            let (x, weight) = (value(i), zones.voxels.at(i).volume / whole);
            sum += weight * x;
        }
        to_single_precision(sum)
    };
    let grid = |value: &(dyn Fn(usize) -> Bands + Sync)| -> Vec<[f32; 3]> {
        parallel::collect(cells, |c| mean(c, value))
    };
    Some(BakedMedium {
        min: map.min(),
        cell: map.cell(),
        dims: map.dims(),
        volume: parallel::collect(cells, |c| volume(c) as f32),
        extinction: grid(&|i| zones.voxels.at(i).extinction),
        albedo: grid(&|i| zones.voxels.at(i).albedo),
        radiosity: groups.iter().map(|g| grid(&|i| g.radiosity(zones.voxel_index(i)))).collect(),
        fluence: groups.iter().map(|g| grid(&|i| g.fluence(zones.voxel_index(i)))).collect(),
    })
}
