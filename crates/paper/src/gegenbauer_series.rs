//! Proposition 2: the Gegenbauer series of 𝓕 along a strip of voxels, with its error.
//!
//! Voxel V_i, reference voxel V_0, voxel V_j = V_0 + s e, e a unit vector along an axis. With t = x_0 − x_i, r = |t|, cosθ = −t_e/r
//!
//! ```text
//! 1/|t + s e|² = Σ_n s^n a_n,   a_n = U_n(cosθ)/r^{n+2},   𝓕_ij = (V_iV_0/π) Σ_n s^n P_n,   P_n = E a_n,
//! ```
//!
//! E the mean over both voxels. One recurrence gives all a_n, a_{n+1} = c a_n − q a_{n−1}, c = −2t_e/r², q = 1/r²: one
//! division a point, then two products, a difference and a sum for each order.
//!
//! **Truncation.** For any s and N, f_s = 1/|t + s e|² is S_N + R_N with **exactly**
//!
//! ```text
//! R_N = s^{N+1} (r² a_{N+1} − s a_N) f_s        (p^{N+1}(U_{N+1} − pU_N) f_s with p = s/r).
//! ```
//!
//! **Quadrature.** The mean is a rule Q with positive weights of sum one. E f_s − Q S_N = (E − Q) f_s + Q R_N: the first is the error of the
//! rule for the **direct** integral of the pair (i, j), bounded by an ellipse at its distance (`trapezoid_gauss.rs`); the second a sum over nodes,
//!
//! ```text
//! |Q R_N| ≤ |s|^{N+1} G(s) max f_s,   G(s) = Q|r² a_{N+1} − s a_N|,
//! ```
//!
//! convex in s: at most the chord through G(0) and G(±S), S the reach. These three sums are taken with the moments, so that the weight
//! 1/r^{N+1} of every node and the decay of U_n across the line of sight are inside. max f_s is taken over the nodes' hull. Where it is
//! smaller, |Q R_N| ≤ b Q f_s with b = p̂^{N+1}(N+2+(N+1)p̂), p̂ = |s|/min r over the nodes, is used.
//!
//! **Rounding**, ε = 2⁻⁵³. Nodes are what floating point makes them; their distance from where they should be, δ, changes f_s by 2|δ|/r_s
//! relative (the caller's `node_error`). q carries 4ε, c 5ε, so that the recurrence is off by e_{n+1} = c e_n − q e_{n−1} + l, |l| ≤ η(|c a_n| + |q a_{n−1}|), η = 7ε
//! (`RECURRENCE_ROUNDINGS`). With |a_n| ≤ (n+1) r^{−n−2} and the same bound for the propagator, |e_n| ≤ η ½n(n+1)² r^{−n−2}, hence
//! Σ|s|^n|e_n| ≤ 3ηp̂/(1−p̂)⁴/r². Weights, sums and Horner's rule: (5 + sums + 2N + 2)ε Σ|s|^n Q|a_n| ≤ (…)ε/(1−p̂)²/r². In G, 4ε(N+2)³(1+p̂) r^{−N−1}.
//!
//! Lengths are in units of the strip's step, so that s is an integer, exact.

use super::tensor_nodes::{LANES, TensorNodes};
use crate::rounding::UNIT_ROUNDOFF;

/// Largest order of a series.
pub const MAX_ORDER: usize = 60;
/// η/ε: the relative errors of c (5) and of a product and a difference (2).
const RECURRENCE_ROUNDINGS: f64 = 5.0 + 2.0; // bound
/// Σ n(n+1)(n+2)/2 p^n = 3p/(1−p)⁴.
const ERROR_GROWTH: f64 = 3.0; // bound

/// Moments P_0 … P_N of a reference, and the sums that bound the truncation.
pub(super) struct GegenbauerMoments {
    /// N.
    pub order: usize,
    /// P_n in units of the step.
    pub p: [f64; MAX_ORDER + 1],
    /// G at 0, +S and −S, rounding inside.
    pub truncation_sums: [f64; 3],
    /// S, steps.
    pub reach: f64,
    /// Smallest distance over the nodes, steps.
    pub nearest: f64,
    /// Bound of the rounding errors of the value for |s| ≤ S.
    pub rounding: f64,
}

/// Sums over the nodes, lane by lane.
struct LaneSums {
    moments: [[f64; LANES]; MAX_ORDER + 1],
    /// |r² a_{N+1} − s a_N| at s = 0, +S and −S.
    truncation: [[f64; LANES]; 3],
}

/// b = p^{N+1}(N+2+(N+1)p): the truncation error relative to the (discrete) integral.
pub fn relative_truncation(order: usize, p: f64) -> f64 {
    let n = order as f64;
    p.powi(order as i32 + 1) * (n + 2.0 + (n + 1.0) * p)
}

