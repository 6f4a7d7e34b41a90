//! Times of the aligned methods and tables on one core: `cargo run --release -p zonal-exchange --example aligned_times`.

use std::time::Instant;
use zonal_exchange::aligned::lattice::{GridTables, VoxelBlock, voxel_block};
use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_math::{Vec3, vec3};

/// Processor time of this thread where available (Linux), otherwise wall-clock time, s.
fn now() -> f64 {
    thread_local!(static START: Instant = Instant::now());
    let clock = START.with(|s| s.elapsed().as_secs_f64());
    let spent = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let spent = spent.and_then(|s| s.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()));
    spent.map_or(clock, |ns| 1e-9 * ns)
}

/// The best of `n` runs, in seconds: processor time for long runs, the clock for those below a millisecond.
fn best<T>(n: usize, mut work: impl FnMut() -> T) -> (f64, T) {
    let mut shortest = f64::INFINITY;
    let mut last = None;
    for _ in 0..n {
        let (start, spent) = (Instant::now(), now());
        let begun = start.elapsed().as_secs_f64();
        let out = work();
        let clock = start.elapsed().as_secs_f64() - begun;
        let time = if clock > 1e-2 { now() - spent } else { clock };
        shortest = shortest.min(time);
        last = Some(out);
    }
    (shortest, last.expect("at least one run"))
}

fn tables() {
    // On the calling thread.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().expect("a pool");
    pool.install(all_tables)
}

fn all_tables() {
    let (edge, counts) = ([1.0; 3], [115; 3]);
    for kappa in [0.0, 0.1] {
        let (t, table) = best(3, || GridTables::new(edge, counts, kappa, 1e-10).voxels());
        println!(
            "voxel-voxel  115^3 1e-10 kappa {kappa}: {t:.4} s, {} entries, {:?}",
            table.len(),
            table.method_counts()
        );
        let (t, table) = best(3, || GridTables::new(edge, counts, kappa, 1e-10).wall(2));
        println!(
            "voxel-wall   115^3 1e-10 kappa {kappa}: {t:.4} s, {} entries, {:?}",
            table.len(),
            table.method_counts()
        );
        let (t, table) = best(3, || GridTables::new(edge, counts, kappa, 1e-10).adjacent([0, 1]));
        println!(
            "adjacent     115^3 1e-10 kappa {kappa}: {t:.4} s, {} entries, {:?}",
            table.len(),
            table.method_counts()
        );
        let (t, table) = best(3, || GridTables::new(edge, counts, kappa, 1e-10).opposite(2));
        println!(
            "opposite     115^3 1e-10 kappa {kappa}: {t:.4} s, {} entries, {:?}",
            table.len(),
            table.method_counts()
        );
    }
    let (t, table) = best(3, || GridTables::new([1.0, 0.5, 0.25], [60, 60, 60], 0.0, 1e-10).voxels());
    println!(
        "boxes 4:2:1   60^3 1e-10 kappa 0: {t:.4} s, {} entries, {:?}",
        table.len(),
        table.method_counts()
    );
}

fn blocks() {
    for counts in [[1, 1, 1], [20, 1, 1], [20, 20, 1]] {
        let (t, b): (f64, VoxelBlock) =
            best(500, || voxel_block([1.0; 3], [3.0, 0.0, 0.0], counts, 0.0, 1e-6));
        println!("block of {counts:?}: {:.1} us, {} distinct", t * 1e6, b.distinct);
    }
    for tolerance in [1e-3, 1e-6, 1e-9] {
        for first in
            [[3.0, -9.5, -9.5], [3.0, -10.0, -10.0], [3.0, 0.0, 0.0], [4.0, -9.5, -9.5], [1.0, -9.5, -9.5]]
        {
            let (t, b) = best(200, || voxel_block([1.0; 3], first, [20; 3], 0.0, tolerance));
            println!(
                "block {first:?} {tolerance:e}: {:.1} us, {} distinct, {:?}",
                t * 1e6,
                b.distinct,
                b.method_counts
            );
        }
    }
}

