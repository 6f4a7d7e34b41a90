//! Sample points and weights of the rays between two zones.

use crate::pair::prepared_zone::{PreparedShape, PreparedZone};
use zonal_math::{Vec3, low_discrepancy};

// Numbers of rays of a pair, and the limits by which they are chosen.

/// Rays that show whether an important pair is partly visible.
pub(crate) const FIRST_RAYS: usize = 4;
/// Rays of such a pair that is not.
pub(crate) const AGREEING_RAYS: usize = 12;
/// Rays of a pair that carries no important share of a zone's power.
pub(crate) const UNIMPORTANT_RAYS: usize = 8;
/// Rays of a pair of close zones of that kind.
pub(crate) const PARTIAL_RAYS: usize = 16;
/// Rays of a partly visible pair that carries an important share of a zone's power.
pub(crate) const IMPORTANT_RAYS: usize = 64;
/// Rays of a nearly touching pair of that kind.
pub(crate) const CLOSE_RAYS: usize = 256;
/// Rays of a voxel to itself.
pub(crate) const SELF_PAIR_RAYS: usize = 2048;
/// Rays of any pair, at most.
pub(crate) const MAX_RAYS: usize = 4096;
/// Rounds of additional rays, at most.
pub(crate) const MAX_ROUNDS: usize = 2;
/// Share of a zone's power, over the tolerance, from which a pair is important.
pub(crate) const IMPORTANT_SHARE: f64 = 0.1;
/// Share of a zone's power, over the tolerance, that the rays of a pair may leave open.
pub(crate) const OPEN_SHARE: f64 = 0.1;
/// Optical depth along the diagonal of a voxel beyond which the cumulants of the distance do not determine the attenuation.
pub(crate) const MAX_CUMULANT_DEPTH: f64 = 1.7;
/// Optical depth beyond which the ratio of a pair's rays to a uniform medium is not used: their mean depth, and the excess of the uniform
/// medium's depth along any of them.
pub(crate) const MAX_REFERENCE_DEPTH: f64 = 20.0;
/// Subdivisions into quarters of a pane and of a zone close to it.
pub(crate) const PANE_SPLITS: u32 = 2;
/// The same of a pane and a patch, which may share an edge, for tolerances below `SMALL_TOLERANCE`.
pub(crate) const PANE_EDGE_SPLITS: u32 = 4;
/// The tolerance below which `PANE_EDGE_SPLITS` applies.
pub(crate) const SMALL_TOLERANCE: f64 = 0.01;

/// Squared distance below which the kernel is bounded, relative to the smaller squared diameter.
const MIN_RELATIVE_SQUARED_DISTANCE: f64 = 0.0025;

/// The points of a pair: a six-dimensional low-discrepancy sequence shifted by a hash of the pair, three coordinates per zone.
pub(crate) struct PairPoints {
    shift: [f64; 6],
}

impl PairPoints {
    pub(crate) fn new(seed: u64) -> PairPoints {
        PairPoints { shift: low_discrepancy::random_shift(seed) }
    }
    /// The `k`-th points on both zones.
    pub(crate) fn both(&self, a: &PreparedZone, b: &PreparedZone, k: usize) -> (Vec3, Vec3) {
        let u = low_discrepancy::r6(k, self.shift);
        (zone_point(a, [u[0], u[1], u[2]]), zone_point(b, [u[3], u[4], u[5]]))
    }
}

/// The point of a zone at coordinates in the unit cube.
fn zone_point(z: &PreparedZone, u: [f64; 3]) -> Vec3 {
    match &z.shape {
        PreparedShape::Plate { plate, .. } => {
            let [s, t] = plate.warp([u[0], u[1]]);
            plate.at(s, t)
        }
        PreparedShape::Voxel => z.lo + (z.hi - z.lo).scale(Vec3::from_array(u)),
        PreparedShape::CutVoxel(samples) => {
            let mut target = u[0] * z.measure;
            for s in samples.iter() {
                target -= s.volume;
                if target <= 0.0 {
                    return s.point;
                }
            }
            samples[samples.len() - 1].point
        }
    }
}

/// The kernel cosθ_a cosθ_b/r² between two points, bounded at small distances; only ratios of it are used.
pub(crate) fn pair_kernel(a: &PreparedZone, b: &PreparedZone, x: Vec3, y: Vec3) -> f64 {
    let d = y - x;
    let r2 = d.length2();
    let floor = MIN_RELATIVE_SQUARED_DISTANCE * (a.diameter * a.diameter).min(b.diameter * b.diameter);
    let d = d / r2.sqrt().max(1e-300);
    let side = |z: &PreparedZone, c: f64| match &z.shape {
        PreparedShape::Plate { pane: None, .. } => c.max(0.0),
        PreparedShape::Plate { .. } => c.abs(),
        _ => 1.0,
    };
    side(a, a.normal.dot(d)) * side(b, -b.normal.dot(d)) / r2.max(floor)
}

/// Weighted mean of a few samples with its standard error.
#[derive(Clone, Copy, Default)]
pub(crate) struct WeightedMean {
    /// Σ w, Σ w x, Σ w x², Σ w² of weights w and values x.
    w: f64,
    wx: f64,
    wxx: f64,
    ww: f64,
    /// Number of samples.
    pub(crate) n: f64,
    /// Samples of value zero.
    pub(crate) blocked: f64,
}

impl WeightedMean {
    pub(crate) fn add(&mut self, w: f64, x: f64) {
        self.w += w;
        self.wx += w * x;
        self.wxx += w * x * x;
        self.ww += w * w;
        self.n += 1.0;
        self.blocked += if x == 0.0 { 1.0 } else { 0.0 };
    }
    /// True if some samples are zero and some are not.
    pub(crate) fn is_mixed(&self) -> bool {
        self.blocked > 0.0 && self.blocked < self.n
    }
    pub(crate) fn mean_and_error(self) -> (f64, f64) {
        if self.w <= 0.0 {
            // Without weight on any ray only a sliver of exchange across an edge remains.
            return ((self.n - self.blocked) / self.n.max(1.0), 0.5);
        }
        let mean = self.wx / self.w;
        let variance = (self.wxx / self.w - mean * mean).max(0.0);
        (mean, (variance * self.ww).sqrt() / self.w)
    }
}
