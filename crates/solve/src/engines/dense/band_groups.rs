//! Groups of bands with equal extinctions, which share their exchange areas, and the memory of the dense engine.

use super::row_blocks::packed_length;
use zonal_math::parallel;
use zonal_scene::{Band, Bands, PerBand, Scene};
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

/// Groups of bands that share their exchange areas.
#[derive(Clone, Debug, PartialEq)]
pub struct BandGroups {
    /// The group of each band.
    pub group: PerBand<usize>,
    /// The first band of each group.
    pub firsts: Vec<Band>,
}

impl BandGroups {
    /// The groups of bands that are the `same`.
    pub(crate) fn of(same: impl Fn(Band, Band) -> bool) -> BandGroups {
        let (mut group, mut firsts) = (PerBand::splat(0), Vec::new());
        for b in Band::all() {
            group[b] = firsts.iter().position(|a| same(*a, b)).unwrap_or_else(|| {
                firsts.push(b);
                firsts.len() - 1
            });
        }
        BandGroups { group, firsts }
    }

    /// The groups of bands that share all factors outside the panes.
    #[must_use]
    pub fn of_scene(scene: &Scene, panes: InteriorPanes) -> BandGroups {
        BandGroups::of(|a, b| {
            let same = |extinction: Bands| extinction[a] == extinction[b];
            scene.voxel_grid().is_none_or(|v| !parallel::any(v.len(), |c| !same(v.extinction(c))))
                && (panes == InteriorPanes::Absent || scene.panes().iter().all(|p| same(p.extinction)))
        })
    }
}

/// Memory of the matrices of `zones` zones, `panes` of them panes, with `groups` groups of bands; bytes.
pub(crate) fn matrix_bytes(zones: usize, panes: usize, groups: usize) -> u64 {
    let shared = packed_length(zones - panes) as u64 * groups as u64;
    let rows = Band::count() as u64 * panes as u64 * zones as u64;
    8 * (shared + rows) + packed_length(zones) as u64
}
