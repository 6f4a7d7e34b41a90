//! Exchange areas of pairs of zones: the heart of the program.
//!
//! | module | what | grade |
//! |---|---|---|
//! | [`aligned`] | axis-aligned boxes and rectangles by the reduced integral, attenuated or not | proved |
//! | [`solid_angle`] | a plate seen from a point, in closed form | exact to rounding |
//! | [`general`] | plates and cuboids in any position, without a medium | estimated |
//! | [`pair`] | the judge: any two zones of a scene, with visibility, attenuation, cut voxels and panes | as its parts |

pub mod aligned;
pub mod general;
pub mod pair;

pub use zonal_transport::solid_angle;
