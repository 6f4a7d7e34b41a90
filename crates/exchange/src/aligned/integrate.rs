//! The driver: budgets to cells, sums, radius, and another round where the first fell short.
//!
//! **Rounding.** All terms are positive, so relative errors pass through the sums. With ε = 2⁻⁵³ and elementary functions
//! within 2 ulp: the spans carry u ε in lo and len ([`Cell`] keeps count of u), the rules 2ε in nodes and weights; so
//! t = lo + len·node has (u+4)ε, r at most (u+7)ε, 1/r^q q(u+8)ε, the numerator of degree m at most m(u+5)ε; three densities,
//! each two products and a sum of nonnegative terms, (2u + 8 + 4 cuts)ε each; lengths and weights of the rules 3(u+4)ε; products 20ε;
//! the sums as many roundings as a term passes additions ([`radial::depth`], [`pyramid::depth`]). The attenuation adds its argument's absolute error, 2(u+10)ε·κr (once for κ(r − r₀), once for the
//! common factor e^{−κr₀}), and 8ε. Cells are added with compensation (Neumaier), 2ε more.

use super::cells::{self, Cell, Division, Kernel, norm};
use super::ellipse::Choice;
use super::radial::{self, Scratch};
use super::reduced::Reduced;
use super::{apart, pyramid};

const EPS: f64 = 0.5 * f64::EPSILON;

/// (1/π)∬ (r − r₀)^p e^{−κr}·cosines/r² for p < P, r₀ the pair's least distance; with the error radius of the first.
pub(super) struct Integral<const P: usize> {
    pub value: [f64; P],
    pub nearest: f64,
    pub radius: f64,
    pub evaluations: u64,
    pub touching: bool,
}

/// One pass over the cells.
struct Pass<const P: usize> {
    sum: [Compensated; P],
    truncation: Compensated,
    rounding: f64,
    evaluations: u64,
}

#[derive(Clone, Copy, Default)]
struct Compensated {
    sum: f64,
    rest: f64,
}

impl Compensated {
    fn add(&mut self, x: f64) {
        let s = self.sum + x;
        self.rest += if self.sum.abs() >= x.abs() { (self.sum - s) + x } else { (x - s) + self.sum };
        self.sum = s;
    }
    fn total(self) -> f64 {
        self.sum + self.rest
    }
}

/// Rounds after which the radius is reported as it is.
const ROUNDS: usize = 6;
/// The share of the tolerance below which a cell is left out, at first.
const NEGLIGIBLE: f64 = 1e-3;

/// The integral to a relative tolerance, or as near to it as rounding allows.
pub(super) fn integrate<const P: usize>(pair: &Reduced, kappa: f64, tolerance: f64) -> Integral<P> {
    let mut negligible = NEGLIGIBLE * tolerance;
    let mut division = cells::divide(pair, kappa, negligible);
    let mut scratch = Scratch::default();
    let mut budget = 0.8 * tolerance * division.total;
    let mut evaluations = 0;
    for round in 1.. {
        let pass = run::<P>(&division, budget, &mut scratch);
        evaluations += pass.evaluations;
        let quadrature = pass.truncation.total();
        let truncation = 1.000_001 * (quadrature + division.dropped);
        let room = tolerance * pass.sum[0].total() - 1.1 * pass.rounding;
        // Written so that what is not a number, where nothing can be improved, ends it too.
        let short = 1.001 * truncation > room && truncation.is_finite() && room > 0.0;
        if !short || round == ROUNDS {
            return finish(&division, &pass, truncation, evaluations);
        }
        budget *= (0.4 * room / quadrature).min(1.0);
        if division.dropped > 0.4 * room {
            negligible *= (0.1 * room / division.dropped).min(0.1);
            division = cells::divide(pair, kappa, negligible);
        }
    }
    unreachable!("the loop returns by its last round")
}

fn run<const P: usize>(division: &Division, budget: f64, scratch: &mut Scratch) -> Pass<P> {
    let mut pass = Pass {
        sum: [Compensated::default(); P],
        truncation: Compensated::default(),
        rounding: 0.0,
        evaluations: 0,
    };
    // Half of the budget goes by weight, half evenly: a light cell is not asked for more digits than it matters.
    let even = 0.5 / division.leaves.len() as f64;
    for (cell, weight) in &division.leaves {
        let share = budget * (even + 0.5 * weight / division.total);
        if cell.touches() {
            pass.touching(cell, &division.kernel, share);
        } else {
            let plan = apart::plan(cell, &division.kernel, share);
            let value = apart::integrate::<P>(cell, &division.kernel, &plan, scratch);
            pass.add(cell, &division.kernel, &plan, value, radial::depth(plan.map(|c| c.points)));
        }
    }
    pass
}

