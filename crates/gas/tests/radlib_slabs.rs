//! Slabs of combustion gases: the gas models with the reference code for layers, against RadLib's answers and stated ones.
//!
//! The tables are those of the validation cases; `radlib_walls.csv` defines the slabs.

use zonal_gas::{GasModel, GasState};
use zonal_reference::slab::{BandEmission, STEFAN_BOLTZMANN, Slab, SlabBand, total_flux, total_source};

const WALLS: &str = include_str!("../../validation/src/validate/data/radlib_walls.csv");
const PROFILES: &str = include_str!("../../validation/src/validate/data/radlib_profiles.csv");

/// Relative limit of wall fluxes; the convergence of both codes is below 0.05 %.
const FLUX_LIMIT: f64 = 1e-3;
/// Limit of the root mean square of the source over its largest value.
const SOURCE_LIMIT: f64 = 2e-3;
/// Number of positions of a profile, less one.
const PROFILE_CELLS: usize = 100;

/// State of the gas of a case at x, m.
fn state(case: &str, x: f64) -> GasState {
    let parabola = x * (1.0 - x);
    let sine = (std::f64::consts::PI * x).sin().powi(2);
    let (temperature, h2o, co2) = match case {
        "S3" => (800.0 + 4000.0 * parabola, 0.12 + 0.8 * parabola, 0.0),
        "S4" => ((2500.0 - 2000.0 * (x - 0.15).abs() / 0.05).max(500.0), 0.1, 0.0),
        "S5" => (1000.0 + 500.0 * (0.5 * std::f64::consts::PI * x).cos(), 0.1, 0.0),
        "B3" => (400.0 + 1400.0 * sine, 1e-4 + 0.9999 * sine, 0.9999 * (1.0 - sine)),
        "S1" => (if x < 0.5 { 2000.0 } else { 300.0 }, 0.2, 0.1),
        _ => (1000.0, 0.0, if x < 0.5 { 0.4 } else { 0.1 }),
    };
    GasState { temperature, h2o, co2, ..GasState::default() }
}

/// Net flux, kW/m², at the boundaries of layers, and source, kW/m³, in layers of these thicknesses, m, with the gas of their midpoints. Walls are black, of the state at the
/// ends, or cold.
fn flux(model: GasModel, case: &str, thickness: Vec<f64>, cold: bool) -> [Vec<f64>; 2] {
    let gases = |s: &GasState| model.evaluate(s).expect("a valid state").gases;
    let power = |s: &GasState| STEFAN_BOLTZMANN * s.temperature.powi(4);
    let mut x = 0.0;
    let mut states = Vec::new();
    for d in &thickness {
        states.push(state(case, x + 0.5 * d));
        x += d;
    }
    let ends = [state(case, 0.0), state(case, x)];
    let (mut bands, mut emission) = (Vec::new(), Vec::new());
    for b in 0..gases(&ends[0]).len() {
        let layers: Vec<_> = states.iter().map(|s| gases(s)[b]).collect();
        let albedo = vec![0.0; layers.len()];
        let extinction = layers.iter().map(|g| g.absorption).collect();
        bands.push(SlabBand { extinction, albedo, wall_emissivity: [1.0; 2] });
        let wall = |s: &GasState| if cold { 0.0 } else { gases(s)[b].weight * power(s) };
        let own = states.iter().zip(&layers).map(|(s, g)| g.weight * power(s)).collect();
        emission.push(BandEmission { layers: own, walls: [wall(&ends[0]), wall(&ends[1])] });
    }
    let solved = Slab { thickness, bands }.solve(&emission);
    [total_flux(&solved), total_source(&solved)].map(|v| v.iter().map(|x| x / 1e3).collect())
}

fn rows(table: &str) -> impl Iterator<Item = Vec<&str>> {
    table.lines().filter(|l| !l.starts_with(['#', 'c'])).map(|l| l.split(',').collect())
}

fn number(text: &str) -> f64 {
    text.parse().expect("a number")
}

fn uniform(case: &str, cells: usize) -> Vec<f64> {
    let length = match case {
        "S4" => 0.3,
        "S5" => 2.0,
        _ => 1.0,
    };
    vec![length / cells as f64; cells]
}

// Guards (numbers): gas models in slabs give RadLib's wall fluxes within 0.1 %.
#[test]
fn wall_fluxes_of_slabs_match_radlib() {
    for row in rows(WALLS) {
        let [length2, low, high] = [1, 2, 3].map(|k| number(row[k]));
        let [q, _] = match row[0] {
            case @ ("S1" | "S2") => {
                let layers = if length2 > 0.0 { vec![0.5, length2] } else { vec![0.5] };
                flux(GasModel::Bordbar2020, case, layers, true)
            }
            case => flux(GasModel::Bordbar2020, case, uniform(case, 3 * PROFILE_CELLS), false),
        };
        for (got, want) in [(q[0], low), (q[q.len() - 1], high)] {
            assert!((got / want - 1.0).abs() < FLUX_LIMIT, "{row:?}: {got} {want}");
        }
    }
}

#[test]
fn sources_of_slabs_match_radlib() {
    for case in ["S3", "S4", "S5", "B3"] {
        let want: Vec<f64> = rows(PROFILES).filter(|r| r[0] == case).map(|r| number(r[2])).collect();
        assert_eq!(want.len(), PROFILE_CELLS + 1, "{case}");
        let layers = uniform(case, 3 * PROFILE_CELLS);
        let thickness = layers[0];
        let [_, got] = flux(GasModel::Bordbar2020, case, layers, false);
        // Sources by area of a cell of the profile, kW/m².
        let ours = |i: usize| got[3 * i..3 * i + 3].iter().sum::<f64>() * thickness;
        let theirs = |i: usize| want[i] - want[i + 1];
        let square = |i| (ours(i) - theirs(i)).powi(2);
        let rms = ((0..PROFILE_CELLS).map(square).sum::<f64>() / PROFILE_CELLS as f64).sqrt();
        let largest = (0..PROFILE_CELLS).map(|i| theirs(i).abs()).fold(0.0, f64::max);
        assert!(rms < SOURCE_LIMIT * largest, "{case}: {rms} {largest}");
    }
}

/// 86.0 kW/m² of an independent program, 86.7 of the line-by-line spectrum.
#[test]
fn superposition_gives_the_wall_flux_of_the_case_of_pure_ends() {
    let [q, _] = flux(GasModel::Cassol2014, "B3", uniform("B3", PROFILE_CELLS), false);
    assert!((q[0] + 86.0).abs() < 0.2, "{}", q[0]);
}
