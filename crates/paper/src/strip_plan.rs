//! The plan of a strip computation: required accuracy, ratio and order, segments with their references, rules by distance.

use super::gegenbauer_series::{self, MAX_ORDER};
use super::trapezoid_gauss::{PointsByDistance, TrapezoidDensity};
use super::uniform_grid::UniformGrid;
use crate::rounding::UNIT_ROUNDOFF;
use zonal_exchange::aligned::Cuboid;

/// Required accuracy of the strips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StripAccuracy {
    /// A relative radius for every factor.
    Tolerance(f64),
    /// A fixed order and the largest ratio p̂ < 1 of a reference; the radius follows.
    Order {
        /// N, at most [`MAX_ORDER`].
        order: usize,
        /// p̂.
        ratio: f64,
    },
}

/// How the moments P_n are integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MomentQuadrature {
    /// Three dimensions: Gauss rules of the trapezoid densities, their points chosen by the bound.
    Reduced,
    /// Six dimensions as in the paper: this many Gauss–Legendre points in each direction of both voxels.
    SixDimensional(usize),
}

/// Orders considered by a plan.
const CANDIDATE_ORDERS: std::ops::RangeInclusive<usize> = 4..=40;
/// Strips sampled along each of two axes to choose the axis.
const SAMPLED_STRIPS_PER_AXIS: usize = 4;
/// Set-up cost of a reference, in orders.
const REFERENCE_SETUP_COST: f64 = 6.0;
/// Cost of a division in orders: that of a direct evaluation at a node.
pub(super) const DIVISION_COST: usize = 5;
/// Share of the tolerance for truncation.
const TRUNCATION_SHARE: f64 = 0.7;
/// Share of the tolerance for quadrature; rounding has the rest.
const QUADRATURE_SHARE: f64 = 0.2;
/// Relative tolerance of the rules for a fixed order.
const FIXED_ORDER_RULE_TOLERANCE: f64 = 1e-15;
/// Smallest relative tolerance of a plan and of the exact integral.
pub(super) const MIN_TOLERANCE: f64 = 1e-13;
/// Largest relative change of a factor by the rounding of coordinates; beyond it the exact integral is used.
const MAX_RELATIVE_NODE_ERROR: f64 = 1e-9;

/// Data common to all strips along an axis. Lengths in steps; axes in the order strip, next, next but one.
pub(super) struct StripFrame {
    pub axes: [usize; 3],
    /// Centre of the first voxel minus centre of V_i.
    pub start: [f64; 3],
    /// Steps of the grid along the three axes (the first is 1).
    pub step: [f64; 3],
    pub count: [usize; 3],
    pub densities: [TrapezoidDensity; 3],
    pub extents: [[f64; 2]; 3],
    pub rule_tables: [PointsByDistance; 3],
    /// Index of the rule table that an axis uses: equal axes share one.
    pub shared_table: [usize; 3],
    pub means: MomentQuadrature,
    pub ask: StripAccuracy,
    pub ratio: f64,
    pub truncation: f64,
    /// V_iV_j/(π d²), m⁴.
    pub factor_scale: f64,
    /// Error of a node in units of the step.
    pub node_error: f64,
    /// Relative error of a voxel's volume by the rounding of its corners.
    pub volume_error: f64,
}

/// A reference and the voxels that it serves, both ends inside.
#[derive(Clone, Copy, Debug)]
pub(super) struct StripSegment {
    pub from: usize,
    pub reference: usize,
    pub to: usize,
}

/// One strip of the grid.
pub(super) struct Strip {
    /// Indices of the strip along the two other axes.
    pub at: [usize; 2],
    /// Centre of its first voxel minus centre of V_i.
    pub start: [f64; 3],
    /// Squared distance of the strip's line of boxes.
    pub lateral: f64,
}

