use super::*;
use crate::distribution::sum_order::SumOrder;
use crate::iteration::test_operators::{MemoryStore, PackedOperator, forty_zones, two_walls};
use crate::operator::ExchangeOperator;
use zonal_scene::{NoCheckpoints, NoProgress};

fn run(
    g: &PackedOperator,
    sources: &[Vec<Bands>],
    w: f64,
    targets: &[f64],
    stop: (f64, usize),
) -> Vec<IterationResult> {
    let weights: Vec<Bands> = targets.iter().map(|t| Bands::splat(w / t)).collect();
    let system = LinearSystem { operator: g, weights: (&weights).into(), targets, sums: SumOrder::plain() };
    solve(
        system,
        None,
        sources.to_vec(),
        None,
        StoppingCriterion { residual: stop.0, max_iterations: stop.1 },
        &NoCheckpoints,
        &NoProgress,
    )
    .0
}

#[test]
fn two_facing_symmetry_planes_match_the_closed_form() {
    let rho = 0.8;
    // Both walls emit, each as a group of its own, in one run.
    let sources = [vec![Bands::ONE, Bands::ZERO], vec![Bands::ZERO, Bands::from_rgb([0.0, 2.0, 1.0])]];
    let e = run(&two_walls(), &sources, rho, &[1.0; 2], (1e-13, 50));
    assert!(e.iter().all(|e| e.status == PerBand::splat(SolveStatus::Converged)));
    let most = 1.0 / (1.0 - rho * rho);
    let difference = |x: Bands, y: Bands| (x - y).abs().max_element();
    assert!(difference(e[0].strengths[0], Bands::splat(most)) < 1e-12);
    assert!(difference(e[0].strengths[1], Bands::splat(rho * most)) < 1e-12);
    assert!(difference(e[1].strengths[0], rho * most * Bands::from_rgb([0.0, 2.0, 1.0])) < 1e-12);
    assert_eq!(e[1].strengths[0].first(), 0.0, "no source in this band");
    // Before the first iteration all of the light has to be reflected once.
    assert!((e[0].residuals[Band::first()][0] - rho).abs() < 1e-15);
    assert_eq!(e[1].power, Bands::from_rgb([0.0, 2.0, 1.0]));
}

// Guards (numbers): an iteration that does not converge is a status, never an `Err`.
#[test]
fn spent_budget_and_divergent_problem_have_a_status() {
    let (g, rows) = forty_zones();
    let source: Vec<Bands> = (0..40).map(|i| Bands::splat(1.0 + i as f64)).collect();
    let e = run(&g, &[source], 0.9, &rows, (1e-15, 1));
    assert_eq!(e[0].status[Band::first()], SolveStatus::MaxIterations);
    // Reflectances above one gain power at every reflection: no solution.
    let e = run(&two_walls(), &[vec![Bands::ONE, Bands::splat(0.5)]], 1.5, &[1.0; 2], (1e-12, 50));
    assert_eq!(e[0].status[Band::first()], SolveStatus::Stalled);
}

/// The error of the absorbed power is at most the residual, for any iterate.
#[test]
fn residual_bounds_the_undistributed_power() {
    let (g, rows) = forty_zones();
    let source: Vec<Bands> =
        (0..40).map(|i| if i < 3 { Bands::from_rgb([10.0, 1.0, 0.1]) } else { Bands::ZERO }).collect();
    let w = 0.97;
    let absorbed =
        |e: &IterationResult| -> f64 { (0..40).map(|i| (1.0 - w) * rows[i] * e.strengths[i].first()).sum() };
    let off = |a: &IterationResult, b: &IterationResult| -> f64 {
        (0..40).map(|i| (1.0 - w) * rows[i] * (a.strengths[i] - b.strengths[i]).first().abs()).sum()
    };
    let exact = &run(&g, std::slice::from_ref(&source), w, &rows, (1e-14, 100))[0];
    assert!(
        (absorbed(exact) / exact.power.first() - 1.0).abs() < 1e-12,
        "all the power is absorbed in the end"
    );
    for n in 1..6 {
        let e = &run(&g, std::slice::from_ref(&source), w, &rows, (1e-14, n))[0];
        let bound = e.residuals[Band::first()].last().unwrap() * e.power.first();
        let off = off(e, exact);
        assert!(off <= bound * (1.0 + 1e-9) + 1e-13 * e.power.first(), "{n}: {off:e} {bound:e}");
    }
}

