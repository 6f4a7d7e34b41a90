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
//! | `pipeline` | the phases of a solve in their order; symmetry planes of the boundary; groups of light and their fields |
//! | [`engines`] | dense, spectral, layered, rays: selection, construction, and the operators |
//! | [`right_hand_side`] | direct light, surroundings, light groups |
//! | [`operator`] | the interface of the engines: [`ExchangeOperator`], `ErrorModel` |
//! | `iteration` | conjugate gradients, stabilised bi-conjugate gradients, Neumann series |
//! | `balance` | closure of the rows, balance of power |
//! | `errors` | error estimates of a solution |
//! | [`thermal`] | boundary conditions, coupling of the bands, recovery of temperatures |
//! | [`forecast`] | counts, time and memory before a solve |
//! | [`report`] | diagnostics and summary |
//! | [`relight`] | scaled lights in a finished solution |
//! | [`areas`] | direct and total exchange areas of all pairs, as matrices |
//! | [`state`] | thermal states of one geometry from stored exchange areas |
//! | [`context`] | what the phases of a solve read in common, and their result |
//! | [`settings`] | memory limit, checkpoints, observer, warm start |
//! | [`device`] | what computes the products of the spectral engine: the interface, and the mathematics of a product |
//! | [`distribution`] | work shared by several processes, sums in a fixed order |

pub mod areas;
pub(crate) mod balance;
pub mod context;
pub mod device;
pub mod distribution;
pub mod engines;
mod errors;
pub mod forecast;
mod iteration;
pub mod operator;
pub mod pipeline;
pub mod relight;
pub mod report;
pub mod right_hand_side;
pub mod settings;
pub mod state;
pub mod thermal;

pub use operator::ExchangeOperator;
pub use pipeline::direct_solution::{solve_direct_light, solve_without_light};
pub use pipeline::{solve, solve_with_settings, solve_zones};
pub use settings::{SolvePurpose, SolveSettings};
