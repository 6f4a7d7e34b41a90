//! Points of the Gauss rules for a cell of a table with linear bases.
//!
//! Along an axis, densities take three of the 2n degrees: for the kernel ϱ^{−(2n−3)} is left (ϱ = 4/ratio + 2 at least, see `density_rules.rs`, for a
//! cell whose longest edge is `ratio` of its nearest distance), and the remainder of e^{−depth·x} (`depth`: the change of the optical depth along the edge).
//! Along the radius of a pyramid densities take nine degrees. The kernel on its base has ϱ ≥ 3.4 up to the largest aspect.

use super::TableAccuracy;

/// Points along an axis, at most.
pub(super) const MAX_POINTS: usize = 12;
/// Points along each axis of the base of a pyramid, at most.
pub(super) const BASE_POINTS: usize = 16;
/// Points along the radius of a pyramid for its densities.
const POINTS_OF_DENSITIES: usize = 3;

/// Numbers of points, each up to a limit of what it depends on.
struct RuleSizes {
    of_ratio: [(f64, usize); 7],
    of_depth: [(f64, usize); 6],
    base: usize,
    /// Along the radius of a pyramid that is deeper than an undivided cell: by a factor √3 at most.
    deep_radius: usize,
}

const UNLIMITED: f64 = f64::INFINITY;

/// About 1e-11.
const FULL_ACCURACY_SIZES: RuleSizes = RuleSizes {
    of_ratio: [(0.025, 4), (0.1, 5), (0.25, 6), (0.45, 7), (0.65, 8), (0.9, 10), (UNLIMITED, MAX_POINTS)],
    of_depth: [(0.07, 4), (0.3, 5), (0.9, 6), (1.8, 7), (2.7, 8), (UNLIMITED, 10)],
    base: BASE_POINTS,
    deep_radius: 16,
};

/// About 1e-8.
const COMPARISON_SIZES: RuleSizes = RuleSizes {
    of_ratio: [(0.025, 3), (0.1, 4), (0.25, 5), (0.45, 6), (0.65, 6), (0.9, 7), (UNLIMITED, 8)],
    of_depth: [(0.02, 3), (0.3, 4), (0.9, 5), (1.8, 6), (2.7, 7), (UNLIMITED, 8)],
    base: 11,
    deep_radius: 13,
};

/// The points up to the first limit that is not exceeded.
fn find(sizes: &[(f64, usize)], x: f64) -> usize {
    sizes.iter().find(|s| x <= s.0).map_or(MAX_POINTS, |s| s.1)
}

impl TableAccuracy {
    fn sizes(self) -> &'static RuleSizes {
        match self {
            TableAccuracy::Full => &FULL_ACCURACY_SIZES,
            TableAccuracy::Comparison => &COMPARISON_SIZES,
        }
    }
    /// Points along an axis.
    pub(super) fn points(self, ratio: f64, depth: f64) -> usize {
        find(&self.sizes().of_ratio, ratio).max(find(&self.sizes().of_depth, depth))
    }
    /// Points along the radius of a pyramid of an optical depth, which is deep if it exceeds the `limit` of an undivided cell.
    pub(super) fn radial_points(self, limit: f64, depth: f64) -> usize {
        if depth > limit { self.sizes().deep_radius } else { self.points(0.0, depth) + POINTS_OF_DENSITIES }
    }
    /// Points along each axis of the base of a pyramid.
    pub(super) fn base_points(self) -> usize {
        self.sizes().base
    }
}
