//! The problem that walks solve.

use zonal_scene::Zones;

/// The problem that walks solve.
#[derive(Clone, Copy)]
pub enum ForwardProblem<'a> {
    /// Surfaces and medium without zones.
    Continuous,
    /// The equations of the zones.
    Zones(&'a Zones),
    /// Those of rays that go on from patches close by.
    ContinuedRays(&'a Zones),
}

impl<'a> ForwardProblem<'a> {
    /// The zones; `None` for the continuous problem.
    pub(super) fn zones(&self) -> Option<&'a Zones> {
        match *self {
            ForwardProblem::Continuous => None,
            ForwardProblem::Zones(z) | ForwardProblem::ContinuedRays(z) => Some(z),
        }
    }
}
