//! Shared basis of all modules: errors and notes, ranges of quantities, names of variants, observers and checkpoints of long computations.

pub mod checkpoint_store;
pub(crate) mod diagnostic;
pub mod limits;
pub(crate) mod named_enum;
pub(crate) mod printable;
pub(crate) mod progress;
pub(crate) mod scene_error;
