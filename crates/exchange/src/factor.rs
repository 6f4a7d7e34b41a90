//! The interface of all methods: an accuracy request in; a factor with radius, grade, method and cost out.

use zonal_math::Bounded;

/// How a factor was computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Method {
    /// The zones are not visible from each other: exactly zero.
    NotVisible,
    /// Formula (3) of the paper: the kernel at the centres.
    Point,
    /// Moments of the zones about their centres, with a proven remainder.
    Moments,
    /// A formula in closed form for two aligned rectangles.
    ClosedForm,
    /// The reduced integral by tensor Gauss–Legendre rules.
    Gauss,
    /// The reduced integral in pyramid coordinates where the boxes touch.
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
    /// The contour integral of two polygons in closed form.
    Contour,
    /// Gauss–Legendre rules over zones in any position.
    Oblique,
}

impl Method {
    /// The name in tables and reports.
    pub fn name(self) -> &'static str {
        match self {
            Method::NotVisible => "unseen",
            Method::Point => "point",
            Method::Moments => "moments",
            Method::ClosedForm => "closed",
            Method::Gauss => "gauss",
            Method::Pyramid => "pyramid",
            Method::SixGauss => "gauss-6d",
            Method::HemiCube => "hemicube",
            Method::Proposition1 => "prop1",
            Method::Series => "series",
            Method::Chebyshev => "chebyshev",
            Method::Contour => "contour",
            Method::Oblique => "oblique",
        }
    }
}

/// The accuracy that a caller requests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccuracyRequest {
    /// Requested radius, relative to the value.
    pub tolerance: f64,
    /// Evaluations of the integrand after which a method stops and reports the radius reached.
    pub max_evaluations: u64,
}

impl AccuracyRequest {
    /// A relative tolerance without a limit of evaluations.
    ///
    /// ```
    /// use zonal_exchange::AccuracyRequest;
    /// assert_eq!(AccuracyRequest::relative(1e-6).radius(-2.0), 2e-6);
    /// ```
    ///
    /// # Panics
    /// On a tolerance that is not positive.
    pub fn relative(tolerance: f64) -> AccuracyRequest {
        assert!(tolerance > 0.0, "tolerance {tolerance}");
        AccuracyRequest { tolerance, max_evaluations: u64::MAX }
    }

    /// The requested radius for a value: max(tolerance·|value|, 1e-300).
    pub fn radius(&self, value: f64) -> f64 {
        (self.tolerance * value.abs()).max(1e-300)
    }
}

/// A geometric factor with its method and cost.
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
    /// The factor of zones that are not visible from each other.
    pub const NOT_VISIBLE: Factor =
        Factor { bounded: Bounded::ZERO, evaluations: 0, method: Method::NotVisible };
}
