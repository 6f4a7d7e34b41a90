//! The solver of thermal states: data of a geometry, current conditions and properties, and the factors, which are kept while they hold.

use super::assembly::{Assembly, ZoneRole};
use super::band_state::{BandProblem, BandState};
use super::band_system::{BandFactor, FactorKey, MatrixData};
use super::exchange_data::ExchangeData;
use super::known_powers::{Coupling, PowerResponse};
use super::thermal_state::ThermalState;
use crate::settings::DEFAULT_MEMORY_LIMIT;
use zonal_math::parallel;
use zonal_scene::thermal::blackbody_emissive_power;
use zonal_scene::{SceneError, ThermalCondition};

/// Emissive power of the first step for zones of known power where no temperature is known: that of 300 K, W/m².
const FIRST_EMISSIVE_POWER: f64 = 460.0;

/// Computes thermal states of one geometry (header of [`super`]).
///
/// Temperatures and powers cost O(n²) for each band; the first state and other emissivities cost a factorization, O(n³), for each band that they change, and so
/// does another set of zones with known power.
///
/// ```
/// use zonal_scene::{Mesh, NoProgress, Scene, ThermalCondition};
/// use zonal_solve::areas::exchange_areas::{ExchangeAreaSettings, ExchangeAreas};
/// use zonal_solve::state::{ExchangeData, StateSolver};
/// let walls = Mesh::room_walls([0.0; 3], [1.0; 3]).map(|wall| wall.temperature(300.0).emissivity(0.5));
/// let scene = Scene::builder().surfaces(walls).patch_size(1.0).build()?;
/// let areas = ExchangeAreas::compute(&scene, &ExchangeAreaSettings::default(), &NoProgress)?;
/// let mut solver = StateSolver::new(ExchangeData::new(&scene, &areas, &NoProgress)?)?;
/// for hot in [400.0, 500.0, 600.0] {
///     solver.set_condition(0, ThermalCondition::Temperature(hot))?;
///     let state = solver.solve()?;
///     assert!(state.net[0] > 0.0 && state.balance(solver.data()).abs() < 1e-6 * state.net[0]);
/// }
/// # Ok::<(), zonal_scene::SceneError>(())
/// ```
pub struct StateSolver {
    data: ExchangeData,
    /// The bands in which something is emitted, by temperatures or by lights.
    bands: Vec<usize>,
    /// For each of them, whether temperatures emit in it.
    emitting: Vec<bool>,
    /// The matrix of each of them; the first of equal ones.
    matrices: Vec<usize>,
    factors: Vec<BandFactor>,
    /// Kept while the reflectances and the zones of known power hold.
    response: Option<PowerResponse>,
}

impl StateSolver {
    /// A solver for the conditions and properties of the data.
    ///
    /// # Errors
    /// If an array has a wrong length or a value out of range.
    pub fn new(data: ExchangeData) -> Result<StateSolver, SceneError> {
        data.check()?;
        let all = data.band_fractions.emitting(data.bands);
        let is_lit = |b: usize| data.light.powers(b).iter().any(|p| *p > 0.0);
        let bands: Vec<usize> = (0..data.bands).filter(|&b| all[b] || is_lit(b)).collect();
        let matrices = distinct_matrices(&data, &bands);
        let emitting = bands.iter().map(|b| all[*b]).collect();
        Ok(StateSolver { data, bands, emitting, matrices, factors: Vec::new(), response: None })
    }

    /// The data with the current conditions and reflectances.
    #[must_use]
    pub fn data(&self) -> &ExchangeData {
        &self.data
    }

    /// Sets the thermal condition of a zone; a power is that of the zone, W. In a grey scene the factor holds as long as the zone keeps its kind: temperature, or flux.
    ///
    /// # Errors
    /// If the value is out of range.
    ///
    /// # Panics
    /// If there is no such zone.
    pub fn set_condition(&mut self, zone: usize, condition: ThermalCondition) -> Result<(), SceneError> {
        condition.check(|k| format!("zone {zone}.{k}"))?;
        self.data.conditions[zone] = match condition {
            ThermalCondition::Power(p) => ThermalCondition::Flux(p / self.data.sizes[zone]),
            other => other,
        };
        Ok(())
    }

    /// Sets the temperatures of all zones, K.
    ///
    /// # Errors
    /// If a temperature is out of range.
    ///
    /// # Panics
    /// If there are more temperatures than zones.
    pub fn set_temperatures(&mut self, kelvin: &[f64]) -> Result<(), SceneError> {
        let mut zones = kelvin.iter().enumerate();
        zones.try_for_each(|(i, t)| self.set_condition(i, ThermalCondition::Temperature(*t)))
    }

