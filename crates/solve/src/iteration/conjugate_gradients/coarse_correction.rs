//! The correction of a direction by the equations on blocks of zones ([`crate::iteration::coarse_system`]).

use super::band_entry::{BandEntry, first_lanes, per_band};
use super::column::{CgColumn, ColumnVectors, Correction, Metric};
use crate::iteration::coarse_system::CoarseSystem;
use crate::operator::ExchangeOperator;
use zonal_math::parallel;
use zonal_scene::SolveStatus;

/// Residual of the coarse equations over that at their start: M⁻¹ is nearly one matrix in all iterations.
const COARSE_RESIDUAL: f64 = 1e-4;
/// Iterations of the coarse equations, at most; bands that need more have no correction.
const MAX_COARSE_ITERATIONS: usize = 100;

/// c = ((I − ΦᵀKΦ)⁻¹ − I) Φᵀ r for the residual r of a column, in the bands that are not done.
pub(super) fn find<'a, E: BandEntry<N>, const N: usize>(
    coarse: &'a CoarseSystem<'a>,
    metric: &Metric<E>,
    column: &CgColumn<E, N>,
) -> Correction<'a, N> {
    let is_open = column.status.map(|s| s.is_none());
    let [_, r, _] = column.vectors.all();
    let right = coarse.restrict(|i| {
        let (root, r) = (metric.root[i].lanes(), r[i].lanes());
        per_band(|b| if is_open[b] { root[b] * r[b] } else { 0.0 })
    });
    let system = coarse.system();
    let root: Vec<E> = parallel::map(&system.weights, |w| E::from_lanes(first_lanes(w.sqrt())));
    let own = Metric { root: &root, targets: system.targets, sums: system.sums };
    let column = solve(&own, system.operator, &right);
    let holds = column.status.map(|s| s == Some(SolveStatus::Converged));
    // y = √w P − r + Φᵀ r, since P is zero at the start.
    let of_block = |c: usize| -> [f64; N] {
        let all = column.solution(root[c].lanes(), c);
        per_band(|b| if holds[b] { all[b] } else { 0.0 })
    };
    let values: Vec<[f64; N]> = parallel::collect(right.len(), of_block);
    let product = own.sums.sum(right.len(), |c| per_band(|b| right[c][b] * values[c][b]));
    Correction { coarse, values, product, holds }
}

/// Solves (I − √w g √w) y = b, with P = 0 at the start.
fn solve<E: BandEntry<N>, const N: usize>(
    metric: &Metric<E>,
    operator: &dyn ExchangeOperator,
    right: &[[f64; N]],
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
    let mut rr = column.square_of_residual(metric);
    let mut products = vec![vec![E::ZERO; n]];
    for iteration in 1..=MAX_COARSE_ITERATIONS {
        if column.is_done() {
            break;
        }
        column.turn(metric, rr, None);
        column.weigh_direction(metric, &mut products[0]);
        E::replace(operator, &mut products);
        rr = column.advance(metric, &products[0], iteration, COARSE_RESIDUAL);
    }
    column
}
