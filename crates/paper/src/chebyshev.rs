//! Chebyshev interpolation of factors along strips and in blocks, with the attenuation e^{−κr} inside.
//!
//! A zone displaced by s (a vector along the axes) from the middle of a block has the factor W f(s), f(s) = E[n(t+s) e^{−κ|t+s|}/|t+s|^q]. On a block
//! |s_k| ≤ σ_k it is interpolated by the tensor product of n_k Chebyshev points x_i = cos((2i+1)π/2n_k), with the cardinal functions
//! ℓ_i(u) = (1/n)(1 + 2 Σ_{m<n} T_m(x_i) T_m(u)). A strip is a block with one axis.
//!
//! **Interpolation.** In s_k, the others real, f is analytic in a Bernstein ellipse around [−σ_k, σ_k] with |f| ≤ M (`clipped_pair.rs`, the support swept by the block:
//! moving a zone moves t). Coefficients are at most 2Mϱ^{−m}, and T_m − its interpolant at most 2:
//!
//! ```text
//! |f − p_k| ≤ Σ_{m ≥ n} 4Mϱ^{−m} = 4Mϱ^{−n}/(1 − 1/ϱ),      |f − p| ≤ E_1 + Λ_1 E_2 + Λ_1Λ_2 E_3,   Λ_n ≤ (2/π) ln(n+1) + 1.
//! ```
//!
//! **Samples.** Each is a tensor of Gauss rules for the densities; its error (one bound for the swept support), its rounding and
//! its coordinate error are amplified by Λ_1Λ_2Λ_3. **Rounding** of the interpolation: T_m = cos(m acos u) errs by (2πm + 2)ε, hence Σ_i |δℓ_i| ≤ 16n²ε; with
//! sums and products (16 Σ n_k² + 4 Σ n_k)ε Λ_1Λ_2Λ_3 max|sample|.
//!
//! A block that would take more samples than it has zones is halved; a single zone takes the rule itself, or the exact integral where no rule is
//! admissible or where it is partly behind a patch. Compared with the Taylor series: an ellipse of analyticity instead of a disc, but sample points off the voxels.

use super::clipped_pair::{ClippedPair, clipped_pair};
use super::gauss_6d::tensor_kernel_sum;
use super::tensor_nodes::{AxisRule, LANES};
use crate::rounding::UNIT_ROUNDOFF;
use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_exchange::{AccuracyRequest, Factor, Method};
use zonal_math::{Bounded, Vec3, vec3};

/// 2 (coefficient) · 2 (a Chebyshev polynomial less its interpolant).
const INTERPOLATION_ERROR_FACTOR: f64 = 2.0 * 2.0; // bound
/// Slope of the Lebesgue constant in ln(n + 1).
const LEBESGUE_SLOPE: f64 = std::f64::consts::FRAC_2_PI; // bound
/// Largest number of points along an axis.
const MAX_POINTS_PER_AXIS: usize = 32;
/// Share of the tolerance for interpolation.
const TRUNCATION_SHARE: f64 = 0.4;
/// Share of the tolerance for quadrature.
const QUADRATURE_SHARE: f64 = 0.1;
/// Smallest relative tolerance of the exact integral.
const MIN_TOLERANCE: f64 = 1e-13;

/// Equal zones on a lattice, seen from one zone: zone (i, j, k) is `first` moved by the steps times i, j, k.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZoneLattice {
    /// The zone opposite the lattice.
    pub from: Cuboid,
    /// The first zone of the lattice.
    pub first: Cuboid,
    /// Steps along the axes, m, positive.
    pub step: Vec3,
    /// Zones along the axes.
    pub dims: [usize; 3],
}

