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
//! **Warm start.** From strengths s near the solution: √w y = s − s⁰ where w > 0, r = √w g s − y; one product, as for a cold start.

use super::divided_state::{self, PartialState};
use super::linear_system::{IterationResult, LinearSystem, StoppingCriterion, source_power};
use crate::distribution::multivector::VectorEntry;
use crate::distribution::sum_order::SumOrder;
use crate::operator::ExchangeOperator;
use crate::settings::stage_codec::{Decoder, Encoder};
use rayon::prelude::*;
use std::ops::Range;
use zonal_math::parallel;
use zonal_scene::{Band, Bands, CheckpointStore, PerBand, Progress, SolveStatus};

/// Iterations without a new smallest residual after which a band is stalled.
const MAX_ITERATIONS_WITHOUT_PROGRESS: usize = 30;

/// Relative residual that rounding may leave in a converged solve, if the criterion is smaller.
const ROUNDING_RESIDUAL: f64 = 1e-10;

/// Iterations between two saved states.
const CHECKPOINT_INTERVAL: usize = 10;

/// Iteration of one column with entries `E` in N bands: all, or one that represents all.
#[derive(Clone, Debug, PartialEq)]
struct CgColumn<E, const N: usize> {
    vectors: ColumnVectors<E>,
    rr: [f64; N],
    power: [f64; N],
    status: [Option<SolveStatus>; N],
    residuals: [Vec<f64>; N],
    best: [(f64, usize); N],
}

/// The vectors y, r and p of a column, one after the other. One band of all three has the size of all bands of one vector, which takes the memory
/// after the iteration.
#[derive(Clone, Debug, PartialEq)]
struct ColumnVectors<E>(Vec<[E; 3]>);

impl<E> ColumnVectors<E> {
    /// y, r and p.
    fn all(&self) -> [&[E]; 3] {
        let (y, others) = self.0.as_flattened().split_at(self.0.len());
        let (r, p) = others.split_at(self.0.len());
        [y, r, p]
    }
    fn all_mut(&mut self) -> [&mut [E]; 3] {
        let n = self.0.len();
        let (y, others) = self.0.as_flattened_mut().split_at_mut(n);
        let (r, p) = others.split_at_mut(n);
        [y, r, p]
    }
}

impl<E, const N: usize> CgColumn<E, N> {
    fn is_done(&self) -> bool {
        self.status.iter().all(Option::is_some)
    }
}

/// An entry of a vector over the unknowns in N bands. The iteration computes with arrays of N numbers, so that one band costs a third; entries
/// of all bands are [`Bands`], which convert to and from arrays here.
trait BandEntry<const N: usize>: VectorEntry {
    /// The numbers of the bands.
    fn lanes(self) -> [f64; N];
    /// The inverse of [`BandEntry::lanes`].
    fn from_lanes(lanes: [f64; N]) -> Self;
    /// A vector of any content in the memory of three.
    fn into_bands(vectors: Vec<[Self; 3]>) -> Vec<Bands>;
    /// Replaces s of every column by g s.
    fn replace(operator: &dyn ExchangeOperator, columns: &mut Vec<Vec<Self>>);
    /// The entry that evaluates `f` for each band.
    #[inline]
    fn per_lane(f: impl FnMut(usize) -> f64) -> Self {
        Self::from_lanes(per_band(f))
    }
}

impl BandEntry<3> for Bands {
    #[inline]
    fn lanes(self) -> [f64; 3] {
        self.to_rgb()
    }
    #[inline]
    fn from_lanes(lanes: [f64; 3]) -> Bands {
        Bands::from_rgb(lanes)
    }
    fn into_bands(vectors: Vec<[Bands; 3]>) -> Vec<Bands> {
        let n = vectors.len();
        let mut out = vectors.into_flattened();
        out.truncate(n);
        out.shrink_to_fit();
        out
    }
    fn replace(operator: &dyn ExchangeOperator, columns: &mut Vec<Vec<Bands>>) {
        operator.replace_many(columns);
    }
}

