//! Pictures: tone mapping and colour maps, PNG and OpenEXR.

pub(crate) mod colour_map;
pub(crate) mod exr;
pub(crate) mod png;
mod size;
pub(crate) mod texture;
pub(crate) mod tone;
