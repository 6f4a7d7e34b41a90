//! Kangwanpongpan, França, Corrêa da Silva, Schneider and Krautz 2012 for oxy-fuel combustion: four grey gases, 400 to 2500 K, mole ratios
//! 0.125 to 4. Coefficients of weights and absorption are quadratic in the mole ratio; weights have degree 5 in T/2000 K.

use crate::fit::{FittedGas, GreyGasFit};
use crate::polynomial::{clamp_with_note, in_units, polynomial};
use crate::state::GasState;

const TEMPERATURE_RANGE: [f64; 2] = [400.0, 2500.0];
const MOLE_RATIO_RANGE: [f64; 2] = [0.125, 4.0];
/// Reference temperature of the weights, K.
const REFERENCE_TEMPERATURE: f64 = 2000.0;

/// Pressure absorption coefficients, 1/(atm m), by powers of the mole ratio.
const PRESSURE_ABSORPTION: [[f64; 3]; 4] = [
    [0.0429, 0.0093, -0.0018],
    [0.3647, 0.0790, -0.0150],
    [3.7144, 0.2565, -0.0509],
    [105.31, -39.265, 6.0877],
];

/// Coefficients of the weights: gas, power of the mole ratio, power of T/2000 K.
const WEIGHTS: [[[f64; 6]; 3]; 4] = [
    [
        [0.3947, -0.4512, 0.1492, 1.8824, -2.3284, 0.7698],
        [-0.1214, 1.1420, -5.2222, 9.1820, -6.9298, 1.9063],
        [0.0243, -0.2296, 1.0115, -1.7493, 1.3038, -0.3549],
    ],
    [
        [-0.4974, 6.8986, -19.988, 26.208, -16.440, 3.9847],
        [0.1092, -2.3198, 8.0021, -11.007, 7.1199, -1.7876],
        [-0.0179, 0.4077, -1.4482, 2.0311, -1.3278, 0.3349],
    ],
    [
        [0.3189, -0.7222, 1.5053, -1.8378, 1.0337, -0.2107],
        [-0.0720, 1.0304, -1.9350, 1.6332, -0.7798, 0.1782],
        [0.0158, -0.2478, 0.5931, -0.6619, 0.3857, -0.0933],
    ],
    [
        [0.1648, -0.6012, 2.0308, -3.4361, 2.5803, -0.7069],
        [0.0329, 0.6942, -3.0960, 4.7494, -3.1714, 0.7869],
        [-0.0095, -0.0687, 0.3691, -0.5919, 0.4017, -0.1003],
    ],
];

pub(crate) fn fit(state: &GasState) -> GreyGasFit {
    let mut notes = Vec::new();
    let ratio =
        clamp_with_note(state.mole_ratio(), MOLE_RATIO_RANGE, "the mole ratio of H2O to CO2", "", &mut notes);
    let gas = |j: usize| {
        let power = |i: usize| polynomial(&WEIGHTS[j].map(|c| c[i]), ratio);
        let weight: Vec<f64> = (0..WEIGHTS[j][0].len()).map(power).collect();
        let absorption = polynomial(&PRESSURE_ABSORPTION[j], ratio) * state.absorbing_pressure();
        FittedGas::new(absorption, in_units(&weight, REFERENCE_TEMPERATURE))
    };
    GreyGasFit::with_clear_gas((0..4).map(gas).collect(), TEMPERATURE_RANGE, notes)
}
