//! Tests of whole pictures.

mod approximation;
mod curved;
mod depth_of_field;
mod picture;
