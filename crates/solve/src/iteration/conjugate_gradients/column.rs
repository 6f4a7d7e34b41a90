//! One column of conjugate gradients: its vectors, and one iteration.

use super::band_entry::{BandEntry, per_band};
use crate::distribution::multivector::VectorEntry;
use crate::distribution::sum_order::SumOrder;
use crate::iteration::coarse_system::CoarseSystem;
use rayon::prelude::*;
use std::ops::Range;
use zonal_math::parallel;
use zonal_scene::SolveStatus;

/// Iterations without a new smallest residual after which a band is stalled.
const MAX_ITERATIONS_WITHOUT_PROGRESS: usize = 30;

/// Relative residual that rounding may leave in a converged solve, if the criterion is smaller.
const ROUNDING_RESIDUAL: f64 = 1e-10;

/// Unknowns of a task of a short loop over all of them.
const UNKNOWNS_OF_TASK: usize = 1 << 10;

/// About the operations of a band of an unknown in a step.
const OPERATIONS_OF_STEP: usize = 12;

/// Iteration of one column with entries `E` in N bands: all, or one that represents all.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CgColumn<E, const N: usize> {
    pub(super) vectors: ColumnVectors<E>,
    /// ⟨r, M⁻¹ r⟩.
    pub(super) rz: [f64; N],
    pub(super) power: [f64; N],
    pub(super) status: [Option<SolveStatus>; N],
    pub(super) residuals: [Vec<f64>; N],
    pub(super) best: [(f64, usize); N],
}

/// The vectors P, r and p of a column, one after the other. One band of all three has the size of all bands of one vector, which takes the memory
/// after the iteration.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ColumnVectors<E>(pub(super) Vec<[E; 3]>);

impl<E> ColumnVectors<E> {
    /// P, r and p.
    pub(super) fn all(&self) -> [&[E]; 3] {
        let (power, others) = self.0.as_flattened().split_at(self.0.len());
        let (r, p) = others.split_at(self.0.len());
        [power, r, p]
    }
    pub(super) fn all_mut(&mut self) -> [&mut [E]; 3] {
        let n = self.0.len();
        let (power, others) = self.0.as_flattened_mut().split_at_mut(n);
        let (r, p) = others.split_at_mut(n);
        [power, r, p]
    }
}

/// Data of the linear system that all columns have in common.
#[derive(Clone, Copy)]
pub(super) struct Metric<'a, E> {
    /// √w.
    pub(super) root: &'a [E],
    /// t.
    pub(super) targets: &'a [f64],
    pub(super) sums: SumOrder<'a>,
}

/// M⁻¹ r − r = Φ c ([`crate::iteration::coarse_system`]).
pub(super) struct Correction<'a, const N: usize> {
    pub(super) coarse: &'a CoarseSystem<'a>,
    /// c.
    pub(super) values: Vec<[f64; N]>,
    /// ⟨r, Φ c⟩.
    pub(super) product: [f64; N],
    /// False for a band whose coarse equations have no solution: its direction begins anew.
    pub(super) holds: [bool; N],
}

impl<E: VectorEntry> Metric<'_, E> {
    /// t √w |r| of an unknown.
    #[inline]
    pub(super) fn power<const N: usize>(&self, i: usize, r: [f64; N]) -> [f64; N]
    where
        E: BandEntry<N>,
    {
        let root = self.root[i].lanes();
        per_band(|b| self.targets[i] * root[b] * r[b].abs())
    }
}

impl<E: BandEntry<N>, const N: usize> CgColumn<E, N> {
    pub(super) fn is_done(&self) -> bool {
        self.status.iter().all(Option::is_some)
    }

    /// √w p.
    pub(super) fn weigh_direction(&self, metric: &Metric<E>, out: &mut Vec<E>) {
        let [_, _, p] = self.vectors.all();
        out.resize(p.len(), E::ZERO);
        parallel::chunks(out, UNKNOWNS_OF_TASK, |k, out| {
            let first = k * UNKNOWNS_OF_TASK;
            out.iter_mut().zip(first..).for_each(|(x, i)| *x = metric.root[i].times(p[i]));
        });
    }

    /// One iteration but for the next direction, `product` = g √w p: new iterates, and their status. Returns ⟨r, r⟩.
    pub(super) fn advance(
        &mut self,
        metric: &Metric<E>,
        product: &[E],
        iteration: usize,
        wanted: f64,
    ) -> [f64; N] {
        let q = |i: usize, p: [f64; N]| -> [f64; N] {
            let (root, product) = (metric.root[i].lanes(), product[i].lanes());
            per_band(|b| p[b] - root[b] * product[b])
        };
        let [_, _, p] = self.vectors.all();
        let pq: [f64; N] = metric.sums.sum(p.len(), |i| {
            let p = p[i].lanes();
            let q = q(i, p);
            per_band(|b| p[b] * q[b])
        });
        let alpha: [f64; N] =
            per_band(|b| if self.status[b].is_none() && pq[b] > 0.0 { self.rz[b] / pq[b] } else { 0.0 });
        let [rr, left] = self.step(metric, product, alpha);
        for b in (0..N).filter(|&b| self.status[b].is_none()).collect::<Vec<_>>() {
            let relative = left[b] / self.power[b];
            self.residuals[b].push(relative);
            if relative < self.best[b].0 {
                self.best[b] = (relative, iteration);
            }
            if relative <= wanted {
                self.status[b] = Some(if self.is_representable(metric, b) {
                    SolveStatus::Converged
                } else {
                    SolveStatus::Stalled
                });
            } else if !relative.is_finite()
                || pq[b] <= 0.0
                || iteration - self.best[b].1 > MAX_ITERATIONS_WITHOUT_PROGRESS
            {
                self.status[b] = Some(SolveStatus::Stalled);
            }
        }
        rr
    }

