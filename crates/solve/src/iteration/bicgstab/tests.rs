use super::*;
use crate::distribution::sum_order::SumOrder;
use crate::operator::ExchangeOperator;
use zonal_scene::{NoCheckpoints, NoProgress};

/// Factors by rows, not necessarily symmetric.
struct RowOperator(Vec<Vec<f64>>);

impl ExchangeOperator for RowOperator {
    fn len(&self) -> usize {
        self.0.len()
    }
    fn apply(&self, s: &[Bands]) -> Vec<Bands> {
        let one = |row: &Vec<f64>| Bands::from_fn(|b| row.iter().zip(s).map(|(x, s)| x * s[b]).sum());
        self.0.iter().map(one).collect()
    }
    fn scale(&mut self, _: &[Bands]) {}
}

/// Closed cavities of four walls each with the absorptances of `absorbed` and a weak exchange between them. `noise` makes the rows differ from the
/// columns, like sampled rays.
fn cavities(absorbed: &[f64], noise: f64) -> (RowOperator, Vec<Bands>) {
    let n = 4 * absorbed.len();
    let coupling = |i: usize, j: usize| {
        if i / 4 == j / 4 { 1.0 + noise * ((7 * i + 3 * j) % 5) as f64 / 4.0 } else { 1e-5 }
    };
    let mut rows: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| coupling(i, j)).collect()).collect();
    for row in &mut rows {
        let sum: f64 = row.iter().sum();
        row.iter_mut().for_each(|x| *x /= sum);
    }
    (RowOperator(rows), (0..n).map(|i| Bands::splat(1.0 - absorbed[i / 4])).collect())
}

fn system<'a>(g: &'a RowOperator, weights: &'a [Bands], targets: &'a [f64]) -> LinearSystem<'a> {
    LinearSystem { operator: g, weights: weights.into(), targets, sums: SumOrder::plain() }
}

const STOP: StoppingCriterion = StoppingCriterion { residual: 1e-6, max_iterations: 200 };

#[test]
fn symmetric_factors_match_conjugate_gradients() {
    let (g, weights) = cavities(&[0.3, 0.01, 0.5], 0.0);
    let system = system(&g, &weights, &[1.0; 12]);
    let sources: [Vec<Bands>; 2] = [
        (0..12).map(|i| Bands::from_rgb([(i % 5) as f64, 1.0, 0.0])).collect(),
        vec![Bands::from_rgb([0.0, 2.0, 1.0]); 12],
    ];
    let (exact, _) = crate::iteration::conjugate_gradients::solve(
        system.clone(),
        None,
        sources.to_vec(),
        None,
        StoppingCriterion { residual: 1e-13, max_iterations: 99 },
        &NoCheckpoints,
        &NoProgress,
    );
    for (e, x) in solve(&system, &sources, None, STOP, &NoProgress).iter().zip(&exact) {
        assert_eq!(e.status, PerBand::splat(SolveStatus::Converged));
        let products = e.residuals[Band::first()].len();
        assert!(products < 20, "{products}");
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
        let sources = [(0..n).map(|i| Bands::splat((i % 3) as f64)).collect::<Vec<Bands>>()];
        let e = &solve(&system, &sources, None, STOP, &NoProgress)[0];
        let residuals = &e.residuals[Band::first()];
        assert_eq!(e.status, PerBand::splat(SolveStatus::Converged), "{absorbed:?}: {residuals:?}");
        // The residual of the equations bounds the error of the solution.
        let least = absorbed.iter().fold(1.0f64, |m, a| m.min(*a));
        let arriving = g.apply(&e.strengths);
        let size: f64 = e.strengths.iter().map(|s| s.first()).sum();
        let left: f64 =
            (0..n).map(|i| (sources[0][i] + weights[i] * arriving[i] - e.strengths[i]).first().abs()).sum();
        assert!(left / least <= 1e-4 * size, "{absorbed:?}: {left:e} of {size:e}");
        assert!(residuals.len() < 60, "{absorbed:?}: {}", residuals.len());
    }
}

#[test]
fn black_zones_keep_their_source_and_dark_bands_stay_dark() {
    let (g, mut weights) = cavities(&[0.2, 0.1], 0.3);
    weights[3] = Bands::from_rgb([0.0, 0.5, 0.0]);
    let targets = vec![1.0; 8];
    let system = system(&g, &weights, &targets);
    let source: Vec<Bands> = (0..8).map(|i| Bands::from_rgb([i as f64, 0.0, 1.0])).collect();
    let e = &solve(&system, &[source], Some(vec![vec![Bands::splat(5.0); 8]]), STOP, &NoProgress)[0];
    let [red, _, blue] = e.strengths[3].to_rgb();
    assert!((red - 3.0).abs() < 1e-12 && (blue - 1.0).abs() < 1e-12);
    assert!(e.strengths.iter().all(|s| s.to_rgb()[1].abs() < 1e-4), "{:?}", e.strengths);
    let dark = &solve(&system, &[vec![Bands::ZERO; 8]], None, STOP, &NoProgress)[0];
    let converged = PerBand::splat(SolveStatus::Converged);
    assert_eq!((dark.status, dark.strengths.clone()), (converged, vec![Bands::ZERO; 8]));
}

// Guards (numbers): an iteration that does not converge is a status, never an `Err`.
#[test]
fn divergent_cavity_is_not_converged_and_stays_finite() {
    let (g, mut weights) = cavities(&[0.0, 0.0, 0.0], 0.2);
    // The last cavity gains power at every reflection, as noise may cause.
    weights[8..].fill(Bands::splat(1.0001));
    let system = system(&g, &weights, &[1.0; 12]);
    let e = &solve(&system, &[vec![Bands::ONE; 12]], None, STOP, &NoProgress)[0];
    assert!(e.strengths.iter().flatten().all(|s| s.is_finite()), "{:?}", e.strengths);
    assert_ne!(e.status[Band::first()], SolveStatus::Converged);
    assert!(e.residuals[Band::first()].len() <= 2 * STOP.max_iterations);
}
