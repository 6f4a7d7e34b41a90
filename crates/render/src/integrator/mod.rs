//! Radiance along a camera ray.
//!
//! | module | contents |
//! |---|---|
//! | `radiance` | the rendering equation along a ray: end point, medium, panes |
//! | `direct_light` | direct light on surfaces and scattered along the ray |
//! | `contact_field` | corrections of the interpolated irradiance where surfaces are near |
//! | `final_gather` | indirect irradiance of a surface point by rays |
//! | `medium_segment` | the medium before the first pane or surface |
//! | `node_lattice` | nodes on patches, as dense as a camera resolves them |
//! | `ray_sampler` | light samples of a ray |
//! | `sky_field` | irradiance of skies without grain |

pub(crate) mod contact_field;
pub(crate) mod direct_light;
pub(crate) mod final_gather;
pub(crate) mod medium_segment;
pub(crate) mod node_lattice;
pub(crate) mod radiance;
pub(crate) mod ray_sampler;
pub(crate) mod sky_field;
