//! A box with cells of longer edges, whose equations correct the iteration ([`crate::iteration::coarse_system`]).

use super::enclosure::{BoxEnclosure, OPENING};
use super::spectral_operator::{SpectralOperator, VectorLayout};
use crate::device::Device;
use crate::device::basis::BasisOrder;
use crate::device::grid::{BoxGrid, OTHER_AXES};
use crate::distribution::sum_order::SumOrder;
use crate::distribution::{Communicator, Execution};
use crate::iteration::coarse_system::{CoarseSystem, ZoneBlocks};
use std::ops::Range;
use zonal_scene::{Bands, NoProgress};

/// Fewest voxels of a box whose iteration is worth the tables of a second grid.
const MIN_VOXELS: usize = 1 << 17;
/// Fewest voxels of a block.
const MIN_VOXELS_PER_BLOCK: usize = 8;
/// Voxels of a block along an axis, the best first: the first divisor of the number of cells counts.
const BLOCK_LENGTHS: [usize; 7] = [4, 5, 6, 3, 7, 8, 2];

/// The zones of a box enclosure to be divided into blocks.
pub(super) struct BoxInBlocks<'a> {
    pub(super) enclosure: &'a BoxEnclosure,
    /// The planes across x whose voxels vectors have.
    pub(super) planes: Range<usize>,
    /// Number of patches.
    pub(super) patches: usize,
    /// The processes, where each has some planes alone.
    pub(super) communicator: Option<&'a dyn Communicator>,
}

impl<'a> BoxInBlocks<'a> {
    /// The equations on blocks; `None` for a box of few voxels, or whose numbers of cells have no small divisors.
    pub(super) fn coarse_system(
        self,
        device: &'a dyn Device,
        weights: &[Bands],
        targets: &[f64],
    ) -> Option<CoarseSystem<'a>> {
        let (communicator, lengths) = (self.communicator, block_lengths(&self.enclosure.grid)?);
        let (operator, blocks) = self.in_blocks(device, lengths);
        Some(CoarseSystem::new(Box::new(operator), blocks, (weights, targets), communicator))
    }

    /// The blocks of given lengths, and their exchange.
    fn in_blocks(self, device: &'a dyn Device, lengths: [usize; 3]) -> (SpectralOperator<'a>, ZoneBlocks) {
        let fine = &self.enclosure.grid;
        let grid = grid_of_blocks(fine, lengths);
        // Number the patches of the blocks wall by wall.
        let (mut patches, mut patch_sizes) = (vec![0; self.patches], Vec::new());
        let faces = [0, 1, 2].map(|axis| {
            [0, 1].map(|side| {
                let [b, c] = OTHER_AXES[axis];
                let first = patch_sizes.len();
                let count = if grid.periodic[axis] { 0 } else { grid.patches(axis) };
                patch_sizes.resize(first + count, (lengths[b] * lengths[c]) as f64);
                for (at, &zone) in self.enclosure.faces[axis][side].iter().enumerate() {
                    if zone != OPENING {
                        let [i, j] = [at / fine.cells[c] / lengths[b], at % fine.cells[c] / lengths[c]];
                        patches[zone as usize] = (first + i * grid.cells[c] + j) as u32;
                    }
                }
                (first..first + count).map(|i| i as u32).collect::<Vec<u32>>()
            })
        });
        let layout = VectorLayout {
            patches: patch_sizes.len(),
            voxels: grid.count(),
            is_divided: false,
            sums: SumOrder::plain(),
        };
        let enclosure = BoxEnclosure { grid, kappa: self.enclosure.kappa, faces, outside: Vec::new() };
        let execution = Execution::alone(&NoProgress);
        let operator =
            SpectralOperator::with_layout(enclosure, layout, BasisOrder::Constant, device, execution);
        let blocks = ZoneBlocks { patches, patch_sizes, cells: fine.cells, lengths, planes: self.planes };
        (operator, blocks)
    }
}

/// True if the iteration uses blocks of the voxels of a grid.
pub(crate) fn has_blocks(grid: &BoxGrid) -> bool {
    block_lengths(grid).is_some()
}

/// Bytes of the equations on blocks, for a number of distinct extinctions; 0 without blocks.
pub(super) fn bytes(fine: &BoxGrid, extinctions: usize) -> u64 {
    let Some(lengths) = block_lengths(fine) else { return 0 };
    let grid = grid_of_blocks(fine, lengths);
    let (of_plane, patches) =
        (grid.cells[1] * grid.cells[2], grid.walled().map(|a| 2 * grid.patches(a)).sum::<usize>());
    // Weights, norms and targets; vectors and roots of the iteration in all bands, and the sums of each plane of voxels on their way between processes.
    let [blocks, sums] = [grid.count() + patches, 3 * fine.cells[0] * of_plane].map(|n| n as u64);
    SpectralOperator::bytes(&grid, extinctions, BasisOrder::Constant, 1) + (56 + 6 * 24) * blocks + 24 * sums
}

/// The grid of blocks.
fn grid_of_blocks(fine: &BoxGrid, lengths: [usize; 3]) -> BoxGrid {
    let cells = [0, 1, 2].map(|k| fine.cells[k] / lengths[k]);
    let edges = [0, 1, 2].map(|k| fine.edges[k] * lengths[k] as f64);
    BoxGrid::new(cells, edges, fine.periodic)
}

/// Voxels of a block along each axis.
fn block_lengths(grid: &BoxGrid) -> Option<[usize; 3]> {
    let length = |n: usize| BLOCK_LENGTHS.into_iter().find(|l| n.is_multiple_of(*l)).unwrap_or(1);
    let lengths = grid.cells.map(length);
    let block: usize = lengths.iter().product();
    (grid.count() >= MIN_VOXELS && block >= MIN_VOXELS_PER_BLOCK).then_some(lengths)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engines::spectral::cpu::Processor;
    use crate::iteration::{LinearSystem, StoppingCriterion, conjugate_gradients};
    use crate::operator::ExchangeOperator;
    use zonal_scene::{Band, NoCheckpoints, SolveStatus};

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
        let layout = VectorLayout {
            patches,
            voxels: enclosure.grid.count(),
            is_divided: false,
            sums: SumOrder::plain(),
        };
        let execution = Execution::alone(&NoProgress);
        SpectralOperator::with_layout(enclosure.clone(), layout, BasisOrder::Constant, &Processor, execution)
    }

    fn divided(enclosure: &BoxEnclosure, patches: usize) -> BoxInBlocks<'_> {
        BoxInBlocks { enclosure, planes: 0..enclosure.grid.cells[0], patches, communicator: None }
    }

    #[test]
    fn exchange_of_blocks_is_the_sum_over_their_zones() {
        for is_periodic in [false, true] {
            let (fine, patches) = enclosure([6, 4, 6], is_periodic);
            let own = operator(&fine, patches);
            let (coarse, blocks) = divided(&fine, patches).in_blocks(&Processor, [3, 2, 2]);
            assert_eq!(coarse.len(), blocks.count());
            // Strengths of one zone's block; the patches beside the opening send nothing.
            let n = blocks.count();
            let is_whole = |c: usize| {
                c >= blocks.patch_sizes.len()
                    || blocks.patches.iter().filter(|b| **b as usize == c).count() as f64
                        == blocks.patch_sizes[c]
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
            let coarse =
                divided(&fine, patches).coarse_system(&Processor, &weights, &targets).expect("large enough");
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
            let iterations =
                |r: &[crate::iteration::IterationResult]| r[0].residuals[Band::first()].len() - 1;
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
}
