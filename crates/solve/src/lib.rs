//! Solution of the zonal equations.
//!
//! With H_i the irradiance of a patch and G_i the fluence of a volume zone,
//!
//! ```text
//!     patch:   B = E + ρ (H + H_dir)                      H_i A_i      = Σ_j F_ij B_j + F_i,sky B_sky
//!     volume:  B = (1−Ω) E + Ω (G + G_dir)/4 + q/(4κ)     κ_i G_i V_i  = Σ_j F_ij B_j + F_i,sky B_sky
//! ```
//!
//! which are equations (1) and (2) of the 1996 paper with the direct light as a separate third source.
//!
//! | module | content |
//! |---|---|
//! | `pipeline` | the phases of a solve, in their order |
//! | `direct_solution` | direct light alone, before the exchange is known |
//! | [`settings`] | memory limit, checkpoints, observer, warm start |
//! | [`distribution`] | work shared by several processes |
//! | [`operator`] | the interface of the engines: [`ExchangeOperator`], `ErrorModel` |
//! | [`engine`] | selection and construction of an engine |
//! | [`dense`] | all pairs of zones |
//! | [`spectral`] | box enclosures, where the exchange is a convolution |
//! | `bordered_operator`, `merged_operator` | patches outside such a box; merged patches |
//! | [`layered`] | slabs of layers of any extinction, periodic along two axes |
//! | [`ray`], `gather`, [`hierarchical`] | stored rays from every zone, and a final gather from their solution |
//! | [`direct_light`], [`surroundings`], [`light_groups`] | the right-hand sides |
//! | `iteration` | conjugate gradients, stabilised bi-conjugate gradients, Neumann series |
//! | `group_solve`, `solution_fields`, `error_amplification` | the solution of all light groups, its fields, and the reflection of errors |
//! | [`thermal`] | boundary conditions, coupling of the bands, recovery of temperatures |
//! | `errors` | error estimates of a solution |
//! | [`report`] | closure, energy balance, diagnostics, cost estimates |
//! | [`relight`] | scaled lights in a finished solution |
//! | [`mirrors`] | scenes with mirrors on their even extensions |
//! | [`exchange_areas`] | direct and total exchange areas of all pairs, as matrices |
//! | [`total_exchange_areas`] | exchange areas with all reflections |
//! | [`state`] | thermal states of one geometry from stored exchange areas |
//! | `stage_codec`, [`solve_context`], `zone_power`, `unobstructed_cells` | shared data and helpers |

mod balanced_report;
mod bordered_operator;
pub mod dense;
pub mod direct_light;
mod direct_solution;
pub mod distribution;
pub mod engine;
mod error_amplification;
mod errors;
pub mod exchange_areas;
mod fixed_tree;
mod gather;
mod group_solve;
pub mod hierarchical;
mod iteration;
pub mod layered;
pub mod light_groups;
mod merged_operator;
pub mod mirrors;
mod mixed_sides;
pub mod operator;
mod pipeline;
pub mod ray;
pub mod relight;
pub mod report;
pub mod settings;
mod solution_fields;
pub mod solve_context;
pub mod spectral;
mod stage_codec;
pub mod state;
mod sum_order;
pub mod surroundings;
pub mod thermal;
pub mod total_exchange_areas;
mod triple_checkpoints;
mod unobstructed_cells;
mod zonal_solution;
pub mod zone_division;
mod zone_power;

pub use direct_solution::{solve_direct_light, solve_without_light};
pub use operator::ExchangeOperator;
pub use pipeline::{solve, solve_with_settings, solve_zones};
pub use settings::SolveSettings;
