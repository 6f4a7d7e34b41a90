//! The number of points a direction that the bound of `density.rs` asks for.
//!
//! The bound holds for any ellipse: six are tried, and the best counts. Neighbours in a table are served alike, so what served one is tried first
//! for the next: the bound is that of the ellipse tried, proved as ever, and only the choice is cheaper.

use super::{COEFFICIENT, Grid, Kind, MOST, NORMS, UP, defect, shell};
use crate::aligned::moments::RATIO;
use zonal_math::simd;

/// Where between the interval and the widest ellipse the bound is tried.
const FRACTIONS: [f64; 6] = [0.95, 0.75, 0.5, 0.3, 0.15, 0.06];
/// Beyond this many mean free paths the exponential may underflow.
const DEEPEST: f64 = 300.0;

/// A number of points a direction, and the error that they leave in each lane (without mass/π).
#[derive(Clone, Copy, Debug)]
pub(in crate::aligned) struct Plan<const N: usize> {
    pub points: [usize; 3],
    pub error: [f64; N],
}

/// What served a place: a number of points and an ellipse, and how often it may still be tried before all are.
#[derive(Clone, Copy, Debug)]
struct Served {
    points: usize,
    ellipse: usize,
    left: u8,
}

/// What served nearby, a direction.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::aligned) struct Hint([Option<Served>; 3]);

/// How often an ellipse is tried again before all are.
const TRUST: u8 = 24;

/// The distance along a direction, the least squared distance across it, the numerator's other factors, B² of the widest ellipse.
struct Side<const N: usize> {
    x: [f64; N],
    c2: [f64; N],
    front: [f64; N],
    widest: [f64; N],
}

impl Grid {
    /// The fewest points whose error is within the relative `budget` in every lane; `None` beyond [`MOST`] or too near.
    #[inline(always)]
    pub(crate) fn plan<const N: usize>(&self, c: &[[f64; N]; 3], budget: f64) -> Option<Plan<N>> {
        self.plan_near(c, budget, &mut Hint::default())
    }

    /// The same, or one with few more points, beginning with what served nearby.
    #[inline(always)]
    pub(crate) fn plan_near<const N: usize>(
        &self,
        c: &[[f64; N]; 3],
        budget: f64,
        hint: &mut Hint,
    ) -> Option<Plan<N>> {
        let goal = self.estimate(c).map(|v| v * budget / 3.0);
        let reach2: f64 = self.half.iter().map(|h| h * h).sum();
        let mut served = true;
        for l in 0..N {
            let r2 = c[0][l] * c[0][l] + c[1][l] * c[1][l] + c[2][l] * c[2][l];
            served &= reach2 <= RATIO * RATIO * r2 && self.kappa * self.kappa * r2 < DEEPEST * DEEPEST;
            for k in 0..3 {
                served &= self.power[k] != 1 || c[k][l] * (1.0 + 1e-9) >= self.half[k];
            }
        }
        if !served {
            return None;
        }
        let mut plan = Plan { points: [1; 3], error: [0.0; N] };
        for k in (0..3).filter(|&k| self.kind[k] != Kind::Fixed) {
            let (points, error) = self.direction(c, k, &goal, &mut hint.0[k])?;
            plan.points[k] = points;
            for l in 0..N {
                plan.error[l] += error[l];
            }
        }
        Some(plan)
    }

    #[inline(always)]
    fn direction<const N: usize>(
        &self,
        c: &[[f64; N]; 3],
        k: usize,
        goal: &[f64; N],
        hint: &mut Option<Served>,
    ) -> Option<(usize, [f64; N])> {
        let side = self.side(c, k);
        if let Some(found) = self.again(&side, k, goal, hint) {
            return Some(found);
        }
        // Of each candidate 2M, then times ϱ⁻² a point; and what follows T_{2n}.
        let mut error = [[0.0; N]; FRACTIONS.len()];
        let mut decay = [[0.0; N]; FRACTIONS.len()];
        let mut rest = [[0.0; N]; FRACTIONS.len()];
        for (f, fraction) in FRACTIONS.into_iter().enumerate() {
            let (m, per, square) = self.ellipse(&side, k, fraction);
            let mut depth = [0.0; N];
            for l in 0..N {
                error[f][l] = COEFFICIENT * m[l];
                rest[f][l] = NORMS * per[l] / (1.0 - per[l]);
                depth[l] = -self.kappa * square[l].sqrt();
            }
            decay[f] = per;
            if self.kappa > 0.0 {
                let e = simd::exp(depth);
                for l in 0..N {
                    error[f][l] *= e[l];
                }
            }
        }
        for n in 1..=MOST {
            let mut best = [f64::INFINITY; N];
            let defect = defect(self.kind[k], n);
            for f in 0..FRACTIONS.len() {
                for l in 0..N {
                    error[f][l] *= decay[f][l];
                    let all = error[f][l] * (defect + rest[f][l]);
                    best[l] = if all < best[l] { all } else { best[l] };
                }
            }
            let mut enough = true;
            for l in 0..N {
                enough &= best[l] <= goal[l];
            }
            if enough {
                // One ellipse that serves all lanes, if there is any.
                let serves =
                    |f: &usize| (0..N).all(|l| error[*f][l] * (defect + rest[*f][l]) * UP <= goal[l]);
                *hint = (0..FRACTIONS.len()).find(serves).map(|ellipse| Served {
                    points: n,
                    ellipse,
                    left: TRUST,
                });
                return Some((n, best.map(|e| e * UP)));
            }
        }
        None
    }

