//! Shaft culling: facets that occlude no segment between two zones (Haines and Wallace 1994).
//!
//! With P and Q the points of two zones, every segment between them lies in hull(P ∪ Q), thus below each plane
//! n·x = max over P ∪ Q of n·p, for any n. A plate whose corners all lie above one such plane meets no segment, nor does one whose
//! own plane has P ∪ Q on one side. The directions n:
//!
//! - the six directions of the axes;
//! - for each quadrant of each coordinate plane the normal of the line through the outermost corners of both boxes there, where it
//!   points into the quadrant: it then touches both boxes, a side of the shaft;
//! - the back of a zone that is seen from its front alone, at the height of the zone itself.
//!
//! The test is conservative: no plate that can occlude is culled; a plate that cannot may be kept. A plate that reaches into the
//! hull by no more than the rounding of a coordinate counts as touching it.

use crate::intersect::{PreparedPlate, Tolerance};
use zonal_math::Vec3;

/// Most planes of a shaft: axes, sides, fronts of the two zones.
const MAX_PLANES: usize = 6 + 12 + 2;

/// A zone as the end of a shaft.
#[derive(Clone, Copy, Debug)]
pub struct ShaftEnd<'a> {
    /// Points whose convex hull holds the zone, m; at least one.
    pub points: &'a [Vec3],
    /// Unit normal of a flat zone that exchanges with its front only.
    pub front: Option<Vec3>,
}

impl ShaftEnd<'_> {
    fn bounds(&self) -> [Vec3; 2] {
        let first = [self.points[0]; 2];
        self.points.iter().fold(first, |[lo, hi], p| [lo.min(*p), hi.max(*p)])
    }
}

/// Planes n·x = c above the hull of two zones.
pub(crate) struct Shaft<'a> {
    ends: [ShaftEnd<'a>; 2],
    planes: [(Vec3, f64); MAX_PLANES],
    count: usize,
}

impl<'a> Shaft<'a> {
    pub(crate) fn new(ends: [ShaftEnd<'a>; 2]) -> Shaft<'a> {
        let mut shaft = Shaft { ends, planes: [(Vec3::ZERO, 0.0); MAX_PLANES], count: 0 };
        let boxes = ends.map(|e| e.bounds());
        for x in 0..3 {
            for side in [0, 1] {
                let mut n = [0.0; 3];
                n[x] = sign(side);
                shaft.push_support_plane(Vec3::from_array(n));
            }
        }
        for (x, y) in [(0, 1), (1, 2), (2, 0)] {
            for quadrant in 0..4 {
                let (i, j) = (quadrant & 1, quadrant >> 1);
                let (dx, dy) = (boxes[1][i][x] - boxes[0][i][x], boxes[1][j][y] - boxes[0][j][y]);
                // The normal of (dx, dy) points into the quadrant only where dx and dy have opposite signs there.
                if dx * dy * sign(i) * sign(j) < 0.0 {
                    let mut n = [0.0; 3];
                    (n[x], n[y]) = (dy.abs() * sign(i), dx.abs() * sign(j));
                    shaft.push_support_plane(Vec3::from_array(n).normalized());
                }
            }
        }
        for end in ends {
            if let Some(n) = end.front {
                shaft.push(-n, support(end.points, -n));
            }
        }
        shaft
    }

    /// The planes.
    pub(crate) fn planes(&self) -> &[(Vec3, f64)] {
        &self.planes[..self.count]
    }

    fn push(&mut self, n: Vec3, c: f64) {
        self.planes[self.count] = (n, c);
        self.count += 1;
    }

    fn push_support_plane(&mut self, n: Vec3) {
        self.push(n, support(self.ends[0].points, n).max(support(self.ends[1].points, n)));
    }

    /// True when some plane of the shaft has all of a box above it, given by its lower and upper corner.
    pub(crate) fn avoids_box(&self, [lo, hi]: [Vec3; 2], tol: &Tolerance) -> bool {
        let lies_above = |&(n, c): &(Vec3, f64)| {
            let pick = |n: f64, l: f64, h: f64| if n > 0.0 { l } else { h };
            let lowest = Vec3::from_array([0, 1, 2].map(|k| pick(n[k], lo[k], hi[k])));
            n.dot(lowest) >= c - tol.rounding
        };
        self.planes().iter().any(lies_above)
    }

    /// False when the plate can cross no segment between the ends.
    pub(crate) fn may_meet(&self, plate: &PreparedPlate, tol: &Tolerance) -> bool {
        let heights = || self.ends.iter().flat_map(|e| e.points).map(|p| plate.height(*p));
        if heights().all(|h| h <= tol.plane) || heights().all(|h| h >= -tol.plane) {
            return false;
        }
        let (corners, count) = plate.corners();
        let lies_above =
            |&(n, c): &(Vec3, f64)| corners[..count].iter().all(|x| n.dot(*x) >= c - tol.rounding);
        !self.planes().iter().any(lies_above)
    }
}

/// −1 for side 0, else 1.
fn sign(side: usize) -> f64 {
    if side == 0 { -1.0 } else { 1.0 }
}

/// Support of the points in direction n: max n·p.
fn support(points: &[Vec3], n: Vec3) -> f64 {
    points.iter().map(|p| n.dot(*p)).fold(f64::NEG_INFINITY, f64::max)
}
