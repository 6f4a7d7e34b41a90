//! Input and result of building an engine: [`SolveContext`] in, `BuiltEngine` out.

pub(crate) mod zonal_solution;

use crate::balance::closure::RowClosure;
use crate::distribution::Execution;
use crate::distribution::sum_order::SharedZones;
use crate::iteration::IterationResult;
use crate::operator::{ErrorModel, IncidentPower};
use crate::right_hand_side::direct_light::light_field::DirectLight;
use crate::right_hand_side::light_groups::{self, SourceGroup};
use crate::right_hand_side::surroundings::SurroundingsExchange;
use crate::settings::SolveSettings;
use zonal_scene::{Bands, Diagnostic, ErrorParts, Scene, ZoneImages, Zones};
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
    /// Settings of the solve.
    pub settings: SolveSettings<'a>,
}

impl<'a> SolveContext<'a> {
    /// The zones, with the processes that share them.
    pub(crate) fn shared_zones(&self) -> SharedZones<'a> {
        SharedZones::new(self.zones, self.settings.communicator)
    }

    /// The processes and the observer.
    pub(crate) fn execution(&self) -> Execution<'a> {
        self.settings.execution()
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
    /// The parts of its error, of the patches and of the volume zones and panes, where the engine tells them apart.
    pub error_parts: Option<[ErrorParts; 2]>,
}

impl<'a> BuiltEngine<'a> {
    /// An engine without warnings that has not found the solution.
    pub(crate) fn unsolved(
        operator: Box<dyn ErrorModel + 'a>,
        closure: RowClosure,
        counts: Vec<(String, u64)>,
    ) -> BuiltEngine<'a> {
        BuiltEngine { operator, closure, counts, warnings: Vec::new(), solved: None, error_parts: None }
    }
}

/// One block of bands with its engine.
pub(crate) struct BlockEngine<'a> {
    pub context: SolveContext<'a>,
    pub built: BuiltEngine<'a>,
    pub surroundings: SurroundingsExchange,
}
