//! Updates of thermal states of a box of 600 patches: `cargo bench -p zonal-benches --bench states`.

use criterion::{Criterion, criterion_group, criterion_main};
use zonal_scene::{Mesh, NoProgress, Scene};
use zonal_solve::areas::exchange_areas::{ExchangeAreaContents, ExchangeAreaSettings, ExchangeAreas};
use zonal_solve::state::{ExchangeData, StateSolver};

fn updates(c: &mut Criterion) {
    let walls = Mesh::room_walls([0.0; 3], [1.0; 3]).map(|wall| wall.temperature(300.0).emissivity(0.7));
    let scene = Scene::builder().surfaces(walls).patch_size(0.1).build().expect("a box");
    let settings = ExchangeAreaSettings { contents: ExchangeAreaContents::Direct, ..Default::default() };
    let areas = ExchangeAreas::compute(&scene, &settings, &NoProgress).expect("areas");
    let data = ExchangeData::new(&scene, &areas, &NoProgress).expect("data");
    let (mut solver, mut k) = (StateSolver::new(data).expect("a solver"), 0);
    c.bench_function("other emissivities", |bench| {
        bench.iter(|| {
            k = (k + 1) % 500;
            solver.set_reflectance(0, &[0.3 + 1e-3 * k as f64])?;
            solver.solve().map(drop)
        })
    });
    let n = solver.data().zone_count();
    c.bench_function("other temperatures", |bench| {
        bench.iter(|| {
            k += 1;
            let kelvin: Vec<f64> = (0..n).map(|i| 300.0 + ((i * 7 + k) % 500) as f64).collect();
            solver.set_temperatures(&kelvin)?;
            solver.solve().map(drop)
        })
    });
}

criterion_group!(states, updates);
criterion_main!(states);
