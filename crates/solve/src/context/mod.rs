//! Input and result of building an engine: [`SolveContext`] in, `BuiltEngine` out.

pub(crate) mod zonal_solution;

use crate::balance::closure::RowClosure;
use crate::distribution::sum_order::SharedZones;
use crate::distribution::{Communicator, Execution};
use crate::iteration::IterationResult;
use crate::operator::{ErrorModel, IncidentPower};
use crate::right_hand_side::direct_light::light_field::DirectLight;
use crate::right_hand_side::light_groups::{self, SourceGroup};
use crate::right_hand_side::surroundings::SurroundingsExchange;
use zonal_exchange::pair::PairSettings;
use zonal_scene::{Bands, CheckpointStore, Diagnostic, Progress, Scene, ZoneImages, Zones};
use zonal_transport::Transport;

/// Everything that the phases of a solve read in common.
pub struct SolveContext<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its zones, with boundary conditions applied.
    pub zones: &'a Zones,
    /// Ray tracing in the scene.
    pub transport: &'a Transport<'a>,
    /// The images of the zones, if they are those of an even extension.
    pub images: Option<&'a ZoneImages>,
    /// Direct light on the zones.
    pub direct: &'a DirectLight,
    /// The light groups, one right-hand side each.
    pub sources: &'a [SourceGroup],
    /// Methods and samples for pairs of zones.
    pub pair_settings: PairSettings,
    /// Memory limit, bytes.
    pub memory_limit: u64,
    /// Store of finished stages.
    pub checkpoints: &'a dyn CheckpointStore,
    /// Observer.
    pub progress: &'a dyn Progress,
    /// The processes that share the work.
    pub communicator: &'a dyn Communicator,
    /// Whether the hierarchical engine gathers the incident radiation of its solution ([`crate::SolveSettings::final_gather`]).
    pub final_gather: bool,
}

impl<'a> SolveContext<'a> {
    /// The zones, with the processes that share them.
    pub(crate) fn shared_zones(&self) -> SharedZones<'a> {
        SharedZones::new(self.zones, self.communicator)
    }

    /// The processes and the observer.
    pub(crate) fn execution(&self) -> Execution<'a> {
        Execution { communicator: self.communicator, progress: self.progress }
    }

    /// The source strengths s⁰ of every group, W/m² and W/m³.
    pub(crate) fn source_strengths(&self, surroundings: &SurroundingsExchange) -> Vec<Vec<Bands>> {
        let of_group = |s: &SourceGroup| {
            light_groups::source_strengths(s, self.scene, self.zones, surroundings, &s.direct(self.direct))
        };
        self.sources.iter().map(of_group).collect()
    }
}

/// An engine with its measured closure.
pub(crate) struct BuiltEngine<'a> {
    /// The exchange of all zones.
    pub operator: Box<dyn ErrorModel + 'a>,
    /// Closure of the rows.
    pub closure: RowClosure,
    /// Names and values of the engine's counters.
    pub counts: Vec<(String, u64)>,
    /// Diagnostics for the report.
    pub warnings: Vec<Diagnostic>,
    /// The solution, if the engine found it while it was built: the result of each group, and the incident power.
    pub solved: Option<(Vec<IterationResult>, IncidentPower)>,
}
