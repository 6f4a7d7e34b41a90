//! The integration tests of the crate as one program, which is linked once.
#![allow(missing_docs)]

mod clear_box_laws;
mod common;
mod cost_estimate;
mod coupled_bands;
mod degenerate_scenes;
mod diagnostics;
mod direct_light;
mod direct_solution;
mod discretization_error;
mod enclosures;
mod error_consistency;
mod hierarchical;
mod hollow_solids;
mod layered;
mod light_groups;
mod linear_basis;
mod many_bands;
mod mirrors;
mod monte_carlo;
mod nodes;
mod panes;
mod periodic;
mod point_lights;
mod power_normalization;
mod ray_operator;
mod refusal_and_interruption;
mod smith_gas;
mod solar_loads;
mod spectral;
mod state;
mod strips;
mod thermal;
mod total_exchange_areas;