    /// P += α g √w p and r −= α q; the new ⟨r, r⟩ and R.
    fn step(&mut self, metric: &Metric<E>, product: &[E], alpha: [f64; N]) -> [[f64; N]; 2] {
        let [power, r, p] = self.vectors.all_mut();
        let (n, chunks) = (p.len(), metric.sums.chunks(p.len()));
        let of_chunks = (pieces_mut(power, &chunks), pieces_mut(r, &chunks), &chunks);
        let least = parallel::least_items(OPERATIONS_OF_STEP * N * n / chunks.len().max(1));
        let parts: Vec<[[f64; N]; 2]> = of_chunks
            .into_par_iter()
            .with_min_len(least)
            .map(|(power, r, chunk)| {
                let mut sums = [[0.0; N]; 2];
                for ((i, p), (power, r)) in chunk.clone().zip(&p[chunk.clone()]).zip(power.iter_mut().zip(r))
                {
                    let (old_power, old_r, p) = (power.lanes(), r.lanes(), p.lanes());
                    let (root, product) = (metric.root[i].lanes(), product[i].lanes());
                    *power = E::per_lane(|b| old_power[b] + alpha[b] * product[b]);
                    let new_r: [f64; N] = per_band(|b| old_r[b] - alpha[b] * (p[b] - root[b] * product[b]));
                    *r = E::from_lanes(new_r);
                    let left = metric.power(i, new_r);
                    sums =
                        [per_band(|b| sums[0][b] + new_r[b] * new_r[b]), per_band(|b| sums[1][b] + left[b])];
                }
                sums
            })
            .collect();
        metric.sums.combine(n, &parts)
    }

    /// ⟨r, r⟩.
    pub(super) fn square_of_residual(&self, metric: &Metric<E>) -> [f64; N] {
        let [_, r, _] = self.vectors.all();
        metric.sums.sum(r.len(), |i| r[i].lanes().map(|x| x * x))
    }

    /// The next direction p = M⁻¹ r + β p, or the first one, from ⟨r, r⟩.
    pub(super) fn turn(&mut self, metric: &Metric<E>, rr: [f64; N], correction: Option<Correction<N>>) {
        let [_, r, p] = self.vectors.all_mut();
        let (product, holds) = correction.as_ref().map_or(([0.0; N], [true; N]), |c| (c.product, c.holds));
        let rz: [f64; N] = per_band(|b| rr[b] + product[b]);
        let beta: [f64; N] =
            per_band(|b| if holds[b] && self.rz[b] > 0.0 { rz[b] / self.rz[b] } else { 0.0 });
        self.rz = rz;
        parallel::for_each_pair(p, r, |p, r| {
            let (old, r) = (p.lanes(), r.lanes());
            *p = E::per_lane(|b| r[b] + beta[b] * old[b]);
        });
        if let Some(Correction { coarse, values, .. }) = correction {
            coarse.prolong(values, p, |i, p, c| {
                let (root, old) = (metric.root[i].lanes(), p.lanes());
                *p = E::per_lane(|b| old[b] + root[b] * c[b]);
            });
        }
    }

    /// y = √w P − r of an unknown.
    #[inline]
    pub(super) fn solution(&self, root: [f64; N], i: usize) -> [f64; N] {
        let [power, r, _] = self.vectors.all();
        let (power, r) = (power[i].lanes(), r[i].lanes());
        per_band(|b| root[b] * power[b] - r[b])
    }

    /// True if the rounding of the strengths is below the residual. The residual is updated separately from the strengths; with almost no absorption the
    /// strengths grow until their rounding leaves more power than the residual states.
    fn is_representable(&self, metric: &Metric<E>, b: usize) -> bool {
        let n = metric.root.len();
        let whole = metric.sums.sum(n, |i| metric.power(i, self.solution(metric.root[i].lanes(), i)));
        let left = self.residuals[b].last().map_or(0.0, |r| r.max(ROUNDING_RESIDUAL));
        f64::EPSILON * whole[b] <= left * self.power[b]
    }
}

/// The pieces of a vector that is cut into chunks.
fn pieces_mut<'a, T>(mut vector: &'a mut [T], chunks: &[Range<usize>]) -> Vec<&'a mut [T]> {
    let mut out = Vec::with_capacity(chunks.len());
    for chunk in chunks {
        let (piece, rest) = vector.split_at_mut(chunk.len());
        out.push(piece);
        vector = rest;
    }
    out
}
