//! Backward path tracing of whole scenes: irradiance, fluence and pictures, with standard errors.
//!
//! ```text
//! H = π ∫ L cosθ/π dω, the mean over a patch        G = 4π ∫ L/(4π) dω, the mean over the free part of a cell
//! ```
//!
//! Paths start at the detector and run backwards; there are no zones, no factors and no equations. Surfaces are diffuse, one- or
//! two-sided (a side that does not exchange is black, cold and opaque); media and panes scatter isotropically. The lights of a scene
//! are ordinary emission here; only the sums distinguish them: [`DetectorReading::incident`] excludes direct light, like the field of
//! that name in a solution.
//!
//! | module | content |
//! |---|---|
//! | `tracer` | [`PathTracer`]: readings of detectors |
//! | `detector` | patches, surfaces, points, cells and panes that receive light |
//! | `path` | one path, with next-event estimation |
//! | `flight` | flights between vertices through facets, cells and panes |
//! | `light_sampling` | suns, sky and emitting facets |
//! | [`bvh`] | the facets in a binary tree of boxes |
//! | `traced_image` | pictures of a camera |
//!
//! The path tracer handles scenes of any size; its tree is tested against the search over every facet. Every random number is a
//! function of seed, detector, replicate and path: the same bits for any number of threads.

pub mod bvh;
mod detector;
pub(crate) mod flight;
mod light_sampling;
mod path;
mod traced_image;
mod tracer;

pub use detector::{Detector, SubcellPart, SurfacePlate};
pub use traced_image::TracedImage;
pub use tracer::{DetectorReading, PathTracer, TracingAccuracy};
