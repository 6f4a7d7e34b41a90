//! State of a gas: temperature, pressure, composition, soot.

use std::fmt;

/// Standard atmosphere, Pa.
pub(crate) const ATMOSPHERE: f64 = 101_325.0;
/// Temperatures that are accepted, K.
pub(crate) const TEMPERATURES: [f64; 2] = [1.0, 1e5];
/// Largest pressure, Pa.
const MAX_PRESSURE: f64 = 1e9;
/// Rounding allowed in the sum of the mole fractions.
const MOLE_FRACTION_ROUNDING: f64 = 1e-9;

/// State of a gas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GasState {
    /// Temperature, K.
    pub temperature: f64,
    /// Total pressure, Pa.
    pub pressure: f64,
    /// Mole fraction of water vapour, 0 to 1.
    pub h2o: f64,
    /// Mole fraction of carbon dioxide, 0 to 1.
    pub co2: f64,
    /// Volume fraction of soot, 0 to 1.
    pub soot: f64,
}

impl Default for GasState {
    /// Gas without absorbing species at 1000 K and one atmosphere.
    fn default() -> GasState {
        GasState { temperature: 1000.0, pressure: ATMOSPHERE, h2o: 0.0, co2: 0.0, soot: 0.0 }
    }
}

/// A state of a gas that is out of range: the property, and what is allowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GasStateError {
    property: &'static str,
    allowed: &'static str,
}

impl GasStateError {
    /// Name of the property: `temperature`, `pressure`, `h2o`, `co2` or `soot`.
    pub fn property(&self) -> &'static str {
        self.property
    }
}

impl fmt::Display for GasStateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: must be {}", self.property, self.allowed)
    }
}

impl std::error::Error for GasStateError {}

impl GasState {
    /// Checks the ranges of all properties.
    ///
    /// # Errors
    /// For the first property that is out of range.
    pub(crate) fn check(&self) -> Result<(), GasStateError> {
        let fraction = |x: f64| (0.0..=1.0).contains(&x);
        let checks = [
            (
                (TEMPERATURES[0]..=TEMPERATURES[1]).contains(&self.temperature),
                "temperature",
                "from 1 to 100000 K",
            ),
            (self.pressure > 0.0 && self.pressure <= MAX_PRESSURE, "pressure", "above 0, at most 1e9 Pa"),
            (fraction(self.h2o), "h2o", "a mole fraction from 0 to 1"),
            (fraction(self.co2), "co2", "a mole fraction from 0 to 1"),
            (
                self.h2o + self.co2 <= 1.0 + MOLE_FRACTION_ROUNDING,
                "h2o",
                "at most 1 together with the mole fraction co2",
            ),
            (fraction(self.soot), "soot", "a volume fraction from 0 to 1"),
        ];
        match checks.into_iter().find(|(holds, ..)| !holds) {
            Some((_, property, allowed)) => Err(GasStateError { property, allowed }),
            None => Ok(()),
        }
    }
    /// Partial pressure of water vapour, atm.
    pub(crate) fn h2o_pressure(&self) -> f64 {
        self.h2o * self.pressure / ATMOSPHERE
    }
    /// Partial pressure of carbon dioxide, atm.
    pub(crate) fn co2_pressure(&self) -> f64 {
        self.co2 * self.pressure / ATMOSPHERE
    }
    /// Partial pressure of both absorbing gases, atm.
    pub(crate) fn absorbing_pressure(&self) -> f64 {
        (self.h2o + self.co2) * (self.pressure / ATMOSPHERE)
    }
    /// Mole ratio of water vapour to carbon dioxide; infinite without carbon dioxide, 0 without both.
    pub(crate) fn mole_ratio(&self) -> f64 {
        if self.h2o == 0.0 { 0.0 } else { self.h2o / self.co2 }
    }
}