    /// Sets the temperature of the surroundings, K; none for cold ones. The stated error of the exchange with them is that of the scene.
    ///
    /// # Errors
    /// If the temperature is out of range.
    pub fn set_surroundings_temperature(&mut self, kelvin: Option<f64>) -> Result<(), SceneError> {
        if let Some(t) = kelvin {
            ThermalCondition::Temperature(t).check(|k| format!("surroundings.{k}"))?;
        }
        self.data.surroundings_temperature = kelvin;
        Ok(())
    }

    /// Sets the reflectance of a patch, or the albedo of a volume, 0 to 1: one value for all bands but that of sunlight, or one value for each band.
    ///
    /// # Errors
    /// If a value is out of range, or there are other numbers of values.
    ///
    /// # Panics
    /// If there is no such zone.
    pub fn set_reflectance(&mut self, zone: usize, reflectance: &[f64]) -> Result<(), SceneError> {
        let n = self.data.zone_count();
        let d = &mut self.data;
        if !reflectance.iter().all(|r| (0.0..=1.0).contains(r)) {
            let what = "the reflectance is out of range; give values from 0 to 1";
            return Err(SceneError::new(format!("zone {zone}.reflectance"), what));
        }
        let bands = match reflectance.len() {
            count if count == d.bands => d.bands,
            1 => d.bands - usize::from(d.has_solar_band),
            count => {
                let what = format!(
                    "there are {count} values and {} bands; give one value, or one for each",
                    d.bands
                );
                return Err(SceneError::new(format!("zone {zone}.reflectance"), what));
            }
        };
        for b in 0..bands {
            let (old, new) = (&mut d.reflectances[b * n + zone], reflectance[b.min(reflectance.len() - 1)]);
            if *old != new {
                *old = new;
                self.response = None;
            }
        }
        Ok(())
    }

    /// The state of the current conditions.
    ///
    /// # Errors
    /// If the level of the temperatures is undetermined, if a zone cannot give its power, if the temperatures of the zones of known power cannot be found, or if a flux is
    /// not a finite number.
    pub fn solve(&mut self) -> Result<ThermalState, SceneError> {
        let roles = self.roles();
        self.check_conditions(&roles)?;
        let factors = self.factorize(&roles)?;
        let emissive = self.known_emissive_powers();
        let mut problems = self.problems(&roles, &factors, &emissive);
        let coupled: Vec<usize> = (0..roles.len()).filter(|&i| roles[i] == ZoneRole::Coupled).collect();
        if coupled.is_empty() {
            let mut states: Vec<BandState> = parallel::map(&problems, BandProblem::solve);
            return self.finish(&roles, emissive, &mut states);
        }
        check_memory(self.bands.len(), coupled.len())?;
        let kept = self.response.as_ref().is_some_and(|r| r.zones == coupled);
        let computed = (!kept).then(|| PowerResponse::new(&problems, coupled));
        let Some(response) = computed.as_ref().or(self.response.as_ref()) else { return Err(not_finite()) };
        let coupling = Coupling {
            response,
            fractions: &self.data.band_fractions,
            bands: (&self.bands, self.data.bands),
            weights: self.absorption_weights(&problems, &response.zones),
        };
        // Find the temperatures, and solve each band with their emission.
        let q: Vec<f64> = response.zones.iter().map(|&i| power_of(self.data.conditions[i])).collect();
        let found = coupling.solve(&problems, &q, first_emissive_power(&emissive))?;
        let mut all = emissive;
        response.zones.iter().zip(&found).for_each(|(i, e)| all[*i] = *e);
        let powers = self.emissive_powers(&all);
        for ((s, problem), weights) in problems.iter_mut().enumerate().zip(&coupling.weights) {
            for (k, i) in response.zones.iter().enumerate() {
                problem.sources[*i] = weights[k][1] * powers[*i][self.bands[s]][0];
            }
        }
        let mut states: Vec<BandState> = parallel::map(&problems, BandProblem::solve);
        coupling.add_reemission(&problems, &found, &mut states);
        drop(problems);
        let state = self.finish(&roles, all, &mut states);
        self.response = computed.or(self.response.take());
        state
    }

    /// The state of solved bands with black emissive powers, W/m²; NaN where they are to be found.
    fn finish(
        &self,
        roles: &[ZoneRole],
        emissive: Vec<f64>,
        states: &mut [BandState],
    ) -> Result<ThermalState, SceneError> {
        let powers = self.emissive_powers(&emissive);
        let matrices = self.matrices.iter().map(|m| MatrixData::of(&self.data, *m)).collect();
        let assembly = Assembly { data: &self.data, bands: &self.bands, matrices, roles, emissive, powers };
        let mut state = assembly.assemble(states);
        if assembly.widen_by_balance(&state, states) {
            state = assembly.assemble(states);
        }
        let finite = |list: &[f64]| list.iter().all(|x| x.is_finite());
        if finite(&state.net) && finite(&state.incident) && state.surroundings.is_finite() {
            return Ok(state);
        }
        Err(not_finite())
    }

