//! The paper's baseline: Gauss–Legendre rules in every direction of both zones.
//!
//! Six directions for two voxels, five for a voxel and a patch, four for two patches; m points each, m⁶ evaluations of
//! t^p e^{−κr}/r^q. The differences of the nodes are tabulated on each axis (m² of them); the kernel is
//! evaluated for every combination, eight at a time.
//!
//! **Error.** Direction by direction as in `aligned::apart`: the rule of one direction errs by at most (32/15) M ϱ^{−2m}/(1 − ϱ^{−2}) on a mean
//! ([`zonal_math::gauss_legendre::error_bound`]) with M on an ellipse from `clipped_pair.rs`; the other rules have positive weights of sum one, so the errors add.
//! Rounding: nodes are off by the pair's coordinate error; kernel, weights and sums at most (40 + q + m⁶/8 …)ε relative, κr 4ε absolute. Parts behind a
//! patch are clipped off first. Boxes that touch have no ellipse: the radius is then value + a proven upper bound of 𝓕.

use super::clipped_pair::{ClippedPair, clipped_pair};
use super::tensor_nodes::LANES;
use super::uniform_grid::UniformGrid;
use crate::rounding::UNIT_ROUNDOFF;
use zonal_exchange::aligned::Cuboid;
use zonal_exchange::{AccuracyRequest, Factor, Method};
use zonal_math::{Bounded, gauss_legendre, simd};

/// Largest number of points in a direction.
pub const MAX_POINTS: usize = 12;
/// Smallest number of points tried.
const MIN_POINTS: usize = 2;

/// Squares of differences and weights times the power of t for one axis: all combinations of the two rules.
fn axis_differences(extents: [f64; 2], centre: f64, power: i32, m: usize) -> Vec<(f64, f64)> {
    let rule = gauss_legendre::rule(m);
    let n = |e: f64| if e > 0.0 { m } else { 1 };
    let node =
        |e: f64, i: usize| if e > 0.0 { (e * (rule.nodes[i] - 0.5), rule.weights[i]) } else { (0.0, 1.0) };
    let mut out = Vec::with_capacity(n(extents[0]) * n(extents[1]));
    for i in 0..n(extents[0]) {
        let (x, w) = node(extents[0], i);
        for j in 0..n(extents[1]) {
            let (y, v) = node(extents[1], j);
            let t = centre + (y - x);
            out.push((t * t, w * v * t.powi(power)));
        }
    }
    out
}

/// The product of two lines in blocks of lanes, with weights of zero at the end.
fn plane_products(
    y: &[(f64, f64)],
    z: &[(f64, f64)],
    squares: &mut Vec<[f64; LANES]>,
    weights: &mut Vec<[f64; LANES]>,
) {
    let blocks = (y.len() * z.len()).div_ceil(LANES);
    squares.clear();
    weights.clear();
    squares.resize(blocks, [1.0; LANES]);
    weights.resize(blocks, [0.0; LANES]);
    let mut i = 0;
    for (y2, wy) in y {
        for (z2, wz) in z {
            squares[i / LANES][i % LANES] = y2 + z2;
            weights[i / LANES][i % LANES] = wy * wz;
            i += 1;
        }
    }
}

/// Σ over an axis and a plane of w e^{−κr}/r^q, q = 2 + M.
#[inline(always)]
fn kernel_sum<const M: usize, const ATTENUATED: bool>(
    x: &[(f64, f64)],
    squares: &[[f64; LANES]],
    weights: &[[f64; LANES]],
    kappa: f64,
) -> f64 {
    let mut total = [0.0; LANES];
    for &(x2, wx) in x {
        let mut part = [0.0; LANES];
        for (s, w) in squares.iter().zip(weights) {
            let mut f = [0.0; LANES];
            let mut depth = [0.0; LANES];
            for l in 0..LANES {
                let r2 = x2 + s[l];
                let r = if ATTENUATED || M == 1 { r2.sqrt() } else { 0.0 };
                depth[l] = -kappa * r;
                f[l] = match M {
                    0 => w[l] / r2,
                    1 => w[l] / (r2 * r),
                    _ => w[l] / (r2 * r2),
                };
            }
            if ATTENUATED {
                let e = simd::exp(depth);
                for l in 0..LANES {
                    f[l] *= e[l];
                }
            }
            for l in 0..LANES {
                part[l] += f[l];
            }
        }
        for l in 0..LANES {
            total[l] += wx * part[l];
        }
    }
    ((total[0] + total[1]) + (total[2] + total[3])) + ((total[4] + total[5]) + (total[6] + total[7]))
}

