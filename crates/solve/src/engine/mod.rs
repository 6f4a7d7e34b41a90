//! Selection and construction of an engine.
//!
//! | module | content |
//! |---|---|
//! | [`selection`] | the engine for a scene, and the reason |
//! | `build` | construction of the operator with its closure |
//! | `spectral_memory` | memory of a solve by the spectral engine |

pub(crate) mod build;
pub mod selection;
pub(crate) mod spectral_memory;
