//! The mean kernel of clusters that are close to each other, by unbiased samples of bounded spread.
//!
//! Of two clusters in touch, the kernel between points has no bound and its mean by a few points no use. Here a sample is a point x of
//! the smaller cluster and a zone q of the other, and what q sends to x in closed form:
//!
//! ```text
//! ⟨K⟩ = E[ S(x, q) / (π p_q W) ]        W the measure of q's cluster, p_q the probability of q
//! S = Ω, the solid angle of a plate, projected where x lies on a surface
//! S = 2π a + π (a² − d²)/d ln|(a + d)/(a − d)|      ∫ dV/r² over the ball of q's volume, radius a, at distance d
//! S = V n·(c − x)/max(d, a)³                        ∫ cos/r² dV over it, for x on a surface
//! ```
//!
//! with q found by a walk down the tree that takes each kid with the probability that its size, distance and orientation suggest. So
//! p_q follows S, and a sample stays near its mean, whatever the distance. One ray from x to a point of q tells what is seen of it.

use super::sight::{Seen, Sight, Spotted};
use super::tree::{Kind, Node};
use crate::surroundings::voxel_point;
use std::f64::consts::PI;
use zonal_exchange::pair::SUCCESSION;
use zonal_math::{Vec3, sequence};
use zonal_scene::Patch;
use zonal_transport::solid_angle::{projected_solid_angle, solid_angle};

/// Share of its own size that a cluster is kept away in the walk.
const ROUND: f64 = 0.5;
/// Kids of a node at most.
const KIDS: usize = 8;

/// One sample.
struct Sample {
    /// Its kernel, 1/m².
    kernel: f64,
    /// From where to where.
    ends: [Vec3; 2],
}

/// Heights over a plate below this share of its size are rounding.
const LEVEL: f64 = 1e-7;

/// True where the front of a patch faces the point.
pub(super) fn is_above(p: &Patch, x: Vec3) -> bool {
    (x - p.plate.origin).dot(p.normal) > LEVEL * p.area.sqrt()
}

/// ∫ dV/r² over a ball, m.
fn ball(volume: f64, d: f64) -> f64 {
    let a = (0.75 * volume / PI).cbrt();
    if d < 1e-6 * a {
        return 4.0 * PI * a;
    }
    let gap = (a - d).abs().max(1e-12 * a);
    2.0 * PI * a + PI * (a * a - d * d) / d * ((a + d) / gap).ln()
}

/// ∫ cos/r² dV over a ball whose centre is `t` away, m.
fn ball_above(volume: f64, t: Vec3, n: Vec3) -> f64 {
    let a = (0.75 * volume / PI).cbrt();
    volume * n.dot(t).max(0.0) / t.length().max(a).powi(3)
}

