//! The view factors of a cube's walls in 1,200 triangles, rotated at random so that no lattice can be exploited: time per pair by method, share proved,
//! closure.
//!
//! ```text
//! cargo run --release -p zonal-exchange --example triangles
//! ```
//!
//! Each wall is a net of 10×10 quadrilaterals whose inner corners are moved at random, each cut into two (unequal) triangles.
//! Requested accuracy: radius ≤ max(1e-9 𝓕, 1e-12 A). One thread.

use std::collections::BTreeMap;
use std::time::Instant;
use zonal_exchange::polygon::FactorMatrix;
use zonal_exchange::{Method, polygon};
use zonal_math::{Grade, Vec3, vec3};
use zonal_scene::Plate;

/// Patches along an edge.
const N: usize = 10;
const RELATIVE_TOLERANCE: f64 = 1e-9;
const ABSOLUTE_TOLERANCE: f64 = 1e-12;

struct SplitMix64(u64);

impl SplitMix64 {
    /// Uniform in [0, 1) (splitmix64).
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A random orthonormal frame.
fn frame(rng: &mut SplitMix64) -> [Vec3; 3] {
    let mut v = || vec3(rng.roll() - 0.5, rng.roll() - 0.5, rng.roll() - 0.5);
    let x = v().normalized();
    let y = x.cross(v()).normalized();
    [x, y, x.cross(y)]
}

fn triangles(rng: &mut SplitMix64) -> Vec<Plate> {
    let axes = frame(rng);
    let shift = vec3(0.3, -0.2, 0.7);
    let mut out = Vec::new();
    for axis in 0..3 {
        for far in [false, true] {
            let (u, v, n) = (axes[(axis + 1) % 3], axes[(axis + 2) % 3], axes[axis]);
            let mut net = vec![Vec3::ZERO; (N + 1) * (N + 1)];
            for i in 0..=N {
                for j in 0..=N {
                    let mut moved = |k: usize| {
                        let jitter = 0.3 * (rng.roll() - 0.5);
                        if k == 0 || k == N { k as f64 } else { k as f64 + jitter }
                    };
                    let (s, t) = (moved(i) / N as f64, moved(j) / N as f64);
                    net[i * (N + 1) + j] = shift + u * s + v * t + n * (far as u8 as f64);
                }
            }
            for i in 0..N {
                for j in 0..N {
                    let at = |a: usize, b: usize| net[(i + a) * (N + 1) + j + b];
                    let parts = if (i + j) % 2 == 0 {
                        [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]]
                    } else {
                        [[at(0, 0), at(1, 0), at(0, 1)], [at(1, 0), at(1, 1), at(0, 1)]]
                    };
                    for [a, b, c] in parts {
                        out.push(if far { Plate::triangle(a, c, b) } else { Plate::triangle(a, b, c) });
                    }
                }
            }
        }
    }
    out
}

fn main() {
    let plates = triangles(&mut SplitMix64(7));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut best = f64::INFINITY;
    let mut made = None;
    for _ in 0..3 {
        let start = Instant::now();
        made = Some(pool.install(|| polygon::factor_matrix(&plates, RELATIVE_TOLERANCE, ABSOLUTE_TOLERANCE)));
        best = best.min(start.elapsed().as_secs_f64());
    }
    let m = made.unwrap();
    let all = plates.len() * (plates.len() - 1) / 2;
    let unseen = m.counts.get(&Method::NotVisible).copied().unwrap_or(0);
    let seen = all as u64 - unseen;
    println!("{} triangles, {all} pairs, {seen} of them facing; {:.3} s on one thread", plates.len(), best);
    println!(
        "per pair: {:.3} µs of all, {:.3} µs of those facing",
        best / all as f64 * 1e6,
        best / seen as f64 * 1e6
    );

    print_accuracy(&plates, &m);
    print_methods(&plates, &m);
}

/// Shares of pairs whose radius meets the request, and the worst closure of a row.
fn print_accuracy(plates: &[Plate], m: &FactorMatrix) {
    let (mut proved, mut met, mut total) = (0, 0, 0);
    for i in 0..plates.len() {
        for j in 0..i {
            let f = m.get(i, j);
            let wanted = (RELATIVE_TOLERANCE * f.value)
                .max(ABSOLUTE_TOLERANCE * plates[i].area().min(plates[j].area()));
            total += 1;
            met += (f.radius <= wanted) as usize;
            proved += (f.radius <= wanted && f.grade == Grade::Proved) as usize;
        }
    }
    println!(
        "radius within the request: {met} of {total}; proved within it: {:.4} %",
        100.0 * proved as f64 / total as f64
    );
    let worst =
        (0..plates.len()).map(|i| (m.row_sum(i).value / plates[i].area() - 1.0).abs()).fold(0.0, f64::max);
    println!("worst closure: {worst:.2e} of the area");
}

/// Pairs and time per pair by method.
fn print_methods(plates: &[Plate], m: &FactorMatrix) {
    let mut by_method: BTreeMap<Method, Vec<(usize, usize)>> = BTreeMap::new();
    for i in 0..plates.len() {
        for j in 0..i {
            by_method.entry(m.method(i, j)).or_default().push((i, j));
        }
    }
    let ready = polygon::PreparedPlates::new(plates);
    println!("{:10} {:>9} {:>10}", "method", "pairs", "µs a pair");
    for (method, pairs) in by_method {
        let start = Instant::now();
        let (mut sum, mut evaluations) = (0.0, 0);
        pairs.iter().for_each(|(i, j)| {
            let f = ready.pair(*i, *j, RELATIVE_TOLERANCE, ABSOLUTE_TOLERANCE);
            sum += f.bounded.value;
            evaluations += f.evaluations;
        });
        let time = start.elapsed().as_secs_f64() / pairs.len() as f64;
        println!(
            "{:10} {:>9} {:>10.3}   {:>8.1} (sum {sum:.6})",
            method.name(),
            pairs.len(),
            time * 1e6,
            evaluations as f64 / pairs.len() as f64
        );
    }
}
