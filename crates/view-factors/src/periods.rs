//! Periodic geometry: blocks of images, and the directions whose rays may leave all represented images unseen.
//!
//! **Images.** The image (m, n) is displaced by m P₀ and n P₁ along the two horizontal axes. Images up to K_k periods away are represented. A block is a
//! rectangle of images; the recursions divide blocks as they divide nodes, so that many distant images cost as little as one.
//!
//! **Endless axes.** An occluder whose images adjoin along an axis is one long plate (`endless.rs`). Along an axis on which all occluders are
//! endless the view repeats for every displacement, real ones too; K is so large there that nothing beyond matters.
//!
//! **Unresolved rays.** A ray in direction d that meets nothing has left the geometry, of height H and of extent S_o along an axis o without a period, if
//!
//! ```text
//! |d_up| t ≥ H   or   |d_o| t ≥ S_o,      t = min_k reach_k/|d_k|,      reach_k = (K_k + 1) P_k − extent_k.
//! ```
//!
//! All other rays that meet nothing are unresolved. Their exchange U_i with facet i bounds all that is missing in row i, and min(U_i, U_j) all that is
//! missing in the exchange of i and j: a segment to an image that is not represented is an unresolved ray of both. K grows until U meets the tolerance or the
//! cost its limit.

use crate::bounds::Bounds;
use crate::bounds::direction_cell::DirectionCell;
use crate::settings::ViewFactorSettings;
use zonal_math::Vec3;

/// Slope that the first number of images resolves.
const FIRST_SLOPE: f64 = 0.05;
/// Images on each side along one axis at first, at most.
const MAX_FIRST_IMAGES: i32 = 24;
/// Reach along an endless axis relative to the extent of the geometry.
const ENDLESS_REACH: f64 = 1e5;
/// Images on each side of an endless axis, at most.
const MAX_ENDLESS_IMAGES: f64 = 1e9;
/// Images that an endless axis counts for in the cost.
const ENDLESS_COST: f64 = 16.0;
/// Images of all facets, at most, above those of the first choice.
const MAX_FACET_IMAGES: f64 = 1e5;
/// Images on each side of an axis, at most, that are evaluated one by one.
const MAX_SINGLE_IMAGES: i32 = 4096;
/// Slack of the cuts between resolved and unresolved directions against rounding.
const CUT_SLACK: f64 = 1.0 + 1e-12;

/// A rectangle of images, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ImageBlock {
    pub first: [i32; 2],
    pub last: [i32; 2],
}

impl ImageBlock {
    /// The geometry itself.
    pub(crate) const ORIGIN: ImageBlock = ImageBlock { first: [0; 2], last: [0; 2] };

    pub(crate) fn is_single(&self) -> bool {
        self.first == self.last
    }

    /// Two parts, divided along an axis: near images apart from distant ones.
    pub(crate) fn divided(&self, axis: usize) -> [ImageBlock; 2] {
        let middle = split(self.first[axis], self.last[axis]);
        let (mut low, mut high) = (*self, *self);
        low.last[axis] = middle;
        high.first[axis] = middle + 1;
        [low, high]
    }
}

/// The last number of the first part of a range of more than one: 0 apart from others, then numbers below twice the smallest.
pub(crate) fn split(first: i32, last: i32) -> i32 {
    match (first, last) {
        (0, _) => 0,
        (f, l) if f < 0 && l >= 0 => -1,
        (f, l) if f > 0 && l / 2 >= f => 2 * f - 1,
        (f, l) if l < 0 && f / 2 <= l => 2 * l,
        (f, l) => f + (l - f) / 2,
    }
}

/// The represented images.
#[derive(Clone, Debug)]
pub(crate) struct PeriodicImages {
    /// The axes of the two periods.
    pub axes: [usize; 2],
    /// Periods, m; zero along an axis without one.
    pub periods: [f64; 2],
    /// Images on each side.
    pub counts: [i32; 2],
    up: usize,
    size: [f64; 3],
    /// Lowest and highest coordinate along the axis that points up, m.
    heights: [f64; 2],
    /// Distance up to which all images are represented, m; infinite without a period.
    reach: [f64; 2],
}

