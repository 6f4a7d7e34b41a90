//! Balances of zones over all bands of a scene: sums over its blocks of bands.
//!
//! E and q of a zone are common to all bands; m, a, r and the band fractions belong to one block each. In a grey scene every band holds the whole
//! power, and there is one block; otherwise the power is the sum over the bands.

use super::zone_balance::{ZoneBalance, ZoneBalances};
use zonal_scene::thermal::blackbody_emissive_power;
use zonal_scene::{BandFractions, Bands, Scene, ThermalCondition, Zones};

/// Maximum number of bracketing steps for E, and of steps in the bracket.
const MAX_BRACKETING_STEPS: usize = 200;
/// Change of E relative to it below which its iteration ends.
const RELATIVE_STEP: f64 = 4.0 * f64::EPSILON;

/// A scene of one block of bands and its zones.
#[derive(Clone, Copy)]
pub(crate) struct BlockZones<'a, 'b> {
    pub scene: &'a Scene,
    pub zones: &'b Zones,
}

/// The balances of all zones in every block of bands.
pub(super) struct SpectralBalances<'a> {
    /// The coefficients of each block.
    pub tables: Vec<ZoneBalances<'a>>,
    /// The balances of each block, by zone.
    pub zones: Vec<Vec<ZoneBalance>>,
}

impl<'a> SpectralBalances<'a> {
    /// Of the blocks of a scene in thermal mode.
    pub(super) fn new(blocks: &[BlockZones<'a, '_>]) -> SpectralBalances<'a> {
        let tables: Vec<ZoneBalances> = blocks.iter().map(|t| ZoneBalances::new(t.scene, t.zones)).collect();
        let zones = tables.iter().zip(blocks).map(|(table, t)| table.all(t.zones)).collect();
        SpectralBalances { tables, zones }
    }
    /// Number of zones.
    pub(super) fn len(&self) -> usize {
        self.zones.first().map_or(0, Vec::len)
    }
    /// Number of blocks.
    pub(super) fn blocks(&self) -> usize {
        self.tables.len()
    }
    /// Zone `i` in the first block: its condition, measure and share of the incident flux hold in all.
    pub(super) fn first(&self, i: usize) -> &ZoneBalance {
        &self.zones[0][i]
    }
    /// The band fractions of zone `i` in block `t`.
    pub(super) fn fractions(&self, t: usize, i: usize) -> &'a BandFractions {
        self.tables[t].fractions(&self.zones[t][i])
    }
    /// True if every band holds the whole emission.
    pub(super) fn is_grey(&self) -> bool {
        self.tables[0].thermal.band_fractions.is_grey()
    }
    /// The bands whose powers add up to the whole: all, or the first of a grey scene.
    pub(super) fn counted(&self) -> Bands {
        if self.is_grey() { Bands::from_fn(|b| if b.index() == 0 { 1.0 } else { 0.0 }) } else { Bands::ONE }
    }
    /// True if the balance of zone `i` is linear in its black emissive power.
    pub(super) fn is_linear(&self, i: usize) -> bool {
        self.has_constant_fractions(i) && self.first(i).convection.is_none()
    }
    /// True if no band fraction of zone `i` depends on temperature.
    pub(super) fn has_constant_fractions(&self, i: usize) -> bool {
        (0..self.blocks()).all(|t| self.fractions(t, i).is_constant())
    }
    /// Total of a quantity over all bands: the sum, or the common value of a grey scene.
    pub(super) fn total(&self, value: impl Fn(usize) -> Bands) -> f64 {
        if self.is_grey() {
            return value(0).first();
        }
        (1..self.blocks()).fold(value(0).sum(), |s, t| s + value(t).sum())
    }
    /// Total of a quantity over all bands, weighted by m a of zone `i`.
    pub(super) fn weighted_total(&self, i: usize, value: impl Fn(usize) -> Bands) -> f64 {
        self.total(|t| self.zones[t][i].absorption_weight() * value(t))
    }
    /// w of zone `i` in block `t` for a black emissive power `e`, W/m².
    pub(super) fn emissive_powers(&self, t: usize, i: usize, e: f64) -> Bands {
        self.fractions(t, i).emissive_powers(e)[0]
    }
    /// E of zone `i` with net power `q` and incident flux `h` of every block, W/m², by Newton's method in a bracket; `None` if it neither absorbs nor emits.
    pub(super) fn emissive_power_in_balance(
        &self,
        i: usize,
        q: f64,
        h: impl Fn(usize) -> Bands,
    ) -> Option<f64> {
        let sum = |a: &dyn Fn(usize) -> Bands| self.weighted_total(i, a);
        if sum(&|_| Bands::ONE) <= 0.0 {
            return None;
        }
        let wanted = q + sum(&h);
        if self.first(i).convection.is_some() {
            return Some(self.convective_balance(i, wanted));
        }
        if self.has_constant_fractions(i) || wanted <= 0.0 {
            let a = sum(&|t| self.fractions(t, i).grey_gas_weights(0.0));
            return (a > 0.0).then(|| wanted / a);
        }
        // The emitted power increases with E: bracket the solution, then take Newton steps, and bisect where one leaves the bracket.
        let emitted = |e: f64| sum(&|t| self.emissive_powers(t, i, e));
        let weights = self.zones.iter().flat_map(|z| z[i].absorption_weight());
        let most = weights.fold(0.0f64, f64::max);
        let (mut low, mut high) = (0.0, wanted / most);
        for _ in 0..MAX_BRACKETING_STEPS {
            if emitted(high) >= wanted {
                break;
            }
            (low, high) = (high, 2.0 * high);
        }
        Some(root_in_bracket([low, high], |e| {
            let [emitted, slope] = self.emitted_and_slope(i, e);
            [emitted - wanted, slope]
        }))
    }
    /// E of zone `i` that emits and convects the power `wanted`, W/m²; 0 if the air cannot supply a missing power.
    fn convective_balance(&self, i: usize, wanted: f64) -> f64 {
        let excess = |e: f64| {
            let ([emitted, slope], [convected, more]) =
                (self.emitted_and_slope(i, e), self.first(i).convected(e));
            [emitted + convected - wanted, slope + more]
        };
        let ambient = self.first(i).convection.map_or(0.0, |c| blackbody_emissive_power(c.ambient));
        let (mut low, mut high) = (0.0, ambient);
        for _ in 0..MAX_BRACKETING_STEPS {
            if excess(high)[0] >= 0.0 {
                break;
            }
            (low, high) = (high, 2.0 * high);
        }
        root_in_bracket([low, high], excess)
    }
    /// Σ m a w(E) of zone `i`, W/m² or W/m³, and its derivative with respect to E.
    pub(super) fn emitted_and_slope(&self, i: usize, e: f64) -> [f64; 2] {
        let of = |t: usize| {
            let weight = self.zones[t][i].absorption_weight() * self.counted();
            self.fractions(t, i).emissive_powers(e).map(|w| (weight * w).sum())
        };
        (1..self.blocks()).fold(of(0), |s, t| {
            let [w, slope] = of(t);
            [s[0] + w, s[1] + slope]
        })
    }
    /// E (W/m²) and q (W/m² or W/m³) of zone `i` for an incident flux `h` of every block; E is NaN if undefined.
    pub(super) fn emissive_and_net_power(&self, i: usize, h: impl Fn(usize) -> Bands) -> (f64, f64) {
        match self.first(i).condition {
            ThermalCondition::Temperature(t) => {
                let e = blackbody_emissive_power(t);
                (e, self.weighted_total(i, |t| self.emissive_powers(t, i, e) - h(t)))
            }
            ThermalCondition::Flux(q) | ThermalCondition::Power(q) => {
                let e = self.emissive_power_in_balance(i, q, h).unwrap_or(f64::NAN);
                (e, q - self.first(i).convected(e)[0])
            }
        }
    }
    /// Source of zone `i` in the linear equations of block `t`: emitted flux or black emissive power for a known temperature, else the source q in each
    /// band by the band fractions.
    pub(super) fn source(&self, t: usize, i: usize, is_patch: bool) -> Bands {
        let l = &self.zones[t][i];
        match self.first(i).condition {
            ThermalCondition::Temperature(kelvin) => {
                let w = self.emissive_powers(t, i, blackbody_emissive_power(kelvin));
                if is_patch { l.absorb * w } else { w }
            }
            ThermalCondition::Flux(q) | ThermalCondition::Power(q) if q != 0.0 => {
                let initial = self.tables[0].initial_temperature();
                let weight = |t: usize| self.fractions(t, i).grey_gas_weights(initial);
                let all = self.total(|t| weight(t) * self.zones[t][i].absorption_weight());
                if all > 0.0 { q * weight(t) * l.absorption_weight() / all } else { Bands::ZERO }
            }
            _ => Bands::ZERO,
        }
    }
}

