//! The parts of a scene, the medium excepted.
//!
//! | module | contents |
//! |---|---|
//! | `surface` | surfaces, facets, textures and panes |
//! | `face_table`, `shading` | faces of mesh files with values by face; normals for pictures |
//! | `light` | lights and surroundings |
//! | `intensity_distribution` | radiant intensity of point lights over directions: spots, photometric tables |
//! | `sky_distribution`, `sun_position` | radiance of skies over directions; the sun by place and time |
//! | `camera`, `options` | cameras; settings of a solve |

pub(crate) mod camera;
pub(crate) mod face_table;
pub(crate) mod intensity_distribution;
pub(crate) mod light;
pub(crate) mod options;
pub(crate) mod shading;
pub(crate) mod sky_distribution;
pub(crate) mod sun_position;
pub(crate) mod surface;
