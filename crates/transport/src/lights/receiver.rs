//! The point at which direct light is received.

use zonal_math::Vec3;

/// A point that receives light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Receiver {
    /// A surface with this unit normal: contributions are irradiances.
    Surface(Vec3),
    /// A point in free space: contributions are fluences.
    Free,
}
