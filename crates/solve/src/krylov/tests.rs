use super::*;
use crate::packed::Packed;
use std::collections::HashMap;
use std::sync::Mutex;
use zonal_math::Grade;
use zonal_scene::{NoVault, Quiet};

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

/// Two facing walls of area 1 that see only each other: s_1 = s⁰_1 + ρ s_2, s_2 = s⁰_2 + ρ s_1.
fn two_walls() -> Plain {
    let mut m = Packed::zeros(2);
    m.rows_mut()[1][0] = 1.0;
    Plain(m)
}

/// 40 zones of about equal area that see each other almost alike, and how much they send on.
fn many() -> (Plain, Vec<f64>) {
    let mut m = Packed::zeros(40);
    for (i, row) in m.rows_mut().into_iter().enumerate() {
        row.iter_mut().enumerate().for_each(|(j, x)| *x = 1.0 / (40.0 + (i * j % 7) as f64));
    }
    let rows = m.apply(&[[1.0]; 40]).iter().map(|r| r[0]).collect();
    (Plain(m), rows)
}

fn run(g: &Plain, sources: &[Vec<Bands>], w: f64, targets: &[f64], stop: (f64, usize)) -> Vec<Ended> {
    let weights: Vec<Bands> = targets.iter().map(|t| [w / t; 3]).collect();
    let system = System { operator: g, weights: &weights, targets };
    solve(&system, sources, None, Stop { residual: stop.0, iterations: stop.1 }, &NoVault, &Quiet)
}

#[test]
fn two_mirroring_walls_have_a_closed_form() {
    let rho = 0.8;
    // Both walls shine, each on its own, in one run.
    let sources = [vec![[1.0; 3], [0.0; 3]], vec![[0.0; 3], [0.0, 2.0, 1.0]]];
    let e = run(&two_walls(), &sources, rho, &[1.0; 2], (1e-13, 50));
    assert!(e.iter().all(|e| e.status == [SolveStatus::Converged; 3]));
    let most = 1.0 / (1.0 - rho * rho);
    assert!((e[0].strengths[0][1] - most).abs() < 1e-12);
    assert!((e[0].strengths[1][2] - rho * most).abs() < 1e-12);
    assert!((e[1].strengths[0][1] - 2.0 * rho * most).abs() < 1e-12);
    assert_eq!(e[1].strengths[0][0], 0.0, "nothing shines in this band");
    // At first all of the light has still to be sent on once.
    assert!((e[0].residuals[0][0] - rho).abs() < 1e-15);
    assert_eq!(e[1].power, [0.0, 2.0, 1.0]);
}

#[test]
fn a_spent_budget_and_an_impossible_problem_are_said() {
    let (g, rows) = many();
    let source: Vec<Bands> = (0..40).map(|i| [1.0 + i as f64; 3]).collect();
    let e = run(&g, &[source], 0.9, &rows, (1e-15, 1));
    assert_eq!(e[0].status[0], SolveStatus::Budget);
    // Reflectances above one gain power at every bounce: no solution.
    let e = run(&two_walls(), &[vec![[1.0; 3], [0.5; 3]]], 1.5, &[1.0; 2], (1e-12, 50));
    assert_eq!(e[0].status[0], SolveStatus::Stalled);
}

/// What all zones absorb is off by no more than the residual, for any iterate.
#[test]
fn the_residual_bounds_the_power_left_undistributed() {
    let (g, rows) = many();
    let source: Vec<Bands> = (0..40).map(|i| if i < 3 { [10.0, 1.0, 0.1] } else { [0.0; 3] }).collect();
    let w = 0.97;
    let absorbed = |e: &Ended| -> f64 { (0..40).map(|i| (1.0 - w) * rows[i] * (e.strengths[i][0])).sum() };
    let off = |a: &Ended, b: &Ended| -> f64 {
        (0..40).map(|i| (1.0 - w) * rows[i] * (a.strengths[i][0] - b.strengths[i][0]).abs()).sum()
    };
    let exact = &run(&g, std::slice::from_ref(&source), w, &rows, (1e-14, 100))[0];
    assert!((absorbed(exact) / exact.power[0] - 1.0).abs() < 1e-12, "all the power is absorbed in the end");
    for n in 1..6 {
        let e = &run(&g, std::slice::from_ref(&source), w, &rows, (1e-14, n))[0];
        let bound = e.residuals[0].last().unwrap() * e.power[0];
        let off = off(e, exact);
        assert!(off <= bound * (1.0 + 1e-9) + 1e-13 * e.power[0], "{n}: {off:e} {bound:e}");
    }
}