impl BandEntry<1> for [f64; 1] {
    #[inline]
    fn lanes(self) -> [f64; 1] {
        self
    }
    #[inline]
    fn from_lanes(lanes: [f64; 1]) -> [f64; 1] {
        lanes
    }
    fn into_bands(vectors: Vec<[[f64; 1]; 3]>) -> Vec<Bands> {
        // Collected in place.
        vectors.into_iter().map(|v| Bands::from_rgb(v.map(|[x]| x))).collect()
    }
    fn replace(operator: &dyn ExchangeOperator, columns: &mut Vec<Vec<[f64; 1]>>) {
        columns.iter_mut().for_each(|c| operator.replace_band(c));
    }
}

fn per_band<const N: usize>(f: impl FnMut(usize) -> f64) -> [f64; N] {
    std::array::from_fn(f)
}

/// The first N bands.
fn first_lanes<const N: usize>(x: Bands) -> [f64; N] {
    per_band(|b| x.as_slice()[b])
}

/// The first N bands of a vector.
fn first_bands<E: BandEntry<N>, const N: usize>(v: &[Bands]) -> Vec<E> {
    parallel::map(v, |x| E::from_lanes(first_lanes(*x)))
}

/// True if the bands of all entries are bit-identical.
fn is_grey(v: &[Bands]) -> bool {
    let is_grey = |x: &Bands| x.all(|y| y.to_bits() == x.first().to_bits());
    parallel::all(v, is_grey)
}

/// Solves s = s⁰ + w g s for every column of `sources`, from the `initial` strengths if there are any. If all bands are identical, one is solved. The
/// strengths take the memory of the sources. The second result is a vector of any content in the memory of those of the iteration.
///
/// The state is saved in `checkpoints` every [`CHECKPOINT_INTERVAL`] iterations as stage `state-krylov`, and resumed from there. The iteration ends
/// early if the observer interrupts it.
pub(crate) fn solve(
    system: &LinearSystem,
    sources: Vec<Vec<Bands>>,
    initial: Option<&[Vec<Bands>]>,
    stop: StoppingCriterion,
    checkpoints: &dyn CheckpointStore,
    progress: &dyn Progress,
) -> (Vec<IterationResult>, Vec<Bands>) {
    let all = || sources.iter().chain(initial.unwrap_or_default());
    let one_band =
        system.operator.has_identical_bands() && is_grey(system.weights) && all().all(|v| is_grey(v));
    let one_band = system.sums.over_processes(one_band, |a, b| a && b);
    if one_band {
        solve_bands::<[f64; 1], 1>(system, sources, initial, stop, checkpoints, progress)
    } else {
        solve_bands::<Bands, 3>(system, sources, initial, stop, checkpoints, progress)
    }
}

fn solve_bands<E: BandEntry<N>, const N: usize>(
    system: &LinearSystem,
    sources: Vec<Vec<Bands>>,
    initial: Option<&[Vec<Bands>]>,
    stop: StoppingCriterion,
    checkpoints: &dyn CheckpointStore,
    progress: &dyn Progress,
) -> (Vec<IterationResult>, Vec<Bands>) {
    let root: Vec<E> = parallel::map(system.weights, |w| E::from_lanes(first_lanes(w.sqrt())));
    let norm = ResidualNorm { root: &root, targets: system.targets, sums: system.sums };
    progress.begin("solving", stop.max_iterations as u64);
    let decode = |bytes: &[u8], unknowns: usize| decode_state::<E, N>(bytes, sources.len(), unknowns);
    let kept = divided_state::load(checkpoints, STAGE, system.sums, root.len(), decode).map(columns_of);
    // √w p of the active columns, replaced by their products.
    let mut products: Vec<Vec<E>> = Vec::new();
    let start = |products: &mut _| (start_columns(system, &norm, &sources, initial, stop, products), 1);
    let (mut all, first) = kept.unwrap_or_else(|| start(&mut products));
    progress.advance(first as u64 - 1);
    for iteration in first..=stop.max_iterations {
        let active: Vec<usize> = (0..all.len()).filter(|&c| !all[c].is_done()).collect();
        if active.is_empty() || progress.is_interrupted() {
            break;
        }
        products.resize_with(active.len(), Vec::new);
        for (&c, product) in active.iter().zip(&mut products) {
            product.resize(root.len(), E::ZERO);
            let [_, _, p] = all[c].vectors.all();
            parallel::for_each(product, |i, x| *x = root[i].times(p[i]));
        }
        E::replace(system.operator, &mut products);
        for (&c, product) in active.iter().zip(&products) {
            iterate_column(&mut all[c], &norm, product, iteration, stop.residual);
        }
        if checkpoints.keeps() && iteration % CHECKPOINT_INTERVAL == 0 {
            divided_state::save(checkpoints, STAGE, system.sums, &encode_state(&all, iteration + 1));
        }
        progress.advance(1);
    }
    progress.end();
    drop(products);
    let mut spare = Vec::new();
    let results = all.into_iter().zip(sources).map(|(c, s)| {
        let (result, vectors) = finish(c, &root, s);
        spare = E::into_bands(vectors.0);
        result
    });
    (results.collect(), spare)
}