impl PeriodicImages {
    /// The first choice of images; along axes marked as endless as many as matter.
    pub(crate) fn new(settings: &ViewFactorSettings, extent: &Bounds, endless: [bool; 2]) -> PeriodicImages {
        let axes = settings.horizontal_axes();
        let size = (extent.hi - extent.lo).array();
        let mut images = PeriodicImages {
            axes,
            periods: settings.periods.map(|p| p.unwrap_or(0.0)),
            counts: [0; 2],
            up: settings.up,
            size,
            heights: [extent.lo, extent.hi].map(|x| x.array()[settings.up]),
            reach: [f64::INFINITY; 2],
        };
        let rise = size[settings.up];
        let largest = size.iter().fold(0.0f64, |s, x| s.max(*x));
        for k in 0..2 {
            let Some(period) = settings.periods[k] else { continue };
            images.counts[k] = if endless[k] {
                (ENDLESS_REACH * largest.max(period) / period).ceil().min(MAX_ENDLESS_IMAGES) as i32
            } else {
                // Rays leave an axis without a period after its extent at the latest.
                let across = if settings.periods[1 - k].is_none() { size[axes[1 - k]] } else { 0.0 };
                let reach = (rise / FIRST_SLOPE).max(across);
                (reach / period).ceil().clamp(1.0, f64::from(MAX_FIRST_IMAGES)) as i32
            };
        }
        images.set_reach();
        images
    }

    fn set_reach(&mut self) {
        for k in 0..2 {
            if self.periods[k] > 0.0 {
                let reach = f64::from(self.counts[k] + 1) * self.periods[k] - self.size[self.axes[k]];
                self.reach[k] = reach.max(0.0);
            }
        }
    }

    /// True if the geometry repeats.
    pub(crate) fn any(&self) -> bool {
        self.counts != [0; 2]
    }

    /// Twice the images along the axes that are not endless; None beyond the limit of the cost for this number of facets.
    pub(crate) fn doubled(&self, endless: [bool; 2], facets: usize) -> Option<PeriodicImages> {
        let mut more = self.clone();
        let (mut cost, mut grows) = (facets as f64, false);
        // The shorter reach grows alone until both are alike.
        let shortest = (0..2).filter(|k| !endless[*k]).fold(f64::INFINITY, |s, k| s.min(self.reach[k]));
        for k in 0..2 {
            if self.periods[k] > 0.0 && !endless[k] {
                if self.reach[k] < 1.5 * shortest || shortest <= 0.0 {
                    more.counts[k] = self.counts[k].checked_mul(2)?;
                    grows = true;
                }
                cost *= f64::from(2 * more.counts[k] + 1);
            } else if self.periods[k] > 0.0 {
                cost *= ENDLESS_COST;
            }
        }
        more.set_reach();
        (grows && cost <= MAX_FACET_IMAGES).then_some(more)
    }

    /// Images of a pair that may be evaluated one by one.
    pub(crate) fn finite_count(&self) -> f64 {
        let count = |k: usize| f64::from(2 * self.counts[k].min(MAX_SINGLE_IMAGES) + 1);
        count(0) * count(1)
    }

    /// The displacement of the first image of a block, m.
    pub(crate) fn shift(&self, block: &ImageBlock) -> Vec3 {
        self.displacement(block.first)
    }

    fn displacement(&self, image: [i32; 2]) -> Vec3 {
        let mut by = [0.0; 3];
        (0..2).for_each(|k| by[self.axes[k]] = f64::from(image[k]) * self.periods[k]);
        Vec3::from_array(by)
    }

    /// One period along an axis, m.
    pub(crate) fn step(&self, axis: usize) -> Vec3 {
        let mut by = [0.0; 3];
        by[self.axes[axis]] = self.periods[axis];
        Vec3::from_array(by)
    }

    /// The bounds of all images of a block.
    pub(crate) fn bounds(&self, b: &Bounds, block: &ImageBlock) -> Bounds {
        if *block == ImageBlock::ORIGIN {
            return *b;
        }
        Bounds { lo: b.lo + self.displacement(block.first), hi: b.hi + self.displacement(block.last) }
    }

    /// The axis along which a block is divided first: the one with the larger displacements.
    pub(crate) fn longer_axis(&self, block: &ImageBlock) -> usize {
        let length = |k: usize| f64::from(block.last[k] - block.first[k]) * self.periods[k];
        usize::from(length(1) > length(0))
    }

    /// All images of occluders that are endless along the marked axes.
    pub(crate) fn all(&self, endless: [bool; 2]) -> ImageBlock {
        let count = |k: usize| if endless[k] { 0 } else { self.counts[k] };
        ImageBlock { first: [-count(0), -count(1)], last: [count(0), count(1)] }
    }

