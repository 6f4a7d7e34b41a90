//! Refinement: the choice of the pairs of clusters that exchange as wholes, by the error that a link would leave in the solution
//! (hierarchical radiosity, Hanrahan, Salzman & Aupperle, with an oracle of brightness-weighted errors).
//!
//! With the powers and tolerances of [`super::error_budget`], a = K M_j the incident radiation at i, and the relative errors of
//! [`super::pair_kernel`], a link leaves at i
//!
//! ```text
//! e_i = a (q_i (half at a leaf) + q_j^{3/2}/2 + c²) + 0.3 K W_j σ_j q_j        expanded pairs
//! e_i = a (0.3; 1 for a node with itself; 0.6 where planes cut) · 3/2     pairs of zeroth order
//! ```
//!
//! A pair is accepted where e ≤ tol at **both** ends; otherwise its larger or more varied end is split. Pairs of two zones are always accepted.
//!
//! **Visibility.** A pair that could exceed its tolerance if it is partly occluded is first tested by rays: where a √(v(1 − v)) > γ tol it is
//! split. An accepted pair is then sampled by other rays, whose number is fixed by a/tol, so that the estimate is unbiased. Few rays give
//! the mean of kernel times visibility; many, and boxes, the visible fraction that multiplies a mean kernel known more accurately.
//!
//! Pairs are processed in rounds: a round tests every pair of a list, in parallel, and the pairs that it splits form the next list. Results
//! are joined in the order of the list and do not depend on the number of threads.

use super::cluster_visibility::{VisibilityEstimate, VisibilitySampling, ZoneChoice};
use super::error_budget::ErrorBudget;
use super::links::LinkPairs;
use super::pair_kernel::{GroupKernel, LinkRequest, PairKernel, PairKernels};
use super::refinement_params::REFINEMENT_PARAMS;
use super::tree::{ClusterKind, ClusterNode};
use rayon::prelude::*;
use zonal_math::low_discrepancy;
use zonal_scene::Progress;

/// Pairs of one task.
const PAIRS_PER_TASK: usize = 512;

/// Counters of a refinement.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RefinementCounts {
    /// Pairs tested.
    pub visits: u64,
    /// Rays between clusters.
    pub rays: u64,
    /// Pairs that no facet can occlude.
    pub unoccluded: u64,
    /// Pairs split for partial occlusion.
    pub split_by_visibility: u64,
    /// Pairs of zones with a near-zone geometric factor.
    pub near_factors: u64,
    /// Pairs of zones computed as the dense engine does.
    pub full_factors: u64,
}

impl RefinementCounts {
    fn add(&mut self, o: RefinementCounts) {
        self.visits += o.visits;
        self.rays += o.rays;
        self.unoccluded += o.unoccluded;
        self.split_by_visibility += o.split_by_visibility;
        self.near_factors += o.near_factors;
        self.full_factors += o.full_factors;
    }
}

/// A pair to test.
#[derive(Clone, Copy, Debug)]
struct CandidatePair {
    ends: [u32; 2],
    /// True where nothing can occlude it.
    unoccluded: bool,
}

/// Result of the test of a pair.
enum PairOutcome {
    /// No exchange.
    None,
    /// One end is split.
    Split { end: usize, unoccluded: bool },
    /// The pair becomes a link.
    Link { kernel: GroupKernel, visibility_error: f64 },
}

/// Result of a list of pairs.
#[derive(Default)]
struct RoundResult {
    pairs: LinkPairs,
    next: Vec<CandidatePair>,
    counts: RefinementCounts,
}

/// How an accepted pair is sampled.
struct PairSampling {
    seed: u64,
    visibility: VisibilitySampling,
    /// Points of the mean kernel.
    points: usize,
}

/// Refines the pairs of a tree.
pub(crate) struct Refiner<'a> {
    /// Kernels of the pairs.
    pub pairs: PairKernels<'a>,
    /// Powers and tolerances of the nodes.
    pub budget: &'a ErrorBudget,
}

