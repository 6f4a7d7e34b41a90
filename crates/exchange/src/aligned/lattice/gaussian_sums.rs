//! Tables of periodic grids: the kernel as a sum of Gaussians, each a product over the axes.
//!
//! **Kernel.** With m patches in a pair, q = 2 + m and v = u², the inverse Laplace transform of e^{−κ√s}/s^{q/2} gives
//!
//! ```text
//!     e^{−κr}/r^q = ∫₀^∞ (4v)^{m/2} iᵐerfc(κ/(2√v)) e^{−v r²} dv,        iᵐerfc(z) = (2/√π) ∫₀^∞ (tᵐ/m!) e^{−(z+t)²} dt.
//! ```
//!
//! The densities of t are products too (`linear_basis.rs`), so the factor of an offset d **with all its images** is
//!
//! ```text
//!     𝓕_pq(d) = (1/π) Σ_u A_u Π_k G_k(u; d_k),         G_k(u; d) = Σ_images ∫ w_k(t) |t|^{p_k} e^{−u²t²} dt,
//! ```
//!
//! with u from the trapezoidal rule in x = ln v. The number of images does not enter: where u times the period P is at least
//! [`MIN_SCALED_PERIOD_OF_IMAGE_SUM`], G is a sum over
//! few images; below, it is Poisson's sum over few frequencies ω = 2πl/P,
//!
//! ```text
//!     G(u; d) = (√π/(uP)) Σ_ω ŵ(ω) e^{−ω²/(4u²)} e^{iωde},        |ŵ| = e² (sinc² a, √3 sinc a j₁(a), 3 j₁²(a)),  a = ωe/2.
//! ```
//!
//! So time and memory do not depend on κ, apart from a few nodes for each decade. For κ → 0 and two periodic axes the factor of two voxels grows
//! as ln(1/κ); every other factor has a limit, and κ = 0 is a value as any. At κ = 0 no voxel emits, and the factors
//! of two voxels with two periodic axes, which have no limit, are given as 0: the incident power is exact.
//!
//! **Error.** All terms of the factors for constant radiosity are positive.
//! - *Step.* The rule multiplies r^{−q} by 1 + ε, |ε| ≤ 2 Σ_l |Γ(q/2 + 2πil/h)|/Γ(q/2), below 1e-25 for h = [`LOG_STEP`]. With a medium the
//!   contour may be turned by any φ < π/2: |ε| is about e^{−2πφ/h + κr(1 − cos φ)}, below 1e-13 up to κr = 30; beyond, [`step_error`] gives it relative to e^{−κr}.
//! - *Ends.* Integrands fall at least as u and 1/u towards the ends, a factor [`END_SHARE`] off the longest and the shortest length (or mean
//!   free path): that share is left out.
//!   Below κ/18, iᵐerfc(9) < 1e-36 of the radiation of a row is left out.
//! - *Profiles.* Gauss rules on pieces over which the exponent changes by [`MAX_EXPONENT_CHANGE`] at most: below 1e-15.
//! - *Rounding.* Exponents up to 41 with a relative error of 2 ulp, sums of eight columns: below 4e-14.
//!
//! Together less than [`RELATIVE_RADIUS`]. A κ below [`MIN_OPTICAL_DEPTH`]/L, L the longest length of the grid, is raised to that value: the
//! incident power changes by less than 1e-25.

use super::chunk_evaluator::ChunkEvaluator;
use super::pair_layout::{AxisRelation, LinearBasisPairs, PeriodicGrid};
use std::f64::consts::{FRAC_1_PI, FRAC_2_SQRT_PI, PI};
use zonal_math::gauss_legendre;
use zonal_math::parallel;

