//! The sampled exchange with the surroundings as a stage of a checkpoint.

use super::surroundings_exchange::{SurroundingsExchange, escape_rays_per_zone};
use crate::settings::SolveSettings;
use crate::settings::stage_codec::{Decoder, Encoder};
use zonal_scene::{Scene, Zones};
use zonal_transport::Transport;

/// Name of the stage, and of that with all rays of some zones alone.
const STAGE: &str = "surroundings";
const STAGE_OF_ZONES: &str = "surroundings-of-zones";

/// The exchange of all zones with the surroundings: loaded from its stage, or sampled and saved.
pub(crate) fn measure(
    scene: &Scene,
    zones: &Zones,
    transport: &Transport,
    settings: &SolveSettings,
) -> SurroundingsExchange {
    let kept = settings.checkpoints.load(STAGE).and_then(|bytes| decode(&bytes, zones.len()));
    kept.unwrap_or_else(|| {
        let sampled = (escape_rays_per_zone(scene), settings.pair_settings.sample);
        let exchange = SurroundingsExchange::measure(scene, zones, transport, sampled, settings.execution());
        if settings.checkpoints.keeps() {
            settings.checkpoints.save(STAGE, &encode(&exchange));
        }
        exchange
    })
}

/// The exchange of the zones that need rays, with pilot rays of the others: loaded from its stage, or sampled and saved.
pub(super) fn measure_zones(
    (scene, zones, transport): (&Scene, &Zones, &Transport),
    needs: &[bool],
    settings: &SolveSettings,
) -> SurroundingsExchange {
    let stage = if needs.contains(&false) { STAGE_OF_ZONES } else { STAGE };
    let kept = settings.checkpoints.load(stage).and_then(|bytes| decode(&bytes, zones.len()));
    kept.unwrap_or_else(|| {
        let sampled = (escape_rays_per_zone(scene), settings.pair_settings.sample);
        let traced = (scene, zones, transport);
        let exchange =
            SurroundingsExchange::measure_zones(traced, sampled, settings.execution(), Some(needs));
        if settings.checkpoints.keeps() {
            settings.checkpoints.save(stage, &encode(&exchange));
        }
        exchange
    })
}

/// The exchange by pilot rays of all zones.
pub(crate) fn pilot(
    scene: &Scene,
    zones: &Zones,
    transport: &Transport,
    settings: &SolveSettings,
) -> SurroundingsExchange {
    let sampled = (escape_rays_per_zone(scene), settings.pair_settings.sample);
    let none = vec![false; zones.len()];
    SurroundingsExchange::measure_zones((scene, zones, transport), sampled, settings.execution(), Some(&none))
}

fn encode(exchange: &SurroundingsExchange) -> Vec<u8> {
    let mut encoder = Encoder::default();
    encoder.bands(&exchange.sky);
    encoder.bands(&exchange.backfaces);
    encoder.bands(&exchange.error);
    encoder.int(exchange.rays as usize);
    encoder.bytes()
}

fn decode(bytes: &[u8], zones: usize) -> Option<SurroundingsExchange> {
    let mut decoder = Decoder::new(bytes);
    let [sky, backfaces, error] = [decoder.bands()?, decoder.bands()?, decoder.bands()?];
    let rays = decoder.int()? as u64;
    let fits = sky.len() == zones && backfaces.len() == zones && (error.is_empty() || error.len() == zones);
    fits.then_some(SurroundingsExchange { sky, backfaces, error, rays })
}
