//! The exchange of blocks of zones, and the iteration that they correct.

use super::*;
use crate::device::grid::BoxGrid;
use crate::engines::spectral::cpu::Processor;
use crate::iteration::coarse_system::CoarseSystem;
use crate::iteration::{IterationResult, LinearSystem, StoppingCriterion, conjugate_gradients};
use zonal_scene::{NoCheckpoints, SolveStatus};

/// A box, periodic along x or closed, with an opening.
fn enclosure(cells: [usize; 3], is_periodic: bool) -> (BoxEnclosure, usize) {
    let grid = BoxGrid::new(
        cells,
        [0.11, 0.17, 0.13].map(|e| 4.0 * e / cells[0] as f64),
        [is_periodic, false, false],
    );
    let mut next = 0;
    let faces = [0, 1, 2].map(|axis| {
        [0, 1].map(|side| {
            let size = if grid.periodic[axis] { 0 } else { grid.patches(axis) };
            let zone = |at: usize| {
                if axis == 1 && side == 1 && at == 3 {
                    return OPENING;
                }
                next += 1;
                next - 1
            };
            (0..size).map(zone).collect::<Vec<u32>>()
        })
    });
    (BoxEnclosure { grid, kappa: Bands::splat(1.3), faces, outside: Vec::new() }, next as usize)
}

fn operator(enclosure: &BoxEnclosure, patches: usize) -> SpectralOperator<'static> {
    let layout = VectorLayout { patches, voxels: enclosure.grid.count(), sums: SumOrder::plain() };
    let execution = Execution::alone(&NoProgress);
    let part = GridPart::new(enclosure.grid, BasisOrder::Constant, execution.communicator);
    SpectralOperator::with_layout(enclosure.clone(), layout, part, &Processor, execution)
}

#[test]
fn exchange_of_blocks_is_the_sum_over_their_zones() {
    for is_periodic in [false, true] {
        let (fine, patches) = enclosure([6, 4, 6], is_periodic);
        let own = operator(&fine, patches);
        let (box_of_blocks, blocks) = box_in_blocks::divide_by(&fine, 0..6, patches, [3, 2, 2]);
        let coarse = operator(&box_of_blocks, blocks.patch_sizes.len());
        assert_eq!(coarse.len(), blocks.count());
        // Strengths of one zone's block; the patches beside the opening send nothing.
        let n = blocks.count();
        let is_whole = |c: usize| {
            c >= blocks.patch_sizes.len()
                || blocks.patches.iter().filter(|b| **b as usize == c).count() as f64 == blocks.patch_sizes[c]
        };
        let of_block: Vec<f64> =
            (0..n).map(|c| if is_whole(c) { 1.0 + (c * 7 % 11) as f64 } else { 0.0 }).collect();
        let block_of = |i: usize| match i.checked_sub(patches) {
            None => blocks.patches[i] as usize,
            Some(v) => {
                let [x, y, z] = [v / 24 / 3, v / 6 % 4 / 2, v % 6 / 2];
                blocks.patch_sizes.len() + (x * 2 + y) * 3 + z
            }
        };
        let spread: Vec<[f64; 1]> = (0..own.len()).map(|i| [of_block[block_of(i)]]).collect();
        let mut sums = vec![0.0; n];
        own.apply_band(&spread).iter().enumerate().for_each(|(i, p)| sums[block_of(i)] += p[0]);
        let power = coarse.apply_band(&of_block.iter().map(|s| [*s]).collect::<Vec<_>>());
        for c in (0..n).filter(|c| is_whole(*c)) {
            assert!((power[c][0] / sums[c] - 1.0).abs() < 1e-7, "{c}: {} {}", power[c][0], sums[c]);
        }
    }
}

#[test]
fn coarse_equations_shorten_the_iteration_to_the_same_solution() {
    for (is_periodic, is_grey) in [(false, true), (true, false)] {
        let (fine, patches) = enclosure([64, 64, 32], is_periodic);
        let own = operator(&fine, patches);
        let n = own.len();
        // Albedo and reflectance vary, and some zones are black.
        let colours = if is_grey { Bands::ONE } else { Bands::from_rgb([1.0, 0.5, 0.0]) };
        let [dx, dy, dz] = fine.grid.edges;
        let measure = |i: usize| if i < patches { dx * dy } else { 4.0 * dx * dy * dz };
        let scattered = |i: usize| {
            if i < patches { 0.4 * (i % 3) as f64 } else { 1.3 * (0.99 - 0.3 * (i % 7) as f64 / 7.0) }
        };
        let weights: Vec<Bands> = (0..n).map(|i| colours * (scattered(i) / measure(i))).collect();
        let targets: Vec<f64> = (0..n).map(measure).collect();
        let sources: Vec<Bands> = (0..n).map(|i| if i < 300 { colours } else { Bands::ZERO }).collect();
        let system = LinearSystem {
            operator: &own,
            weights: (&weights).into(),
            targets: &targets,
            sums: SumOrder::plain(),
        };
        let (blocks, operator) = own.in_blocks().expect("large enough");
        let coarse = CoarseSystem::new(blocks, operator, &system, None);
        let stop = StoppingCriterion { residual: 1e-9, max_iterations: 100 };
        let solve = |coarse| {
            let sources = vec![sources.clone()];
            conjugate_gradients::solve(
                system.clone(),
                coarse,
                sources,
                None,
                stop,
                &NoCheckpoints,
                &NoProgress,
            )
        };
        let ((plain, _), (corrected, products)) = (solve(None), solve(Some(&coarse)));
        let iterations = |r: &[IterationResult]| r[0].residuals[Band::first()].len() - 1;
        assert!(corrected[0].status[Band::first()] == SolveStatus::Converged);
        assert!(4 * iterations(&corrected) <= 3 * iterations(&plain));
        let most = plain[0].strengths.iter().fold(0.0f64, |m, s| m.max(s.max_element()));
        for (a, b) in plain[0].strengths.iter().zip(&corrected[0].strengths) {
            assert!((*a - *b).abs().max_element() < 1e-7 * most);
        }
        let again = own.apply(&corrected[0].strengths);
        let most = again.iter().fold(0.0f64, |m, p| m.max(p.max_element()));
        for (a, b) in again.iter().zip(&products[0]) {
            assert!((*a - *b).abs().max_element() < 1e-12 * most);
        }
    }
}
