//! What every method takes and gives: a demand in, a factor with its radius, grade, method and cost out.

use zonal_math::Bounded;

/// How a factor was computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Method {
    /// The zones cannot see each other: exactly zero.
    Unseen,
    /// Formula (3) of the paper: the kernel at the centres.
    Point,
    /// Moments of the zones about their centres, with a proven remainder.
    Moments,
    /// A formula in closed form for two aligned rectangles.
    Closed,
    /// The reduced integral by tensor Gauss–Legendre rules.
    Gauss,
    /// The same where the boxes touch: pyramid coordinates.
    Pyramid,
    /// Tensor Gauss–Legendre rules over both zones: six dimensions for two voxels.
    SixGauss,
    /// Rushmeier and Torrance's hemi-cube.
    HemiCube,
    /// Proposition 1: the transmittance at the centres times the geometric factor, corrected.
    Proposition1,
    /// Proposition 2: a Gegenbauer series about a reference zone.
    Series,
    /// Chebyshev interpolation along a strip or in a block.
    Chebyshev,
    /// The development of section 3.1 about a reference patch of a smooth surface.
    Proximity,
    /// The contour integral of two polygons in closed form.
    Contour,
    /// Gauss–Legendre rules over zones in any position.
    Oblique,
    /// The contour integral over what clipping leaves visible.
    Clipped,
}

impl Method {
    /// The word that tables and reports use.
    pub fn word(self) -> &'static str {
        match self {
            Method::Unseen => "unseen",
            Method::Point => "point",
            Method::Moments => "moments",
            Method::Closed => "closed",
            Method::Gauss => "gauss",
            Method::Pyramid => "pyramid",
            Method::SixGauss => "gauss-6d",
            Method::HemiCube => "hemicube",
            Method::Proposition1 => "prop1",
            Method::Series => "series",
            Method::Chebyshev => "chebyshev",
            Method::Proximity => "proximity",
            Method::Contour => "contour",
            Method::Oblique => "oblique",
            Method::Clipped => "clipped",
        }
    }
}

/// What is asked of a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand {
    /// Wanted radius, relative to the value.
    pub tolerance: f64,
    /// Evaluations of the integrand after which the method stops, with the radius that it then has.
    pub budget: u64,
}

impl Demand {
    /// A relative tolerance, whatever it costs.
    ///
    /// # Panics
    /// On a tolerance that is not positive.
    pub fn relative(tolerance: f64) -> Demand {
        assert!(tolerance > 0.0, "tolerance {tolerance}");
        Demand { tolerance, budget: u64::MAX }
    }

    /// The wanted radius for a value: max(tolerance·|value|, 1e-300).
    pub fn radius(&self, value: f64) -> f64 {
        (self.tolerance * value.abs()).max(1e-300)
    }
}

/// A geometric factor and what it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factor {
    /// Value and radius: m⁴ for two voxels, m³ for a voxel and a patch, m² for two patches.
    pub bounded: Bounded,
    /// Evaluations of the integrand.
    pub evaluations: u64,
    /// How it was computed.
    pub method: Method,
}

impl Factor {
    /// The factor of zones that cannot see each other.
    pub const UNSEEN: Factor = Factor { bounded: Bounded::ZERO, evaluations: 0, method: Method::Unseen };
}