/// The smallest order whose [`relative_truncation`] at ratio `p` < 1 is at most `tolerance`; [`MAX_ORDER`] + 1 if there is none.
pub(super) fn min_order(p: f64, tolerance: f64) -> usize {
    let (mut n, mut power) = (0.0, p);
    while n <= MAX_ORDER as f64 && power * (n + 2.0 + (n + 1.0) * p) > tolerance {
        n += 1.0;
        power *= p;
    }
    n as usize
}

/// The largest ratio p̂ ≤ 0.9, to a part in a thousand, at which [`relative_truncation`] of an order stays below `tolerance`.
pub(super) fn max_ratio(order: usize, tolerance: f64) -> f64 {
    let n = order as f64;
    let mut p: f64 = 0.5;
    for _ in 0..4 {
        p = (tolerance / (n + 2.0 + (n + 1.0) * p)).powf(1.0 / (n + 1.0)).min(0.9);
    }
    while relative_truncation(order, p) > tolerance {
        p *= 0.9995;
    }
    p
}

/// The moments about the reference at `centre` (difference of the centres, strip axis first, in steps) for shifts |s| ≤ `reach` < nearest.
#[inline(always)]
pub(super) fn gegenbauer_moments(
    nodes: &TensorNodes,
    centre: [f64; 3],
    order: usize,
    reach: f64,
) -> GegenbauerMoments {
    let mut sums = LaneSums { moments: [[0.0; LANES]; MAX_ORDER + 1], truncation: [[0.0; LANES]; 3] };
    let whole = nodes.blocks() / 4 * 4;
    for first in (0..whole).step_by(4) {
        accumulate_lanes::<{ 4 * LANES }>(nodes, first, centre, order, reach, &mut sums);
    }
    for first in whole..nodes.blocks() {
        accumulate_lanes::<LANES>(nodes, first, centre, order, reach, &mut sums);
    }
    let nearest = nodes.min_distance(centre);
    let mut p = [0.0; MAX_ORDER + 1];
    for n in 0..=order {
        p[n] = lane_sum(&sums.moments[n]);
    }
    let (n2, ratio) = (order as f64 + 2.0, reach / nearest);
    let slack = 4.0 * UNIT_ROUNDOFF * n2 * n2 * n2 * (1.0 + ratio) * nearest.powi(-(order as i32) - 1);
    let truncation_sums = sums.truncation.map(|t| 1.000_001 * lane_sum(&t) + slack);
    let rounding = rounding_bound(order, ratio, nodes.blocks()) / (nearest * nearest);
    GegenbauerMoments { order, p, truncation_sums, reach, nearest, rounding }
}

/// The bound of the header in units of 1/r².
fn rounding_bound(order: usize, ratio: f64, blocks: usize) -> f64 {
    let gap = 1.0 - ratio;
    let sums = 5.0 + (blocks as f64 + 12.0) + 2.0 * order as f64 + 2.0;
    let (growth, size) = if ratio <= MAX_RATIO_OF_CLOSED_SUMS {
        (ERROR_GROWTH * ratio / (gap * gap * gap * gap), 1.0 / (gap * gap))
    } else {
        finite_sums(order, ratio)
    };
    1.01 * UNIT_ROUNDOFF * (RECURRENCE_ROUNDINGS * growth + sums * size)
}

/// Largest ratio for which the infinite sums are used in closed form.
const MAX_RATIO_OF_CLOSED_SUMS: f64 = 0.6;

/// Σ ½n(n+1)² p^n and Σ (n+1) p^n up to n = `order`.
fn finite_sums(order: usize, ratio: f64) -> (f64, f64) {
    let (mut growth, mut size, mut power) = (0.0, 0.0, 1.0);
    for n in 0..=order {
        let n = n as f64;
        growth += 0.5 * n * (n + 1.0) * (n + 1.0) * power;
        size += (n + 1.0) * power;
        power *= ratio;
    }
    (growth, size)
}

#[inline(always)]
fn lane_sum(x: &[f64; LANES]) -> f64 {
    ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7]))
}

