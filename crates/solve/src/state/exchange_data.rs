//! What a geometry and its properties contribute to thermal states, as plain arrays.

use super::area_operator::AreaOperator;
use crate::errors::closure_error::unexplained_fractions;
use crate::exchange_areas::{AreaMatrices, ExchangeAreas};
use crate::operator::ExchangeOperator;
use crate::report::closure;
use crate::settings::{DEFAULT_MEMORY_LIMIT, SolveSettings, check_interrupted};
use crate::surroundings::{self, SurroundingsExchange};
use crate::thermal::zone_conditions;
use zonal_exchange::pair::{closure_target, scaled_radiosity_coefficient};
use zonal_scene::{
    Band, BandFractions, Bands, FaceMesh, Progress, Scene, SceneError, Thermal, ThermalCondition,
};
use zonal_transport::Transport;

/// Exchange with the surroundings and closure of the rows, matrix after matrix, one number for each zone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurroundingsData {
    /// Exchange areas with the surroundings F_s, m², scaled with the rows.
    pub areas: Vec<f64>,
    /// Their standard errors, m².
    pub radii: Vec<f64>,
    /// Exchange areas with the black backs of one-sided surfaces, m², scaled with the rows.
    pub backfaces: Vec<f64>,
    /// Scaling d of the rows that restores closure: F' = d F d; 1 where closure is not restored.
    pub scaling: Vec<f64>,
    /// Error of the incident power by closure, relative to it; infinite if unknown.
    pub closure_error: Vec<f64>,
}

