//! The solution: inert data that solvers write, and pictures, tables and files read.

use crate::{Bands, Scene, Zones};
use zonal_math::Grade;

/// How the iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolveStatus {
    /// The residual fell below what was asked for.
    Converged,
    /// The residual stopped falling before.
    Stalled,
    /// The iterations ran out.
    Budget,
}

impl SolveStatus {
    /// The word that reports use.
    pub fn word(self) -> &'static str {
        match self {
            SolveStatus::Converged => "converged",
            SolveStatus::Stalled => "stalled",
            SolveStatus::Budget => "budget",
        }
    }
}

/// One array a quantity, over all zones in the order of [`Zones`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fields {
    /// Radiosity B, W/m², direct light included.
    pub radiosity: Vec<Bands>,
    /// Irradiance H of patches, fluence G of volume zones, W/m², **without** direct light.
    pub incident: Vec<Bands>,
    /// H_dir of patches, G_dir of volume zones, W/m²: direct light alone.
    pub direct: Vec<Bands>,
    /// Estimated error of `incident`, W/m².
    pub error: Vec<Bands>,
}

/// Where the power went, W a band.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Energy {
    /// Emitted by surfaces, volumes, panes and volumetric sources.
    pub emitted: Bands,
    /// Come in: from the surroundings' zone, and as direct light.
    pub incoming: Bands,
    /// Absorbed by each named surface, in the scene's order.
    pub absorbed_surfaces: Vec<(String, Bands)>,
    /// Absorbed by the voxels.
    pub absorbed_volumes: Bands,
    /// Absorbed by the panes.
    pub absorbed_panes: Bands,
    /// Gone to the surroundings, measured by rays.
    pub escaped: Bands,
    /// Absorbed by the black backs of one-sided surfaces, measured by rays.
    pub backs: Bands,
    /// emitted + incoming − absorbed − escaped, relative to emitted + incoming.
    pub residual: Bands,
}

/// Closure: how far Σ_j F_ij is from A_i or 4 κ_i V_i, surroundings and backs included.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Closure {
    /// Largest relative defect before any restoration, a band.
    pub worst: Bands,
    /// Root mean square of the relative defect before any restoration, a band.
    pub rms: Bands,
    /// Largest relative change of a factor made by the restoration; zero without.
    pub largest_change: Bands,
    /// Largest relative defect after the restoration, a band.
    pub after: Bands,
    /// True when closure was restored.
    pub restored: bool,
}

/// What was done, and how well it went.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// How the iteration ended, a band.
    pub status: [SolveStatus; 3],
    /// Relative residual after each iteration, a band.
    pub residuals: [Vec<f64>; 3],
    /// Closure.
    pub closure: Closure,
    /// Energy balance.
    pub energy: Energy,
    /// Name and count of what was counted: pairs by method, rays, tables.
    pub counts: Vec<(String, u64)>,
    /// Warnings: zones too thick, open enclosures, dropped triangles.
    pub warnings: Vec<String>,
    /// The weakest grade among the exchange areas used.
    pub grade: Grade,
}

/// A solved scene.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The scene.
    pub scene: Scene,
    /// Its zones.
    pub zones: Zones,
    /// What was found on them.
    pub fields: Fields,
    /// What was done.
    pub report: Report,
    /// Hash of the scene's ingredients, 64 hexadecimal digits or fewer.
    pub scene_hash: String,
    /// Version of the program.
    pub version: String,
}
