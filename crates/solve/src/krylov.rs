//! Conjugate gradients for the zonal equations: many right-hand sides at once, with a status instead of silence.
//!
//! With strengths s = c B, sources s⁰ and w_i = c_i ρ_i/A_i (patch) or c_i Ω_i/(4 V_i) (volume) the equations read
//! s = s⁰ + w g s. Put s = s⁰ + √w y; then
//!
//! ```text
//!     (I − √w g √w) y = √w g s⁰,
//! ```
//!
//! symmetric, and positive definite as long as some power is lost. Each column (a light group) and band is a problem of its own with
//! its own steps and its own end; they run side by side so that the operator reads its factors once for all. One that is done rests.
//!
//! **The residual is power.** A residual r of y leaves δ = s⁰ + w g s − s = √w r in the strengths: power t_i δ_i that zone i should
//! send on and does not, t = A or 4V. As (I − w g)⁻¹ has no negative entry and power neither grows nor vanishes on its way, the
//! power of δ, wherever it would end, is at most
//!
//! ```text
//!     R = Σ_i t_i √w_i |r_i|            told relative to P = Σ_i t_i s⁰_i, the power that the sources give:
//! ```
//!
//! the norm of r that bounds what all zones together absorb too much or too little, in watts. That is why the iteration stops on
//! it and not on ‖r‖₂, which dark zones and small ones blur.
//!
//! **Warm start.** From strengths s near the solution: √w y = s − s⁰ where w > 0, r = √w g s − y; one product, as from nothing.
//!
//! **Sweeps.** [`sweeps`] follows the light segment by segment instead: s_k = s⁰ + w g s_{k−1}, so that N sweeps hold the light of at
//! most N segments between zones. After its N − 1 steps here, the field that arrives is the N-th product.

use crate::columns::{self, Columns};
use crate::operator::Operator;
use crate::stage::{Pen, Reader};
use rayon::prelude::*;
use zonal_scene::{Bands, Progress, SolveStatus, Vault, bands};

/// Iterations without a new smallest residual after which a band counts as stalled.
const PATIENCE: usize = 30;

/// Residual that rounding may leave of a solve that counts as converged, where less was asked for.
const MOST_ROUNDING: f64 = 1e-10;

/// Iterations between two states that are kept: little work is lost, and little time goes into keeping.
const KEEP_EVERY: usize = 10;

/// The equations: everything but the sources.
pub struct System<'a> {
    /// g.
    pub operator: &'a dyn Operator,
    /// w of every zone.
    pub weights: &'a [Bands],
    /// t of every zone: A of a patch, 4V of a volume zone; m² or m³.
    pub targets: &'a [f64],
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// R/P that is small enough.
    pub residual: f64,
    /// The most iterations.
    pub iterations: usize,
}

/// Where the iteration of one column ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Ended {
    /// Strengths, a zone.
    pub strengths: Vec<Bands>,
    /// Status, a band.
    pub status: [SolveStatus; 3],
    /// R/P before the first and after each iteration, a band.
    pub residuals: [Vec<f64>; 3],
    /// P, W a band.
    pub power: Bands,
}

/// One column on its way, in N bands: three, or one that stands for all.
#[derive(Clone, Debug, PartialEq)]
struct Column<const N: usize> {
    y: Vec<[f64; N]>,
    r: Vec<[f64; N]>,
    p: Vec<[f64; N]>,
    rr: [f64; N],
    power: [f64; N],
    status: [Option<SolveStatus>; N],
    residuals: [Vec<f64>; N],
    best: [(f64, usize); N],
}

impl<const N: usize> Column<N> {
    fn done(&self) -> bool {
        self.status.iter().all(Option::is_some)
    }
}

/// What differs with the number of bands.
trait Bundle<const N: usize>: Sized {
    /// g s of every column.
    fn products(operator: &dyn Operator, columns: &[Vec<[f64; N]>]) -> Vec<Vec<[f64; N]>>;
}

impl Bundle<3> for Column<3> {
    fn products(operator: &dyn Operator, columns: &[Columnar<3>]) -> Vec<Columnar<3>> {
        operator.apply_many(columns)
    }
}

impl Bundle<1> for Column<1> {
    fn products(operator: &dyn Operator, columns: &[Columnar<1>]) -> Vec<Columnar<1>> {
        columns.iter().map(|c| operator.apply_band(c)).collect()
    }
}

/// A vector over the zones in N bands.
type Columnar<const N: usize> = Vec<[f64; N]>;

fn each<const N: usize>(f: impl FnMut(usize) -> f64) -> [f64; N] {
    std::array::from_fn(f)
}

