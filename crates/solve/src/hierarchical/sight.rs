//! What two clusters see of each other: the visible share by rays, the attenuation by the walk between the centres.
//!
//! A ray joins a point of i and a point of j, leaf by its measure, points from a six-dimensional low-discrepancy sequence shifted by a
//! hash of the pair: one set of rays serves both directions. A ray counts by the kernel between its ends. With m rays the visible
//! share v has the standard error √(v(1 − v)/m) where they differ; where all agree, 1/(m + 2) (Laplace's rule of succession), except
//! where no facet reaches into the hull of the pair: then v = 1 exactly, and no ray is asked.
//!
//! How many rays is fixed before the first of them, by what the link deserves: stopping when they agree would make what is hardly seen darker
//! than it is, everywhere, and such errors add up. For the same reason the rays that ask whether to split a pair are not those that
//! tell what it sees.

use super::near::is_above;
use super::tree::{Kind, Node, Tree};
use crate::surroundings::voxel_point;
use std::f64::consts::PI;
use zonal_exchange::pair::SUCCESSION;
use zonal_math::{Vec3, sequence, vec3};
use zonal_scene::{Bands, Plate, Scene, Zones, bands};
use zonal_transport::solid_angle::{projected_solid_angle, solid_angle};
use zonal_transport::{End, Transport};

/// Most rays of a link.
pub const MOST_RAYS: usize = 128;

/// What rays found between two clusters.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// The visible share, panes between included, a band.
    pub share: Bands,
    /// Its error, with that of the mean of what the medium lets pass.
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

/// A point of a cluster.
pub(super) struct Spotted {
    /// Position, m.
    pub at: Vec3,
    /// The normal of its zone, zero in a volume.
    pub normal: Vec3,
    /// The square of the size of its zone, m².
    pub size: f64,
}

/// A scene ready for questions about pairs of clusters.
pub struct Sight<'a> {
    pub(super) zones: &'a Zones,
    transport: &'a Transport<'a>,
    pub(super) tree: &'a Tree,
    /// Σ of the measures of the leaves before each.
    before: Vec<f64>,
    pub(super) cell: Vec3,
    /// Square of the edge of a cell, m².
    cell_size: f64,
    occluders: bool,
    panes: bool,
    /// The extinction differs from cell to cell, or zones lie outside of the medium.
    varied: bool,
}

