//! The solver of thermal states: data of a geometry, current conditions and properties, and the factor, which is kept while it holds.

use super::band_system::{BandFactor, MatrixData};
use super::exchange_data::ExchangeData;
use super::thermal_state::ThermalState;
use crate::errors::closure_error::error_of_fraction;
use zonal_scene::thermal::{blackbody_emissive_power, blackbody_temperature};
use zonal_scene::{Band, Bands, SceneError, ThermalCondition};

/// Residual of the balance, over the absorbed power, that rounding leaves.
const ROUNDING_OF_BALANCE: f64 = 1e-12;

/// Computes thermal states of one geometry (header of [`super`]).
///
/// Temperatures and powers cost O(n²); the first state, other emissivities and another set of zones with known power cost a factorization, O(n³).
///
/// ```
/// use zonal_scene::{Mesh, NoProgress, Scene, ThermalCondition};
/// use zonal_solve::exchange_areas::{ExchangeAreaSettings, ExchangeAreas};
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
    squared_radii: Vec<f64>,
    /// The factors, and for each solved band the index of its factor; none where they have to be computed.
    factors: Option<(Vec<BandFactor>, Vec<usize>)>,
}

/// The solution of one band.
struct BandState {
    band: Band,
    /// h and its error, W/m².
    incident: Vec<f64>,
    error: Vec<f64>,
    radiosity: Vec<f64>,
    /// Power from and to the surroundings, and to black backs, W; error of the escaping power.
    incoming: f64,
    escaped: f64,
    backfaces: f64,
    escaped_error: f64,
}

impl StateSolver {
    /// A solver for the conditions and properties of the data.
    ///
    /// # Errors
    /// If an array has a wrong length or a value out of range.
    pub fn new(data: ExchangeData) -> Result<StateSolver, SceneError> {
        data.check()?;
        let squared_radii = data.direct.radii.iter().map(|r| r * r).collect();
        Ok(StateSolver { data, squared_radii, factors: None })
    }

    /// The data with the current conditions and reflectances.
    #[must_use]
    pub fn data(&self) -> &ExchangeData {
        &self.data
    }

    /// Sets the thermal condition of a zone; a power is that of the zone, W. The factor holds as long as the zone keeps its kind: temperature, or flux.
    ///
    /// # Errors
    /// If the value is out of range.
    ///
    /// # Panics
    /// If there is no such zone.
    pub fn set_condition(&mut self, zone: usize, condition: ThermalCondition) -> Result<(), SceneError> {
        condition.check(|k| format!("zone {zone}.{k}"))?;
        let known = |c: &ThermalCondition| matches!(c, ThermalCondition::Temperature(_));
        let new = match condition {
            ThermalCondition::Power(p) => ThermalCondition::Flux(p / self.data.sizes[zone]),
            other => other,
        };
        if known(&self.data.conditions[zone]) != known(&new) {
            self.factors = None;
        }
        self.data.conditions[zone] = new;
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

    /// Sets the reflectance of a patch, or the albedo of a volume, 0 to 1 in each band.
    ///
    /// # Errors
    /// If a value is out of range, or bands of a grey scene differ.
    ///
    /// # Panics
    /// If there is no such zone.
    pub fn set_reflectance(&mut self, zone: usize, reflectance: Bands) -> Result<(), SceneError> {
        let grey = self.data.band_fractions.is_grey();
        if reflectance.any(|r| !(0.0..=1.0).contains(&r)) || grey && !reflectance.is_grey() {
            let what = "the reflectance is out of range; give values from 0 to 1, one in a grey scene";
            return Err(SceneError::new(format!("zone {zone}.reflectance"), what));
        }
        if self.data.reflectances[zone] != reflectance {
            self.data.reflectances[zone] = reflectance;
            self.factors = None;
        }
        Ok(())
    }

    /// The thermal state of the current conditions.
    ///
    /// # Errors
    /// If known powers couple several bands, if nothing in a closed scene fixes the level of the temperatures, if a zone that does not absorb has a power, or
    /// if a result is not a finite number.
    pub fn solve(&mut self) -> Result<ThermalState, SceneError> {
        // Parallel loops that start on a thread of the pool need no handing over.
        rayon::scope(|_| self.solve_on_worker())
    }

    fn solve_on_worker(&mut self) -> Result<ThermalState, SceneError> {
        self.check_conditions()?;
        let bands = self.bands();
        let (factors, of_band) = match self.factors.take() {
            Some(kept) => kept,
            None => self.factorize(&bands)?,
        };
        let solved = bands.iter().zip(&of_band);
        let mut states: Vec<BandState> = solved.map(|(b, k)| self.solve_band(*b, &factors[*k])).collect();
        self.factors = Some((factors, of_band));
        let mut state = self.assemble(&states);
        if self.widen_by_balance(&state, &mut states) {
            state = self.assemble(&states);
        }
        let finite = |list: &[f64]| list.iter().all(|x| x.is_finite());
        if finite(&state.net) && finite(&state.incident) && state.surroundings.is_finite() {
            return Ok(state);
        }
        let what = "a flux is not a finite number: areas, extinctions or powers differ by too many orders of magnitude; bring them closer together";
        Err(SceneError::new("solve", what))
    }

    /// The bands that are solved: the first of a grey scene, whose bands are equal.
    fn bands(&self) -> Vec<Band> {
        let count = if self.data.band_fractions.is_grey() { 1 } else { Band::count() };
        Band::all().take(count).collect()
    }

    fn matrix(&self, band: Band) -> MatrixData<'_> {
        let index = Band::all().position(|b| b == band).unwrap_or(0).min(self.data.matrices - 1);
        MatrixData::of(&self.data, &self.squared_radii, index)
    }

