//! Data of thermal states from one block of bands: surroundings, closure and direct light.

use super::area_operator::AreaOperator;
use super::light_data::{LightData, direct_light};
use super::ray_tracing::RayTracing;
use super::surroundings_data::SurroundingsData;
use crate::areas::exchange_areas::ExchangeAreas;
use crate::balance::{closure, least_squares_closure};
use crate::distribution::sum_order::SharedZones;
use crate::errors::closure_error::unexplained_fractions;
use crate::pipeline::BandBlock;
use crate::pipeline::emitter_exchange::PatchExchange;
use crate::pipeline::symmetry_planes::SymmetricSolve;
use crate::right_hand_side::surroundings::SurroundingsExchange;
use crate::settings::{SolveSettings, check_interrupted};
use crate::thermal::ZoneProperties;
use crate::thermal::emissivity::set_known_reflectances;
use std::ops::Range;
use zonal_exchange::pair::{closure_target, scaled_radiosity_coefficient};
use zonal_scene::{Band, Bands, SceneError, Zones};
use zonal_transport::{Transport, zones_of_bands};

/// The data of one block of bands.
pub(super) struct BlockData {
    pub properties: ZoneProperties,
    /// A row for each matrix of the block.
    pub surroundings: SurroundingsData,
    /// A row for each band of the block.
    pub light: LightData,
    /// The matrices after a restoration of closure, and their place among the entries of all matrices.
    pub adjusted: Option<(Range<usize>, Vec<f64>)>,
}

impl BlockData {
    /// Measures block number `block` of bands, which is `scene`; samples the surroundings and the lights, and measures or restores closure as a solve does.
    ///
    /// # Errors
    /// If the scene has no zones of this kind, or if the observer interrupts the computation.
    pub(super) fn measure(
        transport: &Transport,
        areas: &ExchangeAreas,
        settings: &SolveSettings,
    ) -> Result<BlockData, SceneError> {
        let scene = transport.scene();
        let block = scene.block();
        // The areas have the zones of the first block.
        let mut further = (block > 0).then(|| zones_of_bands(scene, &areas.zones));
        further.as_mut().map_or(Ok(()), |zones| set_known_reflectances(scene, zones))?;
        let zones = further.as_ref().unwrap_or(&areas.zones);
        let mirrored = SymmetricSolve::of(scene, zones)?;
        let extension = mirrored.as_ref().map(|m| (m, Transport::new(&m.extension.scene)));
        let rays = RayTracing {
            part: BandBlock { scene, zones, transport, mirrored: None },
            mirrored: extension.as_ref().map(|(m, transport)| (*m, BandBlock::extended(m, transport))),
        };
        // Close the rows.
        let mut operator = AreaOperator::new(areas, zones, block);
        let mut exterior = rays.surroundings(&operator, settings)?;
        check_interrupted(settings.progress)?;
        let measured = closure::measure(&operator, SharedZones::alone(zones), &exterior);
        let rows = if scene.restores_rows() {
            least_squares_closure::restore(&mut operator, SharedZones::alone(zones), &mut exterior, measured)
        } else {
            measured
        };
        let fractions = unexplained_fractions(zones, &rows, &exterior);
        // Light the zones.
        let mut light = LightData::default();
        if !scene.lights().is_empty() {
            let exchange = PatchExchange {
                scene,
                zones: SharedZones::alone(zones),
                operator: &operator,
                fractions: &fractions,
                surroundings: &exterior,
            };
            light.append(&direct_light(&rays, &exchange, settings)?, zones, scene.window().len());
        }
        let matrices = areas.matrices.saturating_sub(block * Band::count()).min(Band::count());
        let surroundings = surroundings_rows(zones, &exterior, &operator, &fractions, matrices);
        let entries = operator.entries();
        let adjusted = operator.adjusted.take().map(|areas| (entries, areas));
        Ok(BlockData { properties: ZoneProperties::of(scene, zones), surroundings, light, adjusted })
    }
}

/// Rows of the first `matrices` bands of a block, in the unit of c B.
fn surroundings_rows(
    zones: &Zones,
    exterior: &SurroundingsExchange,
    operator: &AreaOperator,
    fractions: &[Bands],
    matrices: usize,
) -> SurroundingsData {
    let n = zones.len();
    let c: Vec<Bands> = (0..n).map(|i| scaled_radiosity_coefficient(zones, i)).collect();
    let rows = |of: &dyn Fn(usize) -> Bands| -> Vec<f64> {
        Band::all().take(matrices).flat_map(|b| (0..n).map(move |i| of(i)[b])).collect()
    };
    let target = |i: usize| closure_target(zones, i);
    let known = |x: f64| if x.is_nan() { f64::INFINITY } else { x.abs() };
    SurroundingsData {
        areas: rows(&|i| c[i] * exterior.sky_of(i)),
        radii: rows(&|i| c[i] * target(i) * exterior.escape_fraction_error(i, target(i))),
        backfaces: rows(&|i| c[i] * exterior.backfaces_of(i)),
        scaling: rows(&|i| operator.scaling[i]),
        closure_error: rows(&|i| fractions[i].map(known)),
    }
}
