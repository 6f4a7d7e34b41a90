//! Sums over the images of a facet along one axis, of a function that is smooth in the displacement.
//!
//! ```text
//! Σ_{n=a}^{b} f(n) ≈ Σ_i w_i f(ν_i)
//! ```
//!
//! with the Gauss rule of the sum itself, whose nodes ν_i are the zeros of the discrete Chebyshev (Gram) polynomial of degree q on a..b: exact for
//! polynomials of degree 2q − 1. Ranges grow with the distance, since f varies on the scale of the distance; a range on which rules of two
//! degrees differ is halved, down to single images. The difference is part of the radius. What is left out beyond the last range is bounded.
//!
//! Source: J. C. P. Miller and G. Szegő's discrete orthogonal polynomials, as in A. F. Nikiforov, S. K. Suslov, V. B. Uvarov, Classical Orthogonal Polynomials of a
//! Discrete Variable, 1991, section 2.3 (the recurrence).

use zonal_math::Bounded;

/// Nodes of the two rules: moderate and small relative radii.
const NODES: [[usize; 2]; 2] = [[3, 5], [5, 8]];
/// Relative radius below which the rules with more nodes serve.
const FINE_RELATIVE_RADIUS: f64 = 1e-5;
/// Share of the requested radius for one range, and for what is left out.
const RANGE_SHARE: f64 = 1.0 / 64.0;
const REST_SHARE: f64 = 1.0 / 64.0;
/// Share of the requested relative radius of the sum of nearer images that the others may use.
const TOTAL_SHARE: f64 = 1.0 / 8.0;
/// Bisections of a zero.
const BISECTIONS: usize = 60;

/// A function of the displacement in periods and of the weight of its value, and a bound of all its values from a displacement on.
pub(crate) trait ImageFunction {
    /// The value for a displacement; its radius is asked for relative to `weight`.
    fn value(&mut self, displacement: f64, weight: f64) -> Bounded;
    /// A bound of Σ f(±m) over m ≥ n ≥ 1 on one side.
    fn rest(&self, n: i32) -> f64;
    /// Displacements at the side, in periods, over which the function varies at least.
    fn scale(&self) -> f64;
    /// Takes note of the sum of nearer images, beside which the others need no small relative radius.
    fn set_total(&mut self, total: f64);
}

/// The requested radius, max(`relative` of the sum, `absolute`).
#[derive(Clone, Copy, Debug)]
pub(crate) struct SumGoal {
    pub relative: f64,
    pub absolute: f64,
}

impl SumGoal {
    /// The goal of images further away than those of this sum.
    pub(crate) fn beside(self, total: f64) -> SumGoal {
        SumGoal { absolute: self.absolute.max(TOTAL_SHARE * self.relative * total), ..self }
    }
}

/// Σ f(n) for n from `first` to `last`. Grade estimated unless every image was evaluated.
pub(crate) fn sum(first: i32, last: i32, goal: SumGoal, f: &mut dyn ImageFunction) -> Bounded {
    let mut total = Bounded::ZERO;
    if first <= 0 && last >= 0 {
        total = total + f.value(0.0, 1.0);
    }
    for (sign, from, to) in [(1.0, first.max(1), last), (-1.0, (-last).max(1), -first)] {
        let mut a = from;
        while a <= to {
            let goal = goal.beside(total.value);
            f.set_total(total.value);
            let rest = f.rest(a);
            if rest <= REST_SHARE * goal.absolute {
                total = total + Bounded::proved(0.0, rest);
                break;
            }
            let length = f64::from(a).max(f.scale()).min(f64::from(to - a) + 1.0);
            let b = a + (length as i32 - 1).max(0);
            total = total + range(sign, a, b, goal, f);
            a = b.saturating_add(1);
        }
    }
    total
}

fn range(sign: f64, a: i32, b: i32, goal: SumGoal, f: &mut dyn ImageFunction) -> Bounded {
    let [coarse, fine] = NODES[usize::from(goal.relative < FINE_RELATIVE_RADIUS)];
    let count = (b - a) as usize + 1;
    if count <= coarse + fine {
        return (a..=b).fold(Bounded::ZERO, |s, n| s + f.value(sign * f64::from(n), 1.0));
    }
    let mut apply = |q: usize| {
        let rule = gauss_rule(count, q);
        rule.iter().fold(Bounded::ZERO, |s, (x, w)| s + f.value(sign * (f64::from(a) + x), *w) * *w)
    };
    let (rough, value) = (apply(coarse), apply(fine));
    let difference = (rough.value - value.value).abs();
    let noise = value.radius + rough.radius;
    let allowed = (0.25 * goal.relative * value.value).max(RANGE_SHARE * goal.absolute).max(noise);
    if difference <= allowed {
        return Bounded::estimated(value.value, value.radius + difference);
    }
    let middle = a + (b - a) / 2;
    range(sign, a, middle, goal, f) + range(sign, middle + 1, b, goal, f)
}