/// The mean of the kernel with `m` points in each direction.
fn kernel_mean(p: &ClippedPair, kappa: f64, m: usize) -> f64 {
    tensor_kernel_sum(
        [0, 1, 2].map(|k| axis_differences(p.extents[k], p.centre[k], p.power[k], m)),
        p.patches,
        kappa,
    )
}

/// Σ w e^{−κr}/r^q over the tensor product of three lines of (t², w t^p).
pub(super) fn tensor_kernel_sum([x, y, z]: [Vec<(f64, f64)>; 3], patches: i32, kappa: f64) -> f64 {
    let (mut squares, mut weights) = (Vec::new(), Vec::new());
    plane_products(&y, &z, &mut squares, &mut weights);
    let (s, w) = (&squares[..], &weights[..]);
    match (patches, kappa > 0.0) {
        (0, false) => simd::dispatch(
            #[inline(always)]
            || kernel_sum::<0, false>(&x, s, w, kappa),
        ),
        (1, false) => simd::dispatch(
            #[inline(always)]
            || kernel_sum::<1, false>(&x, s, w, kappa),
        ),
        (_, false) => simd::dispatch(
            #[inline(always)]
            || kernel_sum::<2, false>(&x, s, w, kappa),
        ),
        (0, true) => simd::dispatch(
            #[inline(always)]
            || kernel_sum::<0, true>(&x, s, w, kappa),
        ),
        (1, true) => simd::dispatch(
            #[inline(always)]
            || kernel_sum::<1, true>(&x, s, w, kappa),
        ),
        (_, true) => simd::dispatch(
            #[inline(always)]
            || kernel_sum::<2, true>(&x, s, w, kappa),
        ),
    }
}

fn direction_count(p: &ClippedPair) -> i32 {
    p.extents.iter().flatten().filter(|e| **e > 0.0).count() as i32
}

/// Proven bound of the error of [`kernel_mean`] by the rules.
fn truncation_bound(p: &ClippedPair, kappa: f64, m: usize) -> f64 {
    let mut error = 0.0;
    for k in 0..3 {
        for e in p.extents[k].into_iter().filter(|e| *e > 0.0) {
            error += p
                .bernstein_ellipses(k, 0.5 * e, kappa)
                .map(|(rho, top)| gauss_legendre::error_bound(m, rho, top))
                .fold(f64::INFINITY, f64::min);
        }
    }
    error
}

/// Value and proved radius with `m` points.
fn bounded_mean(p: &ClippedPair, kappa: f64, m: usize, truncation: f64) -> Bounded {
    let mean = kernel_mean(p, kappa, m);
    let value = p.weight * mean;
    let g = p.distance();
    if !(g > 0.0 && truncation.is_finite()) {
        return Bounded::proved(value, value.abs() + p.upper_bound());
    }
    let evaluations = (m as f64).powi(direction_count(p));
    let relative = UNIT_ROUNDOFF * (60.0 + evaluations / LANES as f64 + 8.0 * kappa * p.max_distance())
        + p.relative_error;
    let radius = truncation + p.displacement_error(g, kappa) + relative * mean.abs();
    Bounded::proved(value, 1.000_01 * p.weight * radius + f64::MIN_POSITIVE)
}

/// The factor with `m` points in each direction, its proved radius included in the time it takes.
///
/// # Panics
/// On invalid boxes, an extinction (1/m) that is negative, `m` outside 1..=64.
pub fn fixed_points(a: &Cuboid, b: &Cuboid, kappa: f64, m: usize) -> Factor {
    assert!(kappa >= 0.0 && kappa.is_finite(), "extinction {kappa} 1/m");
    let Some(p) = clipped_pair(a, b) else { return Factor::NOT_VISIBLE };
    let bounded = bounded_mean(&p, kappa, m, truncation_bound(&p, kappa, m));
    Factor { bounded, evaluations: (m as u64).pow(direction_count(&p) as u32), method: Method::SixGauss }
}

