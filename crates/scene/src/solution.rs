//! The solution: data that solvers write and that pictures, tables and files read.

use crate::fields::Fields;
use crate::light_group::LightGroup;
use crate::report::Report;
use crate::scene::Scene;
use crate::zones::Zones;

/// A solved scene.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The scene.
    pub scene: Scene,
    /// Its zones.
    pub zones: Zones,
    /// Fields on the zones, for all lights together.
    pub fields: Fields,
    /// Fields of each light group; empty if the lights were solved in one sum.
    pub groups: Vec<LightGroup>,
    /// The report.
    pub report: Report,
    /// Hash of the scene, at most 64 hexadecimal digits.
    pub scene_hash: String,
    /// Version of the program.
    pub version: String,
}
