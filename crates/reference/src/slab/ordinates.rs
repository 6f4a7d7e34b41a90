//! Ordinates of a half range: μ = s³ at the Gauss points of s in 0 to 1.

use std::f64::consts::PI;

/// Number of Gauss points of a half range.
const HALF_RANGE_POINTS: usize = 96;

/// Direction cosine and weight: Σ w f(μ) = ∫ f dμ from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ordinate {
    pub cosine: f64,
    pub weight: f64,
}

/// The ordinates of a half range.
pub(super) fn half_range() -> Vec<Ordinate> {
    let of = |k: usize| {
        let (x, w) = gauss_point(k, HALF_RANGE_POINTS);
        let s = 0.5 * (1.0 + x);
        Ordinate { cosine: s * s * s, weight: 1.5 * w * s * s }
    };
    (0..HALF_RANGE_POINTS).map(of).collect()
}

/// Gauss point `k` of `n` on −1 to 1 and its weight, by Newton's method on the Legendre polynomial.
fn gauss_point(k: usize, n: usize) -> (f64, f64) {
    let mut x = (PI * (k as f64 + 0.75) / (n as f64 + 0.5)).cos();
    let mut slope = 1.0;
    for _ in 0..20 {
        let (mut before, mut p) = (1.0, x);
        for m in 2..=n {
            let m = m as f64;
            (before, p) = (p, ((2.0 * m - 1.0) * x * p - (m - 1.0) * before) / m);
        }
        slope = n as f64 * (x * p - before) / (x * x - 1.0);
        x -= p / slope;
    }
    (x, 2.0 / ((1.0 - x * x) * slope * slope))
}