/// `L` nodes from block `first` on.
#[inline(always)]
fn accumulate_lanes<const L: usize>(
    nodes: &TensorNodes,
    first: usize,
    centre: [f64; 3],
    order: usize,
    reach: f64,
    sums: &mut LaneSums,
) {
    let (e, u, v, w) = nodes.lanes_from::<L>(first);
    let (mut c, mut q, mut a0, mut a1) = ([0.0; L], [0.0; L], [0.0; L], [0.0; L]);
    for l in 0..L {
        let (x, y, z) = (centre[0] + e[l], centre[1] + u[l], centre[2] + v[l]);
        q[l] = 1.0 / (x * x + y * y + z * z);
        c[l] = -2.0 * x * q[l];
        a0[l] = w[l] * q[l];
        a1[l] = c[l] * a0[l];
    }
    add_lanes(&mut sums.moments[0], &a0);
    for n in 1..=order {
        add_lanes(&mut sums.moments[n], &a1);
        for l in 0..L {
            let a2 = c[l] * a1[l] - q[l] * a0[l];
            a0[l] = a1[l];
            a1[l] = a2;
        }
    }
    let (mut at0, mut plus, mut minus) = ([0.0; L], [0.0; L], [0.0; L]);
    for l in 0..L {
        let next = a1[l] / q[l];
        at0[l] = next.abs();
        plus[l] = (next - reach * a0[l]).abs();
        minus[l] = (next + reach * a0[l]).abs();
    }
    add_lanes(&mut sums.truncation[0], &at0);
    add_lanes(&mut sums.truncation[1], &plus);
    add_lanes(&mut sums.truncation[2], &minus);
}

#[inline(always)]
fn add_lanes<const L: usize>(sum: &mut [f64; LANES], x: &[f64; L]) {
    for l in 0..LANES {
        let mut s = x[l];
        for k in 1..L / LANES {
            s += x[l + k * LANES];
        }
        sum[l] += s;
    }
}

/// Values and truncation bounds (without rounding) at `LANES` shifts s, |s| ≤ S. `fold` is the largest 1/r_s² over the nodes' hull.
#[inline(always)]
pub(super) fn evaluate_series(
    m: &GegenbauerMoments,
    s: [f64; LANES],
    fold: [f64; LANES],
) -> ([f64; LANES], [f64; LANES]) {
    let (mut value, mut power) = ([m.p[m.order]; LANES], [1.0; LANES]);
    for n in (0..m.order).rev() {
        for l in 0..LANES {
            value[l] = value[l] * s[l] + m.p[n];
            power[l] *= s[l].abs();
        }
    }
    let n = m.order as f64;
    let scale = m.nearest.powi(-(m.order as i32) - 1);
    let inverse = if m.reach > 0.0 { 1.0 / m.reach } else { 0.0 };
    let mut bound = [0.0; LANES];
    for l in 0..LANES {
        let size = s[l].abs();
        let power = power[l] * size;
        let share = size * inverse;
        let far = if s[l] > 0.0 { m.truncation_sums[1] } else { m.truncation_sums[2] };
        let sharp = power * fold[l] * (m.truncation_sums[0] + share * (far - m.truncation_sums[0]));
        let p = size / m.nearest;
        let b = power * scale * (n + 2.0 + (n + 1.0) * p);
        // Q f ≤ (|Q S_N| + rounding)/(1 − b).
        let plain = if b < 0.5 { b * (value[l].abs() + m.rounding) / (1.0 - b) } else { f64::INFINITY };
        bound[l] = 1.000_01 * if plain < sharp { plain } else { sharp };
    }
    (value, bound)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn max_ratio_and_min_order_are_consistent() {
        for tolerance in [1e-3, 1e-6, 1e-9, 1e-12] {
            for order in [0, 1, 4, 10, 25, 60] {
                let p = max_ratio(order, tolerance);
                assert!(relative_truncation(order, p) <= tolerance);
                assert!(
                    p == 0.9 || relative_truncation(order, 1.001 * p) > tolerance,
                    "{order} {tolerance} {p}"
                );
                assert!(min_order(p, tolerance) <= order);
            }
        }
    }

    /// Σ n(n+1)(n+2)/2 p^n is 3p/(1−p)⁴, and bounds the finite sum.
    #[test]
    fn error_growth_bounds_the_finite_sum() {
        for p in [0.1f64, 0.3, 0.6] {
            let sum: f64 =
                (1..400).map(|n| n as f64).map(|n| 0.5 * n * (n + 1.0) * (n + 2.0) * p.powf(n)).sum();
            assert!((ERROR_GROWTH * p / (1.0 - p).powi(4) / sum - 1.0).abs() < 1e-12);
            assert!(
                finite_sums(60, p).0 <= sum * (1.0 + 1e-12)
                    && finite_sums(60, p).1 <= (1.0 + 1e-12) / ((1.0 - p) * (1.0 - p))
            );
        }
    }

    /// The constant counts the roundings of c and of one step: (t·t 3, division 1, product 1) + (product, difference).
    #[test]
    fn recurrence_constant_counts_its_roundings() {
        let (squares, division, product, step) = (3.0, 1.0, 1.0, 2.0);
        assert_eq!(RECURRENCE_ROUNDINGS, squares + division + product + step);
    }
}
