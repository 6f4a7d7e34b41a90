//! Cases of lighting and daylight.

pub(crate) mod daylight;
pub(crate) mod lighting;
