//! Scenes of several campaigns.

pub(crate) mod cornell;
pub(crate) mod table_cubes;
