//! `[[light]]` and `[surroundings]`: suns, skies, points, luminaires.

pub(crate) mod lights;
pub(crate) mod point_lights;
pub(crate) mod skies;
pub(crate) mod sun_place;