/// The first N bands of a vector.
fn first<const N: usize>(v: &[Bands]) -> Columnar<N> {
    v.par_iter().map(|x| each(|b| x[b])).collect()
}

/// P = Σ t s⁰, W a band.
pub fn power<const N: usize>(targets: &[f64], source: &[[f64; N]]) -> [f64; N] {
    columns::sum(source.len(), |i| source[i].map(|s| targets[i] * s.abs()))
}

/// True where the bands of all entries have the same bits.
fn grey(v: &[Bands]) -> bool {
    v.par_iter().all(|x| x[0].to_bits() == x[1].to_bits() && x[0].to_bits() == x[2].to_bits())
}

/// Solves s = s⁰ + w g s for every column of `sources`, from `initial` strengths if there are any; bands that are alike in everything once.
///
/// The state is kept in `vault` every so often, as stage `state-krylov`, and taken up from there.
pub fn solve(
    system: &System,
    sources: &[Vec<Bands>],
    initial: Option<&[Vec<Bands>]>,
    stop: Stop,
    vault: &dyn Vault,
    progress: &dyn Progress,
) -> Vec<Ended> {
    let all = || sources.iter().chain(initial.unwrap_or_default());
    let one = system.operator.one_band() && grey(system.weights) && all().all(|v| grey(v));
    match one {
        true => solve_bands::<1>(system, sources, initial, stop, vault, progress),
        false => solve_bands::<3>(system, sources, initial, stop, vault, progress),
    }
}

fn solve_bands<const N: usize>(
    system: &System,
    sources: &[Vec<Bands>],
    initial: Option<&[Vec<Bands>]>,
    stop: Stop,
    vault: &dyn Vault,
    progress: &dyn Progress,
) -> Vec<Ended>
where
    Column<N>: Bundle<N>,
{
    let root: Columnar<N> = system.weights.par_iter().map(|w| each(|b| w[b].sqrt())).collect();
    let weight = Weight { root: &root, targets: system.targets };
    progress.begin("solving", stop.iterations as u64);
    let kept = vault.load(STAGE).and_then(|b| restored::<N>(&b, sources.len(), root.len()));
    let (mut all, first) = kept.unwrap_or_else(|| (begun(system, &weight, sources, initial, stop), 1));
    progress.advance(first as u64 - 1);
    for iteration in first..=stop.iterations {
        let active: Vec<usize> = (0..all.len()).filter(|&c| !all[c].done()).collect();
        if active.is_empty() {
            break;
        }
        let inside: Vec<Columnar<N>> = active.iter().map(|&c| columns::times(&root, &all[c].p)).collect();
        let products = Column::<N>::products(system.operator, &inside);
        drop(inside);
        for (&c, product) in active.iter().zip(&products) {
            step(&mut all[c], &weight, product, iteration, stop.residual);
        }
        if vault.keeps() && iteration % KEEP_EVERY == 0 {
            vault.save(STAGE, &kept_state(&all, iteration + 1));
        }
        progress.advance(1);
    }
    progress.end();
    all.into_iter().zip(sources).map(|(c, s)| ended(c, &root, s)).collect()
}

/// The name of the stage.
const STAGE: &str = "state-krylov";

struct Weight<'a, const N: usize> {
    root: &'a [[f64; N]],
    targets: &'a [f64],
}

impl<const N: usize> Weight<'_, N> {
    /// t √w |r| of a zone.
    fn left(&self, i: usize, r: [f64; N]) -> [f64; N] {
        each(|b| self.targets[i] * self.root[i][b] * r[b].abs())
    }
}

