//! The keys of thermal mode: shares of the bands, bodies at one temperature, emissivities by temperature and by side.

use super::keys::{KeyGroups, key};

/// `[thermal]`.
pub(crate) const THERMAL: KeyGroups = &[&[
    key(
        "band_fractions",
        "list of numbers, one for each band",
        "",
        "grey",
        "constant fractions of the black-body emission in the bands; they sum to 1",
    ),
    key(
        "weights",
        "list of numbers for each band, or \"rest\" for one of them",
        "1/K^n",
        "",
        "polynomial band fractions in the temperature, by ascending power",
    ),
    key(
        "range",
        "[number, number]",
        "K",
        "required with weights",
        "temperatures for which the polynomials hold",
    ),
    key("allow_partial", "boolean", "", "false", "accepts band fractions that sum to less than 1"),
]];
/// `[[node]]`.
pub(crate) const NODE: KeyGroups = &[&[
    key("name", "text", "", "required", "unique name"),
    key("temperature", "number above 0", "K", "unknown", "given temperature"),
    key("net_power", "number", "W", "0", "power supplied to a node of unknown temperature"),
    key("links", "list of tables", "", "", "heat paths to other nodes"),
]];
/// `node.links`.
pub(crate) const NODE_LINK: KeyGroups = &[&[
    key("to", "text", "", "required", "name of the other node"),
    key("conductance", "number from 0", "W/K", "", "conductance"),
    key(
        "conductance_per_area",
        "number from 0",
        "W/(m2 K)",
        "",
        "conductance over the area of this node's surfaces",
    ),
    key(
        "effective_emissivity",
        "number from 0",
        "",
        "",
        "radiation through insulation over the area of this node's surfaces, such as 0.02",
    ),
]];
/// `emissivity` by temperature.
pub(crate) const EMISSIVITY_BY_TEMPERATURE: KeyGroups = &[&[
    key("temperatures", "list of numbers above 0", "K", "", "ascending temperatures"),
    key("values", "list of numbers in [0, 1]", "", "required with temperatures", "emissivities at them"),
    key(
        "by_temperature",
        "file name",
        "",
        "",
        ".csv or .npy with temperatures in K in its first column, in place of the lists",
    ),
    key("column", "text | integer from 1", "", "2", "column of the emissivities in the file"),
]];
/// `back` of a surface.
pub(crate) const BACK_OF_SURFACE: KeyGroups = &[&[
    key("emissivity", "bands in [0, 1] | table", "", "required", "diffuse emissivity of the back"),
    key("solar_absorptance", "number in [0, 1]", "", "the emissivity", "absorbed fraction of sunlight"),
]];
