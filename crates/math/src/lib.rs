//! Numbers we trust: vectors, bounded values, Gauss–Legendre quadrature. No word of radiation in here.
//!
//! | module | what |
//! |---|---|
//! | [`mod@vec3`] | three-dimensional vectors in f64 |
//! | [`bounded`] | a value with its error radius and the grade of the evidence |
//! | [`collapsed`] | Gauss–Jacobi rules for triangles, with their remainders |
//! | [`dilogarithm`] | Li₂ in the unit disc |
//! | [`directions`] | directions from numbers: on the circle, the sphere, by the cosine |
//! | [`gauss`] | Gauss–Legendre rules, and what their error is bounded by |
//! | [`logarithm`] | ln for lane arrays |
//! | [`sequence`] | low-discrepancy points, deterministic |
//! | [`simd`] | loops for the widest vectors of the machine, with the same bits on all of them |
//! | [`special`] | exponential integrals |
//! | [`wide`] | eight single-precision lanes with comparisons |

pub mod bounded;
pub mod collapsed;
pub mod dilogarithm;
pub mod directions;
pub mod gauss;
pub mod logarithm;
pub mod sequence;
pub mod simd;
pub mod special;
pub mod vec3;
pub mod wide;

pub use bounded::{Bounded, Grade};
pub use vec3::{Vec3, vec3};