    fn has_temperature(&self, zone: usize) -> bool {
        matches!(self.data.conditions[zone], ThermalCondition::Temperature(_))
    }

    fn check_conditions(&self) -> Result<(), SceneError> {
        let (d, n) = (&self.data, self.data.zone_count());
        let unknown = (0..n).find(|&i| !self.has_temperature(i));
        if let (Some(i), false) = (unknown, d.band_fractions.is_grey()) {
            let what = "a known power couples the bands of this scene; give all zones temperatures, or solve the scene with zonal solve";
            return Err(SceneError::new(format!("zone {i} of '{}'", d.names[d.name_of_zone[i]]), what));
        }
        let absorbs = |i: usize| d.direct.closure[i] > 0.0 && d.reflectances[i].any(|r| r < 1.0);
        let mute = |i: usize| matches!(d.conditions[i], ThermalCondition::Flux(q) if q != 0.0) && !absorbs(i);
        if let Some(i) = (0..n).find(|&i| mute(i)) {
            let what = "a zone that absorbs nothing can give no power; raise its emissivity, or give 0";
            return Err(SceneError::new(format!("zone {i} of '{}'", d.names[d.name_of_zone[i]]), what));
        }
        let s = &d.surroundings;
        let closed = s.areas.iter().chain(&s.backfaces).all(|x| *x == 0.0);
        if closed && !(0..n).any(|i| self.has_temperature(i) && absorbs(i)) {
            let what = "the level of the temperatures is undetermined: the scene is closed and nothing that absorbs has a known temperature; give some zone a temperature";
            return Err(SceneError::new("temperature", what));
        }
        Ok(())
    }

    /// r̂ of a band: r of known temperatures, 1 of known powers.
    fn reflected(&self, band: Band) -> Vec<f64> {
        let of = |i: usize| if self.has_temperature(i) { self.data.reflectances[i][band] } else { 1.0 };
        (0..self.data.zone_count()).map(of).collect()
    }

