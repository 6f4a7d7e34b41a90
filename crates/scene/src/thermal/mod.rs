//! Thermal conditions (prescribed temperatures or net powers) and the fraction of black emission in each band (weighted sum of grey gases;
//! Hottel and Sarofim, Modest).
//!
//! ```text
//!     E_b = σT⁴            w_b(T) = a_b(T) σT⁴            Σ_b a_b = 1
//!     patch:   B_b = (1−ρ_b) w_b + ρ_b H_b                q = Σ_b (1−ρ_b)(w_b − H_b)              W/m²
//!     volume:  B_b = (1−Ω_b) w_b + Ω_b G_b/4              Q = Σ_b κ_b(1−Ω_b)(4 w_b − G_b)         W/m³
//! ```
//!
//! Each zone has either a prescribed T or a prescribed net power q (Q): 0 for an adiabatic wall, or for a medium in radiative
//! equilibrium. In grey scenes the three bands are equal: each holds the whole emission, and their sum has no meaning.

pub(crate) mod emissivity;
pub(crate) mod thermal_network;

use crate::bands::Bands;
use crate::bands::band::{Band, PerBand};
use crate::bands::band_set::{BANDS_PER_BLOCK, BandSet};
use crate::bands::black_body_bands::fraction_below;
use crate::base::limits::{MAX_NET_POWER, MAX_TEMPERATURE};
use crate::base::scene_error::{SceneError, invalid};
use crate::thermal::emissivity::SurfaceEmissivity;
use crate::thermal::thermal_network::ThermalNetwork;
use std::sync::Arc;

/// The Stefan–Boltzmann constant σ = 2π⁵k⁴/(15h³c²), W/(m² K⁴), to double precision (SI of 2019, CODATA 2018).
pub const STEFAN_BOLTZMANN: f64 = 5.670374419184429e-8;

/// Band fractions below this are rounding errors, such as that of a `"rest"` that should be zero.
const MIN_BAND_FRACTION: f64 = 1e-12;

/// Largest deviation of the sum of the band fractions from 1, and of a fraction below 0.
const FRACTION_SUM_TOLERANCE: f64 = 1e-6;

/// Number of intervals of the temperature range at whose ends band fractions are checked.
const TEMPERATURE_INTERVALS: usize = 256;

/// Blackbody emissive power σT⁴ at `t` kelvin, W/m².
///
/// ```
/// use zonal_scene::thermal::{blackbody_emissive_power, blackbody_temperature};
/// assert!((blackbody_emissive_power(1000.0) - 56_703.744_191_844).abs() < 1e-8);
/// assert_eq!(blackbody_temperature(blackbody_emissive_power(321.0)), 321.0);
/// ```
pub fn blackbody_emissive_power(t: f64) -> f64 {
    STEFAN_BOLTZMANN * t.powi(4)
}

/// Temperature of a blackbody emissive power `e` (W/m²), K; NaN below 0.
pub fn blackbody_temperature(e: f64) -> f64 {
    if e >= 0.0 { (e / STEFAN_BOLTZMANN).sqrt().sqrt() } else { f64::NAN }
}

/// Prescribed temperature or net power of a surface, a pane or a cell.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
pub enum ThermalCondition {
    /// Temperature, K.
    #[serde(rename = "temperature")]
    Temperature(f64),
    /// Net emitted power: W/m² of a surface, W/m³ of a volume.
    #[serde(rename = "heat")]
    Flux(f64),
    /// Net emitted power of a whole surface, W, uniform over its area.
    #[serde(rename = "net_power")]
    Power(f64),
}

impl ThermalCondition {
    /// Validates the range of the value; `key` maps the name of the quantity to the key of the error.
    ///
    /// # Errors
    /// If the value is out of range.
    pub fn check(self, key: impl Fn(&str) -> String) -> Result<(), SceneError> {
        let (quantity, valid) = match self {
            ThermalCondition::Temperature(t) => ("temperature", t > 0.0 && t <= MAX_TEMPERATURE),
            ThermalCondition::Flux(q) => ("heat_flux", q.abs() <= MAX_NET_POWER),
            ThermalCondition::Power(p) => ("net_power", p.abs() <= MAX_NET_POWER),
        };
        if valid {
            return Ok(());
        }
        let message = match self {
            ThermalCondition::Temperature(t) => {
                format!("{t} K is out of range; give kelvin above 0, up to {MAX_TEMPERATURE:e}")
            }
            ThermalCondition::Flux(q) | ThermalCondition::Power(q) => power_out_of_range(q),
        };
        invalid(key(quantity), message)
    }

