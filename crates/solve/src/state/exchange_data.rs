//! What a geometry and its properties contribute to thermal states, as plain arrays.

use super::block_data::BlockData;
use super::light_data::{LightData, POWERS};
use super::surroundings_data::SurroundingsData;
use super::zone_fractions::ZoneFractions;
use crate::areas::exchange_areas::{AreaMatrices, ExchangeAreas};
use crate::settings::{DEFAULT_MEMORY_LIMIT, SolveSettings, check_interrupted};

use zonal_scene::{
    FaceMesh, MAX_BANDS, Progress, Scene, SceneError, SurfaceEmissivity, Thermal, ThermalCondition,
};
use zonal_transport::Transport;

/// Exchange areas, properties and conditions of all zones of a thermal scene.
#[derive(Clone, Debug, Default)]
pub struct ExchangeData {
    /// Number of bands: 1 of a grey scene, else those of the scene.
    pub bands: usize,
    /// True if the last band is that of sunlight, in which no temperature emits.
    pub has_solar_band: bool,
    /// Number of matrices: 1, or at least one for each band.
    pub matrices: usize,
    /// Number of zones that are patches; the others are volumes.
    pub patches: usize,
    /// Direct exchange areas, radii and c, m².
    pub direct: AreaMatrices,
    /// Surroundings and closure.
    pub surroundings: SurroundingsData,
    /// Direct light.
    pub light: LightData,
    /// A in m² or V in m³ of each zone.
    pub sizes: Vec<f64>,
    /// ρ or Ω of each zone, band after band.
    pub reflectances: Vec<f64>,
    /// Thermal condition of each zone; never the power of a whole surface.
    pub conditions: Vec<ThermalCondition>,
    /// The fraction of the emission in each band.
    pub band_fractions: ZoneFractions,
    /// Temperature of the surroundings, K; `None` for cold surroundings.
    pub surroundings_temperature: Option<f64>,
    /// Names of the surfaces, of the medium and of the panes.
    pub names: Vec<String>,
    /// The name of each zone, as an index into `names`.
    pub name_of_zone: Vec<usize>,
    /// Mesh files.
    pub meshes: Vec<FaceMesh>,
    /// The face of each zone among the faces of all meshes.
    pub face_of_zone: Vec<Option<usize>>,
}

/// The thermal data of a scene that has thermal states.
///
/// # Errors
/// In light mode, and with nodes, convection or emissivities by temperature.
fn thermal_with_states(scene: &Scene) -> Result<&Thermal, SceneError> {
    let refused = |key: &str, what: &str| Err(SceneError::new(key, what));
    match scene.thermal() {
        None => refused(
            "mode",
            "thermal states belong to mode = \"thermal\"; give the scene temperatures or powers",
        ),
        Some(thermal) if thermal.network.is_some() => refused(
            "node",
            "thermal states have no nodes and no convection; use zonal solve for this scene, or give its surfaces temperatures or powers",
        ),
        Some(thermal) if thermal.emissivities.iter().any(SurfaceEmissivity::depends_on_temperature) => {
            refused(
                "emissivity",
                "thermal states have constant emissivities; use zonal solve for this scene, or give numbers in place of the tables",
            )
        }
        Some(thermal) => Ok(thermal),
    }
}

impl ExchangeData {
    /// The data of exchange areas of a scene in thermal mode: samples the surroundings and the lights, and measures or restores closure as a solve does.
    ///
    /// # Errors
    /// If [`ExchangeData::refusal`] has a reason, or if the observer interrupts the computation.
    pub fn new(
        scene: &Scene,
        areas: &ExchangeAreas,
        progress: &dyn Progress,
    ) -> Result<ExchangeData, SceneError> {
        let thermal = thermal_with_states(scene)?;
        let (zones, n) = (&areas.zones, areas.zone_count());
        let faces = scene.faces();
        let face = |i: usize| zones.patches.get(i).and_then(|p| faces.face_of(p.facet));
        let mut data = ExchangeData {
            bands: scene.bands().count(),
            has_solar_band: scene.bands().has_solar_band(),
            matrices: areas.matrices,
            patches: zones.patches.len(),
            direct: areas.direct.clone(),
            sizes: (0..n).map(|i| zones.response(i).1).collect(),
            surroundings_temperature: thermal.surroundings,
            names: areas.names.clone(),
            name_of_zone: areas.name_of_zone.clone(),
            meshes: faces.meshes.clone(),
            face_of_zone: (0..n).map(face).collect(),
            ..ExchangeData::default()
        };
        let settings = SolveSettings::new(DEFAULT_MEMORY_LIMIT, progress);
        let transport = Transport::new(scene);
        for (t, own) in scene.blocks().enumerate() {
            let mut block = BlockData::measure(&transport.with_bands(&own), areas, &settings)?;
            check_interrupted(progress)?;
            if let Some((entries, adjusted)) = block.adjusted.take() {
                data.direct.areas[entries].copy_from_slice(&adjusted);
            }
            if t == 0 {
                data.conditions.clone_from(&block.properties.conditions);
                data.band_fractions = ZoneFractions::of(scene, block.properties.kinds.clone());
            }
            data.append(block, own.window().len());
        }
        Ok(data)
    }

