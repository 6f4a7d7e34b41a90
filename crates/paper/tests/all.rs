//! The integration tests of the crate as one program, which is linked once.
#![allow(missing_docs)]

mod hemicube;
mod intervals;
mod laws;
mod methods;
mod patch_strips;
mod voxel_strips;
