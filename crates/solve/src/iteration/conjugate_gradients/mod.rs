//! Conjugate gradients for the zonal equations with several right-hand sides (Hestenes and Stiefel 1952; Saad, Iterative Methods, ch. 6).
//!
//! With strengths s = c B, sources s⁰ and w_i = c_i ρ_i/A_i (patch) or c_i Ω_i/(4 V_i) (volume) the equations read
//! s = s⁰ + w g s. Put s = s⁰ + √w y; then
//!
//! ```text
//!     (I − √w g √w) y = √w g s⁰,
//! ```
//!
//! symmetric, and positive definite as long as some power is lost. Each column (a light group) and band is a problem of its own with its own steps and
//! status. They run side by side, so that the operator reads its factors once for all of them. Cost: one product an iteration.
//!
//! **The residual is a power.** A residual r of y leaves δ = s⁰ + w g s − s = √w r in the strengths: the power t_i δ_i, t = A or 4V, is not yet
//! reflected by zone i. Since (I − w g)⁻¹ has no negative entry and power is conserved or lost, the power of δ, wherever it ends, is at most
//!
//! ```text
//!     R = Σ_i t_i √w_i |r_i|            relative to P = Σ_i t_i s⁰_i, the power of the sources:
//! ```
//!
//! the norm of r that bounds the error of the power absorbed by all zones, in watts. The iteration therefore stops on R and not on ‖r‖₂, which
//! weights dark and small zones differently.
//!
//! **Incident power.** The iteration keeps P = g s in place of y, which is √w P − r: each step adds α g √w p. The incident power of the solution so needs no
//! product of its own.
//!
//! **Coarse correction.** With the equations on blocks of zones the directions are M⁻¹ r instead of r, and β = ⟨r, M⁻¹ r⟩ over the one before
//! ([`super::coarse_system`]).
//!
//! **Warm start.** From strengths s near the solution: √w y = s − s⁰ where w > 0, r = √w g s − y; one product, as for a cold start.

mod band_entry;
mod coarse_correction;
mod column;
mod state_codec;

use super::coarse_system::CoarseSystem;
use super::divided_state;
use super::linear_system::{IterationResult, LinearSystem, StoppingCriterion, source_power};
use crate::operator::ExchangeOperator;
use band_entry::{BandEntry, first_lanes, is_grey, per_band};
use column::{CgColumn, ColumnVectors, Metric};
use state_codec::{columns_of, decode_state, encode_state};
use zonal_math::parallel;
use zonal_scene::{Band, Bands, CheckpointStore, PerBand, Progress, SolveStatus};

/// Iterations between two saved states.
const CHECKPOINT_INTERVAL: usize = 10;

/// Solves s = s⁰ + w g s for every column of `sources`, from the `initial` strengths if there are any, corrected by the `coarse` equations if there are
/// any. If all bands are identical, one is solved. The strengths take the memory of the sources. The second result is the incident power P = g s of every
/// column, in the memory of the iteration.
///
/// The state is saved in `checkpoints` every [`CHECKPOINT_INTERVAL`] iterations as stage `state-gradients`, and resumed from there. The iteration ends
/// early if the observer interrupts it.
pub(crate) fn solve(
    system: LinearSystem,
    coarse: Option<&CoarseSystem>,
    sources: Vec<Vec<Bands>>,
    initial: Option<&[Vec<Bands>]>,
    stop: StoppingCriterion,
    checkpoints: &dyn CheckpointStore,
    progress: &dyn Progress,
) -> (Vec<IterationResult>, Vec<Vec<Bands>>) {
    let all = || sources.iter().chain(initial.unwrap_or_default());
    let one_band =
        system.operator.has_identical_bands() && is_grey(&system.weights) && all().all(|v| is_grey(v));
    let one_band = system.sums.over_processes(one_band, |a, b| a && b);
    if one_band {
        solve_bands::<[f64; 1], 1>(system, coarse, sources, initial, stop, checkpoints, progress)
    } else {
        solve_bands::<Bands, 3>(system, coarse, sources, initial, stop, checkpoints, progress)
    }
}

