//! The product of the voxels of a process: planes to frequencies, the product there, and back.
//!
//! Planes x and frequencies f₁ are divided among processes ([`crate::device::slabs`]). A product transforms the own planes along z and y
//! (`voxel_transforms.rs`), brings them to the own blocks of frequencies f₁ of all planes (`transposition.rs`), multiplies these
//! (`frequency_product.rs`), and goes back the same way. The walls receive sums over frequencies (`wall_sums.rs`).
//!
//! **Cost.** The spectra between the steps are 16 n₀ N₁ (N₂/2 + 1) B for each component, 32 n³ B for n³ cells, and are written and read twice. They are
//! the memory of a product.

use super::frequency_product::{BlockLines, FrequencyBlock, FrequencyProduct, WallSpectra};
use super::line_exchange::ZERO;
use super::transposition::Transposition;
use super::wall_sums::{BoxWall, WallSumLayout, WallSums};
use crate::device::GridPart;
use crate::device::slabs::{FREQUENCIES_PER_BLOCK, Slabs};
use crate::device::spectra::GridSpectra;
use crate::distribution::ExchangeBuffers;
use rayon::prelude::*;
use std::sync::Mutex;
use zonal_fourier::Complex64;
use zonal_math::simd;

/// The product of the voxels with voxels and walls.
pub(super) struct VolumeConvolution<'a> {
    slabs: Slabs<'a>,
    sums: WallSumLayout<'a>,
    product: FrequencyProduct,
    /// Buffers, reused by every product.
    buffers: Mutex<ProductBuffers>,
}

/// Buffers of a product.
#[derive(Default)]
struct ProductBuffers {
    /// The spectrum of the voxels: `[own block][component][x][f₂][f₁ of the block]`.
    spectrum: Vec<Complex64>,
    /// Spectra of some planes on their way to other ranks or back; empty in one process.
    messages: ExchangeBuffers,
    /// The sums of each block of frequencies.
    sums: Vec<WallSums>,
}

impl<'a> VolumeConvolution<'a> {
    /// For the part of a process.
    pub(super) fn new(part: GridPart<'a>) -> VolumeConvolution<'a> {
        VolumeConvolution {
            slabs: part.slabs,
            sums: WallSumLayout { part },
            product: FrequencyProduct::new(part.grid, part.order),
            buffers: Mutex::default(),
        }
    }

    /// Replaces the strengths of the voxels of this rank, `values` by component and cell, by their incident power, with that from wall spectra `walls`.
    /// Returns the spectra of the incident power of the walls that this rank completes ([`WallSumLayout::complete`]).
    pub(super) fn apply(
        &self,
        kernels: &GridSpectra,
        values: &mut [f64],
        walls: &[Option<WallSpectra>; 3],
    ) -> Vec<(BoxWall, Vec<Complex64>)> {
        let FrequencyProduct { grid, order, transforms, .. } = &self.product;
        let ([_, n1, n2], parts) = (grid.cells, order.voxel_components());
        let (blocks, planes): (Vec<usize>, _) = (self.slabs.blocks().collect(), self.slabs.planes());
        let size = self.product.component_size();
        let mut buffers = std::mem::take(&mut *self.buffers.lock().unwrap_or_else(|e| e.into_inner()));
        let ProductBuffers { spectrum, messages, sums } = &mut buffers;
        spectrum.resize(blocks.len() * parts * size, ZERO);
        sums.extend((sums.len()..blocks.len()).map(|i| self.sums.zeros(blocks[i])));
        let transposition = Transposition { slabs: self.slabs, piece: self.product.piece_size(), parts };
        // A rank without planes has values of no component.
        let count = (planes.len() * n1 * n2).max(1);
        for p in 0..parts {
            let own = values.chunks(count).nth(p).unwrap_or_default();
            transposition.bring_to_frequencies(p, messages, spectrum, |planes, slots| {
                transforms.transform_planes(&own[planes.start * n1 * n2..planes.end * n1 * n2], slots);
            });
        }
        let chunks = spectrum.par_chunks_mut(parts * size).zip(&mut *sums).enumerate().with_max_len(1);
        chunks.for_each_init(
            || BlockLines::new(&self.product),
            |lines, (i, (block, found))| {
                let first = blocks[i] * FREQUENCIES_PER_BLOCK;
                let product = &self.product;
                simd::run(FrequencyBlock { product, kernels, walls, first, lines, block, found });
            },
        );
        for p in 0..parts {
            let own = values.chunks_mut(count).nth(p).unwrap_or_default();
            transposition.bring_to_planes(p, messages, spectrum, |planes, blocks| {
                let out = &mut own[planes.start * n1 * n2..planes.end * n1 * n2];
                transforms.inverse_transform_planes(blocks, out);
            });
        }
        let walls = self.sums.complete(sums);
        *self.buffers.lock().unwrap_or_else(|e| e.into_inner()) = buffers;
        walls
    }

    /// Frees the buffers; the next product allocates them again.
    pub(super) fn free_buffers(&self) {
        *self.buffers.lock().unwrap_or_else(|e| e.into_inner()) = ProductBuffers::default();
    }
}
