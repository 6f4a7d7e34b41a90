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
/// What the rule of succession adds to the number of rays.
const SUCCESSION: f64 = 2.0;

/// What rays found between two clusters.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// The visible share, panes between included, a band.
    pub share: Bands,
    /// Its error.
    pub error: f64,
    /// The standard deviation of one ray's verdict: 0 where all agree.
    pub mixed: f64,
    /// The mean geometric kernel over the points, 1/m²; tamed by the size of the zones where they come close.
    pub kernel: f64,
    /// What the medium lets pass, a mean over the same points, a band; measured where the extinction varies, else 1.
    pub medium: Bands,
    /// Rays shot.
    pub rays: u32,
}

impl Seen {
    /// Nothing stands between.
    pub const CLEAR: Seen =
        Seen { share: [1.0; 3], error: 0.0, mixed: 0.0, kernel: 0.0, medium: [1.0; 3], rays: 0 };
}

/// A scene ready for questions about pairs of clusters.
pub struct Sight<'a> {
    zones: &'a Zones,
    transport: &'a Transport<'a>,
    tree: &'a Tree,
    /// Σ of the measures of the leaves before each.
    before: Vec<f64>,
    cell: Vec3,
    /// Square of the edge of a cell, m².
    cell_size: f64,
    occluders: bool,
    panes: bool,
    /// The extinction differs from cell to cell, or zones lie outside of the medium.
    varied: bool,
}

