use super::super::chunk_evaluator::OneProcess;
use super::super::grid_tables::GridTables;
use super::super::pair_layout::PeriodicGrid;
use super::*;
use AxisRelation::{Extended, OffWall, OppositeWalls};

const NO_PERIOD: [Option<usize>; 3] = [None; 3];

fn tables(
    edges: [f64; 3],
    counts: [usize; 3],
    along: [AxisRelation; 3],
    kappa: f64,
    terms: &[[usize; 3]],
) -> Vec<Vec<f64>> {
    tables_to(TableAccuracy::Full, edges, counts, along, kappa, terms)
}

fn tables_to(
    accuracy: TableAccuracy,
    edges: [f64; 3],
    counts: [usize; 3],
    along: [AxisRelation; 3],
    kappa: f64,
    terms: &[[usize; 3]],
) -> Vec<Vec<f64>> {
    let images = PeriodicGrid::new(NO_PERIOD, edges, kappa);
    LinearBasisPairs { edges, counts, along, kappa, images: &images, accuracy }.tables(terms, &OneProcess)
}

/// The largest difference to full accuracy, over the factor of the constants, is about 1e-8.
#[test]
fn tables_of_comparisons_have_their_accuracy() {
    let terms = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 1], [0, 0, 2]];
    let mut worst = 0.0f64;
    for (edges, kappa) in
        [([0.3, 0.3, 0.3], 0.0), ([0.5, 0.2, 0.9], 1.7), ([0.4, 0.4, 0.5], 0.5), ([0.5, 0.5, 0.7], 6.0)]
    {
        for along in [
            [Extended; 3],
            [Extended, OffWall, Extended],
            [OffWall, Extended, OffWall],
            [Extended, Extended, OppositeWalls],
        ] {
            let counts = [6, 5, 7];
            let [full, other] = [TableAccuracy::Full, TableAccuracy::Comparison]
                .map(|accuracy| tables_to(accuracy, edges, counts, along, kappa, &terms));
            for t in 0..terms.len() {
                for ((a, b), scale) in full[t].iter().zip(&other[t]).zip(&full[0]) {
                    let off = (a - b).abs() / scale;
                    worst = worst.max(off);
                }
            }
        }
    }
    assert!(worst > 1e-11 && worst < 3e-8, "{worst:e}");
}

#[test]
fn constant_terms_equal_proved_tables() {
    for (edges, kappa) in [([0.3, 0.3, 0.3], 0.0), ([0.5, 0.2, 0.9], 1.7), ([1.0, 1.0, 0.07], 6.0)] {
        let counts = [5, 4, 6];
        let place = |n: [usize; 3], d: [usize; 3]| (d[0] * n[1] + d[1]) * n[2] + d[2];
        let every = |n: [usize; 3]| {
            (0..n[0]).flat_map(move |i| (0..n[1]).flat_map(move |j| (0..n[2]).map(move |k| [i, j, k])))
        };
        let check = |along: [AxisRelation; 3], want: &dyn Fn([i64; 3]) -> f64| {
            let mut n = counts;
            (0..3).filter(|&k| along[k] == OppositeWalls).for_each(|k| n[k] = 1);
            let got = &tables(edges, counts, along, kappa, &[[0, 0, 0]])[0];
            for d in every(n) {
                let (got, want) = (got[place(n, d)], want(d.map(|d| d as i64)));
                assert!((got / want - 1.0).abs() < 2e-11, "{edges:?} {along:?} {d:?}: {got} {want}");
            }
        };
        let v = GridTables::new(edges, counts, kappa, 1e-12).voxels();
        check([Extended; 3], &|d| v.get(d).value);
        let s = GridTables::new(edges, counts, kappa, 1e-12).wall(1);
        check([Extended, OffWall, Extended], &|d| s.get(d).value);
        let o = GridTables::new(edges, counts, kappa, 1e-12).opposite(2);
        check([Extended, Extended, OppositeWalls], &|d| o.get(d).value);
        let q = GridTables::new(edges, counts, kappa, 1e-12).adjacent([0, 2]);
        check([OffWall, Extended, OffWall], &|d| q.get(d).value);
    }
}

