//! Shadow rays: visibility between a point and a light sample.
//!
//! The renderer traces shadow rays to suns and clusters here; the light sampler of `zonal-transport` traces those of its own samples
//! (`gather`, `gather_at`, `lit`). Lit intervals along a whole ray need none: see [`super::lit_intervals`].

use zonal_math::Vec3;
use zonal_transport::Transport;

/// Traces a shadow ray; true where no facet lies between the two points. Panes and medium do not count.
pub(crate) fn trace_shadow_ray(transport: &Transport, point: Vec3, light: Vec3) -> bool {
    !transport.occluded(point, light)
}
