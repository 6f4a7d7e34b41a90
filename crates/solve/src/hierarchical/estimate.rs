//! What the links leave open in the result, a zone.
//!
//! Each link brings to its receiver an error of its expansion, e as in [`super::refine`] with the strengths of the solution itself, and
//! one of its sampled visibility, d = (error of k) · M. Errors of expansions have either sign from link to link and are alike in some:
//! a zone with errors e_k from its own links and all those above it is taken to have √(Σe · √Σe²), between the sum and the root of the
//! squares. Those of visibility behave likewise, d in place of e, and count by `DOUBT`, as one blocker hides a zone from many.
//!
//! Pairs of two zones have nothing in common: points and rays of each are its own, their number is fixed beforehand, and no zone stands
//! for others. Their errors are independent and add up as squares, but for a share `ALIKE` of them: what they bring is light that came
//! by other links, with the errors of those.

use super::kernel::{Curve, Place, Spot};
use super::links::Links;
use super::refine::{FLAT, VARIED};
use super::tree::{Kind, Node, Tree};
use rayon::prelude::*;
use zonal_scene::{Bands, bands};

/// How much the joint error of visibility counts.
const DOUBT: f64 = 1.5;
/// Share of the errors of pairs of zones that is alike in all of them.
const ALIKE: f64 = 0.05;
/// Relative error of a pair of zones beyond what its factor tells.
const EXACT: f64 = 1e-3;
/// The same with parts of voxels.
const SAMPLED: f64 = 0.03;

/// Σe, Σe², Σd, Σd² of links with clusters, Σ (e² + (`DOUBT` d)²) and Σ (e + d) of those of two zones, a band.
type Sums = [Bands; 6];

/// Σ W s and W σ of every node.
fn powers(tree: &Tree, strengths: &[Bands]) -> Vec<[Bands; 2]> {
    let mut sums = vec![[[0.0; 3]; 2]; tree.nodes.len()];
    for n in (0..tree.nodes.len()).rev() {
        let node = &tree.nodes[n];
        if node.is_leaf() {
            let (w, s) = (node.weight as f64, strengths[tree.zone[node.first as usize] as usize]);
            sums[n] = [s.map(|s| w * s), s.map(|s| w * s * s)];
        } else {
            let mut t = [[0.0; 3]; 2];
            for &k in tree.kids(n as u32) {
                let x = sums[k as usize];
                (0..2).for_each(|m| t[m] = bands(|b| t[m][b] + x[m][b]));
            }
            sums[n] = t;
        }
    }
    for (n, s) in sums.iter_mut().enumerate() {
        let w = tree.nodes[n].weight as f64;
        s[1] = bands(|b| w * (s[1][b] / w - (s[0][b] / w).powi(2)).max(0.0).sqrt());
    }
    sums
}

/// Relative errors of a link at the receiver: of what arrives, and of what the source's variation adds.
fn open(a: &Node, b: &Node, sa: &Spot, sb: &Spot) -> (f64, f64) {
    if a.is_leaf() && b.is_leaf() {
        let cut = |n: &Node| n.kind == Kind::Voxel && !n.full;
        return (if cut(a) || cut(b) { SAMPLED } else { EXACT }, 0.0);
    }
    let place = Place::new(sa, sb);
    if place.flat {
        return (1.5 * FLAT, FLAT);
    }
    let kappa = 0.5 * (sa.kappa + sb.kappa) as f64;
    let l = place.gradient(sa, sb, kappa);
    let curve = Curve::new(&place, a, b, l, kappa);
    let bias = if a.full && b.full { 0.0 } else { curve.curvature * curve.curvature };
    let [qi, qj] = curve.q;
    let own = if a.is_leaf() { 0.0 } else { qi };
    let far = if b.is_leaf() { 0.0 } else { 0.5 * qj * qj.sqrt() };
    (own + far + bias, if b.is_leaf() { 0.0 } else { VARIED * qj })
}

/// Estimated error of H and G of every zone with these strengths, by zone.
pub fn errors(
    tree: &Tree,
    spots: &[Spot],
    links: &Links,
    group: [usize; 3],
    strengths: &[Bands],
) -> Vec<Bands> {
    let power = powers(tree, strengths);
    let mut sums: Vec<Sums> = (0..tree.nodes.len())
        .into_par_iter()
        .with_min_len(64)
        .map(|i| {
            let mut s: Sums = [[0.0; 3]; 6];
            for l in links.of(i) {
                let j = links.other[l] as usize;
                let zones = tree.nodes[i].is_leaf() && tree.nodes[j].is_leaf();
                let (relative, varied) = open(&tree.nodes[i], &tree.nodes[j], &spots[i], &spots[j]);
                for b in 0..3 {
                    let k = links.kernel[l * links.groups + group[b]].abs() as f64;
                    let e = k * (power[j][0][b].abs() * relative + power[j][1][b] * varied);
                    let d = links.doubt[l] as f64 * power[j][0][b].abs();
                    if zones {
                        s[4][b] += e * e + (DOUBT * d).powi(2);
                        s[5][b] += e + d;
                        continue;
                    }
                    s[0][b] += e;
                    s[1][b] += e * e;
                    s[2][b] += d;
                    s[3][b] += d * d;
                }
            }
            s
        })
        .collect();
    let mut out = vec![[0.0; 3]; tree.leaves()];
    for n in 0..tree.nodes.len() {
        let up = tree.parent[n] as usize;
        if up != n {
            let from = sums[up];
            (0..6).for_each(|m| sums[n][m] = bands(|b| sums[n][m][b] + from[m][b]));
        }
        if tree.nodes[n].is_leaf() {
            let s = &sums[n];
            let joint = |m: usize, b: usize| (s[m][b] * s[m + 1][b].sqrt()).sqrt();
            let single = |b: usize| s[4][b].sqrt().hypot(ALIKE * s[5][b]);
            out[tree.zone[tree.nodes[n].first as usize] as usize] =
                bands(|b| joint(0, b).hypot(DOUBT * joint(2, b)).hypot(single(b)));
        }
    }
    out
}