/// The patches of a unit cube's walls, n × n each.
fn cube_patches(n: usize) -> Vec<Cuboid> {
    let mut out = vec![];
    let at = |i: usize| i as f64 / n as f64;
    for wall in Cuboid::voxel(Vec3::ZERO, Vec3::ONE).walls() {
        let (axis, _) = wall.normal.expect("a wall");
        for i in 0..n {
            for j in 0..n {
                let (mut lo, mut hi) = (wall.lo.array(), wall.hi.array());
                let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
                (lo[a], hi[a], lo[b], hi[b]) = (at(i), at(i + 1), at(j), at(j + 1));
                out.push(Cuboid { lo: Vec3::from_array(lo), hi: Vec3::from_array(hi), ..wall });
            }
        }
    }
    out
}

fn patches() {
    let all = cube_patches(10);
    // One patch of each distinct pair: offsets of the lattice, sorted.
    let mut seen = std::collections::HashSet::new();
    let mut pairs = vec![];
    for a in &all {
        for b in &all {
            let key = |c: f64| (c * 20.0).round().abs() as i64;
            let (p, q) = (0.5 * (a.lo + a.hi), 0.5 * (b.lo + b.hi));
            let (na, nb) = (a.normal.expect("a patch").0, b.normal.expect("a patch").0);
            if na == nb && p[na] == q[na] {
                continue;
            }
            let d = (q - p).array().map(key);
            let mut k = if na == nb {
                [0, d[(na + 1) % 3], d[(na + 2) % 3], 0]
            } else {
                [1, d[na], d[nb], d[3 - na - nb]]
            };
            k[1..3].sort();
            if seen.insert(k) {
                pairs.push((*a, *b));
            }
        }
    }
    let (t, counts) = best(20, || {
        let mut counts = std::collections::BTreeMap::new();
        for (a, b) in &pairs {
            let f = geometric_factor(a, b, 0.0, 1e-9);
            assert!(f.bounded.radius <= 1e-9 * f.bounded.value);
            *counts.entry(f.method).or_insert(0) += 1;
        }
        counts
    });
    println!("{} rectangle pairs of a cube 10x10 a wall, 1e-9: {:.3} ms, {counts:?}", pairs.len(), t * 1e3);
}

fn random_rows() {
    let mut state = 7u64;
    let mut u = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut rows = vec![];
    while rows.len() < 10_000 {
        let a = Cuboid::voxel(Vec3::ZERO, vec3(0.3 + u(), 0.3 + u(), 0.3 + u()));
        let e = vec3(0.3 + u(), 0.3 + u(), 0.3 + u());
        let shift = match (u() * 3.0) as usize {
            0 => vec3(a.hi.x, u(), u()),
            1 => vec3(1.5 + u(), 2.0 * u(), 2.0 * u()),
            _ => vec3(3.0 + 30.0 * u(), 20.0 * u(), 20.0 * u()),
        };
        let b = Cuboid::voxel(shift, shift + e);
        let kappa = if u() < 0.3 { 0.0 } else { 5.0 * u() };
        let pick = |c: &Cuboid, w: f64, k: f64| if w < 0.5 { *c } else { c.walls()[(k * 6.0) as usize] };
        let (x, y) = (pick(&a, u(), u()), pick(&b, u(), u()));
        if geometric_factor(&x, &y, kappa, 1e-2).evaluations > 0 {
            rows.push((x, y, kappa));
        }
    }
    let mut by: std::collections::BTreeMap<_, (usize, f64)> = Default::default();
    let start = now();
    for (x, y, kappa) in &rows {
        let one = Instant::now();
        let f = geometric_factor(x, y, *kappa, 1e-8);
        let e = by.entry((f.method, *kappa > 0.0)).or_default();
        (e.0, e.1) = (e.0 + 1, e.1 + one.elapsed().as_secs_f64());
    }
    println!("10,000 random rows at 1e-8: {:.3} s, (count, s) {by:?}", now() - start);
}

fn main() {
    let which = std::env::args().nth(1).unwrap_or_default();
    let run = |name: &str, work: &dyn Fn()| {
        if which.is_empty() || which == name {
            work()
        }
    };
    run("tables", &tables);
    run("blocks", &blocks);
    run("patches", &patches);
    run("rows", &random_rows);
}
