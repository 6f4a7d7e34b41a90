//! Exchange areas of pairs of zones: the heart of the program.
//!
//! | module | what | grade |
//! |---|---|---|
//! | [`aligned`] | axis-aligned boxes and rectangles by the reduced integral, attenuated or not | proved |
//! | [`paper`] | every method of the paper, with proven bounds where they can be had, as baselines and for comparison | proved, estimated |
//! | [`polygon`] | plates in any position by contour integrals in closed form and by Gauss rules | proved |
//! | [`solid_angle`] | a plate seen from a point, in closed form | exact to rounding |
//! | [`general`] | plates and cuboids in any position, without a medium | estimated |
//! | [`pair`] | the judge: any two zones of a scene, with visibility, attenuation, cut voxels and panes | as its parts |

pub mod aligned;
mod factor;
pub mod general;
pub mod pair;
pub mod paper;
pub mod polygon;

pub use factor::{Demand, Factor, Method};

pub use zonal_transport::solid_angle;