impl Refiner<'_> {
    /// The pairs of the links, from the root down.
    pub(crate) fn refine(&self, progress: &dyn Progress) -> (LinkPairs, RefinementCounts) {
        let root = self.pairs.tree.root();
        let unoccluded = self.pairs.visibility.is_unoccluded_scene();
        let mut list = vec![CandidatePair { ends: [root, root], unoccluded }];
        let (mut pairs, mut counts) = (LinkPairs::default(), RefinementCounts::default());
        progress.begin("links", 0);
        while !list.is_empty() {
            let parts: Vec<RoundResult> =
                list.par_chunks(PAIRS_PER_TASK).map(|chunk| self.refine_list(chunk)).collect();
            progress.advance(list.len() as u64);
            let mut next = Vec::with_capacity(parts.iter().map(|p| p.next.len()).sum());
            for mut part in parts {
                pairs.append(&mut part.pairs);
                next.extend(part.next);
                counts.add(part.counts);
            }
            list = next;
        }
        progress.end();
        (pairs, counts)
    }

    /// Tests every pair of a list.
    fn refine_list(&self, list: &[CandidatePair]) -> RoundResult {
        let mut out = RoundResult::default();
        for c in list {
            out.counts.visits += 1;
            match self.test_pair(c, &mut out.counts) {
                PairOutcome::None => {}
                PairOutcome::Link { kernel, visibility_error } => {
                    out.pairs.ends.push(c.ends);
                    out.pairs.kernel.extend(self.pairs.first_bands.iter().map(|&band| kernel[band] as f32));
                    out.pairs.visibility_error.push(visibility_error as f32);
                }
                PairOutcome::Split { end, unoccluded } => self.split(c.ends, end, unoccluded, &mut out.next),
            }
        }
        out
    }

    /// Appends the pairs of the children of one end with the other end.
    fn split(&self, ends: [u32; 2], end: usize, unoccluded: bool, next: &mut Vec<CandidatePair>) {
        let children = self.pairs.tree.children(ends[end]);
        let pair = |a: u32, b: u32| CandidatePair { ends: [a.min(b), a.max(b)], unoccluded };
        if ends[0] == ends[1] {
            for (m, &a) in children.iter().enumerate() {
                next.extend(children[..=m].iter().map(|&b| pair(a, b)));
            }
            return;
        }
        let other = ends[1 - end];
        next.extend(children.iter().map(|&k| pair(k, other)));
    }

    /// Decides whether a pair is negligible, split or linked.
    fn test_pair(&self, c: &CandidatePair, counts: &mut RefinementCounts) -> PairOutcome {
        let ends @ [i, j] = c.ends.map(|x| x as usize);
        let [a, b] = self.pairs.nodes_of(ends);
        let are_zones = a.is_leaf() && b.is_leaf();
        // A zone with itself.
        if i == j && a.is_leaf() {
            let is_patch = a.kind == ClusterKind::Patch;
            return if is_patch { PairOutcome::None } else { self.full_exchange(ends, counts) };
        }
        let Some(pair) = self.pairs.expand(i, j) else {
            return PairOutcome::None;
        };
        // Split where the error exceeds the tolerance at either end.
        let significance = self.significance(&pair, ends);
        let has_pane_cluster = [a, b].iter().any(|n| n.kind == ClusterKind::Pane && !n.is_leaf());
        if !are_zones && (has_pane_cluster || self.exceeds_tolerance(&pair, ends)) {
            return PairOutcome::Split { end: end_to_split(a, b, &pair), unoccluded: c.unoccluded };
        }
        let request = LinkRequest { ends, are_zones, pair, significance };
        self.link(&request, c.unoccluded, counts)
    }

    /// Weight of the incident radiation of a node.
    fn unit(&self, n: &ClusterNode) -> f64 {
        if n.kind == ClusterKind::Patch { 1.0 } else { self.budget.volume_weight }
    }

    /// Incident radiation at either end, relative to the mean, with the largest kernel of the bands.
    fn incident(&self, kernel: f64, [i, j]: [usize; 2], end: usize) -> f64 {
        let (receiver, source) = if end == 0 { (i, j) } else { (j, i) };
        kernel * self.budget.power[source] as f64 * self.unit(&self.pairs.tree.nodes[receiver])
    }

    /// The larger ratio of incident radiation to tolerance over both ends.
    fn significance(&self, pair: &PairKernel, ends: [usize; 2]) -> f64 {
        let k = largest(&pair.kernel);
        (0..2).fold(0.0f64, |m, e| m.max(self.incident(k, ends, e) / self.budget.tolerance[ends[e]] as f64))
    }

    /// True where the error of a link exceeds the tolerance at either end.
    fn exceeds_tolerance(&self, pair: &PairKernel, ends: [usize; 2]) -> bool {
        let k = largest(&pair.kernel);
        (0..2).any(|e| {
            let incident = self.incident(k, ends, e);
            let unit = self.unit(&self.pairs.tree.nodes[ends[e]]);
            let deviation = self.budget.power_deviation[ends[1 - e]] as f64;
            let error = incident * pair.receiver_error[e]
                + incident * pair.source_error[e]
                + REFINEMENT_PARAMS.source_variation_share * k * deviation * unit * pair.variation[1 - e];
            error / self.budget.tolerance[ends[e]] as f64 > 1.0
        })
    }

    /// The exchange of two zones in full, as a link.
    fn full_exchange(&self, ends: [usize; 2], counts: &mut RefinementCounts) -> PairOutcome {
        counts.full_factors += 1;
        let full = self.pairs.full_exchange(ends);
        counts.rays += full.rays;
        PairOutcome::Link { kernel: full.kernel, visibility_error: full.error }
    }

    /// True where two zones are computed as the dense engine does.
    fn needs_full_exchange(&self, r: &LinkRequest, wanted_error: f64) -> bool {
        let [a, b] = self.pairs.nodes_of(r.ends);
        let is_near = r.pair.zeroth_order || r.total_variation() > REFINEMENT_PARAMS.max_variation_of_zones;
        let has_cut_voxel =
            a.kind == ClusterKind::Voxel && b.kind == ClusterKind::Voxel && !(a.fills_box && b.fills_box);
        let touching = r.pair.zeroth_order && has_cut_voxel && r.significance > 1.0;
        let is_significant = r.significance > REFINEMENT_PARAMS.min_significance_for_full_factor;
        let is_near_and_difficult = is_near && (has_pane(a, b) || has_cut_voxel && is_significant);
        let precise = wanted_error < REFINEMENT_PARAMS.max_visibility_error_for_pair_factor;
        r.are_zones && (precise || touching || is_near_and_difficult)
    }

    /// Measures the visibility of a pair and makes it a link, or splits it for partial occlusion.
    fn link(&self, r: &LinkRequest, unoccluded: bool, counts: &mut RefinementCounts) -> PairOutcome {
        let [a, b] = self.pairs.nodes_of(r.ends);
        let visibility = self.pairs.visibility;
        let (significance, zeroth_order) = (r.significance, r.pair.zeroth_order);
        let wanted_error = REFINEMENT_PARAMS.visibility_sampling_share / significance.max(1e-30);
        if self.needs_full_exchange(r, wanted_error) {
            return self.full_exchange(r.ends, counts);
        }
        // Test whether anything can occlude the pair.
        let unoccluded = unoccluded
            || visibility.is_unoccluded_scene()
            || wanted_error < REFINEMENT_PARAMS.max_visibility_error_for_shaft_test
                && visibility.is_unoccluded(a, b);
        counts.unoccluded += u64::from(unoccluded);
        // Points of the mean kernel.
        let boxes = a.fills_box && b.fills_box;
        let samples_medium = visibility.has_varying_medium()
            && significance > REFINEMENT_PARAMS.min_significance_for_sampled_medium;
        let most = REFINEMENT_PARAMS.max_kernel_points;
        let points = match zeroth_order && !boxes || samples_medium {
            true => ((most as f64 * significance).ceil() as usize).clamp(1, most),
            false => 1,
        };
        let sampling = PairSampling {
            seed: low_discrepancy::split_mix64((r.ends[0] as u64) << 32 | r.ends[1] as u64),
            visibility: VisibilitySampling {
                unoccluded,
                through_medium: samples_medium,
                choice: ZoneChoice::HalfUniform,
                bounded_kernel: true,
            },
            points,
        };
        // Split where the visibility varies too much over the pair.
        if self.varies_in_visibility(r, &sampling, counts) {
            counts.split_by_visibility += 1;
            return PairOutcome::Split { end: end_to_split(a, b, &r.pair), unoccluded: false };
        }
        let (mut kernel, visibility) = self.sample_link(r, &sampling, counts);
        counts.rays += visibility.rays as u64;
        // Multiply by the visible fraction; a negative kernel marks a link of zeroth order.
        let mut visibility_error = 0.0f64;
        let sign = if zeroth_order { -1.0 } else { 1.0 };
        for &band in self.pairs.first_bands {
            let relative =
                if r.are_zones { visibility.error } else { visibility.error.max(visibility.deviation) };
            visibility_error = visibility_error.max(kernel[band] * relative);
            kernel[band] *= sign * visibility.visible_fraction[band];
        }
        PairOutcome::Link { kernel, visibility_error }
    }

    /// True where pilot rays find that the visibility, or the attenuation, varies over a pair of clusters beyond its tolerance.
    fn varies_in_visibility(
        &self,
        r: &LinkRequest,
        sampling: &PairSampling,
        counts: &mut RefinementCounts,
    ) -> bool {
        let v = sampling.visibility;
        if r.are_zones
            || r.significance <= REFINEMENT_PARAMS.min_significance_for_visibility_split
            || v.unoccluded && !v.through_medium
        {
            return false;
        }
        let [a, b] = self.pairs.nodes_of(r.ends);
        let rays =
            (r.significance.ceil() as usize).clamp(sampling.points, REFINEMENT_PARAMS.max_rays_per_link);
        let seed = low_discrepancy::split_mix64(sampling.seed);
        let pilot = self.pairs.visibility.sample(a, b, seed, rays, v);
        counts.rays += pilot.rays as u64;
        pilot.deviation * r.significance > REFINEMENT_PARAMS.visibility_variation_share
    }

    /// The mean kernel of an accepted pair without occlusion, and its visibility.
    fn sample_link(
        &self,
        r: &LinkRequest,
        sampling: &PairSampling,
        counts: &mut RefinementCounts,
    ) -> (GroupKernel, VisibilityEstimate) {
        let [a, b] = self.pairs.nodes_of(r.ends);
        let (points, seed, zeroth_order) = (sampling.points, sampling.seed, r.pair.zeroth_order);
        let mut v = VisibilitySampling { choice: ZoneChoice::ByMeasure, ..sampling.visibility };
        let (unoccluded, samples_medium) = (v.unoccluded, v.through_medium);
        let boxes = a.fills_box && b.fills_box;
        let has_pane = has_pane(a, b);
        let rays = rays_of_link(r).max(points);
        let mut kernel = r.pair.kernel;
        // Few rays: the mean of kernel times visibility. The mean kernel times the fraction that they see would be too low.
        let few = !unoccluded && rays < REFINEMENT_PARAMS.min_rays_for_visible_fraction;
        let significant_zones = r.are_zones && r.significance > 1.0;
        if !has_pane && (zeroth_order && !boxes && !significant_zones || few) {
            let rays = if unoccluded { points } else { rays };
            v = VisibilitySampling { through_medium: true, bounded_kernel: false, ..v };
            let visibility = match zeroth_order {
                true => self.pairs.visibility.sample_near_field(a, b, seed, rays, v),
                false => self.pairs.visibility.sample(a, b, seed, rays, v),
            };
            for &band in self.pairs.first_bands {
                kernel[band] = visibility.mean_kernel * visibility.transmittance[band];
            }
            return (kernel, visibility);
        }
        // Many rays: the visible fraction, for a mean kernel that is known more accurately.
        let mut visibility = VisibilityEstimate::UNOCCLUDED;
        if !unoccluded || samples_medium || zeroth_order && !boxes {
            let rays = if unoccluded { points } else { rays };
            visibility = self.pairs.visibility.sample(a, b, seed, rays, v);
        }
        counts.near_factors += self.pairs.improve_mean(r, samples_medium.then_some(&visibility), &mut kernel);
        if zeroth_order && has_pane {
            let factors =
                [a, b].map(|n| self.pairs.pane_absorptance_factor(n, REFINEMENT_PARAMS.mean_pane_cosine));
            let transmittance = self.pairs.centre_transmittance(a, b);
            for &band in self.pairs.first_bands {
                kernel[band] =
                    visibility.mean_kernel * transmittance[band] * factors[0][band] * factors[1][band];
            }
        }
        (kernel, visibility)
    }
}