/// Nodes from 0 to count − 1, and weights, of the Gauss rule with `q` nodes of a sum over `count` numbers.
fn gauss_rule(count: usize, q: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    // Monic polynomials on (−1, 1): p_{k+1} = x p_k − β_k p_{k−1}.
    let beta = |k: usize| {
        let k = k as f64;
        k * k * (1.0 - k * k / (n * n)) / (4.0 * k * k - 1.0)
    };
    let value = |degree: usize, x: f64| {
        let (mut before, mut now) = (0.0, 1.0);
        for k in 0..degree {
            let next = x * now - if k > 0 { beta(k) * before } else { 0.0 };
            (before, now) = (now, next);
        }
        now
    };
    // The zeros of one degree separate those of the next.
    let mut zeros: Vec<f64> = Vec::new();
    for degree in 1..=q {
        let ends: Vec<f64> =
            std::iter::once(-1.0).chain(zeros.iter().copied()).chain(std::iter::once(1.0)).collect();
        let zero = |w: &[f64]| {
            let (mut lo, mut hi) = (w[0], w[1]);
            let sign = value(degree, lo);
            for _ in 0..BISECTIONS {
                let m = 0.5 * (lo + hi);
                if value(degree, m) * sign > 0.0 { lo = m } else { hi = m }
            }
            0.5 * (lo + hi)
        };
        zeros = ends.windows(2).map(zero).collect();
    }
    let weight = |x: f64| {
        let (mut before, mut now, mut sum) = (0.0, 1.0, 0.0);
        for k in 0..q {
            sum += now * now;
            // Normalised: √β_{k+1} p_{k+1} = x p_k − √β_k p_{k−1}.
            let next = (x * now - if k > 0 { beta(k).sqrt() * before } else { 0.0 }) / beta(k + 1).sqrt();
            (before, now) = (now, next);
        }
        n / sum
    };
    zeros.into_iter().map(|x| (0.5 * (n - 1.0) + 0.5 * n * x, weight(x))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_exact_for_polynomials() {
        for (count, q) in [(6, 3), (11, 5), (40, 8), (1_000_000, 8)] {
            let rule = gauss_rule(count, q);
            let n = count as f64;
            for power in 0..2 * q as i32 {
                let scaled = |x: f64| (x / n).powi(power);
                let exact: f64 = (0..count).map(|k| scaled(k as f64)).sum();
                let ours: f64 = rule.iter().map(|(x, w)| w * scaled(*x)).sum();
                assert!((ours - exact).abs() < 1e-11 * n, "{count} {q} {power}: {ours} {exact}");
            }
        }
    }

    struct Inverse(usize);
    impl ImageFunction for Inverse {
        fn value(&mut self, x: f64, _: f64) -> Bounded {
            self.0 += 1;
            Bounded::proved(1.0 / (0.3 + x * x).powi(2), 0.0)
        }
        fn rest(&self, n: i32) -> f64 {
            0.34 / (f64::from(n) - 1.0).max(0.1).powi(3)
        }
        fn scale(&self) -> f64 {
            0.5
        }
        fn set_total(&mut self, _: f64) {}
    }

    #[test]
    fn sums_over_many_images_hold_at_little_cost() {
        let exact: f64 = (-100_000..=100_000).map(|n| 1.0 / (0.3 + f64::from(n).powi(2)).powi(2)).sum();
        for goal in [1e-3, 1e-6, 1e-9] {
            let mut f = Inverse(0);
            let ours = sum(-100_000, 100_000, SumGoal { relative: goal, absolute: goal }, &mut f);
            assert!((ours.value - exact).abs() <= ours.radius + 1e-13, "{goal}: {ours:?} {exact}");
            assert!(ours.radius <= goal * exact && f.0 < 400, "{goal}: {} {}", ours.radius, f.0);
        }
    }
}
