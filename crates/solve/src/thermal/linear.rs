//! Bands that zones mix: u = u⁰ + M u in units of power, by stabilised bi-conjugate gradients (van der Vorst).
//!
//! u_i = t_i s_i (W) is the power that zone i sends out and M u what it sends on of what arrives. M is not symmetric where shares differ from
//! zone to zone, but no entry is negative (beside those of weights that fall with temperature) and no column sums to more than 1:
//! power is lost or kept. Where the gradients come to nothing, power is passed on step by step, which never grows. The residual told is Σ|u⁰ + M u − u| / Σ|u⁰|, power that went astray.

use crate::columns;
use rayon::prelude::*;
use zonal_scene::{Bands, bands};

/// Steps without a new smallest residual after which no better one is waited for.
const PATIENCE: usize = 30;

/// Where an iteration ended.
pub(super) struct End {
    pub u: Vec<Bands>,
    pub residual: f64,
    /// Products taken.
    pub products: usize,
}

fn dot(a: &[Bands], b: &[Bands]) -> f64 {
    columns::sum(a.len(), |i| [a[i][0] * b[i][0] + a[i][1] * b[i][1] + a[i][2] * b[i][2]])[0]
}

/// Σ|a|.
pub(super) fn power(a: &[Bands]) -> f64 {
    columns::sum(a.len(), |i| [a[i][0].abs() + a[i][1].abs() + a[i][2].abs()])[0]
}

fn combined(x: &[Bands], f: impl Fn(usize, usize) -> f64 + Sync) -> Vec<Bands> {
    (0..x.len()).into_par_iter().map(|i| bands(|b| f(i, b))).collect()
}

/// Solves u = `source` + `passed`(u) from `start` to the residual `wanted`, in at most `steps` steps of two products.
pub(super) fn solve(
    passed: impl Fn(&[Bands]) -> Vec<Bands>,
    source: &[Bands],
    start: Vec<Bands>,
    wanted: f64,
    steps: usize,
) -> End {
    let given = power(source);
    let mut end = End { residual: 0.0, products: 0, u: start };
    let mut r = rest(&passed, source, &mut end, given);
    if end.residual <= wanted {
        return end;
    }
    gradients(&passed, &mut r, &mut end, given, wanted, steps);
    if end.residual > wanted {
        r = rest(&passed, source, &mut end, given);
    }
    // What is left, passed on: r is what one more pass brings.
    while end.residual > wanted && end.products < 2 * steps {
        end.u = combined(&r, |i, b| end.u[i][b] + r[i][b]);
        r = passed(&r);
        end.products += 1;
        end.residual = power(&r) / given;
    }
    end
}

/// source + M u − u, and its share of what is given.
fn rest(passed: &impl Fn(&[Bands]) -> Vec<Bands>, source: &[Bands], end: &mut End, given: f64) -> Vec<Bands> {
    let m = passed(&end.u);
    end.products += 1;
    let r = combined(&m, |i, b| source[i][b] + m[i][b] - end.u[i][b]);
    end.residual = if given > 0.0 { power(&r) / given } else { 0.0 };
    r
}

/// Bi-conjugate gradients from a residual; `end` is the best found.
fn gradients(
    passed: &impl Fn(&[Bands]) -> Vec<Bands>,
    r: &mut Vec<Bands>,
    end: &mut End,
    given: f64,
    wanted: f64,
    steps: usize,
) {
    let taken = |p: &[Bands]| {
        let m = passed(p);
        combined(p, |i, b| p[i][b] - m[i][b])
    };
    let (shadow, mut p, mut u) = (r.clone(), r.clone(), end.u.clone());
    let mut rho = dot(&shadow, r);
    let mut since = 0;
    for _ in 0..steps {
        let v = taken(&p);
        let along = dot(&shadow, &v);
        if along == 0.0 || !along.is_finite() {
            return;
        }
        let alpha = rho / along;
        let s = combined(r, |i, b| r[i][b] - alpha * v[i][b]);
        let t = taken(&s);
        end.products += 2;
        let tt = dot(&t, &t);
        let omega = if tt > 0.0 { dot(&t, &s) / tt } else { 0.0 };
        u = combined(&u, |i, b| u[i][b] + alpha * p[i][b] + omega * s[i][b]);
        *r = combined(&s, |i, b| s[i][b] - omega * t[i][b]);
        let residual = power(r) / given;
        since += 1;
        if residual < end.residual {
            (end.u, end.residual, since) = (u.clone(), residual, 0);
        }
        if end.residual <= wanted || since > PATIENCE || !residual.is_finite() || omega == 0.0 {
            return;
        }
        let next = dot(&shadow, r);
        let beta = next / rho * (alpha / omega);
        rho = next;
        p = combined(&p, |i, b| r[i][b] + beta * (p[i][b] - omega * v[i][b]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_passed_on_in_a_ring_adds_up() {
        // Zone i sends 0.9 of what it has to zone i + 1, bands in turn.
        let n = 50;
        let passed = |u: &[Bands]| -> Vec<Bands> {
            (0..n).map(|i| bands(|b| 0.9 * u[(i + n - 1) % n][(b + 1) % 3])).collect()
        };
        let mut source = vec![[0.0; 3]; n];
        source[3] = [1.0, 2.0, 4.0];
        let end = solve(passed, &source, source.clone(), 1e-12, 500);
        assert!(end.residual <= 1e-12, "{:e}", end.residual);
        assert!((power(&end.u) - 70.0).abs() < 1e-8);
    }
}
