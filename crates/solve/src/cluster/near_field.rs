//! The mean kernel of clusters close to each other, by unbiased samples of bounded variance.
//!
//! Between two clusters in contact, the kernel between points is unbounded and its mean over a few points useless. Here a sample is a point
//! x of the smaller cluster and a zone q of the other, with the exchange of x and q in closed form:
//!
//! ```text
//! ⟨K⟩ = E[ S(x, q) / (π p_q W) ]        W the measure of q's cluster, p_q the probability of q
//! S = Ω, the solid angle of a plate, projected where x lies on a surface
//! S = 2π a + π (a² − d²)/d ln|(a + d)/(a − d)|      ∫ dV/r² over the ball of q's volume, radius a, at distance d
//! S = V n·(c − x)/max(d, a)³                        ∫ cos/r² dV over it, for x on a surface
//! ```
//!
//! The zone q is chosen by a descent of the tree that takes each child with a probability proportional to a bound of its contribution by
//! size, distance and orientation (importance sampling, as in pbrt's light tree). p_q then follows S, and a sample stays near its mean at
//! any distance. One ray from x to a point of q samples the visibility.

use super::cluster_visibility::{
    AGREEMENT_TOLERANCE, ClusterPoint, ClusterVisibility, VisibilityEstimate, VisibilitySampling, ZoneChoice,
    faces_point,
};
use super::tree::{ClusterKind, ClusterNode};
use crate::surroundings::zone_rays::voxel_point;
use std::f64::consts::PI;
use zonal_exchange::pair::SUCCESSION_PSEUDO_COUNTS;
use zonal_math::{Vec3, low_discrepancy};
use zonal_scene::Bands;
use zonal_transport::solid_angle::{projected_solid_angle, solid_angle};

/// Smallest distance of a cluster in the descent, squared, over the square of its radius.
const MIN_SQUARED_DISTANCE: f64 = 0.5;
/// Most children of a node.
const MAX_CHILDREN: usize = 8;

/// One sample.
struct NearFieldSample {
    /// Its kernel, 1/m².
    kernel: f64,
    /// The ends of its ray.
    ends: [Vec3; 2],
}

/// Sums over the samples of a pair.
#[derive(Default)]
struct SampleSums {
    kernel: f64,
    visible: Bands,
    transmitted: Bands,
    /// Squares of the visible kernel in the first band.
    squares: f64,
    /// Kernel-weighted squares of the visibility in the first band.
    visibility_squares: f64,
}

/// Square of the size of a cluster, m².
fn squared_size(n: &ClusterNode) -> f64 {
    match n.kind {
        ClusterKind::Voxel => (n.measure as f64).powf(2.0 / 3.0),
        _ => n.measure as f64,
    }
}

/// ∫ dV/r² over a ball of this volume at the distance `d` of its centre, m.
fn ball_integral(volume: f64, d: f64) -> f64 {
    let a = (0.75 * volume / PI).cbrt();
    if d < 1e-6 * a {
        return 4.0 * PI * a;
    }
    let gap = (a - d).abs().max(1e-12 * a);
    2.0 * PI * a + PI * (a * a - d * d) / d * ((a + d) / gap).ln()
}

/// ∫ cos/r² dV over a ball of this volume whose centre is at `t`, for a surface of normal `n`, m.
fn projected_ball_integral(volume: f64, t: Vec3, n: Vec3) -> f64 {
    let a = (0.75 * volume / PI).cbrt();
    volume * n.dot(t).max(0.0) / t.length().max(a).powi(3)
}

