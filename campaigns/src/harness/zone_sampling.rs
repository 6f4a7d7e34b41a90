//! Zones for the path tracer: which are measured, and as what.

use std::ops::Range;
use zonal_reference::Rng;
use zonal_reference::path_tracer::Detector;
use zonal_scene::{Scene, ZoneRef, Zones};

/// Zone `i` as a detector of the path tracer.
pub(crate) fn detector(scene: &Scene, zones: &Zones, i: usize) -> Detector {
    match zones.zone(i) {
        ZoneRef::Patch(p) => Detector::patch(p),
        ZoneRef::Voxel(_, z) => {
            let grid = scene.voxel_grid().expect("voxel zones have a voxel grid");
            Detector::voxel(z, grid)
        }
        ZoneRef::Pane(_, z) => Detector::Pane { pane: z.pane, plate: z.plate },
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn picks_are_distinct_and_ascending() {
        let all = pick(10..20, 100, 1);
        assert_eq!(all, (10..20).collect::<Vec<_>>());
        let some = pick(0..1000, 50, 1);
        assert_eq!(some.len(), 50);
        assert!(some.windows(2).all(|w| w[0] < w[1]));
    }
}
