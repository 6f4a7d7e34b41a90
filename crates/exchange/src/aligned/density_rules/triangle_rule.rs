//! Gauss rules of the triangle density 1 − |x| on [−1, 1], by Chebyshev's algorithm in double-double arithmetic.

use std::sync::OnceLock;
use zonal_math::double_double::DoubleDouble;

/// Points per direction at most.
pub(super) const MAX_RULE_POINTS: usize = 9;

/// Nodes on [−1, 1] and weights of sum one.
#[derive(Debug)]
pub(super) struct TriangleRule {
    pub nodes: Vec<f64>,
    pub weights: Vec<f64>,
}

/// The n-point Gauss rule of 1 − |x| on [−1, 1], 1 ≤ n ≤ [`MAX_RULE_POINTS`].
pub(super) fn triangle(n: usize) -> &'static TriangleRule {
    static RULES: OnceLock<Vec<TriangleRule>> = OnceLock::new();
    &RULES.get_or_init(|| {
        let beta = recurrence_coefficients();
        let mut zeros: Vec<f64> = vec![];
        (0..=MAX_RULE_POINTS)
            .map(|n| {
                zeros = interlaced_zeros(n, &beta, &zeros);
                TriangleRule::new(n, &beta, &zeros)
            })
            .collect()
    })[n]
}

/// β_k, k = 1..2·`MAX_RULE_POINTS`, from the even moments (Chebyshev's algorithm; α_k = 0).
fn recurrence_coefficients() -> Vec<DoubleDouble> {
    let count = 2 * MAX_RULE_POINTS + 2;
    let number = |x: usize| DoubleDouble::new(x as f64);
    let moment = |l: usize| {
        if l % 2 == 1 { DoubleDouble::new(0.0) } else { number(2).div(number(l + 1).mul(number(l + 2))) }
    };
    let mut before = vec![DoubleDouble::new(0.0); count];
    let mut now: Vec<DoubleDouble> = (0..count).map(moment).collect();
    let mut beta = vec![now[0]];
    for k in 1..=MAX_RULE_POINTS {
        let mut next = vec![DoubleDouble::new(0.0); count];
        for l in k..count - k {
            next[l] =
                now[l + 1].sub(beta[k - 1].mul(if k == 1 { DoubleDouble::new(0.0) } else { before[l] }));
        }
        beta.push(next[k].div(now[k - 1]));
        (before, now) = (now, next);
    }
    beta
}

/// p_n, its derivative and p_{n−1}.
fn polynomial(
    n: usize,
    beta: &[DoubleDouble],
    x: DoubleDouble,
) -> (DoubleDouble, DoubleDouble, DoubleDouble) {
    let (mut p, mut before) = (DoubleDouble::new(1.0), DoubleDouble::new(0.0));
    let (mut d, mut d_before) = (DoubleDouble::new(0.0), DoubleDouble::new(0.0));
    for k in 0..n {
        let b = if k == 0 { DoubleDouble::new(0.0) } else { beta[k] };
        let next = x.mul(p).sub(b.mul(before));
        let slope = p.add(x.mul(d)).sub(b.mul(d_before));
        (before, d_before, p, d) = (p, d, next, slope);
    }
    (p, d, before)
}

/// The zeros of p_n between those of p_{n−1}, by bisection.
fn interlaced_zeros(n: usize, beta: &[DoubleDouble], zeros: &[f64]) -> Vec<f64> {
    let value = |x: f64| polynomial(n, beta, DoubleDouble::new(x)).0.hi;
    let ends: Vec<f64> = [-1.0].into_iter().chain(zeros.iter().copied()).chain([1.0]).collect();
    let bracket = |w: &[f64]| {
        let (mut a, mut b) = (w[0], w[1]);
        let rising = value(b) > 0.0;
        for _ in 0..60 {
            let mid = 0.5 * (a + b);
            if (value(mid) > 0.0) == rising { b = mid } else { a = mid }
        }
        0.5 * (a + b)
    };
    if n == 0 { vec![] } else { ends.windows(2).map(bracket).collect() }
}

impl TriangleRule {
    fn new(n: usize, beta: &[DoubleDouble], zeros: &[f64]) -> TriangleRule {
        let mut rule = TriangleRule { nodes: vec![0.0; n], weights: vec![0.0; n] };
        // h_{n−1} = β_0 … β_{n−1}.
        let norm = beta[..n].iter().fold(DoubleDouble::new(1.0), |h, b| h.mul(*b));
        for i in 0..n.div_ceil(2) {
            let mut x = DoubleDouble::new(zeros[i]);
            for _ in 0..2 {
                let (p, d, _) = polynomial(n, beta, x);
                x = x.sub(p.div(d));
            }
            if 2 * i + 1 == n {
                x = DoubleDouble::new(0.0);
            }
            let (_, d, before) = polynomial(n, beta, x);
            let w = norm.div(d.mul(before)).hi;
            (rule.nodes[i], rule.nodes[n - 1 - i]) = (x.hi, -x.hi);
            (rule.weights[i], rule.weights[n - 1 - i]) = (w, w);
        }
        rule
    }
}
