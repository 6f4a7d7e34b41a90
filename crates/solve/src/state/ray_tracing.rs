//! Rays of one block of bands: surroundings and lights, in a scene with symmetry planes by its even extension.

use super::area_operator::AreaOperator;
use crate::pipeline::symmetry_planes::SymmetricSolve;
use crate::pipeline::{illuminate_stage, measure_surroundings};
use crate::right_hand_side::direct_light::light_field::LightField;
use crate::right_hand_side::surroundings::{SurroundingsExchange, exact_rows, stage};
use crate::settings::SolveSettings;
use zonal_scene::{Engine, Scene, SceneError, Zones};
use zonal_transport::Transport;

/// A scene of one block of bands, in which rays are traced.
pub(super) struct RayTracing<'a> {
    pub scene: &'a Scene,
    pub zones: &'a Zones,
    pub transport: &'a Transport<'a>,
    /// The even extension of a scene with symmetry planes.
    pub mirrored: Option<(&'a SymmetricSolve, Transport<'a>)>,
}

impl RayTracing<'_> {
    /// The exchange with the surroundings, as the dense engine with the exchange areas `operator` has it.
    pub(super) fn surroundings(
        &self,
        operator: &AreaOperator,
        settings: &SolveSettings,
    ) -> Result<SurroundingsExchange, SceneError> {
        let (scene, zones, transport) = (self.scene, self.zones, self.transport);
        let Some((m, rays)) = &self.mirrored else {
            if !exact_rows::are_known_later(scene, zones, &settings.pair_settings) {
                return measure_surroundings(scene, zones, transport, Engine::Dense, settings);
            }
            let pilot = stage::pilot(zones, transport, settings);
            return Ok(exact_rows::complete(operator, zones, transport, pilot, settings));
        };
        let all = measure_surroundings(&m.extension.scene, &m.zones, rays, Engine::Dense, settings)?;
        Ok(m.surroundings_of_part(&all))
    }

    /// Direct light of light number `l` by shadow rays.
    pub(super) fn light(&self, l: usize, settings: &SolveSettings) -> Result<LightField, SceneError> {
        let Some((m, rays)) = &self.mirrored else {
            return illuminate_stage(self.scene, self.zones, self.transport, l, settings);
        };
        let all = illuminate_stage(&m.extension.scene, &m.zones, rays, l, settings)?;
        Ok(m.light_of_part(l, all))
    }
}
