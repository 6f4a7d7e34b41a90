//! Plates in any position: contour integrals in closed form, and Gauss rules with proven bounds.

mod body;
mod contour;
mod edges;
mod matrix;
mod oblique;
mod plates;
mod prepared;
mod skew;
mod tensor;
pub mod visible;

pub use matrix::{Matrix, Plates, matrix};
pub use oblique::plate_cuboid;
pub use plates::plate_plate;
