//! Smith, Shen and Friedman 1982: three grey gases, 600 to 2400 K.
//!
//! The paper has sets for carbon dioxide alone, for the mole ratios 1 and 2, and for water vapour alone at a partial pressure near 0 and of
//! 1 atm. Between them coefficients are linear in the share y = x_H2O/(x_H2O + x_CO2) of water vapour, and those of water vapour alone are
//! linear in its partial pressure: a choice of this program, which the paper leaves open.

use crate::fit::{FittedSet, GreyGasFit};
use crate::state::GasState;

/// Temperatures of the fit, K.
const TEMPERATURE_RANGE: [f64; 2] = [600.0, 2400.0];

type SmithSet = FittedSet<3, 4>;

const CARBON_DIOXIDE: SmithSet = SmithSet {
    pressure_absorption: [0.3966, 15.64, 394.3],
    weights: [
        [0.4334e-1, 2.620e-4, -1.560e-7, 2.565e-11],
        [-0.4814e-1, 2.822e-4, -1.794e-7, 3.274e-11],
        [0.5492e-1, 0.1087e-4, -0.3500e-7, 0.9123e-11],
    ],
};
const RATIO_ONE: SmithSet = SmithSet {
    pressure_absorption: [0.4303, 7.055, 178.1],
    weights: [
        [5.150e-1, -2.303e-4, 0.9779e-7, -1.494e-11],
        [0.7749e-1, 3.399e-4, -2.297e-7, 3.770e-11],
        [1.907e-1, -1.824e-4, 0.5608e-7, -0.5122e-11],
    ],
};
const RATIO_TWO: SmithSet = SmithSet {
    pressure_absorption: [0.4201, 6.516, 131.9],
    weights: [
        [6.508e-1, -5.551e-4, 3.029e-7, -5.353e-11],
        [-0.2504e-1, 6.112e-4, -3.882e-7, 6.528e-11],
        [2.718e-1, -3.118e-4, 1.221e-7, -1.612e-11],
    ],
};
const DILUTE_WATER_VAPOUR: SmithSet = SmithSet {
    pressure_absorption: [0.4098, 6.325, 120.5],
    weights: [
        [5.977e-1, -5.119e-4, 3.042e-7, -5.564e-11],
        [0.5677e-1, 3.333e-4, -1.967e-7, 2.718e-11],
        [1.800e-1, -2.334e-4, 1.008e-7, -1.454e-11],
    ],
};
const WATER_VAPOUR_AT_ONE_ATMOSPHERE: SmithSet = SmithSet {
    pressure_absorption: [0.4496, 7.113, 119.7],
    weights: [
        [6.324e-1, -8.358e-4, 6.135e-7, -13.03e-11],
        [-0.2016e-1, 7.145e-4, -5.212e-7, 9.868e-11],
        [3.500e-1, -5.040e-4, 2.425e-7, -3.888e-11],
    ],
};

pub(crate) fn fit(state: &GasState) -> GreyGasFit {
    let absorbing = state.h2o + state.co2;
    let share = if absorbing > 0.0 { state.h2o / absorbing } else { 0.0 };
    let pressure = state.absorbing_pressure();
    let (one_half, two_thirds) = (0.5, 2.0 / 3.0);
    let gas = |j: usize| {
        let of = |set: &SmithSet| set.gas(j, pressure);
        let water = of(&DILUTE_WATER_VAPOUR)
            .interpolated(&of(&WATER_VAPOUR_AT_ONE_ATMOSPHERE), state.h2o_pressure().min(1.0));
        if share <= one_half {
            of(&CARBON_DIOXIDE).interpolated(&of(&RATIO_ONE), share / one_half)
        } else if share <= two_thirds {
            of(&RATIO_ONE).interpolated(&of(&RATIO_TWO), (share - one_half) / (two_thirds - one_half))
        } else {
            of(&RATIO_TWO).interpolated(&water, (share - two_thirds) / (1.0 - two_thirds))
        }
    };
    GreyGasFit::with_clear_gas((0..3).map(gas).collect(), TEMPERATURE_RANGE, Vec::new())
}
