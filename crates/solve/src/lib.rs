//! The zonal equations and their solution.
//!
//! With H_i the irradiance of a patch and G_i the fluence of a volume zone,
//!
//! ```text
//!     patch:   B = E + ρ (H + H_dir)                      H_i A_i      = Σ_j F_ij B_j + F_i,sky B_sky
//!     volume:  B = (1−Ω) E + Ω (G + G_dir)/4 + q/(4κ)     κ_i G_i V_i  = Σ_j F_ij B_j + F_i,sky B_sky
//! ```
//!
//! which are equations (1) and (2) of the paper with the third source, direct light, kept apart.
//!
//! | module | what |
//! |---|---|
//! | [`operator`] | the one interface: strengths in, arriving power out |
//! | [`packed`] | symmetric matrices, half of them stored, applied with the same bits by any number of threads |
//! | `radii` | error radii of all pairs, a byte each |
//! | [`dense`] | the dense engine: every pair of zones |
//! | [`spectral`] | the spectral engine: box enclosures, where exchange is a convolution |
//! | `open` | where the medium is open |
//! | [`surroundings`] | what escapes, measured by rays |
//! | `openings` | rays of one zone, evenly or to where they leave |
//! | [`direct`] | sun, sky and small emitters on the zones |
//! | `emitters` | direct light of emitters from exchange areas |
//! | `direct_error` | what the error of direct light costs indirect light |
//! | [`closure`] | row sums: measured, and restored on request |
//! | [`krylov`] | conjugate gradients for many light groups at once, with a status; sweeps |
//! | [`groups`] | light groups: which lights are solved apart |
//! | [`engine`] | the choice of an engine |
//! | [`columns`] | vectors over zones, many at a time |
//! | [`stage`] | what is kept of long work, as bytes |
//! | [`energy`] | the balance |
//! | `consistency` | errors that a solution tells of itself |
//! | `finite` | the guard at the end: nothing that is not a finite number is told |
//! | `notes` | what the report says of a balance that is off |
//! | [`pipeline`] | a scene in, a solution out |
//! | [`thermal`] | temperatures and net powers: zones posed for the linear equations, the coupling of bands, what is found |
//! | [`total`] | total exchange areas: all reflections in one matrix |
//! | [`zoning`] | what the size of the zones costs |
//! | [`relight`] | lights turned up and down in a solution |
//! | [`forecast`] | counts and memory beforehand, and what looks wrong |
//! | [`outlook`] | time and memory beforehand, for the engine that will be taken |

mod bicgstab;
pub mod closure;
pub mod columns;
mod consistency;
pub mod dense;
pub mod direct;
mod direct_error;
mod emitters;
pub mod energy;
pub mod engine;
mod finite;
pub mod forecast;
mod gather;
pub mod groups;
pub mod hierarchical;
pub mod krylov;
mod notes;
mod open;
mod openings;
pub mod operator;
pub mod outlook;
pub mod packed;
pub mod pipeline;
mod radii;
pub mod relight;
pub mod spectral;
pub mod stage;
pub mod surroundings;
pub mod thermal;
pub mod total;
pub mod zoning;

pub use operator::Operator;
pub use pipeline::{Job, solve, solve_job, solve_zones};
