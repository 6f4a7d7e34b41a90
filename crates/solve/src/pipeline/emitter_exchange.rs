//! Direct light of emitters from exchange areas.
//!
//! The unreflected light of an emitter without texture at a zone is the product of the exchange areas F with the emission E of its patches j:
//!
//! ```text
//!     H_dir,i A_i = Σ_j F_ij E_j        G_dir,i κ_i V_i = Σ_j F_ij E_j        escaped = Σ_j F_j,sky E_j
//! ```
//!
//! the same quantity that shadow rays estimate. The dense and the spectral engine have F: closed forms and quadrature with error bounds for
//! unoccluded pairs, measured visibility elsewhere. The cost is one product with the operator, and the error is that of the factors. If this error is
//! within the share of the tolerance that shadow rays aim at, no ray is traced; otherwise both are computed, and the one with the smaller error over
//! all zones is used.

use crate::context::{BuiltEngine, SolveContext};
use crate::distribution::sum_order::SharedZones;
use crate::errors::closure_error::{error_of_fraction, unexplained_fractions};
use crate::operator::ErrorModel;
use crate::right_hand_side::direct_light::light_field::{DirectLight, LightField};
use crate::right_hand_side::direct_light::shadow_rays::ERROR_SHARE;
use crate::right_hand_side::surroundings::SurroundingsExchange;
use crate::settings::zone_power::interception_area;
use zonal_exchange::pair::{PairSettings, closure_target};
use zonal_scene::{Bands, Engine, Light, Scene, SceneError, Sides, Zones};

/// Relative difference between the areas of an emitter's facets and of its patches that rounding may cause.
const AREA_ROUNDING: f64 = 1e-6;

/// The lights of a scene whose direct light follows from exchange areas.
pub(crate) struct EmitterExchange {
    /// The surface of each light that is such an emitter.
    surfaces: Vec<Option<usize>>,
    /// True if no shadow ray can be more exact than the areas of the engine.
    is_exact: bool,
}

impl EmitterExchange {
    /// Finds these lights: emitters without texture whose facets are patches entirely, for an engine that has the exchange areas of single patches.
    pub(crate) fn of(
        scene: &Scene,
        zones: &Zones,
        engine: Engine,
        settings: PairSettings,
    ) -> EmitterExchange {
        let has_areas = engine != Engine::Rays && settings.volume_factors.is_none();
        let surface =
            |light: &Light| light.surface().filter(|s| has_areas && is_covered_by_patches(scene, zones, *s));
        EmitterExchange {
            surfaces: scene.lights().iter().map(surface).collect(),
            is_exact: engine == Engine::Spectral,
        }
    }

    /// The surface of light number `l`, if its direct light follows from exchange areas.
    pub(crate) fn surface(&self, l: usize) -> Option<usize> {
        self.surfaces.get(l).copied().flatten()
    }
}

/// True if a surface has no emission texture, and all of its facets are patches.
fn is_covered_by_patches(scene: &Scene, zones: &Zones, surface: usize) -> bool {
    let own = &scene.surfaces()[surface];
    if own.emission_texture.is_some() {
        return false;
    }
    let sides = if own.sides == Sides::Both && !own.solid { 2.0 } else { 1.0 };
    let facets = scene.facets().iter().filter(|f| f.surface == surface);
    let emitting: f64 = sides * facets.map(|f| f.plate.area()).sum::<f64>();
    let found: f64 = zones.patches.iter().filter(|p| p.surface == surface).map(|p| p.area).sum();
    (found - emitting).abs() <= AREA_ROUNDING * emitting
}

/// Emission of the patches of an emitter: strengths of all unknowns, and powers, W per band.
struct EmittedPower {
    strengths: Vec<Bands>,
    emitted: Bands,
    escaped: Bands,
    absorbed_backfaces: Bands,
    /// Standard error of the escaped power.
    escaped_error: Bands,
}

impl EmittedPower {
    /// Sums the emitted and escaping powers of the patches of `surface`.
    fn of(exchange: &PatchExchange, surface: usize) -> EmittedPower {
        let (zones, surroundings) = (exchange.zones.zones(), exchange.surroundings);
        let emission = exchange.scene.surfaces()[surface].emission;
        let mut strengths = vec![Bands::ZERO; exchange.operator.len()];
        let own = zones.patches.iter().enumerate().filter(|(_, p)| p.surface == surface);
        let (mut emitted, mut escaped, mut backs, mut square) =
            (Bands::ZERO, Bands::ZERO, Bands::ZERO, Bands::ZERO);
        for (j, p) in own {
            strengths[j] = emission;
            let error = if surroundings.rays > 0 {
                surroundings.escape_fraction_error(j, closure_target(zones, j))
            } else {
                Bands::ZERO
            };
            emitted += emission * p.area;
            escaped += emission * surroundings.sky_of(j);
            backs += emission * surroundings.backfaces_of(j);
            square += (emission * error * p.area).map(|x| x.powi(2));
        }
        EmittedPower { strengths, emitted, escaped, absorbed_backfaces: backs, escaped_error: square.sqrt() }
    }
}

