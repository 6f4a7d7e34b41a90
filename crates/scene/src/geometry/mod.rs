//! Plates, and meshes of plates: coincident corners, open shells, solids and enclosures.

pub(crate) mod plate;
pub mod shells;
pub(crate) mod t_junctions;
pub(crate) mod weld;
