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

/// The processor.
#[derive(Clone, Copy, Debug)]
pub struct Processor;

impl Device for Processor {
    fn convolution<'a>(&self, part: GridPart<'a>) -> Box<dyn GridConvolution + 'a> {
        Box::new(ProcessorConvolution {
            volume: VolumeConvolution::new(part),
            walls: WallConvolution::new(part),
            spectra: Vec::new(),
        })
    }
}

/// The products of a grid on the processor.
struct ProcessorConvolution<'a> {
    volume: VolumeConvolution<'a>,
    walls: WallConvolution<'a>,
    /// The spectra of each extinction.
    spectra: Vec<GridSpectra>,
}

impl GridConvolution for ProcessorConvolution<'_> {
    fn load(&mut self, spectra: GridSpectra) {
        self.spectra.push(spectra);
    }

    fn exchange(&self, extinction: usize, voxels: &mut [f64], walls: &WallValues) -> WallValues {
        let kernels = &self.spectra[extinction];
        let sent = self.walls.spectra(walls);
        let from_voxels = self.volume.apply(kernels, voxels, &sent);
        self.walls.incident(kernels, walls, &sent, from_voxels)
    }

    fn free_buffers(&self) {
        self.volume.free_buffers();
    }
}
