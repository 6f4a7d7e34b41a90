//! The grey gases of a composition as functions of the temperature.
//!
//! ```text
//!     κ_j(T) = κ_j + s_j T            a_j(T) = Σ_i c_ji T^i            a_0 = 1 − Σ_{j>0} a_j for the clear gas
//! ```
//!
//! with T in K, clamped in a_j to the range of the model. s_j is that of grey soot; nothing else in κ depends on the temperature.

use crate::mixture::{GreyGas, GreyGasMixture};
use crate::polynomial::{clamp_with_note, interpolated, polynomial, product};

/// One grey gas of a composition.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FittedGas {
    /// The part of the absorption coefficient that does not depend on the temperature, 1/m.
    pub absorption: f64,
    /// The part of the absorption coefficient in proportion to the temperature, 1/(m K).
    pub absorption_per_kelvin: f64,
    /// Coefficients of the weight, by ascending power of the temperature in K.
    pub weight: Vec<f64>,
}

impl FittedGas {
    /// With an absorption coefficient (1/m) that does not depend on the temperature.
    pub(crate) fn new(absorption: f64, weight: Vec<f64>) -> FittedGas {
        FittedGas { absorption, absorption_per_kelvin: 0.0, weight }
    }
    /// (1 − t) `self` + t `other` of coefficient and weight.
    pub(crate) fn interpolated(&self, other: &FittedGas, t: f64) -> FittedGas {
        let absorption = (1.0 - t) * self.absorption + t * other.absorption;
        FittedGas::new(absorption, interpolated(&self.weight, &other.weight, t))
    }
    /// Both gases on one path: coefficients add, weights multiply.
    fn combined(&self, other: &FittedGas) -> FittedGas {
        FittedGas {
            absorption: self.absorption + other.absorption,
            absorption_per_kelvin: self.absorption_per_kelvin + other.absorption_per_kelvin,
            weight: product(&self.weight, &other.weight),
        }
    }
}

/// A published set of grey gases for one composition: pressure absorption coefficients in 1/(atm m), and coefficients of the weights by powers of
/// the temperature in K.
pub(crate) struct FittedSet<const GASES: usize, const POWERS: usize> {
    pub(crate) pressure_absorption: [f64; GASES],
    pub(crate) weights: [[f64; POWERS]; GASES],
}

impl<const GASES: usize, const POWERS: usize> FittedSet<GASES, POWERS> {
    /// Gas `j` at a partial pressure, atm.
    pub(crate) fn gas(&self, j: usize, pressure: f64) -> FittedGas {
        FittedGas::new(self.pressure_absorption[j] * pressure, self.weights[j].to_vec())
    }
    /// All gases at a partial pressure, atm.
    pub(crate) fn gases(&self, pressure: f64) -> Vec<FittedGas> {
        (0..GASES).map(|j| self.gas(j, pressure)).collect()
    }
}

/// The grey gases of a composition; a clear gas is the first. The weights sum to one.
#[derive(Clone, Debug, PartialEq)]
pub struct GreyGasFit {
    /// The gases.
    pub gases: Vec<FittedGas>,
    /// Temperatures of the fit, K; weights beyond are those at its ends.
    pub temperature_range: [f64; 2],
    /// Where the composition is outside the range of the model, and what was used instead; one sentence each.
    pub notes: Vec<String>,
}

impl GreyGasFit {
    /// Adds the clear gas, whose weight is one minus the sum of the others.
    pub(crate) fn with_clear_gas(
        grey: Vec<FittedGas>,
        temperature_range: [f64; 2],
        notes: Vec<String>,
    ) -> GreyGasFit {
        let longest = grey.iter().map(|g| g.weight.len()).max().unwrap_or(0).max(1);
        let mut clear = vec![0.0; longest];
        clear[0] = 1.0;
        for gas in &grey {
            clear.iter_mut().zip(&gas.weight).for_each(|(c, w)| *c -= w);
        }
        let gases = std::iter::once(FittedGas::new(0.0, clear)).chain(grey).collect();
        GreyGasFit { gases, temperature_range, notes }
    }
    /// All combinations of the gases of two fits of the same range.
    pub(crate) fn superposed(&self, other: &GreyGasFit) -> GreyGasFit {
        let gases = self.gases.iter().flat_map(|a| other.gases.iter().map(|b| a.combined(b))).collect();
        let notes = [&self.notes[..], &other.notes].concat();
        GreyGasFit { gases, temperature_range: self.temperature_range, notes }
    }
    /// Adds grey soot to every gas, 1/(m K).
    pub(crate) fn add_soot(&mut self, absorption_per_kelvin: f64) {
        self.gases.iter_mut().for_each(|g| g.absorption_per_kelvin += absorption_per_kelvin);
    }
    /// True if an absorption coefficient depends on the temperature.
    pub fn absorption_depends_on_temperature(&self) -> bool {
        self.gases.iter().any(|g| g.absorption_per_kelvin != 0.0)
    }
    /// The gases at a temperature, K. One outside the range of the fit adds a note, and so does a negative weight.
    ///
    /// ```
    /// use zonal_gas::{GasModel, GasState};
    /// let flue_gas = GasState { h2o: 0.2, co2: 0.1, ..GasState::default() };
    /// let fit = GasModel::Bordbar2020.fit(&flue_gas)?;
    /// let mixture = fit.at(1200.0);
    /// assert_eq!(mixture, GasModel::Bordbar2020.evaluate(&GasState { temperature: 1200.0, ..flue_gas })?);
    /// # Ok::<(), zonal_gas::GasStateError>(())
    /// ```
    pub fn at(&self, temperature: f64) -> GreyGasMixture {
        let mut notes = self.notes.clone();
        let t = clamp_with_note(temperature, self.temperature_range, "the temperature", " K", &mut notes);
        let gas = |g: &FittedGas| GreyGas {
            absorption: g.absorption + g.absorption_per_kelvin * temperature,
            weight: polynomial(&g.weight, t),
        };
        let mut gases: Vec<GreyGas> = self.gases.iter().map(gas).collect();
        // The weights sum to one but for rounding: the first takes it up.
        let others = gases.iter().skip(1).map(|g| g.weight).sum::<f64>();
        if let Some(first) = gases.first_mut() {
            first.weight = 1.0 - others;
        }
        let lowest = gases.iter().fold(0.0f64, |m, g| m.min(g.weight));
        if lowest < 0.0 {
            notes.push(format!("the fit has a negative weight at this state: {lowest:.2e}"));
        }
        GreyGasMixture { gases, notes }
    }
}
