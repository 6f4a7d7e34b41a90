//! Volume zones of the voxel grid: whole cells, and the free parts of cells that facets intersect.

use super::cell_lattice::LineCrossings;
use super::cell_overlap::{CellContact, overlaps};
use super::cell_parts::{ResolvedCell, resolve_cell};
use crate::transport::Transport;
use rayon::prelude::*;
use zonal_math::Vec3;
use zonal_scene::{Scene, VoxelGrid, VoxelSamples, VoxelZone};

/// The volume zones by ascending cell, and the index of the first zone of each cell.
pub(super) fn voxel_zones(
    scene: &Scene,
    grid: &VoxelGrid,
    transport: &Transport,
) -> (Vec<VoxelZone>, Vec<u32>) {
    // Resolve the cells that facets intersect.
    let (contact, pairs) = overlaps(scene, grid, transport.tolerance().edge);
    let lacks_medium = whole_cells_without_medium(grid, transport, &contact);
    let runs: Vec<&[(u32, u32)]> = pairs.chunk_by(|a, b| a.0 == b.0).collect();
    let resolved: Vec<ResolvedCell> = runs
        .par_iter()
        .map_init(LineCrossings::new, |crossings, run| {
            let facets: Vec<u32> = run.iter().map(|x| x.1).collect();
            resolve_cell(transport, grid, grid.coordinates(run[0].0 as usize), &facets, crossings)
        })
        .collect();
    if runs.is_empty() && lacks_medium.is_empty() {
        return all_cells(grid);
    }
    // List the zones cell by cell.
    let part_count = |r: &ResolvedCell| if let ResolvedCell::Parts(p) = r { p.len() } else { 1 };
    let whole_count = contact.iter().filter(|m| **m != CellContact::Intersected).count();
    let mut zones = Vec::with_capacity(whole_count + resolved.iter().map(part_count).sum::<usize>());
    let mut first = Vec::with_capacity(grid.len() + 1);
    let mut resolved = resolved.into_iter();
    for cell in 0..grid.len() {
        first.push(zones.len() as u32);
        match contact[cell] {
            CellContact::Intersected => match resolved.next() {
                Some(ResolvedCell::Parts(parts)) => {
                    zones.extend(parts.into_iter().map(|p| zone(grid, cell, p.centre, p.volume, p.samples)))
                }
                _ => zones.push(whole_cell(grid, cell)),
            },
            _ if !lacks_medium.is_empty() && lacks_medium[cell] => {}
            _ => zones.push(whole_cell(grid, cell)),
        }
    }
    first.push(zones.len() as u32);
    (zones, first)
}

/// Every cell as one zone.
fn all_cells(grid: &VoxelGrid) -> (Vec<VoxelZone>, Vec<u32>) {
    let zones = (0..grid.len()).into_par_iter().map(|cell| whole_cell(grid, cell)).collect();
    (zones, (0..=grid.len() as u32).collect())
}

fn whole_cell(grid: &VoxelGrid, cell: usize) -> VoxelZone {
    let centre = grid.centre(grid.coordinates(cell));
    zone(grid, cell, centre, grid.cell().product(), VoxelSamples::default())
}

fn zone(grid: &VoxelGrid, cell: usize, centre: Vec3, volume: f64, samples: VoxelSamples) -> VoxelZone {
    VoxelZone {
        cell,
        centre,
        volume,
        samples,
        extinction: grid.extinction(cell),
        albedo: grid.albedo(cell),
        emission: grid.emission(cell),
        source: grid.source(cell),
    }
}

/// For each cell without intersecting facets: whether it has no medium. Empty when all cells have medium. Neighbours that no facet
/// touches agree, so few cells are tested.
fn whole_cells_without_medium(grid: &VoxelGrid, transport: &Transport, contact: &[CellContact]) -> Vec<bool> {
    if !transport.may_lack_medium() {
        return Vec::new();
    }
    let test = |cell: usize| !transport.has_medium_at(grid.centre(grid.coordinates(cell)));
    let mut lacks_medium: Vec<bool> =
        (0..grid.len()).into_par_iter().map(|c| contact[c] == CellContact::Touched && test(c)).collect();
    let dims = grid.dims();
    let stride = [dims[1] * dims[2], dims[2], 1];
    for cell in (0..grid.len()).filter(|c| contact[*c] == CellContact::Separate) {
        let c = grid.coordinates(cell);
        let mut neighbours = (0..3).filter(|&k| c[k] > 0).map(|k| cell - stride[k]);
        let known = neighbours.find(|n| contact[*n] == CellContact::Separate);
        lacks_medium[cell] = known.map_or_else(|| test(cell), |n| lacks_medium[n]);
    }
    lacks_medium
}
