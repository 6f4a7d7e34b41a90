//! View factors of a city of 2,640 triangles on a plane: `cargo bench -p zonal-benches --bench city`.
//!
//! Each of the blocks of 40 m has 16 triangles of ground and one building with 64 triangles of walls and 8 of roof.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use zonal_math::{Vec3, low_discrepancy::hash_to_unit, vec3};
use zonal_scene::{NoCheckpoints, NoProgress};
use zonal_view_factors::{ConvexPolygon, ViewFactorSettings, ViewFactors};

/// Edge of a block, m.
const BLOCK_EDGE: f64 = 40.0;
/// Columns and rows of blocks.
const BLOCKS: [usize; 2] = [6, 5];

/// Triangles of a parallelogram in n × m cells.
fn divide(out: &mut Vec<ConvexPolygon>, at: Vec3, edges: [Vec3; 2], [n, m]: [usize; 2]) {
    let corner =
        |i: usize, j: usize| at + edges[0] * (i as f64 / n as f64) + edges[1] * (j as f64 / m as f64);
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        let [p, q, r, s] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        out.extend([vec![p, q, r], vec![p, r, s]].map(|c| ConvexPolygon::new(c).expect("a triangle")));
    }
}

fn city() -> Vec<ConvexPolygon> {
    let mut out = Vec::new();
    for k in 0..BLOCKS[0] * BLOCKS[1] {
        let [u0, v0, u1, v1, h] = [0, 1, 2, 3, 4].map(|i| hash_to_unit(5 * k as u64 + i));
        let [x, y] = [k / BLOCKS[1], k % BLOCKS[1]].map(|i| i as f64 * BLOCK_EDGE);
        let (x0, y0, x1, y1) =
            (x + 6.0 + 4.0 * u0, y + 6.0 + 4.0 * v0, x + 30.0 + 4.0 * u1, y + 30.0 + 4.0 * v1);
        let height = 10.0 + 30.0 * h * h;
        let (xs, ys) = ([x, x0, x1, x + BLOCK_EDGE], [y, y0, y1, y + BLOCK_EDGE]);
        for (u, v) in (0..3).flat_map(|u| (0..3).map(move |v| (u, v))).filter(|c| *c != (1, 1)) {
            let edges = [vec3(xs[u + 1] - xs[u], 0.0, 0.0), vec3(0.0, ys[v + 1] - ys[v], 0.0)];
            divide(&mut out, vec3(xs[u], ys[v], 0.0), edges, [1, 1]);
        }
        let (dx, dy, up) = (vec3(x1 - x0, 0.0, 0.0), vec3(0.0, y1 - y0, 0.0), vec3(0.0, 0.0, height));
        for (at, along) in [([x0, y0], dx), ([x1, y0], dy), ([x1, y1], -dx), ([x0, y1], -dy)] {
            divide(&mut out, vec3(at[0], at[1], 0.0), [along, up], [2, 4]);
        }
        divide(&mut out, vec3(x0, y0, height), [dx, dy], [2, 2]);
    }
    out
}

fn factors(c: &mut Criterion) {
    let facets = city();
    let mut group = c.benchmark_group("city");
    for tolerance in [1e-2, 1e-3] {
        let settings = ViewFactorSettings { tolerance, ..Default::default() };
        group.sample_size(10).bench_function(BenchmarkId::from_parameter(tolerance), |bench| {
            bench.iter(|| ViewFactors::compute(&facets, &[], &settings, &NoProgress, &NoCheckpoints))
        });
    }
}

criterion_group!(benches, factors);
criterion_main!(benches);
