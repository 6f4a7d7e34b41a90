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

use super::linear_system::{IterationResult, LinearSystem, StoppingCriterion, source_power};
use super::multivector;
use crate::checkpoint::{Decoder, Encoder};
use crate::operator::ExchangeOperator;
use rayon::prelude::*;
use zonal_scene::{Bands, CheckpointStore, Progress, SolveStatus, bands};

/// Iterations without a new smallest residual after which a band is stalled.
const MAX_ITERATIONS_WITHOUT_PROGRESS: usize = 30;

/// Relative residual that rounding may leave in a converged solve, if the criterion is smaller.
const ROUNDING_RESIDUAL: f64 = 1e-10;

/// Iterations between two saved states.
const CHECKPOINT_INTERVAL: usize = 10;

/// Iteration of one column in N bands: three, or one that represents all.
#[derive(Clone, Debug, PartialEq)]
struct CgColumn<const N: usize> {
    y: Vec<[f64; N]>,
    r: Vec<[f64; N]>,
    p: Vec<[f64; N]>,
    rr: [f64; N],
    power: [f64; N],
    status: [Option<SolveStatus>; N],
    residuals: [Vec<f64>; N],
    best: [(f64, usize); N],
}

impl<const N: usize> CgColumn<N> {
    fn is_done(&self) -> bool {
        self.status.iter().all(Option::is_some)
    }
}

/// Products for N bands.
trait BandProducts<const N: usize>: Sized {
    /// g s of every column.
    fn products(operator: &dyn ExchangeOperator, columns: &[Vec<[f64; N]>]) -> Vec<Vec<[f64; N]>>;
}

impl BandProducts<3> for CgColumn<3> {
    fn products(operator: &dyn ExchangeOperator, columns: &[BandVector<3>]) -> Vec<BandVector<3>> {
        operator.apply_many(columns)
    }
}

impl BandProducts<1> for CgColumn<1> {
    fn products(operator: &dyn ExchangeOperator, columns: &[BandVector<1>]) -> Vec<BandVector<1>> {
        columns.iter().map(|c| operator.apply_band(c)).collect()
    }
}

/// A vector over the unknowns in N bands.
type BandVector<const N: usize> = Vec<[f64; N]>;

fn per_band<const N: usize>(f: impl FnMut(usize) -> f64) -> [f64; N] {
    std::array::from_fn(f)
}

/// The first N bands of a vector.
fn first_bands<const N: usize>(v: &[Bands]) -> BandVector<N> {
    v.par_iter().map(|x| per_band(|b| x[b])).collect()
}

/// True if the bands of all entries are bit-identical.
fn is_grey(v: &[Bands]) -> bool {
    v.par_iter().all(|x| x[0].to_bits() == x[1].to_bits() && x[0].to_bits() == x[2].to_bits())
}

/// Solves s = s⁰ + w g s for every column of `sources`, from the `initial` strengths if there are any. If all bands are identical, one is solved.
///
/// The state is saved in `checkpoints` every [`CHECKPOINT_INTERVAL`] iterations as stage `state-krylov`, and resumed from there.
pub(crate) fn solve(
    system: &LinearSystem,
    sources: &[Vec<Bands>],
    initial: Option<&[Vec<Bands>]>,
    stop: StoppingCriterion,
    checkpoints: &dyn CheckpointStore,
    progress: &dyn Progress,
) -> Vec<IterationResult> {
    let all = || sources.iter().chain(initial.unwrap_or_default());
    let one_band =
        system.operator.has_identical_bands() && is_grey(system.weights) && all().all(|v| is_grey(v));
    match one_band {
        true => solve_bands::<1>(system, sources, initial, stop, checkpoints, progress),
        false => solve_bands::<3>(system, sources, initial, stop, checkpoints, progress),
    }
}

