//! Direct light on the zones: unreflected light of the sun, the sky and small emitters.
//!
//! | module | content |
//! |---|---|
//! | `light_field` | direct light of one light on all zones, with errors and powers |
//! | [`illumination`] | direct light by shadow rays, reconciled with the power of the light |
//! | `light_power` | power that a light sends into the scene and loses, by rays from the light |
//! | `shadow_rays` | shadow-ray estimate on all zones, with adaptive sample counts |

pub mod illumination;
pub(crate) mod light_field;
pub(crate) mod light_power;
pub(crate) mod shadow_rays;

pub use light_field::{DirectLight, LightField};
