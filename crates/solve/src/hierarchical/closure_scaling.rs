//! Closure of the links, restored cluster by cluster.
//!
//! Links refined for a solution are coarse where little power flows. The row sums of dark zones then have large errors, and scaling each
//! zone to its target would multiply accurate links from bright zones by these. Therefore clusters are scaled: one number d for each of a few
//! dozen clusters C, with
//!
//! ```text
//! Σ_{p∈C} x_p d_C (Σ_q g_pq c_q d_q + g_p,sky + g_p,backs) = Σ_{p∈C} x_p t_p
//! ```
//!
//! and the strengths x of an approximate solution as weights, so that the power sent by the cluster is conserved. Method: the damped
//! Sinkhorn–Knopp iteration d ← d √(target/row). Cost: one product an iteration.

use super::hierarchical_operator::HierarchicalOperator;
use crate::cluster::tree::ClusterTree;
use crate::operator::ExchangeOperator;
use crate::report::closure::{RowClosure, measure};
use crate::solve_context::SolveContext;
use crate::surroundings::SurroundingsExchange;
use zonal_exchange::pair::{closure_target, scaled_radiosity_coefficient};
use zonal_scene::{Band, Bands, Zones};

/// Approximate number of clusters; the levels of an octree are coarse.
const APPROXIMATE_CLUSTER_COUNT: usize = 16;
/// Iterations of a scaling.
const SCALING_ITERATIONS: usize = 6;
/// Row sum over its target above which a row is limited.
const MAX_ROW_OVER_TARGET: f64 = 1.5;
/// Weight of a zone without strength, over the mean strength.
const STRENGTH_FLOOR: f64 = 0.05;
/// Row sum over its target below which a cluster has no exchange and is left unchanged.
const EMPTY_ROW: f64 = 1e-6;

fn coefficients(zones: &Zones) -> Vec<Bands> {
    (0..zones.len()).map(|i| scaled_radiosity_coefficient(zones, i)).collect()
}

/// Weights x of the zones: their strengths, and a uniform floor; `c` are the coefficients of the zones.
fn strength_weights(strengths: &[Bands], c: &[Bands]) -> Vec<Bands> {
    let [strength, coefficient] =
        strengths.iter().zip(c).fold([Bands::ZERO; 2], |s, (x, c)| [s[0] + x, s[1] + c]);
    let mean = strength.zip_map(coefficient, |s, c| if c > 0.0 { s / c } else { 0.0 });
    strengths.iter().zip(c).map(|(x, c)| x + STRENGTH_FLOOR * c * mean).collect()
}

/// d of every zone for the strengths of an approximate solution.
fn cluster_scaling(
    tree: &ClusterTree,
    operator: &dyn ExchangeOperator,
    zones: &Zones,
    surroundings: &SurroundingsExchange,
    strengths: &[Bands],
) -> Vec<Bands> {
    let n = zones.len();
    let (part, count) = tree.partition(2 * tree.leaves().div_ceil(APPROXIMATE_CLUSTER_COUNT));
    let c = coefficients(zones);
    let weight = strength_weights(strengths, &c);
    let mut d = vec![Bands::ONE; count];
    for _ in 0..SCALING_ITERATIONS {
        // Weighted row sums and targets of every cluster.
        let scaled: Vec<Bands> = (0..n).map(|i| c[i] * d[part[i] as usize]).collect();
        let rows = operator.apply(&scaled);
        let mut sums = vec![[Bands::ZERO; 2]; count];
        for i in 0..n {
            let (t, s) = (closure_target(zones, i), &mut sums[part[i] as usize]);
            let row = rows[i] + surroundings.sky[i] + surroundings.backfaces[i];
            s[0] += weight[i] * row;
            s[1] += weight[i] * t;
        }
        for (d, s) in d.iter_mut().zip(&sums) {
            for b in Band::all() {
                let row = d[b] * s[0][b];
                if row > EMPTY_ROW * s[1][b] {
                    d[b] *= (s[1][b] / row).sqrt();
                }
            }
        }
    }
    (0..n).map(|i| d[part[i] as usize]).collect()
}

/// Scales rows above [`MAX_ROW_OVER_TARGET`] times their target down to it, symmetrically, and returns their number. The links of zones that
/// nearly touch may add up to several times the target, and the iteration between two such zones would diverge.
pub(crate) fn limit_rows(
    operator: &mut HierarchicalOperator,
    zones: &Zones,
    surroundings: &SurroundingsExchange,
) -> usize {
    let n = zones.len();
    let c = coefficients(zones);
    let mut scaling = vec![Bands::ONE; n];
    for _ in 0..SCALING_ITERATIONS {
        let rows = operator.apply(&c);
        let factor = |i: usize, b: Band| {
            let (t, away) = (closure_target(zones, i), surroundings.sky[i][b] + surroundings.backfaces[i][b]);
            if rows[i][b] + away > MAX_ROW_OVER_TARGET * t {
                ((t - away).max(0.0) / rows[i][b]).sqrt()
            } else {
                1.0
            }
        };
        let d: Vec<Bands> = (0..n).map(|i| Bands::from_fn(|b| factor(i, b))).collect();
        if d.iter().all(|d| *d == Bands::ONE) {
            break;
        }
        scaling.iter_mut().zip(&d).for_each(|(h, d)| *h *= d);
        operator.scale(&d);
    }
    scaling.iter().filter(|h| **h != Bands::ONE).count()
}

/// Restores closure by clusters; `measured` is the closure before, to which the largest change is added.
pub(crate) fn restore_by_clusters(
    operator: &mut HierarchicalOperator,
    context: &SolveContext,
    surroundings: &mut SurroundingsExchange,
    mut measured: RowClosure,
) -> RowClosure {
    let sum = operator.approximate_strengths();
    let d = cluster_scaling(operator.tree(), operator, context.zones, surroundings, &sum);
    let summary = &mut measured.summary;
    for d in &d {
        summary.largest_change = summary.largest_change.max((d * d - 1.0).abs());
    }
    surroundings.scale(&d);
    operator.scale(&d);
    summary.residual_defect = measure(operator, context.zones, surroundings).summary.worst;
    summary.restored = true;
    measured
}