    /// The prescribed net power in its unit; 0 for a temperature.
    pub(crate) fn prescribed_power(self) -> f64 {
        match self {
            ThermalCondition::Temperature(_) => 0.0,
            ThermalCondition::Flux(q) | ThermalCondition::Power(q) => q,
        }
    }
}

/// Error message for a power beyond [`MAX_NET_POWER`].
pub fn power_out_of_range(q: f64) -> String {
    format!("{q:e} is out of range; give watts of a modulus up to {MAX_NET_POWER:e}")
}

/// The fraction of the blackbody emissive power in each band.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum BandFractions {
    /// Each band holds the whole emission: the three bands are equal.
    #[default]
    Grey,
    /// Polynomials a_b(T) = Σ_k c_k T^k in kelvin, constant outside a range.
    GreyGases {
        /// c_0, c_1, … of each band.
        coefficients: PerBand<Vec<f64>>,
        /// Range of validity, K; twice the same number for constants.
        range: [f64; 2],
        /// True if the sum may be below 1: the remaining emission is not part of the exchange.
        allow_partial: bool,
        /// Polynomials of all bands of the scene, if some are negative within the range, as fits may be near its ends. The fractions are then the
        /// positive values over their sum.
        all_bands: Option<Arc<[Vec<f64>]>>,
    },
    /// Fractions of the black-body emissive power between the limits of each band, nm: the first band of a scene begins at 0, the last one ends at
    /// infinity. A band from infinity to infinity emits nothing.
    BlackBody {
        /// Limits of each band.
        limits: PerBand<[f64; 2]>,
    },
}

/// Value and derivative of a polynomial, coefficients ascending.
fn value_and_slope(c: &[f64], t: f64) -> [f64; 2] {
    let slope = (1..c.len()).rev().fold(0.0, |s, k| s * t + k as f64 * c[k]);
    [c.iter().rev().fold(0.0, |s, c| s * t + c), slope]
}

