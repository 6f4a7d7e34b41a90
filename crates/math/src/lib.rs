//! Numerical tools without radiation: vectors, values with error radii, quadrature, special functions, sampling sequences, SIMD loops.
//!
//! | module | contents |
//! |---|---|
//! | [`bounded`] | values with error radius and grade of evidence |
//! | [`dilogarithm`] | Li₂ in the unit disc |
//! | [`direction_sampling`] | uniform and cosine-weighted directions |
//! | [`double_double`] | double-double arithmetic |
//! | [`exponential_integral`] | E_1 and E_3 |
//! | [`gauss_jacobi`] | Gauss–Jacobi rules for triangles, with remainders |
//! | [`gauss_legendre`] | Gauss–Legendre rules, with error bounds |
//! | [`low_discrepancy`] | R_d and Sobol sequences, hashes |
//! | [`parallel`] | loops on all threads |
//! | [`scrambled_sobol`] | Sobol's sequence with nested uniform scrambling |
//! | [`simd`] | loops over lanes with run-time dispatch, e^x and ln x, eight-lane f32 |
//! | [`spherical_cap`] | cosine integral and samples of a spherical cap above a plane |
//! | [`mod@vec3`] | three-dimensional vectors |

pub mod bounded;
mod counters;
pub mod dilogarithm;
pub mod direction_sampling;
pub mod double_double;
pub mod exponential_integral;
pub mod gauss_jacobi;
pub mod gauss_legendre;
pub mod low_discrepancy;
pub mod parallel;
pub mod scrambled_sobol;
pub mod simd;
pub mod spherical_cap;
pub mod vec3;

pub use bounded::{Bounded, Grade};
pub use vec3::{Vec3, vec3};
