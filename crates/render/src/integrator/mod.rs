//! Radiance along a camera ray.
//!
//! | module | contents |
//! |---|---|
//! | `radiance` | the rendering equation along a ray: end point, medium, panes |
//! | `direct_light` | direct light on surfaces and scattered along the ray |
//! | `final_gather` | indirect irradiance of a surface point by rays |
//! | `medium_segment` | the medium before the first pane or surface |
//! | `ray_sampler` | light samples of a ray |

pub(crate) mod direct_light;
pub(crate) mod final_gather;
pub(crate) mod medium_segment;
pub(crate) mod radiance;
pub(crate) mod ray_sampler;