    /// Adds the first `bands` bands of a block.
    fn append(&mut self, block: BlockData, bands: usize) {
        let reflectances = &block.properties.reflectances;
        for b in 0..bands {
            self.reflectances.extend(reflectances.iter().map(|r| r.as_slice()[b]));
        }
        let (own, more) = (&mut self.surroundings, block.surroundings);
        own.areas.extend(more.areas);
        own.radii.extend(more.radii);
        own.backfaces.extend(more.backfaces);
        own.scaling.extend(more.scaling);
        own.closure_error.extend(more.closure_error);
        self.light.incident.extend(block.light.incident);
        self.light.error.extend(block.light.error);
        self.light.powers.extend(block.light.powers);
    }

    /// ρ or Ω of a zone in a band.
    #[must_use]
    pub fn reflectance(&self, band: usize, zone: usize) -> f64 {
        self.reflectances[band * self.zone_count() + zone]
    }

    /// Why a scene has no thermal states: it is in light mode, has nodes or convection, or emissivities by temperature. `None` if it has.
    #[must_use]
    pub fn refusal(scene: &Scene) -> Option<SceneError> {
        thermal_with_states(scene).err()
    }

    /// Number of zones.
    #[must_use]
    pub fn zone_count(&self) -> usize {
        self.sizes.len()
    }

    /// Number of faces of all meshes.
    #[must_use]
    pub fn face_count(&self) -> usize {
        self.meshes.iter().map(|m| m.faces).sum()
    }

    /// Refuses arrays of wrong lengths, indices that do not exist and values out of range.
    ///
    /// # Errors
    /// The name of the array.
    pub fn check(&self) -> Result<(), SceneError> {
        let (n, m) = (self.sizes.len(), self.matrices);
        let are_few =
            (1..=MAX_BANDS).contains(&self.bands) && (m == 1 || m >= self.bands && m <= MAX_BANDS + 2);
        if !are_few || n == 0 || self.patches > n || self.sizes.contains(&0.0) {
            return wrong("zone_size");
        }
        let is_wrong = |(name, list, length): &(&str, &Vec<f64>, usize)| {
            let may_be_negative = *name == "exchange_areas";
            list.len() != *length || list.iter().any(|x| x.is_nan() || *x < 0.0 && !may_be_negative)
        };
        if let Some((name, ..)) = self.arrays().iter().find(|a| is_wrong(a)) {
            return wrong(name);
        }
        if self.reflectances.iter().any(|r| *r > 1.0) {
            return wrong("reflectance");
        }
        if self.conditions.len() != n
            || self
                .conditions
                .iter()
                .any(|c| c.check(str::to_string).is_err() || matches!(c, ThermalCondition::Power(_)))
        {
            return wrong("condition");
        }
        let faces = self.face_count();
        if self.face_of_zone.len() != n || self.face_of_zone.iter().flatten().any(|f| *f >= faces) {
            return wrong("zone_face");
        }
        if self.name_of_zone.len() == n && self.name_of_zone.iter().all(|k| *k < self.names.len()) {
            self.band_fractions.check(n, self.bands)
        } else {
            wrong("name_of_zone")
        }
    }

    /// Names of the arrays of numbers in a file, the arrays, and the lengths that they must have.
    fn arrays(&self) -> [(&'static str, &Vec<f64>, usize); 13] {
        let (n, m, s) = (self.sizes.len(), self.matrices, &self.surroundings);
        let (pairs, rows) = (m.saturating_mul(n.saturating_mul(n)), m.saturating_mul(n));
        let by_band = self.bands * n;
        let lights = if self.light.incident.is_empty() { 0 } else { 1 };
        [
            ("exchange_areas", &self.direct.areas, pairs),
            ("error_radius", &self.direct.radii, pairs),
            ("closure", &self.direct.closure, rows),
            ("surroundings_areas", &s.areas, rows),
            ("surroundings_radius", &s.radii, rows),
            ("backface_areas", &s.backfaces, rows),
            ("closure_scaling", &s.scaling, rows),
            ("closure_error", &s.closure_error, rows),
            ("zone_size", &self.sizes, n),
            ("reflectance", &self.reflectances, by_band),
            ("light_incident", &self.light.incident, lights * by_band),
            ("light_error", &self.light.error, lights * by_band),
            ("light_power", &self.light.powers, lights * self.bands * POWERS),
        ]
    }
}

/// An array that does not fit.
fn wrong(name: &str) -> Result<(), SceneError> {
    let what = "this array has another length than the zones require, or a value out of range; write the exchange areas again";
    Err(SceneError::new(name, what))
}
