//! Dorigon, Duciak, Brittes, Cassol, Galarça and França 2013: four grey gases, 400 to 2500 K, mole ratios 1 and 2.
//!
//! A mixture takes the set whose ratio is nearer in the share y = x_H2O/(x_H2O + x_CO2) of water vapour; other ratios are noted.

use crate::mixture::{GreyGas, GreyGasMixture};
use crate::polynomial::{clamp_with_note, polynomial};
use crate::state::GasState;

const TEMPERATURE_RANGE: [f64; 2] = [400.0, 2500.0];
/// Share of water vapour between the sets: the mean of 1/2 and 2/3.
const SHARE_BETWEEN_SETS: f64 = 7.0 / 12.0;
/// Relative deviation from the ratio of a set that is noted.
const RATIO_TOLERANCE: f64 = 0.01;

/// Coefficients of a mole ratio.
struct DorigonSet {
    /// Mole ratio.
    ratio: f64,
    /// Pressure absorption coefficients, 1/(atm m).
    pressure_absorption: [f64; 4],
    /// Coefficients of the weights, by powers of T in K.
    weights: [[f64; 5]; 4],
}

const RATIO_ONE: DorigonSet = DorigonSet {
    ratio: 1.0,
    pressure_absorption: [0.1873, 1.723, 12.48, 144.9],
    weights: [
        [7.197e-2, 8.724e-4, -9.690e-7, 4.651e-10, -7.917e-14],
        [1.107e-1, 3.397e-4, -2.467e-7, 4.647e-11, -1.039e-15],
        [2.091e-1, -6.423e-5, -3.200e-8, 1.718e-11, -2.105e-15],
        [7.092e-2, 6.586e-5, -1.278e-7, 5.577e-11, -7.709e-15],
    ],
};
const RATIO_TWO: DorigonSet = DorigonSet {
    ratio: 2.0,
    pressure_absorption: [0.1921, 1.719, 11.37, 111.0],
    weights: [
        [5.617e-2, 7.844e-4, -8.563e-7, 4.246e-10, -7.440e-14],
        [1.426e-1, 1.795e-4, -1.077e-8, -6.971e-11, 1.774e-14],
        [1.362e-1, 2.574e-4, -3.711e-7, 1.575e-10, -2.267e-14],
        [1.222e-1, -2.327e-5, -7.492e-8, 4.275e-11, -6.608e-15],
    ],
};

pub(crate) fn evaluate(state: &GasState) -> GreyGasMixture {
    let mut notes = Vec::new();
    let t = clamp_with_note(state.temperature, TEMPERATURE_RANGE, "the temperature", " K", &mut notes);
    let absorbing = state.h2o + state.co2;
    let set = if state.h2o <= SHARE_BETWEEN_SETS * absorbing { RATIO_ONE } else { RATIO_TWO };
    let ratio = state.mole_ratio();
    if absorbing > 0.0 && (ratio / set.ratio - 1.0).abs() > RATIO_TOLERANCE {
        notes.push(format!(
            "the mole ratio of H2O to CO2 is {ratio:.4}; the model has coefficients for 1 and 2 only, and those for {} are used",
            set.ratio
        ));
    }
    let gas = |j: usize| GreyGas {
        absorption: set.pressure_absorption[j] * state.absorbing_pressure(),
        weight: polynomial(&set.weights[j], t),
    };
    GreyGasMixture::with_clear_gas((0..4).map(gas).collect(), notes)
}
