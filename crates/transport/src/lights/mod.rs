//! Direct light: samples of suns, skies, point lights and emitting surfaces.
//!
//! | module | content |
//! |---|---|
//! | `receiver` | the point that receives light |
//! | `samples` | one sample of a light |
//! | `direct` | [`LightSampler`]: irradiance H and fluence G of one light at a point |
//! | `emitter` | points of an emitting surface, by area and by solid angle |
//! | `visible_polygon` | uniform samples of the solid angle of a facet |
//! | `zone_views` | plates and boxes as seen from a point light |
//! | `light_tree` | hierarchy over the facets of a large emitter |

mod direct;
mod emitter;
mod light_tree;
mod receiver;
mod samples;
mod visible_polygon;
mod zone_views;

pub use direct::LightSampler;
pub use light_tree::LightBall;
pub use receiver::Receiver;
pub use samples::{EmissionSample, LightSample};
pub use zone_views::{BoxChord, BoxView, PlateView};
