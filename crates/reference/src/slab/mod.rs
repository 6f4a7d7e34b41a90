//! Plane-parallel layers between diffuse walls, by discrete ordinates with exact integration of each layer.
//!
//! The intensity I(x, μ) of a band obeys, in a layer of extinction β and albedo ω with the black-body emission e = a σT⁴ (W/m²),
//!
//! ```text
//! μ dI/dx = β (S − I),   S = (1−ω) e/π + ω J,   J = ½ ∫ I dμ from −1 to 1
//! leaving a wall:        I = ε e/π + (1−ε) H/π,   H = 2π ∫ I |μ| dμ over the incident half range
//! ```
//!
//! S is constant in a layer. Along each ordinate the layer of optical path t = βd/|μ| then has exactly
//!
//! ```text
//! I_out = I_in e^−t + S (1 − e^−t),   mean of I = S + (I_in − S)(1 − e^−t)/t
//! ```
//!
//! so that each ordinate conserves power and a transparent layer needs no special case. The ordinates of a half range are Gauss points of
//! s in 0 to 1 with μ = s³, which resolves the logarithmic singularity of the layer averages at grazing directions. No exponential integral
//! occurs. Scattering and reflection are a dense linear system in J of the layers and H of the walls, whose matrix is found by one sweep
//! over the layers for each unit source. Cost: N² M multiplications for N layers and M ordinates, N³ for the system; layers without scattering
//! between black walls take N M.
//!
//! Assumptions: isotropic scattering, diffuse walls, properties and emission constant in each layer. An open end is a black wall without
//! emission.
//!
//! | module | content |
//! |---|---|
//! | `ordinates` | directions and weights |
//! | `band` | one band: sweeps, linear system, fluxes |
//! | `equilibrium` | temperatures of layers and walls of given net power, with weights a(T) |
//! | `linear` | elimination with pivots |

mod band;
mod equilibrium;
mod linear;
mod ordinates;
#[cfg(test)]
mod tests;

pub use band::{BandEmission, BandSolution, SlabBand};
pub use equilibrium::{Equilibrium, SlabCondition};

/// Stefan–Boltzmann constant, W/(m² K⁴).
pub const STEFAN_BOLTZMANN: f64 = 5.670374419184429e-8;

/// Layers between two walls, in any number of bands.
#[derive(Clone, Debug, PartialEq)]
pub struct Slab {
    /// Thicknesses of the layers, m, above 0.
    pub thickness: Vec<f64>,
    /// Properties by band.
    pub bands: Vec<SlabBand>,
}

impl Slab {
    /// The solution of each band for its emission.
    ///
    /// # Panics
    /// If the lengths of the arrays disagree.
    pub fn solve(&self, emission: &[BandEmission]) -> Vec<BandSolution> {
        assert_eq!(emission.len(), self.bands.len(), "one emission a band");
        self.bands.iter().zip(emission).map(|(band, e)| band.solve(&self.thickness, e)).collect()
    }
}

/// Net flux of all bands at each layer boundary, W/m².
pub fn total_flux(bands: &[BandSolution]) -> Vec<f64> {
    sum_of(bands, |b| &b.flux)
}

/// Source Q = −dq/dx of all bands in each layer, W/m³.
pub fn total_source(bands: &[BandSolution]) -> Vec<f64> {
    sum_of(bands, |b| &b.source)
}

fn sum_of(bands: &[BandSolution], field: impl Fn(&BandSolution) -> &Vec<f64>) -> Vec<f64> {
    let mut out = vec![0.0; bands.first().map_or(0, |b| field(b).len())];
    for band in bands {
        out.iter_mut().zip(field(band)).for_each(|(o, x)| *o += x);
    }
    out
}