/// Relative radius of a factor, or of a row of factors.
pub(super) const RELATIVE_RADIUS: f64 = 2e-13;
/// Step in ln v.
const LOG_STEP: f64 = 0.15;
/// Share that is left out beyond the first and the last node.
const END_SHARE: f64 = 1e-15;
/// u over κ of the first node.
const FIRST_NODE_OVER_KAPPA: f64 = 1.0 / 18.0;
/// Optical depth of the longest length below which κ is raised to it.
const MIN_OPTICAL_DEPTH: f64 = 1e-30;
/// Smallest u times period for which images are summed instead of frequencies.
const MIN_SCALED_PERIOD_OF_IMAGE_SUM: f64 = 2.0;
/// Frequencies of Poisson's sum beside zero: e^{−π²l²/4} of the next is below 1e-21.
const MAX_FREQUENCY: usize = 4;
/// Exponents relative to the largest, beyond which terms are left out.
const MAX_EXPONENT: f64 = 41.0;
/// Exponent beyond which a single image is left out.
const MAX_EXPONENT_OF_SINGLE_IMAGE: f64 = 220.0;
/// Change of the exponent over a piece that one Gauss rule serves.
const MAX_EXPONENT_CHANGE: f64 = 5.0;
/// Points of the rules.
const RULE_POINTS: usize = 16;
/// Columns of a sum.
const SUM_COLUMNS: usize = 8;

/// The nodes u with their weights A.
struct GaussianNodes {
    /// 1/m, ascending.
    u: Vec<f64>,
    weight: Vec<f64>,
}

impl GaussianNodes {
    /// Nodes for pairs with `patches` patches; lengths from `shortest` to `longest`, m.
    fn new(kappa: f64, patches: usize, shortest: f64, longest: f64) -> GaussianNodes {
        let kappa = if kappa > 0.0 { kappa.max(MIN_OPTICAL_DEPTH / longest) } else { 0.0 };
        let first = if kappa > 0.0 { kappa * FIRST_NODE_OVER_KAPPA } else { END_SHARE / longest };
        let last = kappa.max(1.0 / shortest) / END_SHARE;
        let count = (2.0 * (last / first).ln() / LOG_STEP).ceil().max(1.0) as usize + 1;
        let u: Vec<f64> = (0..count).map(|i| first * (0.5 * LOG_STEP * i as f64).exp()).collect();
        let power = patches as i32;
        let weight =
            |u: &f64| FRAC_1_PI * LOG_STEP * u * u * (2.0 * u).powi(power) * ierfc(patches, 0.5 * kappa / u);
        GaussianNodes { weight: u.iter().map(weight).collect(), u }
    }
}

/// iᵐerfc(z), z ≥ 0, m = 0, 1, 2; a sum of positive terms, relative error about 1e-15.
fn ierfc(m: usize, z: f64) -> f64 {
    let rule = gauss_legendre::rule(RULE_POINTS);
    // e^{−2zt−t²} over lengths on which it falls by a few powers of e.
    let (length, pieces) = if z > 1.0 { (1.0 / z, 22) } else { (0.5, 14) };
    let mut sum = 0.0;
    for i in 0..pieces {
        for (x, w) in rule.nodes.iter().zip(&rule.weights) {
            let t = (i as f64 + x) * length;
            sum += w * length * t.powi(m as i32) * (-t * (2.0 * z + t)).exp();
        }
    }
    let factorial = if m == 2 { 2.0 } else { 1.0 };
    FRAC_2_SQRT_PI * (-z * z).exp() * sum / factorial
}

/// Relative error by the step of the rule of a factor over `depth` = κr mean free paths.
pub(super) fn step_error(depth: f64) -> f64 {
    let turned = |i: i32| {
        let phi = 0.05 * f64::from(i);
        -std::f64::consts::TAU * phi / LOG_STEP + depth * (1.0 - phi.cos())
    };
    let least = (1..31).map(turned).fold(f64::INFINITY, f64::min);
    (10.0 * (1.0 + depth) * least.exp()).min(1.0)
}

/// One axis of a family of pairs.
#[derive(Clone, Copy)]
struct AxisProfile {
    along: AxisRelation,
    /// m.
    edge: f64,
    /// Cells between opposite walls.
    count: usize,
    /// Cells of a period.
    period: Option<usize>,
}

