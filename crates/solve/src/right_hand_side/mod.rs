//! Right-hand sides of the zonal equations: direct light, surroundings, light groups.

pub mod direct_light;
pub mod light_groups;
pub mod surroundings;
