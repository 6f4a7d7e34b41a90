//! Closure restored by clusters.
//!
//! Links fitted to the light are coarse where no power flows, so the row sums of dark zones are off by much, and scaling each zone to its
//! target would multiply the accurate links from bright zones by that. Scaled are clusters instead: d is one number for each of a few
//! dozen clusters C, found so that
//!
//! ```text
//! Σ_{p∈C} x_p d_C (Σ_q g_pq c_q d_q + g_p,sky + g_p,backs) = Σ_{p∈C} x_p t_p
//! ```
//!
//! with the strengths x of a rough solution as weights: the power that the cluster sends is then neither made nor lost.

use super::tree::Tree;
use crate::operator::Operator;
use crate::surroundings::Escape;
use zonal_exchange::pair::{strength, target};
use zonal_scene::{Bands, Zones, bands};

/// Clusters, about; an octree's steps are coarse.
const CLUSTERS: usize = 16;
/// Sweeps.
const SWEEPS: usize = 6;
/// Share of the mean strength that every zone counts with at least.
const FLOOR: f64 = 0.05;

/// The cluster of every zone: the largest nodes with no more than a share of the leaves.
fn clusters(tree: &Tree) -> (Vec<u32>, usize) {
    let most = 2 * tree.leaves().div_ceil(CLUSTERS);
    let mut of = vec![0; tree.leaves()];
    let (mut count, mut stack) = (0, vec![tree.root()]);
    while let Some(n) = stack.pop() {
        let node = &tree.nodes[n as usize];
        if node.is_leaf() || node.leaves() <= most {
            (node.first..node.last).for_each(|slot| of[tree.zone[slot as usize] as usize] = count);
            count += 1;
        } else {
            stack.extend(tree.kids(n).iter().rev());
        }
    }
    (of, count as usize)
}

/// d of every zone for the strengths of a rough solution.
pub fn scaling(
    tree: &Tree,
    operator: &dyn Operator,
    zones: &Zones,
    escape: &Escape,
    strengths: &[Bands],
) -> Vec<Bands> {
    let n = zones.len();
    let (of, count) = clusters(tree);
    let c: Vec<Bands> = (0..n).map(|i| strength(zones, i)).collect();
    let mean = strengths
        .iter()
        .zip(&c)
        .fold([[0.0; 3]; 2], |s, (x, c)| [bands(|b| s[0][b] + x[b]), bands(|b| s[1][b] + c[b])]);
    let weight: Vec<Bands> = (0..n)
        .map(|i| {
            bands(|b| {
                strengths[i][b]
                    + FLOOR * c[i][b] * if mean[1][b] > 0.0 { mean[0][b] / mean[1][b] } else { 0.0 }
            })
        })
        .collect();
    let mut d = vec![[1.0f64; 3]; count];
    for _ in 0..SWEEPS {
        let scaled: Vec<Bands> = (0..n).map(|i| bands(|b| c[i][b] * d[of[i] as usize][b])).collect();
        let rows = operator.apply(&scaled);
        let mut sums = vec![[[0.0; 3]; 2]; count];
        for i in 0..n {
            let (t, s) = (target(zones, i), &mut sums[of[i] as usize]);
            for b in 0..3 {
                s[0][b] += weight[i][b] * (rows[i][b] + escape.sky[i][b] + escape.backs[i][b]);
                s[1][b] += weight[i][b] * t;
            }
        }
        for (d, s) in d.iter_mut().zip(&sums) {
            for b in 0..3 {
                let row = d[b] * s[0][b];
                if row > 1e-6 * s[1][b] {
                    d[b] *= (s[1][b] / row).sqrt();
                }
            }
        }
    }
    (0..n).map(|i| d[of[i] as usize]).collect()
}
