//! The paper's "analogous results": Gegenbauer series for a voxel and a patch (λ = 3/2) and for two patches (λ = 2), either zone displaced along an axis.
//!
//! ```text
//! 𝓕(s) = W E[ n(t + s e)/|t + s e|^{2λ} ],   1/|t + s e|^{2λ} = Σ_n s^n a_n,   a_n = C_n^λ(cosθ)/r^{n+2λ},   cosθ = −t_e/r,
//! a_{n+1} = α_n c a_n − β_n q a_{n−1},   α_n = (n+λ)/(n+1),   β_n = (n+2λ−1)/(n+1),   c = −2t_e/r²,   q = 1/r².
//! ```
//!
//! The numerator n is t_n, t_n², or t_x t_z: on the strip's axis it is (t_e + s)^{p_e}, constant, linear or quadratic in s, multiplied
//! exactly: with moments P_n^i = E[n̄ t_e^{p_e−i} a_n], n̄ the part of the other axes, 𝓕 = W Σ_n s^n Σ_i binom(p_e, i) s^i P_n^i.
//!
//! **Truncation.** With D(s) = r_s²/r² and p = s/r, the remainder of Σ p^n C_n is an integral over [0, p]. D is convex, so
//! D^{λ−1} ≤ max(1, D(p))^{λ−1}; |(N+1)C_{N+1} − s(N+2λ)C_N| is at most its chord. Both integrals are then elementary:
//!
//! ```text
//! |R_N| ≤ D^{−λ} max(1, D)^{λ−1} |p|^{N+1}/(N+2) [ |C_{N+1}| + |(N+1)C_{N+1} − p(N+2λ)C_N| ].
//! ```
//!
//! The second modulus is convex in s again: sums over the nodes at s = 0 and at the reach ±S bound all between. n ≥ 0 and 1/r_s^{2λ} are taken out with
//! their largest values over the nodes' hull at s. Since everything lies in front (n ≥ 0), the bound is also relative, with |C_n^λ| ≤ K_n = binom(n+2λ−1, n):
//! b = p̂^{N+1}(1+p̂)^{2λ−2}[K_{N+1} + p̂ (N+2λ)/(N+2) K_N]. The smaller of the two counts.
//!
//! **Front.** A pair that is not wholly in front of its patches, or whose reference is not, has the exact integral.
//!
//! **Quadrature.** As in `gegenbauer.rs`: the error of the rule for the direct integral at s, from the ellipses of `clipped_pair.rs`.
//!
//! **Rounding.** Let a_n = K_n r^{−n−2λ} h_n. The recurrence is h_{n+1} = (1+ν)x h_n − ν h_{n−1}, ν = n/(n+2λ) < 1, and the energy
//! (x h_n − h_{n−1})² + (1−x²) h_n² does not grow; so an error δ in h_k is at most (1+n−k)δ in h_n. Each step commits at most
//! 3η, η = 9ε (`RECURRENCE_ROUNDINGS`): |e_n| ≤ (3/2)η n(n+1) K_n r^{−n−2λ}. Sums and Horner's rule as in `gegenbauer.rs`. Lengths are in units of the step.
//!
//! e^{−κr} is outside, as in `voxel_strips.rs`.

use super::clipped_pair::{ClippedPair, clipped_pair};
use super::gegenbauer_series::MAX_ORDER;
use super::proposition1::{self, CentreCorrection};
use super::tensor_nodes::{AxisRule, TensorNodes};
use super::trapezoid_gauss;
use crate::rounding::UNIT_ROUNDOFF;
use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_exchange::{AccuracyRequest, Factor, Method};
use zonal_math::Bounded;

/// η/ε: c (5), two coefficients (2), a product and a difference (2).
const RECURRENCE_ROUNDINGS: f64 = 5.0 + 2.0 + 2.0; // bound
/// Σ_{k ≤ n} 3(1 + n − k) = (3/2) n(n+1).
const ERROR_GROWTH: f64 = 1.5; // bound
/// Smallest relative tolerance of the exact integral.
const MIN_TOLERANCE: f64 = 1e-13;
/// Largest planned ratio of a segment.
const MAX_PLANNED_RATIO: f64 = 0.6;
/// Share of the tolerance for truncation.
const TRUNCATION_SHARE: f64 = 0.7;
/// Share of the tolerance for quadrature.
const QUADRATURE_SHARE: f64 = 0.1;