    /// Tries the ellipse that served before, with a point less and with as many.
    #[inline(always)]
    fn again<const N: usize>(
        &self,
        side: &Side<N>,
        k: usize,
        goal: &[f64; N],
        hint: &mut Option<Served>,
    ) -> Option<(usize, [f64; N])> {
        let served = hint.as_mut().filter(|h| h.left > 0)?;
        served.left -= 1;
        let (m, per, square) = self.ellipse(side, k, FRACTIONS[served.ellipse]);
        let mut error = m.map(|m| COEFFICIENT * m);
        if self.kappa > 0.0 {
            let e = simd::exp(square.map(|s| -self.kappa * s.sqrt()));
            for l in 0..N {
                error[l] *= e[l];
            }
        }
        for n in 1..=served.points {
            let defect = defect(self.kind[k], n);
            for l in 0..N {
                error[l] *= per[l];
            }
            if n + 1 < served.points {
                continue;
            }
            let mut all = [0.0; N];
            let mut enough = true;
            for l in 0..N {
                all[l] = error[l] * (defect + NORMS * per[l] / (1.0 - per[l])) * UP;
                enough &= all[l] <= goal[l];
            }
            if enough {
                served.points = n;
                return Some((n, all));
            }
        }
        None
    }

    /// What the ellipses of direction k share.
    #[inline(always)]
    fn side<const N: usize>(&self, c: &[[f64; N]; 3], k: usize) -> Side<N> {
        let mut s = Side { x: [0.0; N], c2: [0.0; N], front: [1.0; N], widest: [0.0; N] };
        for j in (0..3).filter(|&j| j != k) {
            for l in 0..N {
                let near = c[j][l].abs() - self.half[j];
                let near = if near > 0.0 { near } else { 0.0 };
                s.c2[l] += near * near;
            }
            for _ in 0..self.power[j] {
                for l in 0..N {
                    s.front[l] *= c[j][l] + self.half[j];
                }
            }
        }
        let h2 = self.half[k] * self.half[k];
        for l in 0..N {
            s.x[l] = c[k][l].abs();
            let p = 2.0 * s.c2[l] + s.x[l] * s.x[l] - h2;
            s.widest[l] = 0.25 * (p + (p * p + 8.0 * s.c2[l] * h2).sqrt());
        }
        s
    }

    /// M without its exponential, ϱ⁻² and R of direction k's ellipse (see [`super::ellipse`]).
    #[inline(always)]
    fn ellipse<const N: usize>(
        &self,
        s: &Side<N>,
        k: usize,
        fraction: f64,
    ) -> ([f64; N], [f64; N], [f64; N]) {
        let h = self.half[k];
        let (mut m, mut per, mut square, mut reach) = (s.front, [0.0; N], [0.0; N], [0.0; N]);
        for l in 0..N {
            let x = s.x[l];
            let b2 = fraction * fraction * s.widest[l];
            let a2 = b2 + h * h;
            let (a, b) = (a2.sqrt(), b2.sqrt());
            let flat = b2 * (x * x / (a2 + b2) - 1.0);
            let end = (x - a) * (x - a);
            square[l] = s.c2[l] + if x * a >= a2 + b2 { end } else { flat };
            let inverse = h / (a + b);
            per[l] = inverse * inverse;
            reach[l] = x + a;
        }
        for _ in 0..self.power[k] {
            for l in 0..N {
                m[l] *= reach[l];
            }
        }
        match self.patches {
            0 => (0..N).for_each(|l| m[l] *= shell(0, square[l])),
            1 => (0..N).for_each(|l| m[l] *= shell(1, square[l])),
            _ => (0..N).for_each(|l| m[l] *= shell(2, square[l])),
        }
        (m, per, square)
    }
}