impl AxisProfile {
    /// G of the density `term` at the offset `slot` for each u, up to the last that is not zero.
    fn profile(&self, u: &[f64], term: usize, slot: usize) -> Vec<f64> {
        let mut out: Vec<f64> = u.iter().map(|&u| self.value(u, term, slot)).collect();
        while out.last() == Some(&0.0) {
            out.pop();
        }
        out
    }

    fn value(&self, u: f64, term: usize, slot: usize) -> f64 {
        let e = self.edge;
        match (self.along, self.period) {
            (AxisRelation::OppositeWalls, _) => {
                let far = self.count as f64 * e;
                far * far * (-(u * far).powi(2)).exp()
            }
            (AxisRelation::OffWall, _) => {
                let lo = slot as f64 * e;
                integral(u, lo, e, |x, t| if term == 0 { t } else { t * slope(x) })
            }
            (AxisRelation::Extended, None) => self.image(u, term, slot as f64, MAX_EXPONENT_OF_SINGLE_IMAGE),
            // Cells in a row are one, of density one; slopes along it are zero by symmetry.
            (AxisRelation::Extended, Some(1)) if term == 0 => PI.sqrt() * e / u,
            (AxisRelation::Extended, Some(1)) => 0.0,
            (AxisRelation::Extended, Some(n)) if u * n as f64 * e < MIN_SCALED_PERIOD_OF_IMAGE_SUM => {
                self.by_frequencies(u, term, slot, n)
            }
            (AxisRelation::Extended, Some(n)) => self.by_images(u, term, slot, n),
        }
    }

    /// The integral over the cells above and below one image, `y` cells off; nothing where its exponent is far above `least`.
    fn image(&self, u: f64, term: usize, y: f64, least: f64) -> f64 {
        let (e, sign) = (self.edge, if y < 0.0 { -1.0 } else { 1.0 });
        let y = y.abs();
        let (lo, at) = ((y - 1.0).max(0.0) * e, y * e);
        if (u * lo).powi(2) > least + 2.0 * MAX_EXPONENT {
            return 0.0;
        }
        if term == 1 {
            // The cell above less the cell below: e^{−u²(y+τ)²} − e^{−u²(y−τ)²}.
            if y == 0.0 {
                return 0.0;
            }
            let odd = |x: f64, _: f64| {
                let tau = (1.0 - x) * e;
                e * 3.0f64.sqrt() * x * (1.0 - x) * (-4.0 * u * u * at * tau).exp_m1()
            };
            return sign * integral(u, lo, e, odd);
        }
        let even = |x: f64| if term == 0 { 1.0 - x } else { 1.0 - 3.0 * x + 2.0 * x * x * x };
        let above = integral(u, at, e, |x, _| e * even(x));
        let below = if y == 0.0 { above } else { integral(u, lo, e, |x, _| e * even(1.0 - x)) };
        above + below
    }

    fn by_images(&self, u: f64, term: usize, slot: usize, n: usize) -> f64 {
        let at = |m: f64| slot as f64 + m * n as f64;
        let gap = |y: f64| u * (y.abs() - 1.0).max(0.0) * self.edge;
        let least = gap(at(0.0)).min(gap(at(-1.0))).powi(2);
        let mut sum = self.image(u, term, at(0.0), least);
        for m in 1.. {
            let sides = [at(-f64::from(m)), at(f64::from(m))];
            if sides.iter().all(|&y| gap(y).powi(2) > least + 2.0 * MAX_EXPONENT) {
                break;
            }
            sum += sides.map(|y| self.image(u, term, y, least)).iter().sum::<f64>();
        }
        sum
    }

