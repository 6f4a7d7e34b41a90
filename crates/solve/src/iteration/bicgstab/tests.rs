use super::*;
use crate::operator::ExchangeOperator;
use zonal_scene::{NoCheckpoints, NoProgress};

/// Factors by rows, not necessarily symmetric.
struct RowOperator(Vec<Vec<f64>>);

impl ExchangeOperator for RowOperator {
    fn len(&self) -> usize {
        self.0.len()
    }
    fn apply(&self, s: &[Bands]) -> Vec<Bands> {
        let one = |row: &Vec<f64>| bands(|b| row.iter().zip(s).map(|(x, s)| x * s[b]).sum());
        self.0.iter().map(one).collect()
    }
    fn scale(&mut self, _: &[Bands]) {}
}

/// Closed cavities of four walls each with the absorptances of `absorbed` and a weak exchange between them. `noise` makes the rows differ from the
/// columns, like sampled rays.
fn cavities(absorbed: &[f64], noise: f64) -> (RowOperator, Vec<Bands>) {
    let n = 4 * absorbed.len();
    let coupling = |i: usize, j: usize| match i / 4 == j / 4 {
        true => 1.0 + noise * ((7 * i + 3 * j) % 5) as f64 / 4.0,
        false => 1e-5,
    };
    let mut rows: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| coupling(i, j)).collect()).collect();
    for row in &mut rows {
        let sum: f64 = row.iter().sum();
        row.iter_mut().for_each(|x| *x /= sum);
    }
    (RowOperator(rows), (0..n).map(|i| [1.0 - absorbed[i / 4]; 3]).collect())
}

fn system<'a>(g: &'a RowOperator, weights: &'a [Bands], targets: &'a [f64]) -> LinearSystem<'a> {
    LinearSystem { operator: g, weights, targets }
}

const STOP: StoppingCriterion = StoppingCriterion { residual: 1e-6, max_iterations: 200 };

#[test]
fn symmetric_factors_match_conjugate_gradients() {
    let (g, weights) = cavities(&[0.3, 0.01, 0.5], 0.0);
    let system = system(&g, &weights, &[1.0; 12]);
    let sources: [Vec<Bands>; 2] =
        [(0..12).map(|i| [(i % 5) as f64, 1.0, 0.0]).collect(), vec![[0.0, 2.0, 1.0]; 12]];
    let exact = crate::iteration::conjugate_gradients::solve(
        &system,
        &sources,
        None,
        StoppingCriterion { residual: 1e-13, max_iterations: 99 },
        &NoCheckpoints,
        &NoProgress,
    );
    for (e, x) in solve(&system, &sources, None, STOP, &NoProgress).iter().zip(&exact) {
        assert_eq!(e.status, [SolveStatus::Converged; 3]);
        assert!(e.residuals[0].len() < 20, "{}", e.residuals[0].len());
        for (s, x) in e.strengths.iter().flatten().zip(x.strengths.iter().flatten()) {
            assert!((s - x).abs() <= 1e-5 * x.abs(), "{s} {x}");
        }
    }
}

#[test]
fn nearly_closed_cavities_converge_with_noisy_rows() {
    for absorbed in [vec![1e-3, 1e-4, 1e-2], vec![0.5, 1e-5], vec![1e-6]] {
        let (g, weights) = cavities(&absorbed, 0.4);
        let n = weights.len();
        let targets = vec![1.0; n];
        let system = system(&g, &weights, &targets);
        let sources = [(0..n).map(|i| [(i % 3) as f64; 3]).collect::<Vec<Bands>>()];
        let e = &solve(&system, &sources, None, STOP, &NoProgress)[0];
        assert_eq!(e.status, [SolveStatus::Converged; 3], "{absorbed:?}: {:?}", e.residuals[0]);
        // The residual of the equations bounds the error of the solution.
        let least = absorbed.iter().fold(1.0f64, |m, a| m.min(*a));
        let arriving = g.apply(&e.strengths);
        let size: f64 = e.strengths.iter().map(|s| s[0]).sum();
        let left: f64 = (0..n)
            .map(|i| (sources[0][i][0] + weights[i][0] * arriving[i][0] - e.strengths[i][0]).abs())
            .sum();
        assert!(left / least <= 1e-4 * size, "{absorbed:?}: {left:e} of {size:e}");
        assert!(e.residuals[0].len() < 60, "{absorbed:?}: {}", e.residuals[0].len());
    }
}

#[test]
fn black_zones_keep_their_source_and_dark_bands_stay_dark() {
    let (g, mut weights) = cavities(&[0.2, 0.1], 0.3);
    weights[3] = [0.0, 0.5, 0.0];
    let targets = vec![1.0; 8];
    let system = system(&g, &weights, &targets);
    let source: Vec<Bands> = (0..8).map(|i| [i as f64, 0.0, 1.0]).collect();
    let e = &solve(&system, &[source], Some(vec![vec![[5.0; 3]; 8]]), STOP, &NoProgress)[0];
    assert!((e.strengths[3][0] - 3.0).abs() < 1e-12 && (e.strengths[3][2] - 1.0).abs() < 1e-12);
    assert!(e.strengths.iter().all(|s| s[1].abs() < 1e-4), "{:?}", e.strengths);
    let dark = &solve(&system, &[vec![[0.0; 3]; 8]], None, STOP, &NoProgress)[0];
    assert_eq!((dark.status, dark.strengths.clone()), ([SolveStatus::Converged; 3], vec![[0.0; 3]; 8]));
}

#[test]
fn divergent_cavity_is_not_converged_and_stays_finite() {
    let (g, mut weights) = cavities(&[0.0, 0.0, 0.0], 0.2);
    // The last cavity gains power at every reflection, as noise may cause.
    weights[8..].fill([1.0001; 3]);
    let system = system(&g, &weights, &[1.0; 12]);
    let e = &solve(&system, &[vec![[1.0; 3]; 12]], None, STOP, &NoProgress)[0];
    assert!(e.strengths.iter().flatten().all(|s| s.is_finite()), "{:?}", e.strengths);
    assert_ne!(e.status[0], SolveStatus::Converged);
    assert!(e.residuals[0].len() <= 2 * STOP.max_iterations);
}
