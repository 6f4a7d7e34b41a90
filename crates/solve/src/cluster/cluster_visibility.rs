//! Visibility and attenuation between two clusters, sampled by rays.
//!
//! A ray joins a point of i and a point of j; the zones are chosen in proportion to their measure, the points by a six-dimensional
//! low-discrepancy sequence with a shift that is a hash of the pair, so that one set of rays serves both directions. A ray has the weight
//! of the kernel between its ends. With m rays the visible fraction v has the standard error √(v(1 − v)/m) where they differ. Where all
//! agree the error is 1/(m + 2) (Laplace's rule of succession), except where no facet reaches into the convex hull of the pair: then v = 1
//! exactly, without rays.
//!
//! The number of rays is fixed beforehand, by the significance of the link: stopping as soon as rays agree would underestimate what is
//! rarely visible, everywhere, and such errors add up. For the same reason the rays that decide whether to split a pair are not those
//! that measure it.

use super::tree::{ClusterKind, ClusterNode, ClusterTree};
use crate::surroundings::zone_rays::voxel_point;
use std::f64::consts::PI;
use zonal_exchange::pair::SUCCESSION_PSEUDO_COUNTS;
use zonal_math::{Vec3, low_discrepancy, vec3};
use zonal_scene::{Bands, Patch, Plate, Scene, Zones};
use zonal_transport::solid_angle::{projected_solid_angle, solid_angle};
use zonal_transport::{ShaftEnd, Transport};

/// Deviation of the visible fraction from 0 or 1 below which all rays agree.
pub(crate) const AGREEMENT_TOLERANCE: f64 = 1e-12;
/// Heights over a patch that are zero within rounding, over the square root of its area.
const HEIGHT_ROUNDING: f64 = 1e-7;
/// Error of a pair between which no ray carries radiation.
const ERROR_WITHOUT_RAYS: f64 = 0.5;

/// Visibility between two clusters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VisibilityEstimate {
    /// The visible fraction, panes between included, a band.
    pub visible_fraction: Bands,
    /// Its error, with that of the mean transmittance of the medium.
    pub error: f64,
    /// Standard deviation of the result of one ray: 0 where all agree.
    pub deviation: f64,
    /// Mean geometric kernel over the points, 1/m².
    pub mean_kernel: f64,
    /// Mean transmittance of the medium over the same rays, a band; 1 where it is not measured.
    pub transmittance: Bands,
    /// Rays traced.
    pub rays: u32,
}

impl VisibilityEstimate {
    /// Nothing occludes the pair.
    pub(crate) const UNOCCLUDED: VisibilityEstimate = VisibilityEstimate {
        visible_fraction: Bands::ONE,
        error: 0.0,
        deviation: 0.0,
        mean_kernel: 0.0,
        transmittance: Bands::ONE,
        rays: 0,
    };
}

/// A point of a cluster.
pub(crate) struct ClusterPoint {
    /// Position, m.
    pub position: Vec3,
    /// The normal of its zone, zero in a volume.
    pub normal: Vec3,
    /// The square of the size of its zone, m².
    pub zone_size: f64,
}

/// Choice of the zone of a cluster in which a point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ZoneChoice {
    /// In proportion to its measure.
    ByMeasure,
    /// Half of the points in proportion to the measure, half with the same probability for all zones, so that small ones are met.
    HalfUniform,
}

/// How visibility is sampled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VisibilitySampling {
    /// True where nothing can occlude the pair.
    pub unoccluded: bool,
    /// True if the transmittance of the medium is measured along the rays.
    pub through_medium: bool,
    /// Choice of the zones.
    pub choice: ZoneChoice,
    /// True if the kernel between points is limited by the size of the zones where they come close.
    pub bounded_kernel: bool,
}

/// Visibility tests between the clusters of a tree.
pub(crate) struct ClusterVisibility<'a> {
    /// The zones.
    pub zones: &'a Zones,
    transport: &'a Transport<'a>,
    /// The tree.
    pub tree: &'a ClusterTree,
    /// Sum of the measures of the leaves before each leaf.
    measure_before: Vec<f64>,
    /// Edges of a cell, m.
    pub cell: Vec3,
    /// Square of the edge of a cell, m².
    cell_size: f64,
    has_occluders: bool,
    has_panes: bool,
    /// True where the extinction differs from cell to cell.
    has_varying_medium: bool,
}

/// Sums over the rays of a pair.
#[derive(Default)]
struct RaySums {
    weight: f64,
    visible: Bands,
    /// Weighted squares of the visibility in the first band.
    squares: f64,
    transmitted: Bands,
    /// Weight, optical depth and length of every ray through a varying medium.
    paths: Vec<[f64; 3]>,
    rays: u32,
}