impl StripFrame {
    pub(super) fn new(
        v: &Cuboid,
        grid: &UniformGrid,
        axis: usize,
        ask: StripAccuracy,
        means: MomentQuadrature,
        limits: StripLimits,
    ) -> StripFrame {
        let axes = [axis, (axis + 1) % 3, (axis + 2) % 3];
        let d = grid.cell[axis];
        let e = v.extent();
        let start = axes.map(|k| {
            let first = grid.origin[k] + 0.5 * grid.cell[k];
            (first - 0.5 * (v.lo[k] + v.hi[k])) / d
        });
        let extents = axes.map(|k| [e[k] / d, grid.cell[k] / d]);
        let densities = extents.map(|[a, b]| TrapezoidDensity::new(a, b));
        let h2 = densities.iter().map(|s| s.half * s.half).sum();
        let StripLimits { ratio, truncation, quadrature } = limits;
        let rule_table = |k: usize| match means {
            MomentQuadrature::Reduced => PointsByDistance::new(densities[k].half, h2, quadrature / 3.0),
            MomentQuadrature::SixDimensional(m) => PointsByDistance::fixed(extents[k], h2, m),
        };
        let far = grid.voxel(grid.dims.map(|n| n.max(1) - 1)).hi;
        let corners = [v.lo, v.hi, grid.origin, far];
        let size = corners.iter().flat_map(|c| c.array()).fold(0.0f64, |m, x| m.max(x.abs()));
        StripFrame {
            axes,
            start,
            step: axes.map(|k| grid.cell[k] / d),
            count: axes.map(|k| grid.dims[k]),
            densities,
            extents,
            rule_tables: [rule_table(0), rule_table(1), rule_table(2)],
            shared_table: [0, 1, 2].map(|k| if extents[k] == extents[0] { 0 } else { k }),
            means,
            ask,
            ratio,
            truncation,
            factor_scale: v.measure() * grid.cell.product() / (std::f64::consts::PI * d * d),
            // Each coordinate of a node: at most eight roundings of numbers up to twice the largest coordinate.
            node_error: 3f64.sqrt() * 16.0 * UNIT_ROUNDOFF * size / d,
            // Two corners, each within two roundings, on three axes.
            volume_error: 16.0 * UNIT_ROUNDOFF * size
                / axes.iter().fold(f64::INFINITY, |m, &k| m.min(grid.cell[k])),
        }
    }

    pub(super) fn centre(&self, i: usize, j: usize, k: usize) -> [f64; 3] {
        let at = |axis: usize, n: usize| self.start[axis] + self.step[axis] * n as f64;
        [at(0, i), at(1, j), at(2, k)]
    }

    /// The strip with these indices along the two other axes.
    #[inline(always)]
    pub(super) fn strip(&self, j: usize, k: usize) -> Strip {
        let start = self.centre(0, j, k);
        Strip { at: [j, k], start, lateral: self.lateral_square(start) }
    }

    /// The cell of the grid that is the `i`-th of a strip.
    pub(super) fn cell(&self, i: usize, [j, k]: [usize; 2]) -> [usize; 3] {
        let mut c = [0; 3];
        (c[self.axes[0]], c[self.axes[1]], c[self.axes[2]]) = (i, j, k);
        c
    }

    /// Squared distance of the strip's line of boxes.
    #[inline(always)]
    pub(super) fn lateral_square(&self, centre: [f64; 3]) -> f64 {
        let gap = |k: usize| (centre[k].abs() - self.densities[k].half).max(0.0);
        gap(1) * gap(1) + gap(2) * gap(2)
    }

    /// Distance of the boxes for a coordinate `x` of the centre along the strip.
    #[inline(always)]
    pub(super) fn distance(&self, lateral: f64, x: f64) -> f64 {
        let gap = (x.abs() - self.densities[0].half).max(0.0);
        (lateral + gap * gap).sqrt() * (1.0 - 1e-14) - self.node_error
    }

    /// The segment that begins at voxel `from` of a strip of `n`.
    #[inline(always)]
    pub(super) fn segment(&self, lateral: f64, x0: f64, from: usize, n: usize) -> StripSegment {
        let reach = |i: usize| self.ratio * self.distance(lateral, x0 + i as f64);
        let mut reference = from;
        while reference + 1 < n && (reference + 1 - from) as f64 <= reach(reference + 1) {
            reference += 1;
        }
        let forth = reach(reference).max(0.0) as usize;
        StripSegment { from, reference, to: (reference + forth).min(n - 1) }
    }

    /// The least distance of a segment's boxes.
    #[inline(always)]
    pub(super) fn segment_distance(&self, lateral: f64, x0: f64, s: &StripSegment) -> f64 {
        let (a, b) = (x0 + s.from as f64, x0 + s.to as f64);
        let x = if a * b <= 0.0 { 0.0 } else { a.abs().min(b.abs()) };
        self.distance(lateral, x)
    }

