//! Quantities derived from a scene: its topology, the sides of its sheets, the scene on other zones, and even extensions.
//!
//! | module | contents |
//! |---|---|
//! | [`topology`] | defects of meshes |
//! | `sheet_pairing` | the two sides of transmitting sheets |
//! | `coarsened_scene` | the scene on larger or smaller zones |
//! | `even_extension` | scenes with symmetry planes as parts of their even extensions |

pub(crate) mod coarsened_scene;
pub(crate) mod even_extension;
pub(crate) mod sheet_pairing;
pub mod topology;