/// K_n = binom(n + 2λ − 1, n) for 2λ = `q`.
fn max_gegenbauer(n: usize, q: i32) -> f64 {
    (1..q).map(|i| (n as f64 + i as f64) / i as f64).product()
}

/// The relative truncation bound b of the header.
fn relative_truncation(order: usize, p: f64, q: i32) -> f64 {
    let n = order as f64;
    p.powi(order as i32 + 1)
        * (1.0 + p).powi(q - 2)
        * (max_gegenbauer(order + 1, q) + p * (n + q as f64) / (n + 2.0) * max_gegenbauer(order, q))
}

/// A row of equal zones along an axis, seen from a zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZoneRow {
    /// The zone opposite the row.
    pub from: Cuboid,
    /// The first of the row.
    pub first: Cuboid,
    /// The axis along which the row runs.
    pub axis: usize,
    /// Distance of neighbours, m.
    pub step: f64,
    /// Number of zones.
    pub count: usize,
}

impl ZoneRow {
    /// The `i`-th zone.
    pub fn zone(&self, i: usize) -> Cuboid {
        let mut b = self.first;
        for c in [&mut b.lo, &mut b.hi] {
            let mut a = c.array();
            a[self.axis] += self.step * i as f64;
            *c = zonal_math::vec3(a[0], a[1], a[2]);
        }
        b
    }
}

/// Sums over the nodes of a reference.
struct PatchMoments {
    order: usize,
    /// P_n^i.
    p: Vec<[f64; 3]>,
    /// Z at 0 (|C_{N+1}| alone), and the second modulus at +S and −S.
    truncation_sums: [f64; 3],
    reach: f64,
    nearest: f64,
    rounding: f64,
    half: [f64; 3],
}

/// The reference pair in units of the step.
struct RowReference {
    pair: ClippedPair,
    centre: [f64; 3],
    nodes: TensorNodes,
    points: [usize; 3],
}

fn row_reference(pair: &ClippedPair, axis: usize, step: f64, points: [usize; 3]) -> RowReference {
    let lines = [0, 1, 2].map(|k| {
        let mut line = AxisRule::trapezoid(&pair.densities[k], points[k]);
        line.nodes.iter_mut().for_each(|x| *x /= step);
        line
    });
    let axes = [axis, (axis + 1) % 3, (axis + 2) % 3];
    let nodes = TensorNodes::tensor(axes.map(|k| &lines[k]));
    RowReference { pair: *pair, centre: axes.map(|k| pair.centre[k] / step), nodes, points }
}

fn patch_moments(r: &RowReference, axis: usize, order: usize, reach: f64) -> PatchMoments {
    let (q, power) =
        (r.pair.distance_power(), [axis, (axis + 1) % 3, (axis + 2) % 3].map(|k| r.pair.power[k]));
    let lambda = 0.5 * q as f64;
    let mut p = vec![[0.0; 3]; order + 1];
    let mut tail = [0.0; 3];
    for block in 0..r.nodes.blocks() {
        let (e, u, v, w) = r.nodes.lanes_from::<8>(block);
        for l in (0..8).filter(|&l| w[l] > 0.0) {
            let (x, y, z) = (r.centre[0] + e[l], r.centre[1] + u[l], r.centre[2] + v[l]);
            let r2 = x * x + y * y + z * z;
            let (inverse, rest) = (1.0 / r2, w[l] * y.powi(power[1]) * z.powi(power[2]));
            let c = -2.0 * x * inverse;
            let (mut before, mut now) = (0.0, r2.powf(-lambda));
            for n in 0..=order {
                let mut term = rest * now;
                for i in (0..=power[0] as usize).rev() {
                    p[n][i] += term;
                    term *= x;
                }
                let k = n as f64;
                let next =
                    ((k + lambda) * (c * now) - (k + 2.0 * lambda - 1.0) * (inverse * before)) / (k + 1.0);
                (before, now) = (now, next);
            }
            // now = a_{N+1}, before = a_N; times r^q and r^{q−2}.
            let scale = r2.powf(lambda);
            let (top, low) = (now * scale, (order as f64 + 2.0 * lambda) * before * scale * inverse);
            let excess = |s: f64| {
                let d = ((x + s) * (x + s) + y * y + z * z) * inverse;
                d.max(1.0).powf(lambda - 1.0)
            };
            let (plus, minus) = (excess(reach), excess(-reach));
            let first = (order as f64 + 1.0) * top;
            tail[0] += rest * top.abs() * plus.max(minus);
            tail[1] += rest * (first - reach * low).abs() * plus;
            tail[2] += rest * (first + reach * low).abs() * minus;
        }
    }
    bound_moments(r, power, order, reach, p, tail)
}

