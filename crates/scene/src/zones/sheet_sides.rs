//! The two sides of sheets that transmit diffusely.
//!
//! The front f and the back b of a piece of a sheet of area A are two zones with the same geometry. With the reflectance ρ and the transmittance τ
//!
//! ```text
//!     B_f = E_f + ρ_f H_f + τ H_b      B_b = E_b + ρ_b H_b + τ H_f
//! ```
//!
//! and side f absorbs (1 − ρ_f − τ) H_f A. The sides of a piece follow one another among the patches. A side without a partner, because the other side lies
//! against another surface, transmits nothing.

use crate::bands::Bands;

/// Marks a patch without a partner.
pub(crate) const NO_PARTNER: u32 = u32::MAX;

/// The other side of each patch of a sheet that transmits diffusely; empty for a scene without such sheets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SheetSides {
    pub(crate) opposite: Vec<u32>,
    pub(crate) transmittance: Vec<Bands>,
}

impl SheetSides {
    /// True if no patch transmits.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.opposite.is_empty()
    }
    /// The patch on the other side of zone `i`; `None` for a zone that does not transmit.
    #[must_use]
    pub fn opposite(&self, i: usize) -> Option<usize> {
        self.opposite.get(i).filter(|j| **j != NO_PARTNER).map(|j| *j as usize)
    }
    /// τ of zone `i`: the fraction of the light that arrives there and leaves the other side.
    #[must_use]
    pub fn transmittance(&self, i: usize) -> Bands {
        self.transmittance.get(i).copied().unwrap_or(Bands::ZERO)
    }
}
