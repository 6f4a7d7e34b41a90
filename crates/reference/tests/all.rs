//! The integration tests of the crate as one program, which is linked once.
#![allow(missing_docs)]

mod ducts;
mod forward_laws;
mod path_tracer_laws;
