//! The method of a solve before it begins, for a second solve beside it.

use crate::device::basis::BasisOrder;
use crate::engines::problem_size::ProblemSize;
use crate::engines::selection::select_engine;
use crate::errors::discretization::SolveMethod;
use crate::pipeline::zone_division;
use crate::settings::SolveSettings;
use zonal_scene::{Engine, Scene, ZoneBasis, Zones};
use zonal_transport::Transport;

/// Zones of a scene, at most, whose first and second solve run at the same time: alone each of them has loops too short for several threads, and both together
/// take little memory.
const MAX_ZONES_TOGETHER: usize = 1000;

/// The method that is expected for a small scene whose second solve may run beside the first: neither is shared by processes, resumed nor sampled. `zones` and `transport`
/// belong to the first block of bands.
pub(crate) fn expected_method(
    scene: &Scene,
    transport: &Transport,
    zones: &Zones,
    settings: &SolveSettings,
) -> Option<SolveMethod> {
    let is_alone = settings.communicator.size() == 1 && !settings.checkpoints.keeps();
    if !is_alone || zones.len() > MAX_ZONES_TOGETHER || scene.has_symmetry_planes() {
        return None;
    }
    let SolveSettings { pair_settings, memory_limit, .. } = *settings;
    let mut basis = ZoneBasis::Constant;
    let engine = |(b, block): (usize, Scene)| {
        let of_block = (b > 0).then(|| zone_division::of_block(&block, transport, zones));
        let (transport, zones) = of_block.as_ref().map_or((transport, zones), |(t, z)| (t, z));
        let size = ProblemSize::new(&block, zones, transport);
        let choice = select_engine(&block, zones, transport, &size, pair_settings, memory_limit, 1).ok()?;
        if choice.enclosure.is_some_and(|(_, order)| order == BasisOrder::Linear) {
            basis = ZoneBasis::Linear;
        }
        matches!(choice.engine, Engine::Dense | Engine::Spectral).then_some(choice.engine)
    };
    let engines = scene.blocks().enumerate().map(engine).collect::<Option<_>>()?;
    Some(SolveMethod { basis, engines })
}
