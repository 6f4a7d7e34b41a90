//! Times of the aligned methods by tolerance: `cargo bench -p zonal-benches --bench aligned`, one core.
//!
//! **Floors** (operations an entry, AVX-512 at about 3 GHz, two vector operations a cycle, a division of eight lanes 16 cycles):
//!
//! | bench | what is counted | floor |
//! |---|---|---|
//! | cubes, κ = 0 | order 2K: K²/6 + K products, 40 for offset, bound and radius, one division: about 60 operations in lanes of 8 | 3 ns |
//! | walls, κ = 0 | three axes to order K: 2 binom(K+4, 4) products and sums, K = 2…3: 60…140 in lanes of 8, two roots | 6 ns |
//! | cubes, κℓ = 0.1 | 27…64 exponentials (30 operations, a root and a division each, 48 cycles in lanes of 8) and 18 bounds (60 cycles) | 100…170 ns |
//! | block | 1,100 cubes as above; 8,000 values and radii gathered and written (2 cycles each, 128 KiB) | 3 + 11 µs |
//! | moments, one pair | two tables of 45 numbers per axis, the products above: 1,000 scalar operations | 200 ns |
//! | closed | two walls with a common edge: 6 arcs and 14 logarithms that do not vanish (20 cycles each), 14 divisions | 150 ns |
//! | gauss, pyramid | points × (a division; with κ an exponential, 6 cycles in lanes): 8³…20³ points in some cells | 1…100 µs |

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use zonal_exchange::aligned::lattice::{GridTables, VoxelBlock, voxel_block};
use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_math::{Vec3, vec3};

const TOLERANCES: [f64; 3] = [1e-3, 1e-6, 1e-9];

fn pairs(c: &mut Criterion) {
    let unit = Cuboid::voxel(Vec3::ZERO, Vec3::ONE);
    let at = |x: f64, y: f64, z: f64| Cuboid::voxel(vec3(x, y, z), vec3(x, y, z) + vec3(0.9, 1.0, 1.1));
    let cases = [
        ("moments", unit, at(7.0, 3.0, 1.0), 0.0),
        ("closed", unit.walls()[0], unit.walls()[3], 0.0),
        ("gauss", unit, at(2.0, 0.5, 0.0), 0.0),
        ("gauss-attenuated", unit, at(2.0, 0.5, 0.0), 1.0),
        ("pyramid", unit, at(1.0, 0.0, 0.0), 0.0),
        ("pyramid-attenuated", unit, at(1.0, 0.0, 0.0), 1.0),
    ];
    for (name, a, b, kappa) in cases {
        let mut group = c.benchmark_group(name);
        for tolerance in TOLERANCES {
            group.bench_function(BenchmarkId::from_parameter(format!("{tolerance:e}")), |bench| {
                bench.iter(|| geometric_factor(black_box(&a), black_box(&b), kappa, tolerance))
            });
        }
    }
}

fn tables(c: &mut Criterion) {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    let table = |kappa: f64, tolerance: f64| GridTables::new([1.0; 3], [50; 3], black_box(kappa), tolerance);
    for tolerance in TOLERANCES {
        let mut named = |name: &str, work: &mut dyn FnMut() -> usize| {
            let mut group = c.benchmark_group(name);
            group.sample_size(if name == "block" { 20 } else { 10 });
            group.bench_function(BenchmarkId::from_parameter(format!("{tolerance:e}")), |b| {
                b.iter(&mut *work)
            });
        };
        named("table", &mut || one.install(|| table(0.0, tolerance).voxels().len()));
        named("table-attenuated", &mut || one.install(|| table(0.1, tolerance).voxels().len()));
        named("walls", &mut || one.install(|| table(0.0, tolerance).wall(2).len()));
        let block =
            |first| -> VoxelBlock { voxel_block([1.0; 3], black_box(first), [20; 3], 0.0, tolerance) };
        named("block", &mut || block([3.0, -9.5, -9.5]).values.len());
    }
}

criterion_group! {
    name = aligned;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(std::time::Duration::from_millis(200))
        .measurement_time(std::time::Duration::from_millis(600));
    targets = pairs, tables
}
criterion_main!(aligned);
