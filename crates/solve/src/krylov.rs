//! Conjugate gradients for the zonal equations, with a status instead of silence.
//!
//! With strengths s = c B, sources s⁰ and w_i = c_i ρ_i/A_i (patch) or c_i Ω_i/(4 V_i) (volume) the equations read
//! s = s⁰ + w g s. Put s = s⁰ + √w y; then
//!
//! ```text
//!     (I − √w g √w) y = √w g s⁰,
//! ```
//!
//! symmetric, and positive definite as long as some power is lost. All bands run side by side; a band that is done rests.
//! The residual reported is ‖r‖/‖√w g s⁰‖.

use crate::operator::Operator;
use zonal_scene::{Bands, Progress, SolveStatus, bands};

/// Iterations without a new smallest residual after which a band counts as stalled.
const PATIENCE: usize = 30;

/// Where the iteration ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Ended {
    /// Strengths, a zone.
    pub strengths: Vec<Bands>,
    /// Status, a band.
    pub status: [SolveStatus; 3],
    /// Relative residual before the first and after each iteration, a band.
    pub residuals: [Vec<f64>; 3],
}

fn dot(a: &[Bands], b: &[Bands]) -> Bands {
    a.iter().zip(b).fold([0.0; 3], |s, (x, y)| bands(|k| s[k] + x[k] * y[k]))
}

/// Solves s = s⁰ + w g s.
pub fn solve(
    operator: &dyn Operator,
    source: &[Bands],
    weight: &[Bands],
    residual: f64,
    max_iterations: usize,
    progress: &dyn Progress,
) -> Ended {
    let root: Vec<Bands> = weight.iter().map(|w| w.map(f64::sqrt)).collect();
    let times =
        |a: &[Bands], b: &[Bands]| a.iter().zip(b).map(|(x, y)| bands(|k| x[k] * y[k])).collect::<Vec<_>>();
    let rhs = times(&root, &operator.apply(source));
    let norm = dot(&rhs, &rhs).map(f64::sqrt);
    let mut y = vec![[0.0; 3]; source.len()];
    let mut r = rhs.clone();
    let mut p = rhs;
    let mut rr = dot(&r, &r);
    let mut residuals = norm.map(|n| vec![if n > 0.0 { 1.0 } else { 0.0 }]);
    let mut status = norm.map(|n| if n > 0.0 { None } else { Some(SolveStatus::Converged) });
    let mut best = [(f64::INFINITY, 0usize); 3];
    progress.begin("solving", max_iterations as u64);
    for iteration in 1..=max_iterations {
        if status.iter().all(Option::is_some) {
            break;
        }
        let gp = times(&root, &operator.apply(&times(&root, &p)));
        let q: Vec<Bands> = p.iter().zip(&gp).map(|(p, g)| bands(|k| p[k] - g[k])).collect();
        let pq = dot(&p, &q);
        let alpha = bands(|k| if status[k].is_none() && pq[k] > 0.0 { rr[k] / pq[k] } else { 0.0 });
        for i in 0..y.len() {
            for k in 0..3 {
                y[i][k] += alpha[k] * p[i][k];
                r[i][k] -= alpha[k] * q[i][k];
            }
        }
        let new = dot(&r, &r);
        let beta = bands(|k| if rr[k] > 0.0 { new[k] / rr[k] } else { 0.0 });
        rr = new;
        for (p, r) in p.iter_mut().zip(&r) {
            (0..3).for_each(|k| p[k] = r[k] + beta[k] * p[k]);
        }
        for k in (0..3).filter(|&k| status[k].is_none()).collect::<Vec<_>>() {
            let relative = rr[k].sqrt() / norm[k];
            residuals[k].push(relative);
            if relative < best[k].0 {
                best[k] = (relative, iteration);
            }
            if relative <= residual {
                status[k] = Some(SolveStatus::Converged);
            } else if !relative.is_finite() || pq[k] <= 0.0 || iteration - best[k].1 > PATIENCE {
                status[k] = Some(SolveStatus::Stalled);
            }
        }
        progress.advance(1);
    }
    progress.end();
    let strengths = (0..y.len()).map(|i| bands(|k| source[i][k] + root[i][k] * y[i][k])).collect();
    Ended { strengths, status: status.map(|s| s.unwrap_or(SolveStatus::Budget)), residuals }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packed::Packed;
    use zonal_math::Grade;
    use zonal_scene::Quiet;

    struct Plain(Packed);
    impl Operator for Plain {
        fn len(&self) -> usize {
            self.0.len()
        }
        fn apply(&self, s: &[Bands]) -> Vec<Bands> {
            self.0.apply(s)
        }
        fn scale(&mut self, _: &[Bands]) {}
        fn grade(&self) -> Grade {
            Grade::Proved
        }
    }

    /// Two facing walls that see only each other: s_1 = 1 + ρ s_2, s_2 = ρ s_1.
    fn two_walls() -> Plain {
        let mut m = Packed::zeros(2);
        m.rows_mut()[1][0] = 1.0;
        Plain(m)
    }

    #[test]
    fn two_mirroring_walls_have_a_closed_form() {
        let rho = 0.8;
        let e = solve(&two_walls(), &[[1.0; 3], [0.0; 3]], &[[rho; 3]; 2], 1e-13, 50, &Quiet);
        assert_eq!(e.status, [SolveStatus::Converged; 3]);
        assert!((e.strengths[0][1] - 1.0 / (1.0 - rho * rho)).abs() < 1e-12);
        assert!((e.strengths[1][2] - rho / (1.0 - rho * rho)).abs() < 1e-12);
    }

    #[test]
    fn a_spent_budget_and_an_impossible_problem_are_said() {
        let mut m = Packed::zeros(40);
        for (i, row) in m.rows_mut().into_iter().enumerate() {
            row.iter_mut().enumerate().for_each(|(j, x)| *x = 1.0 / (40.0 + (i * j % 7) as f64));
        }
        let source: Vec<Bands> = (0..40).map(|i| [1.0 + i as f64; 3]).collect();
        let e = solve(&Plain(m), &source, &vec![[0.9; 3]; 40], 1e-15, 1, &Quiet);
        assert_eq!(e.status[0], SolveStatus::Budget);
        // Reflectances above one gain power at every bounce: no solution.
        let e = solve(&two_walls(), &[[1.0; 3], [0.5; 3]], &[[1.5; 3]; 2], 1e-12, 50, &Quiet);
        assert_eq!(e.status[0], SolveStatus::Stalled);
    }
}
