//! Groups of neighbouring zones, over which errors are pooled and one degree of smoothing is chosen.
//!
//! Patches and panes are in groups of consecutive numbers: those of a facet follow one another. The numbers of volume zones run along columns of cells, which
//! pass from the air of a room through a vault into the open; their groups are blocks of cells, those without medium apart from the others.

use rayon::prelude::*;
use std::ops::Range;
use zonal_scene::{Bands, Scene, Zones};

/// Zones of a group.
pub(crate) const ZONES_PER_GROUP: usize = 64;
/// Cells along each edge of a block of volume zones.
const CELLS_ACROSS_GROUP: usize = 4;

/// Groups whose biases support one another: a cube of blocks.
pub(crate) const GROUPS_TOGETHER: usize = 8;

/// The zones in the order of their groups.
pub(crate) struct ZoneGroups {
    order: Vec<u32>,
    kinds: [Range<usize>; 3],
}

impl ZoneGroups {
    /// The groups of patches, of volume zones, and of panes.
    pub(crate) fn new(scene: &Scene, zones: &Zones) -> ZoneGroups {
        let kinds = zones.ranges_of_kinds();
        let mut order: Vec<u32> = (0..zones.len() as u32).collect();
        if let Some(grid) = scene.voxel_grid() {
            let block = |i: &u32| {
                let cell = zones.voxels.at(*i as usize - kinds[1].start).cell;
                let at = grid.coordinates(cell);
                let [cube, block] = [2, 1].map(|n| at.map(|c| c / (n * CELLS_ACROSS_GROUP)));
                (grid.extinction(cell) == Bands::ZERO, cube, block, *i)
            };
            order[kinds[1].clone()].par_sort_by_cached_key(block);
        }
        ZoneGroups { order, kinds }
    }

    /// The groups of a scene of this number of patches.
    #[cfg(test)]
    pub(crate) fn of_patches(n: usize) -> ZoneGroups {
        ZoneGroups { order: (0..n as u32).collect(), kinds: [0..n, n..n, n..n] }
    }

    /// The groups of a kind: 0 for patches, 1 for volume zones, 2 for panes.
    pub(crate) fn of_kind(&self, kind: usize) -> Vec<&[u32]> {
        self.order[self.kinds[kind].clone()].chunks(ZONES_PER_GROUP).collect()
    }

    /// The zones of a kind, group by group.
    pub(crate) fn order_of_kind(&self, kind: usize) -> &[u32] {
        &self.order[self.kinds[kind].clone()]
    }

    /// Ranges of the kinds, of the zones as of the order.
    pub(crate) fn kinds(&self) -> &[Range<usize>; 3] {
        &self.kinds
    }
}
