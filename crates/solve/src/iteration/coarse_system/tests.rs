use super::*;
use crate::distribution::part_of;
use crate::distribution::thread_ranks::on_ranks;
use crate::iteration::test_operators::two_walls;
use std::ops::Range;

/// Blocks of 2 × 3 × 1 voxels, and two patches of which one has a wider block.
fn blocks(planes: Range<usize>) -> ZoneBlocks {
    ZoneBlocks {
        patches: vec![1, 0],
        patch_sizes: vec![1.0, 6.0],
        cells: [6, 6, 2],
        lengths: [2, 3, 1],
        planes,
    }
}

fn weight(i: usize) -> Bands {
    Bands::from_rgb([0.3 + (i % 7) as f64, if i.is_multiple_of(5) { 0.0 } else { 1.0 }, 2.0])
}

fn system<'a>(
    planes: Range<usize>,
    first: usize,
    communicator: Option<&'a dyn Communicator>,
) -> CoarseSystem<'a> {
    let global = |i: usize| if i < 2 { i } else { i + first };
    let n = 2 + planes.len() * 12;
    let weights: Vec<Bands> = (0..n).map(|i| weight(global(i))).collect();
    let targets: Vec<f64> = (0..n).map(|i| 1.0 + global(i) as f64).collect();
    let (g, sums) = (two_walls(), SumOrder::plain());
    let system = LinearSystem { operator: &g, weights: weights.into(), targets: &targets, sums };
    CoarseSystem::new(blocks(planes), Box::new(two_walls()), &system, communicator)
}

#[test]
fn columns_of_phi_are_orthonormal() {
    let s = system(0..6, 0, None);
    let root = |i: usize| weight(i).sqrt().to_rgb();
    let value = |c: usize, b: usize| 1.0 + (c * 7 % 5) as f64 - b as f64;
    let c: Vec<[f64; 3]> = (0..s.blocks.count()).map(|c| std::array::from_fn(|b| value(c, b))).collect();
    let mut p = vec![[0.0; 3]; 74];
    s.prolong(c.clone(), &mut p, |i, p, c| *p = std::array::from_fn(|b| p[b] + root(i)[b] * c[b]));
    let back: Vec<[f64; 3]> = s.restrict(|i| std::array::from_fn(|b| root(i)[b] * p[i][b]));
    for (k, (c, back)) in c.iter().zip(&back).enumerate() {
        for b in 0..3 {
            let want = if s.weights[k].to_rgb()[b] > 0.0 { c[b] } else { 0.0 };
            assert!((back[b] - want).abs() < 1e-14, "{k} {b}: {} {want}", back[b]);
        }
    }
}

#[test]
fn blocks_have_the_sums_of_their_zones() {
    let s = system(0..6, 0, None);
    let sum = |zones: &[usize]| zones.iter().fold(Bands::ZERO, |s, &i| s + weight(i));
    assert_eq!((s.blocks.count(), s.targets[0], s.targets[1]), (2 + 12, 2.0, 1.0));
    assert_eq!((s.weights[0], s.weights[1]), (weight(1), weight(0) / 36.0), "a block of six with one patch");
    // The block of voxels (2..4, 3..6, 1).
    let zones: Vec<usize> = (2..4).flat_map(|x| (3..6).map(move |y| 2 + x * 12 + y * 2 + 1)).collect();
    let at = 2 + 4 + 2 + 1;
    let apart = (s.weights[at] - sum(&zones) / 36.0).abs().max_element();
    assert!(apart < 1e-15, "{apart}");
    assert_eq!(s.targets[at], zones.iter().map(|i| 1.0 + *i as f64).sum::<f64>());
}

// Guards (determinism): sums over blocks do not depend on the division among processes.
#[test]
fn blocks_do_not_depend_on_the_division() {
    let want = system(0..6, 0, None);
    for size in [2, 4, 5] {
        on_ranks(size, |c| {
            let planes = part_of(6, c.rank(), size);
            let first = planes.start * 12;
            let s = system(planes.clone(), first, Some(c));
            assert_eq!((&s.weights, &s.targets, &s.norms), (&want.weights, &want.targets, &want.norms));
            let value = |i: usize| [1.0 / (i as f64 + 0.3)];
            let global = |i: usize| if i < 2 { i } else { i + first };
            assert_eq!(s.restrict(|i| value(global(i))), want.restrict(value));
            let all: Vec<[f64; 1]> = (0..s.blocks.count()).map(|c| [c as f64]).collect();
            let prolonged = |s: &CoarseSystem, n: usize| {
                let mut p = vec![0.0; n];
                s.prolong(all.clone(), &mut p, |_, p, [c]| *p = c);
                p
            };
            let (own, whole) = (prolonged(&s, 2 + planes.len() * 12), prolonged(&want, 74));
            own.iter().enumerate().for_each(|(i, x)| assert_eq!(*x, whole[global(i)]));
        });
    }
}
