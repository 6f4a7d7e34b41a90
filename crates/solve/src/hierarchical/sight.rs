//! What two clusters see of each other: the visible share by rays, the attenuation by the walk between the centres.
//!
//! A ray joins a point of i and a point of j, leaf by its measure, points from a six-dimensional low-discrepancy sequence shifted by a
//! hash of the pair: one set of rays serves both directions. A ray counts by the kernel between its ends. With m rays the visible
//! share v has the standard error √(v(1 − v)/m) where they differ; where all agree, 1/(m + 2) (Laplace's rule of succession), except
//! where no facet reaches into the hull of the pair: then v = 1 exactly, and no ray is asked.
//!
//! Rays are shot until the error is below what the link deserves, or until [`MOST_RAYS`].

use super::tree::{Kind, Node, Tree};
use crate::surroundings::voxel_point;
use std::f64::consts::PI;
use zonal_math::{Vec3, sequence, vec3};
use zonal_scene::{Bands, Scene, Zones, bands};
use zonal_transport::solid_angle::{projected_solid_angle, solid_angle};
use zonal_transport::{End, Transport};

/// Most rays of a link.
pub const MOST_RAYS: usize = 128;
/// Points of a mean kernel.
const KERNEL_POINTS: usize = 16;
/// What the rule of succession adds to the number of rays.
const SUCCESSION: f64 = 2.0;

/// φ^{−m} with φ the root of x⁷ = x + 1.
const ALPHA: [f64; 6] = [
    0.898_653_712_628_699_3,
    0.807_578_495_221_347_8,
    0.725_733_412_888_614_4,
    0.652_183_026_439_512_8,
    0.586_086_697_577_874_5,
    0.526_688_986_801_227_8,
];

/// What rays found between two clusters.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// The visible share, panes between included, a band.
    pub share: Bands,
    /// Its error.
    pub error: f64,
    /// The standard deviation of one ray's verdict: 0 where all agree.
    pub mixed: f64,
    /// Rays shot.
    pub rays: u32,
}

impl Seen {
    /// Nothing stands between.
    pub const CLEAR: Seen = Seen { share: [1.0; 3], error: 0.0, mixed: 0.0, rays: 0 };
}

/// A scene ready for questions about pairs of clusters.
pub struct Sight<'a> {
    zones: &'a Zones,
    transport: &'a Transport<'a>,
    tree: &'a Tree,
    /// Σ of the measures of the leaves before each.
    before: Vec<f64>,
    cell: Vec3,
    occluders: bool,
    panes: bool,
}