/// Relative standard deviation of e^{−(δ − κ̄ r)} over paths (weight, depth δ, length r): by how much the attenuation differs from that of a
/// uniform medium.
fn transmittance_deviation(paths: &[[f64; 3]]) -> f64 {
    let sum = |k: usize| paths.iter().map(|p| p[0] * p[k]).sum::<f64>();
    let (w, length) = (paths.iter().map(|p| p[0]).sum::<f64>(), sum(2));
    if w <= 0.0 || length <= 0.0 {
        return 0.0;
    }
    let kappa = sum(1) / length;
    let x = |p: &[f64; 3]| (kappa * p[2] - p[1]).exp();
    let mean = paths.iter().map(|p| p[0] * x(p)).sum::<f64>() / w;
    let square = paths.iter().map(|p| p[0] * x(p) * x(p)).sum::<f64>() / w;
    // Bessel's correction.
    let correction = paths.len() as f64 / (paths.len().max(2) - 1) as f64;
    (correction * (square / (mean * mean) - 1.0).max(0.0)).sqrt()
}

/// True where the front of a patch faces the point.
pub(crate) fn faces_point(p: &Patch, x: Vec3) -> bool {
    (x - p.plate.origin).dot(p.normal) > HEIGHT_ROUNDING * p.area.sqrt()
}

