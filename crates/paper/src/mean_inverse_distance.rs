//! Mean inverse distances of two boxes, proved, touching or not: the ingredients of the constant of Proposition 1.
//!
//! E r^{−q} for q = 1, 2 over two voxels, by the difference t = x_b − x_a: its density is a product of trapezoids, cut at the breakpoints and at zero and
//! folded onto t ≥ 0, linear on each cell. A cell with t = 0 as a corner is halved along its longest edge until its edges are similar (ratio ≤ 1.6), then
//! taken in pyramid coordinates t_k = d_k s, t_j = d_j s v, t_i = d_i s w: the integrand is ω s^{2−q} Q^{−q}, Q² = d_k² + d_j²v² + d_i²w²,
//! a polynomial of degree ≤ 4 in s and analytic in v and w. Any other cell is halved until its distance is at least 3/4 of its longest edge.
//!
//! **Error.** Rules of n = `POINTS_PER_DIRECTION` points. In v: on the ellipse of semi-axes A, B around [0, 1], |Q²| ≥ d_j² R, R ≥ c² + min Re v² with c = d_k/d_j ≥ 5/8
//! (header of `aligned::ellipse`: X = h = ½, so min Re v² = −B²(1 − ¼/(A²+B²))), density at most ω_max(½ + A)·2. In t_k of a cell apart: |t·t| ≥ R of
//! `trapezoid_gauss::floor`, density at most ω_max (1 + A/h)/1. The error of a direction is (32/15) M ϱ^{−2n}/(1 − ϱ^{−2}); three directions add.
//! All terms are positive: rounding is at most (`ROUNDINGS_PER_TERM` + 3n)ε relative.

use super::trapezoid_gauss;
use crate::rounding::UNIT_ROUNDOFF;
use zonal_exchange::aligned::Cuboid;
use zonal_math::{Bounded, gauss_legendre};

/// Gauss–Legendre points in every direction.
const POINTS_PER_DIRECTION: usize = 20;
/// Relative rounding of a term, ε.
const ROUNDINGS_PER_TERM: f64 = 120.0;
/// Largest ratio of the longest to the shortest edge of a touching cell. Halving the longest reaches 2^{2/3} < 1.59 for any three edges: the logarithms to base two,
/// modulo one, leave a gap of a third of the circle somewhere; a smaller limit might never be reached.
const MAX_EDGE_RATIO: f64 = 1.6;
/// Smallest distance of a separated cell, relative to its longest edge.
const MIN_RELATIVE_DISTANCE: f64 = 0.75;

/// A piece of an axis, folded onto t ≥ 0, its density linear from w.0 to w.1.
#[derive(Clone, Copy, Debug)]
struct DensitySpan {
    lo: f64,
    len: f64,
    w: (f64, f64),
}

impl DensitySpan {
    fn halves(self) -> [DensitySpan; 2] {
        let (half, middle) = (0.5 * self.len, 0.5 * (self.w.0 + self.w.1));
        [
            DensitySpan { len: half, w: (self.w.0, middle), ..self },
            DensitySpan { lo: self.lo + half, len: half, w: (middle, self.w.1) },
        ]
    }
    fn density_at(&self, u: f64) -> f64 {
        self.w.0 * (1.0 - u) + self.w.1 * u
    }
    fn max_density(&self) -> f64 {
        self.w.0.max(self.w.1)
    }
}

/// The pieces of axis `k` of the distance of two voxels; densities integrate to one.
fn density_spans(a: &Cuboid, b: &Cuboid, k: usize) -> Vec<DensitySpan> {
    let (la, lb) = (a.hi[k] - a.lo[k], b.hi[k] - b.lo[k]);
    let (long, short) = (la.max(lb), la.min(lb));
    let (q, r) = (b.lo[k] - a.lo[k], b.hi[k] - a.hi[k]);
    let p = [b.lo[k] - a.hi[k], q.min(r), q.max(r), b.hi[k] - a.lo[k]];
    let level = 1.0 / long;
    let mut out = Vec::with_capacity(6);
    let mut piece = |from: f64, to: f64, len: f64, w0: f64, w1: f64| {
        if len <= 0.0 {
        } else if from >= 0.0 {
            out.push(DensitySpan { lo: from, len, w: (w0, w1) });
        } else if to <= 0.0 {
            out.push(DensitySpan { lo: -to, len, w: (w1, w0) });
        } else {
            let w = (w0 * to - w1 * from) / (to - from);
            out.push(DensitySpan { lo: 0.0, len: to, w: (w, w1) });
            out.push(DensitySpan { lo: 0.0, len: -from, w: (w, w0) });
        }
    };
    piece(p[0], p[1], short, 0.0, level);
    piece(p[1], p[2], long - short, level, level);
    piece(p[2], p[3], short, level, 0.0);
    out
}

type SpanCell = [DensitySpan; 3];

/// E r^{−q} over two voxels, q = 1 or 2, in m^{−q}.
///
/// # Panics
/// On boxes that are no voxels, another q.
pub fn mean_inverse_power(a: &Cuboid, b: &Cuboid, q: i32) -> Bounded {
    assert!(a.normal.is_none() && b.normal.is_none() && a.is_valid() && b.is_valid());
    assert!(q == 1 || q == 2, "power {q}");
    let [x, y, z] = [0, 1, 2].map(|k| density_spans(a, b, k));
    let mut stack: Vec<SpanCell> = Vec::new();
    for &x in &x {
        for &y in &y {
            z.iter().for_each(|&z| stack.push([x, y, z]));
        }
    }
    let (mut value, mut error, mut cuts) = (0.0, 0.0, 0u32);
    while let Some(cell) = stack.pop() {
        match admissible_rule(&cell) {
            Ok(touching) => {
                let (v, e) =
                    if touching { integrate_pyramids(&cell, q) } else { integrate_separated(&cell, q) };
                value += v;
                error += e;
            }
            Err(k) => {
                cuts += 1;
                let [near, far] = cell[k].halves();
                let (mut n, mut f) = (cell, cell);
                (n[k], f[k]) = (near, far);
                stack.extend([f, n]);
            }
        }
    }
    // Sums of cells, compensated by counting them; each cut rounds positions and densities once.
    let rounding =
        (ROUNDINGS_PER_TERM + 3.0 * POINTS_PER_DIRECTION as f64 + 2.0 * cuts as f64) * UNIT_ROUNDOFF;
    Bounded::proved(value, 1.000_001 * error + rounding * value)
}

