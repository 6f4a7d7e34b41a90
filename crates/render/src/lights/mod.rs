//! Visibility of lights.
//!
//! | module | contents |
//! |---|---|
//! | `shadow_ray` | visibility between two points |
//! | `lit_intervals` | exact lit intervals of a ray |
//! | `sun_depth_cache` | optical depths towards a distant light |

pub(crate) mod lit_intervals;
pub(crate) mod shadow_ray;
pub(crate) mod sun_depth_cache;