impl ZoneLattice {
    /// One of the zones.
    pub fn zone(&self, c: [usize; 3]) -> Cuboid {
        let s = vec3(self.step[0] * c[0] as f64, self.step[1] * c[1] as f64, self.step[2] * c[2] as f64);
        Cuboid { lo: self.first.lo + s, hi: self.first.hi + s, normal: self.first.normal }
    }
    /// Index of a zone: z runs fastest.
    pub fn index(&self, c: [usize; 3]) -> usize {
        (c[0] * self.dims[1] + c[1]) * self.dims[2] + c[2]
    }
}

/// Zones lo ≤ c < hi.
#[derive(Clone, Copy, Debug)]
struct LatticeBlock {
    lo: [usize; 3],
    hi: [usize; 3],
}

impl LatticeBlock {
    fn count(&self, k: usize) -> usize {
        self.hi[k] - self.lo[k]
    }
    fn len(&self) -> usize {
        (0..3).map(|k| self.count(k)).product()
    }
    fn halves(self) -> [LatticeBlock; 2] {
        let k = (0..3).fold(0, |m, k| if self.count(k) > self.count(m) { k } else { m });
        let middle = self.lo[k] + self.count(k) / 2;
        let (mut a, mut b) = (self, self);
        (a.hi[k], b.lo[k]) = (middle, middle);
        [a, b]
    }
}

/// The factors of every zone of a lattice for extinction `kappa` (1/m) to a relative tolerance, in the lattice's order.
///
/// # Panics
/// On invalid zones, steps or tolerance that are not positive, a negative extinction.
pub fn lattice_factors(lattice: &ZoneLattice, kappa: f64, demand: &AccuracyRequest) -> Vec<Factor> {
    assert!(kappa >= 0.0 && kappa.is_finite(), "extinction {kappa} 1/m");
    assert!((0..3).all(|k| lattice.step[k] > 0.0) && demand.tolerance > 0.0, "{lattice:?}, {demand:?}");
    let mut out = vec![Factor::NOT_VISIBLE; lattice.dims.iter().product()];
    let mut stack = vec![LatticeBlock { lo: [0; 3], hi: lattice.dims }];
    while let Some(b) = stack.pop() {
        if b.len() == 0 {
            continue;
        }
        if !interpolate_block(lattice, &b, kappa, demand.tolerance, false, &mut out) {
            if b.len() == 1 {
                let f = geometric_factor(
                    &lattice.from,
                    &lattice.zone(b.lo),
                    kappa,
                    demand.tolerance.max(MIN_TOLERANCE),
                );
                out[lattice.index(b.lo)] = f;
            } else {
                stack.extend(b.halves());
            }
        }
    }
    out
}

/// One pair by interpolation between it and its neighbour one extent of `b` farther off along the axis of the largest distance; the
/// exact integral where that is not possible.
pub(super) fn pair_by_interpolation(a: &Cuboid, b: &Cuboid, kappa: f64, demand: &AccuracyRequest) -> Factor {
    let offset = (b.lo + b.hi) - (a.lo + a.hi);
    let k = (0..3).fold(0, |m, k| if offset[k].abs() > offset[m].abs() { k } else { m });
    let step = Vec3::splat(b.extent().array().into_iter().fold(0.0, f64::max));
    let mut shift = [0.0; 3];
    shift[k] = if offset[k] < 0.0 { -step[k] } else { 0.0 };
    let shift = vec3(shift[0], shift[1], shift[2]);
    let first = Cuboid { lo: b.lo + shift, hi: b.hi + shift, normal: b.normal };
    let (mut dims, mut at) = ([1; 3], [0; 3]);
    dims[k] = 2;
    at[k] = (offset[k] < 0.0) as usize;
    let lattice = ZoneLattice { from: *a, first, step, dims };
    let mut out = [Factor::NOT_VISIBLE; 2];
    let same = lattice.zone(at) == *b;
    if same
        && interpolate_block(
            &lattice,
            &LatticeBlock { lo: [0; 3], hi: dims },
            kappa,
            demand.tolerance,
            true,
            &mut out,
        )
    {
        return out[lattice.index(at)];
    }
    geometric_factor(a, b, kappa, demand.tolerance.max(MIN_TOLERANCE))
}

