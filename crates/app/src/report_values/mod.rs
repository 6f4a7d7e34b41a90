//! Numbers of a report as text and as rows, for tables and pages.

mod numbers;
mod rows;

pub use numbers::{large_number, number, thousands, two_digits, value_with_error, value_with_errors};
pub use rows::{PowerRow, distinct_diagnostics, heat_balance, heat_cells, light_group_powers, power_rows};
