//! The sampled exchange with the surroundings as a stage of a checkpoint.

use super::surroundings_exchange::{SurroundingsExchange, escape_rays_per_zone};
use crate::settings::SolveSettings;
use crate::settings::stage_codec::{Decoder, Encoder};
use zonal_scene::Zones;
use zonal_transport::Transport;

/// Name of the stage, and of that with all rays of some zones alone.
const STAGE: &str = "surroundings";
const STAGE_OF_ZONES: &str = "surroundings-of-zones";

/// The exchange of all zones with the surroundings: loaded from its stage, or sampled and saved.
pub(crate) fn measure(
    zones: &Zones,
    transport: &Transport,
    settings: &SolveSettings,
) -> SurroundingsExchange {
    measure_zones(zones, transport, None, settings)
}

/// The exchange by pilot rays of all zones.
pub(crate) fn pilot(zones: &Zones, transport: &Transport, settings: &SolveSettings) -> SurroundingsExchange {
    sampled(zones, transport, settings, Some(&vec![false; zones.len()]))
}

/// The exchange of the zones that need rays, with pilot rays of the others: loaded from its stage, or sampled and saved.
pub(super) fn measure_zones(
    zones: &Zones,
    transport: &Transport,
    needs: Option<&[bool]>,
    settings: &SolveSettings,
) -> SurroundingsExchange {
    let are_some = needs.is_some_and(|needs| needs.contains(&false));
    let stage = if are_some { STAGE_OF_ZONES } else { STAGE };
    let kept = settings.checkpoints.load(stage).and_then(|bytes| decode(&bytes, zones.len()));
    kept.unwrap_or_else(|| {
        let exchange = sampled(zones, transport, settings, needs);
        if settings.checkpoints.keeps() {
            settings.checkpoints.save(stage, &encode(&exchange));
        }
        exchange
    })
}

fn sampled(
    zones: &Zones,
    transport: &Transport,
    settings: &SolveSettings,
    needs: Option<&[bool]>,
) -> SurroundingsExchange {
    let (rays, sample) = (escape_rays_per_zone(transport.scene()), settings.pair_settings.sample);
    SurroundingsExchange::measure(zones, transport, rays, sample, settings.execution(), needs)
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
