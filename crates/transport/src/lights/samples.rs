//! One sample of a light.

use zonal_math::Vec3;
use zonal_scene::Bands;

/// One sample of a light as seen from a point, without attenuation between light and point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Unit vector towards the light.
    pub direction: Vec3,
    /// The far end of the shadow ray, m.
    pub end: Vec3,
    /// Contribution of the sample to H or G without attenuation, W/m².
    pub flux: Bands,
}

/// One sample of a light independent of the receiving point, for light along a whole ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EmissionSample {
    /// At infinity: the same fluence everywhere, W/m².
    Distant {
        /// Unit vector towards the light.
        direction: Vec3,
        /// Fluence without attenuation, W/m².
        fluence: Bands,
    },
    /// A point of an emitter: at distance r and angle θ from its normal the fluence is `power` · cosθ/r².
    Point {
        /// Position, m.
        position: Vec3,
        /// Unit normal of its front.
        normal: Vec3,
        /// True when the back emits as well.
        two_sided: bool,
        /// Index of the facet that holds the point.
        facet: usize,
        /// A E/π, W/sr.
        power: Bands,
    },
}
