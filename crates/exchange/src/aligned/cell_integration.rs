//! The reduced integral over cells: error budgets, sums, radius, and further rounds where the radius exceeds the tolerance.
//!
//! **Rounding.** All terms are positive, so relative errors pass through the sums. With ε = 2⁻⁵³ and elementary functions
//! within 2 ulp: the spans carry u ε in lo and len ([`IntegrationCell`] keeps count of u), the rules 2ε in nodes and weights; so
//! t = lo + len·node has (u+4)ε, r at most (u+7)ε, 1/r^q q(u+8)ε, the numerator of degree m at most m(u+5)ε; three densities,
//! each two products and a sum of nonnegative terms, (2u + 8 + 4 cuts)ε each; lengths and weights of the rules 3(u+4)ε; products 20ε;
//! the sums as many roundings as a term passes additions ([`radial_kernel::summation_depth`], [`pyramid_cells::depth`]). The attenuation adds
//! its argument's absolute error, 2(u+10)ε·κr (once for κ(r − r₀), once for the
//! common factor e^{−κr₀}), and 8ε. Cells are added with compensation (Neumaier), 2ε more.

use super::bernstein_ellipse::PointCount;
use super::radial_kernel::{self, TensorScratch};
use super::reduced_pair::ReducedPair;
use super::subdivision::{self, CellSubdivision, IntegrationCell, ReducedKernel, norm};
use super::{pyramid_cells, separated_cells};

/// Unit roundoff 2⁻⁵³.
const UNIT_ROUNDOFF: f64 = 0.5 * f64::EPSILON;

/// (1/π)∬ (r − r₀)^p e^{−κr}·cosines/r² for p < P, r₀ the pair's least distance; with the error radius of the first.
pub(super) struct ReducedIntegral<const P: usize> {
    pub value: [f64; P],
    pub nearest: f64,
    pub radius: f64,
    pub evaluations: u64,
    pub touching: bool,
}

/// One pass over the cells.
struct CellPass<const P: usize> {
    sum: [NeumaierSum; P],
    truncation: NeumaierSum,
    rounding: f64,
    evaluations: u64,
}

#[derive(Clone, Copy, Default)]
struct NeumaierSum {
    sum: f64,
    rest: f64,
}

impl NeumaierSum {
    fn add(&mut self, x: f64) {
        let s = self.sum + x;
        self.rest += if self.sum.abs() >= x.abs() { (self.sum - s) + x } else { (x - s) + self.sum };
        self.sum = s;
    }
    fn total(self) -> f64 {
        self.sum + self.rest
    }
}

/// Rounds, at most; then the radius reached is reported.
const MAX_ROUNDS: usize = 6;
/// Share of the tolerance below which a cell is left out in the first round.
const NEGLIGIBLE_CELL_SHARE: f64 = 1e-3;

/// The integral to a relative tolerance, or as close to it as rounding allows.
pub(super) fn integrate<const P: usize>(
    pair: &ReducedPair,
    kappa: f64,
    tolerance: f64,
) -> ReducedIntegral<P> {
    let mut negligible = NEGLIGIBLE_CELL_SHARE * tolerance;
    let mut division = subdivision::subdivide(pair, kappa, negligible);
    let mut scratch = TensorScratch::default();
    let mut budget = 0.8 * tolerance * division.total;
    let mut evaluations = 0;
    for round in 1.. {
        let pass = integrate_cells::<P>(&division, budget, &mut scratch);
        evaluations += pass.evaluations;
        let quadrature = pass.truncation.total();
        let truncation = 1.000_001 * (quadrature + division.dropped);
        let room = tolerance * pass.sum[0].total() - 1.1 * pass.rounding;
        // The comparison also ends the loop on NaN, which no further round can improve.
        let short = 1.001 * truncation > room && truncation.is_finite() && room > 0.0;
        if !short || round == MAX_ROUNDS {
            return assemble(&division, &pass, truncation, evaluations);
        }
        budget *= (0.4 * room / quadrature).min(1.0);
        if division.dropped > 0.4 * room {
            negligible *= (0.1 * room / division.dropped).min(0.1);
            division = subdivision::subdivide(pair, kappa, negligible);
        }
    }
    unreachable!("the loop returns by its last round")
}

fn integrate_cells<const P: usize>(
    division: &CellSubdivision,
    budget: f64,
    scratch: &mut TensorScratch,
) -> CellPass<P> {
    let mut pass = CellPass {
        sum: [NeumaierSum::default(); P],
        truncation: NeumaierSum::default(),
        rounding: 0.0,
        evaluations: 0,
    };
    // Half of the budget is distributed by weight and half evenly, so that a light cell gets no more digits than it needs.
    let even = 0.5 / division.leaves.len() as f64;
    for (cell, weight) in &division.leaves {
        let share = budget * (even + 0.5 * weight / division.total);
        if cell.touches() {
            pass.add_touching_cell(cell, &division.kernel, share);
        } else {
            let plan = separated_cells::plan(cell, &division.kernel, share);
            let value = separated_cells::integrate::<P>(cell, &division.kernel, &plan, scratch);
            pass.add(
                cell,
                &division.kernel,
                &plan,
                value,
                radial_kernel::summation_depth(plan.map(|c| c.points)),
            );
        }
    }
    pass
}

impl<const P: usize> CellPass<P> {
    fn add_touching_cell(&mut self, cell: &IntegrationCell, kernel: &ReducedKernel, share: f64) {
        for k in 0..3 {
            let plan = pyramid_cells::plan(cell, kernel, k, P - 1, share / 3.0);
            let value = pyramid_cells::integrate::<P>(cell, kernel, k, &plan);
            self.add(cell, kernel, &plan, value, pyramid_cells::depth(plan.map(|c| c.points)));
        }
    }

