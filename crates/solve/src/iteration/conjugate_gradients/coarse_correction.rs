//! The correction of a direction by the equations on blocks of zones ([`crate::iteration::coarse_system`]).

use super::band_entry::{BandEntry, first_lanes, per_band};
use super::column::{CgColumn, ColumnVectors, Metric};
use crate::distribution::sum_order::SumOrder;
use crate::iteration::coarse_system::CoarseSystem;
use zonal_math::parallel;
use zonal_scene::SolveStatus;

/// Residual of the coarse equations over that at their start: M⁻¹ is nearly one matrix in all iterations.
const COARSE_RESIDUAL: f64 = 1e-4;
/// Iterations of the coarse equations, at most; bands that need more have no correction.
const MAX_COARSE_ITERATIONS: usize = 100;

/// M⁻¹ r − r = Φ c, c = ((I − ΦᵀKΦ)⁻¹ − I) Φᵀ r.
pub(super) struct Correction<const N: usize> {
    /// c.
    values: Vec<[f64; N]>,
    /// ⟨r, Φ c⟩.
    pub(super) product: [f64; N],
    /// False for a band whose coarse equations have no solution: its direction begins anew.
    pub(super) holds: [bool; N],
}

impl<const N: usize> Correction<N> {
    /// Adds Φ c to p.
    pub(super) fn add_to<E: BandEntry<N>>(self, metric: &Metric<E>, coarse: &CoarseSystem, p: &mut [E]) {
        coarse.prolong(self.values, p, |i, p, c| {
            let (root, old) = (metric.root[i].lanes(), p.lanes());
            *p = E::per_lane(|b| old[b] + root[b] * c[b]);
        });
    }
}

/// The correction for a residual r in the bands that are `open`; `None` without coarse equations.
pub(super) fn find<E: BandEntry<N>, const N: usize>(
    metric: &Metric<E>,
    r: &[E],
    open: [bool; N],
) -> Option<Correction<N>> {
    let coarse = metric.coarse?;
    let right = coarse.restrict(|i| {
        let (root, r) = (metric.root[i].lanes(), r[i].lanes());
        per_band(|b| if open[b] { root[b] * r[b] } else { 0.0 })
    });
    let system = coarse.system();
    let root: Vec<E> = parallel::map(&system.weights, |w| E::from_lanes(first_lanes(w.sqrt())));
    let own = Metric { root: &root, targets: system.targets, sums: SumOrder::plain(), coarse: None };
    let column = solve(&own, &right, |s| E::replace(system.operator, s));
    let holds = column.status.map(|s| s == Some(SolveStatus::Converged));
    // y_C = √w P − r + Φᵀ r, since P is zero at the start.
    let of_block = |c: usize| -> [f64; N] {
        let all = column.solution(root[c].lanes(), c);
        per_band(|b| if holds[b] { all[b] } else { 0.0 })
    };
    let values: Vec<[f64; N]> = parallel::collect(right.len(), of_block);
    let product = own.sums.sum(right.len(), |c| per_band(|b| right[c][b] * values[c][b]));
    Some(Correction { values, product, holds })
}

/// Solves (I − √w g √w) y = b, with P = 0 at the start.
fn solve<E: BandEntry<N>, const N: usize>(
    metric: &Metric<E>,
    right: &[[f64; N]],
    replace: impl Fn(&mut Vec<Vec<E>>),
) -> CgColumn<E, N> {
    let n = right.len();
    let mut vectors = ColumnVectors(vec![[E::ZERO; 3]; n]);
    let [_, r, _] = vectors.all_mut();
    parallel::for_each(r, |i, r| *r = E::from_lanes(right[i]));
    let power = metric.sums.sum(n, |i| metric.power(i, right[i]));
    let mut column = CgColumn {
        vectors,
        rz: [0.0; N],
        power,
        status: power.map(|p| (p <= 0.0).then_some(SolveStatus::Converged)),
        residuals: [const { Vec::new() }; N],
        best: [(f64::INFINITY, 0); N],
    };
    column.begin(metric);
    let mut products = vec![vec![E::ZERO; n]];
    for iteration in 1..=MAX_COARSE_ITERATIONS {
        if column.is_done() {
            break;
        }
        column.weigh_direction(metric, &mut products[0]);
        replace(&mut products);
        column.iterate(metric, &products[0], iteration, COARSE_RESIDUAL);
    }
    column
}