/// By how much the attenuation along paths (weight, depth, length) differs from that of a uniform medium: the relative standard deviation of
/// e^{−(δ − κ̄ r)}.
fn uneven(paths: &[[f64; 3]]) -> f64 {
    let sum = |k: usize| paths.iter().map(|p| p[0] * p[k]).sum::<f64>();
    let (w, length) = (paths.iter().map(|p| p[0]).sum::<f64>(), sum(2));
    if w <= 0.0 || length <= 0.0 {
        return 0.0;
    }
    let kappa = sum(1) / length;
    let x = |p: &[f64; 3]| (kappa * p[2] - p[1]).exp();
    let mean = paths.iter().map(|p| p[0] * x(p)).sum::<f64>() / w;
    let square = paths.iter().map(|p| p[0] * x(p) * x(p)).sum::<f64>() / w;
    (square / (mean * mean) - 1.0).max(0.0).sqrt()
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
            cell_size: scene.voxmap().map_or(0.0, |v| v.cell().product().powf(2.0 / 3.0)),
            occluders: transport.has_occluders(),
            panes: transport.has_panes_between(),
            varied: scene.voxmap().is_some_and(|v| v.uniform_extinction().is_none()),
        }
    }

    /// Extinction and thickness of a piece of pane.
    pub fn pane(&self, n: &Node) -> Option<(Bands, f64)> {
        let zone = self.tree.zone[n.first as usize] as usize;
        let p = self.zones.panes.get(zone.checked_sub(self.zones.pane_offset())?)?;
        Some((p.extinction, p.thickness))
    }

    /// Optical depth between two points, without panes, a band.
    pub fn depth(&self, a: Vec3, b: Vec3) -> Bands {
        self.transport.medium_depth(a, b)
    }

    /// True where the extinction differs from cell to cell.
    pub fn varied(&self) -> bool {
        self.varied
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

    /// A point of a cluster with its normal, zero in a volume, and the square of the size of its zone, m².
    fn point(&self, n: &Node, u: [f64; 3]) -> (Vec3, Vec3, f64) {
        let (zone, first) = self.pick(n, u[0]);
        let u = [first, u[1], u[2]];
        let zones = self.zones;
        if zone < zones.voxel_offset() {
            let p = &zones.patches[zone];
            let [s, t] = p.plate.warp([u[0], u[1]]);
            (p.plate.at(s, t), p.normal, p.area)
        } else if zone < zones.pane_offset() {
            let z = &zones.voxels[zone - zones.voxel_offset()];
            (voxel_point(z, self.cell, u), Vec3::ZERO, self.cell_size)
        } else {
            let p = &zones.panes[zone - zones.pane_offset()];
            let [s, t] = p.plate.warp([u[0], u[1]]);
            (p.plate.at(s, t), p.normal, p.area)
        }
    }

    /// Shoots rays until the error of the visible share is below `want`, `least` of them at least; where the pair is `clear`, looks at
    /// `least` points only.
    pub fn look(&self, i: &Node, j: &Node, seed: u64, want: f64, least: usize, clear: bool) -> Seen {
        let most = MOST_RAYS;
        let shift = sequence::shift(seed);
        let (mut w, mut sum, mut squares) = (0.0, [0.0; 3], 0.0);
        let mut seen =
            Seen { share: [0.0; 3], error: 0.5, mixed: 0.0, kernel: 0.0, medium: [1.0; 3], rays: 0 };
        // What one point stands for, m²: closer than that, points say nothing of the mean.
        let share = |n: &Node| {
            let w = n.weight as f64 / least as f64;
            if n.kind == Kind::Voxel { w.powf(2.0 / 3.0) } else { w }
        };
        let (share_i, share_j) = (share(i), share(j));
        let (mut dimmed, mut paths) = ([0.0; 3], [[0.0; 3]; 8]);
        let mut goal =
            if clear { least } else { ((1.0 / want - SUCCESSION).ceil().max(1.0) as usize).max(least) };
        goal = goal.min(most);
        let mut k = 0;
        loop {
            while k < goal {
                let u = sequence::r6(k, shift);
                k += 1;
                let (x, nx, sx) = self.point(i, [u[0], u[1], u[2]]);
                let (y, ny, sy) = self.point(j, [u[3], u[4], u[5]]);
                let d = y - x;
                let r2 = d.length2();
                let mut weight = 1.0 / (r2 + sx.max(share_i).max(sy).max(share_j) / PI);
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
                w += weight;
                if self.varied && least > 1 {
                    let depth = self.transport.medium_depth(x, y);
                    (0..3).for_each(|b| dimmed[b] += weight * (-depth[b]).exp());
                    if k <= paths.len() {
                        paths[k - 1] = [weight, depth.iter().fold(0.0f64, |m, d| m.max(*d)), r2.sqrt()];
                    }
                }
                let pass = if clear { [1.0; 3] } else { self.pass(x, y) };
                seen.rays += u32::from(!clear);
                (0..3).for_each(|b| sum[b] += weight * pass[b]);
                squares += weight * pass[0] * pass[0];
            }
            seen.kernel = w / (k as f64 * PI);
            if self.varied && least > 1 && w > 0.0 {
                seen.medium = dimmed.map(|d| d / w);
                seen.mixed = uneven(&paths);
            }
            if clear {
                return Seen { kernel: seen.kernel, medium: seen.medium, mixed: seen.mixed, ..Seen::CLEAR };
            }
            if w <= 0.0 {
                // No ray could carry anything: a sliver of exchange at most.
                return Seen { share: [1.0; 3], ..seen };
            }
            seen.share = sum.map(|s| s / w);
            let v = seen.share[0];
            let variance = (squares / w - v * v).max(0.0);
            let m = seen.rays as f64;
            let agree = v <= 1e-12 || v >= 1.0 - 1e-12;
            let medium = seen.mixed;
            seen.mixed = variance.sqrt().hypot(medium);
            seen.error =
                if agree { 1.0 / (m + SUCCESSION) } else { (variance / m).sqrt().max(0.5 / (m * m)) };
            if seen.error <= want || k >= most {
                return seen;
            }
            let need = if agree { 1.0 / want } else { variance / (want * want) };
            goal = (need.ceil().min(most as f64) as usize).clamp(k + 1, most);
        }
    }

    /// The mean geometric kernel of a zone and a zone that is a patch: the solid angle of the patch, projected where the other is a patch
    /// too, over its area, at `points` points of the other, 1/m². It stays bounded where the two touch.
    pub fn solid_mean(&self, other: &Node, plate: &Node, seed: u64, points: usize) -> f64 {
        let zone = self.tree.zone[plate.first as usize] as usize;
        let Some(p) = self.zones.patches.get(zone) else {
            return 0.0;
        };
        let shift = sequence::shift(seed);
        let mut sum = 0.0;
        for k in 0..points {
            let (x, n, _) = self.point(other, sequence::r3(k, shift));
            sum += match other.kind {
                Kind::Patch if (x - p.plate.origin).dot(p.normal) <= 0.0 => 0.0,
                Kind::Patch => projected_solid_angle(&p.plate, x, n),
                _ => solid_angle(&p.plate, x).max(0.0),
            };
        }
        let mean = sum / (PI * p.area * points as f64);
        // What crosses a voxel is its mean chord at most: ∫ cos/(π r²) dV ≤ its extent. Patches send no more than they have.
        let most = match other.kind {
            Kind::Voxel => 2.0 * other.radius() / self.cell.product(),
            _ => 1.0 / p.area,
        };
        if mean.is_finite() { mean.min(most) } else { 0.0 }
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
