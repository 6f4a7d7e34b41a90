//! Cells of the bounding box through which rays of a group of zones leave the scene, marked by pilot rays.
//!
//! The share of the rays that leave through other cells than those marked is about
//!
//! ```text
//!     (n₁ + 1)/(n + 1)
//! ```
//!
//! with n₁ of the n pilot rays of a group alone in their cells (Good 1953, with one more that all may have missed).

use super::box_cells::{BoxCell, BoxSides};
use super::ray_tally::TracedScene;
use super::zone_rays::sample_point;
use rayon::prelude::*;
use std::ops::Range;
use zonal_math::low_discrepancy;
use zonal_scene::Bands;

/// Maximum number of open cells; with more the scene is open rather than a room with openings.
const MAX_OPEN_CELLS: usize = 512;
/// Pilot rays of a zone that tell at once a scene that is open.
const FIRST_MARKING_RAYS_PER_ZONE: usize = 16;

/// The open cells of a group of zones.
#[derive(Clone, Debug)]
pub(super) struct OpenCells {
    pub sides: BoxSides,
    pub cells: Vec<BoxCell>,
    /// Index into `cells` for each cell of the box.
    pub index: Vec<Option<u16>>,
    /// Share of the rays that may leave through other cells.
    pub missed: f64,
}

impl OpenCells {
    /// Marks the cells of the `group` of zones by `per_zone` pilot rays of each, with as many cells along the longest side of the box as the first of `divisions` that leaves few of them
    /// open; `None` if rays leave nearly everywhere.
    pub(super) fn mark(
        traced: TracedScene,
        divisions: &[f64],
        group: &[usize],
        per_zone: usize,
    ) -> Option<OpenCells> {
        let first = per_zone.min(FIRST_MARKING_RAYS_PER_ZONE);
        divisions.iter().find_map(|&along| {
            let sides = BoxSides::of(traced.transport.scene(), along);
            let mut hits = count_hits(traced, sides, group, 0..first);
            if hits.iter().filter(|h| **h > 0).count() > MAX_OPEN_CELLS {
                return None;
            }
            let further = count_hits(traced, sides, group, first..per_zone);
            hits.iter_mut().zip(further).for_each(|(h, f)| *h = add_hits(*h, f));
            OpenCells::of_hits(sides, &hits, group.len() * per_zone)
        })
    }

    fn of_hits(sides: BoxSides, hits: &[u8], rays: usize) -> Option<OpenCells> {
        let cells: Vec<BoxCell> =
            sides.cells().into_iter().zip(hits).filter(|c| *c.1 > 0).map(|c| c.0).collect();
        let mut count = 0..;
        let index = hits.iter().map(|h| if *h > 0 { count.next() } else { None }).collect();
        let alone = hits.iter().filter(|h| **h == 1).count();
        let missed = (alone + 1) as f64 / (rays + 1) as f64;
        (cells.len() <= MAX_OPEN_CELLS).then_some(OpenCells { sides, cells, index, missed })
    }
}

/// Sum of two numbers of pilot rays, at most 2.
fn add_hits(a: u8, b: u8) -> u8 {
    (a + b).min(2)
}

/// Pilot rays of the zones of `list` that leave through each cell of the box, at most 2.
fn count_hits(traced: TracedScene, sides: BoxSides, list: &[usize], rays: Range<usize>) -> Vec<u8> {
    // Pilot rays come from another sample than the rays of the estimate.
    let seed = low_discrepancy::split_mix64(traced.seed ^ u64::MAX);
    let exit_cell = |i: usize, k: usize| {
        let ray = traced.ray(i, sample_point(traced.zones, i, seed, k));
        let lost = traced.trace(ray);
        (!lost.on_back && lost.share != Bands::ZERO).then(|| sides.exit_cell(ray.origin, ray.dir))
    };
    let of_zone = |mut hits: Vec<u8>, &i: &usize| {
        rays.clone().filter_map(|k| exit_cell(i, k)).for_each(|c| hits[c] = add_hits(hits[c], 1));
        hits
    };
    let none = || vec![0; sides.cells().len()];
    let sum = |a: Vec<u8>, b: Vec<u8>| a.iter().zip(b).map(|(a, b)| add_hits(*a, b)).collect();
    list.par_iter().fold(none, of_zone).reduce(none, sum)
}