/// The columns before the first iteration.
fn begun<const N: usize>(
    system: &System,
    weight: &Weight<N>,
    sources: &[Vec<Bands>],
    initial: Option<&[Vec<Bands>]>,
    stop: Stop,
) -> Vec<Column<N>>
where
    Column<N>: Bundle<N>,
{
    let sources: Vec<Columnar<N>> = sources.iter().map(|s| first(s)).collect();
    let initial: Option<Vec<Columnar<N>>> = initial.map(|i| i.iter().map(|s| first(s)).collect());
    let start = initial.as_ref().unwrap_or(&sources);
    let products = Column::<N>::products(system.operator, start);
    let one = |c: usize| {
        let (s0, s, g) = (&sources[c], &start[c], &products[c]);
        let root = weight.root;
        let over =
            |i: usize, b: usize| if root[i][b] > 0.0 { (s[i][b] - s0[i][b]) / root[i][b] } else { 0.0 };
        let y: Columnar<N> = (0..s.len()).into_par_iter().map(|i| each(|b| over(i, b))).collect();
        let r: Columnar<N> =
            g.par_iter().enumerate().map(|(i, g)| each(|b| root[i][b] * g[b] - y[i][b])).collect();
        let power = power(weight.targets, s0);
        let left = columns::sum(r.len(), |i| weight.left(i, r[i]));
        let relative: [f64; N] = each(|b| if power[b] > 0.0 { left[b] / power[b] } else { 0.0 });
        let status = relative.map(|x| (x <= stop.residual).then_some(SolveStatus::Converged));
        Column {
            rr: columns::sum(r.len(), |i| r[i].map(|x| x * x)),
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
fn step<const N: usize>(
    c: &mut Column<N>,
    weight: &Weight<N>,
    product: &[[f64; N]],
    iteration: usize,
    wanted: f64,
) {
    let root = weight.root;
    let q = |i: usize, p: [f64; N]| -> [f64; N] { each(|b| p[b] - root[i][b] * product[i][b]) };
    let pq: [f64; N] = columns::sum(c.p.len(), |i| {
        let (p, q) = (c.p[i], q(i, c.p[i]));
        each(|b| p[b] * q[b])
    });
    let alpha: [f64; N] = each(|b| if c.status[b].is_none() && pq[b] > 0.0 { c.rr[b] / pq[b] } else { 0.0 });
    let parts: Vec<[[f64; N]; 2]> = (
        c.y.par_chunks_mut(columns::CHUNK),
        c.r.par_chunks_mut(columns::CHUNK),
        c.p.par_chunks(columns::CHUNK),
    )
        .into_par_iter()
        .enumerate()
        .map(|(k, (y, r, p))| {
            let mut sums = [[0.0; N]; 2];
            for (j, ((y, r), p)) in y.iter_mut().zip(r).zip(p).enumerate() {
                let i = k * columns::CHUNK + j;
                let q = q(i, *p);
                *y = each(|b| y[b] + alpha[b] * p[b]);
                *r = each(|b| r[b] - alpha[b] * q[b]);
                let left = weight.left(i, *r);
                sums = [each(|b| sums[0][b] + r[b] * r[b]), each(|b| sums[1][b] + left[b])];
            }
            sums
        })
        .collect();
    let total = |k: usize| parts.iter().fold([0.0; N], |s, p| each(|b| s[b] + p[k][b]));
    let (new, left) = (total(0), total(1));
    let beta: [f64; N] = each(|b| if c.rr[b] > 0.0 { new[b] / c.rr[b] } else { 0.0 });
    c.rr = new;
    c.p.par_iter_mut().zip(&c.r).for_each(|(p, r)| *p = each(|b| r[b] + beta[b] * p[b]));
    for b in (0..N).filter(|&b| c.status[b].is_none()).collect::<Vec<_>>() {
        let relative = left[b] / c.power[b];
        c.residuals[b].push(relative);
        if relative < c.best[b].0 {
            c.best[b] = (relative, iteration);
        }
        if relative <= wanted {
            c.status[b] =
                Some(if carried(c, weight, b) { SolveStatus::Converged } else { SolveStatus::Stalled });
        } else if !relative.is_finite() || pq[b] <= 0.0 || iteration - c.best[b].1 > PATIENCE {
            c.status[b] = Some(SolveStatus::Stalled);
        }
    }
}

/// True where the strengths can carry the residual that the iteration tells: it is kept apart from them, and where next to nothing is absorbed
/// they grow until their own rounding leaves more power than that.
fn carried<const N: usize>(c: &Column<N>, weight: &Weight<N>, b: usize) -> bool {
    let whole = columns::sum(c.y.len(), |i| weight.left(i, c.y[i]));
    f64::EPSILON * whole[b] <= c.residuals[b].last().map_or(0.0, |r| r.max(MOST_ROUNDING)) * c.power[b]
}

fn ended<const N: usize>(c: Column<N>, root: &[[f64; N]], source: &[Bands]) -> Ended {
    let of = |b: usize| b.min(N - 1);
    let strength = |i: usize| bands(|b| source[i][b] + root[i][of(b)] * c.y[i][of(b)]);
    Ended {
        strengths: (0..source.len()).into_par_iter().map(strength).collect(),
        status: [0, 1, 2].map(|b| c.status[of(b)].unwrap_or(SolveStatus::Budget)),
        residuals: [0, 1, 2].map(|b| c.residuals[of(b)].clone()),
        power: bands(|b| c.power[of(b)]),
    }
}

/// `count` − 1 steps of the Neumann series from the sources; see the header. The state is kept in `vault` as stage `state-sweeps`.
pub fn sweeps(
    system: &System,
    sources: &[Vec<Bands>],
    count: usize,
    vault: &dyn Vault,
    progress: &dyn Progress,
) -> Vec<Ended> {
    let all: Vec<Ended> = sources
        .iter()
        .map(|s| Ended {
            strengths: s.clone(),
            status: [SolveStatus::Swept; 3],
            residuals: Default::default(),
            power: power(system.targets, s),
        })
        .collect();
    progress.begin("sweeping", count as u64);
    let kept = vault.load(SWEEPS).and_then(|b| swept(&b, &all)).filter(|s| s.1 <= count);
    let (mut all, first) = kept.unwrap_or((all, 1));
    progress.advance(first as u64 - 1);
    for sweep in first..=count {
        let now: Columns = all.iter().map(|e| e.strengths.clone()).collect();
        let products = system.operator.apply_many(&now);
        for ((e, g), s0) in all.iter_mut().zip(&products).zip(sources) {
            let next = |i: usize| bands(|b| s0[i][b] + system.weights[i][b] * g[i][b]);
            // What the next step would still bring.
            let left = columns::sum(s0.len(), |i| {
                let n = next(i);
                bands(|b| system.targets[i] * (n[b] - e.strengths[i][b]).abs())
            });
            (0..3).for_each(|b| {
                e.residuals[b].push(if e.power[b] > 0.0 { left[b] / e.power[b] } else { 0.0 });
            });
            if sweep < count {
                e.strengths = (0..s0.len()).into_par_iter().map(next).collect();
            }
        }
        if vault.keeps() && sweep < count && sweep % KEEP_EVERY == 0 {
            vault.save(SWEEPS, &kept_sweeps(&all, sweep + 1));
        }
        progress.advance(1);
    }
    progress.end();
    all
}

/// The name of the stage of sweeps.
const SWEEPS: &str = "state-sweeps";

fn kept_sweeps(all: &[Ended], next: usize) -> Vec<u8> {
    let mut pen = Pen::default();
    pen.int(next);
    for e in all {
        pen.triples(&e.strengths);
        e.residuals.iter().for_each(|r| pen.reals(r));
    }
    pen.bytes()
}

/// The state that [`kept_sweeps`] wrote, put into the `fresh` one, and the sweep that is next.
fn swept(bytes: &[u8], fresh: &[Ended]) -> Option<(Vec<Ended>, usize)> {
    let mut r = Reader::new(bytes);
    let next = r.int()?;
    let mut all = Vec::new();
    for f in fresh {
        let strengths = r.triples().filter(|s| s.len() == f.strengths.len())?;
        let residuals = [r.reals()?, r.reals()?, r.reals()?];
        all.push(Ended { strengths, residuals, status: f.status, power: f.power });
    }
    (r.at_end() && next > 0).then_some((all, next))
}

/// The state as a stage, the number of bands first.
fn kept_state<const N: usize>(all: &[Column<N>], next: usize) -> Vec<u8> {
    let mut pen = Pen::default();
    pen.int(N);
    pen.int(next);
    for c in all {
        [&c.y, &c.r, &c.p].into_iter().for_each(|v| pen.reals(v.as_flattened()));
        pen.reals(&c.rr);
        pen.reals(&c.power);
        for b in 0..N {
            pen.int(
                c.status[b].map_or(0, |s| 1 + SolveStatus::ALL.iter().position(|x| *x == s).unwrap_or(0)),
            );
            pen.reals(&c.residuals[b]);
            pen.reals(&[c.best[b].0]);
            pen.int(c.best[b].1);
        }
    }
    pen.bytes()
}

/// The state that [`kept_state`] wrote, for so many columns and zones, and the iteration that is next.
fn restored<const N: usize>(bytes: &[u8], columns: usize, zones: usize) -> Option<(Vec<Column<N>>, usize)> {
    let mut r = Reader::new(bytes);
    let (bands, next) = (r.int()?, r.int()?);
    if bands != N {
        return None;
    }
    let mut all = Vec::new();
    for _ in 0..columns {
        let mut field = || -> Option<Columnar<N>> {
            let flat = r.reals()?;
            (flat.len() == N * zones).then(|| flat.as_chunks::<N>().0.to_vec())
        };
        let [y, rest, p] = [field()?, field()?, field()?];
        let (rr, power) = (r.reals()?.try_into().ok()?, r.reals()?.try_into().ok()?);
        let (mut status, mut residuals, mut best) = ([None; N], [const { Vec::new() }; N], [(0.0, 0); N]);
        for b in 0..N {
            let known = r.int()?;
            status[b] = if known == 0 { None } else { Some(*SolveStatus::ALL.get(known - 1)?) };
            residuals[b] = r.reals()?;
            best[b] = (*r.reals()?.first()?, r.int()?);
        }
        all.push(Column { y, r: rest, p, rr, power, status, residuals, best });
    }
    (r.at_end() && next > 0).then_some((all, next))
}

#[cfg(test)]
mod tests;