    /// Adds a cell whose terms pass through `depth` additions.
    fn add(
        &mut self,
        cell: &IntegrationCell,
        kernel: &ReducedKernel,
        plan: &[PointCount; 3],
        value: [f64; P],
        depth: usize,
    ) {
        for p in 0..P {
            self.sum[p].add(value[p]);
        }
        plan.iter().for_each(|c| self.truncation.add(c.error));
        self.rounding += value[0] * relative_rounding(cell, kernel, depth);
        self.evaluations += plan.iter().map(|c| c.points as u64).product::<u64>();
    }
}

/// Roundings beyond the span's own, in units of ε: of a node's t, of its distance, of a numerator's factor, of a density (and for each cut
/// of its cell), of a length with its weight; of all products and sums but the points; of the depth's argument.
const ROUNDINGS_OF_DISTANCE: f64 = 8.0; // bound
const ROUNDINGS_OF_NUMERATOR: f64 = 5.0; // bound
const ROUNDINGS_OF_DENSITY: f64 = 8.0; // bound
const ROUNDINGS_PER_CUT: f64 = 4.0; // bound
const ROUNDINGS_OF_LENGTH: f64 = 4.0; // bound
const ROUNDINGS_OF_PRODUCTS: f64 = 35.0; // bound
const ROUNDINGS_OF_DEPTH: f64 = 10.0; // bound

/// The relative rounding error of a cell's integral (derived in the header).
fn relative_rounding(cell: &IntegrationCell, kernel: &ReducedKernel, points: usize) -> f64 {
    let (u, q, m) = (cell.ulps, kernel.q() as f64, kernel.patches as f64);
    let shape = q * (u + ROUNDINGS_OF_DISTANCE) + m * (u + ROUNDINGS_OF_NUMERATOR);
    let density = 3.0 * (2.0 * u + ROUNDINGS_OF_DENSITY + ROUNDINGS_PER_CUT * cell.cuts);
    let sums = 3.0 * (u + ROUNDINGS_OF_LENGTH) + ROUNDINGS_OF_PRODUCTS + points as f64;
    let depth = kernel.kappa * norm(cell.upper());
    UNIT_ROUNDOFF * (shape + density + sums + 2.0 * (u + ROUNDINGS_OF_DEPTH) * depth)
}

/// Values below may have lost digits to underflow.
pub(super) const MIN_SAFE_VALUE: f64 = 1e-290;

fn assemble<const P: usize>(
    division: &CellSubdivision,
    pass: &CellPass<P>,
    truncation: f64,
    evaluations: u64,
) -> ReducedIntegral<P> {
    let front = division.multiplicity * std::f64::consts::FRAC_1_PI * division.kernel.decay_to_nearest();
    let value = pass.sum.map(|s| s.total() * front);
    let mut radius = (truncation + pass.rounding) * front * (1.0 + 64.0 * UNIT_ROUNDOFF);
    if radius.is_nan() {
        radius = f64::INFINITY;
    }
    if value[0] < MIN_SAFE_VALUE {
        radius = 1.001 * radius + f64::MIN_POSITIVE.max(value[0] * f64::EPSILON);
    }
    ReducedIntegral {
        value,
        nearest: division.kernel.nearest,
        radius,
        evaluations,
        touching: division.leaves.iter().any(|(c, _)| c.touches()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The counts of the header, step by step: nothing in [`relative_rounding`] is less.
    #[test]
    fn rounding_constants_equal_their_counts() {
        let (node, product, sum, elementary) = (2.0, 1.0, 1.0, 2.0);
        // t = lo + len · node.
        let t = node + product + sum;
        // r² = Σ t²: a square and two sums, halved by the root, and the root's own; then a power of it.
        let r = t + 0.5 * (product + 2.0 * sum) + 1.0;
        assert!(ROUNDINGS_OF_DISTANCE >= r + product && ROUNDINGS_OF_DISTANCE < 2.0 * r);
        assert!(ROUNDINGS_OF_NUMERATOR >= t + product);
        // w₀(1−u) + w₁u: weights (of a cut: three products, a sum of products, a quotient), node, product, sum.
        assert!(ROUNDINGS_OF_DENSITY >= node + product + sum + 4.0 * product);
        assert!(ROUNDINGS_PER_CUT >= 2.0 * product + sum + product);
        // Length times weight.
        assert!(ROUNDINGS_OF_LENGTH >= node + 2.0 * product);
        // Twenty products, three sums' starts, the exponential twice over and its front, compensated sums.
        assert!(
            ROUNDINGS_OF_PRODUCTS >= 20.0 * product + 3.0 * sum + 2.0 * (elementary + elementary) + 2.0 + 2.0
        );
        // κ(r − r₀) and κ r₀.
        assert!(ROUNDINGS_OF_DEPTH >= r + 2.0 * product + sum);
        let cell = |w: f64| IntegrationCell {
            spans: [super::super::reduced_pair::DensitySpan { lo: 1.0, len: 1.0, w0: w, w1: w }; 3],
            ulps: 3.0,
            cuts: 1.0,
        };
        let kernel = ReducedKernel { kappa: 0.0, nearest: 0.0, power: [0; 3], patches: 0 };
        assert!(
            (relative_rounding(&cell(1.0), &kernel, 12) / UNIT_ROUNDOFF - (22.0 + 54.0 + 21.0 + 47.0)).abs()
                < 1e-9
        );
    }
}
