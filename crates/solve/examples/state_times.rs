//! Times of thermal states of a box of 600 patches: the factorization, and updates of all temperatures.
//!
//!     cargo run --release -p zonal-solve --example state_times

use std::time::Instant;
use zonal_scene::{Mesh, NoProgress, Scene, SceneError};
use zonal_solve::areas::exchange_areas::{ExchangeAreaContents, ExchangeAreaSettings, ExchangeAreas};
use zonal_solve::state::{ExchangeData, StateSolver};

/// Repetitions of which the shortest and the median are printed.
const REPETITIONS: usize = 101;

/// Prints the shortest and the median time of a computation, ms.
fn measure(what: &str, mut run: impl FnMut(usize) -> Result<(), SceneError>) -> Result<(), SceneError> {
    let mut times = Vec::with_capacity(REPETITIONS);
    for k in 0..REPETITIONS {
        let start = Instant::now();
        run(k)?;
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    times.sort_by(f64::total_cmp);
    println!("{what}: shortest {:.2} ms, median {:.2} ms", times[0], times[REPETITIONS / 2]);
    Ok(())
}

fn main() -> Result<(), SceneError> {
    let walls = Mesh::room_walls([0.0; 3], [1.0; 3]).map(|wall| wall.temperature(300.0).emissivity(0.7));
    let scene = Scene::builder().surfaces(walls).patch_size(0.1).build()?;
    let settings = ExchangeAreaSettings { contents: ExchangeAreaContents::Direct, ..Default::default() };
    let areas = ExchangeAreas::compute(&scene, &settings, &NoProgress)?;
    let mut solver = StateSolver::new(ExchangeData::new(&scene, &areas, &NoProgress)?)?;
    let n = solver.data().zone_count();
    println!("{n} zones");
    measure("other emissivities", |k| {
        solver.set_reflectance(0, &[0.3 + 1e-3 * k as f64])?;
        solver.solve().map(drop)
    })?;
    measure("other temperatures", |k| {
        let kelvin: Vec<f64> = (0..n).map(|i| 300.0 + ((i * 7 + k) % 500) as f64).collect();
        solver.set_temperatures(&kelvin)?;
        solver.solve().map(drop)
    })
}