#[test]
fn a_warm_start_at_the_solution_is_done_at_once() {
    let (g, rows) = many();
    let source: Vec<Bands> = (0..40).map(|i| [1.0 + i as f64; 3]).collect();
    let weights: Vec<Bands> = rows.iter().map(|t| [0.9 / t; 3]).collect();
    let system = System { operator: &g, weights: &weights, targets: &rows };
    let stop = Stop { residual: 1e-10, iterations: 100 };
    let once = solve(&system, std::slice::from_ref(&source), None, stop, &NoVault, &Quiet);
    let again = solve(&system, &[source], Some(&[once[0].strengths.clone()]), stop, &NoVault, &Quiet);
    assert_eq!(again[0].residuals[0].len(), 1);
    assert!(once[0].residuals[0].len() > 2);
}

#[test]
fn sweeps_are_partial_sums_of_the_neumann_series() {
    let (rho, weights) = (0.8, [[0.8; 3]; 2]);
    let g = two_walls();
    let system = System { operator: &g, weights: &weights, targets: &[1.0; 2] };
    for n in 1..7 {
        let e = sweeps(&system, &[vec![[1.0; 3], [0.0; 3]]], n, &NoVault, &Quiet);
        let arriving = g.apply(&e[0].strengths)[1][0];
        // Light arrives at the second wall after 1, 3, 5 … segments.
        let want: f64 = (1..=n).step_by(2).map(|k| rho_to(rho, k - 1)).sum();
        assert!((arriving - want).abs() < 1e-14, "{n}: {arriving} {want}");
        assert_eq!((e[0].status[0], e[0].residuals[0].len()), (SolveStatus::Swept, n));
        assert!((e[0].residuals[0][n - 1] - rho_to(rho, n)).abs() < 1e-14);
    }
}

#[test]
fn sweeps_taken_up_end_with_the_same_bits() {
    let (g, rows) = many();
    let sources = [(0..40).map(|i| [(1 + i % 5) as f64, 0.0, 1.0 / (1 + i) as f64]).collect()];
    let weights: Vec<Bands> = (0..40).map(|i| [(1.0 - 1.0 / (2 + i) as f64) / rows[i]; 3]).collect();
    let system = System { operator: &g, weights: &weights, targets: &rows };
    let vault = Memory::default();
    let with = |n, v: &dyn Vault| sweeps(&system, &sources, n, v, &Quiet);
    let straight = with(35, &NoVault);
    with(23, &vault);
    let state = vault.load(SWEEPS).expect("a state after twenty sweeps");
    assert_eq!(swept(&state, &straight).map(|s| s.1), Some(21));
    assert_eq!(with(35, &vault), straight);
    assert!(swept(&state[..state.len() - 1], &straight).is_none());
    assert_eq!(with(12, &vault), with(12, &NoVault), "a state beyond the wanted end");
}

fn rho_to(rho: f64, k: usize) -> f64 {
    rho.powi(k as i32)
}

#[derive(Default)]
struct Memory(Mutex<HashMap<String, Vec<u8>>>);
impl Vault for Memory {
    fn load(&self, stage: &str) -> Option<Vec<u8>> {
        self.0.lock().unwrap().get(stage).cloned()
    }
    fn save(&self, stage: &str, bytes: &[u8]) {
        self.0.lock().unwrap().insert(stage.into(), bytes.to_vec());
    }
}

#[test]
fn a_state_taken_up_ends_with_the_same_bits() {
    let (g, rows) = many();
    let sources = |colours: [f64; 3]| -> Vec<Vec<Bands>> {
        let one = |k: usize, i: usize| colours.map(|c| c * (1 + i * k % 5) as f64);
        (1..3).map(|k| (0..40).map(|i| one(k, i)).collect()).collect()
    };
    // Strong absorption apart, so that it takes its time.
    let weights: Vec<Bands> = (0..40).map(|i| [(1.0 - 1.0 / (2 + i) as f64) / rows[i]; 3]).collect();
    let system = System { operator: &g, weights: &weights, targets: &rows };
    fn check<const N: usize>(system: &System, sources: &[Vec<Bands>]) -> Vec<u8>
    where
        Column<N>: Bundle<N>,
    {
        let vault = Memory::default();
        let with = |n, v: &dyn Vault| {
            let stop = Stop { residual: 1e-30, iterations: n };
            solve_bands::<N>(system, sources, None, stop, v, &Quiet)
        };
        let straight = with(35, &NoVault);
        with(14, &vault);
        let state = vault.load(STAGE).expect("a state after ten iterations");
        assert_eq!(restored::<N>(&state, 2, 40).map(|s| s.1), Some(11));
        assert_eq!(with(35, &vault), straight);
        // Another number of zones or a cut file: begun afresh.
        assert!(restored::<N>(&state, 2, 41).is_none() && restored::<N>(&state, 1, 40).is_none());
        assert!(restored::<N>(&state[..state.len() - 1], 2, 40).is_none());
        state
    }
    let three = check::<3>(&system, &sources([1.0, 0.0, 0.3]));
    let one = check::<1>(&system, &sources([1.0; 3]));
    // Of another number of bands.
    assert!(restored::<1>(&three, 2, 40).is_none() && restored::<3>(&one, 2, 40).is_none());
}
