//! Bordbar, Węcel and Hyppänen 2014, and Bordbar, Fraga and Hostikka 2020: four grey gases, 300 to 2400 K, mole ratios r of water vapour to
//! carbon dioxide of 0.01 to 4.
//!
//! ```text
//! k_j = Σ_k d_jk r^k,   a_j = Σ_i (Σ_k c_jik r^k) (T/1200 K)^i
//! ```
//!
//! The set of 2020 adds the pure gases: between r = 0 and 0.01, and between 4 and 10⁸, κ and weights are linear in r, as in RadLib
//! (Stephens, Jansen, Johnson and Lignell 2022). The set of 2014 takes the nearest ratio of its range.

use crate::fit::{FittedGas, FittedSet, GreyGasFit};
use crate::polynomial::{clamp_with_note, in_units, polynomial};
use crate::state::GasState;

const TEMPERATURE_RANGE: [f64; 2] = [300.0, 2400.0];
const MOLE_RATIO_RANGE: [f64; 2] = [0.01, 4.0];
/// Reference temperature of the weights, K.
const REFERENCE_TEMPERATURE: f64 = 1200.0;
/// Mole ratio of pure water vapour.
const PURE_WATER_RATIO: f64 = 1e8;
/// Added to the mole fraction of carbon dioxide in the mole ratio.
const RATIO_OFFSET: f64 = 1e-10;

/// c: gas, power of T/1200 K, power of the mole ratio.
const WEIGHTS: [[[f64; 5]; 5]; 4] = [
    [
        [0.7412956, -0.5244441, 0.582286, -0.2096994, 0.02420312],
        [-0.9412652, 0.2799577, -0.7672319, 0.3204027, -0.03910174],
        [0.8531866, 0.08230754, 0.528943, -0.2468463, 0.03109396],
        [-0.3342806, 0.1474987, -0.4160689, 0.1697627, -0.0204066],
        [0.04314362, -0.06886217, 0.1109773, -0.04208608, 0.004918817],
    ],
    [
        [0.1552073, -0.4862117, 0.3668088, -0.1055508, 0.01058568],
        [0.6755648, 1.409271, -1.383449, 0.457521, -0.0501976],
        [-1.125394, -0.5913199, 0.9085441, -0.3334201, 0.03842361],
        [0.6040543, -0.05533854, -0.1733014, 0.07916083, -0.009893357],
        [-0.1105453, 0.04646634, -0.001612982, -0.003539835, 0.0006121277],
    ],
    [
        [0.2550242, 0.3805403, -0.4249709, 0.1429446, -0.01574075],
        [-0.6065428, 0.3494024, 0.1853509, -0.1013694, 0.01302441],
        [0.8123855, -1.102009, 0.4046178, -0.08118223, 0.006298101],
        [-0.453229, 0.6784475, -0.3432603, 0.08830883, -0.008415221],
        [0.08693093, -0.1306996, 0.07414464, -0.02029294, 0.002010969],
    ],
    [
        [-0.03451994, 0.2656726, -0.1225365, 0.03001508, -0.002820525],
        [0.4112046, -0.572835, 0.292449, -0.07980766, 0.007996603],
        [-0.5055995, 0.4579559, -0.2616436, 0.07648413, -0.007908356],
        [0.2317509, -0.1656759, 0.1052608, -0.03219347, 0.003386965],
        [-0.03754908, 0.02295193, -0.01600472, 0.005046318, -0.0005364326],
    ],
];

/// d, 1/(atm m): gas, power of the mole ratio.
const PRESSURE_ABSORPTION: [[f64; 5]; 4] = [
    [0.03404288, 0.06523048, -0.04636852, 0.01386835, -0.001444993],
    [0.3509457, 0.7465138, -0.529309, 0.1594423, -0.01663261],
    [4.57074, 2.168067, -1.498901, 0.4917165, -0.0542999],
    [109.8169, -50.92359, 23.43236, -5.163892, 0.4393889],
];

/// A pure gas, with weights by powers of T/1200 K.
type PureGas = FittedSet<4, 5>;

const CARBON_DIOXIDE: PureGas = PureGas {
    pressure_absorption: [0.03388079, 0.4544269, 4.680226, 103.8439],
    weights: [
        [0.8425766, -1.442229, 1.286974, -0.5202712, 0.07581559],
        [-0.03023864, 0.5264245, -0.6209696, 0.2704755, -0.0409069],
        [0.1070243, -0.1989596, 0.3101602, -0.173723, 0.0308118],
        [0.03108972, 0.1981489, -0.2543676, 0.1061331, -0.01498231],
    ],
};
const WATER_VAPOUR: PureGas = PureGas {
    pressure_absorption: [0.07703541, 0.8242941, 6.854761, 65.93653],
    weights: [
        [0.7129509, -1.378353, 1.555028, -0.6636291, 0.09773674],
        [0.1589917, 0.05635578, 0.2666874, -0.2040335, 0.03742408],
        [-0.1196373, 1.349665, -1.544797, 0.6397595, -0.0915365],
        [0.307825, -0.6003555, 0.4441261, -0.1468813, 0.01824702],
    ],
};

/// Grey gas `j` of a mixture of a mole ratio within the range.
fn mixture_gas(j: usize, ratio: f64, absorbing_pressure: f64) -> FittedGas {
    let absorption = polynomial(&PRESSURE_ABSORPTION[j], ratio) * absorbing_pressure;
    FittedGas::new(absorption, WEIGHTS[j].map(|c| polynomial(&c, ratio)).to_vec())
}

/// The fit of gases whose weights are polynomials of T/1200 K.
fn fit_of(mut gases: Vec<FittedGas>, notes: Vec<String>) -> GreyGasFit {
    gases.iter_mut().for_each(|g| g.weight = in_units(&g.weight, REFERENCE_TEMPERATURE));
    GreyGasFit::with_clear_gas(gases, TEMPERATURE_RANGE, notes)
}

/// The set of 2014.
pub(crate) fn fit_2014(state: &GasState) -> GreyGasFit {
    let mut notes = Vec::new();
    let ratio = state.mole_ratio();
    let clamped = clamp_with_note(ratio, MOLE_RATIO_RANGE, "the mole ratio of H2O to CO2", "", &mut notes);
    if state.h2o + state.co2 == 0.0 {
        // Without absorbing gases the ratio has no meaning.
        notes.clear();
    }
    let gas = |j| mixture_gas(j, clamped, state.absorbing_pressure());
    fit_of((0..4).map(gas).collect(), notes)
}

/// The set of 2020.
pub(crate) fn fit_2020(state: &GasState) -> GreyGasFit {
    let ratio = (state.h2o / (state.co2 + RATIO_OFFSET)).min(PURE_WATER_RATIO);
    let [low, high] = MOLE_RATIO_RANGE;
    let gas = |j| {
        let mixture = mixture_gas(j, ratio.clamp(low, high), state.absorbing_pressure());
        if ratio < low {
            mixture.interpolated(&CARBON_DIOXIDE.gas(j, state.co2_pressure()), (low - ratio) / low)
        } else if ratio > high {
            let pure = WATER_VAPOUR.gas(j, state.h2o_pressure());
            mixture.interpolated(&pure, (ratio - high) / (PURE_WATER_RATIO - high))
        } else {
            mixture
        }
    };
    fit_of((0..4).map(gas).collect(), Vec::new())
}
