//! Volume zones of the voxel grid: whole cells, and the free parts of cells that facets intersect.

use super::cell_lattice::LineCrossings;
use super::cell_overlap::{CellContact, overlaps};
use super::cell_parts::{CellPart, ResolvedCell, resolve_cell};
use super::work_sharing::{WorkSharing, decode_cells, encode_cell};
use crate::transport::Transport;
use rayon::prelude::*;
use zonal_math::parallel;
use zonal_scene::{Scene, VoxelGrid, VoxelPlace, VoxelZones};

/// Cells that one process resolves together.
const CELLS_PER_BLOCK: usize = 64;

/// A cell and a facet that intersects it.
type CellAndFacet = (u32, u32);

/// The volume zones by ascending cell.
pub(super) fn voxel_zones(
    scene: &Scene,
    grid: &VoxelGrid,
    transport: &Transport,
    sharing: Option<&dyn WorkSharing>,
) -> VoxelZones {
    // Resolve the cells that facets intersect.
    let (contact, pairs) = overlaps(scene, grid, transport.tolerance().edge, sharing);
    let lacks_medium = whole_cells_without_medium(grid, transport, &contact);
    let runs: Vec<&[CellAndFacet]> = pairs.chunk_by(|a, b| a.0 == b.0).collect();
    let resolved = resolve_cells(transport, grid, &runs, sharing);
    if runs.is_empty() && lacks_medium.is_empty() {
        return VoxelZones::whole(grid);
    }
    // List the zones cell by cell.
    let mut resolved = resolved.into_iter();
    let of_cell = |cell: usize| {
        let (parts, is_whole) = match contact[cell] {
            CellContact::Intersected => match resolved.next() {
                Some(ResolvedCell::Parts(parts)) => (parts, false),
                _ => (Vec::new(), true),
            },
            _ => (Vec::new(), lacks_medium.is_empty() || !lacks_medium[cell]),
        };
        let whole = is_whole.then(|| VoxelPlace::whole(grid, cell));
        parts.into_iter().map(move |p| place(cell, p)).chain(whole)
    };
    VoxelZones::new(grid, (0..grid.len()).flat_map(of_cell))
}

/// The cells that facets intersect, each with its facets.
fn resolve_cells(
    transport: &Transport,
    grid: &VoxelGrid,
    runs: &[&[CellAndFacet]],
    sharing: Option<&dyn WorkSharing>,
) -> Vec<ResolvedCell> {
    let coordinates = |run: &[CellAndFacet]| grid.coordinates(run[0].0 as usize);
    let resolve = |crossings: &mut LineCrossings, run: &[CellAndFacet]| {
        let facets: Vec<u32> = run.iter().map(|x| x.1).collect();
        resolve_cell(transport, grid, coordinates(run), &facets, crossings)
    };
    let Some(sharing) = sharing else {
        return runs.par_iter().map_init(LineCrossings::new, |c, run| resolve(c, run)).collect();
    };
    let blocks: Vec<&[&[CellAndFacet]]> = runs.chunks(CELLS_PER_BLOCK).collect();
    let of_block = |b: usize| {
        let (mut crossings, mut words) = (LineCrossings::new(), Vec::new());
        blocks[b].iter().for_each(|run| encode_cell(&resolve(&mut crossings, run), &mut words));
        words
    };
    let words = sharing.map_lists(blocks.len(), &of_block);
    let decode = |(words, runs): (Vec<u64>, &[&[CellAndFacet]])| {
        decode_cells(grid, &words, runs.iter().map(|run| coordinates(run)))
    };
    words.into_iter().zip(blocks).flat_map(decode).collect()
}

fn place(cell: usize, part: CellPart) -> VoxelPlace {
    VoxelPlace { cell, centre: part.centre, volume: part.volume, samples: part.samples }
}

/// For each cell without intersecting facets: whether it has no medium. Empty when all cells have medium. Neighbours that no facet
/// touches agree, so few cells are tested.
fn whole_cells_without_medium(grid: &VoxelGrid, transport: &Transport, contact: &[CellContact]) -> Vec<bool> {
    if !transport.may_lack_medium() {
        return Vec::new();
    }
    let test = |cell: usize| !transport.has_medium_at(grid.centre(grid.coordinates(cell)));
    let mut lacks_medium: Vec<bool> =
        parallel::collect(grid.len(), |c| contact[c] == CellContact::Touched && test(c));
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