/// Returns the factor with as many points (2 to [`MAX_POINTS`] in each direction) as the request needs, within its evaluations.
///
/// # Panics
/// On invalid boxes or a negative extinction (1/m).
pub fn factor(a: &Cuboid, b: &Cuboid, kappa: f64, demand: &AccuracyRequest) -> Factor {
    assert!(kappa >= 0.0 && kappa.is_finite(), "extinction {kappa} 1/m");
    let Some(p) = clipped_pair(a, b) else { return Factor::NOT_VISIBLE };
    let cost = |m: usize| (m as u64).pow(direction_count(&p) as u32);
    let guess = p.kernel(p.centre, kappa);
    let mut evaluations = 0;
    let mut best = Bounded::proved(0.0, p.upper_bound());
    for m in MIN_POINTS..=MAX_POINTS {
        if cost(m) > demand.max_evaluations.saturating_sub(evaluations) {
            break;
        }
        let error = truncation_bound(&p, kappa, m);
        // Without a bound more points gain nothing.
        let useful = error.is_finite() || m < MIN_POINTS + 2;
        let affordable = m < MAX_POINTS && cost(m + 1) <= demand.max_evaluations.saturating_sub(evaluations);
        if error > demand.tolerance * guess && useful && affordable {
            continue;
        }
        best = bounded_mean(&p, kappa, m, error);
        evaluations += cost(m);
        if best.radius <= demand.radius(best.value) || !error.is_finite() {
            break;
        }
    }
    Factor { bounded: best, evaluations, method: Method::SixGauss }
}

/// The paper's baseline: the factors (m⁴) of voxel `v` with every voxel of a grid in its order, `m` points in each of the six directions, no error
/// bound (the radius is infinite, the grade estimated). Tables of differences are made once a row.
///
/// # Panics
/// On a box other than a voxel, `m` outside 1..=64.
pub fn grid_baseline(v: &Cuboid, voxels: &UniformGrid, m: usize) -> Vec<Bounded> {
    assert!(v.normal.is_none() && v.is_valid(), "not a voxel: {v:?}");
    let e = v.extent();
    let table = |k: usize| -> Vec<Vec<(f64, f64)>> {
        let first = voxels.origin[k] + 0.5 * voxels.cell[k] - 0.5 * (v.lo[k] + v.hi[k]);
        let at = |i: usize| axis_differences([e[k], voxels.cell[k]], first + voxels.cell[k] * i as f64, 0, m);
        (0..voxels.dims[k]).map(at).collect()
    };
    let [x, y, z] = [table(0), table(1), table(2)];
    let weight = v.measure() * voxels.cell.product() * std::f64::consts::FRAC_1_PI;
    let mut values = simd::run(GridBaseline { x: &x, y: &y, z: &z, voxels });
    values.iter_mut().for_each(|v| *v *= weight);
    values.into_iter().map(|x| Bounded::estimated(x, f64::INFINITY)).collect()
}

/// Sums of the baseline for all voxels, in the widest SIMD vectors of the machine.
struct GridBaseline<'a> {
    x: &'a [Vec<(f64, f64)>],
    y: &'a [Vec<(f64, f64)>],
    z: &'a [Vec<(f64, f64)>],
    voxels: &'a UniformGrid,
}

impl simd::SimdKernel for GridBaseline<'_> {
    type Output = Vec<f64>;
    #[inline(always)]
    fn evaluate(self) -> Vec<f64> {
        let mut values = vec![0.0; self.voxels.len()];
        let (mut squares, mut weights) = (Vec::new(), Vec::new());
        for j in 0..self.voxels.dims[1] {
            for k in 0..self.voxels.dims[2] {
                plane_products(&self.y[j], &self.z[k], &mut squares, &mut weights);
                for i in 0..self.voxels.dims[0] {
                    values[self.voxels.index([i, j, k])] =
                        kernel_sum::<0, false>(&self.x[i], &squares, &weights, 0.0);
                }
            }
        }
        values
    }
}