impl<const P: usize> Pass<P> {
    fn touching(&mut self, cell: &Cell, kernel: &Kernel, share: f64) {
        for k in 0..3 {
            let plan = pyramid::plan(cell, kernel, k, P - 1, share / 3.0);
            let value = pyramid::integrate::<P>(cell, kernel, k, &plan);
            self.add(cell, kernel, &plan, value, pyramid::depth(plan.map(|c| c.points)));
        }
    }

    /// Adds a cell whose terms pass through `depth` additions.
    fn add(&mut self, cell: &Cell, kernel: &Kernel, plan: &[Choice; 3], value: [f64; P], depth: usize) {
        for p in 0..P {
            self.sum[p].add(value[p]);
        }
        plan.iter().for_each(|c| self.truncation.add(c.error));
        self.rounding += value[0] * rounding(cell, kernel, depth);
        self.evaluations += plan.iter().map(|c| c.points as u64).product::<u64>();
    }
}

/// Roundings beyond the span's own, in units of ε: of a node's t, of its distance, of a numerator's factor, of a density (and for each cut
/// of its cell), of a length with its weight; of all products and sums but the points; of the depth's argument.
const OF_DISTANCE: f64 = 8.0; // bound
const OF_NUMERATOR: f64 = 5.0; // bound
const OF_DENSITY: f64 = 8.0; // bound
const OF_CUT: f64 = 4.0; // bound
const OF_LENGTH: f64 = 4.0; // bound
const OF_PRODUCTS: f64 = 35.0; // bound
const OF_DEPTH: f64 = 10.0; // bound

/// The relative rounding error of a cell's integral (derived in the header).
fn rounding(cell: &Cell, kernel: &Kernel, points: usize) -> f64 {
    let (u, q, m) = (cell.ulps, kernel.q() as f64, kernel.patches as f64);
    let shape = q * (u + OF_DISTANCE) + m * (u + OF_NUMERATOR);
    let density = 3.0 * (2.0 * u + OF_DENSITY + OF_CUT * cell.cuts);
    let sums = 3.0 * (u + OF_LENGTH) + OF_PRODUCTS + points as f64;
    let depth = kernel.kappa * norm(cell.upper());
    EPS * (shape + density + sums + 2.0 * (u + OF_DEPTH) * depth)
}

/// Below this a value may have lost digits to underflow.
pub(super) const TINY: f64 = 1e-290;

fn finish<const P: usize>(
    division: &Division,
    pass: &Pass<P>,
    truncation: f64,
    evaluations: u64,
) -> Integral<P> {
    let front = division.multiplicity * std::f64::consts::FRAC_1_PI * division.kernel.decay_to_nearest();
    let value = pass.sum.map(|s| s.total() * front);
    let mut radius = (truncation + pass.rounding) * front * (1.0 + 64.0 * EPS);
    if radius.is_nan() {
        radius = f64::INFINITY;
    }
    if value[0] < TINY {
        radius = 1.001 * radius + f64::MIN_POSITIVE.max(value[0] * f64::EPSILON);
    }
    Integral {
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

    /// The counts of the header, step by step: nothing in [`rounding`] is less.
    #[test]
    fn the_constants_are_their_counts() {
        let (node, product, sum, elementary) = (2.0, 1.0, 1.0, 2.0);
        // t = lo + len · node.
        let t = node + product + sum;
        // r² = Σ t²: a square and two sums, halved by the root, and the root's own; then a power of it.
        let r = t + 0.5 * (product + 2.0 * sum) + 1.0;
        assert!(OF_DISTANCE >= r + product && OF_DISTANCE < 2.0 * r);
        assert!(OF_NUMERATOR >= t + product);
        // w₀(1−u) + w₁u: weights (of a cut: three products, a sum of products, a quotient), node, product, sum.
        assert!(OF_DENSITY >= node + product + sum + 4.0 * product);
        assert!(OF_CUT >= 2.0 * product + sum + product);
        // Length times weight.
        assert!(OF_LENGTH >= node + 2.0 * product);
        // Twenty products, three sums' starts, the exponential twice over and its front, compensated sums.
        assert!(OF_PRODUCTS >= 20.0 * product + 3.0 * sum + 2.0 * (elementary + elementary) + 2.0 + 2.0);
        // κ(r − r₀) and κ r₀.
        assert!(OF_DEPTH >= r + 2.0 * product + sum);
        let cell = |w: f64| Cell {
            spans: [super::super::reduced::Span { lo: 1.0, len: 1.0, w0: w, w1: w }; 3],
            ulps: 3.0,
            cuts: 1.0,
        };
        let kernel = Kernel { kappa: 0.0, nearest: 0.0, power: [0; 3], patches: 0 };
        assert!((rounding(&cell(1.0), &kernel, 12) / EPS - (22.0 + 54.0 + 21.0 + 47.0)).abs() < 1e-9);
    }
}