/// A linear function on a cell is seen from its halves: their means, and their own slopes of half the size.
#[test]
fn linear_tables_are_additive_over_halved_cells() {
    let (edges, kappa) = ([0.6, 0.4, 0.5], 2.0);
    let half = [0.3, 0.4, 0.5];
    let terms = [[0, 0, 0], [1, 0, 0], [2, 0, 0]];
    let whole = tables(edges, [3, 2, 2], [Extended; 3], kappa, &terms);
    let parts = tables(half, [7, 2, 2], [Extended; 3], kappa, &terms);
    // On half h ∈ {−1, +1} of a cell φ is h √3/2 + φ_half/2, and half of the cell's own integral is there.
    let of_part = |term: usize, d: i64, jk: usize| {
        let sign = if term == 1 && d < 0 { -1.0 } else { 1.0 };
        sign * parts[term][d.unsigned_abs() as usize * 4 + jk]
    };
    let slope = |h: i64| h as f64 * 0.75f64.sqrt();
    for d in 0..3i64 {
        for jk in 0..4 {
            let mut sums = [0.0; 3];
            for a in [-1i64, 1] {
                for b in [-1i64, 1] {
                    let at = 2 * d + (b - a) / 2;
                    let [f00, f01, f11] = [0, 1, 2].map(|t| of_part(t, at, jk));
                    sums[0] += f00;
                    sums[1] += slope(b) * f00 + 0.5 * f01;
                    // Of the first the slope has the other sign: 𝓕_10(d) = −𝓕_01(d).
                    sums[2] +=
                        slope(a) * slope(b) * f00 + 0.5 * slope(a) * f01 - 0.5 * slope(b) * f01 + 0.25 * f11;
                }
            }
            for term in 0..3 {
                let got = whole[term][d as usize * 4 + jk];
                let scale = whole[0][d as usize * 4 + jk];
                assert!((got - sums[term]).abs() < 1e-11 * scale, "{d} {jk} {term}: {got} {sums:?}");
            }
        }
    }
}

#[test]
fn linear_terms_agree_with_midpoint_quadrature() {
    // Against midpoints of the six-fold integral, far enough for them.
    let (edges, kappa, m) = ([0.5, 0.4, 0.3], 0.8, 6);
    let terms = [[0, 1, 0], [1, 1, 0], [1, 0, 1], [0, 0, 2], [0, 2, 0]];
    let got = tables(edges, [4, 3, 5], [Extended; 3], kappa, &terms);
    let d = [3usize, 2, 4];
    let places = |k: usize| (0..m).map(move |i| ((i as f64 + 0.5) / m as f64 - 0.5, edges[k]));
    for (term, got) in terms.iter().zip(got) {
        let mut sum = 0.0;
        let each = |k: usize| -> Vec<(f64, f64)> {
            let mut out = vec![];
            for (a, e) in places(k) {
                for (b, _) in places(k) {
                    // Terms of an odd axis: the first odd axis belongs to the second cell, another to the first.
                    let first_odd = (0..3).find(|&k| term[k] == 1);
                    let root = 12f64.sqrt();
                    let by = match term[k] {
                        0 => 1.0,
                        1 if first_odd == Some(k) => root * b,
                        1 => -root * a,
                        _ => 12.0 * a * b,
                    };
                    out.push(((d[k] as f64 + b - a) * e, by));
                }
            }
            out
        };
        let [x, y, z] = [0, 1, 2].map(each);
        for (tx, wx) in &x {
            for (ty, wy) in &y {
                for (tz, wz) in &z {
                    let r2 = tx * tx + ty * ty + tz * tz;
                    sum += wx * wy * wz * (-kappa * r2.sqrt()).exp() / r2;
                }
            }
        }
        let volume: f64 = edges.iter().product();
        let want = sum * (volume / (m * m * m) as f64).powi(2) / std::f64::consts::PI;
        let got = got[(d[0] * 3 + d[1]) * 5 + d[2]];
        assert!((got / want - 1.0).abs() < 0.08, "{term:?}: {got} {want}");
    }
}

#[test]
fn periodic_linear_tables_equal_sums_over_longer_grid() {
    let (edges, kappa) = ([0.5, 0.4, 0.3], 9.0);
    let images = PeriodicGrid::new([Some(4), Some(3), None], edges, kappa);
    let terms = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [2, 0, 0], [0, 1, 1]];
    let counts = [3, 2, 5];
    let got = LinearBasisPairs {
        edges,
        counts,
        along: [Extended; 3],
        kappa,
        images: &images,
        accuracy: TableAccuracy::Full,
    }
    .tables(&terms, &OneProcess);
    let plain = tables(edges, [14, 15, 5], [Extended; 3], kappa, &terms);
    for (t, term) in terms.iter().enumerate() {
        for (i, got) in got[t].iter().enumerate() {
            let d = [i / 10, i / 5 % 2, i % 5].map(|d| d as i64);
            let (mut sum, mut scale) = (0.0, 0.0);
            for m in -3i64..=3 {
                for k in -4i64..=4 {
                    let at = [d[0] + 4 * m, d[1] + 3 * k];
                    if at[0].abs() < 14 && at[1].abs() < 15 {
                        let place = (at[0].unsigned_abs() * 15 + at[1].unsigned_abs()) as usize * 5;
                        let sign = |k: usize| if term[k] == 1 && at[k] < 0 { -1.0 } else { 1.0 };
                        sum += sign(0) * sign(1) * plain[t][place + d[2] as usize];
                        scale += plain[0][place + d[2] as usize];
                    }
                }
            }
            assert!((got - sum).abs() < 1e-11 * scale, "{term:?} {d:?}: {got} {sum}");
        }
    }
}
