//! Thermal states of one geometry: fluxes and temperatures for other temperatures, powers and emissivities from stored exchange areas.
//!
//! With the direct exchange areas F_ij (m²), c_i = A_i or 4κ_iV_i, r_i = ρ_i or Ω_i, a = 1 − r, incident powers P_i = c_i h_i and surroundings of
//! radiosity B_s,
//!
//! ```text
//!     P = F B + F_s B_s        known temperature:  B_i = a_i w(T_i) + r_i h_i        known power:  B_i = h_i + q_i/m_i        m_i = c_i/V_i (1 for A_i)
//! ```
//!
//! A zone of known power is white. With r̂ = r or 1, D = diag(r̂/c) and sources s, P = (I − F D)⁻¹ b, b = F s + F_s B_s. The symmetric form
//!
//! ```text
//!     (I − √D F √D) y = √D b        P = b + F √D y
//! ```
//!
//! has a Cholesky factor as long as some power is absorbed or lost. The factor depends on F, on r and on the zones whose power is known, not on the values:
//! another temperature or power costs two products and a solution with the factor, O(n²); another emissivity costs a factorization, n³/3.
//!
//! **Closure.** The stored areas are scaled as in a solve, F' = d F d with the surroundings, if the scene restores closure.
//!
//! **Errors** are those of a solve: e_i = √(Σ_j (δF_ij B_j)²) from the radii, the unexplained closure defect of the row as a fraction of P_i, and the error of
//! the surroundings; then δP = e + (I − F D)⁻¹ F D e, which bounds their reflection, because no entry is negative; then the residual of the balance of
//! heat. δq = m a δh for a known temperature, δE = δh for a known power. The error of the finite zones is not included.
//!
//! **Scope.** Grey scenes, and scenes with band fractions whose temperatures are all known. Known powers in several bands couple the bands: `solve` has
//! Newton's method for them.
//!
//! | module | content |
//! |---|---|
//! | `exchange_data` | what a geometry contributes, as plain arrays |
//! | `area_operator` | exchange areas as an operator, for closure |
//! | `cholesky` | decomposition and solution |
//! | `band_system` | the equations of one band |
//! | `state_solver` | the solver that keeps the decomposition |
//! | `thermal_state` | the result |

mod area_operator;
mod band_system;
mod cholesky;
mod exchange_data;
mod state_solver;
mod thermal_state;

pub use exchange_data::{ExchangeData, SurroundingsData};
pub use state_solver::StateSolver;
pub use thermal_state::{StatePart, ThermalState};
