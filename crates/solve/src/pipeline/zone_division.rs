//! Division of the voxel zones among processes: who needs memory for all zones in one process has it in several.
//!
//! The spectral engine divides its spectra among processes, whatever the zones. Where fields and vectors would take most of the memory that is left, the zones are
//! divided too: each process has all patches, and the voxels of its planes, and its solution has the fields of these. Phases that read the fields of other
//! zones keep all zones on each process: thermal mode, symmetry planes, the discretization error, lights by shadow rays, warm starts.

use crate::distribution::part_of;
use crate::distribution::{Blocks, Communicator, ExchangeBuffers, Message};
use crate::engines::engine_memory::divides_zones;
use crate::engines::problem_size::ProblemSize;
use crate::engines::selection::select_engine;
use crate::pipeline::emitter_exchange::EmitterExchange;
use crate::settings::SolveSettings;
use std::borrow::Cow;
use zonal_fourier::Complex64;
use zonal_math::simd::{complex_parts, complex_parts_mut};
use zonal_scene::{Bands, Engine, Scene, SceneError, Solution, Zones};
use zonal_transport::{Transport, WorkSharing, build_shared_zones, zones_of_bands};

/// Bytes of one message of a field.
const MESSAGE_BYTES: usize = 1 << 23;

/// Processes that cut a scene into zones together.
struct SharedZoning<'a>(&'a dyn Communicator);

impl WorkSharing for SharedZoning<'_> {
    fn map_lists(&self, items: usize, list: &(dyn Fn(usize) -> Vec<u64> + Sync)) -> Vec<Vec<u64>> {
        Blocks::new(self.0, items, 1).map_unequal_lists(self.0, list)
    }
}

/// All zones of a scene, which the processes find together.
///
/// # Errors
/// As [`zonal_transport::build_zones`].
pub(crate) fn shared_zones(
    scene: &Scene,
    transport: &Transport,
    communicator: &dyn Communicator,
) -> Result<Zones, SceneError> {
    let sharing = SharedZoning(communicator);
    let sharing = (communicator.size() > 1).then_some(&sharing as &dyn WorkSharing);
    build_shared_zones(scene, transport, sharing)
}

/// A scene prepared for ray queries, and its zones: those that the settings have, or all that the processes find together.
///
/// # Errors
/// As [`shared_zones`].
pub(crate) fn cut<'a>(
    scene: &'a Scene,
    settings: &SolveSettings,
) -> Result<(Transport<'a>, Zones), SceneError> {
    settings.progress.begin("zones", 1);
    let transport = Transport::new(scene);
    let zones = match settings.zones {
        Some(zones) => zones.clone(),
        None => shared_zones(scene, &transport, settings.communicator)?,
    };
    settings.progress.advance(1);
    settings.progress.end();
    Ok((transport, zones))
}

/// Ray queries and zones of a block of bands, from those of the first block.
pub(crate) fn of_block<'a>(block: &'a Scene, transport: &Transport, zones: &Zones) -> (Transport<'a>, Zones) {
    let own = if block.block() == 0 { zones.clone() } else { zones_of_bands(block, zones) };
    (transport.with_bands(block), own)
}

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
    let SolveSettings { pair_settings, memory_limit, .. } = *settings;
    let choice = select_engine(scene, &zones, transport, &size, pair_settings, memory_limit, ranks)?;
    let emitters = EmitterExchange::of(scene, &zones, choice.engine, settings.pair_settings);
    let has_shadow_rays = (0..scene.lights().len()).any(|l| emitters.surface(l).is_none());
    if choice.engine != Engine::Spectral || has_shadow_rays || choice.has_patches_outside() {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::thread_ranks::on_ranks;
    use zonal_scene::{Medium, Mesh};

    /// Walls cut cells into parts, of which one process resolves some.
    #[test]
    fn shared_zones_are_those_of_one_process() {
        let corners = [[0.1, 0.2, 0.3], [0.9, 0.3, 0.2], [0.5, 0.8, 0.9], [0.2, 0.7, 0.1]];
        let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
        let medium = Medium::grid([0.0; 3], [1.0; 3], [16; 3]).extinction(0.5);
        let wall = Mesh::from_arrays(&corners, &faces).unwrap().reflectance(0.5);
        let scene = Scene::builder().surface(wall).medium(medium).build().unwrap();
        let transport = Transport::new(&scene);
        let whole = zonal_transport::build_zones(&scene, &transport).unwrap();
        assert!(whole.voxels.iter().filter(|v| !v.samples.is_empty()).count() > 100);
        for size in [2, 3, 7] {
            for found in on_ranks(size, |c| shared_zones(&scene, &transport, c).unwrap()) {
                assert_eq!(found, whole, "{size} processes");
            }
        }
    }
}
