//! Pictures and meshes from a solution.
//!
//! A solution does not depend on the view: one solve serves any number of cameras. Along each camera ray the indirect light of the
//! zones is interpolated, so that zone borders stay invisible, and direct light is evaluated at the surface point and along the
//! ray, so that shadows and shafts are sharp. The renderer reads a [`Solution`](zonal_scene::Solution) and traces rays through
//! `zonal-transport`; it depends on no solver. Its output is linear radiance; `zonal-io` applies exposure and writes files.
//!
//! | module | contents |
//! |---|---|
//! | `options` | size and sampling of a picture |
//! | `picture` | entry points: [`render`], [`render_each`], [`focus_distances`] |
//! | `integrator` | radiance along a camera ray: surfaces, medium, direct light, final gather |
//! | `adaptive_sampling` | camera rays where the picture varies |
//! | `lights` | shadow rays, lit intervals of a ray, optical depths towards a sun |
//! | `medium` | ray paths, interpolated radiosity, single scattering, deep shadow map, area lights, many lights |
//! | `surface` | interpolated irradiance on surfaces and panes |
//! | `node_interpolation` | node values from zone means |
//! | `denoise` | cross-bilateral filter of the patches' irradiance |
//! | `camera` | pinhole, thin lens, positions inside a pixel |
//! | `spectral_colour` | colours of bands with wavelengths |
//! | `bloom()` | light that a lens scatters over the picture |
//! | `item_buffer` | zone seen by each pixel, for false colours |
//! | [`bake`] | the solution on triangles, for viewers and other engines |
//!
//! Rows are computed in parallel and joined in order. Every pixel is a function of its index, so that the bits do not depend on the
//! number of threads.

pub mod bake;

mod adaptive_sampling;
mod bloom;
mod camera;
mod denoise;
mod image;
mod integrator;
mod item_buffer;
mod lazy_values;
mod lights;
mod medium;
mod node_interpolation;
mod options;
mod picture;
mod spectral_colour;
mod surface;
mod view_ray;

pub use bloom::bloom;
pub use image::Image;
pub use item_buffer::{ItemBuffer, PaneVisibility};
pub use options::RenderOptions;
pub use picture::{focus_distances, render, render_each, sky_noise};

#[cfg(test)]
mod approximation_tests;
#[cfg(test)]
mod curved_tests;
#[cfg(test)]
mod depth_of_field_tests;
#[cfg(test)]
mod picture_tests;
#[cfg(test)]
mod test_scenes;
