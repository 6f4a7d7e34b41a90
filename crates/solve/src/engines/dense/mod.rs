//! The dense engine: exchange areas of all pairs of zones, each computed once.

mod assembly;
pub mod band_groups;
pub(crate) mod dense_operator;
pub(crate) mod image_sums;
pub(crate) mod packed_symmetric;
pub(crate) mod pair_radii;
pub(crate) mod row_blocks;

pub(crate) use dense_operator::DenseOperator;
