//! Temperatures: what is known of surfaces, panes and cells in thermal mode, and how black emission is shared by the bands.
//!
//! ```text
//!     E_b = σT⁴            w_b(T) = a_b(T) σT⁴            Σ_b a_b = 1
//!     patch:   B_b = (1−ρ_b) w_b + ρ_b H_b                q = Σ_b (1−ρ_b)(w_b − H_b)              W/m²
//!     volume:  B_b = (1−Ω_b) w_b + Ω_b G_b/4              Q = Σ_b κ_b(1−Ω_b)(4 w_b − G_b)         W/m³
//! ```
//!
//! Of each zone either T is known, or the power q (Q) that it gives: 0 for an adiabatic wall, or a medium in radiative equilibrium. In grey
//! scenes the three bands are one: each has all of the emission, and their sum stands for nothing.

use crate::scene::SceneError;
use crate::{Bands, Groups, Scene, bands};

/// σ, W/(m² K⁴).
pub const STEFAN_BOLTZMANN: f64 = 5.670374419e-8;

/// The highest temperature, K.
pub const LARGEST_TEMPERATURE: f64 = 1e6;

/// The largest modulus of a known net power, in W, W/m² or W/m³.
pub const LARGEST_POWER: f64 = 1e18;

/// Shares of the emission below this are rounding, such as that of a `"rest"` that nothing is left for.
const SMALLEST_SHARE: f64 = 1e-12;

/// How far shares of the emission may be from 1 in sum.
const SHARE_ROUNDING: f64 = 1e-6;

/// Temperatures over a range at which weights are checked.
const CHECKS: usize = 256;

/// σT⁴ of `t` kelvin, W/m².
pub fn black(t: f64) -> f64 {
    STEFAN_BOLTZMANN * t.powi(4)
}

/// The temperature of a black emissive power `e` (W/m²), K; not a number below 0.
pub fn temperature(e: f64) -> f64 {
    if e >= 0.0 { (e / STEFAN_BOLTZMANN).sqrt().sqrt() } else { f64::NAN }
}

/// What is known of a surface, a pane or a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Known {
    /// Its temperature, K.
    Temperature(f64),
    /// The net power that it gives: W/m² of a surface, W/m³ of a volume.
    Flux(f64),
    /// The net power of all of a surface, W, the same on every square metre.
    Power(f64),
}

impl Known {
    /// Refuses temperatures and powers that are none; `key` is where they were given.
    pub fn check(self, key: impl Fn(&str) -> String) -> Result<(), SceneError> {
        let (word, fine) = match self {
            Known::Temperature(t) => ("temperature", t > 0.0 && t <= LARGEST_TEMPERATURE),
            Known::Flux(q) => ("heat_flux", q.abs() <= LARGEST_POWER),
            Known::Power(p) => ("net_power", p.abs() <= LARGEST_POWER),
        };
        if fine {
            return Ok(());
        }
        let what = match self {
            Known::Temperature(t) => {
                format!("{t} K is out of range; give kelvin above 0, up to {LARGEST_TEMPERATURE:e}")
            }
            Known::Flux(q) | Known::Power(q) => power_out_of_range(q),
        };
        Err(SceneError::new(key(word), what))
    }
}

/// What is wrong with a power beyond [`LARGEST_POWER`].
pub fn power_out_of_range(q: f64) -> String {
    format!("{q:e} is out of range; give watts of a modulus up to {LARGEST_POWER:e}")
}

/// The share of the black emissive power that each band has.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Shares {
    /// All of it: three bands that are one.
    #[default]
    Grey,
    /// Polynomials a_b(T) = Σ_k c_k T^k in kelvin, held constant outside a range.
    Weights {
        /// c_0, c_1, … of each band.
        coefficients: [Vec<f64>; 3],
        /// The range in which they hold, K; the same number twice for constants.
        range: [f64; 2],
        /// Their sum may be below 1: what is left over takes no part.
        left_out: bool,
    },
}