/// How to look.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Nothing can stand between.
    pub clear: bool,
    /// Along the rays through the medium.
    pub through: bool,
    /// Half the zones by number rather than by measure.
    pub by_number: bool,
    /// The kernel between points is kept from growing without bound where they come close.
    pub tamed: bool,
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
    // Few paths vary less about their own mean than about that of all.
    let few = paths.len() as f64 / (paths.len().max(2) - 1) as f64;
    (few * (square / (mean * mean) - 1.0).max(0.0)).sqrt()
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

    /// A zone of a cluster, by its measure or half by number, and what is left of `u`.
    fn pick(&self, n: &Node, u: f64, by_number: bool) -> (usize, f64) {
        if n.is_leaf() {
            return (self.tree.zone[n.first as usize] as usize, u);
        }
        let (first, last) = (n.first as usize, n.last as usize);
        let (slot, rest) = if by_number && u < 0.5 {
            let count = (last - first) as f64;
            let at = (2.0 * u * count).min(count - 1e-6);
            (first + at as usize, at.fract())
        } else {
            let u = if by_number { 2.0 * u - 1.0 } else { u };
            let (a, b) = (self.before[first], self.before[last]);
            let target = a + u * (b - a);
            let slot = first + self.before[first + 1..last].partition_point(|x| *x <= target);
            (slot, (target - self.before[slot]) / (self.before[slot + 1] - self.before[slot]))
        };
        (self.tree.zone[slot] as usize, sequence::wrap(rest.clamp(0.0, 1.0 - 1e-9)))
    }

    /// A point of a cluster; half of the zones are chosen by number where asked, so that small ones are seen too.
    pub(super) fn point(&self, n: &Node, u: [f64; 3], by_number: bool) -> Spotted {
        let (zone, first) = self.pick(n, u[0], by_number);
        let u = [first, u[1], u[2]];
        let zones = self.zones;
        let on = |plate: &Plate, normal: Vec3, size: f64| {
            let [s, t] = plate.warp([u[0], u[1]]);
            Spotted { at: plate.at(s, t), normal, size }
        };
        if zone < zones.voxel_offset() {
            let p = &zones.patches[zone];
            on(&p.plate, p.normal, p.area)
        } else if zone < zones.pane_offset() {
            let z = &zones.voxels[zone - zones.voxel_offset()];
            Spotted { at: voxel_point(z, self.cell, u), normal: Vec3::ZERO, size: self.cell_size }
        } else {
            let p = &zones.panes[zone - zones.pane_offset()];
            on(&p.plate, p.normal, p.area)
        }
    }

    /// Looks along `rays` rays between points of two clusters, by measure or as asked; `through` the medium where that varies. Their number
    /// is fixed beforehand: rays that go on only where the first ones disagree make what is hardly seen darker than it is.
    pub fn look(&self, i: &Node, j: &Node, seed: u64, rays: usize, look: Look) -> Seen {
        let shift = sequence::shift(seed);
        let (mut w, mut sum, mut squares) = (0.0, [0.0; 3], 0.0);
        let mut seen =
            Seen { share: [1.0; 3], error: 0.5, mixed: 0.0, kernel: 0.0, medium: [1.0; 3], rays: 0 };
        // What one point stands for, m²: closer than that, points say nothing of the mean.
        let share = |n: &Node| {
            let w = n.weight as f64 / rays as f64;
            if n.kind == Kind::Voxel { w.powf(2.0 / 3.0) } else { w }
        };
        let (share_i, share_j) = (share(i), share(j));
        let through = look.through;
        // All of them: a medium may hide a small part of a cluster from another.
        let mut paths = Vec::with_capacity(if through && self.varied { rays } else { 0 });
        let mut dimmed = [0.0; 3];
        for k in 0..rays {
            let u = sequence::r6(k, shift);
            let p = self.point(i, [u[0], u[1], u[2]], look.by_number);
            let q = self.point(j, [u[3], u[4], u[5]], look.by_number);
            let (x, y) = (p.at, q.at);
            let d = y - x;
            let r2 = d.length2();
            let size = if look.tamed { p.size.max(share_i).max(q.size).max(share_j) / PI } else { 0.0 };
            let mut weight = 1.0 / (r2 + size);
            for (n, node, d) in [(p.normal, i, d), (q.normal, j, -d)] {
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
            if through {
                let depth = self.transport.medium_depth(x, y);
                (0..3).for_each(|b| dimmed[b] += weight * (-depth[b]).exp());
                if self.varied {
                    paths.push([weight, depth.iter().fold(0.0f64, |m, d| m.max(*d)), r2.sqrt()]);
                }
            }
            let pass = if look.clear { [1.0; 3] } else { self.pass(x, y) };
            seen.rays += u32::from(!look.clear);
            (0..3).for_each(|b| sum[b] += weight * pass[b]);
            squares += weight * pass[0] * pass[0];
        }
        seen.kernel = w / (rays as f64 * PI);
        if through && w > 0.0 {
            seen.medium = dimmed.map(|d| d / w);
            seen.mixed = if self.varied { uneven(&paths) } else { 0.0 };
        }
        // What the mean over these points leaves open of a medium that varies.
        let dim = if through { seen.mixed / (rays as f64).sqrt() } else { 0.0 };
        if look.clear {
            let Seen { kernel, medium, mixed, .. } = seen;
            return Seen { kernel, medium, mixed, error: dim, ..Seen::CLEAR };
        }
        if w <= 0.0 {
            // No ray could carry anything: a sliver of exchange at most.
            return seen;
        }
        seen.share = sum.map(|s| s / w);
        let v = seen.share[0];
        let spread = (squares / w - v * v).max(0.0).sqrt();
        let m = seen.rays as f64;
        let agree = v <= 1e-12 || v >= 1.0 - 1e-12;
        seen.mixed = spread.hypot(seen.mixed);
        let missed = if agree { 1.0 / (m + SUCCESSION) } else { (spread / m.sqrt()).max(0.5 / (m * m)) };
        seen.error = missed.hypot(dim * v);
        seen
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
            let Spotted { at: x, normal: n, .. } = self.point(other, sequence::r3(k, shift), false);
            sum += match other.kind {
                Kind::Patch if !is_above(p, x) => 0.0,
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
    pub(super) fn pass(&self, x: Vec3, y: Vec3) -> Bands {
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