fn bound_moments(
    r: &RowReference,
    power: [i32; 3],
    order: usize,
    reach: f64,
    p: Vec<[f64; 3]>,
    tail: [f64; 3],
) -> PatchMoments {
    let q = r.pair.distance_power();
    let nearest = r.nodes.min_distance(r.centre);
    let far = |k: usize| r.centre[k].abs() + r.nodes.half_extents[k];
    let rest = far(1).powi(power[1]) * far(2).powi(power[2]);
    let ratio = reach / nearest;
    let (mut growth, mut size, mut shift) = (0.0, 0.0, 1.0);
    for n in 0..=order {
        let k = n as f64;
        growth += k * (k + 1.0) * max_gegenbauer(n, q) * shift;
        size += max_gegenbauer(n, q) * shift;
        shift *= ratio;
    }
    let sums = 12.0 + r.nodes.count as f64 + 2.0 * order as f64 + 8.0;
    let front = rest * (far(0) + reach).powi(power[0]) * nearest.powi(-q);
    let rounding =
        1.01 * UNIT_ROUNDOFF * front * (RECURRENCE_ROUNDINGS * ERROR_GROWTH * growth + sums * size);
    // The recurrence's error in C_{N+1} and C_N, with D ≤ (1 + p)².
    let n = order as f64 + 2.0;
    let slack = 1.01
        * UNIT_ROUNDOFF
        * RECURRENCE_ROUNDINGS
        * ERROR_GROWTH
        * n
        * (n + 1.0)
        * n
        * 2.0
        * max_gegenbauer(order + 1, q)
        * (1.0 + ratio).powi(q - 1)
        * rest
        * nearest.powi(-(order as i32) - 1);
    let truncation_sums = tail.map(|t| 1.000_001 * t + slack);
    PatchMoments { order, p, truncation_sums, reach, nearest, rounding, half: r.nodes.half_extents }
}

/// Value and bound of truncation and rounding of the mean at shift `s`, in units of the step.
fn evaluate_series(m: &PatchMoments, r: &RowReference, axis: usize, s: f64) -> (f64, f64) {
    let (q, power) =
        (r.pair.distance_power(), [axis, (axis + 1) % 3, (axis + 2) % 3].map(|k| r.pair.power[k]));
    let choose = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 2.0, 1.0]][power[0] as usize];
    let mut value = 0.0;
    for p in m.p.iter().rev() {
        value = value * s + (choose[0] * p[0] + s * (choose[1] * p[1] + s * (choose[2] * p[2])));
    }
    let gap = |k: usize, s: f64| ((r.centre[k] + s).abs() - m.half[k]).max(0.0);
    let near2 = gap(0, s) * gap(0, s) + gap(1, 0.0) * gap(1, 0.0) + gap(2, 0.0) * gap(2, 0.0);
    let numerator = ((r.centre[0] + s).abs() + m.half[0]).powi(power[0]);
    let share = if m.reach > 0.0 { s.abs() / m.reach } else { 0.0 };
    let far = if s > 0.0 { m.truncation_sums[1] } else { m.truncation_sums[2] };
    let n = m.order as f64;
    let second = (n + 1.0) * m.truncation_sums[0] * (1.0 - share) + share * far;
    let sharp = s.abs().powi(m.order as i32 + 1) / (n + 2.0)
        * numerator
        * (near2 * (1.0 - 1e-13)).powf(-0.5 * q as f64)
        * (m.truncation_sums[0] + second);
    let b = relative_truncation(m.order, s.abs() / m.nearest, q);
    let plain = if b < 0.5 { b * (value.abs() + m.rounding) / (1.0 - b) } else { f64::INFINITY };
    (value, 1.000_01 * sharp.min(plain) + m.rounding)
}

