//! Cassol, Brittes, França and Ezekoye 2014: carbon dioxide, water vapour and soot by superposition, 400 to 2500 K.
//!
//! Carbon dioxide and water vapour have four grey gases and a clear gas each, soot two grey gases without a clear one, so that a mixture has
//! 25 gases, and 50 with soot. The weight of the second gas of soot is one minus that of the first; the published fits of the two weights
//! sum to one within 0.02 between 400 and 2500 K.

use crate::mixture::{GreyGas, GreyGasMixture};
use crate::polynomial::{clamp_with_note, polynomial};
use crate::state::GasState;

const TEMPERATURE_RANGE: [f64; 2] = [400.0, 2500.0];

/// A species with four grey gases.
struct CassolGas {
    /// Pressure absorption coefficients, 1/(atm m).
    pressure_absorption: [f64; 4],
    /// Coefficients of the weights, by powers of T in K.
    weights: [[f64; 5]; 4],
}

const CARBON_DIOXIDE: CassolGas = CassolGas {
    pressure_absorption: [0.138, 1.895, 13.301, 340.811],
    weights: [
        [0.09990, 64.41e-5, -89.94e-8, 41.27e-11, -67.74e-15],
        [0.00942, 10.36e-5, -2.277e-8, -2.134e-11, 6.497e-15],
        [0.14511, -30.73e-5, 37.65e-8, -18.41e-11, 30.16e-15],
        [-0.02915, 25.23e-5, -26.10e-8, 9.965e-11, -13.26e-15],
    ],
};
const WATER_VAPOUR: CassolGas = CassolGas {
    pressure_absorption: [0.171, 1.551, 5.562, 49.159],
    weights: [
        [0.06617, 55.48e-5, -48.41e-8, 22.27e-11, -40.17e-15],
        [0.11045, 0.576e-5, 24.00e-8, -17.01e-11, 30.96e-15],
        [-0.04915, 70.63e-5, -70.12e-8, 26.07e-11, -34.94e-15],
        [0.23675, -18.91e-5, -0.907e-8, 4.082e-11, -8.778e-15],
    ],
};
/// Absorption coefficients of soot per unit volume fraction, 1/m.
const SOOT_ABSORPTION: [f64; 2] = [22_313.49, 466_624.8];
/// Coefficients of the weight of the first gas of soot, by powers of T in K.
const SOOT_WEIGHT: [f64; 5] = [0.95552, -1.431e-3, 9.871e-7, -3.390e-10, 4.555e-14];

impl CassolGas {
    fn mixture(&self, temperature: f64, pressure: f64) -> GreyGasMixture {
        let gas = |j: usize| GreyGas {
            absorption: self.pressure_absorption[j] * pressure,
            weight: polynomial(&self.weights[j], temperature),
        };
        GreyGasMixture::with_clear_gas((0..4).map(gas).collect(), Vec::new())
    }
}

pub(crate) fn evaluate(state: &GasState) -> GreyGasMixture {
    let mut notes = Vec::new();
    let t = clamp_with_note(state.temperature, TEMPERATURE_RANGE, "the temperature", " K", &mut notes);
    let carbon_dioxide = CARBON_DIOXIDE.mixture(t, state.co2_pressure());
    let water_vapour = WATER_VAPOUR.mixture(t, state.h2o_pressure());
    let mut mixture = carbon_dioxide.superpose(&water_vapour);
    if state.soot > 0.0 {
        let weight = polynomial(&SOOT_WEIGHT, t);
        let weights = [weight, 1.0 - weight];
        let gas = |j: usize| GreyGas { absorption: SOOT_ABSORPTION[j] * state.soot, weight: weights[j] };
        mixture = mixture.superpose(&GreyGasMixture { gases: vec![gas(0), gas(1)], notes: Vec::new() });
    }
    mixture.notes = notes;
    mixture
}
