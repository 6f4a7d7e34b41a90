//! Tables of a regular grid: each distinct offset once, with a proved radius.
//!
//! The factor of two cells depends on their offset alone, up to the symmetries of the cell: 48 of a cube, where offsets are sorted and
//! n(n+1)(n+2)/6 of n³ are kept (260,130 for 115³); 16 where two edges agree; 8 otherwise. Of a voxel and a patch of the
//! grid's walls (patches are faces of cells), and of two such patches, the offsets across the plane of the walls fold in
//! the same way: n²(n+1)/2 entries (766,935 + … for 115³).
//!
//! `offset_family.rs` fills a [`FactorTable`], in batches of eight offsets by the moments' series or by Gauss rules of the density, near ones by
//! `method_selection.rs`, pair by pair; [`voxel_block()`] the factors of one voxel with a block of voxels.
//!
//! Tables for radiosity that is linear inside a cell are in `linear_basis.rs`.
//!
//! In a periodic grid an entry is the sum over the images of its offset (`periodic.rs`, `gaussian_sums.rs`).
//!
//! Work is divided into fixed chunks of whole batches, so that no value depends on the number of threads, nor on the number of processes that share
//! the chunks ([`ChunkEvaluator`]).

mod chunk_evaluator;
mod gaussian_sums;
mod grid_tables;
mod linear_basis;
mod offset_family;
mod offset_index;
mod pair_layout;
mod periodic;
mod table;
mod voxel_block;

pub use chunk_evaluator::ChunkEvaluator;
pub(crate) use chunk_evaluator::OneProcess;
pub use grid_tables::GridTables;
pub use offset_family::MethodCounts;
pub use pair_layout::{AxisRelation, LinearBasisPairs, PeriodicGrid, TableAccuracy};
pub use table::{FactorTable, TurnedTable};
pub use voxel_block::{VoxelBlock, voxel_block};

#[cfg(test)]
mod tests;
