//! Links between clusters and their application to a vector of strengths (upward, across and downward passes, as in tree codes).
//!
//! A link joins two nodes i, j by the mean kernel k = K v τ (1 + c) of a band group. It is stored once for each direction, by receiver, so
//! every node sums its own links in a fixed order: the result does not depend on the number of threads. The number k is the same in both
//! directions, so the operator is symmetric to rounding; the gradient L of a pair is recomputed from the two centroids.
//!
//! **Upward**: moments of the strengths s of the leaves, M = Σ W s, N = Σ W s n, D = Σ W s (y − c).
//!
//! **Across**, for a link of i with j and the gradient L at t = c_j − c_i,
//!
//! ```text
//! h_i += k [ (N_j·t)/(n_j·t) + L·D_j ]      the first as J_i += k (N_j·t)/(n_j·t) · t/(n_i·t) where i is a patch cluster
//! ∇h_i −= k M_j L
//! ```
//!
//! The vector irradiance J is passed down, not the scalar, so each patch of a curved cluster has its own cosine.
//!
//! **Downward**: H_p = Σ over p and all nodes above it of h + J·n_p + ∇h·(x_p − c). The incident power is W_p H_p.
//!
//! One application costs O(number of links + number of nodes).

use super::kernel::{CompactNode, PairGeometry};
use super::tree::{ClusterKind, ClusterTree};
use rayon::prelude::*;
use std::ops::Range;
use zonal_math::Vec3;
use zonal_scene::{Band, Bands, PerBand};

/// Nodes of one task, at least.
const MIN_NODES_PER_TASK: usize = 64;

/// Pairs of nodes in the order in which the refinement finds them.
#[derive(Clone, Debug, Default)]
pub(crate) struct LinkPairs {
    /// i ≤ j by index in the tree.
    pub ends: Vec<[u32; 2]>,
    /// Mean kernels of every band group of each pair, 1/m²; negative for a pair of zeroth order whatever its geometry.
    pub kernel: Vec<f32>,
    /// Absolute error of the largest of them by sampled visibility.
    pub visibility_error: Vec<f32>,
}

impl LinkPairs {
    /// Moves the pairs of `o` behind these.
    pub(crate) fn append(&mut self, o: &mut LinkPairs) {
        self.ends.append(&mut o.ends);
        self.kernel.append(&mut o.kernel);
        self.visibility_error.append(&mut o.visibility_error);
    }
}

/// Links by receiver, in compressed rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Links {
    /// The links of node n are `first[n]..first[n + 1]`.
    pub first: Vec<u32>,
    /// Sending node.
    pub source: Vec<u32>,
    /// Mean kernels of every band group of each link, 1/m²; negative for a link of zeroth order.
    pub kernel: Vec<f32>,
    /// Absolute error of the largest by sampled visibility, 1/m².
    pub visibility_error: Vec<f32>,
    /// Number of band groups.
    pub group_count: usize,
}

impl Links {
    /// Sorts pairs by receiver.
    pub(crate) fn new(nodes: usize, pairs: &LinkPairs, group_count: usize) -> Links {
        // Count the links of every node.
        let mut first = vec![0u32; nodes + 1];
        for [i, j] in &pairs.ends {
            first[*i as usize + 1] += 1;
            if i != j {
                first[*j as usize + 1] += 1;
            }
        }
        for n in 0..nodes {
            first[n + 1] += first[n];
        }
        // Store each pair in both directions.
        let total = first[nodes] as usize;
        let mut at = first.clone();
        let mut links = Links {
            first,
            source: vec![0; total],
            kernel: vec![0.0; total * group_count],
            visibility_error: vec![0.0; total],
            group_count,
        };
        for (k, [i, j]) in pairs.ends.iter().enumerate() {
            let mut store = |to: u32, from: u32| {
                let slot = at[to as usize] as usize;
                at[to as usize] += 1;
                links.source[slot] = from;
                links.visibility_error[slot] = pairs.visibility_error[k];
                for g in 0..group_count {
                    links.kernel[slot * group_count + g] = pairs.kernel[k * group_count + g];
                }
            };
            store(*i, *j);
            if i != j {
                store(*j, *i);
            }
        }
        links
    }
    /// Number of directed links.
    pub(crate) fn len(&self) -> usize {
        self.source.len()
    }
    /// Links of a receiving node.
    #[inline]
    pub(crate) fn of(&self, node: usize) -> Range<usize> {
        self.first[node] as usize..self.first[node + 1] as usize
    }
    /// Bytes occupied.
    pub(crate) fn bytes(&self) -> u64 {
        4 * (self.first.len() + self.source.len() + self.kernel.len() + self.visibility_error.len()) as u64
    }
}

