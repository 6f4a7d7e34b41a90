//! The processor as the device of the spectral engine (the mathematics: [`crate::device`]).
//!
//! | module | content |
//! |---|---|
//! | `voxel_transforms` | transforms of the voxels: planes along z and y, lines along x |
//! | `frequency_product`, `line_exchange` | the product in frequency space, by blocks and by lines |
//! | `volume`, `transposition` | planes of voxels and blocks of frequencies of each process, and the exchange of one for the other |
//! | `wall_sums` | radiation of the voxels on the walls, summed over the blocks |
//! | `walls` | walls with walls |
//!
//! Transforms use the best instructions of the processor (crate rustfft); sums have a fixed order, so that the bits depend neither on the number of
//! threads nor of processes.

mod frequency_product;
mod line_exchange;
pub(super) mod transposition;
mod volume;
mod voxel_transforms;
pub(super) mod wall_sums;
mod walls;

use crate::device::spectra::GridSpectra;
use crate::device::{Device, GridConvolution, GridPart, WallValues};
use volume::VolumeConvolution;
use walls::WallConvolution;
use zonal_math::parallel;

/// The processor.
#[derive(Clone, Copy, Debug)]
pub struct Processor;

impl Device for Processor {
    fn convolution<'a>(&self, part: GridPart<'a>) -> Box<dyn GridConvolution + 'a> {
        Box::new(ProcessorConvolution {
            volume: VolumeConvolution::new(part),
            walls: WallConvolution::new(part),
            spectra: Vec::new(),
            ranks: part.slabs.ranks(),
        })
    }
}

/// Values of voxels from which the transforms of the walls are a task.
const MIN_VALUES_TOGETHER: usize = 1 << 10;

/// The products of a grid on the processor.
struct ProcessorConvolution<'a> {
    volume: VolumeConvolution<'a>,
    walls: WallConvolution<'a>,
    /// The spectra of each extinction.
    spectra: Vec<GridSpectra>,
    /// Number of processes.
    ranks: usize,
}

/// Two computations, at the same time or the first before the second.
fn run_both<A: Send, B: Send>(
    together: bool,
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    if together { parallel::join(a, b) } else { (a(), b()) }
}

impl GridConvolution for ProcessorConvolution<'_> {
    fn load(&mut self, spectra: GridSpectra) {
        self.spectra.push(spectra);
    }

    fn exchange(&self, extinction: usize, voxels: &mut [f64], walls: &WallValues) -> WallValues {
        let (kernels, mut buffers) = (&self.spectra[extinction], self.volume.buffers());
        // Walls have few transforms: in one process they run beside those of the voxels. Several exchange messages in one order.
        let together = self.ranks == 1 && voxels.len() >= MIN_VALUES_TOGETHER;
        let transform_walls = || self.walls.spectra(walls);
        let strengths = &*voxels;
        let transform_voxels = || self.volume.transform(&mut buffers, strengths);
        let (sent, ()) = run_both(together, transform_walls, transform_voxels);
        let from_voxels = self.volume.multiply(&mut buffers, kernels, &sent);
        let of_voxels = || self.volume.transform_back(&mut buffers, voxels);
        let of_walls = || self.walls.incident(kernels, walls, &sent, from_voxels);
        let ((), met) = run_both(together, of_voxels, of_walls);
        self.volume.give(buffers);
        met
    }

    fn free_buffers(&self) {
        self.volume.free_buffers();
    }
}
