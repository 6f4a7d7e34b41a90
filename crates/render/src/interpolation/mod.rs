//! Interpolation between nodes, whose values are computed when they are needed.

pub(crate) mod lazy_values;
pub(crate) mod node_interpolation;
