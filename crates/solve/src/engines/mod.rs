//! The engines: selection, construction, and the operators.
//!
//! | module | content |
//! |---|---|
//! | [`dense`] | all pairs of zones |
//! | [`spectral`] | box enclosures, where the exchange is a convolution |
//! | `bordered_operator`, `merged_operator` | patches outside such a box; merged patches |
//! | [`layered`] | slabs of layers of any extinction, periodic along two axes |
//! | [`rays`] | stored rays from every zone, and a final gather from their solution |
//! | [`selection`] | the engine for a scene, and the reason |
//! | `build` | construction of the operator with its closure |
//! | `cost_forecast` | processor time of the dense and of the rays engine, by counts |
//! | [`problem_size`] | counts of zones, pairs and rays, and their memory |
//! | `engine_memory` | memory of a solve by the spectral and by the layered engine |

pub(crate) mod bordered_operator;
pub(crate) mod build;
mod cost_forecast;
pub mod dense;
pub(crate) mod engine_memory;
pub mod layered;
pub(crate) mod merged_operator;
pub mod problem_size;
pub mod rays;
pub mod selection;
pub mod spectral;

use zonal_scene::{Diagnostic, Engine};

/// The advice for an error above the tolerance, by its cause: a smaller tolerance helps only where it leads to more rays.
pub(crate) fn tolerance_advice(engine: Engine, reported: &[Diagnostic]) -> &'static str {
    let has = |code: &str| reported.iter().any(|d| d.code == code);
    match engine {
        _ if has("memory") => {
            "memory limits the rays; allow more (--max-memory) or use a larger tolerance, a smaller one has no effect"
        }
        _ if has("light-power") => {
            "shadow rays are at their limit, see the warning of the light; use smaller patches at the edges of its shadows or a larger tolerance, a smaller one has no effect"
        }
        Engine::Dense | Engine::Spectral => {
            "the rays for partly hidden pairs and for the surroundings are not sufficient in this scene"
        }
        _ => "use a smaller tolerance",
    }
}