/// Bound of the interpolation in direction `k`, and the points that reach `goal`.
fn interpolation_points(
    swept: &ClippedPair,
    half: [f64; 3],
    kappa: f64,
    goal: f64,
) -> Option<([usize; 3], f64)> {
    let (mut points, mut error, mut lebesgue) = ([1; 3], 0.0, 1.0);
    for k in (0..3).filter(|&k| half[k] > 0.0) {
        let (mut n, mut e) = (usize::MAX, f64::INFINITY);
        for (rho, m) in swept.bernstein_ellipses(k, half[k], kappa) {
            let front = INTERPOLATION_ERROR_FACTOR * m / (1.0 - 1.0 / rho);
            let needed = ((3.0 * 4.0 * front / goal).ln() / rho.ln()).ceil().max(1.0);
            if needed < n as f64 {
                n = needed as usize;
                e = front * rho.powi(-(n as i32));
            }
        }
        if n > MAX_POINTS_PER_AXIS {
            return None;
        }
        points[k] = n;
        error += lebesgue * e;
        lebesgue *= lebesgue_constant(n);
    }
    Some((points, error))
}

/// The Lebesgue constant of n Chebyshev points, or a bound of it.
fn lebesgue_constant(n: usize) -> f64 {
    if n == 1 { 1.0 } else { LEBESGUE_SLOPE * ((n + 1) as f64).ln() + 1.0 }
}

/// Interpolates a block; false where it must be divided or integrated exactly.
fn interpolate_block(
    lattice: &ZoneLattice,
    b: &LatticeBlock,
    kappa: f64,
    tolerance: f64,
    forced: bool,
    out: &mut [Factor],
) -> bool {
    let end = [0, 1, 2].map(|k| b.hi[k] - 1);
    let (near, far) = (lattice.zone(b.lo), lattice.zone(end));
    let (Some(p), Some(last)) = (clipped_pair(&lattice.from, &near), clipped_pair(&lattice.from, &far))
    else {
        // Unseen at both ends is unseen between: half-spaces are convex.
        return clipped_pair(&lattice.from, &near).is_none()
            && clipped_pair(&lattice.from, &far).is_none()
            && is_unseen(lattice, b);
    };
    if !(p.is_unclipped(&lattice.from, &near) && last.is_unclipped(&lattice.from, &far)) {
        return false;
    }
    let p = p.with_lattice_rounding(&[&lattice.from, &lattice.first, &far]);
    let half = [0, 1, 2].map(|k| 0.5 * lattice.step[k] * (b.count(k) - 1) as f64);
    let middle = [0, 1, 2].map(|k| p.centre[k] + p.sign[k] * half[k]);
    let swept = ClippedPair { centre: middle, ..(0..3).fold(p, |p, k| p.swept_along(k, half[k])) };
    let g = swept.distance();
    if g <= 0.0 {
        return false;
    }
    let least =
        block_corners(middle, half).map(|t| p.kernel(t, kappa)).into_iter().fold(f64::INFINITY, f64::min);
    let Some((points, truncation)) =
        interpolation_points(&swept, half, kappa, TRUNCATION_SHARE * tolerance * least)
    else {
        return false;
    };
    let lebesgue: f64 = points.iter().map(|&n| lebesgue_constant(n)).product();
    let Some(nodes) = swept.points_for_error(kappa, QUADRATURE_SHARE * tolerance * least / lebesgue) else {
        return false;
    };
    if !forced && b.len() > 1 && 5 * points.iter().product::<usize>() > 4 * b.len() {
        return false;
    }
    let lines = [0, 1, 2].map(|k| AxisRule::trapezoid(&p.densities[k], nodes[k]));
    let quadrature = swept.quadrature_error([0, 1, 2].map(|k| (nodes[k], lines[k].defect)), kappa);
    let samples = sample_means(&p, &lines, middle, half, points, kappa);
    let top = samples.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let count: usize = lines.iter().map(|l| l.nodes.len()).product();
    let evaluation = UNIT_ROUNDOFF * (60.0 + (count / LANES) as f64 + 8.0 * kappa * swept.max_distance());
    let work: f64 = points.iter().map(|&n| (16 * n * n + 4 * n) as f64).sum();
    let error = truncation
        + lebesgue
            * (quadrature
                + 2.0 * swept.displacement_error(g, kappa)
                + (evaluation + work * UNIT_ROUNDOFF) * top);
    let values = interpolate_to_zones(samples, points, b);
    let cost = (points.iter().product::<usize>() * count).div_ceil(b.len()) as u64;
    let result = BlockResult { values: &values, error, evaluations: cost };
    store_block(lattice, b, &p, &result, tolerance, out)
}

