//! Zones for ParaView.

pub(super) mod document;
mod group_radiosity;
pub(crate) mod vti;
pub(crate) mod vtu;
