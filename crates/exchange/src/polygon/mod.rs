//! Plates in any position: contour integrals in closed form, and Gauss rules with proven bounds.

pub mod visible;
