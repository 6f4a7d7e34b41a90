//! Iterative solution of the zonal equations for several right-hand sides.
//!
//! | module | content |
//! |---|---|
//! | [`linear_system`] | the equations, the stopping criterion, the result of a column |
//! | [`conjugate_gradients`] | symmetric operators |
//! | [`coarse_system`] | the equations on blocks of zones, which correct conjugate gradients |
//! | [`bicgstab`] | operators that are not symmetric |
//! | [`neumann_series`] | a fixed number of scattering orders |
//! | `divided_state` | states of an iteration in a checkpoint |

pub(crate) mod bicgstab;
pub(crate) mod coarse_system;
pub(crate) mod conjugate_gradients;
mod divided_state;
pub(crate) mod linear_system;
pub(crate) mod neumann_series;

pub(crate) use linear_system::{IterationResult, LinearSystem, StoppingCriterion};

#[cfg(test)]
mod test_operators;