    fn by_frequencies(&self, u: f64, term: usize, slot: usize, n: usize) -> f64 {
        let (e, period) = (self.edge, n as f64 * self.edge);
        let mut sum = if term == 0 { 1.0 } else { 0.0 };
        for l in 1..=MAX_FREQUENCY {
            let (a, omega) = (PI * l as f64 / n as f64, 2.0 * PI * l as f64 / period);
            let (sinc, j1) = (a.sin() / a, j1(a));
            let turn = 2.0 * PI * ((l * slot) % n) as f64 / n as f64;
            let of = match term {
                0 => sinc * sinc * turn.cos(),
                1 => -3.0f64.sqrt() * sinc * j1 * turn.sin(),
                _ => 3.0 * j1 * j1 * turn.cos(),
            };
            sum += 2.0 * of * (-(0.5 * omega / u).powi(2)).exp();
        }
        PI.sqrt() * e * e / (u * period) * sum
    }
}

/// φ_k of a cell off a wall.
fn slope(x: f64) -> f64 {
    3.0f64.sqrt() * (2.0 * x - 1.0)
}

/// The spherical Bessel function of order one, a > 0.
fn j1(a: f64) -> f64 {
    if a > 0.5 {
        return (a.sin() / a - a.cos()) / a;
    }
    let (mut sum, mut term) = (0.0, a / 3.0);
    for k in 1..12 {
        sum += term;
        term *= -0.5 * a * a / (k as f64 * (2 * k + 3) as f64);
    }
    sum
}

/// ∫ f(x, t) e^{−u²t²} dt over t = lo + x·len, x in [0, 1].
fn integral(u: f64, lo: f64, len: f64, f: impl Fn(f64, f64) -> f64) -> f64 {
    let (from, to) = (u * lo, u * (lo + len));
    if from * from > 700.0 {
        return 0.0;
    }
    let end = to.min((from * from + MAX_EXPONENT).sqrt());
    let part = if end < to { (end - from) / (u * len) } else { 1.0 };
    let change = (end - from) * (end + from);
    let pieces = (change / MAX_EXPONENT_CHANGE).max((end - from) / 1.5).ceil().max(1.0);
    let rule = gauss_legendre::rule(if change < 0.1 { RULE_POINTS / 2 } else { RULE_POINTS });
    let mut sum = 0.0;
    for i in 0..pieces as usize {
        for (x, w) in rule.nodes.iter().zip(&rule.weights) {
            let x = part * (i as f64 + x) / pieces;
            let t = lo + x * len;
            sum += w * f(x, t) * (-(u * t).powi(2)).exp();
        }
    }
    sum * len * part / pieces
}

