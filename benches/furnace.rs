//! Whole solves of a furnace of 123 zones: `cargo bench -p zonal-benches --bench furnace`.

use criterion::{Criterion, criterion_group, criterion_main};
use zonal_scene::{Medium, Mesh, NoProgress, PatchRule, Scene, SolveOptions};

fn furnace(estimates_discretization: bool) -> Scene {
    let temperatures = [800.0, 800.0, 800.0, 800.0, 1200.0, 400.0];
    let walls = Mesh::room_walls([0.0; 3], [2.0, 2.0, 4.0]).into_iter().zip(temperatures);
    let walls = walls.map(|(wall, t)| wall.temperature(t).emissivity(0.8));
    let medium = Medium::grid([0.0; 3], [2.0, 2.0, 4.0], [3, 3, 5]).extinction(0.5).heat_source(5000.0);
    let options = SolveOptions {
        patch_rule: PatchRule::Voxels,
        discretization_error: Some(estimates_discretization),
        ..SolveOptions::default()
    };
    Scene::builder().surfaces(walls).medium(medium).options(options).build().expect("a furnace")
}

fn solves(c: &mut Criterion) {
    for (name, is_estimated) in [("with the discretization error", true), ("without it", false)] {
        let scene = furnace(is_estimated);
        c.bench_function(name, |bench| {
            bench.iter(|| zonal_solve::solve(scene.clone(), 1 << 30, &NoProgress).expect("a solution"))
        });
    }
}

criterion_group!(furnaces, solves);
criterion_main!(furnaces);
