//! The keys of thermal mode: shares of the bands, bodies at one temperature, emissivities by temperature and by side.

use super::keys::keys;
use super::kinds::{
    BOOLEAN, COLUMN, FILE, KELVIN, NET_POWER, NON_NEGATIVE, NUMBERS, TABLES, TEXT, UP_TO_ONE, shown,
};

keys! {
    /// `[thermal]`.
    THERMAL: Thermal = [Thermal] {
        band_fractions: () = shown("list of numbers, one for each band", ""), "grey",
            "constant fractions of the black-body emission in the bands; they sum to 1";
        weights: () = shown("list of numbers for each band, or \"rest\" for one of them", "1/K^n"), "",
            "polynomial band fractions in the temperature, by ascending power";
        range: () = shown("[number, number]", "K"), "required with weights", "temperatures for which the polynomials hold",
            "[600, 2400] (kelvin, where the polynomials hold)";
        allow_partial: bool = BOOLEAN, "false", "accepts band fractions that sum to less than 1";
    }
    /// `[[node]]`.
    NODE: Node = [Node] {
        name: String = TEXT, "required", "unique name", "\"plate\"";
        temperature: f64 = KELVIN, "unknown", "given temperature";
        net_power: f64 = NET_POWER.in_unit("W"), "0", "power supplied to a node of unknown temperature";
        links: () = TABLES, "", "heat paths to other nodes";
    }
    /// `node.links`.
    NODE_LINK: NodeLink = [NodeLink] {
        to: () = shown("text", ""), "required", "name of the other node", "\"hull\"";
        conductance: f64 = NON_NEGATIVE.in_unit("W/K"), "", "conductance";
        conductance_per_area: f64 = NON_NEGATIVE.in_unit("W/(m2 K)"), "", "conductance over the area of this node's surfaces";
        effective_emissivity: f64 = NON_NEGATIVE, "", "radiation through insulation over the area of this node's surfaces, such as 0.02";
    }
    /// `emissivity` by temperature.
    EMISSIVITY_BY_TEMPERATURE: EmissivityByTemperature = [EmissivityByTemperature] {
        temperatures: Vec<f64> = NUMBERS.described("list of numbers above 0").in_unit("K"), "", "ascending temperatures", "[300, 900]";
        values: Vec<f64> = NUMBERS.described("list of numbers in [0, 1]"), "required with temperatures", "emissivities at them", "[0.1, 0.3]";
        by_temperature: () = FILE, "", ".csv or .npy with temperatures in K in its first column, in place of the lists";
        column: String = COLUMN, "\"2\"", "column of the emissivities in the file";
    }
    /// `back` of a surface.
    BACK: Back = [Back] {
        emissivity: () = shown("bands in [0, 1] | table", ""), "required", "diffuse emissivity of the back", "0.1";
        solar_absorptance: f64 = UP_TO_ONE, "the emissivity", "absorbed fraction of sunlight";
    }
}
