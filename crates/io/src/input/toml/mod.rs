//! TOML with places: the text, typed values, known keys.
//!
//! | module | contents |
//! |---|---|
//! | `source` | the text, the place of every key that was read |
//! | `node` | typed reading; every value carries its key, line and column |
//! | `band_values` | values of bands: numbers or a spectrum |
//! | `key_specs`, `keys` | what manuals print of a key; its definition, from which readers, checks and manuals take it, and tables of keys |
//! | `kinds`, `band_kinds` | the kinds of values: description, unit and reader |
//! | `key_tables` | the tables of the scene format, and the keys of the document, `[solve]` and `[boundary]` |
//! | `surface_keys`, `medium_keys`, `light_keys`, `sky_keys`, `spectrum_keys`, `thermal_keys`, `camera_keys` | the other keys |
//! | `template` | numbers replaced in a text |

mod band_kinds;
mod band_values;
pub(crate) mod camera_keys;
pub(crate) mod key_specs;
pub(crate) mod key_tables;
pub(crate) mod keys;
pub(crate) mod kinds;
pub(crate) mod light_keys;
pub(crate) mod medium_keys;
pub(crate) mod node;
pub(crate) mod sky_keys;
pub(crate) mod source;
mod spectrum_keys;
pub(crate) mod surface_keys;
pub(crate) mod template;
pub(crate) mod thermal_keys;
