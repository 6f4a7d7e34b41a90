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
use crate::engines::spectral::buffer_pool::BufferPool;
use rayon::prelude::*;
use zonal_fourier::Complex64;
use zonal_math::{parallel, simd};

/// The product of the voxels with voxels and walls.
pub(super) struct VolumeConvolution<'a> {
    slabs: Slabs<'a>,
    sums: WallSumLayout<'a>,
    product: FrequencyProduct,
    /// Buffers, reused by every product.
    buffers: BufferPool<ProductBuffers>,
}

/// Buffers of a product.
#[derive(Default)]
pub(super) struct ProductBuffers {
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
            buffers: BufferPool::default(),
        }
    }

    /// Buffers of a product.
    pub(super) fn buffers(&self) -> ProductBuffers {
        let mut buffers = self.buffers.take();
        let blocks: Vec<usize> = self.slabs.blocks().collect();
        let parts = self.product.order.voxel_components();
        let length = blocks.len() * parts * self.product.component_size();
        if length > buffers.spectrum.capacity() {
            // Free the old memory first; all threads write the new one first.
            buffers.spectrum = Vec::new();
            buffers.spectrum = parallel::collect(length, |_| ZERO);
        }
        buffers.spectrum.resize(length, ZERO);
        let sums = &mut buffers.sums;
        sums.extend((sums.len()..blocks.len()).map(|i| self.sums.zeros(blocks[i])));
        buffers
    }

    /// Gives the buffers of a product back.
    pub(super) fn give(&self, buffers: ProductBuffers) {
        self.buffers.give(buffers);
    }

    fn transposition(&self) -> Transposition<'a> {
        let (piece, parts) = (self.product.piece_size(), self.product.order.voxel_components());
        Transposition { slabs: self.slabs, piece, parts }
    }

    /// Voxels of a plane, and voxels of this rank.
    fn voxels(&self) -> [usize; 2] {
        let [_, n1, n2] = self.product.grid.cells;
        // A rank without planes has values of no component.
        [n1 * n2, (self.slabs.planes().len() * n1 * n2).max(1)]
    }

    /// Transforms the strengths of the voxels of this rank, `values` by component and cell, along z and y.
    pub(super) fn transform(&self, buffers: &mut ProductBuffers, values: &[f64]) {
        let (transposition, [plane, count]) = (self.transposition(), self.voxels());
        let ProductBuffers { spectrum, messages, .. } = buffers;
        for p in 0..transposition.parts {
            let own = values.chunks(count).nth(p).unwrap_or_default();
            transposition.bring_to_frequencies(p, messages, spectrum, |planes, slots| {
                let cells = &own[planes.start * plane..planes.end * plane];
                self.product.transforms.transform_planes(cells, slots);
            });
        }
    }

    /// Multiplies the spectra by those of the kernels, with the radiation of wall spectra `walls`. Returns the spectra of the incident power of the walls that
    /// this rank completes ([`WallSumLayout::complete`]).
    pub(super) fn multiply(
        &self,
        buffers: &mut ProductBuffers,
        kernels: &GridSpectra,
        walls: &[Option<WallSpectra>; 3],
    ) -> Vec<(BoxWall, Vec<Complex64>)> {
        let ProductBuffers { spectrum, sums, .. } = buffers;
        let blocks: Vec<usize> = self.slabs.blocks().collect();
        let parts = self.product.order.voxel_components();
        let size = parts * self.product.component_size();
        let chunks = spectrum
            .par_chunks_mut(size)
            .zip(&mut *sums)
            .enumerate()
            .with_max_len(1)
            .with_min_len(parallel::least_items(parts * size));
        chunks.for_each_init(
            || BlockLines::new(&self.product),
            |lines, (i, (block, found))| {
                let first = blocks[i] * FREQUENCIES_PER_BLOCK;
                let product = &self.product;
                simd::run(FrequencyBlock { product, kernels, walls, first, lines, block, found });
            },
        );
        self.sums.complete(sums)
    }

    /// Transforms the spectra back along y and z: the incident power of the voxels.
    pub(super) fn transform_back(&self, buffers: &mut ProductBuffers, values: &mut [f64]) {
        let (transposition, [plane, count]) = (self.transposition(), self.voxels());
        let ProductBuffers { spectrum, messages, .. } = buffers;
        for p in 0..transposition.parts {
            let own = values.chunks_mut(count).nth(p).unwrap_or_default();
            transposition.bring_to_planes(p, messages, spectrum, |planes, blocks| {
                let out = &mut own[planes.start * plane..planes.end * plane];
                self.product.transforms.inverse_transform_planes(blocks, out);
            });
        }
    }

    /// Frees the buffers; the next product allocates them again.
    pub(super) fn free_buffers(&self) {
        self.buffers.clear();
    }
}