fn solve_bands<E: BandEntry<N>, const N: usize>(
    system: LinearSystem,
    coarse: Option<&CoarseSystem>,
    sources: Vec<Vec<Bands>>,
    initial: Option<&[Vec<Bands>]>,
    stop: StoppingCriterion,
    checkpoints: &dyn CheckpointStore,
    progress: &dyn Progress,
) -> (Vec<IterationResult>, Vec<Vec<Bands>>) {
    let LinearSystem { operator, weights, targets, sums } = system;
    let root: Vec<E> = parallel::map(&weights, |w| E::from_lanes(first_lanes(w.sqrt())));
    // The weights of a large scene are freed before the vectors are made.
    drop(weights);
    let metric = Metric { root: &root, targets, sums };
    let turn = |c: &mut CgColumn<E, N>, rr| {
        let correction = coarse.map(|coarse| coarse_correction::find(coarse, &metric, c));
        c.turn(&metric, rr, correction);
    };
    progress.begin("solving", stop.max_iterations as u64);
    let decode = |bytes: &[u8], unknowns: usize| decode_state::<E, N>(bytes, sources.len(), unknowns);
    let kept = divided_state::load(checkpoints, STAGE, sums, root.len(), decode).map(columns_of);
    // √w p of the active columns, replaced by their products.
    let mut products: Vec<Vec<E>> = Vec::new();
    let start = |products: &mut _| {
        let mut all = start_columns(operator, &metric, &sources, initial, stop, products);
        for c in all.iter_mut().filter(|c| !c.is_done()) {
            let rr = c.square_of_residual(&metric);
            turn(c, rr);
        }
        (all, 1)
    };
    let (mut all, first) = kept.unwrap_or_else(|| start(&mut products));
    progress.advance(first as u64 - 1);
    for iteration in first..=stop.max_iterations {
        let active: Vec<usize> = (0..all.len()).filter(|&c| !all[c].is_done()).collect();
        if active.is_empty() || progress.is_interrupted() {
            break;
        }
        products.resize_with(active.len(), Vec::new);
        for (&c, product) in active.iter().zip(&mut products) {
            all[c].weigh_direction(&metric, product);
        }
        E::replace(operator, &mut products);
        for (&c, product) in active.iter().zip(&products) {
            let rr = all[c].advance(&metric, product, iteration, stop.residual);
            if !all[c].is_done() {
                turn(&mut all[c], rr);
            }
        }
        if checkpoints.keeps() && iteration % CHECKPOINT_INTERVAL == 0 {
            divided_state::save(checkpoints, STAGE, sums, &encode_state(&all, iteration + 1));
        }
        progress.advance(1);
    }
    progress.end();
    drop(products);
    all.into_iter().zip(sources).map(|(c, s)| finish(c, &root, s)).unzip()
}

/// Name of the stage.
const STAGE: &str = "state-gradients";

/// All columns before the first iteration; their products are left in `products`.
fn start_columns<E: BandEntry<N>, const N: usize>(
    operator: &dyn ExchangeOperator,
    metric: &Metric<E>,
    sources: &[Vec<Bands>],
    initial: Option<&[Vec<Bands>]>,
    stop: StoppingCriterion,
    products: &mut Vec<Vec<E>>,
) -> Vec<CgColumn<E, N>> {
    let powers: Vec<[f64; N]> =
        sources.iter().map(|s| first_lanes(source_power(metric.targets, s, metric.sums))).collect();
    let start = initial.unwrap_or(sources);
    let entry = |c: usize, i: usize| {
        let root = metric.root[i].lanes();
        let [s, s0]: [[f64; N]; 2] = [start, sources].map(|all| first_lanes(all[c][i]));
        E::per_lane(|b| if root[b] > 0.0 { s[b] } else { s0[b] })
    };
    *products = (0..start.len()).map(|c| parallel::collect(start[c].len(), |i| entry(c, i))).collect();
    E::replace(operator, products);
    let one = |c: usize| {
        let (s0, s, product) = (&sources[c], &start[c], &products[c]);
        let mut vectors = ColumnVectors(vec![[E::ZERO; 3]; s.len()]);
        let [power, r, _] = vectors.all_mut();
        parallel::for_each_pair(power, product, |power, g| *power = *g);
        parallel::for_each(r, |i, r| {
            let (root, g, s, s0): (_, _, [f64; N], [f64; N]) =
                (metric.root[i].lanes(), product[i].lanes(), first_lanes(s[i]), first_lanes(s0[i]));
            let y = |b: usize| if root[b] > 0.0 { (s[b] - s0[b]) / root[b] } else { 0.0 };
            *r = E::per_lane(|b| root[b] * g[b] - y(b));
        });
        let r = &*r;
        let power = powers[c];
        let left = metric.sums.sum(r.len(), |i| metric.power(i, r[i].lanes()));
        let relative: [f64; N] = per_band(|b| if power[b] > 0.0 { left[b] / power[b] } else { 0.0 });
        let status = relative.map(|x| (x <= stop.residual).then_some(SolveStatus::Converged));
        CgColumn {
            rz: [0.0; N],
            vectors,
            power,
            status,
            residuals: relative.map(|x| vec![x]),
            best: [(f64::INFINITY, 0); N],
        }
    };
    (0..sources.len()).map(one).collect()
}

/// The result of a column in the memory of its source, and the incident power in that of its vectors.
fn finish<E: BandEntry<N>, const N: usize>(
    c: CgColumn<E, N>,
    root: &[E],
    mut source: Vec<Bands>,
) -> (IterationResult, Vec<Bands>) {
    let of = |b: Band| b.index().min(N - 1);
    parallel::for_each(&mut source, |i, s| {
        let (root, s0) = (root[i].lanes(), *s);
        let y = c.solution(root, i);
        *s = Bands::from_fn(|b| s0[b] + root[of(b)] * y[of(b)]);
    });
    let result = IterationResult {
        strengths: source,
        status: PerBand::from_fn(|b| c.status[of(b)].unwrap_or(SolveStatus::MaxIterations)),
        residuals: PerBand::from_fn(|b| c.residuals[of(b)].clone()),
        power: Bands::from_fn(|b| c.power[of(b)]),
    };
    (result, E::first_of(c.vectors.0))
}

#[cfg(test)]
mod tests;
