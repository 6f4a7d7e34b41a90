//! Plates in general positions, by method and relative tolerance.
//!
//! Floors at 3 GHz with AVX-512 (eight lanes; a division or root of eight takes 16 to 24 cycles, other operations half a cycle):
//!
//! | benchmark | operations | floor |
//! |---|---|---|
//! | `far/t`, two triangles five edges apart | kernels of the tensor rule, one division each: 2 cycles; n⁴ with n = 2, 3, 4 | 11 ns, 54 ns, 170 ns |
//! | `touching/t`, two triangles with a common edge | nine pairs of edges in closed form, sixteen dilogarithms of some 60 operations each | 3 µs |
//! | `medium/t`, the same far pair, κ = 1 | a division, a root and an exponential a kernel: 6 cycles | 32 ns, 160 ns, 510 ns |
//! | `voxel/t`, a triangle and a cube five edges apart | n⁵ kernels with a division and a root: 4 cycles | 43 ns, 320 ns, 1.4 µs |

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use zonal_exchange::AccuracyRequest;
use zonal_exchange::polygon::{PreparedPlates, plate_cuboid, plate_plate};
use zonal_math::{Vec3, vec3};
use zonal_scene::Plate;

fn pairs(c: &mut Criterion) {
    let a = Plate::triangle(Vec3::ZERO, vec3(1.0, 0.1, 0.0), vec3(0.2, 1.0, 0.1));
    let far = Plate::triangle(vec3(0.3, 0.1, 5.0), vec3(0.1, 1.1, 5.3), vec3(1.2, 0.2, 5.1));
    let touching = Plate::triangle(vec3(1.0, 0.1, 0.0), Vec3::ZERO, vec3(0.4, -0.3, 1.0));
    let touching = if touching.normal().dot(a.centre() - touching.centre()) > 0.0 {
        touching
    } else {
        touching.flipped()
    };
    let voxel = (vec3(0.0, 0.0, 5.0), vec3(1.0, 1.0, 6.0));
    for tolerance in [1e-3, 1e-6, 1e-9] {
        let demand = AccuracyRequest::relative(tolerance);
        let mut named = |name: &str, work: &mut dyn FnMut()| {
            c.bench_function(&format!("{name}/{tolerance:e}"), |bench| bench.iter(&mut *work));
        };
        named("far", &mut || {
            black_box(plate_plate(black_box(&a), &far, 0.0, demand));
        });
        named("touching", &mut || {
            black_box(plate_plate(black_box(&a), &touching, 0.0, demand));
        });
        named("medium", &mut || {
            black_box(plate_plate(black_box(&a), &far, 1.0, demand));
        });
        named("voxel", &mut || {
            black_box(plate_cuboid(black_box(&a), voxel.0, voxel.1, 0.0, demand));
        });
    }
}

/// All pairs of the walls of a cube, each cut into 200 triangles and turned, so that no lattice is left.
fn matrix(c: &mut Criterion) {
    const CELLS: usize = 10;
    let x = vec3(0.8, 0.5, 0.33).normalized();
    let y = x.cross(vec3(-0.3, 0.9, 0.4)).normalized();
    let axes = [x, y, x.cross(y)];
    let mut plates = Vec::new();
    for wall in 0..6 * CELLS * CELLS {
        let (axis, far) = (wall % 3, wall / 3 % 2);
        let [i, j] = [wall / 6 % CELLS, wall / 6 / CELLS].map(|k| k as f64 / CELLS as f64);
        let (u, v) = (axes[(axis + 1) % 3], axes[(axis + 2) % 3]);
        let (p, du, dv) = (u * i + v * j + axes[axis] * far as f64, u / CELLS as f64, v / CELLS as f64);
        let (du, dv) = if far == 0 { (du, dv) } else { (dv, du) };
        plates.extend([Plate::triangle(p, p + du, p + du + dv), Plate::triangle(p, p + du + dv, p + dv)]);
    }
    let ready = PreparedPlates::new(&plates);
    c.bench_function("matrix/pair", |bench| bench.iter(|| ready.pair(black_box(0), 700, 1e-9, 1e-12)));
    let matrix = || -> f64 {
        let ready = PreparedPlates::new(black_box(&plates));
        let row = |i: usize| (0..i).map(|j| ready.pair(i, j, 1e-9, 1e-12).bounded.value).sum::<f64>();
        (0..plates.len()).map(row).sum()
    };
    let mut group = c.benchmark_group("matrix");
    group.sample_size(10).bench_function("1200", |bench| bench.iter(matrix));
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).warm_up_time(std::time::Duration::from_millis(200)).measurement_time(std::time::Duration::from_secs(1));
    targets = pairs, matrix
}
criterion_main!(benches);