impl<'a> Sight<'a> {
    /// Prepares sampling.
    pub fn new(
        scene: &'a Scene,
        zones: &'a Zones,
        transport: &'a Transport<'a>,
        tree: &'a Tree,
    ) -> Sight<'a> {
        let mut before = Vec::with_capacity(tree.leaves() + 1);
        let mut sum = 0.0;
        before.push(0.0);
        for slot in 0..tree.leaves() {
            sum += tree.nodes[tree.leaf(slot)].weight as f64;
            before.push(sum);
        }
        Sight {
            zones,
            transport,
            tree,
            before,
            cell: scene.voxmap().map_or(Vec3::ZERO, |v| v.cell()),
            occluders: transport.has_occluders(),
            panes: transport.has_panes_between(),
        }
    }

    /// Optical depth between two points, without panes, a band.
    pub fn depth(&self, a: Vec3, b: Vec3) -> Bands {
        self.transport.medium_depth(a, b)
    }

    /// True where nothing can stand between any two points of the scene.
    pub fn open(&self) -> bool {
        !self.occluders && !self.panes
    }

    /// True where no facet (and no pane) can stand between the two.
    pub fn is_clear(&self, i: &Node, j: &Node) -> bool {
        if self.open() {
            return true;
        }
        if self.panes {
            return false;
        }
        let (mut p, mut q) = ([Vec3::ZERO; 8], [Vec3::ZERO; 8]);
        let ends = [self.end(i, &mut p), self.end(j, &mut q)];
        !self.transport.may_divide(ends)
    }

    fn end<'b>(&self, n: &Node, points: &'b mut [Vec3; 8]) -> End<'b> {
        if n.is_leaf() && n.kind == Kind::Patch {
            let p = &self.zones.patches[self.tree.zone[n.first as usize] as usize];
            let (c, count) = p.plate.corners();
            points[..4].copy_from_slice(&c);
            return End { points: &points[..count], front: Some(p.normal) };
        }
        let pick = |k: usize, a: usize| if k >> a & 1 == 1 { n.hi[a] } else { n.lo[a] };
        *points = std::array::from_fn(|k| vec3(pick(k, 0), pick(k, 1), pick(k, 2)));
        End { points: &points[..], front: None }
    }

    /// A zone of a cluster, by its measure, and what is left of `u`.
    fn pick(&self, n: &Node, u: f64) -> (usize, f64) {
        if n.is_leaf() {
            return (self.tree.zone[n.first as usize] as usize, u);
        }
        let (first, last) = (n.first as usize, n.last as usize);
        let (a, b) = (self.before[first], self.before[last]);
        let target = a + u * (b - a);
        let slot = first + self.before[first + 1..last].partition_point(|x| *x <= target);
        let (l, h) = (self.before[slot], self.before[slot + 1]);
        let rest = sequence::wrap(((target - l) / (h - l)).clamp(0.0, 1.0 - 1e-9));
        (self.tree.zone[slot] as usize, rest)
    }

    /// The mean geometric kernel of two clusters, one of them of plates, by a few points: the solid angle of a zone of the one from a
    /// point of the other over its area, which stays bounded where they touch, 1/m².
    pub fn mean_kernel(&self, i: &Node, j: &Node, seed: u64) -> f64 {
        let shift: [f64; 6] =
            std::array::from_fn(|m| sequence::unit(seed.wrapping_mul(6).wrapping_add(m as u64)));
        let (a, b) = if j.kind == Kind::Voxel { (j, i) } else { (i, j) };
        let mut sum = 0.0;
        for k in 0..KERNEL_POINTS {
            let u: [f64; 6] = std::array::from_fn(|m| sequence::wrap(shift[m] + k as f64 * ALPHA[m]));
            let (x, n) = self.point(a, [u[0], u[1], u[2]]);
            let (zone, _) = self.pick(b, u[3]);
            let (plate, area, two_sided) = if zone < self.zones.voxel_offset() {
                (&self.zones.patches[zone].plate, self.zones.patches[zone].area, false)
            } else {
                let p = &self.zones.panes[zone - self.zones.pane_offset()];
                (&p.plate, p.area, true)
            };
            let height = (x - plate.origin).dot(plate.normal());
            if !two_sided && height <= 0.0 {
                continue;
            }
            sum += match a.kind {
                Kind::Voxel => solid_angle(plate, x).abs(),
                Kind::Pane => projected_solid_angle(plate, x, n) + projected_solid_angle(plate, x, -n),
                _ => projected_solid_angle(plate, x, n),
            } / area;
        }
        sum / (KERNEL_POINTS as f64 * PI)
    }

    /// A point of a cluster with its normal, zero in a volume.
    fn point(&self, n: &Node, u: [f64; 3]) -> (Vec3, Vec3) {
        let (zone, first) = self.pick(n, u[0]);
        let u = [first, u[1], u[2]];
        let zones = self.zones;
        if zone < zones.voxel_offset() {
            let p = &zones.patches[zone];
            let [s, t] = p.plate.warp([u[0], u[1]]);
            (p.plate.at(s, t), p.normal)
        } else if zone < zones.pane_offset() {
            (voxel_point(&zones.voxels[zone - zones.voxel_offset()], self.cell, u), Vec3::ZERO)
        } else {
            let p = &zones.panes[zone - zones.pane_offset()];
            let [s, t] = p.plate.warp([u[0], u[1]]);
            (p.plate.at(s, t), p.normal)
        }
    }

    /// Shoots rays until the error of the visible share is below `want`.
    pub fn look(&self, i: &Node, j: &Node, seed: u64, want: f64) -> Seen {
        let most = MOST_RAYS;
        let shift: [f64; 6] =
            std::array::from_fn(|m| sequence::unit(seed.wrapping_mul(6).wrapping_add(m as u64)));
        let floor = 0.01 * (i.radius() * i.radius()).min(j.radius() * j.radius());
        let (mut w, mut sum, mut squares) = (0.0, [0.0; 3], 0.0);
        let mut seen = Seen { share: [0.0; 3], error: 0.5, mixed: 0.0, rays: 0 };
        let mut goal = ((1.0 / want - SUCCESSION).ceil().max(1.0) as usize).min(most);
        let mut k = 0;
        loop {
            while k < goal {
                let u: [f64; 6] = std::array::from_fn(|m| sequence::wrap(shift[m] + k as f64 * ALPHA[m]));
                k += 1;
                let (x, nx) = self.point(i, [u[0], u[1], u[2]]);
                let (y, ny) = self.point(j, [u[3], u[4], u[5]]);
                let d = y - x;
                let r2 = d.length2();
                let mut weight = 1.0 / (r2 + floor);
                for (n, node, d) in [(nx, i, d), (ny, j, -d)] {
                    match node.kind {
                        Kind::Patch => weight *= n.dot(d).max(0.0) / r2.sqrt(),
                        Kind::Pane => weight *= n.dot(d).abs() / r2.sqrt(),
                        _ => {}
                    }
                }
                if weight.is_nan() || weight <= 0.0 {
                    continue;
                }
                seen.rays += 1;
                w += weight;
                let pass = self.pass(x, y);
                (0..3).for_each(|b| sum[b] += weight * pass[b]);
                squares += weight * pass[0] * pass[0];
            }
            if w <= 0.0 {
                // No ray could carry anything: a sliver of exchange at most.
                return Seen { share: [1.0; 3], error: 0.5, mixed: 0.0, rays: k as u32 };
            }
            seen.share = sum.map(|s| s / w);
            let v = seen.share[0];
            let variance = (squares / w - v * v).max(0.0);
            let m = seen.rays as f64;
            let agree = v <= 1e-12 || v >= 1.0 - 1e-12;
            seen.mixed = variance.sqrt();
            seen.error =
                if agree { 1.0 / (m + SUCCESSION) } else { (variance / m).sqrt().max(0.5 / (m * m)) };
            if seen.error <= want || k >= most {
                return seen;
            }
            let need = if agree { 1.0 / want } else { variance / (want * want) };
            goal = (need.ceil().min(most as f64) as usize).clamp(k + 1, most);
        }
    }

    #[inline]
    fn pass(&self, x: Vec3, y: Vec3) -> Bands {
        if self.occluders && self.transport.blocked_inside(x, y) {
            return [0.0; 3];
        }
        if !self.panes {
            return [1.0; 3];
        }
        let depth = self.transport.pane_depth_inside(x, y);
        bands(|b| (-depth[b]).exp())
    }
}