impl Shares {
    /// Constant shares.
    pub fn constant(shares: Bands) -> Shares {
        Shares::Weights { coefficients: shares.map(|s| vec![s]), range: [1.0, 1.0], left_out: false }
    }
    /// True where the three bands are one.
    pub fn grey(&self) -> bool {
        *self == Shares::Grey
    }
    /// True where no share depends on temperature.
    pub fn is_constant(&self) -> bool {
        match self {
            Shares::Grey => true,
            Shares::Weights { coefficients, .. } => coefficients.iter().all(|c| c.len() == 1),
        }
    }
    /// a_b and da_b/dT (1/K) at `t` kelvin.
    fn at(&self, t: f64) -> [Bands; 2] {
        let Shares::Weights { coefficients, range, .. } = self else { return [[1.0; 3], [0.0; 3]] };
        let inside = t > range[0] && t < range[1];
        let t = t.clamp(range[0], range[1]);
        let value = |b: usize| coefficients[b].iter().rev().fold(0.0, |s, c| s * t + c);
        let slope = |b: usize| {
            let c = &coefficients[b];
            (1..c.len()).rev().fold(0.0, |s, k| s * t + k as f64 * c[k])
        };
        [bands(value), if inside { bands(slope) } else { [0.0; 3] }]
    }
    /// The share of each band at `t` kelvin.
    pub fn weights(&self, t: f64) -> Bands {
        self.at(t)[0]
    }
    /// w_b of a black emissive power `e`, W/m², and dw_b/de.
    pub fn emissive(&self, e: f64) -> [Bands; 2] {
        if self.is_constant() {
            let a = self.weights(0.0);
            return [a.map(|a| a * e), a];
        }
        let t = temperature(e.max(0.0));
        let [a, slope] = self.at(t);
        [a.map(|a| a * e), bands(|b| a[b] + 0.25 * t * slope[b])]
    }
    /// What values of the bands come to: their sum, or any of them in a grey scene.
    pub fn total(&self, v: Bands) -> f64 {
        if self.grey() { v[0] } else { v[0] + v[1] + v[2] }
    }
    /// Of each band, whether it has a share of the emission at some temperature.
    pub fn shining(&self) -> [bool; 3] {
        let Shares::Weights { range: [from, to], .. } = self else { return [true; 3] };
        let temperatures = (0..=CHECKS).map(|k| from + (to - from) * k as f64 / CHECKS as f64);
        temperatures
            .map(|t| self.weights(t))
            .fold([false; 3], |s, a| [0, 1, 2].map(|b| s[b] || a[b] > SMALLEST_SHARE))
    }
    /// Refuses shares that are negative or do not sum to 1.
    pub fn check(&self) -> Result<(), SceneError> {
        let Shares::Weights { coefficients, range: [from, to], left_out } = self else { return Ok(()) };
        let key = if self.is_constant() { "thermal.shares" } else { "thermal.weights" };
        let fail = |key: &str, what: String| Err(SceneError::new(key, what));
        if !(*from > 0.0 && from <= to && *to <= LARGEST_TEMPERATURE) {
            return fail(
                "thermal.range",
                format!("[{from}, {to}] is no range of temperatures; give kelvin, the lower first"),
            );
        }
        if coefficients.iter().any(|c| c.is_empty() || c.iter().any(|x| !x.is_finite())) {
            return fail(key, "a band has no finite coefficients; give c0, c1, … of its polynomial".into());
        }
        for k in 0..=CHECKS {
            let t = from + (to - from) * k as f64 / CHECKS as f64;
            let a = self.weights(t);
            let sum: f64 = a.iter().sum();
            if let Some(b) = (0..3).find(|&b| a[b] < -SHARE_ROUNDING) {
                return fail(
                    key,
                    format!(
                        "the share of band {b} is {:.4} at {t:.0} K; give shares from 0, or a range in which they are",
                        a[b]
                    ),
                );
            }
            if sum > 1.0 + SHARE_ROUNDING {
                return fail(key, format!("the shares sum to {sum:.6} at {t:.0} K; let them sum to 1"));
            }
            if sum < 1.0 - SHARE_ROUNDING && !left_out {
                return fail(
                    key,
                    format!(
                        "the shares sum to {sum:.6} at {t:.0} K, not 1; write \"rest\" for one of the bands, or left_out = true where what is left over takes no part"
                    ),
                );
            }
        }
        Ok(())
    }
}

