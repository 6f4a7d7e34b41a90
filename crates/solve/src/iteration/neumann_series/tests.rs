use super::*;
use crate::distribution::sum_order::SumOrder;
use crate::iteration::test_operators::{MemoryStore, forty_zones, two_walls};
use crate::operator::ExchangeOperator;
use zonal_scene::{NoCheckpoints, NoProgress};

#[test]
fn orders_are_partial_sums_of_the_series() {
    let (rho, weights) = (0.8, [Bands::splat(0.8); 2]);
    let g = two_walls();
    let system = LinearSystem {
        operator: &g,
        weights: (&weights).into(),
        targets: &[1.0; 2],
        sums: SumOrder::plain(),
    };
    for n in 1..7 {
        let e = solve(&system, &[vec![Bands::ONE, Bands::ZERO]], n, &NoCheckpoints, &NoProgress);
        let arriving = g.apply(&e[0].strengths)[1].first();
        // Light arrives at the second wall after 1, 3, 5 … path segments.
        let want: f64 = (1..=n).step_by(2).map(|k| rho_power(rho, k - 1)).sum();
        assert!((arriving - want).abs() < 1e-14, "{n}: {arriving} {want}");
        assert_eq!(
            (e[0].status[Band::first()], e[0].residuals[Band::first()].len()),
            (SolveStatus::FixedOrder, n)
        );
        assert!((e[0].residuals[Band::first()][n - 1] - rho_power(rho, n)).abs() < 1e-14);
    }
}

#[test]
fn resumed_series_is_bit_identical() {
    let (g, rows) = forty_zones();
    let sources =
        [(0..40).map(|i| Bands::from_rgb([(1 + i % 5) as f64, 0.0, 1.0 / (1 + i) as f64])).collect()];
    let weights: Vec<Bands> = (0..40).map(|i| Bands::splat((1.0 - 1.0 / (2 + i) as f64) / rows[i])).collect();
    let system =
        LinearSystem { operator: &g, weights: (&weights).into(), targets: &rows, sums: SumOrder::plain() };
    let store = MemoryStore::default();
    let with = |n, v: &dyn CheckpointStore| solve(&system, &sources, n, v, &NoProgress);
    let straight = with(35, &NoCheckpoints);
    with(23, &store);
    let state = store.load(STAGE).expect("a state after twenty orders");
    assert_eq!(decode_state(&state, &straight).map(|s| s.1), Some(21));
    assert_eq!(with(35, &store), straight);
    assert!(decode_state(&state[..state.len() - 1], &straight).is_none());
    assert_eq!(with(12, &store), with(12, &NoCheckpoints), "a state beyond the last order is not used");
}

fn rho_power(rho: f64, k: usize) -> f64 {
    rho.powi(k as i32)
}
