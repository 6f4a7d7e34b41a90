//! Radiative properties of combustion gases: weighted sums of grey gases (WSGG) of water vapour and carbon dioxide, and soot.
//!
//! A WSGG model replaces the spectrum of a gas by a clear gas, the first of a list, and a few grey gases. Grey gas j has an absorption coefficient
//! κ_j (1/m), which depends on the composition and the pressure, and a weight a_j, the fraction of the black-body emissive power that it
//! emits, which depends on the temperature and the composition. The weights sum to one. The total emissivity of a uniform path of length
//! L (m) is
//!
//! ```text
//! ε(L) = Σ_j a_j (1 − e^{−κ_j L}),   κ_j = k_j p_a + κ_s,   Σ_j a_j = 1
//! ```
//!
//! with the pressure absorption coefficient k_j (1/(atm m)), the partial pressure p_a of the absorbing gases (atm), and the absorption
//! coefficient κ_s of soot. In a zonal solution each grey gas is a spectral band.
//!
//! Soot is grey, κ_s = 1817 f_v T (T in K, f_v its volume fraction), and is added to every gas, including the clear gas, which then
//! absorbs. Only [`GasModel::Cassol2014`] has its own grey gases for soot. It combines the gases of all three species (superposition):
//! κ of a combination is the sum, its weight the product.
//!
//! The coefficients are those of the papers named by [`GasModel::source`]; [`GasModel::verification`] says how each set was checked.
//! No error estimate is published with these models. Comparisons with line-by-line spectra report differences of 5 to 30 % in heat flux
//! (Solovjov et al. 2017; Bordbar et al. 2020).
//!
//! ```
//! use zonal_gas::{GasModel, GasState};
//! let flue_gas = GasState { temperature: 1200.0, h2o: 0.2, co2: 0.1, ..GasState::default() };
//! let mixture = GasModel::Bordbar2020.evaluate(&flue_gas)?;
//! assert_eq!(mixture.gases.len(), 5);
//! assert!((mixture.emissivity(1.0) - 0.311102).abs() < 5e-7);
//! # Ok::<(), zonal_gas::GasStateError>(())
//! ```
//!
//! | module | content |
//! |---|---|
//! | `model` | [`GasModel`]: names, sources, evaluation |
//! | `state` | [`GasState`] and its limits |
//! | `fit` | [`GreyGasFit`]: the grey gases of a composition as functions of the temperature |
//! | `mixture` | [`GreyGasMixture`]: absorption coefficients and weights, emissivity |
//! | `polynomial` | polynomials of the temperature and of the mole ratio |
//! | `smith`, `kangwanpongpan`, `dorigon`, `bordbar`, `cassol` | coefficients |

mod bordbar;
mod cassol;
mod dorigon;
mod fit;
mod kangwanpongpan;
mod mixture;
mod model;
mod polynomial;
mod smith;
mod state;

pub use fit::{FittedGas, GreyGasFit};
pub use mixture::{GreyGas, GreyGasMixture};
pub use model::GasModel;
pub use state::{GasState, GasStateError};