/// True if every zone of a block is unseen, tested at its corners.
fn is_unseen(lattice: &ZoneLattice, b: &LatticeBlock) -> bool {
    (0..8).all(|i| {
        let c = [0, 1, 2].map(|k| if i >> k & 1 == 0 { b.lo[k] } else { b.hi[k] - 1 });
        clipped_pair(&lattice.from, &lattice.zone(c)).is_none()
    })
}

fn block_corners(middle: [f64; 3], half: [f64; 3]) -> [[f64; 3]; 8] {
    std::array::from_fn(|i| [0, 1, 2].map(|k| middle[k] + if i >> k & 1 == 0 { -half[k] } else { half[k] }))
}

/// The i-th Chebyshev point of n.
fn chebyshev_point(i: usize, n: usize) -> f64 {
    ((2 * i + 1) as f64 * std::f64::consts::PI / (2 * n) as f64).cos()
}

/// The means at all Chebyshev points of a block.
fn sample_means(
    p: &ClippedPair,
    lines: &[AxisRule; 3],
    middle: [f64; 3],
    half: [f64; 3],
    n: [usize; 3],
    kappa: f64,
) -> Vec<f64> {
    let tables = [0, 1, 2].map(|k| -> Vec<Vec<(f64, f64)>> {
        // The points are counted in the direction of the lattice.
        let at = |i: usize| middle[k] + p.sign[k] * half[k] * chebyshev_point(i, n[k]);
        (0..n[k]).map(|i| lines[k].squares_and_weights(at(i), p.power[k])).collect()
    });
    let mut out = Vec::with_capacity(n.iter().product());
    for x in &tables[0] {
        for y in &tables[1] {
            for z in &tables[2] {
                out.push(tensor_kernel_sum([x.clone(), y.clone(), z.clone()], p.patches, kappa));
            }
        }
    }
    out
}

/// ℓ_i at the zones of one axis: count rows of n.
fn cardinal_functions(n: usize, count: usize) -> Vec<Vec<f64>> {
    let row = |j: usize| -> Vec<f64> {
        let u = if count > 1 { 2.0 * j as f64 / (count - 1) as f64 - 1.0 } else { 0.0 };
        let angle = u.clamp(-1.0, 1.0).acos();
        let value = |i: usize| {
            let node = (2 * i + 1) as f64 * std::f64::consts::PI / (2 * n) as f64;
            let sum: f64 = (1..n).map(|m| (m as f64 * node).cos() * (m as f64 * angle).cos()).sum();
            (1.0 + 2.0 * sum) / n as f64
        };
        (0..n).map(value).collect()
    };
    (0..count).map(row).collect()
}

/// Interpolates from samples to zones, one axis after the other.
fn interpolate_to_zones(samples: Vec<f64>, points: [usize; 3], b: &LatticeBlock) -> Vec<f64> {
    let mut data = samples;
    let mut shape = points;
    for k in 0..3 {
        let rows = cardinal_functions(points[k], b.count(k));
        let inner: usize = shape[k + 1..].iter().product();
        let outer: usize = shape[..k].iter().product();
        let mut next = vec![0.0; outer * rows.len() * inner];
        for o in 0..outer {
            for (j, row) in rows.iter().enumerate() {
                for (i, l) in row.iter().enumerate() {
                    for x in 0..inner {
                        next[(o * rows.len() + j) * inner + x] += l * data[(o * points[k] + i) * inner + x];
                    }
                }
            }
        }
        shape[k] = rows.len();
        data = next;
    }
    data
}

