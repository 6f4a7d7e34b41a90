//! Absorption and emission of surfaces, cells and panes.

use zonal_scene::thermal::blackbody_emissive_power;
use zonal_scene::{Bands, Light, Scene, ThermalCondition, bands};

/// The temperature, K, at which band fractions of elements of known net power are evaluated.
const FRACTION_TEMPERATURE: f64 = 1000.0;

/// Absorption and emission of a surface, a cell or a pane.
#[derive(Clone, Copy, Debug)]
pub(super) struct ElementOptics {
    /// Absorbed fraction of an event: 1 − ρ or 1 − Ω.
    pub absorptance: Bands,
    /// Extinction of a volume, 1/m; 1 for a surface.
    pub extinction: Bands,
    /// Emission of its own, W/m² or W/m³: negative where heat is withdrawn.
    pub emission: Bands,
    /// True where absorbed power is emitted again.
    pub reemits: bool,
    /// a_b(1 − ρ_b), or 4κ_b(1 − Ω_b)a_b: the fractions of emission by band.
    pub band_weights: Bands,
    /// Sum of the band weights: power emitted for σT⁴ = 1.
    pub total_weight: f64,
    /// σT⁴ where it is known, W/m².
    pub emissive_power: Option<f64>,
    /// Net power where it is known, W/m² or W/m³.
    pub net_power: f64,
}

impl ElementOptics {
    /// A surface (without extinction) or a volume that emits `light` in light mode, or has a thermal condition.
    fn new(
        absorptance: Bands,
        extinction: Option<Bands>,
        light: Bands,
        condition: Option<ThermalCondition>,
        scene: &Scene,
    ) -> ElementOptics {
        let measure = extinction.map_or([1.0; 3], |k| k.map(|k| 4.0 * k));
        let mut out = ElementOptics {
            absorptance,
            extinction: extinction.unwrap_or([1.0; 3]),
            emission: light,
            reemits: false,
            band_weights: [0.0; 3],
            total_weight: 1.0,
            emissive_power: None,
            net_power: 0.0,
        };
        let Some(thermal) = scene.thermal() else { return out };
        let grey = thermal.band_fractions.is_grey();
        let weigh =
            |a: Bands| bands(|b| if grey && b > 0 { 0.0 } else { a[b] * measure[b] * absorptance[b] });
        match condition {
            Some(ThermalCondition::Temperature(t)) => {
                let power = blackbody_emissive_power(t);
                let w = thermal.band_fractions.emissive_powers(power)[0];
                out.band_weights = weigh(w.map(|w| w / power));
                out.emission = out.band_weights.map(|s| s * power);
                out.emissive_power = Some(power);
            }
            Some(ThermalCondition::Flux(q) | ThermalCondition::Power(q)) => {
                out.band_weights = weigh(thermal.band_fractions.weights(FRACTION_TEMPERATURE));
                let all: f64 = out.band_weights.iter().sum();
                out.emission = out.band_weights.map(|s| if all > 0.0 { q * s / all } else { 0.0 });
                (out.reemits, out.net_power) = (all > 0.0, q);
            }
            None => out.emission = [0.0; 3],
        }
        out.total_weight = out.band_weights.iter().sum();
        out
    }

    /// True when all bands are equal.
    fn is_grey(&self) -> bool {
        equal_bands(self.absorptance) && equal_bands(self.extinction) && equal_bands(self.emission)
    }
}

fn equal_bands(v: Bands) -> bool {
    v[0] == v[1] && v[1] == v[2]
}

/// Absorption and emission of all elements of a scene.
pub(super) struct SceneOptics {
    pub surfaces: Vec<ElementOptics>,
    pub cells: Vec<ElementOptics>,
    pub panes: Vec<ElementOptics>,
    /// True where all bands are equal, so that only the first is simulated.
    pub one_band: bool,
}

impl SceneOptics {
    /// The optics of a scene whose surfaces have these areas, m².
    pub(super) fn new(scene: &Scene, areas: &[f64]) -> SceneOptics {
        let thermal = scene.thermal();
        let surfaces: Vec<ElementOptics> = (scene.surfaces().iter().enumerate())
            .map(|(i, s)| {
                let condition = thermal.map(|t| match t.surfaces[i] {
                    ThermalCondition::Power(p) => ThermalCondition::Flux(p / areas[i]),
                    other => other,
                });
                ElementOptics::new(s.reflectance.map(|r| 1.0 - r), None, s.emission, condition, scene)
            })
            .collect();
        let cells: Vec<ElementOptics> = scene.voxel_grid().map_or(Vec::new(), |m| {
            (0..m.len())
                .map(|c| {
                    let (k, a) = (m.extinction(c), m.albedo(c).map(|o| 1.0 - o));
                    let light = bands(|b| 4.0 * k[b] * a[b] * m.emission(c)[b] + m.source(c)[b]);
                    ElementOptics::new(a, Some(k), light, m.heat(c), scene)
                })
                .collect()
        });
        let panes: Vec<ElementOptics> = (scene.panes().iter().enumerate())
            .map(|(i, p)| {
                let a = p.albedo.map(|o| 1.0 - o);
                let light = bands(|b| 4.0 * p.extinction[b] * a[b] * p.emission[b]);
                ElementOptics::new(a, Some(p.extinction), light, thermal.map(|t| t.panes[i]), scene)
            })
            .collect();
        // One band suffices in grey thermal scenes, and in light scenes where all bands are equal.
        let grey_heat = thermal.is_some_and(|t| t.band_fractions.is_grey());
        let lights = scene.lights().iter().all(|l| match l {
            Light::Sun { irradiance, .. } => equal_bands(*irradiance),
            Light::Sky { radiance, .. } => equal_bands(*radiance),
            Light::Emitter { .. } => true,
        });
        let elements = surfaces.iter().chain(&cells).chain(&panes).all(ElementOptics::is_grey);
        let grey_light =
            thermal.is_none() && elements && lights && equal_bands(scene.surroundings().radiance);
        SceneOptics { surfaces, cells, panes, one_band: grey_heat || grey_light }
    }
}
