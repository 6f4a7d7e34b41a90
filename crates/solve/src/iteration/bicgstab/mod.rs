//! Stabilised bi-conjugate gradients for the zonal equations with an operator that is not symmetric, such as one sampled by rays of each zone
//! (H. A. van der Vorst, SIAM J. Sci. Stat. Comput. 13, 1992).
//!
//! With strengths s, sources s⁰ and weights w as in [`super::conjugate_gradients`] the equations are A s = s⁰, A = I − w g. One iteration takes two
//! products. From the residual r = s⁰ − A s, a fixed shadow residual q and a direction p:
//!
//! ```text
//!     v = A p,   α = ⟨q, r⟩/⟨q, v⟩,   h = r − α v,   t = A h,   ω = ⟨t, h⟩/⟨t, t⟩
//!     s += α p + ω h,   r' = h − ω t,   p' = r' + (⟨q, r'⟩/⟨q, r⟩)(α/ω)(p − ω v)
//! ```
//!
//! Inner products are Σ x y/w: in them w g is symmetric but for its noise.
//!
//! **Stopping.** The residual is a power R as in [`super::conjugate_gradients`], relative to the power P of the sources. The error of the solution is
//! A⁻¹ r, which is many times r in a cavity with little absorption. A step that changes the strengths by Δs changes the residual by −A Δs; the
//! largest ‖Δs‖/‖A Δs‖ estimates ‖A⁻¹‖. The iteration ends when R/P max(1, ‖A⁻¹‖ P/‖s‖), the relative error of the strengths, meets the
//! criterion and a product confirms the residual.
//!
//! **Breakdown.** If an inner product vanishes, a residual is not finite or a product contradicts the recursive residual, the iteration restarts from
//! the best strengths. After a restart without progress a few relaxation steps s += r come first, which increase no residual as long as no zone
//! reflects more than it receives.

use super::linear_system::{IterationResult, LinearSystem, StoppingCriterion, source_power};
use crate::distribution::multivector::{self, MultiVector};
use zonal_math::parallel;
use zonal_scene::{Band, Bands, PerBand, Progress, SolveStatus};

/// Maximum number of restarts.
const MAX_RESTARTS: usize = 6;
/// Products of one iteration and the check after it.
const PRODUCTS_OF_ITERATION: usize = 3;
/// Relaxation steps before a restart if the last one did not halve the residual.
const RELAXATION_STEPS: usize = 4;
/// Largest negative strength over the mean strength, in bands without negative sources.
const MAX_UNDERSHOOT_OVER_MEAN: f64 = 0.01;
/// Largest measured residual over the criterion when the recursive residual meets it.
const RESIDUAL_DRIFT: f64 = 2.0;

/// Solves s = s⁰ + w g s for every column of `sources`, from the `initial` strengths if there are any. `stop.max_iterations` limits the products of a
/// column.
pub(crate) fn solve(
    system: &LinearSystem,
    sources: &[Vec<Bands>],
    initial: Option<MultiVector>,
    stop: StoppingCriterion,
    progress: &dyn Progress,
) -> Vec<IterationResult> {
    let start = initial.unwrap_or_else(|| sources.to_vec());
    progress.begin("solving", 0);
    let one = |(s0, start): (&Vec<Bands>, Vec<Bands>)| {
        let mut column = BicgstabColumn::new(system, s0, start, stop, progress);
        column.run();
        column.finish()
    };
    let all = sources.iter().zip(start).map(one).collect();
    progress.end();
    all
}

/// Iteration of one column.
struct BicgstabColumn<'a> {
    system: &'a LinearSystem<'a>,
    source: &'a [Bands],
    stop: StoppingCriterion,
    progress: &'a dyn Progress,
    /// s, and its residual s⁰ + w g s − s.
    strengths: Vec<Bands>,
    residual: Vec<Bands>,
    /// The strengths with the smallest residual since the last restart; that residual R/P; and their norm ‖s‖/P.
    best: Vec<Bands>,
    best_residual: Bands,
    best_norm: Bands,
    /// P.
    power: Bands,
    /// Estimate of ‖A⁻¹‖: the largest ‖Δs‖/‖A Δs‖.
    inverse_norm: Bands,
    residuals: PerBand<Vec<f64>>,
    products: usize,
    iterations: usize,
}

