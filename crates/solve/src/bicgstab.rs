//! Stabilised bi-conjugate gradients for the zonal equations with an operator that is not symmetric, as rays sampled zone by zone give it
//! (H. A. van der Vorst, SIAM J. Sci. Stat. Comput. 13, 1992).
//!
//! With strengths s, sources s⁰ and weights w as in [`crate::krylov`] the equations are A s = s⁰, A = I − w g. One iteration takes two
//! products. From the residual r = s⁰ − A s, a fixed shadow q and a direction p:
//!
//! ```text
//!     v = A p,   α = ⟨q, r⟩/⟨q, v⟩,   h = r − α v,   t = A h,   ω = ⟨t, h⟩/⟨t, t⟩
//!     s += α p + ω h,   r' = h − ω t,   p' = r' + (⟨q, r'⟩/⟨q, r⟩)(α/ω)(p − ω v)
//! ```
//!
//! Inner products are Σ x y/w: in them w g is symmetric but for its noise.
//!
//! **End.** The residual is a power R as in [`crate::krylov`], told relative to the power P of the sources. What is still missing of the solution
//! is A⁻¹ r, which in a cavity that hardly anything enters or leaves is many times r. Steps tell how many times: one that changes the strengths by
//! Δs changes the residual by −A Δs, and the largest ‖Δs‖/‖A Δs‖ met is taken for ‖A⁻¹‖. The iteration ends where R/P max(1, ‖A⁻¹‖ P/‖s‖), the error
//! of the strengths relative to all of them, is small enough and a product of its own confirms the residual.
//!
//! **Trouble.** Where an inner product vanishes, a residual is no number or a product finds another one than the iteration tells, the iteration begins
//! again from the best strengths that it has met. Where that led nowhere, light is first passed on a few times, s += r, which makes no residual larger
//! where no zone sends on more than it receives.

use crate::columns::{self, Columns};
use crate::krylov::{Ended, Stop, System, power};
use rayon::prelude::*;
use zonal_scene::{Bands, Progress, SolveStatus, bands};

/// Beginnings at most.
const MAX_RESTARTS: usize = 6;
/// Passes of light before the next beginning, where the last one did not halve the residual.
const PASSES: usize = 4;
/// How far below zero strengths may be where no source is, over their mean.
const MOST_BELOW: f64 = 0.01;
/// How many times the wanted residual a product may find where the iteration tells that it is met.
const DRIFT: f64 = 2.0;

/// Solves s = s⁰ + w g s for every column of `sources`, from `initial` strengths if there are any. `stop.iterations` limits the products of a column.
pub(crate) fn solve(
    system: &System,
    sources: &[Vec<Bands>],
    initial: Option<Columns>,
    stop: Stop,
    progress: &dyn Progress,
) -> Vec<Ended> {
    let start = initial.unwrap_or_else(|| sources.to_vec());
    progress.begin("solving", 0);
    let one = |(s0, start): (&Vec<Bands>, Vec<Bands>)| {
        let mut column = Column::new(system, s0, start, stop, progress);
        column.run();
        column.ended()
    };
    let all = sources.iter().zip(start).map(one).collect();
    progress.end();
    all
}

/// One column on its way.
struct Column<'a> {
    system: &'a System<'a>,
    source: &'a [Bands],
    stop: Stop,
    progress: &'a dyn Progress,
    /// s, and s⁰ + w g s − s of it.
    strengths: Vec<Bands>,
    residual: Vec<Bands>,
    /// The strengths with the smallest residual since the last beginning; that, R/P; and ‖s‖/P of them.
    best: Vec<Bands>,
    least: Bands,
    size: Bands,
    /// P.
    power: Bands,
    /// The largest ‖Δs‖/‖A Δs‖ met.
    inverse: Bands,
    residuals: [Vec<f64>; 3],
    products: usize,
    iterations: usize,
}

/// ‖x‖ = Σ t |x|, a band; W.
fn norm(targets: &[f64], x: impl Fn(usize) -> Bands + Sync) -> Bands {
    columns::sum(targets.len(), |i| x(i).map(|x| targets[i] * x.abs()))
}

