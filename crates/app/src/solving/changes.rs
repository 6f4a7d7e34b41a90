//! Options of a solve in place of the options of a scene.

use crate::quality::Quality;
use zonal_scene::{Engine, LightGrouping, Scene, SceneError, ZoneBasis};

/// Options of a solve; `None` keeps that of the scene at the quality.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolveChanges {
    /// Tolerance and patch size at once.
    pub quality: Quality,
    /// Relative tolerance of the exchange areas, 0 < T < 1.
    pub tolerance: Option<f64>,
    /// Whether closure is restored, or measured.
    pub restore_closure: Option<bool>,
    /// Representation of the exchange between zones.
    pub engine: Option<Engine>,
    /// Lights that are solved separately.
    pub light_grouping: Option<LightGrouping>,
    /// Basis of the radiosity inside zones.
    pub zone_basis: Option<ZoneBasis>,
    /// Whether a second solve estimates the discretization error.
    pub discretization_error: Option<bool>,
    /// Number of terms of the Neumann series in place of the iterative solver.
    pub scattering_orders: Option<usize>,
}

impl SolveChanges {
    /// The scene with these options.
    ///
    /// # Errors
    /// If an option is out of range.
    pub fn apply(&self, scene: Scene) -> Result<Scene, SceneError> {
        let mut o = self.quality.of_solve(&scene);
        o.tolerance = self.tolerance.unwrap_or(o.tolerance);
        o.restore_closure = self.restore_closure.or(o.restore_closure);
        o.engine = self.engine.unwrap_or(o.engine);
        o.light_grouping = self.light_grouping.unwrap_or(o.light_grouping);
        o.zone_basis = self.zone_basis.unwrap_or(o.zone_basis);
        o.discretization_error = self.discretization_error.or(o.discretization_error);
        o.scattering_orders = self.scattering_orders.or(o.scattering_orders);
        scene.with_options(o)
    }
}
