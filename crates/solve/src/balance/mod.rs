//! Balance of a row and of the power: closure of the rows, and the energy balance of a solution.

pub(crate) mod closure;
pub(crate) mod energy_balance;
pub(crate) mod least_squares_closure;
