//! Rays of one block of bands: surroundings and lights, in a scene with symmetry planes by its even extension.

use super::area_operator::AreaOperator;
use crate::pipeline::BandBlock;
use crate::pipeline::symmetry_planes::SymmetricSolve;
use crate::right_hand_side::direct_light::light_field::LightField;
use crate::right_hand_side::surroundings::{SurroundingsExchange, exact_rows, stage};
use crate::settings::SolveSettings;
use zonal_scene::{Engine, SceneError};

/// A scene of one block of bands, in which rays are traced.
pub(super) struct RayTracing<'a> {
    pub part: BandBlock<'a>,
    /// The even extension of a scene with symmetry planes.
    pub mirrored: Option<(&'a SymmetricSolve, BandBlock<'a>)>,
}

impl RayTracing<'_> {
    /// The exchange with the surroundings, as the dense engine with the exchange areas `operator` has it.
    pub(super) fn surroundings(
        &self,
        operator: &AreaOperator,
        settings: &SolveSettings,
    ) -> Result<SurroundingsExchange, SceneError> {
        let BandBlock { scene, zones, transport, .. } = self.part;
        let Some((m, whole)) = &self.mirrored else {
            if !exact_rows::are_known_later(scene, zones, &settings.pair_settings) {
                return self.part.measure_surroundings(Engine::Dense, settings);
            }
            let pilot = stage::pilot(zones, transport, settings);
            return Ok(exact_rows::complete(operator, zones, transport, pilot, settings));
        };
        Ok(m.surroundings_of_part(&whole.measure_surroundings(Engine::Dense, settings)?))
    }

    /// Direct light of light number `l` by shadow rays.
    pub(super) fn light(&self, l: usize, settings: &SolveSettings) -> Result<LightField, SceneError> {
        match &self.mirrored {
            Some((m, whole)) => Ok(m.light_of_part(l, whole.illuminate(l, settings)?)),
            None => self.part.illuminate(l, settings),
        }
    }
}