impl BandFractions {
    /// Constant fractions.
    ///
    /// ```
    /// use zonal_scene::{BandFractions, Bands};
    /// let fractions = BandFractions::constant(Bands::from_rgb([0.2, 0.3, 0.5]));
    /// assert!(fractions.check().is_ok() && fractions.is_constant());
    /// assert_eq!(fractions.emissive_powers(100.0)[0].to_rgb(), [20.0, 30.0, 50.0]);
    /// assert_eq!(fractions.total(Bands::from_rgb([1.0, 2.0, 3.0])), 6.0);
    /// ```
    pub fn constant(fractions: Bands) -> BandFractions {
        BandFractions::GreyGases {
            coefficients: fractions.map(|s| vec![s]),
            range: [1.0, 1.0],
            allow_partial: false,
            all_bands: None,
        }
    }
    /// The fractions of one block out of polynomials of all bands of a scene in the temperature (K), coefficients ascending, constant outside a
    /// range. Where some are negative, the positive ones over their sum take their place.
    ///
    /// ```
    /// use zonal_scene::{BandFractions, BandSet};
    /// let bands = BandSet::numbered(4)?;
    /// let weights = [vec![0.6, -1e-4], vec![0.4, 1e-4], vec![0.1, -1e-4], vec![-0.1, 1e-4]];
    /// let last = BandFractions::of_polynomials(&bands, 1, &weights, [500.0, 2000.0]);
    /// assert_eq!(last.grey_gas_weights(500.0).sum(), 0.0);
    /// assert!((last.grey_gas_weights(2000.0).sum() - 0.1 / 1.1).abs() < 1e-15);
    /// # Ok::<(), zonal_scene::SceneError>(())
    /// ```
    pub fn of_polynomials(
        bands: &BandSet,
        block: usize,
        polynomials: &[Vec<f64>],
        range: [f64; 2],
    ) -> BandFractions {
        let window = bands.window(block);
        // What fills up the last block emits nothing.
        let own = |b: Band| {
            let band = window.clone().nth(b.index());
            band.and_then(|k| polynomials.get(k).cloned()).unwrap_or_else(|| vec![0.0])
        };
        let is_negative = |p: &Vec<f64>| check_temperatures(range).any(|t| value_and_slope(p, t)[0] < 0.0);
        let all_bands = polynomials.iter().any(is_negative).then(|| polynomials.into());
        BandFractions::GreyGases {
            coefficients: PerBand::from_fn(own),
            range,
            allow_partial: false,
            all_bands,
        }
    }
    /// The fractions of the black body in one block of bands with wavelengths; those below the first band and above the last count to these. `None`
    /// without wavelengths.
    ///
    /// ```
    /// use zonal_scene::{BandFractions, BandSet};
    /// let bands = BandSet::by_wavelength(vec![[200.0, 3000.0], [3000.0, 1e5]])?;
    /// let fractions = BandFractions::of_wavelengths(&bands, 0).unwrap();
    /// let [short, long, none] = fractions.grey_gas_weights(966.0).to_rgb();
    /// assert!((short - 0.25).abs() < 1e-3 && short + long == 1.0 && none == 0.0);
    /// # Ok::<(), zonal_scene::SceneError>(())
    /// ```
    pub fn of_wavelengths(bands: &BandSet, block: usize) -> Option<BandFractions> {
        let wavelengths = bands.wavelengths()?;
        let window = bands.window(block);
        let of_band = |b: Band| match window.clone().nth(b.index()) {
            Some(k) => {
                let low = if k == 0 { 0.0 } else { wavelengths[k][0] };
                [low, if k + 1 == bands.count() { f64::INFINITY } else { wavelengths[k][1] }]
            }
            None => [f64::INFINITY; 2],
        };
        Some(BandFractions::BlackBody { limits: PerBand::from_fn(of_band) })
    }
    /// The polynomials of the bands of the block; `None` for a grey scene and for a black body.
    pub fn coefficients(&self) -> Option<&PerBand<Vec<f64>>> {
        match self {
            BandFractions::Grey | BandFractions::BlackBody { .. } => None,
            BandFractions::GreyGases { coefficients, .. } => Some(coefficients),
        }
    }
    /// True if the three bands are equal.
    pub fn is_grey(&self) -> bool {
        *self == BandFractions::Grey
    }
    /// True if no fraction depends on temperature.
    pub fn is_constant(&self) -> bool {
        match self {
            BandFractions::Grey => true,
            BandFractions::BlackBody { .. } => false,
            BandFractions::GreyGases { coefficients, .. } => coefficients.iter().all(|c| c.len() == 1),
        }
    }
    /// a_b and da_b/dT (1/K) at `t` kelvin.
    fn fractions_and_slopes(&self, t: f64) -> [Bands; 2] {
        let (coefficients, range, all_bands) = match self {
            BandFractions::Grey => return [Bands::ONE, Bands::ZERO],
            BandFractions::BlackBody { limits } => {
                let of_band = |k: usize, b: Band| {
                    let [low, high] = limits[b].map(|w| fraction_below(w, t)[k]);
                    high - low
                };
                return [0, 1].map(|k| Bands::from_fn(|b| of_band(k, b)));
            }
            BandFractions::GreyGases { coefficients, range, all_bands, .. } => {
                (coefficients, range, all_bands)
            }
        };
        let inside = t > range[0] && t < range[1];
        let t = t.clamp(range[0], range[1]);
        let own = |b: Band| value_and_slope(&coefficients[b], t);
        let [mut value, mut slope] = [Bands::from_fn(|b| own(b)[0]), Bands::from_fn(|b| own(b)[1])];
        if let Some(all) = all_bands {
            let positive = all.iter().map(|c| value_and_slope(c, t)).filter(|x| x[0] > 0.0);
            let [sum, sum_slope] = positive.fold([0.0; 2], |s, x| [s[0] + x[0], s[1] + x[1]]);
            slope = Bands::from_fn(|b| {
                if value[b] > 0.0 { (slope[b] - value[b] * sum_slope / sum) / sum } else { 0.0 }
            });
            value = value.map(|a| a.max(0.0) / sum);
        }
        [value, if inside { slope } else { Bands::ZERO }]
    }
    /// The fraction of each band at `t` kelvin.
    pub fn grey_gas_weights(&self, t: f64) -> Bands {
        self.fractions_and_slopes(t)[0]
    }
    /// w_b of a blackbody emissive power `e`, W/m², and dw_b/de.
    pub fn emissive_powers(&self, e: f64) -> [Bands; 2] {
        if self.is_constant() {
            let a = self.grey_gas_weights(0.0);
            return [a * e, a];
        }
        let t = blackbody_temperature(e.max(0.0));
        let [a, slope] = self.fractions_and_slopes(t);
        [a * e, a + 0.25 * t * slope]
    }
    /// Total over the bands: the sum, or the common value of a grey scene.
    pub fn total(&self, v: Bands) -> f64 {
        if self.is_grey() { v.first() } else { v.sum() }
    }
    /// For each band, whether its fraction is positive at any temperature.
    pub fn emitting_bands(&self) -> PerBand<bool> {
        let range = match self {
            BandFractions::Grey => return PerBand::splat(true),
            BandFractions::BlackBody { limits } => return PerBand::from_fn(|b| limits[b][0] < limits[b][1]),
            BandFractions::GreyGases { range, .. } => range,
        };
        check_temperatures(*range)
            .map(|t| self.grey_gas_weights(t))
            .fold(PerBand::splat(false), |s, a| s.zip_map(a, |s, a| s || a > MIN_BAND_FRACTION))
    }
    /// Validates range, coefficients, signs and sum of the fractions.
    ///
    /// # Errors
    /// If a fraction is negative, or the sum is above 1, or below 1 without `allow_partial`.
    pub fn check(&self) -> Result<(), SceneError> {
        self.check_coefficients()?;
        check_sum(&[self])
    }
    /// Validates the fractions of all blocks of bands together.
    ///
    /// ```
    /// use zonal_scene::{BandFractions, Bands};
    /// let half = BandFractions::constant(Bands::from_rgb([0.2, 0.3, 0.0]));
    /// assert!(BandFractions::check_block_sums(&[half.clone(), half.clone()]).is_ok());
    /// assert!(BandFractions::check_block_sums(&[half]).is_err());
    /// ```
    ///
    /// # Errors
    /// As [`BandFractions::check`].
    pub fn check_block_sums(blocks: &[BandFractions]) -> Result<(), SceneError> {
        blocks.iter().try_for_each(BandFractions::check_coefficients)?;
        check_sum(&blocks.iter().collect::<Vec<_>>())
    }
    /// The key of the fractions in a scene file.
    fn key(&self) -> &'static str {
        if self.is_constant() { "thermal.band_fractions" } else { "thermal.weights" }
    }
    /// Validates range and coefficients.
    ///
    /// # Errors
    /// If the range is none, or a band has no finite coefficients.
    pub(crate) fn check_coefficients(&self) -> Result<(), SceneError> {
        let BandFractions::GreyGases { coefficients, range: [from, to], .. } = self else {
            return Ok(());
        };
        if !(*from > 0.0 && from <= to && *to <= MAX_TEMPERATURE) {
            return invalid(
                "thermal.range",
                format!("[{from}, {to}] is no range of temperatures; give kelvin, the lower first"),
            );
        }
        if coefficients.iter().any(|c| c.is_empty() || c.iter().any(|x| !x.is_finite())) {
            return invalid(
                self.key(),
                "a band has no finite coefficients; give c0, c1, … of its polynomial",
            );
        }
        Ok(())
    }
}

