//! Settings of a solve that are not part of the scene: memory limit, methods for pairs of zones, checkpoints, observer and warm start.
//!
//! | module | content |
//! |---|---|
//! | `named_stages`, `stage_codec` | stages of a part of a solve in a checkpoint, and their bytes |
//! | `zone_power` | powers of the zones that closure and normalization compare |
//! | `unobstructed_cells` | cells that no facet touches |

pub(crate) mod named_stages;
pub(crate) mod stage_codec;
pub(crate) mod unobstructed_cells;
pub(crate) mod zone_power;

use crate::device::Device;
use crate::distribution::{Communicator, Execution, SingleProcess};
use zonal_exchange::aligned::lattice::TableAccuracy;
use zonal_exchange::pair::PairSettings;
use zonal_scene::{CheckpointStore, LightGroup, NoCheckpoints, Progress, SceneError, Zones};

/// Default memory limit of a solve, bytes.
pub const DEFAULT_MEMORY_LIMIT: u64 = 12 << 30;

/// Settings of a solve beside the options of the scene.
#[derive(Clone, Copy)]
pub struct SolveSettings<'a> {
    /// Memory limit, bytes: of the exchange areas of all pairs, or of everything that the rays engine holds.
    pub memory_limit: u64,
    /// Methods and samples for pairs of zones.
    pub pair_settings: PairSettings,
    /// Store of finished stages.
    pub checkpoints: &'a dyn CheckpointStore,
    /// Observer.
    pub progress: &'a dyn Progress,
    /// The processes that share the work.
    pub communicator: &'a dyn Communicator,
    /// The device of the products of the spectral engine; `None` for the processor.
    pub device: Option<&'a dyn Device>,
    /// Light groups of an earlier solution on the same zones for a warm start; empty for a cold start.
    pub initial_groups: &'a [LightGroup],
    /// The zones of the scene, or of its first three bands, where an earlier solve has cut them.
    pub zones: Option<&'a Zones>,
    /// False ends the rays engine with the incident radiation of its stored rays, which are fewer: a preview with more noise, whose error is stated, in a fraction of the time.
    pub final_gather: bool,
    /// The purpose of the solution.
    pub purpose: SolvePurpose,
}

/// Relative error of factors with slopes in a solve for a comparison.
pub(crate) const COMPARISON_TOLERANCE: f64 = 3e-8;

/// The purpose of a solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SolvePurpose {
    /// It is the result, with its errors.
    #[default]
    Result,
    /// Its temperatures and powers by name are compared with those of a result on other zones, far less accurately than they are solved; its
    /// errors are not read.
    Comparison,
}

impl SolvePurpose {
    /// Accuracy of tables of factors with slopes.
    pub(crate) fn table_accuracy(self) -> TableAccuracy {
        match self {
            SolvePurpose::Result => TableAccuracy::Full,
            SolvePurpose::Comparison => TableAccuracy::Comparison,
        }
    }
}

impl<'a> SolveSettings<'a> {
    /// Default settings without checkpoints, with a memory limit in bytes.
    pub fn new(memory_limit: u64, progress: &'a dyn Progress) -> SolveSettings<'a> {
        SolveSettings {
            memory_limit,
            pair_settings: PairSettings::default(),
            checkpoints: &NoCheckpoints,
            progress,
            communicator: &SingleProcess,
            device: None,
            initial_groups: &[],
            zones: None,
            final_gather: true,
            purpose: SolvePurpose::Result,
        }
    }

    /// The settings of block `t` of bands that are solved apart: zones and solution of an earlier solve serve the first.
    pub(crate) fn of_block<'b>(&self, t: usize, checkpoints: &'b dyn CheckpointStore) -> SolveSettings<'b>
    where
        'a: 'b,
    {
        let own = SolveSettings { checkpoints, ..*self };
        if t == 0 { own } else { SolveSettings { initial_groups: &[], zones: None, ..own } }
    }

    /// The processes and the observer.
    pub(crate) fn execution(&self) -> Execution<'a> {
        Execution { communicator: self.communicator, progress: self.progress }
    }
}

/// The error of an interrupted solve if the observer interrupts it; called between phases.
pub(crate) fn check_interrupted(progress: &dyn Progress) -> Result<(), SceneError> {
    if progress.is_interrupted() { Err(SceneError::interrupted()) } else { Ok(()) }
}
