//! The radial part of the kernel and the innermost sums.
//!
//! P sums are taken at once, of (r−r₀)^p e^{−κ(r−r₀)}/r^q for p < P: P = 1 for a factor, P = 5 for its cumulants.

use super::cells::Kernel;

/// Per axis: squares of the nodes, and weights times whatever belongs to that axis alone.
#[derive(Default)]
pub(super) struct Scratch {
    pub square: [Vec<f64>; 3],
    pub factor: [Vec<f64>; 3],
}

/// e^{−κ(r−r₀)}/r^{2+m} · (1, r−r₀, (r−r₀)², …) at r² for m patches.
#[inline(always)]
pub(super) fn radial<const M: i32, const ATTENUATED: bool, const P: usize>(
    r2: f64,
    kappa: f64,
    nearest: f64,
) -> [f64; P] {
    let plain = !ATTENUATED && P == 1 && M != 1;
    let r = if plain { 0.0 } else { r2.sqrt() };
    let mut v = match M {
        0 => 1.0 / r2,
        1 => 1.0 / (r2 * r),
        _ => 1.0 / (r2 * r2),
    };
    if ATTENUATED {
        v *= (-kappa * (r - nearest)).exp();
    }
    let mut out = [v; P];
    for p in 1..P {
        out[p] = out[p - 1] * (r - nearest);
    }
    out
}

/// The sum over a tensor grid, every term positive.
pub(super) fn sum_tensor<const P: usize>(s: &Scratch, kernel: &Kernel) -> [f64; P] {
    match (kernel.patches, kernel.kappa > 0.0) {
        (0, false) => tensor::<0, false, P>(s, kernel),
        (1, false) => tensor::<1, false, P>(s, kernel),
        (_, false) => tensor::<2, false, P>(s, kernel),
        (0, true) => tensor::<0, true, P>(s, kernel),
        (1, true) => tensor::<1, true, P>(s, kernel),
        (_, true) => tensor::<2, true, P>(s, kernel),
    }
}

fn tensor<const M: i32, const ATTENUATED: bool, const P: usize>(s: &Scratch, kernel: &Kernel) -> [f64; P] {
    let [x, y, z] = &s.square;
    let [gx, gy, gz] = &s.factor;
    let mut total = [0.0; P];
    for (x, gx) in x.iter().zip(gx) {
        let mut plane = [0.0; P];
        for (y, gy) in y.iter().zip(gy) {
            let c2 = x + y;
            let mut line = [0.0; P];
            for (z, gz) in z.iter().zip(gz) {
                let v = radial::<M, ATTENUATED, P>(c2 + z, kernel.kappa, kernel.nearest);
                for p in 0..P {
                    line[p] += gz * v[p];
                }
            }
            for p in 0..P {
                plane[p] += gy * line[p];
            }
        }
        for p in 0..P {
            total[p] += gx * plane[p];
        }
    }
    total
}
