//! The final state of an iterative solve.

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

impl SolveStatus {
    /// The name in reports.
    pub fn name(self) -> &'static str {
        match self {
            SolveStatus::Converged => "converged",
            SolveStatus::Stalled => "stalled",
            SolveStatus::MaxIterations => "max_iterations",
            SolveStatus::FixedOrder => "fixed_order",
        }
    }
    /// All statuses, from best to worst.
    pub const VARIANTS: [SolveStatus; 4] =
        [SolveStatus::Converged, SolveStatus::FixedOrder, SolveStatus::MaxIterations, SolveStatus::Stalled];
}