/// Name of the stage.
const STAGE: &str = "state-krylov";

struct ResidualNorm<'a, E> {
    root: &'a [E],
    targets: &'a [f64],
    sums: SumOrder<'a>,
}

impl<E: VectorEntry> ResidualNorm<'_, E> {
    /// t √w |r| of an unknown.
    #[inline]
    fn power<const N: usize>(&self, i: usize, r: [f64; N]) -> [f64; N]
    where
        E: BandEntry<N>,
    {
        let root = self.root[i].lanes();
        per_band(|b| self.targets[i] * root[b] * r[b].abs())
    }
}

/// All columns before the first iteration; their products are left in `products`.
fn start_columns<E: BandEntry<N>, const N: usize>(
    system: &LinearSystem,
    norm: &ResidualNorm<E>,
    sources: &[Vec<Bands>],
    initial: Option<&[Vec<Bands>]>,
    stop: StoppingCriterion,
    products: &mut Vec<Vec<E>>,
) -> Vec<CgColumn<E, N>> {
    let powers: Vec<[f64; N]> =
        sources.iter().map(|s| first_lanes(source_power(norm.targets, s, norm.sums))).collect();
    let start = initial.unwrap_or(sources);
    *products = start.iter().map(|s| first_bands(s)).collect();
    E::replace(system.operator, products);
    let one = |c: usize| {
        let (s0, s, g) = (&sources[c], &start[c], &products[c]);
        let over = |i: usize| {
            let (root, s, s0): (_, [f64; N], [f64; N]) =
                (norm.root[i].lanes(), first_lanes(s[i]), first_lanes(s0[i]));
            E::per_lane(|b| if root[b] > 0.0 { (s[b] - s0[b]) / root[b] } else { 0.0 })
        };
        let mut vectors = ColumnVectors(vec![[E::ZERO; 3]; s.len()]);
        let [y, r, p] = vectors.all_mut();
        parallel::for_each(y, |i, y| *y = over(i));
        parallel::for_each(r, |i, r| {
            let (root, g, y) = (norm.root[i].lanes(), g[i].lanes(), y[i].lanes());
            *r = E::per_lane(|b| root[b] * g[b] - y[b]);
        });
        p.copy_from_slice(r);
        let r = &*r;
        let power = powers[c];
        let left = norm.sums.sum(r.len(), |i| norm.power(i, r[i].lanes()));
        let relative: [f64; N] = per_band(|b| if power[b] > 0.0 { left[b] / power[b] } else { 0.0 });
        let status = relative.map(|x| (x <= stop.residual).then_some(SolveStatus::Converged));
        CgColumn {
            rr: norm.sums.sum(r.len(), |i| r[i].lanes().map(|x| x * x)),
            vectors,
            power,
            status,
            residuals: relative.map(|x| vec![x]),
            best: [(f64::INFINITY, 0); N],
        }
    };
    (0..sources.len()).map(one).collect()
}

