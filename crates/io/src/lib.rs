//! Formats in and out.

pub mod input;
pub mod output;
