//! Engines and basis of a solve: those that a second solve takes over.

use crate::context::zonal_solution::ZonalSolution;
use zonal_scene::{Engine, ZoneBasis};

/// Engines and basis of a solve.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SolveMethod {
    /// With or without slopes.
    pub basis: ZoneBasis,
    /// The engine of each block of bands.
    pub engines: Vec<Engine>,
}

/// The basis of a solve with or without slopes.
pub(crate) fn basis_of(has_slopes: bool) -> ZoneBasis {
    if has_slopes { ZoneBasis::Linear } else { ZoneBasis::Constant }
}

impl SolveMethod {
    /// That of a finished solve.
    pub(crate) fn of(blocks: &[ZonalSolution]) -> SolveMethod {
        let engine = |b: &ZonalSolution| {
            Engine::VARIANTS.into_iter().find(|e| e.name() == b.report.engine).unwrap_or_default()
        };
        SolveMethod { basis: basis_of(blocks[0].has_slopes), engines: blocks.iter().map(engine).collect() }
    }
}
