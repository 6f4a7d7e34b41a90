//! Direct light of suns, skies and emitters on the zones: a constant part of all thermal states of a geometry.
//!
//! In the zonal equations it adds to the incident flux, h = h' + d, and its first reflection to the sources, B = s + r (h' + d).

use super::ray_tracing::RayTracing;
use crate::errors::direct_error::light_power_errors;
use crate::pipeline::BandBlock;
use crate::pipeline::emitter_exchange::{EmitterExchange, PatchExchange};
use crate::right_hand_side::direct_light::LightField;
use crate::right_hand_side::direct_light::light_field::DirectLight;
use crate::settings::SolveSettings;
use zonal_scene::{Band, Engine, SceneError, Zones};

/// Numbers of a band in [`LightData::powers`].
pub(super) const POWERS: usize = 5;

/// Direct light, band after band; empty lists without lights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightData {
    /// d of each zone: H of patches, G/4 of volumes, W/m².
    pub incident: Vec<f64>,
    /// Its error, W/m².
    pub error: Vec<f64>,
    /// Power that suns and skies send in, that emitters emit, that leaves unscattered, that ends on black backs, and the error of all these, W.
    pub powers: Vec<f64>,
}

impl LightData {
    /// The powers of a band; zeros without lights.
    pub(super) fn powers(&self, band: usize) -> [f64; POWERS] {
        let own = self.powers.get(band * POWERS..(band + 1) * POWERS);
        own.and_then(|p| p.try_into().ok()).unwrap_or_default()
    }

    /// d and its error of all zones in a band; empty without lights.
    pub(super) fn of_band(&self, band: usize, zones: usize) -> [&[f64]; 2] {
        let rows = band * zones..(band + 1) * zones;
        [&self.incident, &self.error].map(|list| list.get(rows.clone()).unwrap_or_default())
    }

    /// Adds the first `bands` bands of a block with these zones.
    pub(super) fn append(&mut self, light: &DirectLight, zones: &Zones, bands: usize) {
        let share = |i: usize| if i < zones.patches.len() { 1.0 } else { 0.25 };
        let known = |x: f64| if x.is_nan() { f64::INFINITY } else { x.abs() };
        let [sent, escaped, backs] = light_power_errors(light);
        for b in Band::all().take(bands) {
            let of_zone = |i: usize, value: &dyn Fn(&LightField) -> f64| {
                share(i) * light.lights.iter().map(value).sum::<f64>()
            };
            self.incident.extend((0..zones.len()).map(|i| of_zone(i, &|l| l.fields[i][b])));
            self.error.extend((0..zones.len()).map(|i| known(of_zone(i, &|l| l.error_of(i)[b]))));
            let total = |power: &dyn Fn(&LightField) -> f64| light.lights.iter().map(power).sum::<f64>();
            self.powers.extend([
                total(&|l| l.incoming[b]),
                total(&|l| l.emitted[b]),
                total(&|l| l.escaped[b]),
                total(&|l| l.absorbed_backfaces[b]),
                known(sent[b].hypot(escaped[b]).hypot(backs[b])),
            ]);
        }
    }
}

/// Direct light of all lights in one block of bands: by shadow rays, or of emitters from the exchange areas.
pub(super) fn direct_light(
    rays: &RayTracing,
    exchange: &PatchExchange,
    settings: &SolveSettings,
) -> Result<DirectLight, SceneError> {
    let BandBlock { scene, zones, .. } = rays.part;
    let emitters = EmitterExchange::of(scene, zones, Engine::Dense, settings.pair_settings);
    let one = |l: usize| match emitters.surface(l) {
        Some(surface) => exchange.light_of_emitter(l, surface, || rays.light(l, settings)),
        None => rays.light(l, settings),
    };
    Ok(DirectLight { lights: (0..scene.lights().len()).map(one).collect::<Result<_, _>>()? })
}
