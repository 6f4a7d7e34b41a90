//! Solution of the zonal equations of one triple of bands.

use zonal_scene::{Bands, Fields, LightGroup, Report, Zones};

/// Zones, fields and report of one triple of bands.
pub(crate) struct ZonalSolution {
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
