//! Cases that other programs, measurements or Monte Carlo methods have computed.

pub(crate) mod burns;
pub(crate) mod discretization;
pub(crate) mod elmer;
pub(crate) mod macbeth;
pub mod montecarlo;
pub(crate) mod openfoam;
pub(crate) mod thick;
