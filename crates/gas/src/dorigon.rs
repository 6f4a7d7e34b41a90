//! Dorigon, Duciak, Brittes, Cassol, Galarça and França 2013: four grey gases, 400 to 2500 K, mole ratios 1 and 2.
//!
//! A mixture takes the set whose ratio is nearer in the share y = x_H2O/(x_H2O + x_CO2) of water vapour; other ratios are noted.

use crate::fit::{FittedSet, GreyGasFit};
use crate::state::GasState;

const TEMPERATURE_RANGE: [f64; 2] = [400.0, 2500.0];
/// Share of water vapour between the sets: the mean of 1/2 and 2/3.
const SHARE_BETWEEN_SETS: f64 = 7.0 / 12.0;
/// Relative deviation from the ratio of a set that is noted.
const RATIO_TOLERANCE: f64 = 0.01;

type DorigonSet = FittedSet<4, 5>;

const RATIO_ONE: DorigonSet = DorigonSet {
    pressure_absorption: [0.1873, 1.723, 12.48, 144.9],
    weights: [
        [7.197e-2, 8.724e-4, -9.690e-7, 4.651e-10, -7.917e-14],
        [1.107e-1, 3.397e-4, -2.467e-7, 4.647e-11, -1.039e-15],
        [2.091e-1, -6.423e-5, -3.200e-8, 1.718e-11, -2.105e-15],
        [7.092e-2, 6.586e-5, -1.278e-7, 5.577e-11, -7.709e-15],
    ],
};
const RATIO_TWO: DorigonSet = DorigonSet {
    pressure_absorption: [0.1921, 1.719, 11.37, 111.0],
    weights: [
        [5.617e-2, 7.844e-4, -8.563e-7, 4.246e-10, -7.440e-14],
        [1.426e-1, 1.795e-4, -1.077e-8, -6.971e-11, 1.774e-14],
        [1.362e-1, 2.574e-4, -3.711e-7, 1.575e-10, -2.267e-14],
        [1.222e-1, -2.327e-5, -7.492e-8, 4.275e-11, -6.608e-15],
    ],
};

pub(crate) fn fit(state: &GasState) -> GreyGasFit {
    let mut notes = Vec::new();
    let absorbing = state.h2o + state.co2;
    let (set, own_ratio) =
        if state.h2o <= SHARE_BETWEEN_SETS * absorbing { (&RATIO_ONE, 1.0) } else { (&RATIO_TWO, 2.0) };
    let ratio = state.mole_ratio();
    if absorbing > 0.0 && (ratio / own_ratio - 1.0).abs() > RATIO_TOLERANCE {
        notes.push(format!(
            "the mole ratio of H2O to CO2 is {ratio:.4}; the model has coefficients for 1 and 2 only, and those for {own_ratio} are used"
        ));
    }
    GreyGasFit::with_clear_gas(set.gases(state.absorbing_pressure()), TEMPERATURE_RANGE, notes)
}