    /// Whether a zone absorbs in a solved band.
    fn absorbs(&self, s: usize, zone: usize) -> bool {
        let (d, n) = (&self.data, self.data.zone_count());
        d.direct.closure[self.matrices[s] * n + zone] > 0.0 && d.reflectance(self.bands[s], zone) < 1.0
    }

    /// Whether a zone absorbs in a band in which temperatures emit.
    fn emits(&self, zone: usize) -> bool {
        (0..self.bands.len()).any(|s| self.emitting[s] && self.absorbs(s, zone))
    }

    fn roles(&self) -> Vec<ZoneRole> {
        let is_grey = self.data.band_fractions.is_grey();
        let role = |(i, condition): (usize, &ThermalCondition)| match condition {
            ThermalCondition::Temperature(_) => ZoneRole::Temperature,
            _ if is_grey => ZoneRole::White,
            _ if self.emits(i) => ZoneRole::Coupled,
            _ => ZoneRole::Reflector,
        };
        self.data.conditions.iter().enumerate().map(role).collect()
    }

    fn check_conditions(&self, roles: &[ZoneRole]) -> Result<(), SceneError> {
        let (d, n) = (&self.data, self.data.zone_count());
        let place = |i: usize| format!("zone {i} of '{}'", d.names[d.name_of_zone[i]]);
        let mute = |i: usize| roles[i] != ZoneRole::Temperature && !self.emits(i);
        if let Some(i) = (0..n).find(|&i| mute(i) && power_of(d.conditions[i]) != 0.0) {
            let what = "a zone that absorbs nothing can give no power; raise its emissivity, or give 0";
            return Err(SceneError::new(place(i), what));
        }
        let heated = |i: usize| (0..self.bands.len()).any(|s| !self.emitting[s] && self.absorbs(s, i));
        if let Some(i) = (0..n).find(|&i| mute(i) && heated(i)) {
            let what = "the zone absorbs sunlight and emits nothing, so that it has no temperature; raise its emissivity, or give it a temperature";
            return Err(SceneError::new(place(i), what));
        }
        let s = &d.surroundings;
        let closed = s.areas.iter().chain(&s.backfaces).all(|x| *x == 0.0);
        if closed && !(0..n).any(|i| roles[i] == ZoneRole::Temperature && self.emits(i)) {
            let what = "the level of the temperatures is undetermined: the scene is closed and nothing that absorbs has a known temperature; give some zone a temperature";
            return Err(SceneError::new("temperature", what));
        }
        Ok(())
    }

    /// Computes the factors that do not hold any more; returns that of each solved band. Bands with equal areas and reflectances share one.
    fn factorize(&mut self, roles: &[ZoneRole]) -> Result<Vec<usize>, SceneError> {
        let mut kept = std::mem::take(&mut self.factors);
        let (mut factors, mut of_band): (Vec<BandFactor>, Vec<usize>) = (Vec::new(), Vec::new());
        for (band, matrix) in self.bands.iter().zip(&self.matrices) {
            let of_zone = |(i, role): (usize, &ZoneRole)| match role {
                ZoneRole::White => 1.0,
                _ => self.data.reflectance(*band, i),
            };
            let key =
                FactorKey { matrix: *matrix, reflected: roles.iter().enumerate().map(of_zone).collect() };
            if let Some(k) = factors.iter().position(|f| f.key == key) {
                of_band.push(k);
                continue;
            }
            let factor = match kept.iter().position(|f| f.key == key) {
                Some(k) => kept.remove(k),
                None => {
                    check_memory(factors.len() + kept.len() + 1, roles.len())?;
                    let what = "nothing absorbs in some band, so that its radiosity is undetermined; raise an emissivity";
                    let factor = BandFactor::new(&MatrixData::of(&self.data, *matrix), key);
                    factor.ok_or_else(|| SceneError::new("emissivity", what))?
                }
            };
            of_band.push(factors.len());
            factors.push(factor);
        }
        self.factors = factors;
        Ok(of_band)
    }

    /// E of each zone, W/m²; NaN where the power is known.
    fn known_emissive_powers(&self) -> Vec<f64> {
        let of_zone = |c: &ThermalCondition| match c {
            ThermalCondition::Temperature(t) => blackbody_emissive_power(*t),
            ThermalCondition::Flux(_) | ThermalCondition::Power(_) => f64::NAN,
        };
        self.data.conditions.iter().map(of_zone).collect()
    }