/// The root of an increasing function in a bracket by Newton's method, with bisection where a step leaves the bracket; the function gives its value
/// and slope.
fn root_in_bracket([mut low, mut high]: [f64; 2], function: impl Fn(f64) -> [f64; 2]) -> f64 {
    let mut x = high;
    for _ in 0..MAX_BRACKETING_STEPS {
        let [value, slope] = function(x);
        if value < 0.0 {
            low = x
        } else {
            high = x
        }
        let newton = x - value / slope;
        let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
        let is_found = (next - x).abs() <= RELATIVE_STEP * x;
        x = next;
        if is_found {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_scene::{Mesh, PerBand, Scene};

    #[test]
    fn zone_in_balance_has_the_given_net_power() {
        let fractions = BandFractions::GreyGases {
            coefficients: PerBand::from_rgb([vec![0.2, 1e-4], vec![0.7, -1.5e-4], vec![0.1, 0.5e-4]]),
            range: [300.0, 3000.0],
            allow_partial: false,
            all_bands: None,
        };
        let mirror = Mesh::room([0.0; 3], [1.0; 3]).emissivity([0.0; 3]).heat_flux(0.0);
        let wall = Mesh::cuboid([0.2; 3], [0.4; 3]).emissivity([0.9, 0.3, 0.5]).heat_flux(0.0);
        let scene = Scene::builder().surface(mirror).surface(wall).band_fractions(fractions).build().unwrap();
        let transport = zonal_transport::Transport::new(&scene);
        let zones = zonal_transport::build_zones(&scene, &transport).unwrap();
        let b = SpectralBalances::new(&[BlockZones { scene: &scene, zones: &zones }]);
        let of = |surface: usize| zones.patches.iter().position(|p| p.surface == surface).unwrap();
        let i = of(1);
        for (q, h) in [(0.0, [1e4, 2e4, 5e3]), (5e4, [0.0; 3]), (-1e3, [1e5, 0.0, 3e4])] {
            let h = Bands::from_rgb(h);
            let e = b.emissive_power_in_balance(i, q, |_| h).unwrap();
            let net = b.weighted_total(i, |t| b.emissive_powers(t, i, e) - h);
            assert!((net - q).abs() < 1e-9 * (1e5 + q.abs()), "{q}");
        }
        assert_eq!(b.emissive_power_in_balance(of(0), 0.0, |_| Bands::ONE), None);
    }
}
