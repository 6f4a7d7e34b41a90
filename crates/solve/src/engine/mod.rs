//! Selection and construction of an engine.
//!
//! | module | content |
//! |---|---|
//! | [`selection`] | the engine for a scene, and the reason |
//! | `build` | construction of the operator with its closure |
//! | `cost_forecast` | processor time of the dense and of the hierarchical engine, by counts |
//! | `engine_memory` | memory of a solve by the spectral and by the layered engine |

pub(crate) mod build;
mod cost_forecast;
pub(crate) mod engine_memory;
pub mod selection;
