//! One sample of a light.

use zonal_math::Vec3;
use zonal_scene::{Bands, IntensityDistribution};

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
pub enum EmissionSample<'a> {
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
        /// Index of the facet that holds the point, which casts no shadow of it; `None` without one.
        facet: Option<usize>,
        /// A E/π, W/sr.
        power: Bands,
    },
    /// A point light: at distance r in the unit direction ω from it the fluence is `intensity` · f(ω)/r².
    Intensity {
        /// Position, m.
        position: Vec3,
        /// Unit intensity, W/sr.
        intensity: Bands,
        /// Relative intensity f.
        distribution: &'a IntensityDistribution,
    },
}

impl EmissionSample<'_> {
    /// Position, m, and radiant intensity, W/sr, towards a point; `None` of a sample at infinity.
    ///
    /// ```
    /// use zonal_math::vec3;
    /// use zonal_scene::{Bands, IntensityDistribution};
    /// use zonal_transport::lights::EmissionSample;
    /// let (position, distribution) = (vec3(0.0, 0.0, 2.0), &IntensityDistribution::isotropic());
    /// let lamp = EmissionSample::Intensity { position, intensity: Bands::ONE, distribution };
    /// assert_eq!(lamp.intensity_towards(vec3(1.0, 0.0, 0.0)), Some((position, Bands::ONE)));
    /// ```
    #[must_use]
    pub fn intensity_towards(&self, point: Vec3) -> Option<(Vec3, Bands)> {
        match *self {
            EmissionSample::Distant { .. } => None,
            EmissionSample::Point { position, normal, two_sided, power, .. } => {
                let cos = normal.dot((point - position).normalized());
                let emitted = if two_sided { cos.abs() } else { cos.max(0.0) };
                Some((position, power * emitted))
            }
            EmissionSample::Intensity { position, intensity, distribution } => {
                Some((position, intensity * distribution.relative((point - position).normalized())))
            }
        }
    }
}
