//! The medium along a camera ray.
//!
//! | module | contents |
//! |---|---|
//! | `ray_path` | a ray cut into segments of one voxel zone, integrals over a segment |
//! | `path_builder` | from a ray to its segments and panes |
//! | `interpolated_extinction` | extinction between cells that sample a smooth density |
//! | `radiosity_field` | interpolated indirect radiosity |
//! | `single_scattering` | direct light of one light sample scattered along a ray |
//! | `analytic_area_light` | the same for emitters of few facets, without noise beside them |
//! | `deep_shadow_map` | the same for suns with an extent |
//! | `many_lights` | emitters of many facets |

pub(crate) mod analytic_area_light;
pub(crate) mod deep_shadow_map;
pub(crate) mod interpolated_extinction;
pub(crate) mod many_lights;
pub(crate) mod path_builder;
pub(crate) mod radiosity_field;
pub(crate) mod ray_path;
pub(crate) mod single_scattering;
