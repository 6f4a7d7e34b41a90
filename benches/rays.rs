//! Ray queries in a hall of 200,000 triangles, and its cut into zones: `cargo bench -p zonal-benches --bench rays`, one core.

mod hall;

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use zonal_math::{Vec3, low_discrepancy::hash_to_unit};
use zonal_scene::{Bands, VoxelGrid};
use zonal_transport::{Transport, build_zones};

/// Cells of the medium along an edge.
const CELLS: usize = 32;

fn queries(c: &mut Criterion) {
    let mut grid = VoxelGrid::new(Vec3::ZERO, hall::HALL / CELLS as f64, [CELLS; 3]).expect("a grid");
    for i in 0..grid.len() {
        grid.set(i, Bands::splat(hash_to_unit(i as u64)), Bands::splat(0.5), Bands::ZERO, Bands::ZERO);
    }
    let plates = hall::plates();
    let scene = hall::scene(&plates, Some(grid.seal().expect("a medium")));
    let t = Transport::new(&scene);
    for (kind, points) in [("volume", hall::in_volume(&scene)), ("surfaces", hall::on_surfaces(&plates))] {
        let mut segments = points.chunks_exact(2).cycle();
        let mut named = |name: &str, query: &dyn Fn(Vec3, Vec3) -> bool| {
            c.bench_function(&format!("{name}/{kind}"), |bench| {
                bench.iter(|| {
                    let segment = segments.next().expect("segments");
                    query(black_box(segment[0]), segment[1])
                })
            });
        };
        named("occluded", &|a, b| t.occluded(a, b));
        named("occluded-inside", &|a, b| t.occluded_inside(a, b));
        named("closest-hit", &|a, b| t.closest_hit(a, (b - a).normalized(), 1e-9, f64::INFINITY).is_some());
        named("optical-depth", &|a, b| t.optical_depth(a, b).first() > 1.0);
    }
    let mut group = c.benchmark_group("zones");
    group.sample_size(10).bench_function("200k", |bench| bench.iter(|| build_zones(&scene, &t)));
    group.bench_function("transport", |bench| bench.iter(|| Transport::new(&scene).occluder_count()));
}

criterion_group!(rays, queries);
criterion_main!(rays);
