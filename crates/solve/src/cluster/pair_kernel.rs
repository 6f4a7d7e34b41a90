//! The mean kernel of a pair of nodes, before occlusion, and the error of its expansion.
//!
//! With the second-order terms q and c of [`super::kernel`] a pair leaves at i the relative errors
//!
//! ```text
//! q_i (half at a leaf) + c²   of the incident radiation,   q_j^{3/2}/2   of the source       expanded pairs
//! 0.3; 1 for a node with itself; 0.6 where planes cut; half as much of the source            pairs of zeroth order
//! ```
//!
//! Boxes and axis-parallel rectangles have their exact mean kernel, near zones a mean solid angle or the factor of the dense engine.

use super::cluster_visibility::{ClusterVisibility, VisibilityEstimate};
use super::kernel::{CompactNode, PairGeometry, SecondOrderTerms, height_range, is_behind};
use super::refinement_params::REFINEMENT_PARAMS;
use super::tree::{ClusterKind, ClusterNode, ClusterTree};
use std::f64::consts::PI;
use zonal_exchange::aligned::{Cuboid, FactorCache};
use zonal_exchange::pair::{Exchange, PairCounts};
use zonal_exchange::solid_angle_quadrature::DistanceMoments;
use zonal_math::{Vec3, low_discrepancy};
use zonal_scene::{Band, Bands};

/// A kernel of every band group, 1/m²: the value of its first band; zero in the other bands.
pub(crate) type GroupKernel = Bands;

/// A kernel with its relative errors at both ends, before occlusion.
pub(crate) struct PairKernel {
    /// Mean kernel.
    pub kernel: GroupKernel,
    /// Relative error of the incident radiation at either end.
    pub receiver_error: [f64; 2],
    /// Relative error by the variation of the kernel over the source of either end.
    pub source_error: [f64; 2],
    /// q at either end.
    pub variation: [f64; 2],
    /// True without an expansion.
    pub zeroth_order: bool,
}

/// A pair that is to become a link.
pub(crate) struct LinkRequest {
    /// Indices of the nodes.
    pub ends: [usize; 2],
    /// True for two zones.
    pub are_zones: bool,
    /// The kernel before occlusion.
    pub pair: PairKernel,
    /// Power carried over the tolerance, the larger of both directions.
    pub significance: f64,
}

impl LinkRequest {
    /// q_i + q_j.
    pub(crate) fn total_variation(&self) -> f64 {
        self.pair.variation[0] + self.pair.variation[1]
    }
}

/// Kernel and error of an exchange in full.
pub(crate) struct FullExchange {
    /// Mean kernel, occlusion included.
    pub kernel: GroupKernel,
    /// Largest absolute error, 1/m².
    pub error: f64,
    /// Rays traced.
    pub rays: u64,
}

/// The kernels of all pairs of nodes.
pub(crate) struct PairKernels<'a> {
    /// The tree.
    pub tree: &'a ClusterTree,
    /// Its nodes as the kernel reads them.
    pub nodes: &'a [CompactNode],
    /// Rays between clusters.
    pub visibility: &'a ClusterVisibility<'a>,
    /// Exchange factors of pairs of zones.
    pub exchange: &'a Exchange<'a>,
    /// Exchange factors of boxes and axis-parallel rectangles.
    pub box_factors: &'a FactorCache,
    /// The first band of each band group.
    pub first_bands: &'a [Band],
}

