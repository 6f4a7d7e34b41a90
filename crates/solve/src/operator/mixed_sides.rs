//! Sheets that transmit diffusely, in the linear system.
//!
//! With the incident powers P = g s of the two sides f and b of a piece of a sheet of area A, reflectances ρ and transmittance τ,
//!
//! ```text
//!     s_f = s⁰_f + (ρ_f P_f + τ P_b)/A = s⁰_f + w_f P̃_f      w_f = (ρ_f + τ)/A      P̃_f = (ρ_f P_f + τ P_b)/(ρ_f + τ)
//! ```
//!
//! and likewise for b: the equations have the form s = s⁰ + w g̃ s of those without sheets, where g̃ mixes the incident powers of the two sides. The mean P̃ keeps
//! w P̃ within the power that arrives, so that no iteration gains power. g̃ is not symmetric, and the matrix of ρ and τ is not positive where τ > ρ: the systems
//! are solved by stabilised bi-conjugate gradients, not by conjugate gradients.

use crate::operator::ExchangeOperator;
use zonal_scene::{Bands, Zones};

/// An exchange operator with the incident powers of both sides of transmitting sheets mixed.
pub(crate) struct MixedSides<'a> {
    /// The operator of the zones.
    pub operator: &'a dyn ExchangeOperator,
    /// The zones.
    pub zones: &'a Zones,
}

/// Replaces the incident powers of the sides of sheets by P̃.
pub(crate) fn mix_sides(zones: &Zones, power: &mut [Bands]) {
    if zones.sheets.is_empty() {
        return;
    }
    let pairs = (0..zones.patches.len()).filter_map(|i| Some((i, zones.sheets.opposite(i)?)));
    for (i, j) in pairs.filter(|(i, j)| i < j) {
        (power[i], power[j]) = (zones.mixed(i, |k| power[k]), zones.mixed(j, |k| power[k]));
    }
}

impl ExchangeOperator for MixedSides<'_> {
    fn len(&self) -> usize {
        self.operator.len()
    }
    fn apply(&self, strengths: &[Bands]) -> Vec<Bands> {
        let mut power = self.operator.apply(strengths);
        mix_sides(self.zones, &mut power);
        power
    }
    fn scale(&mut self, _: &[Bands]) {}
}
