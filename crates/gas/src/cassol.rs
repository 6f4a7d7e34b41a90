//! Cassol, Brittes, França and Ezekoye 2014: carbon dioxide, water vapour and soot by superposition, 400 to 2500 K.
//!
//! Carbon dioxide and water vapour have four grey gases and a clear gas each, soot two grey gases without a clear one, so that a mixture has
//! 25 gases, and 50 with soot. The weight of the second gas of soot is one minus that of the first; the published fits of the two weights
//! sum to one within 0.02 between 400 and 2500 K.

use crate::fit::{FittedGas, FittedSet, GreyGasFit};
use crate::state::GasState;

const TEMPERATURE_RANGE: [f64; 2] = [400.0, 2500.0];

/// A species with four grey gases.
type CassolGas = FittedSet<4, 5>;

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

pub(crate) fn fit(state: &GasState) -> GreyGasFit {
    let species = |set: &CassolGas, pressure: f64| {
        GreyGasFit::with_clear_gas(set.gases(pressure), TEMPERATURE_RANGE, Vec::new())
    };
    let carbon_dioxide = species(&CARBON_DIOXIDE, state.co2_pressure());
    let water_vapour = species(&WATER_VAPOUR, state.h2o_pressure());
    let gases = carbon_dioxide.superposed(&water_vapour);
    if state.soot == 0.0 {
        return gases;
    }
    // The second weight is one minus the first.
    let grey = vec![FittedGas::new(SOOT_ABSORPTION[0] * state.soot, SOOT_WEIGHT.to_vec())];
    let mut soot = GreyGasFit::with_clear_gas(grey, TEMPERATURE_RANGE, Vec::new());
    soot.gases.reverse();
    soot.gases[1].absorption = SOOT_ABSORPTION[1] * state.soot;
    gases.superposed(&soot)
}
