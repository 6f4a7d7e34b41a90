//! The inputs of a gather.

use super::regression_windows::RegressionWindows;
use super::zone_gather::GatheredSky;
use super::zone_groups::ZoneGroups;
use crate::distribution::Execution;
use crate::engines::rays::stored_rays::padded_bands::PaddedBands;
use std::ops::Range;
use zonal_scene::{Bands, CheckpointStore, Zones};

/// The inputs of a gather beside the gatherer.
pub(crate) struct GatherTask<'a> {
    /// Zones.
    pub zones: &'a Zones,
    /// Groups of zones with one degree of smoothing.
    pub zone_groups: &'a ZoneGroups,
    /// Neighbours over which fields are smoothed.
    pub windows: &'a RegressionWindows<'a>,
    /// Number of light groups; the columns of the gatherer are theirs, then one of the noise of the radiosities.
    pub groups: usize,
    /// The surroundings, where the gather samples them.
    pub sky: Option<&'a GatheredSky>,
    /// Relative tolerance.
    pub tolerance: f64,
    /// Incident radiation of known value and its error that the result does not contain, W/m²: that of the surroundings.
    pub known: &'a [[Bands; 2]],
    /// Error of every zone by panes whose light varies over their thickness, W/m²; may be empty.
    pub thickness: &'a [Bands],
    /// Mean radiosity of the rays of a zone, by its number, that the zone itself sends, of a column, W/m².
    pub own: &'a (dyn Fn(usize, usize) -> Bands + Sync),
    /// The response of the solution by the stored rays to changes of the incident radiation of all zones, W/m².
    pub passed_on: &'a (dyn Fn(&[Vec<Bands>]) -> Vec<PassedOn> + Sync),
    /// H or G of every group by the stored rays, W/m².
    pub stored: &'a (dyn Fn() -> Vec<Vec<Bands>> + Sync),
    /// Stored rays of a patch, and of a volume zone or pane.
    pub stored_rays: [usize; 2],
    /// Store of finished rounds.
    pub checkpoints: &'a dyn CheckpointStore,
    /// The processes that share the work, and the observer.
    pub execution: Execution<'a>,
}

/// The response of the solution to a change of the incident radiation.
pub(crate) struct PassedOn {
    /// Change of the radiosities, W/m².
    pub radiosity: Vec<PaddedBands>,
    /// Further change of the incident radiation, by these radiosities, W/m².
    pub incident: Vec<Bands>,
}

impl GatherTask<'_> {
    /// Known incident radiation of zone `i` and its error, W/m².
    pub(crate) fn known_radiation(&self, i: usize) -> [Bands; 2] {
        self.known.get(i).copied().unwrap_or_default()
    }

    /// Error of zone `i` by the thickness of panes, W/m².
    pub(crate) fn error_by_thickness(&self, i: usize) -> Bands {
        self.thickness.get(i).copied().unwrap_or_default()
    }

    /// Number of quantities of a sample: the groups, their sum, the noise of the radiosities, and the surroundings alone.
    pub(crate) fn quantities(&self) -> usize {
        self.groups + 2 + usize::from(self.sky.is_some())
    }
}

/// 0 for patches, 1 for volume zones and panes.
pub(crate) fn kind_of(zones: &Zones, i: usize) -> usize {
    usize::from(i >= zones.patches.len())
}

/// The patches, and the volume zones with the panes.
pub(crate) fn ranges_of_kinds(zones: &Zones) -> [Range<usize>; 2] {
    [0..zones.patches.len(), zones.patches.len()..zones.len()]
}
