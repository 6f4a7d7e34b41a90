//! Direct light on the zones: unreflected light of the sun, the sky and small emitters.
//!
//! | module | content |
//! |---|---|
//! | `light_field` | direct light of one light on all zones, with errors and powers |
//! | [`illumination`] | direct light by shadow rays, reconciled with the power of the light |
//! | `light_power` | power that a light sends into the scene and loses, by rays from the light |
//! | `shadow_rays` | shadow-ray estimate on all zones, with adaptive sample counts |
//! | `emitter_exchange` | direct light of emitters from exchange areas |
//! | `direct_error` | propagation of errors of direct light to reflected light |

pub(crate) mod direct_error;
pub(crate) mod emitter_exchange;
pub mod illumination;
pub(crate) mod light_field;
pub(crate) mod light_power;
pub(crate) mod shadow_rays;

pub use light_field::{DirectLight, LightField};
