//! Shafts: the union of all segments between two boxes, or of all rays from a box into a cone of directions. An obstruction outside a shaft
//! hides nothing.
//!
//! Between two boxes the shaft lies in the box of both and, for each pair of axes, between the lines that support both rectangles of the
//! projection (Haines and Wallace 1991). From a box along directions of one face of the direction cube, the
//! shaft's section at height s above the box is the box's section widened by s times the face cell.

use crate::bounds::Bounds;
use crate::bounds::direction_cell::DirectionCell;

/// A plane n·x ≤ c in two of the three coordinates.
#[derive(Clone, Copy, Debug)]
struct SupportLine {
    axes: [usize; 2],
    normal: [f64; 2],
    limit: f64,
}

/// The segments between two boxes.
#[derive(Clone, Debug)]
pub(crate) struct BoxShaft {
    hull: Bounds,
    lines: [SupportLine; 6],
    count: usize,
    contact: f64,
}

impl BoxShaft {
    /// The shaft of two boxes; obstructions that enter it by no more than `contact` (m) count as outside.
    pub(crate) fn new(a: &Bounds, b: &Bounds, contact: f64) -> BoxShaft {
        let empty = SupportLine { axes: [0, 1], normal: [0.0; 2], limit: 0.0 };
        let mut shaft = BoxShaft { hull: a.union(*b), lines: [empty; 6], count: 0, contact };
        let side = |bounds: &Bounds, axis: usize, high: bool| {
            if high { bounds.hi.array()[axis] } else { bounds.lo.array()[axis] }
        };
        for axes in [[0, 1], [1, 2], [2, 0]] {
            for (high_u, high_v) in [(false, false), (false, true), (true, false), (true, true)] {
                let p = [side(a, axes[0], high_u), side(a, axes[1], high_v)];
                let q = [side(b, axes[0], high_u), side(b, axes[1], high_v)];
                let d = [q[0] - p[0], q[1] - p[1]];
                // The line through both corners supports both rectangles if its normal points into the quadrant of the corners.
                let (mut n, along) =
                    ([d[1], -d[0]], [if high_u { 1.0 } else { -1.0 }, if high_v { 1.0 } else { -1.0 }]);
                if n[0] * along[0] < 0.0 || n[1] * along[1] < 0.0 {
                    n = [-n[0], -n[1]];
                }
                let length = n[0].hypot(n[1]);
                if n[0] * along[0] <= 0.0 || n[1] * along[1] <= 0.0 || shaft.count == 6 {
                    continue;
                }
                let normal = [n[0] / length, n[1] / length];
                let limit = normal[0] * p[0] + normal[1] * p[1];
                shaft.lines[shaft.count] = SupportLine { axes, normal, limit };
                shaft.count += 1;
            }
        }
        shaft
    }

    /// True if the box lies outside the shaft.
    pub(crate) fn excludes(&self, o: &Bounds) -> bool {
        let (lo, hi) = (o.lo.array(), o.hi.array());
        let (from, to) = (self.hull.lo.array(), self.hull.hi.array());
        let apart = (0..3).any(|k| hi[k] <= from[k] + self.contact || lo[k] >= to[k] - self.contact);
        // A hull without extent along an axis is no reason to exclude anything.
        let flat = (0..3).any(|k| to[k] - from[k] <= 2.0 * self.contact);
        if apart && !flat {
            return true;
        }
        self.lines[..self.count].iter().any(|l| {
            let least =
                |i: usize| l.normal[i] * if l.normal[i] > 0.0 { lo[l.axes[i]] } else { hi[l.axes[i]] };
            least(0) + least(1) >= l.limit - self.contact
        })
    }
}

/// The rays from a box into a cell of directions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SkyShaft {
    from: Bounds,
    cell: DirectionCell,
    contact: f64,
}

impl SkyShaft {
    pub(crate) fn new(from: &Bounds, cell: &DirectionCell, contact: f64) -> SkyShaft {
        SkyShaft { from: *from, cell: *cell, contact }
    }

    /// True if no ray meets the box beyond the contact distance.
    pub(crate) fn excludes(&self, o: &Bounds) -> bool {
        let (lo, hi) = (o.lo.array(), o.hi.array());
        let (from, to) = (self.from.lo.array(), self.from.hi.array());
        let DirectionCell { axis, sign, range } = self.cell;
        // Heights of the obstruction above the box along the axis of the face.
        let (least, most) = if sign > 0.0 {
            (lo[axis] - to[axis], hi[axis] - from[axis])
        } else {
            (from[axis] - hi[axis], to[axis] - lo[axis])
        };
        if most <= self.contact {
            return true;
        }
        let heights = [least.max(0.0), most];
        [1, 2].into_iter().any(|k| {
            let (axis, [low, high]) = ((axis + k) % 3, range[k - 1]);
            let (below, above) = (lo[axis] - to[axis], hi[axis] - from[axis]);
            let furthest = (high * heights[0]).max(high * heights[1]);
            let nearest = (low * heights[0]).min(low * heights[1]);
            below >= furthest - self.contact || above <= nearest + self.contact
        })
    }
}
