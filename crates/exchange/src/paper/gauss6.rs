//! The integration that the paper measures against: Gauss–Legendre in every direction of both zones.
//!
//! Six directions for two voxels, five for a voxel and a patch, four for two patches; m points each, m⁶ evaluations of
//! t^p e^{−κr}/r^q. Nothing is reduced: the differences of the nodes are tabulated an axis (m² of them), the kernel is
//! evaluated for every combination, eight at a time.
//!
//! **Error.** Direction by direction as in `aligned::apart`: the rule of one direction errs by at most (32/15) M ϱ^{−2m}/(1 − ϱ^{−2}) on a mean
//! ([`zonal_math::gauss::error_bound`]) with M on an ellipse from `kernel.rs`; the other rules have positive weights of sum one, so the errors add.
//! Rounding: nodes are off by the pair's shake; kernel, weights and sums at most (40 + q + m⁶/8 …)ε relative, κr 4ε absolute. Parts behind a
//! patch are clipped off first. Boxes that touch have no ellipse: the radius is then value + a proven upper bound of 𝓕.

use super::kernel::{EPS, Pair, pair};
use super::nodes::LANES;
use super::strip::Voxels;
use crate::aligned::Cuboid;
use crate::{Demand, Factor, Method};
use zonal_math::{Bounded, gauss, simd};

/// The most points in a direction.
pub const MOST: usize = 12;
/// The fewest that are tried.
const FEWEST: usize = 2;

