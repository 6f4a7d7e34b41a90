//! Cells with a corner at t = 0: pyramid (Duffy) coordinates.
//!
//! For each axis k the pyramid over the opposite face: t_k = d_k s, t_j = d_j s v, t_i = d_i s w with s, v, w ∈ [0, 1] and
//! Jacobian D s², D = d_x d_y d_z. The numerator brings s^m and 1/r^{2+m} brings s^{−2−m}, so that the integrand is
//!
//! ```text
//! D · ω(s, v, w) · n(v, w) · Q^{−q} e^{−κ s Q},   Q² = d_k² + d_j² v² + d_i² w²,   n = d_k^{p_k} (d_j v)^{p_j} (d_i w)^{p_i},
//! ```
//!
//! with ω the product of the three linear densities at s, sv, sw. The integrand has no singularity.
//!
//! **In v** (w likewise): on an ellipse around [0, 1] with semi-axis A and Re(v² + (d_k/d_j)²) ≥ R', |Q²| ≥ d_j² R' and
//! Re Q > 0, so that |e^{−κsQ}| ≤ 1; sv stays inside the ellipse, which is convex and holds 0, so the density is at most
//! ½(w₀+w₁) + |w₁−w₀| A and |v| ≤ ½ + A.
//!
//! **In s**: a polynomial of degree ≤ 3 (one for each density that is not constant) times e^{−κsQ}: without attenuation two points are exact;
//! otherwise Re s ≥ ½ − A gives |e^{−κsQ}| ≤ e^{κ Q_max (A−½)}, and any ellipse is admissible.

use super::bernstein_ellipse::{self, PointCount};
use super::radial_kernel::radial_kernel;
use super::reduced_pair::DensitySpan;
use super::subdivision::{IntegrationCell, ReducedKernel, norm};
use zonal_math::gauss_legendre::{self, QuadratureRule};
use zonal_math::simd::{self, LANES};

/// The pyramid over the face across axis `k`: its axes (k, j, i).
fn axes(k: usize) -> [usize; 3] {
    [k, (k + 1) % 3, (k + 2) % 3]
}

/// Points in s, v and w for the pyramid of axis `k` within an error `budget`. `extra` is the power of s that the moments add to the polynomial
/// degree in s.
pub(super) fn plan(
    cell: &IntegrationCell,
    kernel: &ReducedKernel,
    k: usize,
    extra: usize,
    budget: f64,
) -> [PointCount; 3] {
    let [_, j, i] = axes(k);
    [
        radial_points(cell, kernel, k, extra, budget / 3.0),
        lateral_points(cell, kernel, [k, j, i], budget / 3.0),
        lateral_points(cell, kernel, [k, i, j], budget / 3.0),
    ]
}

/// Bounds ½(w₀+w₁) + |w₁−w₀| a of a linear density on an ellipse of semi-axis `a` around the unit interval.
fn density_bound(s: &DensitySpan, a: f64) -> f64 {
    0.5 * (s.w0 + s.w1) + (s.w1 - s.w0).abs() * a
}

/// Candidate ellipse parameters ϱ along s.
const RADIAL_ELLIPSE_PARAMETERS: [f64; 6] = [3.0, 6.0, 12.0, 24.0, 60.0, 200.0];

fn radial_points(
    cell: &IntegrationCell,
    kernel: &ReducedKernel,
    k: usize,
    extra: usize,
    budget: f64,
) -> PointCount {
    let degree = cell.spans.iter().filter(|s| s.w0 != s.w1).count() + extra;
    if kernel.kappa == 0.0 {
        return PointCount { points: degree / 2 + 1, error: 0.0 };
    }
    let d = cell.spans.map(|s| s.len);
    let face = cell.volume() * kernel.numerator(d) * d[k].powi(-kernel.q());
    let growth = kernel.kappa * norm(d);
    let candidates = RADIAL_ELLIPSE_PARAMETERS.map(|rho| {
        let a = 0.25 * (rho + 1.0 / rho);
        let density: f64 = cell.spans.iter().map(|s| density_bound(s, a)).product();
        ((face * density).ln() + growth * (a - 0.5), rho)
    });
    bernstein_ellipse::fewest_points(candidates.into_iter(), budget)
}

/// `k` the pyramid's axis, `j` the direction, `i` the other one.
fn lateral_points(
    cell: &IntegrationCell,
    kernel: &ReducedKernel,
    [k, j, i]: [usize; 3],
    budget: f64,
) -> PointCount {
    let (dk, dj, di) = (cell.spans[k].len, cell.spans[j].len, cell.spans[i].len);
    let rest = cell.volume()
        * cell.spans[k].max_weight()
        * cell.spans[i].max_weight()
        * dk.powi(kernel.power[k])
        * di.powi(kernel.power[i])
        * dj.powi(kernel.power[j] - kernel.q());
    let c = dk / dj;
    let candidates = bernstein_ellipse::ellipses_around(0.0, 1.0, c * c).map(|e| {
        let front = rest * density_bound(&cell.spans[j], e.a) * (0.5 + e.a).powi(kernel.power[j]);
        (front.ln() - 0.5 * kernel.q() as f64 * e.square.ln(), e.rho)
    });
    bernstein_ellipse::fewest_points(candidates, budget)
}