impl<'a> ClusterVisibility<'a> {
    /// Prepares the choice of zones by their measure.
    pub(crate) fn new(
        scene: &'a Scene,
        zones: &'a Zones,
        transport: &'a Transport<'a>,
        tree: &'a ClusterTree,
    ) -> ClusterVisibility<'a> {
        let mut measure_before = Vec::with_capacity(tree.leaves() + 1);
        let mut sum = 0.0;
        measure_before.push(0.0);
        for leaf in 0..tree.leaves() {
            sum += tree.nodes[tree.leaf_node(leaf)].measure as f64;
            measure_before.push(sum);
        }
        let grid = scene.voxel_grid();
        ClusterVisibility {
            zones,
            transport,
            tree,
            measure_before,
            cell: grid.map_or(Vec3::ZERO, |v| v.cell()),
            cell_size: grid.map_or(0.0, |v| v.cell().product().powf(2.0 / 3.0)),
            has_occluders: transport.has_occluders(),
            has_panes: transport.has_interior_panes(),
            has_varying_medium: grid.is_some_and(|v| v.uniform_extinction().is_none()),
        }
    }

    /// Extinction (1/m) and thickness (m) of a pane zone; `None` for other nodes.
    pub(crate) fn pane(&self, n: &ClusterNode) -> Option<(Bands, f64)> {
        let zone = self.tree.zone_of(n);
        let p = self.zones.panes.get(zone.checked_sub(self.zones.pane_offset())?)?;
        Some((p.extinction, p.thickness))
    }

    /// Optical depth between two points, without panes, a band.
    pub(crate) fn depth(&self, a: Vec3, b: Vec3) -> Bands {
        self.transport.medium_depth(a, b)
    }

    /// True where the extinction differs from cell to cell.
    pub(crate) fn has_varying_medium(&self) -> bool {
        self.has_varying_medium
    }

    /// True where nothing can occlude any pair of points of the scene.
    pub(crate) fn is_unoccluded_scene(&self) -> bool {
        !self.has_occluders && !self.has_panes
    }

    /// True where it is proved that no facet and no pane reaches into the convex hull of the pair.
    pub(crate) fn is_unoccluded(&self, i: &ClusterNode, j: &ClusterNode) -> bool {
        if self.is_unoccluded_scene() {
            return true;
        }
        if self.has_panes {
            return false;
        }
        let (mut p, mut q) = ([Vec3::ZERO; 8], [Vec3::ZERO; 8]);
        let ends = [self.shaft_end(i, &mut p), self.shaft_end(j, &mut q)];
        !self.transport.may_occlude(ends)
    }

    fn shaft_end<'b>(&self, n: &ClusterNode, points: &'b mut [Vec3; 8]) -> ShaftEnd<'b> {
        if n.is_leaf() && n.kind == ClusterKind::Patch {
            let p = &self.zones.patches[self.tree.zone_of(n)];
            let (c, count) = p.plate.corners();
            points[..4].copy_from_slice(&c);
            return ShaftEnd { points: &points[..count], front: Some(p.normal) };
        }
        let coordinate = |k: usize, a: usize| if k >> a & 1 == 1 { n.hi[a] } else { n.lo[a] };
        *points = std::array::from_fn(|k| vec3(coordinate(k, 0), coordinate(k, 1), coordinate(k, 2)));
        ShaftEnd { points: &points[..], front: None }
    }

    /// A zone of a cluster by the uniform number `u`, and a uniform number that is independent of the choice.
    fn choose_zone(&self, n: &ClusterNode, u: f64, choice: ZoneChoice) -> (usize, f64) {
        if n.is_leaf() {
            return (self.tree.zone_of(n), u);
        }
        let half_uniform = choice == ZoneChoice::HalfUniform;
        let (first, last) = (n.first_leaf as usize, n.end_leaf as usize);
        let (leaf, rest) = if half_uniform && u < 0.5 {
            let count = (last - first) as f64;
            let at = (2.0 * u * count).min(count - 1e-6);
            (first + at as usize, at.fract())
        } else {
            let u = if half_uniform { 2.0 * u - 1.0 } else { u };
            let before = &self.measure_before;
            let (a, b) = (before[first], before[last]);
            let target = a + u * (b - a);
            let leaf = first + before[first + 1..last].partition_point(|x| *x <= target);
            (leaf, (target - before[leaf]) / (before[leaf + 1] - before[leaf]))
        };
        (self.tree.leaf_zones[leaf] as usize, low_discrepancy::wrap(rest.clamp(0.0, 1.0 - 1e-9)))
    }

    /// A point of a cluster by three uniform numbers.
    pub(crate) fn point(&self, n: &ClusterNode, u: [f64; 3], choice: ZoneChoice) -> ClusterPoint {
        let (zone, first) = self.choose_zone(n, u[0], choice);
        let u = [first, u[1], u[2]];
        let zones = self.zones;
        let on_plate = |plate: &Plate, normal: Vec3, zone_size: f64| {
            let [s, t] = plate.warp([u[0], u[1]]);
            ClusterPoint { position: plate.at(s, t), normal, zone_size }
        };
        if zone < zones.voxel_offset() {
            let p = &zones.patches[zone];
            on_plate(&p.plate, p.normal, p.area)
        } else if zone < zones.pane_offset() {
            let z = &zones.voxels[zone - zones.voxel_offset()];
            let position = voxel_point(z, self.cell, u);
            ClusterPoint { position, normal: Vec3::ZERO, zone_size: self.cell_size }
        } else {
            let p = &zones.panes[zone - zones.pane_offset()];
            on_plate(&p.plate, p.normal, p.area)
        }
    }

    /// Samples the visibility of two clusters by `rays` rays.
    pub(crate) fn sample(
        &self,
        i: &ClusterNode,
        j: &ClusterNode,
        seed: u64,
        rays: usize,
        sampling: VisibilitySampling,
    ) -> VisibilityEstimate {
        let shift = low_discrepancy::random_shift(seed);
        // The area that one point represents, m²: points closer than that do not represent the mean.
        let area = |n: &ClusterNode| {
            let w = n.measure as f64 / rays as f64;
            if n.kind == ClusterKind::Voxel { w.powf(2.0 / 3.0) } else { w }
        };
        let (area_i, area_j) = (area(i), area(j));
        let mut sums = RaySums::default();
        for k in 0..rays {
            let u = low_discrepancy::r6(k, shift);
            let p = self.point(i, [u[0], u[1], u[2]], sampling.choice);
            let q = self.point(j, [u[3], u[4], u[5]], sampling.choice);
            let d = q.position - p.position;
            let r2 = d.length2();
            let softening = match sampling.bounded_kernel {
                true => p.zone_size.max(area_i).max(q.zone_size).max(area_j) / PI,
                false => 0.0,
            };
            let mut weight = 1.0 / (r2 + softening);
            for (n, node, d) in [(p.normal, i, d), (q.normal, j, -d)] {
                match node.kind {
                    ClusterKind::Patch => weight *= n.dot(d).max(0.0) / r2.sqrt(),
                    ClusterKind::Pane => weight *= n.dot(d).abs() / r2.sqrt(),
                    _ => {}
                }
            }
            if weight.is_nan() || weight <= 0.0 {
                continue;
            }
            self.add_ray(&mut sums, [p.position, q.position], weight, sampling);
        }
        self.estimate(sums, rays, sampling)
    }

    /// Adds a ray between two points to the sums.
    fn add_ray(&self, sums: &mut RaySums, [x, y]: [Vec3; 2], weight: f64, sampling: VisibilitySampling) {
        sums.weight += weight;
        if sampling.through_medium {
            let depth = self.transport.medium_depth(x, y);
            sums.transmitted += weight * (-depth).exp();
            if self.has_varying_medium {
                let length = (y - x).length2().sqrt();
                sums.paths.push([weight, depth.iter().fold(0.0f64, |m, d| m.max(*d)), length]);
            }
        }
        let pass = if sampling.unoccluded { Bands::ONE } else { self.transmittance_of_panes(x, y) };
        sums.rays += u32::from(!sampling.unoccluded);
        sums.visible += weight * pass;
        sums.squares += weight * pass.first() * pass.first();
    }

    /// The visibility and its error from the sums over `rays` rays.
    fn estimate(&self, sums: RaySums, rays: usize, sampling: VisibilitySampling) -> VisibilityEstimate {
        let w = sums.weight;
        let mean_kernel = w / (rays as f64 * PI);
        // The medium: its mean transmittance and the error of that mean.
        let (mut transmittance, mut medium_deviation) = (Bands::ONE, 0.0);
        if sampling.through_medium && w > 0.0 {
            transmittance = sums.transmitted / w;
            medium_deviation =
                if self.has_varying_medium { transmittance_deviation(&sums.paths) } else { 0.0 };
        }
        let medium_error =
            if sampling.through_medium { medium_deviation / (rays as f64).sqrt() } else { 0.0 };
        let clear = VisibilityEstimate {
            mean_kernel,
            transmittance,
            deviation: medium_deviation,
            error: medium_error,
            ..VisibilityEstimate::UNOCCLUDED
        };
        if sampling.unoccluded {
            return clear;
        }
        if w <= 0.0 {
            // No ray carries radiation: the exchange is negligible.
            return VisibilityEstimate { error: ERROR_WITHOUT_RAYS, rays: sums.rays, ..clear };
        }
        // Occluders: the visible fraction, and its error with that of the medium.
        let visible_fraction = sums.visible / w;
        let v = visible_fraction.first();
        let spread = (sums.squares / w - v * v).max(0.0).sqrt();
        let m = sums.rays as f64;
        let agree = v <= AGREEMENT_TOLERANCE || v >= 1.0 - AGREEMENT_TOLERANCE;
        let visibility_error =
            if agree { 1.0 / (m + SUCCESSION_PSEUDO_COUNTS) } else { (spread / m.sqrt()).max(0.5 / (m * m)) };
        VisibilityEstimate {
            visible_fraction,
            error: visibility_error.hypot(medium_error * v),
            deviation: spread.hypot(medium_deviation),
            mean_kernel,
            transmittance,
            rays: sums.rays,
        }
    }

    /// Mean geometric kernel of a zone and a patch, 1/m²: the solid angle of the patch, projected where the other zone is a patch too, over
    /// its area, at `points` points of the other. It stays bounded where the two touch.
    pub(crate) fn mean_solid_angle_kernel(
        &self,
        other: &ClusterNode,
        patch: &ClusterNode,
        seed: u64,
        points: usize,
    ) -> f64 {
        let Some(p) = self.zones.patches.get(self.tree.zone_of(patch)) else {
            return 0.0;
        };
        let shift = low_discrepancy::random_shift(seed);
        let mut sum = 0.0;
        for k in 0..points {
            let u = low_discrepancy::r3(k, shift);
            let ClusterPoint { position: x, normal: n, .. } = self.point(other, u, ZoneChoice::ByMeasure);
            sum += match other.kind {
                ClusterKind::Patch if !faces_point(p, x) => 0.0,
                ClusterKind::Patch => projected_solid_angle(&p.plate, x, n),
                _ => solid_angle(&p.plate, x).max(0.0),
            };
        }
        let mean = sum / (PI * p.area * points as f64);
        // The mean chord limits a voxel: ∫ cos/(π r²) dV ≤ its extent. A patch sends at most its own power.
        let bound = match other.kind {
            ClusterKind::Voxel => 2.0 * other.radius() / self.cell.product(),
            _ => 1.0 / p.area,
        };
        if mean.is_finite() { mean.min(bound) } else { 0.0 }
    }

    /// Transmittance of facets (0 or 1) and panes between two points, a band.
    #[inline]
    pub(crate) fn transmittance_of_panes(&self, x: Vec3, y: Vec3) -> Bands {
        if self.has_occluders && self.transport.occluded_inside(x, y) {
            return Bands::ZERO;
        }
        if !self.has_panes {
            return Bands::ONE;
        }
        (-self.transport.pane_depth_inside(x, y)).exp()
    }
}
