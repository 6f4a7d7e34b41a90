//! Quantities of surfaces, media and lights as a scene gives them, before they become parts of the scene.

pub(crate) mod gas_composition;
pub(crate) mod light_quantities;
pub(crate) mod medium_properties;
pub(crate) mod surface_properties;
