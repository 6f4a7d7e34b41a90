//! Commands of exchange factors and exchange areas.

pub mod exchange;
pub mod factors;
pub mod gas;
pub mod update;
pub mod view_factors;
