//! TOML with places: the text, typed values, known keys.
//!
//! | module | contents |
//! |---|---|
//! | `source` | the text, the place of every key that was read |
//! | `node` | typed reading; every value carries its key, line and column |
//! | `keys` | the description of one key, and its lookup in a table of keys |
//! | `key_tables` | every key of the scene and camera-path formats, with type, unit, default and description |
//! | `camera_keys` | those of cameras and camera paths |
//! | `light_keys` | those of lights and spectra |
//! | `sky_keys` | those of skies, place and time |
//! | `thermal_keys` | those of thermal mode: band fractions, bodies, emissivities by temperature and side |
//! | `template` | numbers replaced in a text |

pub(crate) mod camera_keys;
pub(crate) mod key_tables;
pub(crate) mod keys;
pub(crate) mod light_keys;
pub(crate) mod node;
pub(crate) mod sky_keys;
pub(crate) mod source;
pub(crate) mod template;
pub(crate) mod thermal_keys;
