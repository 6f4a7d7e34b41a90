//! Constants that the error bounds of the development share.

/// Roundings of a point of the surface or of B, in ε of the lengths that it is summed from: sine and cosine (2 each), four products, four sums,
/// a node (2), and two for second orders.
pub(super) const POINT_ROUNDINGS: f64 = 2.0 * 2.0 + 4.0 + 4.0 + 2.0 + 2.0; // bound
/// Factor that covers the rounding of the radii themselves.
pub(super) const RADIUS_SLACK: f64 = 1.0 + 1e-9;
