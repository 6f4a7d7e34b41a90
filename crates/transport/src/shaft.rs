//! All segments between two zones at once: the planes that hold their convex hull.
//!
//! With P and Q the points of two zones, every segment between them lies in hull(P ∪ Q), thus below each plane
//! n·x = max over P ∪ Q of n·p, whatever n. A plate whose corners all lie above one such plane meets no segment, nor does one whose
//! own plane has all of P ∪ Q on one side. The directions n:
//!
//! - the six of the axes;
//! - for each quadrant of each coordinate plane the normal of the line through the outermost corners of both boxes there, where it
//!   points into the quadrant: it then touches both boxes, a side of the shaft (Haines and Wallace 1994);
//! - the back of a zone that is seen from its front alone, at the height of the zone itself.
//!
//! No plate that can block is left out; one that cannot may be kept. What reaches into the hull by no more than the
//! rounding of a coordinate touches it.

use crate::meet::{Prepared, Tolerance};
use zonal_math::Vec3;

/// Axes, sides of the shaft, fronts.
const MOST: usize = 6 + 12 + 2;

/// A zone as the end of segments.
#[derive(Clone, Copy, Debug)]
pub struct End<'a> {
    /// Points whose convex hull holds the zone, m, one at least.
    pub points: &'a [Vec3],
    /// The unit normal of a flat zone that only its front sees.
    pub front: Option<Vec3>,
}

impl End<'_> {
    fn bounds(&self) -> [Vec3; 2] {
        let first = [self.points[0]; 2];
        self.points.iter().fold(first, |[lo, hi], p| [lo.min(*p), hi.max(*p)])
    }
}

/// Planes n·x = c with the hull of two zones below all of them.
pub(crate) struct Shaft<'a> {
    ends: [End<'a>; 2],
    planes: [(Vec3, f64); MOST],
    count: usize,
}

impl<'a> Shaft<'a> {
    pub(crate) fn new(ends: [End<'a>; 2]) -> Shaft<'a> {
        let mut shaft = Shaft { ends, planes: [(Vec3::ZERO, 0.0); MOST], count: 0 };
        let boxes = ends.map(|e| e.bounds());
        for x in 0..3 {
            for side in [0, 1] {
                let mut n = [0.0; 3];
                n[x] = sign(side);
                shaft.hold(Vec3::from_array(n));
            }
        }
        for (x, y) in [(0, 1), (1, 2), (2, 0)] {
            for quadrant in 0..4 {
                let (i, j) = (quadrant & 1, quadrant >> 1);
                let (dx, dy) = (boxes[1][i][x] - boxes[0][i][x], boxes[1][j][y] - boxes[0][j][y]);
                // Normal to (dx, dy), and into the quadrant, only where they run against each other there.
                if dx * dy * sign(i) * sign(j) < 0.0 {
                    let mut n = [0.0; 3];
                    (n[x], n[y]) = (dy.abs() * sign(i), dx.abs() * sign(j));
                    shaft.hold(Vec3::from_array(n).normalized());
                }
            }
        }
        for end in ends {
            if let Some(n) = end.front {
                shaft.push(-n, highest(end.points, -n));
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

    fn hold(&mut self, n: Vec3) {
        self.push(n, highest(self.ends[0].points, n).max(highest(self.ends[1].points, n)));
    }

    /// False when the plate can cross no segment between the ends.
    pub(crate) fn may_meet(&self, plate: &Prepared, tol: &Tolerance) -> bool {
        let heights = || self.ends.iter().flat_map(|e| e.points).map(|p| plate.height(*p));
        if heights().all(|h| h <= tol.plane) || heights().all(|h| h >= -tol.plane) {
            return false;
        }
        let (corners, count) = plate.corners();
        let beyond = |&(n, c): &(Vec3, f64)| corners[..count].iter().all(|x| n.dot(*x) >= c - tol.rounding);
        !self.planes().iter().any(beyond)
    }
}

fn sign(side: usize) -> f64 {
    if side == 0 { -1.0 } else { 1.0 }
}

fn highest(points: &[Vec3], n: Vec3) -> f64 {
    points.iter().map(|p| n.dot(*p)).fold(f64::NEG_INFINITY, f64::max)
}