/// Interpolated means of a block.
struct BlockResult<'a> {
    /// Means in the order of the block's zones.
    values: &'a [f64],
    /// Error of every mean.
    error: f64,
    /// Evaluations of the kernel a zone.
    evaluations: u64,
}

/// Writes the factors of a block; false, and nothing written, where a radius misses the tolerance.
fn store_block(
    lattice: &ZoneLattice,
    b: &LatticeBlock,
    p: &ClippedPair,
    result: &BlockResult,
    tolerance: f64,
    out: &mut [Factor],
) -> bool {
    let BlockResult { values, error, evaluations } = *result;
    let radius = |v: f64| 1.000_001 * p.weight * (error + p.relative_error * v.abs()) + f64::MIN_POSITIVE;
    if b.len() > 1 && values.iter().any(|&v| radius(v) > tolerance * p.weight * v) {
        return false;
    }
    if b.len() == 1 && radius(values[0]) > tolerance * p.weight * values[0] {
        return false;
    }
    let method = if b.len() == 1 { Method::Gauss } else { Method::Chebyshev };
    let mut i = 0;
    for x in b.lo[0]..b.hi[0] {
        for y in b.lo[1]..b.hi[1] {
            for z in b.lo[2]..b.hi[2] {
                let bounded = Bounded::proved(p.weight * values[i], radius(values[i]));
                out[lattice.index([x, y, z])] = Factor { bounded, evaluations, method };
                i += 1;
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cardinal_functions_are_one_at_their_node_and_sum_to_one() {
        // 2·3 + 1 uniform points hit the middle Chebyshev point of 3.
        let rows = cardinal_functions(3, 7);
        assert!((rows[3][1] - 1.0).abs() < 1e-15 && rows[3][0].abs() < 1e-15);
        assert!(rows.iter().all(|r| (r.iter().sum::<f64>() - 1.0).abs() < 1e-14));
    }

    /// The largest Σ|ℓ_i| over [−1, 1] is at most the bound, and above half of it.
    #[test]
    fn lebesgue_constant_bounds_the_sum_of_cardinal_functions() {
        for n in [2, 5, 12, 32] {
            let most = cardinal_functions(n, 4001)
                .iter()
                .map(|r| r.iter().map(|l| l.abs()).sum::<f64>())
                .fold(0.0, f64::max);
            assert!(most <= lebesgue_constant(n) + 1e-9, "{n}: {most} {}", lebesgue_constant(n));
            assert!(most > 1.0 + 0.5 * LEBESGUE_SLOPE * ((n + 1) as f64).ln(), "{n}: {most}");
        }
    }

    /// f = T_n vanishes at the n points: the error is 1 = 2 M ϱ^{−n}, half of 4 M ϱ^{−n}; a sum of aliased terms takes the rest.
    #[test]
    fn interpolation_constant_is_attained() {
        // f = Σ_{j odd} (−1)^{(j−1)/2}-free signs: T_n − T_3n + …: at u = 1 the interpolant is 0 and aliases add with their signs.
        let (coefficient, alias) = (2.0, 2.0);
        assert_eq!(INTERPOLATION_ERROR_FACTOR, coefficient * alias);
        let n = 6;
        // T_{2n} interpolates to −1: at u = 1 it is off by two.
        let rows = cardinal_functions(n, 2);
        let p: f64 = (0..n).map(|i| rows[1][i] * (2.0 * n as f64 * chebyshev_point(i, n).acos()).cos()).sum();
        assert!((1.0 - p - alias).abs() < 1e-12);
    }
}
