//! Cells apart from t = 0: tensor Gauss–Legendre in Cartesian coordinates.
//!
//! Direction k of a cell, the other two variables real: on an ellipse with semi-axis A along and R = c² + min Re z²
//! (see [`super::bernstein_ellipse`]; c² the smallest sum of the other squares), the integrand is at most
//!
//! ```text
//! M = (½(w₀+w₁) + |w₁−w₀| A/len) · Π_{j≠k} max w_j · Π_{j≠k} hi_j^{p_j} · (X + A)^{p_k} · R^{−q/2} e^{−κ(√R − r₀)}.
//! ```
//!
//! The errors of the three directions add: E = (I₁−Q₁)I₂I₃ + Q₁(I₂−Q₂)I₃ + Q₁Q₂(I₃−Q₃), the weights being positive.

use super::bernstein_ellipse::{self, PointCount};
use super::radial_kernel::{TensorScratch, sum_tensor};
use super::reduced_pair::DensitySpan;
use super::subdivision::{IntegrationCell, ReducedKernel};
use zonal_math::gauss_legendre;

/// Points for the three directions within an error `budget` for the cell.
pub(super) fn plan(cell: &IntegrationCell, kernel: &ReducedKernel, budget: f64) -> [PointCount; 3] {
    let volume = cell.volume();
    let directions = cell.spans.iter().filter(|s| s.len > 0.0).count() as f64;
    [0, 1, 2].map(|k| {
        if cell.spans[k].len > 0.0 {
            points_along(cell, kernel, k, volume, budget / directions)
        } else {
            PointCount { points: 1, error: 0.0 }
        }
    })
}

fn points_along(
    cell: &IntegrationCell,
    kernel: &ReducedKernel,
    k: usize,
    volume: f64,
    budget: f64,
) -> PointCount {
    let (mut c2, mut rest) = (0.0, volume);
    for j in (0..3).filter(|&j| j != k) {
        let s = &cell.spans[j];
        c2 += s.lo * s.lo;
        rest *= s.max_weight() * s.hi().powi(kernel.power[j]);
    }
    let DensitySpan { lo, len, w0, w1 } = cell.spans[k];
    let (mid, slope) = (0.5 * (w0 + w1), (w1 - w0).abs() / len);
    let candidates = bernstein_ellipse::ellipses_around(lo, len, c2).map(|e| {
        let reach = lo + 0.5 * len + e.a;
        let front = rest * (mid + slope * e.a) * reach.powi(kernel.power[k]);
        let mut ln_m = front.ln() - 0.5 * kernel.q() as f64 * e.square.ln();
        if kernel.kappa > 0.0 {
            ln_m -= kernel.kappa * (e.square.sqrt() - kernel.nearest);
        }
        (ln_m, e.rho)
    });
    bernstein_ellipse::fewest_points(candidates, budget)
}

/// The cell's integral by the planned rule.
pub(super) fn integrate<const P: usize>(
    cell: &IntegrationCell,
    kernel: &ReducedKernel,
    plan: &[PointCount; 3],
    scratch: &mut TensorScratch,
) -> [f64; P] {
    for k in 0..3 {
        fill_axis(
            &cell.spans[k],
            kernel.power[k],
            plan[k].points,
            &mut scratch.square[k],
            &mut scratch.factor[k],
        );
    }
    sum_tensor::<P>(scratch, kernel)
}

/// Nodes' squares and everything of the integrand that belongs to one axis.
fn fill_axis(span: &DensitySpan, power: i32, n: usize, square: &mut Vec<f64>, factor: &mut Vec<f64>) {
    square.clear();
    factor.clear();
    if span.len == 0.0 {
        square.push(span.lo * span.lo);
        factor.push(span.lo.powi(power));
        return;
    }
    let rule = gauss_legendre::rule(n);
    for i in 0..n {
        let (u, mirror) = (rule.nodes[i], rule.nodes[n - 1 - i]);
        let t = span.lo + span.len * u;
        square.push(t * t);
        factor.push(rule.weights[i] * span.len * (span.w0 * mirror + span.w1 * u) * t.powi(power));
    }
}
