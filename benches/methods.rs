//! The paper's methods, by method and relative tolerance: one voxel to a 20³ block three voxels off, a pair for those that serve pairs.
//!
//! Floors at 3 GHz with AVX-512 (eight lanes; a division of eight takes 16 cycles, other operations half a cycle):
//!
//! | benchmark | operations | floor |
//! |---|---|---|
//! | `gauss-6d/t` for the block, m = 3, 4, 5 | 8,000 · m⁶ kernels, one division each: 2 cycles | 3.9 ms, 22 ms, 83 ms |
//! | `series/t` | nodes × orders of all references at 4 operations (¼ cycle) + a division a node: 0.3, 1.4, 3.4 million (from the counters) | 0.03 ms, 0.12 ms, 0.3 ms |
//! | `chebyshev/t`, block of 18³ at 25 voxels, κℓ = 0.1 | samples × nodes at a root, a division, an exponential: 6 cycles | 0.01 ms, 0.1 ms, 0.6 ms |
//! | `analogous/t`, 40 patches in a row | scalar recurrence, 9 operations an order and node | 2 µs, 8 µs, 30 µs |
//! | `point/any` | one kernel, one exponential | 20 ns |
//! | `prop1/t` | the mean inverse distance: 8,000 roots a cell | 20 µs |

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use zonal_exchange::AccuracyRequest;
use zonal_exchange::aligned::Cuboid;
use zonal_math::{Vec3, vec3};
use zonal_paper::voxel_strips::{MomentQuadrature, StripAccuracy, StripFactors, UniformGrid, formfact};
use zonal_paper::{chebyshev, gauss_6d, patch_strips, point, proposition1};

fn unit(x: f64, y: f64, z: f64) -> Cuboid {
    Cuboid::voxel(vec3(x, y, z), vec3(x + 1.0, y + 1.0, z + 1.0))
}

fn methods(c: &mut Criterion) {
    let v = unit(-4.0, 10.0, 10.0);
    let grid = UniformGrid { origin: Vec3::splat(0.0), cell: Vec3::splat(1.0), dims: [20; 3] };
    let lattice = chebyshev::ZoneLattice {
        from: v,
        first: unit(25.0, 0.0, 0.0),
        step: Vec3::splat(1.0),
        dims: [18; 3],
    };
    let patch = Cuboid::patch(Vec3::splat(0.0), vec3(1.0, 1.0, 0.0), 2, 1);
    let wall = Cuboid::patch(vec3(-20.0, 0.0, 4.0), vec3(-19.0, 1.0, 4.0), 2, -1);
    let row = patch_strips::ZoneRow { from: patch, first: wall, axis: 0, step: 1.0, count: 40 };
    let (a, b) = (unit(0.0, 0.0, 0.0), unit(4.0, 1.0, 0.0));
    for (tolerance, m) in [(1e-3, 3), (1e-6, 4), (1e-9, 5)] {
        let demand = AccuracyRequest::relative(tolerance);
        let mut named = |name: &str, work: &mut dyn FnMut()| {
            c.bench_function(&format!("{name}/{tolerance:e}"), |bench| bench.iter(&mut *work));
        };
        named("gauss-6d", &mut || {
            black_box(gauss_6d::grid_baseline(black_box(&v), &grid, m));
        });
        let strips = |v: &Cuboid| -> StripFactors {
            formfact(v, &grid, StripAccuracy::Tolerance(tolerance), MomentQuadrature::Reduced)
        };
        named("series", &mut || {
            black_box(strips(black_box(&v)));
        });
        named("chebyshev", &mut || {
            black_box(chebyshev::lattice_factors(black_box(&lattice), 0.1, &demand));
        });
        named("analogous", &mut || {
            black_box(patch_strips::row_factors(black_box(&row), &demand));
        });
        named("prop1", &mut || {
            black_box(proposition1::factor(black_box(&a), &b, 1e-3, &demand));
        });
    }
    c.bench_function("point/any", |bench| bench.iter(|| point::factor(black_box(&a), &b, 0.1)));
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10).warm_up_time(std::time::Duration::from_millis(300)).measurement_time(std::time::Duration::from_secs(1));
    targets = methods
}
criterion_main!(benches);
