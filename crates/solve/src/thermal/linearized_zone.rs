//! Linearization of the radiosity of a zone about an emissive power, and the scaling of the unknowns of the linear solve.

use super::zone_balance::ZoneBalance;
use crate::operator::{ExchangeOperator, extend_to_slopes};
use rayon::prelude::*;
use zonal_exchange::pair::{closure_target, scaled_radiosity_coefficient};
use zonal_scene::thermal::blackbody_temperature;
use zonal_scene::{BandFractions, Bands, ThermalCondition, Zones};

/// Whether the bands of a linear solve differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BandCoupling {
    /// All bands have the same coefficients and sources.
    Identical,
    /// Bands differ.
    Distinct,
}

impl BandCoupling {
    /// Of band fractions.
    pub(super) fn of(fractions: &BandFractions) -> BandCoupling {
        if fractions.is_grey() { BandCoupling::Identical } else { BandCoupling::Distinct }
    }
}

/// Radiosity of a zone as a linear function of the incident flux.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinearizedZone {
    pub own: Bands,
    reflect: Bands,
    /// a ψ/S, and m a; both 0 if the temperature is known.
    pub reemitted: Bands,
    pub absorption: Bands,
}

impl LinearizedZone {
    pub(super) fn of(l: &ZoneBalance, shares: &BandFractions, e: f64) -> LinearizedZone {
        let [w, mut slope] = shares.emissive_powers(e);
        let absorption = l.absorption_weight();
        let fixed = LinearizedZone {
            own: l.absorb * w,
            reflect: l.reflect,
            reemitted: Bands::ZERO,
            absorption: Bands::ZERO,
        };
        let q = match l.condition {
            ThermalCondition::Temperature(_) => return fixed,
            ThermalCondition::Flux(q) | ThermalCondition::Power(q) => q,
        };
        if slope.any(|s| s < 0.0) {
            slope = shares.grey_gas_weights(blackbody_temperature(e.max(0.0)));
        }
        let all = (absorption * slope).sum();
        if all <= 0.0 {
            return fixed;
        }
        let missing = (q - (absorption * w).sum()) / all;
        LinearizedZone {
            own: l.absorb * (w + slope * missing),
            reemitted: l.absorb * slope / all,
            absorption,
            ..fixed
        }
    }
    /// The part of B that depends on the incident flux `h`.
    pub(super) fn reflected(&self, h: Bands) -> Bands {
        let absorbed = (self.absorption * h).sum();
        self.reflect * h + self.reemitted * absorbed
    }
}

/// Conversion between radiosities and powers of all unknowns, for the linear solve.
pub(super) struct PowerScaling {
    /// t and c.
    scale: Vec<(f64, Bands)>,
    /// h over P: 1/A or 1/(4V).
    pub flux_over_power: Vec<f64>,
    /// The zone of every higher-order unknown.
    slope_zones: Vec<u32>,
    zones: usize,
    /// True if all bands are identical and one product serves all.
    one_band: bool,
}

impl PowerScaling {
    /// For zones with their balances and higher-order unknowns; `bands` says whether all bands are identical.
    pub(super) fn new(
        operator: &dyn ExchangeOperator,
        zones: &Zones,
        locals: &[ZoneBalance],
        bands: BandCoupling,
        slope_zones: &[u32],
    ) -> PowerScaling {
        let mut scale: Vec<(f64, Bands)> = (0..zones.len())
            .into_par_iter()
            .map(|i| (closure_target(zones, i), scaled_radiosity_coefficient(zones, i)))
            .collect();
        let mut flux_over_power: Vec<f64> = locals.iter().map(|l| l.incident_share / l.measure).collect();
        extend_to_slopes(&mut scale, slope_zones);
        extend_to_slopes(&mut flux_over_power, slope_zones);
        let (slope_zones, zones) = (slope_zones.to_vec(), zones.len());
        // Without the higher-order unknowns only products of all bands are available.
        let one_band = bands == BandCoupling::Identical
            && operator.has_identical_bands()
            && operator.len() == scale.len();
        PowerScaling { scale, flux_over_power, slope_zones, zones, one_band }
    }
    /// The zone of an unknown.
    pub(super) fn zone(&self, k: usize) -> usize {
        if k < self.zones { k } else { self.slope_zones[k - self.zones] as usize }
    }
    /// Power of an unknown with a radiosity, W.
    pub(super) fn power_of(&self, i: usize, radiosity: Bands) -> Bands {
        let (t, c) = self.scale[i];
        t * c * radiosity
    }
    pub(super) fn strengths(&self, u: &[Bands]) -> Vec<Bands> {
        u.par_iter().zip(&self.scale).map(|(u, (t, _))| u / *t).collect()
    }
    /// h of every unknown by the exchange between the zones.
    pub(super) fn incident_flux(&self, operator: &dyn ExchangeOperator, u: &[Bands]) -> Vec<Bands> {
        let s = self.strengths(u);
        let mut p: Vec<Bands> = match self.one_band {
            true => {
                let first: Vec<[f64; 1]> = s.par_iter().map(|s| [s.first()]).collect();
                operator.apply_band(&first).par_iter().map(|p| Bands::splat(p[0])).collect()
            }
            false => operator.apply(&s),
        };
        p.par_iter_mut().zip(&self.flux_over_power).for_each(|(p, o)| *p *= *o);
        p
    }
    /// M u.
    pub(super) fn reflect(
        &self,
        operator: &dyn ExchangeOperator,
        u: &[Bands],
        reflected: impl Fn(usize, Bands) -> Bands + Sync,
    ) -> Vec<Bands> {
        let h = self.incident_flux(operator, u);
        (0..u.len()).into_par_iter().map(|k| self.power_of(k, reflected(self.zone(k), h[k]))).collect()
    }
}