#[test]
fn warm_start_at_the_solution_needs_no_iteration() {
    let (g, rows) = forty_zones();
    let source: Vec<Bands> = (0..40).map(|i| Bands::splat(1.0 + i as f64)).collect();
    let weights: Vec<Bands> = rows.iter().map(|t| Bands::splat(0.9 / t)).collect();
    let system =
        LinearSystem { operator: &g, weights: (&weights).into(), targets: &rows, sums: SumOrder::plain() };
    let stop = StoppingCriterion { residual: 1e-10, max_iterations: 100 };
    let (once, _) =
        solve(system.clone(), None, vec![source.clone()], None, stop, &NoCheckpoints, &NoProgress);
    let (again, _) = solve(
        system,
        None,
        vec![source],
        Some(&[once[0].strengths.clone()]),
        stop,
        &NoCheckpoints,
        &NoProgress,
    );
    assert_eq!(again[0].residuals[Band::first()].len(), 1);
    assert!(once[0].residuals[Band::first()].len() > 2);
}

#[test]
fn incident_power_is_the_product_of_the_strengths() {
    let (g, rows) = forty_zones();
    let sources = |colours: Bands| vec![(0..40).map(|i| colours * (1 + i % 3) as f64).collect::<Vec<_>>()];
    // Black zones too.
    let weights: Vec<Bands> = (0..40).map(|i| Bands::splat(0.1 * (i % 10) as f64 / rows[i])).collect();
    let system =
        LinearSystem { operator: &g, weights: (&weights).into(), targets: &rows, sums: SumOrder::plain() };
    let stop = StoppingCriterion { residual: 1e-12, max_iterations: 100 };
    let check = |(results, products): (Vec<IterationResult>, Vec<Vec<Bands>>)| {
        let want = g.apply(&results[0].strengths);
        for (p, want) in products[0].iter().zip(&want) {
            assert!((*p - *want).abs().max_element() < 1e-13 * want.max_element(), "{p:?} {want:?}");
        }
        let again = products.iter().flatten().all(|p| p.all(|x| x > 0.0));
        assert!(again && results[0].residuals[Band::first()].len() > 3);
    };
    let warm = [vec![Bands::splat(2.0); 40]];
    for initial in [None, Some(&warm[..])] {
        for colours in [Bands::ONE, Bands::from_rgb([1.0, 0.5, 2.0])] {
            let all = (None, sources(colours), initial, &NoCheckpoints, &NoProgress);
            check(solve_bands::<Bands, 3>(system.clone(), all.0, all.1.clone(), all.2, stop, all.3, all.4));
            if colours == Bands::ONE {
                check(solve_bands::<[f64; 1], 1>(system.clone(), all.0, all.1, all.2, stop, all.3, all.4));
            }
        }
    }
}

#[test]
fn resumed_iteration_is_bit_identical() {
    let (g, rows) = forty_zones();
    let sources = |colours: Bands| -> Vec<Vec<Bands>> {
        let one = |k: usize, i: usize| colours * (1 + i * k % 5) as f64;
        (1..3).map(|k| (0..40).map(|i| one(k, i)).collect()).collect()
    };
    // Absorption differs widely between zones, so that convergence is slow.
    let weights: Vec<Bands> = (0..40).map(|i| Bands::splat((1.0 - 1.0 / (2 + i) as f64) / rows[i])).collect();
    let system =
        LinearSystem { operator: &g, weights: (&weights).into(), targets: &rows, sums: SumOrder::plain() };
    fn check<E: BandEntry<N>, const N: usize>(system: &LinearSystem, sources: &[Vec<Bands>]) -> Vec<u8> {
        let store = MemoryStore::default();
        let with = |n, v: &dyn CheckpointStore| {
            let stop = StoppingCriterion { residual: 1e-30, max_iterations: n };
            solve_bands::<E, N>(system.clone(), None, sources.to_vec(), None, stop, v, &NoProgress).0
        };
        let straight = with(35, &NoCheckpoints);
        with(14, &store);
        let state = store.load(STAGE).expect("a state after ten iterations");
        assert_eq!(decode_state::<E, N>(&state, 2, 40).map(|s| s.next), Some(11));
        assert_eq!(with(35, &store), straight);
        // A state of another size or a truncated one is not used.
        assert!(
            decode_state::<E, N>(&state, 2, 41).is_none() && decode_state::<E, N>(&state, 1, 40).is_none()
        );
        assert!(decode_state::<E, N>(&state[..state.len() - 1], 2, 40).is_none());
        state
    }
    let three = check::<Bands, 3>(&system, &sources(Bands::from_rgb([1.0, 0.0, 0.3])));
    let one = check::<[f64; 1], 1>(&system, &sources(Bands::ONE));
    // A state for another number of bands is not used.
    assert!(
        decode_state::<[f64; 1], 1>(&three, 2, 40).is_none()
            && decode_state::<Bands, 3>(&one, 2, 40).is_none()
    );
}
