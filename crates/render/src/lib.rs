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
//! | `picture` | entry points: [`render`], [`render_each`], [`focus_distances`]; camera rays where the picture varies (`adaptive_sampling`); pinhole, thin lens, positions inside a pixel (`camera`); zone seen by each pixel, for false colours (`item_buffer`) |
//! | `integrator` | radiance along a camera ray: surfaces, medium, direct light, final gather |
//! | `lights` | shadow rays, lit intervals of a ray, optical depths towards a sun |
//! | `medium` | ray paths, interpolated radiosity, single scattering, deep shadow map, area lights, many lights |
//! | `surface` | interpolated irradiance on surfaces and panes |
//! | `interpolation` | node values from zone means, computed when they are needed |
//! | `image` | linear pictures; cross-bilateral filter (`denoise`), colours of bands with wavelengths (`spectral_colour`), light that a lens scatters over the picture (`bloom()`) |
//! | [`bake`] | the solution on triangles, for viewers and other engines |
//!
//! Rows are computed in parallel and joined in order. Every pixel is a function of its index, so that the bits do not depend on the
//! number of threads.

pub mod bake;

mod image;
mod integrator;
mod interpolation;
mod lights;
mod medium;
mod options;
mod picture;
mod surface;
mod view_ray;

pub use image::Image;
pub use image::bloom::bloom;
pub use options::RenderOptions;
pub use picture::item_buffer::{ItemBuffer, PaneVisibility};
pub use picture::{focus_distances, render, render_each, sky_noise};

#[cfg(test)]
mod test_scenes;
#[cfg(test)]
mod tests;
