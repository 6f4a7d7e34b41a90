//! Commands that show and check the program itself.

pub mod demo;
pub mod reproduce;
pub mod validate;