    /// The factors of the bands; bands with equal areas and reflectances share one.
    fn factorize(&self, bands: &[Band]) -> Result<(Vec<BandFactor>, Vec<usize>), SceneError> {
        let (mut factors, mut of_band) = (Vec::new(), Vec::new());
        let mut last: Option<Vec<f64>> = None;
        for &band in bands {
            let reflected = self.reflected(band);
            if self.data.matrices > 1 || last.as_ref() != Some(&reflected) {
                let what = "nothing absorbs in some band, so that its radiosity is undetermined; raise an emissivity";
                let factor = BandFactor::new(&self.matrix(band), &reflected);
                factors.push(factor.ok_or_else(|| SceneError::new("emissivity", what))?);
            }
            of_band.push(factors.len() - 1);
            last = Some(reflected);
        }
        Ok((factors, of_band))
    }

    /// m of a zone: 1, or 4κ.
    fn weight(&self, m: &MatrixData, zone: usize) -> f64 {
        m.c[zone] / self.data.sizes[zone]
    }

    fn solve_band(&self, band: Band, factor: &BandFactor) -> BandState {
        let (d, m, n) = (&self.data, self.matrix(band), self.data.zone_count());
        let emissive = |t: f64| d.band_fractions.emissive_powers(blackbody_emissive_power(t))[0][band];
        let sky = d.surroundings_temperature.map_or(0.0, emissive);
        let source = |i: usize| match d.conditions[i] {
            _ if m.c[i] == 0.0 => 0.0,
            ThermalCondition::Temperature(t) => (1.0 - d.reflectances[i][band]) * emissive(t),
            ThermalCondition::Flux(q) | ThermalCondition::Power(q) => q / self.weight(&m, i),
        };
        let sources: Vec<f64> = (0..n).map(source).collect();
        let mut b = m.apply(&sources);
        b.iter_mut().zip(m.surroundings).for_each(|(b, s)| *b += s * sky);
        let power = factor.solve(&m, b);
        // `max` would drop a NaN.
        let positive = |x: f64| if x < 0.0 { 0.0 } else { x };
        let flux = |i: usize| if m.c[i] > 0.0 { positive(power[i] / m.c[i]) } else { 0.0 };
        let incident: Vec<f64> = (0..n).map(flux).collect();
        let reflected = self.reflected(band);
        let radiosity: Vec<f64> = (0..n).map(|i| sources[i] + reflected[i] * incident[i]).collect();
        let error = self.incident_errors(&m, factor, (&incident, &radiosity), sky);
        let total = |areas: &[f64]| areas.iter().zip(&radiosity).map(|(f, b)| f * b).sum::<f64>();
        let squares = m.surroundings_radii.iter().zip(&radiosity).map(|(r, b)| (r * b).powi(2));
        BandState {
            band,
            incoming: m.surroundings.iter().map(|f| f * sky).sum(),
            escaped: total(m.surroundings),
            backfaces: total(m.backfaces),
            escaped_error: squares.sum::<f64>().sqrt(),
            incident,
            error,
            radiosity,
        }
    }

    /// Errors of the incident flux with their reflection, W/m²; `sky` is the radiosity of the surroundings.
    fn incident_errors(
        &self,
        m: &MatrixData,
        factor: &BandFactor,
        (incident, radiosity): (&[f64], &[f64]),
        sky: f64,
    ) -> Vec<f64> {
        let n = incident.len();
        let factors = m.factor_errors(radiosity);
        let own = |i: usize| {
            let closure = error_of_fraction(m.closure_error[i], m.c[i] * incident[i]);
            (factors[i] + closure).hypot(m.surroundings_radii[i] * sky)
        };
        let mut errors: Vec<f64> = (0..n).map(own).collect();
        let diagonal = factor.diagonal();
        // An unknown error of a zone that reflects is unknown everywhere.
        let spreads = (0..n).any(|i| !errors[i].is_finite() && diagonal[i] > 0.0);
        if spreads {
            return vec![f64::INFINITY; n];
        }
        let sent: Vec<f64> =
            (0..n).map(|i| if diagonal[i] > 0.0 { diagonal[i] * errors[i] } else { 0.0 }).collect();
        let more = factor.solve(m, m.apply(&sent));
        for i in 0..n {
            let all = errors[i] + more[i].abs();
            errors[i] = if m.c[i] > 0.0 { all / m.c[i] } else { 0.0 };
        }
        errors
    }