/// Exchange areas, properties and conditions of all zones of a thermal scene.
#[derive(Clone, Debug, Default)]
pub struct ExchangeData {
    /// Number of matrices: 1, or one for each band.
    pub matrices: usize,
    /// Number of zones that are patches; the others are volumes.
    pub patches: usize,
    /// Direct exchange areas, radii and c, m².
    pub direct: AreaMatrices,
    /// Surroundings and closure.
    pub surroundings: SurroundingsData,
    /// A in m² or V in m³ of each zone.
    pub sizes: Vec<f64>,
    /// ρ or Ω of each zone.
    pub reflectances: Vec<Bands>,
    /// Thermal condition of each zone; never the power of a whole surface.
    pub conditions: Vec<ThermalCondition>,
    /// The fraction of the emission in each band.
    pub band_fractions: BandFractions,
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

impl ExchangeData {
    /// The data of exchange areas of a scene in thermal mode: samples the surroundings, and measures or restores closure as a solve does.
    ///
    /// # Errors
    /// If the scene is in light mode or has nodes or convection, or if the observer interrupts the computation.
    pub fn new(
        scene: &Scene,
        areas: &ExchangeAreas,
        progress: &dyn Progress,
    ) -> Result<ExchangeData, SceneError> {
        let Some(thermal) = scene.thermal() else {
            return Err(SceneError::new(
                "mode",
                "thermal states belong to mode = \"thermal\"; give the scene temperatures or powers",
            ));
        };
        check_plain(scene, thermal)?;
        let zones = &areas.zones;
        let n = zones.len();
        let transport = Transport::new(scene);
        let settings = SolveSettings::new(DEFAULT_MEMORY_LIMIT, progress);
        let mut exterior = surroundings::stage::measure(scene, zones, &transport, &settings);
        drop(transport);
        check_interrupted(progress)?;
        let (surroundings, direct) = closed_rows(scene, areas, &mut exterior);
        let faces = scene.faces();
        let face = |i: usize| zones.patches.get(i).and_then(|p| faces.face_of(p.facet));
        let (conditions, reflectances) = zone_conditions(scene, zones);
        Ok(ExchangeData {
            matrices: areas.matrices,
            patches: zones.voxel_offset(),
            direct,
            surroundings,
            sizes: (0..n).map(|i| zones.response(i).1).collect(),
            reflectances,
            conditions,
            band_fractions: thermal.band_fractions.clone(),
            surroundings_temperature: thermal.surroundings,
            names: areas.names.clone(),
            name_of_zone: areas.name_of_zone.clone(),
            meshes: faces.meshes.clone(),
            face_of_zone: (0..n).map(face).collect(),
        })
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
        let (pairs, rows) = (m.saturating_mul(n.saturating_mul(n)), m.saturating_mul(n));
        let s = &self.surroundings;
        let wrong = |name: &str| {
            let what = "this array has another length than the zones require, or a value out of range; write the exchange areas again";
            Err(SceneError::new(name, what))
        };
        if m != 1 && m != Band::count() || n == 0 || self.patches > n {
            return wrong("zone_size");
        }
        for (name, list, length) in [
            ("exchange_areas", &self.direct.areas, pairs),
            ("error_radius", &self.direct.radii, pairs),
            ("closure", &self.direct.closure, rows),
            ("surroundings_areas", &s.areas, rows),
            ("surroundings_radius", &s.radii, rows),
            ("backface_areas", &s.backfaces, rows),
            ("closure_scaling", &s.scaling, rows),
            ("closure_error", &s.closure_error, rows),
            ("zone_size", &self.sizes, n),
        ] {
            let may_be_negative = name == "exchange_areas";
            if list.len() != length || list.iter().any(|x| x.is_nan() || *x < 0.0 && !may_be_negative) {
                return wrong(name);
            }
        }
        if self.sizes.contains(&0.0) {
            return wrong("zone_size");
        }
        if self.reflectances.len() != n
            || self.reflectances.iter().flatten().any(|r| !(0.0..=1.0).contains(r))
        {
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
        match self.name_of_zone.len() == n && self.name_of_zone.iter().all(|k| *k < self.names.len()) {
            true => self.band_fractions.check(),
            false => wrong("name_of_zone"),
        }
    }
}

/// Refuses scenes that have more than temperatures and powers.
fn check_plain(scene: &Scene, thermal: &Thermal) -> Result<(), SceneError> {
    if scene.bands().triples() > 1 {
        let what = "thermal states have up to three bands; solve the scene, or give it fewer bands";
        return Err(SceneError::new("bands", what));
    }
    if !scene.lights().is_empty() {
        return Err(SceneError::new(
            "light",
            "thermal states have no lights; solve the scene, or remove the lights",
        ));
    }
    if thermal.network.is_some() {
        return Err(SceneError::new(
            "node",
            "thermal states have no nodes and no convection; solve the scene, or give temperatures and powers",
        ));
    }
    Ok(())
}

/// Measures or restores the closure of the rows; the surroundings are scaled with them.
fn closed_rows(
    scene: &Scene,
    areas: &ExchangeAreas,
    exterior: &mut SurroundingsExchange,
) -> (SurroundingsData, AreaMatrices) {
    let zones = &areas.zones;
    let n = zones.len();
    let mut operator = AreaOperator::new(areas);
    let rows = match scene.restores_closure() {
        true => closure::restore(&mut operator, zones, exterior),
        false => closure::measure(&operator, zones, exterior),
    };
    let fractions = unexplained_fractions(zones, &rows, exterior);
    debug_assert_eq!(operator.len(), n);
    let c: Vec<Bands> = (0..n).map(|i| scaled_radiosity_coefficient(zones, i)).collect();
    let per_matrix = |of: &dyn Fn(usize) -> Bands| -> Vec<f64> {
        Band::all().take(areas.matrices).flat_map(|b| (0..n).map(move |i| of(i)[b])).collect()
    };
    let target = |i: usize| closure_target(zones, i);
    let data = SurroundingsData {
        areas: per_matrix(&|i| c[i] * exterior.sky_of(i)),
        radii: per_matrix(&|i| c[i] * target(i) * exterior.escape_fraction_error(i, target(i))),
        backfaces: per_matrix(&|i| c[i] * exterior.backfaces_of(i)),
        scaling: per_matrix(&|i| operator.scaling[i]),
        closure_error: per_matrix(&|i| {
            fractions[i].map(|x| if x.is_nan() { f64::INFINITY } else { x.abs() })
        }),
    };
    (data, areas.direct.clone())
}