/// Whether the cell touches zero where a rule is admissible, else the axis to halve.
fn admissible_rule(cell: &SpanCell) -> Result<bool, usize> {
    let len = cell.map(|s| s.len);
    let longest = (0..3).fold(0, |m, k| if len[k] > len[m] { k } else { m });
    let shortest = len.iter().copied().fold(f64::INFINITY, f64::min);
    let touching = cell.iter().all(|s| s.lo == 0.0);
    let g = cell.iter().map(|s| s.lo * s.lo).sum::<f64>().sqrt();
    let fine = if touching {
        len[longest] <= MAX_EDGE_RATIO * shortest
    } else {
        g >= MIN_RELATIVE_DISTANCE * len[longest]
    };
    if fine { Ok(touching) } else { Err(longest) }
}

fn integrate_separated(cell: &SpanCell, q: i32) -> (f64, f64) {
    let rule = gauss_legendre::rule(POINTS_PER_DIRECTION);
    let mut sum = 0.0;
    for i in 0..POINTS_PER_DIRECTION {
        let x = cell[0].lo + cell[0].len * rule.nodes[i];
        for j in 0..POINTS_PER_DIRECTION {
            let y = cell[1].lo + cell[1].len * rule.nodes[j];
            let w = rule.weights[i]
                * rule.weights[j]
                * cell[0].density_at(rule.nodes[i])
                * cell[1].density_at(rule.nodes[j]);
            for k in 0..POINTS_PER_DIRECTION {
                let z = cell[2].lo + cell[2].len * rule.nodes[k];
                let r2 = x * x + y * y + z * z;
                let f = if q == 2 { 1.0 / r2 } else { 1.0 / r2.sqrt() };
                sum += w * rule.weights[k] * cell[2].density_at(rule.nodes[k]) * f;
            }
        }
    }
    let volume: f64 = cell.iter().map(|s| s.len).product();
    let top: f64 = cell.iter().map(DensitySpan::max_density).product();
    let g = cell.iter().map(|s| s.lo * s.lo).sum::<f64>().sqrt() * (1.0 - 1e-14);
    let direction = |s: &DensitySpan| {
        let h = 0.5 * s.len;
        // `ellipses` gives E|t|²/R for a square of our choosing: with h² = 0 the square is g².
        trapezoid_gauss::ellipse_ratios(g, h, 0.0)
            .map(|(rho, m)| {
                let big = 0.5 * (rho + 1.0 / rho);
                gauss_legendre::error_bound(
                    POINTS_PER_DIRECTION,
                    rho,
                    top * (1.0 + big) * (m / (g * g)).powf(0.5 * q as f64),
                )
            })
            .fold(f64::INFINITY, f64::min)
    };
    (volume * sum, volume * cell.iter().map(direction).sum::<f64>())
}

fn integrate_pyramids(cell: &SpanCell, q: i32) -> (f64, f64) {
    let rule = gauss_legendre::rule(POINTS_PER_DIRECTION);
    let volume: f64 = cell.iter().map(|s| s.len).product();
    let top: f64 = cell.iter().map(DensitySpan::max_density).product();
    let (mut value, mut error) = (0.0, 0.0);
    for k in 0..3 {
        let (a, b, c) = (&cell[k], &cell[(k + 1) % 3], &cell[(k + 2) % 3]);
        let mut sum = 0.0;
        for (v, wv) in rule.nodes.iter().zip(&rule.weights) {
            for (w, ww) in rule.nodes.iter().zip(&rule.weights) {
                let (y, z) = (b.len * v, c.len * w);
                let q2 = a.len * a.len + y * y + z * z;
                let shape = wv * ww * if q == 2 { 1.0 / q2 } else { 1.0 / q2.sqrt() };
                // Degree at most four in s: three points are exact.
                let three = gauss_legendre::rule(3);
                for (s, ws) in three.nodes.iter().zip(&three.weights) {
                    let jacobian = if q == 2 { 1.0 } else { *s };
                    sum +=
                        shape * ws * jacobian * a.density_at(*s) * b.density_at(s * v) * c.density_at(s * w);
                }
            }
        }
        value += volume * sum;
        for edge in [b.len, c.len] {
            let ratio = a.len / edge;
            let bound = [0.9, 0.8, 0.65, 0.5]
                .into_iter()
                .filter_map(|f| {
                    let small = f * ratio;
                    let big = (small * small + 0.25).sqrt();
                    let least = ratio * ratio - small * small * (1.0 - 0.25 / (big * big + small * small));
                    let rho = 2.0 * (big + small);
                    let m = top * 2.0 * (0.5 + big) * (edge * edge * least).powf(-0.5 * q as f64);
                    (least > 0.0).then(|| gauss_legendre::error_bound(POINTS_PER_DIRECTION, rho, m))
                })
                .fold(f64::INFINITY, f64::min);
            error += volume * bound;
        }
    }
    (value, error)
}