    /// The state of all bands together.
    fn assemble(&self, states: &[BandState]) -> ThermalState {
        let (d, n) = (&self.data, self.data.zone_count());
        let mut out = ThermalState::default();
        for s in states {
            out.surroundings += s.incoming - s.escaped;
            out.absorbed_backfaces += s.backfaces;
        }
        for i in 0..n {
            let (mut net, mut absorbed) = ([0.0; 2], [0.0; 3]);
            let mut fluxes = [0.0; 4];
            for s in states {
                let (m, a) = (self.matrix(s.band), 1.0 - d.reflectances[i][s.band]);
                let weight = self.weight(&m, i) * a;
                let (h, dh) = (s.incident[i], s.error[i]);
                let scaled = |w: f64, x: f64| if w == 0.0 { 0.0 } else { w * x };
                absorbed = [absorbed[0] + weight, absorbed[1] + weight * h, absorbed[2] + scaled(weight, dh)];
                let own =
                    [h, dh, s.radiosity[i], scaled(if self.has_temperature(i) { 1.0 - a } else { 1.0 }, dh)];
                fluxes.iter_mut().zip(own).for_each(|(f, x)| *f += x);
                if let ThermalCondition::Temperature(t) = d.conditions[i] {
                    let w = d.band_fractions.emissive_powers(blackbody_emissive_power(t))[0][s.band];
                    net = [net[0] + weight * (w - h), net[1] + scaled(weight, dh)];
                }
            }
            let temperature = match d.conditions[i] {
                ThermalCondition::Temperature(t) => [t, 0.0],
                ThermalCondition::Flux(q) | ThermalCondition::Power(q) => {
                    net = [q, 0.0];
                    let [weight, power, error] = absorbed;
                    temperature_of((power + q) / weight, error / weight)
                }
            };
            out.temperature.push(temperature[0]);
            out.temperature_error.push(temperature[1]);
            out.net.push(net[0]);
            out.net_error.push(net[1]);
            let [h, dh, b, db] = fluxes;
            out.incident.push(h);
            out.incident_error.push(dh);
            out.radiosity.push(b);
            out.radiosity_error.push(db);
        }
        out
    }

    /// Distributes the residual of the balance beyond the stated errors in proportion to the incident flux; true where there is any.
    fn widen_by_balance(&self, state: &ThermalState, states: &mut [BandState]) -> bool {
        let d = &self.data;
        let lost: f64 = states.iter().map(|s| s.escaped_error).sum();
        let explained: f64 = state.net_error.iter().zip(&d.sizes).map(|(e, s)| e * s).sum();
        let mut absorbed = 0.0;
        for s in states.iter() {
            let m = self.matrix(s.band);
            let of = |i: usize| m.c[i] * (1.0 - d.reflectances[i][s.band]) * s.incident[i];
            absorbed += (0..d.zone_count()).filter(|&i| self.has_temperature(i)).map(of).sum::<f64>();
        }
        let excess = state.balance(d).abs() - explained - lost;
        // An excess that is not a number gives an unknown error.
        let fraction = match excess <= ROUNDING_OF_BALANCE * absorbed {
            true => return false,
            false if absorbed > 0.0 && excess.is_finite() => excess / absorbed,
            false => f64::INFINITY,
        };
        for s in states {
            s.error.iter_mut().zip(&s.incident).for_each(|(e, h)| *e += error_of_fraction(fraction, *h));
        }
        true
    }
}

/// T and its error, K, from E and its error, W/m²; NaN where E is not positive.
fn temperature_of(e: f64, error: f64) -> [f64; 2] {
    if e > 0.0 && e.is_finite() {
        let t = blackbody_temperature(e);
        return [t, 0.25 * t * error / e];
    }
    [f64::NAN; 2]
}
