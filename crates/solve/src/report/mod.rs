//! Content of the report: closure of the rows, energy balance, diagnostics, summary, and cost estimates before a solve.

pub(crate) mod back_faces;
pub(crate) mod closure;
pub mod cost_estimate;
pub(crate) mod diagnostics;
pub(crate) mod energy_balance;
pub(crate) mod least_squares_closure;
pub(crate) mod summary;
