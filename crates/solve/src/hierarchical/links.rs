//! Links and their application.
//!
//! A link joins two nodes i, j with the mean kernel k = K v τ (1 + c) a band group. It is stored once for each direction, by receiver, so
//! that every node gathers for itself in a fixed order: the same bits for any number of threads. With the number k stored twice the
//! operator is symmetric to rounding: the gradient L of the pair is recomputed from the two centres, turned round.
//!
//! **Up**: moments of the strengths s of the leaves, M = Σ W s, N = Σ W s n, D = Σ W s (y − c).
//!
//! **Across**, for a link of i with j and the gradient L at t = c_j − c_i,
//!
//! ```text
//! h_i += k [ (N_j·t)/(n_j·t) + L·D_j ]      the first as J_i += k (N_j·t)/(n_j·t) · t/(n_i·t) where i is a patch cluster
//! ∇h_i −= k M_j L
//! ```
//!
//! so that a curved cluster has at each of its patches the cosine of that patch: the vector irradiance J is shared, not the scalar.
//!
//! **Down**: H_p = Σ over p and all above it of h + J·n_p + ∇h·(x_p − c). What arrives is W_p H_p.

use super::kernel::{Place, Spot};
use super::tree::{Kind, Tree};
use rayon::prelude::*;
use zonal_math::Vec3;
use zonal_scene::{Bands, bands};

/// Pairs as the refinement finds them.
#[derive(Clone, Debug, Default)]
pub struct Pairs {
    /// i ≤ j in the order of the tree's ids.
    pub ends: Vec<[u32; 2]>,
    /// Mean kernels, `groups` a pair, 1/m²; negative for a pair that is flat whatever its centres say.
    pub kernel: Vec<f32>,
    /// Absolute error of the largest of them by sampled visibility.
    pub doubt: Vec<f32>,
}

impl Pairs {
    /// Puts others behind these.
    pub fn append(&mut self, o: &mut Pairs) {
        self.ends.append(&mut o.ends);
        self.kernel.append(&mut o.kernel);
        self.doubt.append(&mut o.doubt);
    }
}

/// Links by receiver.
#[derive(Clone, Debug, Default)]
pub struct Links {
    /// `first[n]..first[n + 1]` are those of node n.
    pub first: Vec<u32>,
    /// The other end.
    pub other: Vec<u32>,
    /// Mean kernels, `groups` a link; negative for a flat one.
    pub kernel: Vec<f32>,
    /// Error of the largest.
    pub doubt: Vec<f32>,
    /// Band groups.
    pub groups: usize,
}

impl Links {
    /// Sorts pairs by receiver.
    pub fn new(nodes: usize, pairs: &Pairs, groups: usize) -> Links {
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
        let total = first[nodes] as usize;
        let mut at = first.clone();
        let mut links = Links {
            first,
            other: vec![0; total],
            kernel: vec![0.0; total * groups],
            doubt: vec![0.0; total],
            groups,
        };
        for (k, [i, j]) in pairs.ends.iter().enumerate() {
            let mut put = |to: u32, from: u32| {
                let slot = at[to as usize] as usize;
                at[to as usize] += 1;
                links.other[slot] = from;
                links.doubt[slot] = pairs.doubt[k];
                for g in 0..groups {
                    links.kernel[slot * groups + g] = pairs.kernel[k * groups + g];
                }
            };
            put(*i, *j);
            if i != j {
                put(*j, *i);
            }
        }
        links
    }
    /// Number of directed links.
    pub fn len(&self) -> usize {
        self.other.len()
    }
    /// True without links.
    pub fn is_empty(&self) -> bool {
        self.other.is_empty()
    }
    /// Links of a node.
    #[inline]
    pub fn of(&self, node: usize) -> std::ops::Range<usize> {
        self.first[node] as usize..self.first[node + 1] as usize
    }
    /// Bytes taken.
    pub fn bytes(&self) -> u64 {
        4 * (self.first.len() + self.other.len() + self.kernel.len() + self.doubt.len()) as u64
    }
}

/// Moments of an inner node: M, N (three), D (three).
type Moments = [Bands; 7];
/// What an inner node receives: h, J (three), ∇h (three).
type Received = [Bands; 7];

const NOTHING: [Bands; 7] = [[0.0; 3]; 7];

/// Sums over the leaves of inner nodes: M, N, D.
fn moments(tree: &Tree, strengths: &[Bands]) -> Vec<Moments> {
    let mut out = vec![NOTHING; tree.inner];
    for n in (0..tree.inner).rev() {
        let centre = tree.nodes[n].centre();
        let mut m = NOTHING;
        for &k in tree.kids(n as u32) {
            let kid = &tree.nodes[k as usize];
            let d = kid.centre() - centre;
            let add =
                |m: &mut Moments, at: usize, v: Bands, f: f64| (0..3).for_each(|b| m[at][b] += f * v[b]);
            if kid.is_leaf() {
                let w = kid.weight as f64;
                let s = strengths[tree.zone[kid.first as usize] as usize].map(|x| x * w);
                let normal = kid.normal();
                add(&mut m, 0, s, 1.0);
                for x in 0..3 {
                    add(&mut m, 1 + x, s, normal[x]);
                    add(&mut m, 4 + x, s, d[x]);
                }
            } else {
                let own = out[k as usize];
                add(&mut m, 0, own[0], 1.0);
                for x in 0..3 {
                    add(&mut m, 1 + x, own[1 + x], 1.0);
                    add(&mut m, 4 + x, own[4 + x], 1.0);
                    add(&mut m, 4 + x, own[0], d[x]);
                }
            }
        }
        out[n] = m;
    }
    out
}

