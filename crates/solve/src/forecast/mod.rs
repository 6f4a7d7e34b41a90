//! Estimates before a solve: counts and memory ([`crate::engines::problem_size`]), time and peak memory for the engine that is selected
//! ([`time_and_memory`]), messages of several processes ([`distribution_cost`]).

pub mod distribution_cost;
pub mod time_and_memory;
