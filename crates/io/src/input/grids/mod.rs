//! Files of voxel grids: OpenVDB (`vdb`) and the volumes of Mitsuba (`vol`).

pub(crate) mod vdb;
pub(crate) mod vol;