/// The exchange matrix of links over a cluster tree.
#[derive(Clone, Copy)]
pub(crate) struct LinkMatrix<'a> {
    /// The tree.
    pub tree: &'a ClusterTree,
    /// Its nodes as the kernel reads them.
    pub nodes: &'a [CompactNode],
    /// The links.
    pub links: &'a Links,
    /// Band group of each band.
    pub band_groups: PerBand<usize>,
}

/// Moments of an inner node: M, N (three), D (three).
type StrengthMoments = [Bands; 7];
/// Incident radiation at an inner node: h, J (three), ∇h (three).
type LocalExpansion = [Bands; 7];

const ZERO_MOMENTS: [Bands; 7] = [Bands::ZERO; 7];

#[inline]
fn dot(v: Vec3, m: &[Bands]) -> Bands {
    v.x * m[0] + v.y * m[1] + v.z * m[2]
}

/// The contribution of the source node of a link.
struct LinkSource<'a> {
    /// M.
    monopole: Bands,
    /// N·t/(n·t) of a curved cluster, M of any other.
    towards: Bands,
    /// D of an inner node.
    dipole: Option<&'a [Bands]>,
}

/// A matrix with the moments of one vector of strengths.
struct Application<'a> {
    matrix: LinkMatrix<'a>,
    moments: Vec<StrengthMoments>,
    strengths: &'a [Bands],
}

impl LinkMatrix<'_> {
    /// H of every zone (irradiance, fluence; W/m²) by the strengths of the zones.
    pub(crate) fn apply(&self, strengths: &[Bands]) -> Vec<Bands> {
        let tree = self.tree;
        let pass = Application { matrix: *self, moments: self.upward(strengths), strengths };
        // Across: the links of inner nodes.
        let mut local: Vec<LocalExpansion> = (0..tree.inner_nodes)
            .into_par_iter()
            .with_min_len(MIN_NODES_PER_TASK)
            .map(|i| pass.sum_links(i))
            .collect();
        self.downward(&mut local);
        // The links of leaves, with the expansion of the parent at their centroids.
        let by_leaf: Vec<Bands> = (0..tree.leaves())
            .into_par_iter()
            .with_min_len(MIN_NODES_PER_TASK)
            .map(|leaf| pass.at_leaf(leaf, &local))
            .collect();
        let mut out = vec![Bands::ZERO; tree.leaves()];
        for (leaf, v) in by_leaf.into_iter().enumerate() {
            out[tree.leaf_zones[leaf] as usize] = v;
        }
        out
    }

    /// M, N, D of the inner nodes, from the leaves up.
    fn upward(&self, strengths: &[Bands]) -> Vec<StrengthMoments> {
        let tree = self.tree;
        let mut out = vec![ZERO_MOMENTS; tree.inner_nodes];
        for n in (0..tree.inner_nodes).rev() {
            let centre = tree.nodes[n].centre();
            let mut m = ZERO_MOMENTS;
            for &k in tree.children(n as u32) {
                let child = &tree.nodes[k as usize];
                let d = child.centre() - centre;
                if child.is_leaf() {
                    let w = child.measure as f64;
                    let s = strengths[tree.zone_of(child)] * w;
                    let normal = child.normal();
                    m[0] += s;
                    for x in 0..3 {
                        m[1 + x] += normal[x] * s;
                        m[4 + x] += d[x] * s;
                    }
                } else {
                    let own = out[k as usize];
                    m[0] += own[0];
                    for x in 0..3 {
                        m[1 + x] += own[1 + x];
                        m[4 + x] += own[4 + x];
                        m[4 + x] += d[x] * own[0];
                    }
                }
            }
            out[n] = m;
        }
        out
    }

    /// Adds to every inner node the expansion of its parent.
    fn downward(&self, local: &mut [LocalExpansion]) {
        let tree = self.tree;
        for n in 0..tree.inner_nodes {
            let (centre, from) = (tree.nodes[n].centre(), local[n]);
            for &k in tree.children(n as u32) {
                if (k as usize) < tree.inner_nodes {
                    let d = tree.nodes[k as usize].centre() - centre;
                    let to = &mut local[k as usize];
                    to[0] += from[0] + d.x * from[4] + d.y * from[5] + d.z * from[6];
                    (1..7).for_each(|x| to[x] += from[x]);
                }
            }
        }
    }
}