/// Σ a b in fixed columns.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a, b) = (&a[..n], &b[..n]);
    let mut sums = [0.0; SUM_COLUMNS];
    let (x, y) = (a.chunks_exact(SUM_COLUMNS), b.chunks_exact(SUM_COLUMNS));
    let rest: f64 = x.remainder().iter().zip(y.remainder()).map(|(a, b)| a * b).sum();
    for (x, y) in x.zip(y) {
        for l in 0..SUM_COLUMNS {
            sums[l] += x[l] * y[l];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// Lines of a table per task.
const LINES_PER_CHUNK: usize = 8;

/// The tables of pairs in a periodic grid, as [`LinearBasisPairs::tables`].
pub(super) fn tables(
    pairs: &LinearBasisPairs,
    terms: &[[usize; 3]],
    evaluator: &dyn ChunkEvaluator,
) -> Vec<Vec<f64>> {
    let PeriodicGrid { period, .. } = *pairs.images;
    let axes = [0, 1, 2].map(|k| AxisProfile {
        along: pairs.along[k],
        edge: pairs.edges[k],
        count: pairs.counts[k],
        period: period[k].filter(|_| pairs.along[k] == AxisRelation::Extended),
    });
    let counts = pairs.slots();
    let size = counts.iter().product();
    let patches = pairs.patches();
    let level = axes.iter().filter(|a| a.period.is_some()).count() > 1;
    if pairs.kappa == 0.0 && patches == 0 && level {
        return vec![vec![0.0; size]; terms.len()];
    }
    let shortest = pairs.edges.iter().copied().fold(f64::INFINITY, f64::min);
    let length = |a: &AxisProfile| a.edge * a.period.unwrap_or(0).max(a.count) as f64;
    let longest = axes.iter().map(length).fold(0.0, f64::max);
    let nodes = GaussianNodes::new(pairs.kappa, patches, shortest, longest);
    // By axis, density and offset.
    let profiles: [Vec<Vec<Vec<f64>>>; 3] = std::array::from_fn(|k| {
        let profile = |term: usize| {
            if terms.iter().any(|t| t[k] == term) {
                parallel::collect(counts[k], |d| axes[k].profile(&nodes.u, term, d))
            } else {
                Vec::new()
            }
        };
        (0..3).map(profile).collect()
    });
    let table = |term: &[usize; 3]| {
        let [of0, of1, of2] = [0, 1, 2].map(|k| &profiles[k][term[k]]);
        let line = |i: usize| {
            let (a, b) = (&of0[i / counts[1]], &of1[i % counts[1]]);
            let both: Vec<f64> = nodes.weight.iter().zip(a).zip(b).map(|((w, a), b)| w * a * b).collect();
            of2.iter().map(|c| dot(&both, c)).collect::<Vec<f64>>()
        };
        let lines = counts[0] * counts[1];
        let chunk = |k: usize| {
            let own = k * LINES_PER_CHUNK..((k + 1) * LINES_PER_CHUNK).min(lines);
            own.flat_map(line).collect()
        };
        evaluator.evaluate(lines.div_ceil(LINES_PER_CHUNK), &chunk).concat()
    };
    terms.iter().map(table).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaussian_sum_equals_kernel() {
        for kappa in [0.0, 1e-9, 0.4, 30.0] {
            for patches in 0..=2 {
                let nodes = GaussianNodes::new(kappa, patches, 1e-3, 50.0);
                for r in [1e-2, 0.3, 1.0, 7.0] {
                    let sum: f64 =
                        nodes.u.iter().zip(&nodes.weight).map(|(u, w)| w * (-(u * r).powi(2)).exp()).sum();
                    let want = FRAC_1_PI * f64::exp(-kappa * r) / f64::powi(r, 2 + patches as i32);
                    // The ends of the node grid are left out: an error that is a power of the distance.
                    let (depth, ends) = (kappa * r, (END_SHARE * r / 50.0).powi(2).max((1e-18 / r).powi(2)));
                    let off = (sum / want - 1.0).abs();
                    let rounding = 2e-14 * (1.0 + depth);
                    assert!(off < rounding + ends + step_error(depth), "{kappa} {patches} {r}: {off:e}");
                }
            }
        }
    }

    #[test]
    fn image_and_frequency_sums_agree() {
        let axis = AxisProfile { along: AxisRelation::Extended, edge: 0.3, count: 3, period: Some(5) };
        for term in 0..3 {
            for slot in 0..3 {
                for u in [0.7, 1.0, 1.33] {
                    let (a, b) = (axis.by_images(u, term, slot, 5), axis.by_frequencies(u, term, slot, 5));
                    let scale = axis.by_images(u, 0, slot, 5);
                    assert!((a - b).abs() < 2e-15 * scale, "{term} {slot} {u}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn repeated_erfc_integrals_match_tables() {
        // Abramowitz and Stegun, table 7.4, times Γ(m/2 + 1) 2^m: 1 at zero.
        assert!((ierfc(0, 0.0) - 1.0).abs() < 1e-15);
        assert!((ierfc(1, 0.0) - 0.5 * FRAC_2_SQRT_PI).abs() < 1e-15);
        assert!((ierfc(2, 0.0) - 0.25).abs() < 1e-15);
        assert!((ierfc(0, 1.0) / 0.157_299_207_050_285_13 - 1.0).abs() < 1e-14);
        for z in [0.2, 0.9, 1.1, 3.0, 7.0] {
            // 2m iᵐerfc = iᵐ⁻²erfc − 2z iᵐ⁻¹erfc.
            let (left, right) = (4.0 * ierfc(2, z), ierfc(0, z) - 2.0 * z * ierfc(1, z));
            assert!((left - right).abs() < 1e-14 * ierfc(0, z), "{z}: {left} {right}");
        }
    }
}