/// The exchange of single patches with all zones.
pub(crate) struct PatchExchange<'a> {
    pub scene: &'a Scene,
    pub zones: SharedZones<'a>,
    pub operator: &'a dyn ErrorModel,
    /// The defect of each row that its errors do not explain ([`unexplained_fractions`]).
    pub fractions: &'a [Bands],
    pub surroundings: &'a SurroundingsExchange,
}

impl PatchExchange<'_> {
    /// Direct light of light number `l`, the emitter `surface`, from the exchange areas, or by `shadow_rays` if these are needed and their error is smaller.
    pub(crate) fn light_of_emitter(
        &self,
        l: usize,
        surface: usize,
        shadow_rays: impl FnOnce() -> Result<LightField, SceneError>,
    ) -> Result<LightField, SceneError> {
        let light = self.light_from_areas(l, surface);
        let error = relative_error(self.zones, &light);
        if error > ERROR_SHARE[0] * self.scene.options().tolerance {
            let sampled = shadow_rays()?;
            if relative_error(self.zones, &sampled) < error {
                return Ok(sampled);
            }
        }
        Ok(light)
    }

    fn light_from_areas(&self, l: usize, surface: usize) -> LightField {
        let (scene, zones) = (self.scene, self.zones.zones());
        let n = zones.len();
        let power = EmittedPower::of(self, surface);
        // Apply the operator to the emission.
        let mut incident = self.operator.apply(&power.strengths);
        let power_error = self.operator.error(&power.strengths).unwrap_or_default();
        let slope_power = incident.split_off(n);
        let (mut fields, mut error) = (incident, vec![Bands::ZERO; n]);
        for i in 0..n {
            let measure = zones.response(i).1;
            fields[i] = fields[i].map(|p| (p / measure).max(0.0));
            let e = power_error.get(i).copied().unwrap_or_default();
            error[i] = e / measure + self.fractions[i].zip_map(fields[i], error_of_fraction);
        }
        let (backs, lost) = (power.absorbed_backfaces, power.escaped_error);
        LightField {
            name: scene.lights()[l].name(scene.surfaces()).to_string(),
            fields,
            error,
            by_exchange: true,
            slope_power,
            emitted: power.emitted,
            escaped: power.escaped,
            absorbed_backfaces: backs,
            power_error: [Bands::ZERO, lost, if backs == Bands::ZERO { Bands::ZERO } else { lost }],
            ..LightField::default()
        }
    }
}

/// The larger of the relative errors of patches and of volume zones: root mean square error of the intercepted power over its root mean square.
fn relative_error(zones: SharedZones, light: &LightField) -> f64 {
    let patches = zones.patches.len();
    let sums: [[f64; 2]; 2] = zones.sum(|i| {
        let w = interception_area(&zones, i);
        let square = |x: Bands| (w * x).map(|x| x.powi(2)).sum();
        let own = [square(light.error_of(i)), square(light.fields[i])];
        if i < patches { [own, [0.0; 2]] } else { [[0.0; 2], own] }
    });
    let [patches, volumes] = sums.map(|[e, f]| if e > 0.0 { (e / f).sqrt() } else { 0.0 });
    patches.max(volumes)
}

/// The direct light of a context, completed by the lights from exchange areas; `None` if there are none. `shadow_rays` gives a light by shadow rays,
/// or an error if the observer interrupts the solve.
pub(crate) fn complete(
    context: &SolveContext,
    built: &BuiltEngine,
    surroundings: &SurroundingsExchange,
    emitters: &EmitterExchange,
    shadow_rays: impl Fn(usize) -> Result<LightField, SceneError>,
) -> Result<Option<DirectLight>, SceneError> {
    if !(0..context.direct.lights.len()).any(|l| emitters.surface(l).is_some()) {
        return Ok(None);
    }
    let fractions = unexplained_fractions(context.zones, &built.closure, surroundings);
    let exchange = PatchExchange {
        scene: context.scene,
        zones: context.shared_zones(),
        operator: built.operator.as_ref(),
        fractions: &fractions,
        surroundings,
    };
    let mut lights = context.direct.lights.clone();
    for (l, light) in lights.iter_mut().enumerate() {
        if let Some(surface) = emitters.surface(l) {
            *light = if emitters.is_exact {
                exchange.light_from_areas(l, surface)
            } else {
                exchange.light_of_emitter(l, surface, || shadow_rays(l))?
            };
        }
    }
    Ok(Some(DirectLight { lights }))
}
