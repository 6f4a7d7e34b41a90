//! The error that the links leave in a solution, for every zone.
//!
//! Each link has at its receiver an error of its expansion, e as in [`super::refinement`] with the strengths of the solution, and one of its
//! sampled visibility, d = (error of k) · M. Errors of expansions have either sign and are partly correlated: a zone with errors e_k of its
//! own links and of all those above it is assigned √(Σe · √Σe²), the geometric mean of the sum and of the root of the squares. Errors of
//! visibility are treated likewise, d in place of e, and weighted by [`LinkErrorParams::visibility_weight`], as one occluder hides a zone
//! from many.
//!
//! Pairs of two zones are independent: the points and rays of each are its own, their number is fixed beforehand, and no zone represents
//! others. Their errors add up as squares, except for a share [`LinkErrorParams::correlated_share`] of them, because the radiation that they
//! transport arrived by other links and carries the errors of those.

use super::kernel::{PairGeometry, SecondOrderTerms};
use super::links::LinkMatrix;
use super::refinement_params::REFINEMENT_PARAMS;
use super::tree::{ClusterKind, ClusterNode, ClusterTree};
use rayon::prelude::*;
use zonal_scene::Bands;

/// Weights and correlations of the errors of links.
struct LinkErrorParams {
    /// Weight of the joint error of visibility.
    visibility_weight: f64,
    /// Share of the errors of pairs of zones that is common to all of them.
    correlated_share: f64,
    /// Relative error of a pair of zones beyond the radius of its factor.
    zone_pair_error: f64,
    /// The same where one of them is a cut voxel, whose factor is sampled.
    cut_voxel_error: f64,
}

const LINK_ERROR_PARAMS: LinkErrorParams = LinkErrorParams {
    visibility_weight: 1.5,
    correlated_share: 0.05,
    zone_pair_error: 1e-3,
    cut_voxel_error: 0.03,
};

/// Nodes of one task, at least.
const MIN_NODES_PER_TASK: usize = 64;

/// Σe, Σe², Σd, Σd² of links with clusters, Σ (e² + (weight d)²) and Σ (e + d) of those between two zones, a band.
type ErrorSums = [Bands; 6];

/// Σ W s and W σ of every node.
fn powers(tree: &ClusterTree, strengths: &[Bands]) -> Vec<[Bands; 2]> {
    let mut sums = vec![[Bands::ZERO; 2]; tree.nodes.len()];
    for n in (0..tree.nodes.len()).rev() {
        let node = &tree.nodes[n];
        if node.is_leaf() {
            let (w, s) = (node.measure as f64, strengths[tree.zone_of(node)]);
            sums[n] = [w * s, w * s * s];
        } else {
            let mut t = [Bands::ZERO; 2];
            for &k in tree.children(n as u32) {
                let x = sums[k as usize];
                (0..2).for_each(|m| t[m] += x[m]);
            }
            sums[n] = t;
        }
    }
    for (n, s) in sums.iter_mut().enumerate() {
        let w = tree.nodes[n].measure as f64;
        let variance = s[1] / w - (s[0] / w).map(|mean| mean.powi(2));
        s[1] = w * variance.map(|v| v.max(0.0).sqrt());
    }
    sums
}

/// Relative errors of the link of node `i` from node `j`: of the incident radiation, and of the variation of the source.
fn relative_errors(matrix: &LinkMatrix, i: usize, j: usize) -> (f64, f64) {
    let (a, b) = (&matrix.tree.nodes[i], &matrix.tree.nodes[j]);
    if a.is_leaf() && b.is_leaf() {
        let cut = |n: &ClusterNode| n.kind == ClusterKind::Voxel && !n.fills_box;
        let error = if cut(a) || cut(b) {
            LINK_ERROR_PARAMS.cut_voxel_error
        } else {
            LINK_ERROR_PARAMS.zone_pair_error
        };
        return (error, 0.0);
    }
    let (compact_a, compact_b) = (&matrix.nodes[i], &matrix.nodes[j]);
    let geometry = PairGeometry::new(compact_a, compact_b);
    if geometry.zeroth_order {
        return (1.5 * REFINEMENT_PARAMS.zeroth_order_error, REFINEMENT_PARAMS.zeroth_order_error);
    }
    let kappa = 0.5 * (compact_a.extinction + compact_b.extinction) as f64;
    let l = geometry.gradient(compact_a, compact_b, kappa);
    let terms = SecondOrderTerms::new(&geometry, a, b, l, kappa);
    let bias = if a.fills_box && b.fills_box { 0.0 } else { terms.correction * terms.correction };
    let [qi, qj] = terms.variation;
    let own = if a.is_leaf() { 0.0 } else { qi };
    let far = if b.is_leaf() { 0.0 } else { 0.5 * qj * qj.sqrt() };
    (own + far + bias, if b.is_leaf() { 0.0 } else { REFINEMENT_PARAMS.source_variation_share * qj })
}

/// Sums over the links of node `i`; `power` as [`powers`] returns it.
fn sum_errors(matrix: &LinkMatrix, power: &[[Bands; 2]], i: usize) -> ErrorSums {
    let (tree, links) = (matrix.tree, matrix.links);
    let mut s: ErrorSums = [Bands::ZERO; 6];
    for l in links.of(i) {
        let j = links.source[l] as usize;
        let are_zones = tree.nodes[i].is_leaf() && tree.nodes[j].is_leaf();
        let (relative, varied) = relative_errors(matrix, i, j);
        let k = matrix.band_groups.map_to_bands(|g| links.kernel[l * links.group_count + g].abs() as f64);
        let [sent, deviation] = power[j];
        let e = k * (sent.abs() * relative + deviation * varied);
        let d = links.visibility_error[l] as f64 * sent.abs();
        if are_zones {
            s[4] += e * e + (LINK_ERROR_PARAMS.visibility_weight * d).map(|d| d.powi(2));
            s[5] += e + d;
            continue;
        }
        s[0] += e;
        s[1] += e * e;
        s[2] += d;
        s[3] += d * d;
    }
    s
}

/// Estimated error of H and G of every zone with these strengths, W/m².
pub(crate) fn estimate_errors(matrix: &LinkMatrix, strengths: &[Bands]) -> Vec<Bands> {
    let tree = matrix.tree;
    let power = powers(tree, strengths);
    let mut sums: Vec<ErrorSums> = (0..tree.nodes.len())
        .into_par_iter()
        .with_min_len(MIN_NODES_PER_TASK)
        .map(|i| sum_errors(matrix, &power, i))
        .collect();
    // Add the sums of all nodes above a leaf, and combine.
    let mut out = vec![Bands::ZERO; tree.leaves()];
    for n in 0..tree.nodes.len() {
        let parent = tree.parent[n] as usize;
        if parent != n {
            let from = sums[parent];
            (0..6).for_each(|m| sums[n][m] += from[m]);
        }
        if tree.nodes[n].is_leaf() {
            let s = &sums[n];
            let joint = |m: usize| (s[m] * s[m + 1].sqrt()).sqrt();
            let of_zones = s[4].sqrt().hypot(LINK_ERROR_PARAMS.correlated_share * s[5]);
            out[tree.zone_of(&tree.nodes[n])] =
                joint(0).hypot(LINK_ERROR_PARAMS.visibility_weight * joint(2)).hypot(of_zones);
        }
    }
    out
}
