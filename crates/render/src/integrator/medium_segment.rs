//! The part of a camera ray before the first pane or surface, where there is medium alone.
//!
//! L = L_m + τ L_b with L_m the in-scattered and emitted radiance of the segment, τ its transmittance and L_b the radiance at its end.
//! A segment that ends Δ farther has L_m + Δ τ S and τ e^{−κΔ}, to first order, with S the source and κ the extinction at the end.

use zonal_scene::Bands;
use zonal_transport::{Hit, PaneHit};

/// End point of a camera ray and the panes before it.
pub(crate) struct CameraRayEnd {
    /// The surface point; `None` where the ray leaves the scene.
    pub hit: Option<Hit>,
    /// Distance to the end, m; outside of the scene where nothing is hit.
    pub distance: f64,
    /// The panes before the end, near to far.
    pub panes: Vec<PaneHit>,
}

impl CameraRayEnd {
    /// Length, m, of the medium segment: up to the first pane, or to the end.
    pub(crate) fn segment_length(&self) -> f64 {
        self.panes.first().map_or(self.distance, |p| p.t)
    }
}

/// The medium before the first pane or surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MediumSegment {
    /// Length, m.
    pub length: f64,
    /// Radiance in-scattered and emitted along the segment, W/(m² sr).
    pub inscattered: Bands,
    /// Transmittance.
    pub transmittance: Bands,
    /// Extinction at the end, 1/m.
    pub end_extinction: Bands,
    /// Source per metre at the end, without direct light and not attenuated, W/(m² sr)/m.
    pub end_source: Bands,
}

impl MediumSegment {
    /// Radiance of the segment in front of the radiance `behind` at its end.
    pub(crate) fn in_front_of(&self, behind: Bands) -> Bands {
        self.inscattered + self.transmittance * behind
    }

    /// The segment with its end moved to the distance `t`, m, to first order.
    pub(crate) fn with_end_at(self, t: f64) -> MediumSegment {
        let more = t - self.length;
        let inscattered = (self.inscattered + more * self.transmittance * self.end_source).max(Bands::ZERO);
        let transmittance = self.transmittance * (-self.end_extinction * more).exp();
        MediumSegment { length: t, inscattered, transmittance, ..self }
    }
}