/// The factors of a row by one reference's series of a given order; a zone that is not wholly in front, or the same for the reference, takes the exact integral.
///
/// # Panics
/// On invalid zones, an order above [`MAX_ORDER`], a reference outside the row, a step that is not positive.
pub fn single_reference_row(row: &ZoneRow, reference: usize, order: usize) -> Vec<Factor> {
    assert!(order <= MAX_ORDER && reference < row.count && row.step > 0.0, "order {order} of {row:?}");
    serve_row_segment(row, 0, reference, row.count - 1, Some(order), MIN_TOLERANCE)
}

/// The factors of a row to a relative tolerance: references are chosen as in `voxel_strips.rs`.
///
/// # Panics
/// On invalid zones, a step or a tolerance that is not positive.
pub fn row_factors(row: &ZoneRow, demand: &AccuracyRequest) -> Vec<Factor> {
    assert!(row.step > 0.0, "step {} m", row.step);
    let mut out = Vec::with_capacity(row.count);
    let distance = |i: usize| {
        let b = row.zone(i);
        clipped_pair(&row.from, &b).filter(|p| p.is_unclipped(&row.from, &b)).map_or(0.0, |p| p.distance())
    };
    while out.len() < row.count {
        let from = out.len();
        let reach = |i: usize| MAX_PLANNED_RATIO * distance(i) / row.step;
        let mut middle = from;
        while middle + 1 < row.count && (middle + 1 - from) as f64 <= reach(middle + 1) {
            middle += 1;
        }
        let to = (middle + reach(middle) as usize).min(row.count - 1);
        out.extend(serve_row_segment(row, from, middle, to, None, demand.tolerance));
    }
    out
}

/// One pair by the series about the neighbour of `b` one extent farther off along the axis of the largest distance, e^{−κd} outside; the exact
/// integral where no reference serves.
pub(super) fn pair_by_series(a: &Cuboid, b: &Cuboid, kappa: f64, demand: &AccuracyRequest) -> Factor {
    let offset = (b.lo + b.hi) - (a.lo + a.hi);
    let k = (0..3).fold(0, |m, k| if offset[k].abs() > offset[m].abs() { k } else { m });
    let step = b.extent().array().into_iter().fold(0.0, f64::max);
    let first = ZoneRow { from: *a, first: *b, axis: k, step, count: 2 };
    let before = ZoneRow { first: ZoneRow { step: -step, ..first }.zone(1), ..first };
    let (row, at) = if offset[k] < 0.0 { (before, 1) } else { (first, 0) };
    let base = if row.zone(at) == *b {
        serve_row_segment(&row, 0, 1 - at, 1, None, demand.tolerance)[at]
    } else {
        geometric_factor(a, b, 0.0, demand.tolerance.max(MIN_TOLERANCE))
    };
    if kappa == 0.0 {
        return base;
    }
    Factor {
        method: base.method,
        ..proposition1::attenuate_at_centres(a, b, kappa, &base, CentreCorrection::FirstOrder)
    }
}

/// Returns the factors of one segment.
fn serve_row_segment(
    row: &ZoneRow,
    from: usize,
    at: usize,
    to: usize,
    order: Option<usize>,
    tolerance: f64,
) -> Vec<Factor> {
    let exactly = |i: usize| geometric_factor(&row.from, &row.zone(i), 0.0, tolerance.max(MIN_TOLERANCE));
    let all = |i: usize| -> Option<ClippedPair> {
        let b = row.zone(i);
        clipped_pair(&row.from, &b).filter(|p| p.is_unclipped(&row.from, &b) && p.distance() > 0.0)
    };
    let Some(centre) = all(at) else { return (from..=to).map(exactly).collect() };
    let goal = if order.is_some() { 1e-15 } else { QUADRATURE_SHARE * tolerance };
    let mut points = [1; 3];
    for p in (from..=to).filter_map(all) {
        match p.points_for_error(0.0, goal * p.kernel(p.centre, 0.0).max(1e-300)) {
            Some(n) => points = [0, 1, 2].map(|k| points[k].max(n[k])),
            None if order.is_some() => points = [trapezoid_gauss::MAX_POINTS; 3],
            None => return (from..=to).map(exactly).collect(),
        }
    }
    let r = row_reference(&centre, row.axis, row.step, points);
    let reach = (at - from).max(to - at) as f64;
    let ratio = reach / r.nodes.min_distance(r.centre);
    let n = order.or_else(|| {
        (0..=MAX_ORDER)
            .find(|&n| relative_truncation(n, ratio, r.pair.distance_power()) <= TRUNCATION_SHARE * tolerance)
    });
    let Some(order_used) = n else { return (from..=to).map(exactly).collect() };
    let m = patch_moments(&r, row.axis, order_used, reach);
    let one = |i: usize| {
        let Some(p) = all(i) else { return exactly(i) };
        let f = series_factor(&m, &r, &p, row, i as f64 - at as f64);
        let missed = order.is_none() && f.bounded.radius > tolerance * f.bounded.value;
        if missed { exactly(i) } else { f }
    };
    (from..=to).map(one).collect()
}