impl PairKernels<'_> {
    /// The two nodes of a pair.
    pub(crate) fn nodes_of(&self, [i, j]: [usize; 2]) -> [&ClusterNode; 2] {
        [&self.tree.nodes[i], &self.tree.nodes[j]]
    }

    /// The kernel of two nodes before occlusion, with its errors; `None` where they face away from each other.
    pub(crate) fn expand(&self, i: usize, j: usize) -> Option<PairKernel> {
        let [a, b] = self.nodes_of([i, j]);
        let mut cut = a.kind == ClusterKind::Mixed || b.kind == ClusterKind::Mixed;
        for (p, q) in [(a, b), (b, a)] {
            if p.kind == ClusterKind::Patch {
                let [low, high] = height_range(p, q);
                if is_behind(p, q, high) {
                    return None;
                }
                cut |= low < -1e-6 * q.radius();
            }
        }
        let geometry = PairGeometry::new(&self.nodes[i], &self.nodes[j]);
        let depth = self.visibility.depth(a.centre(), b.centre());
        let mut kernel = Bands::ZERO;
        for &band in self.first_bands {
            kernel[band] = (-depth[band]).exp();
        }
        if geometry.zeroth_order || cut {
            Some(self.zeroth_order(&geometry, kernel, [i, j]))
        } else {
            Some(self.second_order(&geometry, kernel, [i, j]))
        }
    }

    /// A guess of the kernel from the distance, for the decision to split: boxes that become links have their exact mean, others a mean over
    /// points. `kernel` is the transmittance.
    fn zeroth_order(&self, geometry: &PairGeometry, mut kernel: GroupKernel, ends: [usize; 2]) -> PairKernel {
        let [a, b] = self.nodes_of(ends);
        let min_r2 = 0.1 * (a.radius() + b.radius()).powi(2);
        let inverse_square = 1.0 / (PI * (geometry.r * geometry.r).max(min_r2));
        let mut share = 1.0;
        for (n, h) in [(a, geometry.heights[0]), (b, geometry.heights[1])] {
            if n.kind == ClusterKind::Patch {
                let reach = (geometry.r + a.radius() + b.radius()).max(1e-300);
                share *=
                    ((h / reach).max(0.0) + 0.25 * (1.0 - (geometry.r / reach).min(1.0))).clamp(0.02, 1.0);
            }
        }
        self.first_bands.iter().for_each(|&band| kernel[band] *= inverse_square * share);
        let relative = if ends[0] == ends[1] {
            1.0
        } else if a.fills_box && b.fills_box {
            REFINEMENT_PARAMS.zeroth_order_error
        } else {
            REFINEMENT_PARAMS.cut_pair_error
        };
        PairKernel {
            kernel,
            receiver_error: [relative; 2],
            source_error: [0.5 * relative; 2],
            variation: [1.0; 2],
            zeroth_order: true,
        }
    }

    /// The kernel by its expansion about the centroids; `kernel` is the transmittance.
    fn second_order(
        &self,
        geometry: &PairGeometry,
        mut kernel: GroupKernel,
        [i, j]: [usize; 2],
    ) -> PairKernel {
        let [a, b] = self.nodes_of([i, j]);
        let (compact_a, compact_b) = (&self.nodes[i], &self.nodes[j]);
        let kappa = 0.5 * (compact_a.extinction + compact_b.extinction) as f64;
        let l = geometry.gradient(compact_a, compact_b, kappa);
        let terms = SecondOrderTerms::new(geometry, a, b, l, kappa);
        for &band in self.first_bands {
            kernel[band] *= geometry.geometric_kernel * terms.mean_factor;
            for (n, h) in [(a, geometry.heights[0]), (b, geometry.heights[1])] {
                if n.kind == ClusterKind::Pane {
                    kernel[band] *= self.pane_absorptance_factor(n, h / geometry.r)[band];
                }
            }
        }
        let q = terms.variation;
        let exact = a.fills_box && b.fills_box;
        let bias = if exact { 0.0 } else { terms.correction * terms.correction };
        let receiver = |e: usize, leaf: bool| bias + if leaf { 0.5 * q[e] } else { q[e] };
        let source = |e: usize, leaf: bool| if leaf { 0.0 } else { 0.5 * q[e] * q[e].sqrt() };
        PairKernel {
            kernel,
            receiver_error: [receiver(0, a.is_leaf()), receiver(1, b.is_leaf())],
            source_error: [source(1, b.is_leaf()), source(0, a.is_leaf())],
            variation: q,
            zeroth_order: false,
        }
    }

    /// Transmittance of the medium between two centroids.
    pub(crate) fn centre_transmittance(&self, a: &ClusterNode, b: &ClusterNode) -> Bands {
        (-self.visibility.depth(a.centre(), b.centre())).exp()
    }

    /// Replaces `kernel` by a better mean kernel without occlusion where there is one: exact for boxes, by points for near zones, otherwise
    /// with the transmittance of `sampled`, the rays through a varying medium. Returns the number of factors of near zones.
    pub(crate) fn improve_mean(
        &self,
        r: &LinkRequest,
        sampled: Option<&VisibilityEstimate>,
        kernel: &mut GroupKernel,
    ) -> u64 {
        let [a, b] = self.nodes_of(r.ends);
        let (q, zeroth_order) = (r.total_variation(), r.pair.zeroth_order);
        // The solid angle serves a pair with a patch; between volumes at a distance the second order does.
        let has_patch = a.kind == ClusterKind::Patch || b.kind == ClusterKind::Patch;
        let transmittance = || sampled.map_or_else(|| self.centre_transmittance(a, b), |s| s.transmittance);
        if a.fills_box && b.fills_box && (zeroth_order || q > REFINEMENT_PARAMS.max_variation_of_boxes) {
            *kernel = self.box_kernel(a, b, sampled.map(|s| s.transmittance));
        } else if r.are_zones
            && has_patch
            && (zeroth_order || q > REFINEMENT_PARAMS.max_variation_of_zones)
            && r.significance > 1.0
        {
            let geometric = self.near_zones(r);
            let transmittance = transmittance();
            self.first_bands.iter().for_each(|&band| kernel[band] = geometric * transmittance[band]);
            return 1;
        } else if sampled.is_some() && !zeroth_order {
            let centre = self.centre_transmittance(a, b);
            let relative = transmittance().zip_map(centre, |t, centre| t / centre.max(1e-30));
            self.first_bands.iter().for_each(|&band| kernel[band] *= relative[band]);
        }
        0
    }

    /// The exchange of two zones as the dense engine computes it.
    pub(crate) fn full_exchange(&self, [i, j]: [usize; 2]) -> FullExchange {
        let mut counts = PairCounts::default();
        let f = self.exchange.pair(self.zone(i), self.zone(j), &mut counts);
        let measure = self.measure(i) * self.measure(j);
        let mut out = FullExchange { kernel: Bands::ZERO, error: 0.0, rays: counts.rays };
        for &b in self.first_bands {
            out.kernel[b] = f.value[b] / measure;
            out.error = out.error.max(f.radius[b] / measure);
        }
        out
    }

    /// (1 − e^{−κt/c})/(κt/c) of a pane zone at the cosine c: its kernel relative to that of a thin sheet of its volume.
    pub(crate) fn pane_absorptance_factor(&self, n: &ClusterNode, cos: f64) -> Bands {
        self.visibility.pane(n).map_or(Bands::ONE, |(kappa, t)| {
            kappa.map(|k| {
                let depth = k * t / cos.max(1e-6);
                // A sheet of volume A t emits κ A t times this; its projected area is included already.
                if depth > 1e-9 { -(-depth).exp_m1() / depth / cos.max(1e-6) } else { 1.0 / cos.max(1e-6) }
            })
        })
    }

    /// The zone of a leaf node.
    fn zone(&self, leaf: usize) -> usize {
        self.tree.leaf_zones[leaf - self.tree.inner_nodes] as usize
    }

    fn measure(&self, leaf: usize) -> f64 {
        self.tree.nodes[leaf].measure as f64
    }

    /// The geometric kernel of two near zones, one of them a patch: the factor of two patches, or the mean solid angle of a patch over a number
    /// of points that grows with the significance.
    fn near_zones(&self, r: &LinkRequest) -> f64 {
        let ([i, j], significance) = (r.ends, r.significance);
        let [a, b] = self.nodes_of(r.ends);
        let least = REFINEMENT_PARAMS.near_points;
        let points = ((least as f64 * significance.sqrt()).ceil() as usize)
            .clamp(least, REFINEMENT_PARAMS.max_near_points_factor * least);
        let seed = low_discrepancy::split_mix64((j as u64) << 32 | i as u64);
        match (a.kind, b.kind) {
            (ClusterKind::Voxel, _) => self.visibility.mean_solid_angle_kernel(a, b, seed, points),
            (_, ClusterKind::Voxel) => self.visibility.mean_solid_angle_kernel(b, a, seed, points),
            _ if significance < REFINEMENT_PARAMS.min_significance_for_full_factor => {
                let (small, large) = if a.measure < b.measure { (a, b) } else { (b, a) };
                self.visibility.mean_solid_angle_kernel(small, large, seed, points)
            }
            _ => {
                let tolerance = REFINEMENT_PARAMS.zone_factor_tolerance;
                let factor = self.exchange.unobstructed_plates(self.zone(i), self.zone(j), tolerance);
                factor.value / (self.measure(i) * self.measure(j))
            }
        }
    }

    /// The exact mean kernel of two boxes, or axis-parallel rectangles, in a medium of the given transmittance, otherwise in one with the mean
    /// extinction between the centroids.
    fn box_kernel(&self, a: &ClusterNode, b: &ClusterNode, transmittance: Option<Bands>) -> GroupKernel {
        let (p, q) = (cuboid(a), cuboid(b));
        let moments = DistanceMoments::from(self.box_factors.get_cumulants(&p, &q));
        let measures = cuboid_measure(&p) * cuboid_measure(&q);
        let mut kernel = Bands::ZERO;
        if let Some(transmittance) = transmittance {
            for &band in self.first_bands {
                kernel[band] = moments.factor.value * transmittance[band] / measures;
            }
            return kernel;
        }
        let (x, y) = (a.centre(), b.centre());
        let r = (x - y).length();
        let kappa = if r > 1e-6 * a.radius() {
            self.visibility.depth(x, y) / r
        } else {
            Bands::splat(a.extinction as f64)
        };
        for &band in self.first_bands {
            kernel[band] = moments.factor.value * moments.transmittance(kappa[band]) / measures;
        }
        kernel
    }
}

/// The box of a node; of a patch cluster the rectangle in its plane.
fn cuboid(n: &ClusterNode) -> Cuboid {
    let axis = (0..3).find(|&x| n.kind == ClusterKind::Patch && n.normal[x].abs() > 0.5);
    let mut hi = n.hi;
    if let Some(x) = axis {
        let mut h = hi.array();
        h[x] = n.lo[x];
        hi = Vec3::from_array(h);
    }
    Cuboid { lo: n.lo, hi, normal: axis.map(|x| (x, if n.normal[x] > 0.0 { 1 } else { -1 })) }
}

/// Volume of a box, area of a rectangle.
fn cuboid_measure(c: &Cuboid) -> f64 {
    let e = c.hi - c.lo;
    c.normal.map_or(e.product(), |(x, _)| e[(x + 1) % 3] * e[(x + 2) % 3])
}