impl Sight<'_> {
    /// What a node sends to x, roughly: 0 only where it is exactly nothing.
    fn promise(&self, n: &Node, x: Vec3, normal: Vec3) -> f64 {
        let d = n.centre() - x;
        let (r2, radius) = (d.length2(), n.radius());
        let reach = r2.sqrt() + radius;
        let mut w = n.weight as f64 / (r2 + ROUND * radius * radius).max(1e-300);
        if normal != Vec3::ZERO {
            w *= ((normal.dot(d) + radius) / reach).max(0.0);
        }
        if n.kind == Kind::Patch && n.cone < 1.0 {
            let own = n.normal().normalized();
            w *= ((radius - own.dot(d)) / reach + n.cone as f64).clamp(0.0, 1.0);
        }
        w
    }

    /// A zone of a cluster and the probability of its choice, for a receiver at x; none where all of it faces away.
    fn walk(&self, cluster: &Node, x: &Spotted, mut u: f64) -> Option<(usize, f64)> {
        let (mut node, mut p) = (cluster, 1.0);
        while !node.is_leaf() {
            let kids = self.tree.kids_of(node);
            let mut upto = [0.0; KIDS];
            let mut total = 0.0;
            for (k, &kid) in kids.iter().enumerate().take(KIDS) {
                total += self.promise(&self.tree.nodes[kid as usize], x.at, x.normal);
                upto[k] = total;
            }
            if total <= 0.0 {
                return None;
            }
            let take = upto[..kids.len()].partition_point(|s| *s <= u * total).min(kids.len() - 1);
            let from = if take == 0 { 0.0 } else { upto[take - 1] };
            let share = upto[take] - from;
            if share <= 0.0 {
                return None;
            }
            u = sequence::wrap(((u * total - from) / share).clamp(0.0, 1.0 - 1e-12));
            p *= share / total;
            node = &self.tree.nodes[kids[take] as usize];
        }
        Some((self.tree.zone[node.first as usize] as usize, p))
    }

    fn sample(&self, from: &Node, to: &Node, u: [f64; 6]) -> Option<Sample> {
        let x = self.point(from, [u[0], u[1], u[2]], false);
        let (zone, p) = self.walk(to, &x, u[3])?;
        let zones = self.zones;
        let surface = x.normal != Vec3::ZERO;
        let (sent, y) = if let Some(patch) = zones.patches.get(zone) {
            if !is_above(patch, x.at) {
                return None;
            }
            let [s, t] = patch.plate.warp([u[4], u[5]]);
            let angle = match surface {
                true => projected_solid_angle(&patch.plate, x.at, x.normal),
                false => solid_angle(&patch.plate, x.at),
            };
            (angle, patch.plate.at(s, t))
        } else {
            let z = zones.voxels.get(zone - zones.voxel_offset())?;
            let t = z.centre - x.at;
            let sent = match surface {
                true => ball_above(z.volume, t, x.normal),
                false => ball(z.volume, t.length()),
            };
            let turn = sequence::wrap(u[3] + u[4] + 0.5);
            (sent, voxel_point(z, self.cell, [turn, u[4], u[5]]))
        };
        let kernel = sent / (PI * p * to.weight as f64);
        let sound = kernel > 0.0 && kernel.is_finite();
        sound.then_some(Sample { kernel, ends: [x.at, y] })
    }

    /// `points` samples of a pair of clusters without panes. Their number is fixed beforehand: stopping when they look good enough would
    /// favour small means.
    pub fn near(&self, i: &Node, j: &Node, seed: u64, points: usize, clear: bool) -> Seen {
        let size = |n: &Node| match n.kind {
            Kind::Voxel => (n.weight as f64).powf(2.0 / 3.0),
            _ => n.weight as f64,
        };
        let (from, to) = if size(j) < size(i) { (j, i) } else { (i, j) };
        let shift = sequence::shift(seed);
        let (mut sum, mut passed, mut dimmed, mut squares) = (0.0, [0.0; 3], [0.0; 3], 0.0);
        let mut verdicts = 0.0;
        let mut seen =
            Seen { share: [1.0; 3], error: 1.0, mixed: 0.0, kernel: 0.0, medium: [1.0; 3], rays: 0 };
        for k in 0..points {
            let Some(s) = self.sample(from, to, sequence::r6(k, shift)) else {
                continue;
            };
            let [x, y] = s.ends;
            let pass = if clear { [1.0; 3] } else { self.pass(x, y) };
            seen.rays += u32::from(!clear);
            let depth = self.depth(x, y);
            let w = s.kernel;
            sum += w;
            (0..3).for_each(|b| {
                passed[b] += w * pass[b];
                dimmed[b] += w * (-depth[b]).exp();
            });
            squares += (pass[0] * w).powi(2);
            verdicts += w * pass[0] * pass[0];
        }
        let m = points as f64;
        seen.kernel = sum / m;
        if sum <= 0.0 {
            return seen;
        }
        seen.share = passed.map(|p| p / sum);
        seen.medium = dimmed.map(|d| d / sum);
        // The spread of the samples about their mean, relative to the mean kernel; of a single one its own size.
        let (mean, v) = (passed[0] / m, seen.share[0]);
        seen.mixed = (verdicts / sum - v * v).max(0.0).sqrt();
        let variance = if points > 1 { (squares / m - mean * mean).max(0.0) / (m - 1.0) } else { squares };
        let agree = v <= 1e-12 || v >= 1.0 - 1e-12;
        let unseen = if clear || !agree { 0.0 } else { 1.0 / (m + SUCCESSION) };
        seen.error = (variance.sqrt() / seen.kernel).hypot(unseen);
        seen
    }
}