/// Validates signs and sum of the fractions of all band blocks of a scene.
///
/// # Errors
/// As [`BandFractions::check`].
pub(crate) fn check_sum(blocks: &[&BandFractions]) -> Result<(), SceneError> {
    let Some(first @ BandFractions::GreyGases { range, allow_partial, .. }) = blocks.first() else {
        return Ok(());
    };
    let key = first.key();
    for t in check_temperatures(*range) {
        let mut sum = 0.0;
        for (k, fractions) in blocks.iter().enumerate() {
            let a = fractions.grey_gas_weights(t);
            sum += a.sum();
            if let Some(b) = Band::all().find(|&b| a[b] < -FRACTION_SUM_TOLERANCE) {
                let (band, fraction) = (BANDS_PER_BLOCK * k + b.index(), a[b]);
                return invalid(
                    key,
                    format!(
                        "the fraction of band {band} is {fraction:.4} at {t:.0} K; give fractions from 0, or a range in which they are"
                    ),
                );
            }
        }
        if sum > 1.0 + FRACTION_SUM_TOLERANCE {
            return invalid(
                key,
                format!("the band fractions sum to {sum:.6} at {t:.0} K; let them sum to 1"),
            );
        }
        if sum < 1.0 - FRACTION_SUM_TOLERANCE && !allow_partial {
            return invalid(
                key,
                format!(
                    "the band fractions sum to {sum:.6} at {t:.0} K, not 1; write \"rest\" for one of the bands, or allow_partial = true to exclude the remaining emission"
                ),
            );
        }
    }
    Ok(())
}

/// Equidistant temperatures over a range, K.
fn check_temperatures([from, to]: [f64; 2]) -> impl Iterator<Item = f64> {
    (0..=TEMPERATURE_INTERVALS).map(move |k| from + (to - from) * k as f64 / TEMPERATURE_INTERVALS as f64)
}

/// Band fractions that differ from cell to cell of the medium, such as those of a gas of varying composition.
#[derive(Clone, Debug, PartialEq)]
pub struct CellFractions {
    /// The different fractions.
    pub kinds: Vec<BandFractions>,
    /// The kind of each cell, in the order of the voxel grid.
    pub kind_of_cell: Vec<u32>,
}