/// ‖x‖ = Σ t |x|, a band; W.
fn norm(targets: &[f64], x: impl Fn(usize) -> Bands + Sync) -> Bands {
    multivector::sum(targets.len(), |i| x(i).map(|x| targets[i] * x.abs()))
}

/// a/b, 0 if that is not finite.
#[inline]
fn ratio(a: Bands, b: Bands) -> Bands {
    (a / b).map(|q| if q.is_finite() { q } else { 0.0 })
}

impl<'a> BicgstabColumn<'a> {
    fn new(
        system: &'a LinearSystem,
        source: &'a [Bands],
        mut start: Vec<Bands>,
        stop: StoppingCriterion,
        progress: &'a dyn Progress,
    ) -> BicgstabColumn<'a> {
        let power = source_power(system.targets, source, system.sums);
        // Zones without reflection have the strengths of their sources; bands without sources are zero.
        let free = |i: usize, b: Band| system.weights[i][b] > 0.0 && power[b] > 0.0;
        let given =
            |i: usize, s: &mut Bands| *s = Bands::from_fn(|b| if free(i, b) { s[b] } else { source[i][b] });
        parallel::for_each(&mut start, |i, s| given(i, s));
        BicgstabColumn {
            power,
            best: start.clone(),
            best_residual: Bands::splat(f64::INFINITY),
            best_norm: Bands::ONE,
            inverse_norm: Bands::ZERO,
            residuals: PerBand::default(),
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

    /// Restarts until a product confirms a residual below the criterion, or the maximum of products is reached.
    fn run(&mut self) {
        self.measure_residual();
        for _ in 0..MAX_RESTARTS {
            if self.has_converged(RESIDUAL_DRIFT).all(|met| met) && self.iterations > 0
                || self.is_spent(PRODUCTS_OF_ITERATION)
            {
                break;
            }
            let before = self.best_residual;
            self.iterate();
            self.strengths.clone_from(&self.best);
            self.measure_residual();
            let met = self.has_converged(RESIDUAL_DRIFT);
            let stagnates = Band::all().all(|b| met[b] || self.best_residual[b] > 0.5 * before[b]);
            if stagnates && !met.all(|met| met) {
                (0..RELAXATION_STEPS).for_each(|_| self.relax_and_measure());
            }
        }
        // Relax once more by the measured residual, without a further product.
        self.relax();
    }

    /// A relaxation step (s += r), and its residual by a product.
    fn relax_and_measure(&mut self) {
        if !self.is_spent(1) {
            self.relax();
            self.measure_residual();
        }
    }

    /// True if `more` products exceed the maximum, or if the observer interrupts the solve.
    fn is_spent(&self, more: usize) -> bool {
        self.products + more > self.stop.max_iterations || self.progress.is_interrupted()
    }

    /// A v = v − w g v.
    fn apply_system(&mut self, v: &[Bands]) -> Vec<Bands> {
        let mut product = self.system.operator.apply(v);
        let w = &self.system.weights;
        let put = |i: usize, g: &mut Bands| *g = v[i] - w[i] * *g;
        parallel::for_each(&mut product, |i, g| put(i, g));
        self.products += 1;
        self.progress.advance(1);
        product
    }

    /// Computes the residual of the strengths by a product.
    fn measure_residual(&mut self) {
        let strengths = std::mem::take(&mut self.strengths);
        let mut product = self.apply_system(&strengths);
        let source = self.source;
        parallel::for_each_pair(&mut product, source, |r, s| *r = s - *r);
        (self.strengths, self.residual) = (strengths, product);
        // The measured residual replaces the recursive one.
        self.best_residual = Bands::splat(f64::INFINITY);
        self.record();
    }

    /// Records R/P of the residual, and the strengths where it is the smallest so far.
    fn record(&mut self) {
        let (targets, power) = (self.system.targets, self.power);
        let over = |x: Bands| x.zip_map(power, |x, p| if p > 0.0 { x / p } else { 0.0 });
        let (s, r) = (&self.strengths, &self.residual);
        let (share, size) = (over(norm(targets, |i| r[i])), over(norm(targets, |i| s[i])));
        let better = PerBand::from_fn(|b| share[b] < self.best_residual[b]);
        for b in Band::all() {
            self.residuals[b].push(share[b]);
            if better[b] {
                (self.best_residual[b], self.best_norm[b]) = (share[b], size[b]);
            }
        }
        let kept =
            |best: &mut Bands, s: &Bands| *best = Bands::from_fn(|b| if better[b] { s[b] } else { best[b] });
        parallel::for_each_pair(&mut self.best, &self.strengths, kept);
    }

    /// In which bands the error of the smallest residual is at most `times` the criterion.
    fn has_converged(&self, times: f64) -> PerBand<bool> {
        let grown = ratio(self.inverse_norm, self.best_norm);
        (self.best_residual * grown.map(|g| g.max(1.0))).map(|error| error <= times * self.stop.residual)
    }

    /// A relaxation step: s += r.
    fn relax(&mut self) {
        parallel::for_each_pair(&mut self.strengths, &self.residual, |s, r| *s += r);
    }

    /// Iterates from the current residual until every band has converged or broken down, or the maximum of products is reached.
    fn iterate(&mut self) {
        let (weights, targets) = (&self.system.weights, self.system.targets);
        let over = |i: usize, x: Bands| x.zip_map(weights[i], |x, w| if w > 0.0 { x / w } else { 0.0 });
        let product =
            |x: &[Bands], y: &[Bands]| -> Bands { multivector::sum(x.len(), |i| over(i, x[i] * y[i])) };
        let copy = || parallel::map(&self.residual, |r| *r);
        let (shadow, mut direction) = (copy(), copy());
        let mut rho = product(&shadow, &shadow);
        let mut open = rho.map(|x| x > 0.0 && x.is_finite());
        while open.any(|open| open) && !self.is_spent(PRODUCTS_OF_ITERATION) {
            let v = self.apply_system(&direction);
            let alpha = ratio(rho, product(&shadow, &v));
            let alpha = Bands::from_fn(|b| if open[b] { alpha[b] } else { 0.0 });
            let mut h = std::mem::take(&mut self.residual);
            parallel::for_each_pair(&mut h, &v, |h, v| *h -= alpha * v);
            let t = self.apply_system(&h);
            let omega = ratio(product(&t, &h), product(&t, &t));
            let omega = omega.zip_map(alpha, |omega, alpha| if alpha != 0.0 { omega } else { 0.0 });
            // Update ‖A⁻¹‖ by the changes of strengths and residual in this step.
            let step = |i: usize| alpha * direction[i] + omega * h[i];
            let change = |i: usize| alpha * v[i] + omega * t[i];
            let inverse = ratio(norm(targets, step), norm(targets, change));
            self.inverse_norm = self.inverse_norm.max(inverse);
            parallel::for_each(&mut self.strengths, |i, s| *s += step(i));
            parallel::for_each_pair(&mut h, &t, |h, t| *h -= omega * t);
            self.residual = h;
            self.iterations += 1;
            self.record();
            let next = product(&shadow, &self.residual);
            let beta = ratio(next, rho) * ratio(alpha, omega);
            let r = &self.residual;
            let turned = |i: usize, p: &mut Bands| *p = r[i] + beta * (*p - omega * v[i]);
            parallel::for_each(&mut direction, |i, p| turned(i, p));
            rho = next;
            let met = self.has_converged(1.0);
            open = PerBand::from_fn(|b| beta[b] != 0.0 && !met[b]);
        }
    }

    fn finish(self) -> IterationResult {
        let (met, sound) = (self.has_converged(RESIDUAL_DRIFT), self.is_physical());
        let is_spent = self.is_spent(PRODUCTS_OF_ITERATION);
        let status = met.zip_map(sound, |met, sound| {
            if met && sound {
                SolveStatus::Converged
            } else if sound && is_spent {
                SolveStatus::MaxIterations
            } else {
                SolveStatus::Stalled
            }
        });
        IterationResult { strengths: self.strengths, status, residuals: self.residuals, power: self.power }
    }

    /// In which bands the strengths are physical: without negative sources none of them is negative beyond the tolerance. If noise creates more light
    /// in a cavity than is absorbed, the equations have a solution that is not physical.
    fn is_physical(&self) -> PerBand<bool> {
        let least = |v: &[Bands], b: Band| v.iter().fold(0.0f64, |m, x| if x[b] < m { x[b] } else { m });
        let all = &self.strengths;
        let sum = multivector::sum(all.len(), |i| all[i].abs());
        PerBand::from_fn(|b| {
            let floor = -MAX_UNDERSHOOT_OVER_MEAN * sum[b] / all.len().max(1) as f64;
            least(self.source, b) < 0.0 || least(all, b) >= floor
        })
    }
}

#[cfg(test)]
mod tests;
