//! Division of the voxel zones among processes: who needs memory for all zones in one process has it in several.
//!
//! The spectral engine divides its spectra among processes, whatever the zones. Where fields and vectors would take most of the memory that is left, the zones are
//! divided too: each process has all patches, and the voxels of its planes, and its solution has the fields of these. Phases that read the fields of other
//! zones keep all zones on each process: thermal mode, mirrors, the discretization error, lights by shadow rays, warm starts.

use crate::direct_light::emitter_exchange::EmitterExchange;
use crate::distribution::{Communicator, ExchangeBuffers, Message};
use crate::engine::engine_memory::divides_zones;
use crate::engine::selection::select_engine;
use crate::report::cost_estimate::problem_size::ProblemSize;
use crate::settings::SolveSettings;
use crate::spectral::slabs::part_of;
use rustfft::num_complex::Complex64;
use std::borrow::Cow;
use zonal_math::simd::{complex_parts, complex_parts_mut};
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
    let voxels = &own[patches..];
    let (rank, ranks) = (communicator.rank(), communicator.size());
    let lengths = communicator.all_gather((voxels.len() as u64).to_le_bytes().to_vec());
    let lengths: Vec<usize> = lengths.iter().map(|bytes| u64::get(bytes) as usize).collect();
    let mut out = Vec::new();
    if rank == 0 {
        out.reserve_exact(patches + lengths.iter().sum::<usize>());
        out.extend_from_slice(own);
    }
    let per_message = MESSAGE_BYTES / size_of::<Bands>();
    let mut buffers = ExchangeBuffers::default();
    for (sender, length) in lengths.into_iter().enumerate().skip(1) {
        for first in (0..length).step_by(per_message) {
            let values = per_message.min(length - first);
            let numbers = (3 * values).div_ceil(2);
            let of = |from: usize, to: usize| {
                (0..ranks).map(move |r| if rank == from && r == to { numbers } else { 0 })
            };
            buffers.sent_lengths = of(sender, 0).collect();
            buffers.received_lengths = of(0, sender).collect();
            buffers.sent.resize(buffers.sent_lengths.iter().sum(), Complex64::default());
            buffers.received.resize(buffers.received_lengths.iter().sum(), Complex64::default());
            if rank == sender {
                let places = complex_parts_mut(&mut buffers.sent).chunks_exact_mut(3);
                places.zip(&voxels[first..first + values]).for_each(|(x, v)| x.copy_from_slice(&v.to_rgb()));
            }
            buffers = communicator.exchange(buffers);
            let received = complex_parts(&buffers.received).as_chunks::<3>().0;
            out.extend(received.iter().take(values).map(|x| Bands::from_rgb(*x)));
        }
    }
    Cow::Owned(out)
}