/// Thermal data of a scene; conditions of the medium's cells are in the voxel grid ([`crate::VoxelGrid::heat`]).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Thermal {
    /// The fraction of the emission in each band, where no cell has its own.
    pub band_fractions: BandFractions,
    /// Fractions of the cells of the medium and of the surfaces next to them; `None` if all are equal.
    pub cell_fractions: Option<CellFractions>,
    /// Condition of each surface; where its facets have conditions of their own ([`crate::FaceTable`]), one of the same kind that stands for them.
    pub surfaces: Vec<ThermalCondition>,
    /// Condition of each pane; a pane without temperature is in radiative equilibrium.
    pub panes: Vec<ThermalCondition>,
    /// Temperature of the surroundings, K; `None` for cold surroundings.
    pub surroundings: Option<f64>,
    /// Bodies at one temperature and convection; `None` without them.
    pub network: Option<ThermalNetwork>,
    /// Emissivities of each surface by temperature or by side; empty without them.
    pub emissivities: Vec<SurfaceEmissivity>,
}

impl Thermal {
    /// The band fractions of the scene, then those of the kinds of cells.
    pub fn all_fractions(&self) -> impl Iterator<Item = &BandFractions> {
        std::iter::once(&self.band_fractions).chain(self.cell_fractions.iter().flat_map(|f| &f.kinds))
    }
    /// True if the network has unknown temperatures, or convection at surfaces whose temperature is not given.
    pub(crate) fn has_unknown_nodes(&self) -> bool {
        let Some(network) = &self.network else { return false };
        let is_free = |k: usize| !matches!(self.surfaces[k], ThermalCondition::Temperature(_));
        (0..network.nodes.len()).any(|k| network.is_unknown(k))
            || network.convection.iter().enumerate().any(|(k, c)| c.is_some() && is_free(k))
    }
    /// True if some surface has an emissivity by temperature or by side.
    pub fn has_varied_emissivities(&self) -> bool {
        self.emissivities.iter().any(|e| *e != SurfaceEmissivity::default())
    }
    /// Radiance of the surroundings, W/(m² sr) per band.
    pub fn surroundings_radiance(&self) -> Bands {
        let e = self.surroundings.map_or(0.0, blackbody_emissive_power);
        self.band_fractions.emissive_powers(e)[0] / std::f64::consts::PI
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_polynomials_constant_outside_their_range() {
        let smith = BandFractions::GreyGases {
            coefficients: PerBand::from_rgb([
                vec![6.508e-1, -5.551e-4, 3.029e-7, -5.353e-11],
                vec![-0.2504e-1, 6.112e-4, -3.882e-7, 6.528e-11],
                vec![2.718e-1, -3.118e-4, 1.221e-7, -1.612e-11],
            ]),
            range: [600.0, 2400.0],
            allow_partial: true,
            all_bands: None,
        };
        assert!(smith.check().is_ok());
        let at = |t: f64| smith.grey_gas_weights(t);
        assert!((at(1000.0).first() - (0.6508 - 0.5551 + 0.3029 - 0.05353)).abs() < 1e-12);
        assert_eq!(at(300.0), at(600.0));
        // The derivative of a(T) σT⁴ with respect to σT⁴ by a central difference.
        let (e, h) = (blackbody_emissive_power(1300.0), 1e-6 * blackbody_emissive_power(1300.0));
        let [up, down] = [e + h, e - h].map(|e| smith.emissive_powers(e)[0]);
        let slope = smith.emissive_powers(e)[1];
        assert!(((up - down) / (2.0 * h) - slope).abs().all(|d| d < 1e-7));
    }

    #[test]
    fn band_fractions_that_do_not_sum_to_one_are_refused() {
        assert!(BandFractions::constant(Bands::from_rgb([0.2, 0.3, 0.5])).check().is_ok());
        for (invalid, expected) in
            [([0.2, 0.3, 0.4], "rest"), ([0.2, 0.3, 0.6], "sum to 1"), ([-0.2, 0.6, 0.6], "band 0")]
        {
            let e = BandFractions::constant(Bands::from_rgb(invalid)).check().unwrap_err().to_string();
            assert!(e.contains(expected), "{e}");
        }
    }

    #[test]
    fn temperatures_outside_the_range_are_refused() {
        for t in [0.0, -1.0, f64::NAN, 1e7] {
            assert!(ThermalCondition::Temperature(t).check(|k| k.into()).is_err());
        }
        assert_eq!(blackbody_temperature(blackbody_emissive_power(321.0)), 321.0);
        assert!(blackbody_temperature(-1.0).is_nan());
    }
}