/// The pyramid's integral by the planned rule.
pub(super) fn integrate<const P: usize>(
    cell: &IntegrationCell,
    kernel: &ReducedKernel,
    k: usize,
    plan: &[PointCount; 3],
) -> [f64; P] {
    let [_, j, i] = axes(k);
    let spans = [cell.spans[k], cell.spans[j], cell.spans[i]];
    let face = face(&spans, kernel, [j, i], plan);
    let rule = gauss_legendre::rule(plan[0].points);
    let total = match (kernel.patches, kernel.kappa > 0.0) {
        (0, false) => simd::dispatch(|| sum::<0, false, P>(&spans, kernel.kappa, rule, &face)),
        (1, false) => simd::dispatch(|| sum::<1, false, P>(&spans, kernel.kappa, rule, &face)),
        (_, false) => simd::dispatch(|| sum::<2, false, P>(&spans, kernel.kappa, rule, &face)),
        (0, true) => simd::dispatch(|| sum::<0, true, P>(&spans, kernel.kappa, rule, &face)),
        (1, true) => simd::dispatch(|| sum::<1, true, P>(&spans, kernel.kappa, rule, &face)),
        (_, true) => simd::dispatch(|| sum::<2, true, P>(&spans, kernel.kappa, rule, &face)),
    };
    let front = cell.volume() * cell.spans[k].len.powi(kernel.power[k]);
    total.map(|x| x * front)
}

/// Upper bound of the additions that one term passes through.
pub(super) fn depth(points: [usize; 3]) -> usize {
    points[0] + (points[1] * points[2]).div_ceil(LANES) + LANES
}

/// A node u of a rule and its mirror 1 − u, both relatively accurate.
fn node(rule: &QuadratureRule, i: usize) -> (f64, f64) {
    (rule.nodes[i], rule.nodes[rule.nodes.len() - 1 - i])
}

/// Nodes of the pyramid's face side by side: v and w with their mirrors, Q², the weights times the numerator.
#[derive(Clone, Copy, Default)]
struct FaceLanes {
    v: [[f64; LANES]; 2],
    w: [[f64; LANES]; 2],
    square: [f64; LANES],
    factor: [f64; LANES],
}

/// All nodes of the face, the last lanes padded with weight zero.
fn face(
    spans: &[DensitySpan; 3],
    kernel: &ReducedKernel,
    [j, i]: [usize; 2],
    plan: &[PointCount; 3],
) -> Vec<FaceLanes> {
    let [sk, sj, si] = spans;
    let (rv, rw) = (gauss_legendre::rule(plan[1].points), gauss_legendre::rule(plan[2].points));
    let (nv, nw) = (rv.nodes.len(), rw.nodes.len());
    let mut face = vec![FaceLanes::default(); (nv * nw).div_ceil(LANES)];
    for place in 0..face.len() * LANES {
        // Padding repeats the first node.
        let real = place < nv * nw;
        let (iv, iw) = if real { (place / nw, place % nw) } else { (0, 0) };
        let (v, w) = (node(rv, iv), node(rw, iw));
        let (tj, ti) = (sj.len * v.0, si.len * w.0);
        let (lanes, l) = (&mut face[place / LANES], place % LANES);
        (lanes.v[0][l], lanes.v[1][l], lanes.w[0][l], lanes.w[1][l]) = (v.0, v.1, w.0, w.1);
        lanes.square[l] = sk.len * sk.len + tj * tj + ti * ti;
        if real {
            lanes.factor[l] =
                rv.weights[iv] * tj.powi(kernel.power[j]) * rw.weights[iw] * ti.powi(kernel.power[i]);
        }
    }
    face
}

/// The density at s·u: w₀(1 − su) + w₁ su with 1 − su = (1−s) + s(1−u), no difference taken.
#[inline(always)]
fn density(span: &DensitySpan, s: f64, not_s: f64, u: f64, not_u: f64) -> f64 {
    span.w0 * (not_s + s * not_u) + span.w1 * (s * u)
}

#[inline(always)]
fn sum<const M: i32, const ATTENUATED: bool, const P: usize>(
    spans: &[DensitySpan; 3],
    kappa: f64,
    rule: &QuadratureRule,
    face: &[FaceLanes],
) -> [f64; P] {
    let [sk, sj, si] = spans;
    let mut total = [[0.0; LANES]; P];
    for FaceLanes { v, w, square, factor } in face {
        // 1/Q^q and the powers of Q; the attenuation follows with s.
        let shape = radial_kernel::<M, false, P>(square, 0.0, 0.0);
        let mut depth = [0.0; LANES];
        if ATTENUATED {
            for l in 0..LANES {
                depth[l] = -kappa * square[l].sqrt();
            }
        }
        let mut line = [[0.0; LANES]; P];
        for is in 0..rule.nodes.len() {
            let (s, not_s) = node(rule, is);
            let first = rule.weights[is] * (sk.w0 * not_s + sk.w1 * s);
            let mut term = [0.0; LANES];
            for l in 0..LANES {
                term[l] =
                    first * density(sj, s, not_s, v[0][l], v[1][l]) * density(si, s, not_s, w[0][l], w[1][l]);
            }
            if ATTENUATED {
                let e = simd::exp(depth.map(|x| x * s));
                for l in 0..LANES {
                    term[l] *= e[l];
                }
            }
            for p in 0..P {
                for l in 0..LANES {
                    line[p][l] += term[l];
                    term[l] *= s;
                }
            }
        }
        for p in 0..P {
            for l in 0..LANES {
                total[p][l] += factor[l] * shape[p][l] * line[p][l];
            }
        }
    }
    total.map(|lanes| lanes.iter().sum())
}
