//! Arithmetic, quadrature and random numbers of the references.

pub(crate) mod double_double;
pub(crate) mod estimate_heap;
pub(crate) mod tanh_sinh;
