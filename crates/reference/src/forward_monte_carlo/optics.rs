//! Absorption and emission of surfaces, cells and panes.

use zonal_scene::thermal::blackbody_emissive_power;
use zonal_scene::{Band, Bands, Light, Scene, ThermalCondition};

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
        let measure = extinction.map_or(Bands::ONE, |k| 4.0 * k);
        let mut out = ElementOptics {
            absorptance,
            extinction: extinction.unwrap_or(Bands::ONE),
            emission: light,
            reemits: false,
            band_weights: Bands::ZERO,
            total_weight: 1.0,
            emissive_power: None,
            net_power: 0.0,
        };
        let Some(thermal) = scene.thermal() else { return out };
        let grey = thermal.band_fractions.is_grey();
        let weigh = |a: Bands| {
            Bands::from_fn(
                |b| if grey && b > Band::first() { 0.0 } else { a[b] * measure[b] * absorptance[b] },
            )
        };
        match condition {
            Some(ThermalCondition::Temperature(t)) => {
                let power = blackbody_emissive_power(t);
                let w = thermal.band_fractions.emissive_powers(power)[0];
                out.band_weights = weigh(w / power);
                out.emission = out.band_weights * power;
                out.emissive_power = Some(power);
            }
            Some(ThermalCondition::Flux(q) | ThermalCondition::Power(q)) => {
                out.band_weights = weigh(thermal.band_fractions.grey_gas_weights(FRACTION_TEMPERATURE));
                let all = out.band_weights.sum();
                out.emission = out.band_weights.map(|s| if all > 0.0 { q * s / all } else { 0.0 });
                (out.reemits, out.net_power) = (all > 0.0, q);
            }
            None => out.emission = Bands::ZERO,
        }
        out.total_weight = out.band_weights.sum();
        out
    }

    /// True when all bands are equal.
    fn is_grey(&self) -> bool {
        self.absorptance.is_grey() && self.extinction.is_grey() && self.emission.is_grey()
    }
}

/// Absorption and emission of all elements of a scene.
pub(super) struct WalkOptics {
    pub surfaces: Vec<ElementOptics>,
    pub cells: Vec<ElementOptics>,
    pub panes: Vec<ElementOptics>,
    /// True where all bands are equal, so that only the first is simulated.
    pub one_band: bool,
}

impl WalkOptics {
    /// The optics of a scene whose surfaces have these areas, m².
    pub(super) fn new(scene: &Scene, areas: &[f64]) -> WalkOptics {
        let thermal = scene.thermal();
        let surfaces: Vec<ElementOptics> = (scene.surfaces().iter().enumerate())
            .map(|(i, s)| {
                let condition = thermal.map(|t| match t.surfaces[i] {
                    ThermalCondition::Power(p) => ThermalCondition::Flux(p / areas[i]),
                    other => other,
                });
                ElementOptics::new(1.0 - s.reflectance, None, s.emission, condition, scene)
            })
            .collect();
        let cells: Vec<ElementOptics> = scene.voxel_grid().map_or(Vec::new(), |m| {
            (0..m.len())
                .map(|c| {
                    let (k, a) = (m.extinction(c), 1.0 - m.albedo(c));
                    let light = 4.0 * k * a * m.emission(c) + m.source(c);
                    ElementOptics::new(a, Some(k), light, m.heat(c), scene)
                })
                .collect()
        });
        let panes: Vec<ElementOptics> = (scene.panes().iter().enumerate())
            .map(|(i, p)| {
                let a = 1.0 - p.albedo;
                let light = 4.0 * p.extinction * a * p.emission;
                ElementOptics::new(a, Some(p.extinction), light, thermal.map(|t| t.panes[i]), scene)
            })
            .collect();
        // One band suffices in grey thermal scenes, and in light scenes where all bands are equal.
        let grey_heat = thermal.is_some_and(|t| t.band_fractions.is_grey());
        let lights = scene.lights().iter().all(Light::is_grey);
        let elements = surfaces.iter().chain(&cells).chain(&panes).all(ElementOptics::is_grey);
        let grey_light = thermal.is_none() && elements && lights && scene.surroundings().radiance.is_grey();
        WalkOptics { surfaces, cells, panes, one_band: grey_heat || grey_light }
    }
    /// The bands that are simulated.
    pub(super) fn simulated_bands(&self) -> impl Iterator<Item = Band> {
        Band::all().take(if self.one_band { 1 } else { Band::count() })
    }
    /// The simulated band that stands for `band`.
    pub(super) fn simulated_band(&self, band: Band) -> Band {
        if self.one_band { Band::first() } else { band }
    }
}