/// Squares of differences and weights times the power of t for one axis: all combinations of the two rules.
fn line(extents: [f64; 2], centre: f64, power: i32, m: usize) -> Vec<(f64, f64)> {
    let rule = gauss::rule(m);
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

/// The product of two lines in blocks of lanes, weightless at the end.
fn plane(
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
fn sum<const M: usize, const ATTENUATED: bool>(
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
fn mean(p: &Pair, kappa: f64, m: usize) -> f64 {
    tensor([0, 1, 2].map(|k| line(p.extents[k], p.centre[k], p.power[k], m)), p.patches, kappa)
}

/// Σ w e^{−κr}/r^q over the tensor product of three lines of (t², w t^p).
pub(super) fn tensor([x, y, z]: [Vec<(f64, f64)>; 3], patches: i32, kappa: f64) -> f64 {
    let (mut squares, mut weights) = (Vec::new(), Vec::new());
    plane(&y, &z, &mut squares, &mut weights);
    let (s, w) = (&squares[..], &weights[..]);
    match (patches, kappa > 0.0) {
        (0, false) => simd::dispatch(
            #[inline(always)]
            || sum::<0, false>(&x, s, w, kappa),
        ),
        (1, false) => simd::dispatch(
            #[inline(always)]
            || sum::<1, false>(&x, s, w, kappa),
        ),
        (_, false) => simd::dispatch(
            #[inline(always)]
            || sum::<2, false>(&x, s, w, kappa),
        ),
        (0, true) => simd::dispatch(
            #[inline(always)]
            || sum::<0, true>(&x, s, w, kappa),
        ),
        (1, true) => simd::dispatch(
            #[inline(always)]
            || sum::<1, true>(&x, s, w, kappa),
        ),
        (_, true) => simd::dispatch(
            #[inline(always)]
            || sum::<2, true>(&x, s, w, kappa),
        ),
    }
}

fn directions(p: &Pair) -> i32 {
    p.extents.iter().flatten().filter(|e| **e > 0.0).count() as i32
}

/// Proven bound of the error of [`mean`] by the rules.
fn truncation(p: &Pair, kappa: f64, m: usize) -> f64 {
    let mut error = 0.0;
    for k in 0..3 {
        for e in p.extents[k].into_iter().filter(|e| *e > 0.0) {
            error += p
                .ellipses(k, 0.5 * e, kappa)
                .map(|(rho, top)| gauss::error_bound(m, rho, top))
                .fold(f64::INFINITY, f64::min);
        }
    }
    error
}

/// Value and proved radius with `m` points.
fn bounded(p: &Pair, kappa: f64, m: usize, truncation: f64) -> Bounded {
    let mean = mean(p, kappa, m);
    let value = p.weight * mean;
    let g = p.distance();
    if !(g > 0.0 && truncation.is_finite()) {
        return Bounded::proved(value, value.abs() + p.cap());
    }
    let evaluations = (m as f64).powi(directions(p));
    let relative = EPS * (60.0 + evaluations / LANES as f64 + 8.0 * kappa * p.reach()) + p.grain;
    let radius = truncation + p.shaken(g, kappa) + relative * mean.abs();
    Bounded::proved(value, 1.000_01 * p.weight * radius + f64::MIN_POSITIVE)
}

/// The factor with `m` points in each direction, its proved radius included in the time it takes.
///
/// # Panics
/// On invalid boxes, an extinction (1/m) that is negative, `m` outside 1..=64.
pub fn points(a: &Cuboid, b: &Cuboid, kappa: f64, m: usize) -> Factor {
    assert!(kappa >= 0.0 && kappa.is_finite(), "extinction {kappa} 1/m");
    let Some(p) = pair(a, b) else { return Factor::UNSEEN };
    let bounded = bounded(&p, kappa, m, truncation(&p, kappa, m));
    Factor { bounded, evaluations: (m as u64).pow(directions(&p) as u32), method: Method::SixGauss }
}

/// The factor with as many points (2 to [`MOST`] in each direction) as the demand needs; fewer if its budget says so.
///
/// # Panics
/// On invalid boxes or a negative extinction (1/m).
pub fn factor(a: &Cuboid, b: &Cuboid, kappa: f64, demand: &Demand) -> Factor {
    assert!(kappa >= 0.0 && kappa.is_finite(), "extinction {kappa} 1/m");
    let Some(p) = pair(a, b) else { return Factor::UNSEEN };
    let cost = |m: usize| (m as u64).pow(directions(&p) as u32);
    let guess = p.kernel(p.centre, kappa);
    let mut evaluations = 0;
    let mut best = Bounded::proved(0.0, p.cap());
    for m in FEWEST..=MOST {
        if cost(m) > demand.budget.saturating_sub(evaluations) {
            break;
        }
        let error = truncation(&p, kappa, m);
        // Where there is no bound at all, a few points do as well as many.
        let worth = error.is_finite() || m < FEWEST + 2;
        let room = m < MOST && cost(m + 1) <= demand.budget.saturating_sub(evaluations);
        if error > demand.tolerance * guess && worth && room {
            continue;
        }
        best = bounded(&p, kappa, m, error);
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
/// On a box that is no voxel, `m` outside 1..=64.
pub fn fixed(v: &Cuboid, voxels: &Voxels, m: usize) -> Vec<Bounded> {
    assert!(v.normal.is_none() && v.is_valid(), "not a voxel: {v:?}");
    let e = v.extent();
    let table = |k: usize| -> Vec<Vec<(f64, f64)>> {
        let first = voxels.origin[k] + 0.5 * voxels.cell[k] - 0.5 * (v.lo[k] + v.hi[k]);
        let at = |i: usize| line([e[k], voxels.cell[k]], first + voxels.cell[k] * i as f64, 0, m);
        (0..voxels.dims[k]).map(at).collect()
    };
    let [x, y, z] = [table(0), table(1), table(2)];
    let weight = v.measure() * voxels.cell.product() * std::f64::consts::FRAC_1_PI;
    let mut values = simd::run(Baseline { x: &x, y: &y, z: &z, voxels });
    values.iter_mut().for_each(|v| *v *= weight);
    values.into_iter().map(|x| Bounded::estimated(x, f64::INFINITY)).collect()
}

/// The sums of the baseline for all voxels, in vectors as wide as the machine has them.
struct Baseline<'a> {
    x: &'a [Vec<(f64, f64)>],
    y: &'a [Vec<(f64, f64)>],
    z: &'a [Vec<(f64, f64)>],
    voxels: &'a Voxels,
}

impl simd::Work for Baseline<'_> {
    type Output = Vec<f64>;
    #[inline(always)]
    fn go(self) -> Vec<f64> {
        let mut values = vec![0.0; self.voxels.len()];
        let (mut squares, mut weights) = (Vec::new(), Vec::new());
        for j in 0..self.voxels.dims[1] {
            for k in 0..self.voxels.dims[2] {
                plane(&self.y[j], &self.z[k], &mut squares, &mut weights);
                for i in 0..self.voxels.dims[0] {
                    values[self.voxels.index([i, j, k])] =
                        sum::<0, false>(&self.x[i], &squares, &weights, 0.0);
                }
            }
        }
        values
    }
}
