//! Visibility of lights.
//!
//! | module | contents |
//! |---|---|
//! | `shadow_ray` | visibility between two points |
//! | `lit_intervals` | exact lit intervals of a ray |
//! | `sun_depth_cache` | optical depths towards a distant light |

/// Angular diameter, rad, from which on one direction does not stand for a whole sun.
pub(crate) const WIDE_SUN_DIAMETER: f64 = 0.1;

pub(crate) mod lit_intervals;
pub(crate) mod shadow_ray;
pub(crate) mod sun_depth_cache;
