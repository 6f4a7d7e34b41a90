//! Energy balance of a solution.

use crate::bands::Bands;
use crate::model::surface::Surface;

/// Emitted, incoming, absorbed and escaped powers, W per band.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnergyBalance {
    /// Emitted by surfaces, volumes, panes and volumetric sources.
    pub emitted: Bands,
    /// Incoming from the surroundings' zone and as direct light.
    pub incoming: Bands,
    /// Absorbed by each named surface, in the scene's order.
    pub absorbed_surfaces: Vec<(String, Bands)>,
    /// Absorbed by the voxels.
    pub absorbed_volumes: Bands,
    /// Absorbed by the panes.
    pub absorbed_panes: Bands,
    /// Escaped to the surroundings, measured by rays.
    pub escaped: Bands,
    /// Absorbed by the black back faces of one-sided surfaces, measured by rays.
    pub absorbed_backfaces: Bands,
    /// (emitted + incoming − absorbed − escaped)/(emitted + incoming).
    pub residual: Bands,
}

impl EnergyBalance {
    /// Zero powers of these surfaces.
    pub fn of_surfaces(surfaces: &[Surface]) -> EnergyBalance {
        let absorbed_surfaces = surfaces.iter().map(|s| (s.name.clone(), Bands::ZERO)).collect();
        EnergyBalance { absorbed_surfaces, ..EnergyBalance::default() }
    }
    fn powers_mut(&mut self) -> impl Iterator<Item = &mut Bands> {
        [
            &mut self.emitted,
            &mut self.incoming,
            &mut self.absorbed_volumes,
            &mut self.absorbed_panes,
            &mut self.escaped,
            &mut self.absorbed_backfaces,
        ]
        .into_iter()
        .chain(self.absorbed_surfaces.iter_mut().map(|s| &mut s.1))
    }
    /// Multiplies all powers by a factor per band.
    pub fn scale(&mut self, factor: Bands) {
        self.powers_mut().for_each(|x| *x *= factor);
    }
    /// Adds the balance of other lights on the same surfaces; the residual is that of the sum.
    pub fn add(&mut self, other: &EnergyBalance) {
        if self.absorbed_surfaces.is_empty() {
            self.absorbed_surfaces =
                other.absorbed_surfaces.iter().map(|s| (s.0.clone(), Bands::ZERO)).collect();
        }
        let mut more = other.clone();
        self.powers_mut().zip(more.powers_mut()).for_each(|(x, y)| *x += *y);
        self.balance();
    }
    /// Combines each power with that of another balance on the same surfaces by `f`; the residual is 0.
    pub fn zip_map(&self, other: &EnergyBalance, f: impl Fn(f64, f64) -> f64) -> EnergyBalance {
        let (mut out, mut other) = (self.clone(), other.clone());
        out.powers_mut().zip(other.powers_mut()).for_each(|(x, y)| *x = x.zip_map(*y, &f));
        out.residual = Bands::ZERO;
        out
    }
    /// Computes the residual from the powers.
    ///
    /// ```
    /// use zonal_scene::{Bands, EnergyBalance};
    /// let (emitted, escaped) = (Bands::from_rgb([2.0, 4.0, 0.0]), Bands::from_rgb([1.0, 4.0, 0.0]));
    /// let mut energy = EnergyBalance { emitted, escaped, ..EnergyBalance::default() };
    /// energy.balance();
    /// assert_eq!(energy.residual.to_rgb(), [0.5, 0.0, 0.0]);
    /// ```
    pub fn balance(&mut self) {
        let supplied = self.emitted + self.incoming;
        let surfaces: Bands = self.absorbed_surfaces.iter().map(|s| s.1).sum();
        let removed =
            surfaces + self.absorbed_volumes + self.absorbed_panes + self.escaped + self.absorbed_backfaces;
        // NaN is preserved.
        self.residual = supplied.zip_map(removed, |s, r| if s <= 0.0 { 0.0 } else { (s - r) / s });
    }
}