impl Application<'_> {
    /// H of a leaf: its own links, and the expansion of its parent.
    fn at_leaf(&self, leaf: usize, local: &[LocalExpansion]) -> Bands {
        let tree = self.matrix.tree;
        let i = tree.leaf_node(leaf);
        let node = &tree.nodes[i];
        let own = self.sum_links(i)[0];
        let parent = tree.parent[i] as usize;
        if parent >= tree.inner_nodes {
            return own;
        }
        let (from, d, n) = (&local[parent], node.centre() - tree.nodes[parent].centre(), node.normal());
        let (plane, slope) = (dot(n, &from[1..4]), dot(d, &from[4..7]));
        own + from[0] + plane + slope
    }

    /// Sum over the links of node `i`.
    #[inline]
    fn sum_links(&self, i: usize) -> LocalExpansion {
        let LinkMatrix { tree, nodes, links, band_groups: group } = self.matrix;
        let mut sum = ZERO_MOMENTS;
        let (a, groups) = (&nodes[i], links.group_count);
        let is_leaf = i >= tree.inner_nodes;
        let is_curved = !is_leaf && a.kind == ClusterKind::Patch;
        for l in links.of(i) {
            let j = links.source[l] as usize;
            let k = &links.kernel[l * groups..(l + 1) * groups];
            // Two zones: the kernel alone.
            if is_leaf && j >= tree.inner_nodes {
                let b = &tree.nodes[j];
                let (s, w) = (self.strengths[tree.zone_of(b)], b.measure as f64);
                sum[0] += group.map_to_bands(|g| k[g].abs() as f64) * w * s;
                continue;
            }
            let b = &nodes[j];
            let mut geometry = PairGeometry::new(a, b);
            geometry.zeroth_order |= k.iter().any(|k| *k < 0.0);
            let source = self.source(j, &geometry);
            if geometry.zeroth_order {
                sum[0] += group.map_to_bands(|g| k[g].abs() as f64) * source.monopole;
                continue;
            }
            // The expansion about both centroids.
            let gradient = geometry.gradient(a, b, 0.5 * (a.extinction + b.extinction) as f64);
            let along = source.dipole.map_or(Bands::ZERO, |d| dot(gradient, d));
            let t = geometry.t / geometry.heights[0];
            // Band by band, which takes 10 to 20 % less time than operators on all bands.
            for band in Band::all() {
                let k = k[group[band]] as f64;
                sum[0][band] += k * along[band];
                if is_curved {
                    (0..3).for_each(|x| sum[1 + x][band] += k * source.towards[band] * t[x]);
                } else {
                    sum[0][band] += k * source.towards[band];
                }
                if !is_leaf {
                    (0..3).for_each(|x| sum[4 + x][band] -= k * source.monopole[band] * gradient[x]);
                }
            }
        }
        sum
    }

    /// Moments of node `j` towards the receiver of a link.
    #[inline]
    fn source(&self, j: usize, geometry: &PairGeometry) -> LinkSource<'_> {
        let LinkMatrix { tree, nodes, .. } = self.matrix;
        if j >= tree.inner_nodes {
            let s = self.strengths[tree.leaf_zones[j - tree.inner_nodes] as usize];
            let w = tree.nodes[j].measure as f64;
            let monopole = s * w;
            return LinkSource { monopole, towards: monopole, dipole: None };
        }
        let m = &self.moments[j];
        let is_curved = nodes[j].kind == ClusterKind::Patch && !geometry.zeroth_order;
        let towards = if is_curved { dot(-geometry.t, &m[1..4]) / geometry.heights[1] } else { m[0] };
        LinkSource { monopole: m[0], towards, dipole: Some(&m[4..7]) }
    }
}