impl ClusterVisibility<'_> {
    /// Importance of a node for a receiver at x; zero only where it contributes nothing.
    fn importance(&self, n: &ClusterNode, x: &ClusterPoint) -> f64 {
        let d = n.centre() - x.position;
        let (r2, radius) = (d.length2(), n.radius());
        let reach = r2.sqrt() + radius;
        let mut w = n.measure as f64 / (r2 + MIN_SQUARED_DISTANCE * radius * radius).max(1e-300);
        if x.normal != Vec3::ZERO {
            w *= ((x.normal.dot(d) + radius) / reach).max(0.0);
        }
        if n.kind == ClusterKind::Patch && n.cone_sine < 1.0 {
            let own = n.normal().normalized();
            w *= ((radius - own.dot(d)) / reach + n.cone_sine as f64).clamp(0.0, 1.0);
        }
        w
    }

    /// A zone of a cluster and its probability, for a receiver at x; `None` where the whole cluster faces away.
    fn descend(&self, cluster: &ClusterNode, x: &ClusterPoint, mut u: f64) -> Option<(usize, f64)> {
        let (mut node, mut p) = (cluster, 1.0);
        while !node.is_leaf() {
            let children = self.tree.children_of(node);
            let mut cumulative = [0.0; MAX_CHILDREN];
            let mut total = 0.0;
            for (k, &child) in children.iter().enumerate().take(MAX_CHILDREN) {
                total += self.importance(&self.tree.nodes[child as usize], x);
                cumulative[k] = total;
            }
            if total <= 0.0 {
                return None;
            }
            let below = cumulative[..children.len()].partition_point(|s| *s <= u * total);
            let chosen = below.min(children.len() - 1);
            let from = if chosen == 0 { 0.0 } else { cumulative[chosen - 1] };
            let share = cumulative[chosen] - from;
            if share <= 0.0 {
                return None;
            }
            u = low_discrepancy::wrap(((u * total - from) / share).clamp(0.0, 1.0 - 1e-12));
            p *= share / total;
            node = &self.tree.nodes[children[chosen] as usize];
        }
        Some((self.tree.zone_of(node), p))
    }

    /// A sample of the kernel between two clusters.
    fn near_field_sample(
        &self,
        from: &ClusterNode,
        to: &ClusterNode,
        u: [f64; 6],
    ) -> Option<NearFieldSample> {
        let x = self.point(from, [u[0], u[1], u[2]], ZoneChoice::ByMeasure);
        let (zone, p) = self.descend(to, &x, u[3])?;
        let zones = self.zones;
        let on_surface = x.normal != Vec3::ZERO;
        let (exchange, y) = if let Some(patch) = zones.patches.get(zone) {
            if !faces_point(patch, x.position) {
                return None;
            }
            let [s, t] = patch.plate.warp([u[4], u[5]]);
            let angle = match on_surface {
                true => projected_solid_angle(&patch.plate, x.position, x.normal),
                false => solid_angle(&patch.plate, x.position),
            };
            (angle, patch.plate.at(s, t))
        } else {
            let z = zones.voxels.get(zone - zones.voxel_offset())?;
            let t = z.centre - x.position;
            let integral = match on_surface {
                true => projected_ball_integral(z.volume, t, x.normal),
                false => ball_integral(z.volume, t.length()),
            };
            let third = low_discrepancy::wrap(u[3] + u[4] + 0.5);
            (integral, voxel_point(z, self.cell, [third, u[4], u[5]]))
        };
        let kernel = exchange / (PI * p * to.measure as f64);
        let valid = kernel > 0.0 && kernel.is_finite();
        valid.then_some(NearFieldSample { kernel, ends: [x.position, y] })
    }

    /// Samples a pair of clusters without panes at `points` points. Their number is fixed beforehand: stopping as soon as they seem
    /// sufficient would favour small means.
    pub(crate) fn sample_near_field(
        &self,
        i: &ClusterNode,
        j: &ClusterNode,
        seed: u64,
        points: usize,
        sampling: VisibilitySampling,
    ) -> VisibilityEstimate {
        let (from, to) = if squared_size(j) < squared_size(i) { (j, i) } else { (i, j) };
        let shift = low_discrepancy::random_shift(seed);
        let unoccluded = sampling.unoccluded;
        let mut sums = SampleSums::default();
        let mut estimate = VisibilityEstimate { error: 1.0, ..VisibilityEstimate::UNOCCLUDED };
        for k in 0..points {
            let Some(s) = self.near_field_sample(from, to, low_discrepancy::r6(k, shift)) else {
                continue;
            };
            let [x, y] = s.ends;
            let pass = if unoccluded { Bands::ONE } else { self.transmittance_of_panes(x, y) };
            estimate.rays += u32::from(!unoccluded);
            let w = s.kernel;
            sums.kernel += w;
            sums.visible += w * pass;
            sums.transmitted += w * (-self.depth(x, y)).exp();
            sums.squares += (pass.first() * w).powi(2);
            sums.visibility_squares += w * pass.first() * pass.first();
        }
        let m = points as f64;
        estimate.mean_kernel = sums.kernel / m;
        if sums.kernel <= 0.0 {
            return estimate;
        }
        estimate.visible_fraction = sums.visible / sums.kernel;
        estimate.transmittance = sums.transmitted / sums.kernel;
        // The standard deviation of the samples about their mean, relative to the mean kernel; of a single sample its own value.
        let (mean, v) = (sums.visible.first() / m, estimate.visible_fraction.first());
        estimate.deviation = (sums.visibility_squares / sums.kernel - v * v).max(0.0).sqrt();
        let variance =
            if points > 1 { (sums.squares / m - mean * mean).max(0.0) / (m - 1.0) } else { sums.squares };
        let agree = v <= AGREEMENT_TOLERANCE || v >= 1.0 - AGREEMENT_TOLERANCE;
        let undetected = if unoccluded || !agree { 0.0 } else { 1.0 / (m + SUCCESSION_PSEUDO_COUNTS) };
        estimate.error = (variance.sqrt() / estimate.mean_kernel).hypot(undetected);
        estimate
    }
}
