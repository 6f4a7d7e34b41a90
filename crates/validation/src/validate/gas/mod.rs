//! Cases with gases.

pub(crate) mod furnace;
pub(crate) mod gas_slabs;
pub(crate) mod gases;