fn solve_bands<const N: usize>(
    system: &LinearSystem,
    sources: &[Vec<Bands>],
    initial: Option<&[Vec<Bands>]>,
    stop: StoppingCriterion,
    checkpoints: &dyn CheckpointStore,
    progress: &dyn Progress,
) -> Vec<IterationResult>
where
    CgColumn<N>: BandProducts<N>,
{
    let root: BandVector<N> = system.weights.par_iter().map(|w| per_band(|b| w[b].sqrt())).collect();
    let norm = ResidualNorm { root: &root, targets: system.targets };
    progress.begin("solving", stop.max_iterations as u64);
    let kept = checkpoints.load(STAGE).and_then(|b| decode_state::<N>(&b, sources.len(), root.len()));
    let (mut all, first) = kept.unwrap_or_else(|| (start_columns(system, &norm, sources, initial, stop), 1));
    progress.advance(first as u64 - 1);
    for iteration in first..=stop.max_iterations {
        let active: Vec<usize> = (0..all.len()).filter(|&c| !all[c].is_done()).collect();
        if active.is_empty() {
            break;
        }
        let inputs: Vec<BandVector<N>> =
            active.iter().map(|&c| multivector::times(&root, &all[c].p)).collect();
        let products = CgColumn::<N>::products(system.operator, &inputs);
        drop(inputs);
        for (&c, product) in active.iter().zip(&products) {
            iterate_column(&mut all[c], &norm, product, iteration, stop.residual);
        }
        if checkpoints.keeps() && iteration % CHECKPOINT_INTERVAL == 0 {
            checkpoints.save(STAGE, &encode_state(&all, iteration + 1));
        }
        progress.advance(1);
    }
    progress.end();
    all.into_iter().zip(sources).map(|(c, s)| finish(c, &root, s)).collect()
}

/// Name of the stage.
const STAGE: &str = "state-krylov";

struct ResidualNorm<'a, const N: usize> {
    root: &'a [[f64; N]],
    targets: &'a [f64],
}

impl<const N: usize> ResidualNorm<'_, N> {
    /// t √w |r| of an unknown.
    fn power(&self, i: usize, r: [f64; N]) -> [f64; N] {
        per_band(|b| self.targets[i] * self.root[i][b] * r[b].abs())
    }
}

/// All columns before the first iteration.
fn start_columns<const N: usize>(
    system: &LinearSystem,
    norm: &ResidualNorm<N>,
    sources: &[Vec<Bands>],
    initial: Option<&[Vec<Bands>]>,
    stop: StoppingCriterion,
) -> Vec<CgColumn<N>>
where
    CgColumn<N>: BandProducts<N>,
{
    let sources: Vec<BandVector<N>> = sources.iter().map(|s| first_bands(s)).collect();
    let initial: Option<Vec<BandVector<N>>> = initial.map(|i| i.iter().map(|s| first_bands(s)).collect());
    let start = initial.as_ref().unwrap_or(&sources);
    let products = CgColumn::<N>::products(system.operator, start);
    let one = |c: usize| {
        let (s0, s, g) = (&sources[c], &start[c], &products[c]);
        let root = norm.root;
        let over =
            |i: usize, b: usize| if root[i][b] > 0.0 { (s[i][b] - s0[i][b]) / root[i][b] } else { 0.0 };
        let y: BandVector<N> = (0..s.len()).into_par_iter().map(|i| per_band(|b| over(i, b))).collect();
        let r: BandVector<N> =
            g.par_iter().enumerate().map(|(i, g)| per_band(|b| root[i][b] * g[b] - y[i][b])).collect();
        let power = source_power(norm.targets, s0);
        let left = multivector::sum(r.len(), |i| norm.power(i, r[i]));
        let relative: [f64; N] = per_band(|b| if power[b] > 0.0 { left[b] / power[b] } else { 0.0 });
        let status = relative.map(|x| (x <= stop.residual).then_some(SolveStatus::Converged));
        CgColumn {
            rr: multivector::sum(r.len(), |i| r[i].map(|x| x * x)),
            p: r.clone(),
            y,
            r,
            power,
            status,
            residuals: relative.map(|x| vec![x]),
            best: [(f64::INFINITY, 0); N],
        }
    };
    (0..sources.len()).map(one).collect()
}