fn series_factor(m: &PatchMoments, r: &RowReference, p: &ClippedPair, row: &ZoneRow, shift: f64) -> Factor {
    let (value, bound) = evaluate_series(m, r, row.axis, shift * p.sign[row.axis]);
    let defect = |k: usize| r.nodes.defect[(k + 3 - row.axis) % 3];
    let quadrature = p.quadrature_error([0, 1, 2].map(|k| (r.points[k], defect(k))), 0.0);
    // The mean has the dimension 1/m² whatever the zones are.
    let unit = 1.0 / (row.step * row.step);
    let p = p.with_lattice_rounding(&[&row.from, &row.first, &row.zone(row.count - 1)]);
    // The reference's coordinates and the pair's are both rounded.
    let shaken = 2.0 * p.displacement_error(p.distance(), 0.0);
    let radius =
        (bound + (16.0 * UNIT_ROUNDOFF + p.relative_error) * value.abs()) * unit + quadrature + shaken;
    let factor = Bounded::proved(p.weight * value * unit, 1.000_001 * p.weight * radius);
    Factor { bounded: factor, evaluations: (r.nodes.count * (m.order + 1)) as u64, method: Method::Series }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The constants count: c five roundings, coefficients two, a step two; Σ_{k ≤ n} 3(1+n−k) = (3/2)n(n+1).
    #[test]
    fn rounding_constants_follow_their_derivation() {
        let (c, coefficients, step) = (5.0, 2.0, 2.0);
        assert_eq!(RECURRENCE_ROUNDINGS, c + coefficients + step);
        let n = 17;
        let sum: f64 = (1..=n).map(|k| 3.0 * (1 + n - k) as f64).sum();
        assert_eq!(ERROR_GROWTH * (n * (n + 1)) as f64, sum);
    }

    /// |C_n^λ| ≤ C_n^λ(1), from the recurrence at x = 1.
    #[test]
    fn max_gegenbauer_is_the_value_at_one() {
        for q in [2, 3, 4] {
            let lambda = 0.5 * q as f64;
            let (mut before, mut now) = (0.0, 1.0);
            for n in 0..20 {
                assert!((max_gegenbauer(n, q) / now - 1.0).abs() < 1e-13);
                let k = n as f64;
                let next = (2.0 * (k + lambda) * now - (k + 2.0 * lambda - 1.0) * before) / (k + 1.0);
                (before, now) = (now, next);
            }
        }
    }

    /// The relative bound is reached: along the line of sight, approaching, at x = 1, within (1 + p)^{2λ−2}.
    #[test]
    fn relative_truncation_bounds_the_error_closely() {
        for q in [2, 3, 4] {
            let lambda = 0.5 * q as f64;
            for (order, p) in [(4, 0.3), (10, 0.5), (20, 0.6)] {
                for x in [-1.0, -0.4, 0.0, 0.7, 1.0] {
                    let d: f64 = 1.0 - 2.0 * p * x + p * p;
                    let (mut before, mut now, mut sum, mut power) = (0.0, 1.0, 0.0, 1.0);
                    for n in 0..=order {
                        sum += power * now;
                        power *= p;
                        let k = n as f64;
                        let next =
                            (2.0 * (k + lambda) * x * now - (k + 2.0 * lambda - 1.0) * before) / (k + 1.0);
                        (before, now) = (now, next);
                    }
                    let off = (1.0 - sum * d.powf(lambda)).abs();
                    let b = relative_truncation(order, p, q);
                    assert!(off <= b * (1.0 + 1e-9) + 1e-15, "{q} {order} {p} {x}: {off:e} {b:e}");
                    if x == -1.0 {
                        assert!(off >= 0.2 * b, "{q} {order} {p}: {off:e} {b:e}");
                    }
                }
            }
        }
    }
}
