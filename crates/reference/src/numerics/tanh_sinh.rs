//! The tanh–sinh (double-exponential) rule of Takahasi and Mori (1974) on [0, 1], and integrals over intervals near a singularity.
//!
//! u(τ) = 1/(1 + e^{−π sinh τ}), du = π cosh τ · u(1 − u) dτ, and the trapezoidal rule in τ. A node stores its distances from
//! **both** ends, each to relative accuracy (computed in [`DoubleDouble`], rounded once), so that integrands that vanish or diverge
//! at an end keep their accuracy. The weights beyond |τ| = 3.35 are below 1e−17 and omitted.

use crate::numerics::double_double::{DoubleDouble, PI_DD};
use std::sync::OnceLock;

/// A node of the rule on [0, 1].
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuadratureNode {
    /// Distance from 0.
    pub below: f64,
    /// Distance from 1.
    pub above: f64,
    /// Weight.
    pub weight: f64,
}

/// Steps in τ of the levels, from coarse to fine.
pub(crate) const LEVEL_STEPS: [f64; 8] = [0.5, 0.36, 0.26, 0.19, 0.135, 0.1, 0.07, 0.05];

/// Largest |τ| of a node.
const MAX_TAU: f64 = 3.35;

/// The rule of a level below [`LEVEL_STEPS`]`.len()`.
pub(crate) fn rule(level: usize) -> &'static [QuadratureNode] {
    static LEVEL_RULES: [OnceLock<Vec<QuadratureNode>>; LEVEL_STEPS.len()] =
        [const { OnceLock::new() }; LEVEL_STEPS.len()];
    LEVEL_RULES[level].get_or_init(|| build_rule(LEVEL_STEPS[level]))
}

fn build_rule(step: f64) -> Vec<QuadratureNode> {
    let count = (MAX_TAU / step).floor() as i64;
    (-count..=count).map(|k| node(k as f64 * step, step)).collect()
}

fn node(tau: f64, step: f64) -> QuadratureNode {
    let one = DoubleDouble::from(1.0);
    let e = DoubleDouble::from(tau).exp();
    let (sinh2, cosh2) = (e - one / e, e + one / e);
    let half_pi = PI_DD * DoubleDouble::from(0.5);
    // e^{π sinh τ}: 1/(1 + it) is the distance from the upper end.
    let grown = (half_pi * sinh2).exp();
    let (above, below) = (one / (one + grown), grown / (one + grown));
    let weight = half_pi * cosh2 * above * below * DoubleDouble::from(step);
    QuadratureNode { below: below.rounded(), above: above.rounded(), weight: weight.rounded() }
}

/// An interval [lo, lo + len] of positive numbers whose integrand has a singularity at ±i·`away` (or nearer to zero).
#[derive(Clone, Copy, Debug)]
pub(crate) struct SingularInterval {
    /// Lower end, not negative.
    pub lo: f64,
    /// Length, relatively accurate.
    pub len: f64,
    /// Distance of the singularities on the imaginary axis from zero.
    pub away: f64,
    /// Longest piece that is integrated without subdivision.
    pub longest: f64,
}

/// A point of an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NodePosition {
    /// The coordinate.
    pub x: f64,
    /// Distance from the lower end.
    pub below: f64,
    /// Distance from the upper end.
    pub above: f64,
}

impl SingularInterval {
    /// ∫ f over the interval. A piece is at most [`PIECE_OVER_DISTANCE`] times as long as its distance from the singularity, so that
    /// the integrand is analytic well beyond its ends.
    pub(crate) fn integrate(&self, nodes: &[QuadratureNode], mut f: impl FnMut(NodePosition) -> f64) -> f64 {
        let (mut from, mut total) = (0.0, 0.0);
        while from < self.len {
            let reach = (PIECE_OVER_DISTANCE * (self.lo + from).hypot(self.away)).min(self.longest);
            let rest = self.len - from;
            let (size, after) = if rest <= 1.2 * reach { (rest, 0.0) } else { (reach, rest - reach) };
            let mut sum = 0.0;
            for n in nodes {
                let (below, above) = (from + size * n.below, after + size * n.above);
                sum += n.weight * f(NodePosition { x: self.lo + below, below, above });
            }
            total += size * sum;
            if after == 0.0 {
                break;
            }
            from += size;
        }
        total
    }
}

/// Largest length of a piece over its distance from the singularity.
const PIECE_OVER_DISTANCE: f64 = 2.0;

#[cfg(test)]
mod tests {
    use super::*;

    fn line(lo: f64, len: f64, away: f64) -> SingularInterval {
        SingularInterval { lo, len, away, longest: f64::INFINITY }
    }

    #[test]
    fn smooth_and_endpoint_singular_integrals_are_exact() {
        let fine = rule(6);
        let unit = line(0.0, 1.0, 1.0);
        let close = |got: f64, want: f64| assert!((got / want - 1.0).abs() < 4e-16 * 4.0, "{got} {want}");
        close(unit.integrate(fine, |_| 1.0), 1.0);
        close(unit.integrate(fine, |s| s.x.exp()), 1f64.exp_m1());
        close(unit.integrate(fine, |s| s.above * s.above), 1.0 / 3.0);
        close(unit.integrate(fine, |s| s.x * s.x.ln()), -0.25);
    }

    #[test]
    fn integrals_near_poles_are_exact_over_twelve_decades() {
        for away in [1.0, 1e-3, 1e-6, 1e-12] {
            let got = line(0.0, 1.0, away).integrate(rule(5), |s| 1.0 / (s.x * s.x + away * away));
            let want = (1.0 / away).atan() / away;
            assert!((got / want - 1.0).abs() < 3e-15, "{away}: {got} {want}");
        }
        let far = line(1e4, 1e-4, 0.0).integrate(rule(3), |s| s.below / s.x);
        assert!((far / (0.5e-8 / 1e4) - 1.0).abs() < 1e-8, "{far}");
    }
}
