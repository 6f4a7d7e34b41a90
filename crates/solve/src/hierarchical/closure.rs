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

use super::Hierarchical;
use super::tree::Tree;
use crate::columns::total;
use crate::engine::Site;
use crate::operator::Operator;
use crate::surroundings::Escape;
use zonal_exchange::pair::{strength, target};
use zonal_scene::solution::Closure;
use zonal_scene::{Bands, Zones, bands};

/// Clusters, about; an octree's steps are coarse.
const CLUSTERS: usize = 16;
/// Sweeps.
const SWEEPS: usize = 6;
/// A row of links so many times its target is held to it.
const OVERFULL: f64 = 1.5;
/// Share of the mean strength that every zone counts with at least.
const FLOOR: f64 = 0.05;

/// d of every zone for the strengths of a rough solution.
pub fn scaling(
    tree: &Tree,
    operator: &dyn Operator,
    zones: &Zones,
    escape: &Escape,
    strengths: &[Bands],
) -> Vec<Bands> {
    let n = zones.len();
    let (of, count) = tree.clusters(2 * tree.leaves().div_ceil(CLUSTERS));
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

/// Holds rows that close to more than `OVERFULL` times their target to it, symmetrically; gives their number. Links of zones that all but touch may add
/// up to several times what a zone can receive, and light between two such would never end.
pub fn hold(made: &mut Hierarchical, zones: &Zones, escape: &Escape) -> usize {
    let n = zones.len();
    let c: Vec<Bands> = (0..n).map(|i| strength(zones, i)).collect();
    let mut held = vec![[1.0f64; 3]; n];
    for _ in 0..SWEEPS {
        let rows = made.apply(&c);
        let full = |i: usize, b: usize| {
            let (t, away) = (target(zones, i), escape.sky[i][b] + escape.backs[i][b]);
            if rows[i][b] + away > OVERFULL * t { ((t - away).max(0.0) / rows[i][b]).sqrt() } else { 1.0 }
        };
        let d: Vec<Bands> = (0..n).map(|i| bands(|b| full(i, b))).collect();
        if d.iter().all(|d| *d == [1.0; 3]) {
            break;
        }
        held.iter_mut().zip(&d).for_each(|(h, d)| *h = bands(|b| h[b] * d[b]));
        made.scale(&d);
    }
    held.iter().filter(|h| **h != [1.0; 3]).count()
}

/// Closure restored by clusters: what was measured before, with the change.
pub fn restore(
    made: &mut Hierarchical,
    site: &Site,
    escape: &mut Escape,
    (mut report, defects): (Closure, Vec<Bands>),
) -> (Closure, Vec<Bands>) {
    let sum = total(made.len(), made.known.iter().map(|k| &k.0));
    let d = scaling(&made.tree, made, site.zones, escape, &sum);
    for d in &d {
        report.largest_change = bands(|b| report.largest_change[b].max((d[b] * d[b] - 1.0).abs()));
    }
    escape.scale(&d);
    made.scale(&d);
    report.after = crate::closure::measure(made, site.zones, escape).0.worst;
    report.restored = true;
    (report, defects)
}