    /// w and dw/dE of each zone in every band; zeros where E is not known.
    fn emissive_powers(&self, e: &[f64]) -> Vec<Vec<[f64; 2]>> {
        let d = &self.data;
        let of_zone = |i: usize| {
            let e = e[i];
            if e.is_nan() {
                vec![[0.0; 2]; d.bands]
            } else {
                d.band_fractions.emissive_powers(d.band_fractions.kind(i), e, d.bands)
            }
        };
        parallel::collect(e.len(), of_zone)
    }

    /// m a and a of zones in each solved band.
    fn absorption_weights(&self, problems: &[BandProblem], zones: &[usize]) -> Vec<Vec<[f64; 2]>> {
        let of_band = |(p, b): (&BandProblem, &usize)| {
            let of_zone = |i: &usize| {
                let a = 1.0 - self.data.reflectance(*b, *i);
                [p.m.c[*i] / self.data.sizes[*i] * a, a]
            };
            zones.iter().map(of_zone).collect()
        };
        problems.iter().zip(&self.bands).map(of_band).collect()
    }

    /// The equations of the solved bands for black emissive powers; zones where they are not known emit nothing, or their power if they are white.
    fn problems(&self, roles: &[ZoneRole], factors: &[usize], emissive: &[f64]) -> Vec<BandProblem<'_>> {
        let (d, n) = (&self.data, self.data.zone_count());
        let powers = self.emissive_powers(emissive);
        let outside = d.surroundings_temperature.map_or(0.0, blackbody_emissive_power);
        let outside = d.band_fractions.emissive_powers(0, outside, d.bands);
        let of_band = |s: usize| {
            let (b, m) = (self.bands[s], MatrixData::of(d, self.matrices[s]));
            let source = |i: usize| match roles[i] {
                ZoneRole::Temperature => (1.0 - d.reflectance(b, i)) * powers[i][b][0],
                ZoneRole::White if m.c[i] == 0.0 => 0.0,
                ZoneRole::White => power_of(d.conditions[i]) * d.sizes[i] / m.c[i],
                ZoneRole::Coupled | ZoneRole::Reflector => 0.0,
            };
            BandProblem {
                m,
                factor: &self.factors[factors[s]],
                light: d.light.of_band(b, n),
                light_power_error: d.light.powers(b)[4],
                sources: (0..n).map(source).collect(),
                sky: outside[b][0],
            }
        };
        (0..self.bands.len()).map(of_band).collect()
    }
}

/// Refuses more than the default memory limit for square matrices of `rows` rows.
fn check_memory(matrices: usize, rows: usize) -> Result<(), SceneError> {
    let bytes = (matrices as u64).saturating_mul((rows as u64).saturating_mul(rows as u64)).saturating_mul(8);
    if bytes <= DEFAULT_MEMORY_LIMIT {
        return Ok(());
    }
    let [needed, allowed] = [bytes, DEFAULT_MEMORY_LIMIT].map(|b| b as f64 / 1e9);
    let what = format!(
        "the matrices of a state of {rows} zones need {needed:.3} GB, more than the {allowed:.3} GB allowed; use larger patches, fewer cells or fewer bands, or zonal solve"
    );
    Err(SceneError::out_of_memory("memory", what))
}

/// The matrix of each band; the first of those with equal numbers.
fn distinct_matrices(data: &ExchangeData, bands: &[usize]) -> Vec<usize> {
    let mut distinct: Vec<usize> = Vec::new();
    let matrix = |b: &usize| {
        let own = (*b).min(data.matrices - 1);
        let equal = |k: &usize| *k == own || MatrixData::of(data, *k) == MatrixData::of(data, own);
        let first = distinct.iter().copied().find(equal).unwrap_or(own);
        if first == own && !distinct.contains(&own) {
            distinct.push(own);
        }
        first
    };
    bands.iter().map(matrix).collect()
}

/// The known power of a condition, W/m² or W/m³; 0 of a temperature.
fn power_of(condition: ThermalCondition) -> f64 {
    match condition {
        ThermalCondition::Temperature(_) => 0.0,
        ThermalCondition::Flux(q) | ThermalCondition::Power(q) => q,
    }
}

/// The mean of the known emissive powers, W/m².
fn first_emissive_power(emissive: &[f64]) -> f64 {
    let known = || emissive.iter().filter(|e| !e.is_nan());
    match known().count() {
        0 => FIRST_EMISSIVE_POWER,
        count => known().sum::<f64>() / count as f64,
    }
}

fn not_finite() -> SceneError {
    let what = "a flux is not a finite number: areas, extinctions or powers differ by too many orders of magnitude; bring them closer together";
    SceneError::new("solve", what)
}
