//! View factors of a city of boxes on a plane: time, counts, and defects of rows before closing.
//!
//!     cargo run --release -p zonal-view-factors --example city -- [columns] [rows] [tolerance]
//!
//! Each of the columns × rows blocks of 40 m has 16 triangles of ground and one building with 64 triangles of walls and 8 of roof: 18 × 14
//! blocks have 22,176 facets.

use std::time::Instant;
use zonal_math::{Vec3, vec3};
use zonal_scene::{NoCheckpoints, NoProgress};
use zonal_view_factors::{ConvexPolygon, ViewFactorSettings, ViewFactors};

/// Edge of a block, m.
const BLOCK_EDGE: f64 = 40.0;

fn main() {
    let argument =
        |k: usize, default: f64| std::env::args().nth(k).and_then(|s| s.parse().ok()).unwrap_or(default);
    let facets = city(argument(1, 18.0) as usize, argument(2, 14.0) as usize);
    let surroundings =
        if argument(4, 0.0) > 0.0 { zonal_view_factors::Openness::Closed } else { Default::default() };
    let settings = ViewFactorSettings { tolerance: argument(3, 1e-3), surroundings, ..Default::default() };
    let begin = Instant::now();
    let f =
        ViewFactors::compute(&facets, &[], &settings, &NoProgress, &NoCheckpoints).expect("valid settings");
    let seconds = begin.elapsed().as_secs_f64();
    let mut defects: Vec<f64> = f.defects().iter().map(|d| d.abs()).collect();
    defects.sort_by(f64::total_cmp);
    let at = |share: f64| defects[((defects.len() - 1) as f64 * share) as usize];
    println!("{:?}", f.counts);
    println!(
        "{} factors in {seconds:.2} s; {:.1e} remains of defects",
        f.entry_count(),
        f.remaining_defect()
    );
    println!(
        "defects before closing: median {:.1e}, 99 % {:.1e}, largest {:.1e}",
        at(0.5),
        at(0.99),
        at(1.0)
    );
    let largest = (0..f.len()).flat_map(|i| f.row(i)).fold(0.0f64, |s, (_, b)| s.max(b.value));
    let covered = (0..f.len()).filter(|i| f.defects()[*i].abs() <= f.row_radius(*i)).count();
    println!(
        "largest factor {largest:.4}; rows whose defect is within their radii: {covered} of {}",
        f.len()
    );
}

/// Triangles of a parallelogram in n × m cells.
fn divide(out: &mut Vec<ConvexPolygon>, at: Vec3, edges: [Vec3; 2], [n, m]: [usize; 2]) {
    let corner =
        |i: usize, j: usize| at + edges[0] * (i as f64 / n as f64) + edges[1] * (j as f64 / m as f64);
    for i in 0..n {
        for j in 0..m {
            let [p, q, r, s] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            out.extend([vec![p, q, r], vec![p, r, s]].map(|c| ConvexPolygon::new(c).expect("a triangle")));
        }
    }
}

fn city(columns: usize, rows: usize) -> Vec<ConvexPolygon> {
    let mut state = 12_345u64;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut out = Vec::new();
    for (i, j) in (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j))) {
        let (x, y) = (i as f64 * BLOCK_EDGE, j as f64 * BLOCK_EDGE);
        let (x0, y0) = (x + 6.0 + 4.0 * random(), y + 6.0 + 4.0 * random());
        let (x1, y1) = (x + 30.0 + 4.0 * random(), y + 30.0 + 4.0 * random());
        let height = 10.0 + 30.0 * random() * random();
        let (xs, ys) = ([x, x0, x1, x + BLOCK_EDGE], [y, y0, y1, y + BLOCK_EDGE]);
        for (u, v) in (0..3).flat_map(|u| (0..3).map(move |v| (u, v))).filter(|c| *c != (1, 1)) {
            let edges = [vec3(xs[u + 1] - xs[u], 0.0, 0.0), vec3(0.0, ys[v + 1] - ys[v], 0.0)];
            divide(&mut out, vec3(xs[u], ys[v], 0.0), edges, [1, 1]);
        }
        let (dx, dy, up) = (vec3(x1 - x0, 0.0, 0.0), vec3(0.0, y1 - y0, 0.0), vec3(0.0, 0.0, height));
        for (at, along) in [((x0, y0), dx), ((x1, y0), dy), ((x1, y1), -dx), ((x0, y1), -dy)] {
            divide(&mut out, vec3(at.0, at.1, 0.0), [along, up], [2, 4]);
        }
        divide(&mut out, vec3(x0, y0, height), [dx, dy], [2, 2]);
    }
    out
}
