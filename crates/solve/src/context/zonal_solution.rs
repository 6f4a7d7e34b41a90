//! Solution of the zonal equations of one block of bands.

use zonal_scene::{Bands, Fields, LightGroup, Report, Scene, Solution, Zones};

/// Zones, fields and report of one block of bands.
pub(crate) struct ZonalSolution {
    /// The scene of this block alone.
    pub scene: Scene,
    /// The zones with the emission of the temperatures found.
    pub zones: Zones,
    pub fields: Fields,
    pub groups: Vec<LightGroup>,
    pub report: Report,
    /// Power that emitters send as direct light, W per band.
    pub emitters: Bands,
    /// True if the radiosity has slopes inside the zones.
    pub has_slopes: bool,
}

impl ZonalSolution {
    /// The solution of this block alone.
    pub(crate) fn into_solution(self) -> Solution {
        Solution {
            scene: self.scene,
            zones: self.zones,
            fields: self.fields,
            groups: self.groups,
            report: self.report,
            further_blocks: Vec::new(),
            scene_hash: String::new(),
            version: env!("CARGO_PKG_VERSION").to_string(),
        }
    }
}
