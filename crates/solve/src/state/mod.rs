//! Thermal states of one geometry: fluxes and temperatures for other temperatures, powers and emissivities from stored exchange areas.
//!
//! With the direct exchange areas F_ij (m²) of a band, c_i = A_i or 4κ_iV_i, r_i = ρ_i or Ω_i, a = 1 − r, incident powers P_i = c_i h_i, direct light d and
//! surroundings of radiosity B_s,
//!
//! ```text
//!     P = F B + F_s B_s + c d        known temperature:  B_i = a_i w(T_i) + r_i h_i        known power, grey:  B_i = h_i + q_i/m_i        m_i = c_i/V_i (1 for A_i)
//! ```
//!
//! In a grey scene a zone of known power is white. With r̂ = r or 1, D = diag(r̂/c) and sources s, P = c d + (I − F D)⁻¹ b, b = F (s + r̂ d) + F_s B_s. The symmetric form
//!
//! ```text
//!     (I − √D F √D) y = √D b        P = c d + b + F √D y
//! ```
//!
//! has a Cholesky factor as long as some power is absorbed or lost. The factor depends on F, on r and in a grey scene on the zones whose power is known, not on the values:
//! another temperature or power costs two products and a solution with the factor, O(n²); another emissivity costs a factorization, n³/3. Each band has its own.
//!
//! **Several bands.** The emissive powers w_b(T) of a zone follow from the band fractions of the scene or of its gas. Known temperatures leave the bands independent;
//! zones of known power couple them, and Newton's method finds their temperatures (`known_powers`).
//!
//! **Direct light** of suns, skies and emitters is constant: d and its error are part of the data.
//!
//! **Closure.** The stored areas are scaled as in a solve, F' = d F d with the surroundings, if the scene restores closure.
//!
//! **Errors** are those of a solve: e_i = √(Σ_j (δF_ij B_j)²) from the radii, the unexplained closure defect of the row as a fraction of P_i, the error of
//! the surroundings, and the error of direct light; then δP = e + (I − F D)⁻¹ F D e, which bounds their reflection, because no entry is negative; then the residual of the balance of
//! heat. δq = Σ_b m a δh for a known temperature, δE = Σ_b m a δh / Σ_b m a dw/dE for a known power. The error of the finite zones is not included.
//!
//! **Scope.** Temperatures, powers and lights. Bodies at one temperature (nodes) and convection are refused: `solve` has them.
//!
//! | module | content |
//! |---|---|
//! | `exchange_data` | what a geometry contributes, as plain arrays |
//! | `block_data` | the part of one block of bands: surroundings, closure, lights |
//! | `ray_tracing`, `surroundings_data`, `light_data` | rays of a block; surroundings and direct light |
//! | `zone_fractions` | emissive powers of the zones in each band |
//! | `area_operator` | exchange areas as an operator, for closure and emitters |
//! | `cholesky`, `gaussian_elimination` | decomposition and solution |
//! | `band_system` | matrix and factor of one band |
//! | `band_state` | the solution of one band with errors |
//! | `known_powers` | temperatures of zones of known power in several bands |
//! | `state_solver` | the solver that keeps the factors |
//! | `assembly` | the state of all bands together |
//! | `thermal_state` | the result |

mod area_operator;
mod assembly;
mod band_state;
mod band_system;
mod block_data;
mod cholesky;
mod exchange_data;
mod gaussian_elimination;
mod known_powers;
mod light_data;
mod ray_tracing;
mod state_solver;
mod surroundings_data;
mod thermal_state;
mod zone_fractions;

pub use exchange_data::ExchangeData;
pub use light_data::LightData;
pub use state_solver::StateSolver;
pub use surroundings_data::SurroundingsData;
pub use thermal_state::{StatePart, ThermalState};
pub use zone_fractions::ZoneFractions;
