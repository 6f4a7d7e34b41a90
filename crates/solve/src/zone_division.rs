//! Division of the voxel zones among processes: who needs memory for all zones in one process has it in several.
//!
//! The spectral engine divides its spectra among processes, whatever the zones. Where fields and vectors would take most of the memory that is left, the zones are
//! divided too: each process has all patches, and the voxels of its planes, and its solution has the fields of these. Phases that read the fields of other
//! zones keep all zones on each process: thermal mode, mirrors, the discretization error, lights by shadow rays, warm starts.

use crate::direct_light::emitter_exchange::EmitterExchange;
use crate::distribution::Communicator;
use crate::engine::engine_memory::divides_zones;
use crate::engine::selection::select_engine;
use crate::report::cost_estimate::problem_size::ProblemSize;
use crate::settings::SolveSettings;
use crate::spectral::slabs::part_of;
use std::borrow::Cow;
use zonal_scene::{Bands, Engine, Scene, SceneError, Solution, Zones};
use zonal_transport::Transport;

/// Bytes of one message of a field.
const MESSAGE_BYTES: usize = 1 << 23;

/// The zones of this process, of all zones of a scene.
///
/// # Errors
/// If no engine can solve the scene, or if it exceeds the memory limit.
pub(crate) fn divide(
    scene: &Scene,
    transport: &Transport,
    zones: Zones,
    settings: &SolveSettings,
) -> Result<Zones, SceneError> {
    let ranks = settings.communicator.size();
    if ranks == 1 || !divides_zones(scene) || !settings.initial_groups.is_empty() {
        return Ok(zones);
    }
    let size = ProblemSize::new(scene, &zones, transport);
    let limits = (settings.pair_settings, settings.memory_limit);
    let choice = select_engine(scene, &zones, transport, &size, limits, ranks)?;
    let emitters = EmitterExchange::of(scene, &zones, choice.engine, settings.pair_settings);
    let has_shadow_rays = (0..scene.lights().len()).any(|l| emitters.surface(l).is_none());
    if choice.engine != Engine::Spectral || has_shadow_rays {
        return Ok(zones);
    }
    let [planes, plane] = match scene.voxel_grid() {
        Some(grid) => [grid.dims()[0], grid.dims()[1] * grid.dims()[2]],
        None => return Ok(zones),
    };
    let own = part_of(planes, settings.communicator.rank(), ranks);
    let voxels = zones.voxels.of_cells(own.start * plane..own.end * plane);
    Ok(match voxels {
        Some(voxels) => Zones { voxels, ..zones },
        None => zones,
    })
}

/// The values of all zones on the first process, in the place of those of its own; other processes receive none. All processes call it for the same fields in the
/// same order.
pub fn collect<'a>(
    solution: &Solution,
    communicator: &dyn Communicator,
    own: &'a [Bands],
) -> Cow<'a, [Bands]> {
    let zones = &solution.zones;
    if !zones.voxels.is_divided() {
        return Cow::Borrowed(own);
    }
    let patches = zones.patches.len().min(own.len());
    let mut out = if communicator.rank() == 0 { own[..patches].to_vec() } else { Vec::new() };
    let voxels = &own[patches..];
    let lengths = communicator.all_gather((voxels.len() as u64).to_le_bytes().to_vec());
    let length = |bytes: &Vec<u8>| bytes.as_slice().try_into().map_or(0, u64::from_le_bytes) as usize;
    let per_message = MESSAGE_BYTES / size_of::<Bands>();
    for (rank, length) in lengths.iter().map(length).enumerate() {
        for first in (0..length).step_by(per_message) {
            let mut messages = vec![Vec::new(); communicator.size()];
            if rank == communicator.rank() {
                let part = &voxels[first..(first + per_message).min(length)];
                messages[0] = part.iter().flat_map(Bands::iter).flat_map(|x| x.to_le_bytes()).collect();
            }
            let received = communicator.all_to_all(messages);
            let mut numbers =
                received[rank].chunks_exact(8).map(|x| x.try_into().map_or(0.0, f64::from_le_bytes));
            let mut next = || numbers.next().unwrap_or_default();
            out.extend((0..received[rank].len() / size_of::<Bands>()).map(|_| Bands::from_fn(|_| next())));
        }
    }
    Cow::Owned(out)
}
