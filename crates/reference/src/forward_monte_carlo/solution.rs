//! Results of forward Monte Carlo.

use crate::estimate::SampleEstimate;
use zonal_scene::PerBand;

/// Temperature and net power of a surface, the medium, a pane or a zone.
#[derive(Clone, Copy, Debug, Default)]
pub struct HeatBalance {
    /// Mean of σT⁴, W/m²; `None` where there is no temperature.
    pub emissive: Option<SampleEstimate>,
    /// Net power that it emits, W.
    pub power: SampleEstimate,
}

/// Powers and temperatures of a scene.
#[derive(Clone, Debug, Default)]
pub struct ForwardSolution {
    /// Absorbed by each surface, W per band; in thermal mode where temperatures are known.
    pub surfaces: Vec<PerBand<SampleEstimate>>,
    /// Absorbed by the medium, W per band; in thermal mode where temperatures are known.
    pub medium: PerBand<SampleEstimate>,
    /// Absorbed by all panes, W per band.
    pub panes: PerBand<SampleEstimate>,
    /// Escaped to the surroundings after an event, W per band.
    pub escaped: PerBand<SampleEstimate>,
    /// Absorbed by black backs, W per band.
    pub backs: PerBand<SampleEstimate>,
    /// Surfaces, the medium if there is one, each pane: temperatures and net powers. Empty in light mode.
    pub heat: Vec<HeatBalance>,
    /// H or G of each zone, W/m² per band; empty for the continuous problem.
    pub zones: Vec<PerBand<SampleEstimate>>,
    /// Temperature and net power of each zone; empty in light mode and for the continuous problem.
    pub zone_heat: Vec<HeatBalance>,
}