/// One iteration of a column, `product` = g √w p.
fn iterate_column<E: BandEntry<N>, const N: usize>(
    c: &mut CgColumn<E, N>,
    norm: &ResidualNorm<E>,
    product: &[E],
    iteration: usize,
    wanted: f64,
) {
    let q = |i: usize, p: [f64; N]| -> [f64; N] {
        let (root, product) = (norm.root[i].lanes(), product[i].lanes());
        per_band(|b| p[b] - root[b] * product[b])
    };
    let [_, _, p] = c.vectors.all();
    let pq: [f64; N] = norm.sums.sum(p.len(), |i| {
        let p = p[i].lanes();
        let q = q(i, p);
        per_band(|b| p[b] * q[b])
    });
    let alpha: [f64; N] =
        per_band(|b| if c.status[b].is_none() && pq[b] > 0.0 { c.rr[b] / pq[b] } else { 0.0 });
    let [new, left] = step_along_direction(c, norm, alpha, q);
    let beta: [f64; N] = per_band(|b| if c.rr[b] > 0.0 { new[b] / c.rr[b] } else { 0.0 });
    c.rr = new;
    let [_, r, p] = c.vectors.all_mut();
    parallel::for_each_pair(p, r, |p, r| {
        let (old, r) = (p.lanes(), r.lanes());
        *p = E::per_lane(|b| r[b] + beta[b] * old[b]);
    });
    for b in (0..N).filter(|&b| c.status[b].is_none()).collect::<Vec<_>>() {
        let relative = left[b] / c.power[b];
        c.residuals[b].push(relative);
        if relative < c.best[b].0 {
            c.best[b] = (relative, iteration);
        }
        if relative <= wanted {
            c.status[b] = Some(if is_representable(c, norm, b) {
                SolveStatus::Converged
            } else {
                SolveStatus::Stalled
            });
        } else if !relative.is_finite()
            || pq[b] <= 0.0
            || iteration - c.best[b].1 > MAX_ITERATIONS_WITHOUT_PROGRESS
        {
            c.status[b] = Some(SolveStatus::Stalled);
        }
    }
}