    /// Points of the three rules at a distance, the relative error of the three together, and the factors of their defects.
    #[inline(always)]
    pub(super) fn rules(&self, g: f64) -> Option<([usize; 3], f64, [f64; 3])> {
        if 2.0 * self.node_error > MAX_RELATIVE_NODE_ERROR * g {
            return None;
        }
        let [a, b, c] = self.shared_table.map(|k| self.rule_tables[k].at(g));
        let (a, b, c) = (a?, b?, c?);
        let error = a.error + b.error + c.error;
        Some(([a.points, b.points, c.points], error, [a.factor, b.factor, c.factor]))
    }

    pub(super) fn order(&self, ratio: f64) -> usize {
        match self.ask {
            StripAccuracy::Order { order, .. } => order,
            StripAccuracy::Tolerance(_) => gegenbauer_series::min_order(ratio, self.truncation),
        }
    }

    /// Estimated cost of all strips, from a sample of at most [`SAMPLED_STRIPS_PER_AXIS`]² of them.
    pub(super) fn sampled_cost(&self) -> f64 {
        let [_, n, m] = self.count;
        let some = |n: usize| {
            (0..n.min(SAMPLED_STRIPS_PER_AXIS))
                .map(move |i| (2 * i + 1) * n / (2 * n.min(SAMPLED_STRIPS_PER_AXIS)))
        };
        let sum: f64 = some(n).flat_map(|j| some(m).map(move |k| (j, k))).map(|(j, k)| self.cost(j, k)).sum();
        sum * (n * m) as f64 / (n.min(SAMPLED_STRIPS_PER_AXIS) * m.min(SAMPLED_STRIPS_PER_AXIS)).max(1) as f64
    }

    /// Estimated cost of a strip.
    pub(super) fn cost(&self, j: usize, k: usize) -> f64 {
        let centre = self.centre(0, j, k);
        let (lateral, n) = (self.lateral_square(centre), self.count[0]);
        let (mut from, mut cost) = (0, 0.0);
        while from < n {
            let s = self.segment(lateral, centre[0], from, n);
            let grid = s.to + 1 - s.from;
            let nodes = match self.rules(self.segment_distance(lateral, centre[0], &s)) {
                Some((p, ..)) if self.means == MomentQuadrature::Reduced => {
                    p.iter().product::<usize>() as f64
                }
                Some((p, ..)) => p.iter().map(|m| m * m).product::<usize>() as f64,
                None => 20_000.0,
            };
            let ratio = (s.reference - s.from).max(s.to - s.reference) as f64
                / self.distance(lateral, centre[0] + s.reference as f64);
            let orders = (DIVISION_COST * grid).min(DIVISION_COST + self.order(ratio.min(self.ratio)));
            cost += nodes * orders as f64 + 40.0 * grid as f64;
            from = s.to + 1;
        }
        cost
    }
}

/// Limits of a plan.
#[derive(Clone, Copy)]
pub(super) struct StripLimits {
    /// The largest ratio p̂ of a segment.
    pub ratio: f64,
    /// Relative truncation error.
    pub truncation: f64,
    /// Relative error of the rules.
    pub quadrature: f64,
}

/// The limits that follow from the required accuracy.
pub(super) fn strip_limits(ask: StripAccuracy) -> StripLimits {
    match ask {
        StripAccuracy::Order { order, ratio } => {
            assert!(order <= MAX_ORDER && ratio > 0.0 && ratio < 1.0, "order {order}, ratio {ratio}");
            StripLimits { ratio, truncation: f64::INFINITY, quadrature: FIXED_ORDER_RULE_TOLERANCE }
        }
        StripAccuracy::Tolerance(tolerance) => {
            assert!(tolerance > 0.0, "tolerance {tolerance}");
            let truncation = TRUNCATION_SHARE * tolerance.clamp(MIN_TOLERANCE, 0.1);
            let gain = |order: usize| {
                let p = gegenbauer_series::max_ratio(order, truncation);
                (((1.0 + p) / (1.0 - p)).ln() / (order as f64 + REFERENCE_SETUP_COST), p)
            };
            let best =
                CANDIDATE_ORDERS.step_by(3).map(gain).fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
            let quadrature = QUADRATURE_SHARE * tolerance.clamp(MIN_TOLERANCE, 0.1);
            StripLimits { ratio: best.1, truncation, quadrature }
        }
    }
}
