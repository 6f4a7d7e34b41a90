//! The unit roundoff of double precision.

/// ε = 2⁻⁵³, the largest relative error of one operation in round-to-nearest.
pub(crate) const UNIT_ROUNDOFF: f64 = 0.5 * f64::EPSILON;
