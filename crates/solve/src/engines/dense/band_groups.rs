//! Groups of bands with equal extinctions, which share their exchange areas, and the memory of the dense engine.

use super::row_blocks::packed_length;
use zonal_scene::{Band, PerBand, Scene};
use zonal_transport::Transport;

/// Whether panes attenuate the exchange of other zones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InteriorPanes {
    /// No pane lies between two zones.
    Absent,
    /// Some pane lies between two zones.
    Present,
}

impl InteriorPanes {
    /// In the scene of a transport.
    #[must_use]
    pub fn of(transport: &Transport) -> InteriorPanes {
        if transport.has_interior_panes() { InteriorPanes::Present } else { InteriorPanes::Absent }
    }
}

/// The groups of bands that share all factors outside the panes: the group of each band, and the number of groups.
#[must_use]
pub fn band_groups(scene: &Scene, panes: InteriorPanes) -> (PerBand<usize>, usize) {
    let same = |a: Band, b: Band| {
        let media =
            scene.voxel_grid().is_none_or(|v| (0..v.len()).all(|c| v.extinction(c)[a] == v.extinction(c)[b]));
        media
            && (panes == InteriorPanes::Absent
                || scene.panes().iter().all(|p| p.extinction[a] == p.extinction[b]))
    };
    let mut group = PerBand::splat(0);
    let mut count = 0;
    for b in Band::all() {
        group[b] = match Band::all().find(|&a| a < b && same(a, b)) {
            Some(a) => group[a],
            None => {
                count += 1;
                count - 1
            }
        };
    }
    (group, count)
}

/// The first band of each group.
pub(crate) fn first_bands((group, count): (PerBand<usize>, usize)) -> Vec<Band> {
    (0..count).filter_map(|g| Band::all().find(|&b| group[b] == g)).collect()
}

/// Memory of the matrices of `zones` zones, `panes` of them panes, with `groups` groups of bands; bytes.
pub(crate) fn matrix_bytes(zones: usize, panes: usize, groups: usize) -> u64 {
    let shared = packed_length(zones - panes) as u64 * groups as u64;
    let rows = Band::count() as u64 * panes as u64 * zones as u64;
    8 * (shared + rows) + packed_length(zones) as u64
}
