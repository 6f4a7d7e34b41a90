//! The keys of emissivities by temperature and by side.

use super::keys::{KeyGroups, key};

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
