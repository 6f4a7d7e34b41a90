//! The integration tests of the crate as one program, which is linked once.
#![allow(missing_docs)]

mod common;
mod light_samples;
mod optical_depth;
mod ray_queries;
mod shaft_culling;
mod solids;
mod zoning;