/// a/b, 0 where that is no number.
fn ratio(a: Bands, b: Bands) -> Bands {
    bands(|k| {
        let q = a[k] / b[k];
        if q.is_finite() { q } else { 0.0 }
    })
}

impl<'a> Column<'a> {
    fn new(
        system: &'a System,
        source: &'a [Bands],
        mut start: Vec<Bands>,
        stop: Stop,
        progress: &'a dyn Progress,
    ) -> Column<'a> {
        let power = power(system.targets, source);
        // What sends nothing on shines as its source does, and nothing shines where there is no source.
        let free = |i: usize, b: usize| system.weights[i][b] > 0.0 && power[b] > 0.0;
        let given = |i: usize, s: &mut Bands| *s = bands(|b| if free(i, b) { s[b] } else { source[i][b] });
        start.par_iter_mut().enumerate().for_each(|(i, s)| given(i, s));
        Column {
            power,
            best: start.clone(),
            least: [f64::INFINITY; 3],
            size: [1.0; 3],
            inverse: [0.0; 3],
            residuals: Default::default(),
            products: 0,
            iterations: 0,
            residual: Vec::new(),
            strengths: start,
            system,
            source,
            stop,
            progress,
        }
    }

    /// Begins again until the residual is confirmed to be small enough, or the budget is spent.
    fn run(&mut self) {
        self.begin();
        for _ in 0..MAX_RESTARTS {
            if self.met(DRIFT) == [true; 3] && self.iterations > 0 || self.spent(3) {
                break;
            }
            let before = self.least;
            self.iterate();
            self.strengths.clone_from(&self.best);
            self.begin();
            let met = self.met(DRIFT);
            if (0..3).all(|b| met[b] || self.least[b] > 0.5 * before[b]) && met != [true; 3] {
                (0..PASSES).for_each(|_| self.pass_on());
            }
        }
        // The product that confirmed the residual has paid for this.
        self.pass();
    }

    /// s += r, and the residual of that.
    fn pass_on(&mut self) {
        if !self.spent(1) {
            self.pass();
            self.begin();
        }
    }

    fn spent(&self, more: usize) -> bool {
        self.products + more > self.stop.iterations
    }

    /// v − w g v.
    fn times(&mut self, v: &[Bands]) -> Vec<Bands> {
        let mut product = self.system.operator.apply(v);
        let w = self.system.weights;
        let put = |i: usize, g: &mut Bands| *g = bands(|b| v[i][b] - w[i][b] * g[b]);
        product.par_iter_mut().enumerate().for_each(|(i, g)| put(i, g));
        self.products += 1;
        self.progress.advance(1);
        product
    }

    /// The residual of the strengths by a product of its own.
    fn begin(&mut self) {
        let strengths = std::mem::take(&mut self.strengths);
        let mut product = self.times(&strengths);
        let source = self.source;
        product.par_iter_mut().zip(source).for_each(|(r, s)| *r = bands(|b| s[b] - r[b]));
        (self.strengths, self.residual) = (strengths, product);
        // A residual that was told is replaced by one that was measured.
        self.least = [f64::INFINITY; 3];
        self.note();
    }

    /// Takes down R/P of the residual, and the strengths where it is the smallest yet.
    fn note(&mut self) {
        let (targets, power) = (self.system.targets, self.power);
        let over = |x: Bands| bands(|b| if power[b] > 0.0 { x[b] / power[b] } else { 0.0 });
        let (s, r) = (&self.strengths, &self.residual);
        let (share, size) = (over(norm(targets, |i| r[i])), over(norm(targets, |i| s[i])));
        let better = [0, 1, 2].map(|b| share[b] < self.least[b]);
        for b in 0..3 {
            self.residuals[b].push(share[b]);
            if better[b] {
                (self.least[b], self.size[b]) = (share[b], size[b]);
            }
        }
        let kept =
            |(best, s): (&mut Bands, &Bands)| *best = bands(|b| if better[b] { s[b] } else { best[b] });
        self.best.par_iter_mut().zip(&self.strengths).for_each(kept);
    }

    /// Where the error that the smallest residual leaves is at most `times` what is wanted.
    fn met(&self, times: f64) -> [bool; 3] {
        let grown = ratio(self.inverse, self.size);
        [0, 1, 2].map(|b| self.least[b] * grown[b].max(1.0) <= times * self.stop.residual)
    }

    /// s += r.
    fn pass(&mut self) {
        self.strengths.par_iter_mut().zip(&self.residual).for_each(|(s, r)| *s = bands(|b| s[b] + r[b]));
    }

    /// Iterations from the residual at hand until every band is met or broken down, or the budget is spent.
    fn iterate(&mut self) {
        let (weights, targets) = (self.system.weights, self.system.targets);
        let over =
            |i: usize, x: Bands| bands(|b| if weights[i][b] > 0.0 { x[b] / weights[i][b] } else { 0.0 });
        let product = |x: &[Bands], y: &[Bands]| -> Bands {
            columns::sum(x.len(), |i| over(i, bands(|b| x[i][b] * y[i][b])))
        };
        let shadow = self.residual.clone();
        let mut direction = shadow.clone();
        let mut rho = product(&shadow, &shadow);
        let mut open = rho.map(|x| x > 0.0 && x.is_finite());
        while open != [false; 3] && !self.spent(3) {
            let v = self.times(&direction);
            let alpha = ratio(rho, product(&shadow, &v));
            let alpha = bands(|b| if open[b] { alpha[b] } else { 0.0 });
            let mut h = std::mem::take(&mut self.residual);
            h.par_iter_mut().zip(&v).for_each(|(h, v)| *h = bands(|b| h[b] - alpha[b] * v[b]));
            let t = self.times(&h);
            let omega = ratio(product(&t, &h), product(&t, &t));
            let omega = bands(|b| if alpha[b] != 0.0 { omega[b] } else { 0.0 });
            // Of what the step changes in the strengths, and in the residual.
            let step = |i: usize| bands(|b| alpha[b] * direction[i][b] + omega[b] * h[i][b]);
            let change = |i: usize| bands(|b| alpha[b] * v[i][b] + omega[b] * t[i][b]);
            let inverse = ratio(norm(targets, step), norm(targets, change));
            self.inverse = bands(|b| self.inverse[b].max(inverse[b]));
            let add = |i: usize, s: &mut Bands| {
                let d = step(i);
                *s = bands(|b| s[b] + d[b]);
            };
            self.strengths.par_iter_mut().enumerate().for_each(|(i, s)| add(i, s));
            h.par_iter_mut().zip(&t).for_each(|(h, t)| *h = bands(|b| h[b] - omega[b] * t[b]));
            self.residual = h;
            self.iterations += 1;
            self.note();
            let next = product(&shadow, &self.residual);
            let beta = bands(|b| ratio(next, rho)[b] * ratio(alpha, omega)[b]);
            let r = &self.residual;
            let turned = |i: usize, p: &mut Bands| {
                *p = bands(|b| r[i][b] + beta[b] * (p[b] - omega[b] * v[i][b]));
            };
            direction.par_iter_mut().enumerate().for_each(|(i, p)| turned(i, p));
            rho = next;
            let met = self.met(1.0);
            open = [0, 1, 2].map(|b| beta[b] != 0.0 && !met[b]);
        }
    }

    fn ended(self) -> Ended {
        let (met, sound) = (self.met(DRIFT), self.sound());
        let status = [0, 1, 2].map(|b| match (met[b], sound[b]) {
            (_, false) => SolveStatus::Stalled,
            (true, _) => SolveStatus::Converged,
            (false, _) => SolveStatus::Budget,
        });
        Ended { strengths: self.strengths, status, residuals: self.residuals, power: self.power }
    }

    /// Where the strengths are those of light: with no source below zero none of them is, beyond what may be missing. The equations of a cavity
    /// in which noise makes more light than is absorbed have a solution, which is not one.
    fn sound(&self) -> [bool; 3] {
        let least = |v: &[Bands], b: usize| v.iter().fold(0.0f64, |m, x| if x[b] < m { x[b] } else { m });
        let all = &self.strengths;
        let sum = columns::sum(all.len(), |i| all[i].map(f64::abs));
        [0, 1, 2].map(|b| {
            let floor = -MOST_BELOW * sum[b] / all.len().max(1) as f64;
            least(self.source, b) < 0.0 || least(all, b) >= floor
        })
    }
}

#[cfg(test)]
mod tests;