fn dot(v: Vec3, m: &[Bands]) -> Bands {
    bands(|b| v.x * m[0][b] + v.y * m[1][b] + v.z * m[2][b])
}

/// What the links bring to node `i`.
#[inline]
fn gather(
    tree: &Tree,
    spots: &[Spot],
    links: &Links,
    group: [usize; 3],
    i: usize,
    own: &[Moments],
    strengths: &[Bands],
) -> Received {
    let mut got = NOTHING;
    let (a, groups) = (&spots[i], links.groups);
    let leaf_i = i >= tree.inner;
    let curved_i = !leaf_i && a.kind == Kind::Patch;
    for l in links.of(i) {
        let j = links.other[l] as usize;
        let k = &links.kernel[l * groups..(l + 1) * groups];
        if leaf_i && j >= tree.inner {
            let b = &tree.nodes[j];
            let (s, w) = (strengths[tree.zone[b.first as usize] as usize], b.weight as f64);
            (0..3).for_each(|c| got[0][c] += k[group[c]].abs() as f64 * w * s[c]);
            continue;
        }
        let b = &spots[j];
        let mut place = Place::new(a, b);
        place.flat |= k.iter().any(|k| *k < 0.0);
        let (mass, toward, dipole);
        if j >= tree.inner {
            let (s, w) = (strengths[tree.zone[j - tree.inner] as usize], tree.nodes[j].weight as f64);
            mass = s.map(|x| x * w);
            toward = mass;
            dipole = None;
        } else {
            let m = &own[j];
            mass = m[0];
            let curved = b.kind == Kind::Patch && !place.flat;
            toward = if curved { dot(-place.t, &m[1..4]).map(|x| x / place.along[1]) } else { mass };
            dipole = Some(&m[4..7]);
        }
        if place.flat {
            (0..3).for_each(|c| got[0][c] += k[group[c]].abs() as f64 * mass[c]);
            continue;
        }
        let grad = place.gradient(a, b, 0.5 * (a.kappa + b.kappa) as f64);
        let along = dipole.map_or([0.0; 3], |d| dot(grad, d));
        let t = place.t / place.along[0];
        for c in 0..3 {
            let k = k[group[c]] as f64;
            got[0][c] += k * along[c];
            if curved_i {
                (0..3).for_each(|x| got[1 + x][c] += k * toward[c] * t[x]);
            } else {
                got[0][c] += k * toward[c];
            }
            if !leaf_i {
                (0..3).for_each(|x| got[4 + x][c] -= k * mass[c] * grad[x]);
            }
        }
    }
    got
}

/// Inner nodes handled by one task.
const RUN: usize = 64;

/// H of every zone (irradiance, fluence) by its strengths, in the order of the zones.
pub fn apply(
    tree: &Tree,
    spots: &[Spot],
    links: &Links,
    group: [usize; 3],
    strengths: &[Bands],
) -> Vec<Bands> {
    let own = moments(tree, strengths);
    let mut got: Vec<Received> = (0..tree.inner)
        .into_par_iter()
        .with_min_len(RUN)
        .map(|i| gather(tree, spots, links, group, i, &own, strengths))
        .collect();
    for n in 0..tree.inner {
        let (centre, from) = (tree.nodes[n].centre(), got[n]);
        for &k in tree.kids(n as u32) {
            if (k as usize) < tree.inner {
                let d = tree.nodes[k as usize].centre() - centre;
                let to = &mut got[k as usize];
                for c in 0..3 {
                    to[0][c] += from[0][c] + d.x * from[4][c] + d.y * from[5][c] + d.z * from[6][c];
                    (1..7).for_each(|x| to[x][c] += from[x][c]);
                }
            }
        }
    }
    let by_leaf: Vec<Bands> = (0..tree.leaves())
        .into_par_iter()
        .with_min_len(RUN)
        .map(|slot| {
            let i = tree.leaf(slot);
            let node = &tree.nodes[i];
            let own_links = gather(tree, spots, links, group, i, &own, strengths)[0];
            let up = tree.parent[i] as usize;
            if up >= tree.inner {
                return own_links;
            }
            let (from, d, n) = (&got[up], node.centre() - tree.nodes[up].centre(), node.normal());
            let (plane, slope) = (dot(n, &from[1..4]), dot(d, &from[4..7]));
            bands(|c| own_links[c] + from[0][c] + plane[c] + slope[c])
        })
        .collect();
    let mut out = vec![[0.0; 3]; tree.leaves()];
    for (slot, v) in by_leaf.into_iter().enumerate() {
        out[tree.zone[slot] as usize] = v;
    }
    out
}
