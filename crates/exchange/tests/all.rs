//! The integration tests of the crate as one program, which is linked once.
#![allow(missing_docs)]

mod aligned_factors;
mod estimated_factors;
mod heterogeneous_scenes;
mod plates_and_boxes_in_media;
mod polygon_factors;
mod rounded_corners;