/// y += α p and r −= α q; the new ⟨r, r⟩ and R.
fn step_along_direction<E: BandEntry<N>, const N: usize>(
    c: &mut CgColumn<E, N>,
    norm: &ResidualNorm<E>,
    alpha: [f64; N],
    q: impl Fn(usize, [f64; N]) -> [f64; N] + Sync,
) -> [[f64; N]; 2] {
    let [y, r, p] = c.vectors.all_mut();
    let (n, chunks) = (p.len(), norm.sums.chunks(p.len()));
    let of_chunks = (pieces_mut(y, &chunks), pieces_mut(r, &chunks), &chunks);
    let parts: Vec<[[f64; N]; 2]> = of_chunks
        .into_par_iter()
        .map(|(y, r, chunk)| {
            let mut sums = [[0.0; N]; 2];
            for ((i, p), (y, r)) in chunk.clone().zip(&p[chunk.clone()]).zip(y.iter_mut().zip(r)) {
                let (old_y, old_r, p) = (y.lanes(), r.lanes(), p.lanes());
                let q = q(i, p);
                *y = E::per_lane(|b| old_y[b] + alpha[b] * p[b]);
                let new_r: [f64; N] = per_band(|b| old_r[b] - alpha[b] * q[b]);
                *r = E::from_lanes(new_r);
                let left = norm.power(i, new_r);
                sums = [per_band(|b| sums[0][b] + new_r[b] * new_r[b]), per_band(|b| sums[1][b] + left[b])];
            }
            sums
        })
        .collect();
    norm.sums.combine(n, &parts)
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

/// True if the rounding of the strengths is below the residual. The residual is updated separately from the strengths; with almost no absorption the
/// strengths grow until their rounding leaves more power than the residual states.
fn is_representable<E: BandEntry<N>, const N: usize>(
    c: &CgColumn<E, N>,
    norm: &ResidualNorm<E>,
    b: usize,
) -> bool {
    let [y, ..] = c.vectors.all();
    let whole = norm.sums.sum(y.len(), |i| norm.power(i, y[i].lanes()));
    f64::EPSILON * whole[b] <= c.residuals[b].last().map_or(0.0, |r| r.max(ROUNDING_RESIDUAL)) * c.power[b]
}

/// The result of a column in the memory of its source, and its vectors.
fn finish<E: BandEntry<N>, const N: usize>(
    c: CgColumn<E, N>,
    root: &[E],
    mut source: Vec<Bands>,
) -> (IterationResult, ColumnVectors<E>) {
    let of = |b: Band| b.index().min(N - 1);
    let [y, ..] = c.vectors.all();
    parallel::for_each(&mut source, |i, s| {
        let (root, y, s0) = (root[i].lanes(), y[i].lanes(), *s);
        *s = Bands::from_fn(|b| s0[b] + root[of(b)] * y[of(b)]);
    });
    let result = IterationResult {
        strengths: source,
        status: PerBand::from_fn(|b| c.status[of(b)].unwrap_or(SolveStatus::MaxIterations)),
        residuals: PerBand::from_fn(|b| c.residuals[of(b)].clone()),
        power: Bands::from_fn(|b| c.power[of(b)]),
    };
    (result, c.vectors)
}

/// Encodes the state as a stage, the number of bands first.
fn encode_state<E: BandEntry<N>, const N: usize>(all: &[CgColumn<E, N>], next: usize) -> Vec<u8> {
    let mut encoder = Encoder::default();
    encoder.int(N);
    encoder.int(next);
    for c in all {
        for v in c.vectors.all() {
            encoder.reals(&v.iter().flat_map(|x| x.lanes()).collect::<Vec<f64>>());
        }
        encoder.reals(&c.rr);
        encoder.reals(&c.power);
        for b in 0..N {
            encoder.int(
                c.status[b]
                    .map_or(0, |s| 1 + SolveStatus::VARIANTS.iter().position(|x| *x == s).unwrap_or(0)),
            );
            encoder.reals(&c.residuals[b]);
            encoder.reals(&[c.best[b].0]);
            encoder.int(c.best[b].1);
        }
    }
    encoder.bytes()
}

/// The numbers of a column beside its vectors.
type ColumnNumbers<const N: usize> =
    ([[f64; N]; 2], [Option<SolveStatus>; N], [Vec<f64>; N], [(f64, usize); N]);

/// Decodes a stage of [`encode_state`] for a number of columns and unknowns: y, r and p of each column in turn.
fn decode_state<E: BandEntry<N>, const N: usize>(
    bytes: &[u8],
    columns: usize,
    unknowns: usize,
) -> Option<PartialState<E, Vec<ColumnNumbers<N>>>> {
    let mut decoder = Decoder::new(bytes);
    let (bands, next) = (decoder.int()?, decoder.int()?);
    if bands != N || next == 0 {
        return None;
    }
    let mut state = PartialState { vectors: Vec::new(), shared: Vec::new(), next };
    for _ in 0..columns {
        for _ in 0..3 {
            let flat = decoder.reals().filter(|flat| flat.len() == N * unknowns)?;
            state.vectors.push(flat.as_chunks::<N>().0.iter().map(|x| E::from_lanes(*x)).collect());
        }
        let sums = [decoder.reals()?.try_into().ok()?, decoder.reals()?.try_into().ok()?];
        let (mut status, mut residuals, mut best) = ([None; N], [const { Vec::new() }; N], [(0.0, 0); N]);
        for b in 0..N {
            let known = decoder.int()?;
            status[b] = if known == 0 { None } else { Some(*SolveStatus::VARIANTS.get(known - 1)?) };
            residuals[b] = decoder.reals()?;
            best[b] = (*decoder.reals()?.first()?, decoder.int()?);
        }
        state.shared.push((sums, status, residuals, best));
    }
    decoder.at_end().then_some(state)
}

/// The columns of a state, and the next iteration.
fn columns_of<E: BandEntry<N>, const N: usize>(
    state: PartialState<E, Vec<ColumnNumbers<N>>>,
) -> (Vec<CgColumn<E, N>>, usize) {
    let column = |(([rr, power], status, residuals, best), of_column): (ColumnNumbers<N>, &[Vec<E>])| {
        let mut vectors = ColumnVectors(vec![[E::ZERO; 3]; of_column[0].len()]);
        vectors.all_mut().into_iter().zip(of_column).for_each(|(v, known)| v.copy_from_slice(known));
        CgColumn { vectors, rr, power, status, residuals, best }
    };
    (state.shared.into_iter().zip(state.vectors.chunks(3)).map(column).collect(), state.next)
}

#[cfg(test)]
mod tests;