    /// Blocks that hold one of each two opposite images; the geometry itself comes first.
    pub(crate) fn half(&self) -> Vec<ImageBlock> {
        let [k, l] = self.counts;
        let mut blocks = vec![ImageBlock::ORIGIN];
        if l > 0 {
            blocks.push(ImageBlock { first: [0, 1], last: [0, l] });
        }
        if k > 0 {
            blocks.push(ImageBlock { first: [1, -l], last: [k, l] });
        }
        blocks
    }

    /// Smallest |rise| per unit of |d_axis| above which a direction on that face of the cube is resolved.
    fn resolved_slope(&self, face: usize) -> f64 {
        let rise = self.size[self.up];
        let own = self.axes.iter().position(|a| *a == face);
        let along = |k: usize| if self.periods[k] > 0.0 { rise / self.reach[k] } else { 0.0 };
        match own {
            // The rays of the face leave an extent without a period before the images of the other axis end.
            Some(k) if self.periods[k] == 0.0 && self.reach[1 - k] >= self.size[face] => 0.0,
            _ => along(0).max(along(1)),
        }
    }

    /// The coordinates ± of a face's direction cells at which cells are cut along one of their two ranges.
    pub(crate) fn cut(&self, face: usize, coordinate: usize) -> f64 {
        let rise = self.size[self.up];
        let of = |axis: usize| self.axes.iter().position(|a| *a == axis);
        let cut = match (of(face), of(coordinate)) {
            // The face of the zenith.
            (None, Some(k)) if self.periods[k] > 0.0 && rise > 0.0 => self.reach[k] / rise / CUT_SLACK,
            (Some(_), None) => self.resolved_slope(face) * CUT_SLACK,
            (Some(k), Some(o)) if self.periods[k] > 0.0 && self.periods[o] == 0.0 => {
                self.size[coordinate] / self.reach[k] * CUT_SLACK
            }
            _ => 0.0,
        };
        if cut > 0.0 && cut < 1.0 { cut } else { 0.0 }
    }

    /// The rise or fall after which rays from within bounds have left the geometry, m.
    pub(crate) fn rise_from(&self, b: &Bounds, is_above: bool) -> f64 {
        let [lowest, highest] = self.heights;
        let rise = if is_above { highest - b.lo.array()[self.up] } else { b.hi.array()[self.up] - lowest };
        rise.max(0.0)
    }

    /// False if every ray of the cell that meets no represented image has left the geometry.
    pub(crate) fn is_unresolved(&self, cell: &DirectionCell) -> bool {
        self.is_unresolved_within(cell, self.size[self.up])
    }

    /// The same for rays that leave the geometry after a rise or fall of `rise` (m).
    pub(crate) fn is_unresolved_within(&self, cell: &DirectionCell, rise: f64) -> bool {
        let (least, most) = cell.extremes();
        let run = (0..2)
            .filter(|k| self.periods[*k] > 0.0)
            .fold(f64::INFINITY, |s, k| s.min(self.reach[k] / most[self.axes[k]].max(f64::MIN_POSITIVE)));
        let leaves = |axis: usize| least[axis] * run >= if axis == self.up { rise } else { self.size[axis] };
        run.is_finite() && !leaves(self.up) && !(0..2).any(|k| self.periods[k] == 0.0 && leaves(self.axes[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn divided_blocks_hold_every_image_once() {
        let mut stack = vec![ImageBlock { first: [-37, -3], last: [41, 90] }];
        let mut seen = std::collections::BTreeSet::new();
        while let Some(b) = stack.pop() {
            if b.is_single() {
                assert!(seen.insert(b.first));
                continue;
            }
            let axis = usize::from(b.first[0] == b.last[0]);
            stack.extend(b.divided(axis));
        }
        assert_eq!(seen.len(), 79 * 94);
    }

    #[test]
    fn half_of_the_images_and_their_opposites_are_all() {
        let settings = ViewFactorSettings { periods: [Some(1.0), Some(2.0)], ..Default::default() };
        let extent = Bounds { lo: Vec3::ZERO, hi: Vec3::ONE };
        let images = PeriodicImages::new(&settings, &extent, [false; 2]);
        let count = |b: &ImageBlock| (0..2).map(|k| i64::from(b.last[k] - b.first[k] + 1)).product::<i64>();
        let half: i64 = images.half().iter().map(count).sum();
        assert_eq!(2 * half - 1, count(&images.all([false; 2])));
    }
}
