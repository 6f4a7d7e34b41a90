//! Zones for the path tracer: which are measured, and as what.

use std::ops::Range;
use zonal_reference::Rng;
use zonal_reference::path_tracer::Detector;
use zonal_scene::{Scene, Zones};

/// Zone `i` as a detector of the path tracer.
pub(crate) fn detector(scene: &Scene, zones: &Zones, i: usize) -> Detector {
    if i < zones.voxel_offset() {
        return Detector::patch(&zones.patches[i]);
    }
    if i >= zones.pane_offset() {
        let z = &zones.panes[i - zones.pane_offset()];
        return Detector::Pane { pane: z.pane, plate: z.plate };
    }
    let grid = scene.voxel_grid().expect("voxel zones have a voxel grid");
    Detector::voxel(zones.voxels.at(i - zones.voxel_offset()), grid)
}

/// Up to `count` zones of a range at random, each with equal chances, ascending.
pub(crate) fn pick(range: Range<usize>, count: usize, seed: u64) -> Vec<usize> {
    let (mut rng, mut rest) = (Rng::new(seed), range.collect::<Vec<usize>>());
    let mut out = Vec::new();
    while out.len() < count && !rest.is_empty() {
        let k = (rng.uniform() * rest.len() as f64) as usize;
        out.push(rest.swap_remove(k.min(rest.len() - 1)));
    }
    out.sort_unstable();
    out
}
