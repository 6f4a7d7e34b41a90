//! The final state of an iterative solve.

use crate::base::named_enum::named_enum;
/// Why the iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolveStatus {
    /// The residual fell below its tolerance.
    Converged,
    /// The residual stopped falling above its tolerance.
    Stalled,
    /// The maximum number of iterations was reached.
    MaxIterations,
    /// The requested number of scattering orders was computed; higher orders are missing.
    FixedOrder,
}

// From best to worst.
named_enum!(SolveStatus: Converged "converged", FixedOrder "fixed_order", MaxIterations "max_iterations", Stalled "stalled");
