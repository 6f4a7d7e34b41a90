//! The radial part of the kernel, and sums of it over tensor grids.
//!
//! P sums of (r−r₀)^p e^{−κ(r−r₀)}/r^q, p < P, are computed together: P = 1 for a factor, P = 5 for its cumulants.

use super::subdivision::ReducedKernel;
use zonal_math::simd::{self, LANES};

/// Per axis: squared nodes, and weights times the factors of that axis.
#[derive(Default)]
pub(super) struct TensorScratch {
    pub square: [Vec<f64>; 3],
    pub factor: [Vec<f64>; 3],
    outer: usize,
    plane: Vec<PlaneLanes>,
}

/// Nodes of a plane side by side.
#[derive(Clone, Copy, Default)]
struct PlaneLanes {
    square: [f64; LANES],
    factor: [f64; LANES],
}

/// e^{−κ(r−r₀)}/r^{2+m} · (1, r−r₀, (r−r₀)², …) at r² for m patches, lane by lane.
#[inline(always)]
pub(super) fn radial_kernel<const M: i32, const ATTENUATED: bool, const P: usize>(
    r2: &[f64; LANES],
    kappa: f64,
    nearest: f64,
) -> [[f64; LANES]; P] {
    let plain = !ATTENUATED && P == 1 && M != 1;
    let mut r = [0.0; LANES];
    let mut v = [0.0; LANES];
    if !plain {
        for l in 0..LANES {
            r[l] = r2[l].sqrt();
        }
    }
    for l in 0..LANES {
        v[l] = match M {
            0 => 1.0 / r2[l],
            1 => 1.0 / (r2[l] * r[l]),
            _ => 1.0 / (r2[l] * r2[l]),
        };
    }
    if ATTENUATED {
        let mut depth = [0.0; LANES];
        for l in 0..LANES {
            depth[l] = -kappa * (r[l] - nearest);
        }
        let e = simd::exp(depth);
        for l in 0..LANES {
            v[l] *= e[l];
        }
    }
    let mut out = [v; P];
    for p in 1..P {
        for l in 0..LANES {
            out[p][l] = out[p - 1][l] * (r[l] - nearest);
        }
    }
    out
}

/// The sum over a tensor grid, every term positive. The direction with the fewest points is the outer loop; the nodes of the other two lie
/// side by side in lanes.
pub(super) fn sum_tensor<const P: usize>(s: &mut TensorScratch, kernel: &ReducedKernel) -> [f64; P] {
    s.flatten();
    match (kernel.patches, kernel.kappa > 0.0) {
        (0, false) => simd::dispatch(|| tensor::<0, false, P>(s, kernel)),
        (1, false) => simd::dispatch(|| tensor::<1, false, P>(s, kernel)),
        (_, false) => simd::dispatch(|| tensor::<2, false, P>(s, kernel)),
        (0, true) => simd::dispatch(|| tensor::<0, true, P>(s, kernel)),
        (1, true) => simd::dispatch(|| tensor::<1, true, P>(s, kernel)),
        (_, true) => simd::dispatch(|| tensor::<2, true, P>(s, kernel)),
    }
}

/// Upper bound of the additions that one term of [`sum_tensor`] passes through.
pub(super) fn summation_depth(points: [usize; 3]) -> usize {
    let [a, b, c] = points;
    let outer = a.min(b).min(c);
    outer + (a * b * c / outer).div_ceil(LANES) + LANES
}

impl TensorScratch {
    /// Squares and weights of all nodes of a plane in lanes, the last padded with weight zero.
    fn flatten(&mut self) {
        let count = |k: usize| self.square[k].len();
        self.outer = (0..3).fold(0, |m, k| if count(k) < count(m) { k } else { m });
        let (j, i) = ((self.outer + 1) % 3, (self.outer + 2) % 3);
        self.plane.clear();
        let (mut lanes, mut l) = (PlaneLanes::default(), 0);
        for (y, gy) in self.square[j].iter().zip(&self.factor[j]) {
            for (z, gz) in self.square[i].iter().zip(&self.factor[i]) {
                (lanes.square[l], lanes.factor[l]) = (y + z, gy * gz);
                l += 1;
                if l == LANES {
                    self.plane.push(lanes);
                    l = 0;
                }
            }
        }
        if l > 0 {
            for rest in l..LANES {
                (lanes.square[rest], lanes.factor[rest]) = (lanes.square[0], 0.0);
            }
            self.plane.push(lanes);
        }
    }
}

#[inline(always)]
fn tensor<const M: i32, const ATTENUATED: bool, const P: usize>(
    s: &TensorScratch,
    kernel: &ReducedKernel,
) -> [f64; P] {
    let mut total = [0.0; P];
    for (x, gx) in s.square[s.outer].iter().zip(&s.factor[s.outer]) {
        let mut sums = [[0.0; LANES]; P];
        for lanes in &s.plane {
            let mut r2 = lanes.square;
            for l in 0..LANES {
                r2[l] += x;
            }
            let v = radial_kernel::<M, ATTENUATED, P>(&r2, kernel.kappa, kernel.nearest);
            for p in 0..P {
                for l in 0..LANES {
                    sums[p][l] += lanes.factor[l] * v[p][l];
                }
            }
        }
        for p in 0..P {
            total[p] += gx * sums[p].iter().sum::<f64>();
        }
    }
    total
}