/// What thermal mode knows of a scene beside its optical properties; cells of the medium know their own ([`crate::Voxmap::heat`]).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Thermal {
    /// The share of the emission in each band.
    pub shares: Shares,
    /// Of each surface.
    pub surfaces: Vec<Known>,
    /// Of each pane; a pane without temperature is in radiative equilibrium.
    pub panes: Vec<Known>,
    /// Temperature of the surroundings, K; none for cold ones.
    pub surroundings: Option<f64>,
}

impl Thermal {
    /// The radiance that comes in from the surroundings, W/(m² sr) a band.
    pub fn surroundings_radiance(&self) -> Bands {
        let e = self.surroundings.map_or(0.0, black);
        self.shares.emissive(e)[0].map(|w| w / std::f64::consts::PI)
    }
    /// Validates all of it with the scene it belongs to.
    pub(crate) fn check(&self, scene: &Scene) -> Result<(), SceneError> {
        self.shares.check()?;
        if self.surfaces.len() != scene.surfaces().len() || self.panes.len() != scene.panes().len() {
            return Err(SceneError::new(
                "thermal",
                "something is known of each surface and pane, or of none",
            ));
        }
        if !scene.lights().is_empty() {
            return Err(SceneError::new(
                "light",
                "lights belong to mode = \"light\"; in thermal mode give temperatures, or heat_flux to what the sun warms",
            ));
        }
        if scene.options().groups == Groups::Each {
            return Err(SceneError::new(
                "solve.groups",
                "heat is one sum: temperatures do not add up; remove this key in thermal mode",
            ));
        }
        if scene.options().sweeps.is_some() {
            return Err(SceneError::new(
                "solve.sweeps",
                "sweeps follow light, not heat; remove this key in thermal mode",
            ));
        }
        if let Some(t) = self.surroundings {
            Known::Temperature(t).check(|k| format!("surroundings.{k}"))?;
        }
        self.check_surfaces(scene)?;
        self.check_volumes(scene)
    }
    /// Refuses bands that differ where they are one.
    fn check_grey(&self, key: String, v: Bands) -> Result<(), SceneError> {
        if self.shares.grey() && !(v[0] == v[1] && v[1] == v[2]) {
            let what = "the bands differ, but a grey scene has one; give one number, or [thermal] shares of the emission";
            return Err(SceneError::new(key, what));
        }
        Ok(())
    }
    fn check_surfaces(&self, scene: &Scene) -> Result<(), SceneError> {
        let shining = self.shares.shining();
        for (s, known) in scene.surfaces().iter().zip(&self.surfaces) {
            let key = |k: &str| format!("surface '{}'.{k}", s.name);
            known.check(key)?;
            self.check_grey(key("emissivity"), s.reflectance)?;
            if s.emission != [0.0; 3] || s.emission_texture.is_some() || s.reflectance_texture.is_some() {
                return Err(SceneError::new(
                    key("emission"),
                    "emission and pictures belong to mode = \"light\"; give a temperature and an emissivity",
                ));
            }
            let (gives, word) = match known {
                Known::Temperature(_) => (false, ""),
                Known::Flux(q) => (*q != 0.0, "heat_flux"),
                Known::Power(p) => (*p != 0.0, "net_power"),
            };
            if gives && s.reflectance == [1.0; 3] {
                return Err(SceneError::new(
                    key(word),
                    "a surface of emissivity 0 can give no power; raise its emissivity, or give 0",
                ));
            }
            if gives && !(0..3).any(|b| shining[b] && s.reflectance[b] < 1.0) {
                return Err(SceneError::new(
                    key(word),
                    "the emissivity is 0 in every band that has a share of the emission, so that the surface can give no power; raise it in one of them, or give 0",
                ));
            }
        }
        Ok(())
    }
    fn check_volumes(&self, scene: &Scene) -> Result<(), SceneError> {
        for (p, known) in scene.panes().iter().zip(&self.panes) {
            let key = |k: &str| format!("pane '{}'.{k}", p.name);
            known.check(key)?;
            self.check_grey(key("extinction"), p.extinction)?;
            self.check_grey(key("albedo"), p.albedo)?;
            if p.emission != [0.0; 3] {
                return Err(SceneError::new(
                    key("emission"),
                    "emission belongs to mode = \"light\"; give a temperature",
                ));
            }
            if !matches!(known, Known::Temperature(_) | Known::Flux(0.0)) {
                return Err(SceneError::new(
                    key("heat_source"),
                    "a pane has a temperature, or heat_source = 0; give one of them",
                ));
            }
        }
        let Some(map) = scene.voxmap() else { return Ok(()) };
        if !map.is_thermal() {
            return Err(SceneError::new(
                "medium",
                "neither temperature nor heat_source is given; write heat_source = 0 for radiative equilibrium",
            ));
        }
        let shining = self.shares.shining();
        for i in 0..if map.is_uniform() { 1 } else { map.len() } {
            self.check_grey("medium.extinction".into(), map.extinction(i))?;
            self.check_grey("medium.albedo".into(), map.albedo(i))?;
            if map.emission(i) != [0.0; 3] || map.source(i) != [0.0; 3] {
                return Err(SceneError::new(
                    "medium.emission",
                    "emission and source belong to mode = \"light\"; give temperature or heat_source",
                ));
            }
            let (k, o) = (map.extinction(i), map.albedo(i));
            let gives = matches!(map.heat(i), Some(Known::Flux(q) | Known::Power(q)) if q != 0.0);
            if gives && !(0..3).any(|b| shining[b] && k[b] * (1.0 - o[b]) > 0.0) {
                let [x, y, z] = map.coordinates(i);
                let what = format!(
                    "in cell ({x}, {y}, {z}) the medium absorbs in no band that has a share of the emission, so that it can give no heat; raise extinction or shares there, or give 0"
                );
                return Err(SceneError::new("medium.heat_source", what));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_polynomials_held_constant_outside_their_range() {
        let smith = Shares::Weights {
            coefficients: [
                vec![6.508e-1, -5.551e-4, 3.029e-7, -5.353e-11],
                vec![-0.2504e-1, 6.112e-4, -3.882e-7, 6.528e-11],
                vec![2.718e-1, -3.118e-4, 1.221e-7, -1.612e-11],
            ],
            range: [600.0, 2400.0],
            left_out: true,
        };
        assert!(smith.check().is_ok());
        let at = |t: f64| smith.weights(t);
        assert!((at(1000.0)[0] - (0.6508 - 0.5551 + 0.3029 - 0.05353)).abs() < 1e-12);
        assert_eq!(at(300.0), at(600.0));
        // The slope of a(T) σT⁴ over σT⁴ by a difference.
        let (e, h) = (black(1300.0), 1e-6 * black(1300.0));
        let [up, down] = [e + h, e - h].map(|e| smith.emissive(e)[0]);
        for b in 0..3 {
            assert!(((up[b] - down[b]) / (2.0 * h) - smith.emissive(e)[1][b]).abs() < 1e-7);
        }
    }

    #[test]
    fn shares_that_do_not_add_up_are_refused() {
        assert!(Shares::constant([0.2, 0.3, 0.5]).check().is_ok());
        for (bad, word) in
            [([0.2, 0.3, 0.4], "rest"), ([0.2, 0.3, 0.6], "sum to 1"), ([-0.2, 0.6, 0.6], "band 0")]
        {
            let e = Shares::constant(bad).check().unwrap_err().to_string();
            assert!(e.contains(word), "{e}");
        }
    }

    #[test]
    fn kelvin_start_above_zero() {
        for t in [0.0, -1.0, f64::NAN, 1e7] {
            assert!(Known::Temperature(t).check(|k| k.into()).is_err());
        }
        assert_eq!(temperature(black(321.0)), 321.0);
        assert!(temperature(-1.0).is_nan());
    }
}