fn largest(kernel: &GroupKernel) -> f64 {
    kernel.iter().fold(0.0f64, |m, k| m.max(*k))
}

fn has_pane(a: &ClusterNode, b: &ClusterNode) -> bool {
    a.kind == ClusterKind::Pane || b.kind == ClusterKind::Pane
}

/// Rays of a link: enough for √(v(1 − v)/m) where a pair of zones may be partly visible; for a pair of clusters that was found to agree, the
/// number that would have shown otherwise.
fn rays_of_link(r: &LinkRequest) -> usize {
    let most = REFINEMENT_PARAMS.max_rays_per_link;
    let w = (r.significance / REFINEMENT_PARAMS.visibility_sampling_share).min(most as f64);
    let m = if r.are_zones { w.max(REFINEMENT_PARAMS.typical_visibility_variance * w * w) } else { w };
    (m.ceil() as usize).clamp(1, most)
}

/// The end to split: the one over which the kernel varies more, or the larger where that is not decisive.
fn end_to_split(a: &ClusterNode, b: &ClusterNode, pair: &PairKernel) -> usize {
    if a.is_leaf() {
        return 1;
    }
    if b.is_leaf() {
        return 0;
    }
    if a.kind == ClusterKind::Mixed {
        return 0;
    }
    if b.kind == ClusterKind::Mixed {
        return 1;
    }
    if a.kind == ClusterKind::Pane || b.kind == ClusterKind::Pane {
        return (a.kind != ClusterKind::Pane) as usize;
    }
    let (ra, rb) = (a.radius(), b.radius());
    if pair.zeroth_order || ra > 2.0 * rb || rb > 2.0 * ra {
        return (rb > ra) as usize;
    }
    (pair.variation[1] > pair.variation[0]) as usize
}
