//! Exchange areas of all pairs, direct and total, as matrices.

pub mod exchange_areas;
pub mod total_exchange_areas;