/// One iteration of a column, `product` = g √w p.
fn iterate_column<const N: usize>(
    c: &mut CgColumn<N>,
    norm: &ResidualNorm<N>,
    product: &[[f64; N]],
    iteration: usize,
    wanted: f64,
) {
    let root = norm.root;
    let q = |i: usize, p: [f64; N]| -> [f64; N] { per_band(|b| p[b] - root[i][b] * product[i][b]) };
    let pq: [f64; N] = multivector::sum(c.p.len(), |i| {
        let (p, q) = (c.p[i], q(i, c.p[i]));
        per_band(|b| p[b] * q[b])
    });
    let alpha: [f64; N] =
        per_band(|b| if c.status[b].is_none() && pq[b] > 0.0 { c.rr[b] / pq[b] } else { 0.0 });
    let parts: Vec<[[f64; N]; 2]> = (
        c.y.par_chunks_mut(multivector::CHUNK_LENGTH),
        c.r.par_chunks_mut(multivector::CHUNK_LENGTH),
        c.p.par_chunks(multivector::CHUNK_LENGTH),
    )
        .into_par_iter()
        .enumerate()
        .map(|(k, (y, r, p))| {
            let mut sums = [[0.0; N]; 2];
            for (j, ((y, r), p)) in y.iter_mut().zip(r).zip(p).enumerate() {
                let i = k * multivector::CHUNK_LENGTH + j;
                let q = q(i, *p);
                *y = per_band(|b| y[b] + alpha[b] * p[b]);
                *r = per_band(|b| r[b] - alpha[b] * q[b]);
                let left = norm.power(i, *r);
                sums = [per_band(|b| sums[0][b] + r[b] * r[b]), per_band(|b| sums[1][b] + left[b])];
            }
            sums
        })
        .collect();
    let total = |k: usize| parts.iter().fold([0.0; N], |s, p| per_band(|b| s[b] + p[k][b]));
    let (new, left) = (total(0), total(1));
    let beta: [f64; N] = per_band(|b| if c.rr[b] > 0.0 { new[b] / c.rr[b] } else { 0.0 });
    c.rr = new;
    c.p.par_iter_mut().zip(&c.r).for_each(|(p, r)| *p = per_band(|b| r[b] + beta[b] * p[b]));
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

/// True if the rounding of the strengths is below the residual. The residual is updated separately from the strengths; with almost no absorption the
/// strengths grow until their rounding leaves more power than the residual states.
fn is_representable<const N: usize>(c: &CgColumn<N>, norm: &ResidualNorm<N>, b: usize) -> bool {
    let whole = multivector::sum(c.y.len(), |i| norm.power(i, c.y[i]));
    f64::EPSILON * whole[b] <= c.residuals[b].last().map_or(0.0, |r| r.max(ROUNDING_RESIDUAL)) * c.power[b]
}

fn finish<const N: usize>(c: CgColumn<N>, root: &[[f64; N]], source: &[Bands]) -> IterationResult {
    let of = |b: usize| b.min(N - 1);
    let strength = |i: usize| bands(|b| source[i][b] + root[i][of(b)] * c.y[i][of(b)]);
    IterationResult {
        strengths: (0..source.len()).into_par_iter().map(strength).collect(),
        status: [0, 1, 2].map(|b| c.status[of(b)].unwrap_or(SolveStatus::MaxIterations)),
        residuals: [0, 1, 2].map(|b| c.residuals[of(b)].clone()),
        power: bands(|b| c.power[of(b)]),
    }
}

/// Encodes the state as a stage, the number of bands first.
fn encode_state<const N: usize>(all: &[CgColumn<N>], next: usize) -> Vec<u8> {
    let mut encoder = Encoder::default();
    encoder.int(N);
    encoder.int(next);
    for c in all {
        [&c.y, &c.r, &c.p].into_iter().for_each(|v| encoder.reals(v.as_flattened()));
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

/// Decodes a stage of [`encode_state`] for a number of columns and unknowns: the columns, and the next iteration.
fn decode_state<const N: usize>(
    bytes: &[u8],
    columns: usize,
    zones: usize,
) -> Option<(Vec<CgColumn<N>>, usize)> {
    let mut decoder = Decoder::new(bytes);
    let (bands, next) = (decoder.int()?, decoder.int()?);
    if bands != N {
        return None;
    }
    let mut all = Vec::new();
    for _ in 0..columns {
        let mut field = || -> Option<BandVector<N>> {
            let flat = decoder.reals()?;
            (flat.len() == N * zones).then(|| flat.as_chunks::<N>().0.to_vec())
        };
        let [y, rest, p] = [field()?, field()?, field()?];
        let (rr, power) = (decoder.reals()?.try_into().ok()?, decoder.reals()?.try_into().ok()?);
        let (mut status, mut residuals, mut best) = ([None; N], [const { Vec::new() }; N], [(0.0, 0); N]);
        for b in 0..N {
            let known = decoder.int()?;
            status[b] = if known == 0 { None } else { Some(*SolveStatus::VARIANTS.get(known - 1)?) };
            residuals[b] = decoder.reals()?;
            best[b] = (*decoder.reals()?.first()?, decoder.int()?);
        }
        all.push(CgColumn { y, r: rest, p, rr, power, status, residuals, best });
    }
    (decoder.at_end() && next > 0).then_some((all, next))
}

#[cfg(test)]
mod tests;
