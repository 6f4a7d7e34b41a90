//! The state of all bands together: temperatures, net powers and sums of fluxes, and the errors that the balance of heat shows.

use super::band_state::BandState;
use super::band_system::MatrixData;
use super::exchange_data::ExchangeData;
use super::known_powers::times;
use super::thermal_state::ThermalState;
use crate::errors::closure_error::error_of_fraction;
use zonal_scene::ThermalCondition;
use zonal_scene::thermal::blackbody_temperature;

/// Residual of the balance, over the absorbed and the net powers of all zones, that rounding leaves.
const ROUNDING_OF_BALANCE: f64 = 1e-12;

/// How a zone enters the equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ZoneRole {
    /// Its temperature is known.
    Temperature,
    /// Its power is known in a grey scene: it is white.
    White,
    /// Its power is known, and its temperature couples the bands.
    Coupled,
    /// Its power is 0, and it emits in no band: it reflects, and has no temperature.
    Reflector,
}

/// Data of a state that all solved bands share.
pub(super) struct Assembly<'a> {
    pub data: &'a ExchangeData,
    /// The solved bands, and their matrices.
    pub bands: &'a [usize],
    pub matrices: Vec<MatrixData<'a>>,
    pub roles: &'a [ZoneRole],
    /// E of each zone, W/m²; NaN where it follows from the incident flux, or does not exist.
    pub emissive: Vec<f64>,
    /// w and dw/dE of each zone in every band; zeros where E is NaN.
    pub powers: Vec<Vec<[f64; 2]>>,
}

/// Sums of a zone over the solved bands.
#[derive(Default)]
struct ZoneSums {
    /// Σ m a h and Σ m a δh, W/m² or W/m³.
    absorbed: [f64; 2],
    /// Σ m a w and Σ m a dw/dE.
    emitted: [f64; 2],
    /// Σ h, δh, B and r δh, W/m².
    fluxes: [f64; 4],
    /// Σ a dw/dE.
    sent: f64,
}

impl Assembly<'_> {
    /// m a of a zone in solved band `s`: a, or 4κ a.
    fn weight(&self, s: usize, zone: usize) -> f64 {
        self.matrices[s].c[zone] / self.data.sizes[zone] * (1.0 - self.data.reflectance(self.bands[s], zone))
    }

    fn sums(&self, states: &[BandState], i: usize) -> ZoneSums {
        let mut sums = ZoneSums::default();
        let is_white = self.roles[i] == ZoneRole::White;
        for (s, state) in states.iter().enumerate() {
            let (r, weight) = (self.data.reflectance(self.bands[s], i), self.weight(s, i));
            let (h, dh) = (state.incident[i], state.error[i]);
            // The whole power of a grey scene is that of its band.
            let [w, slope] = if is_white { [0.0, 1.0] } else { self.powers[i][self.bands[s]] };
            let slope = slope.max(0.0);
            sums.absorbed = [sums.absorbed[0] + weight * h, sums.absorbed[1] + times(weight, dh)];
            sums.emitted = [sums.emitted[0] + weight * w, sums.emitted[1] + weight * slope];
            let own = [h, dh, state.radiosity[i], times(r, dh)];
            sums.fluxes.iter_mut().zip(own).for_each(|(f, x)| *f += x);
            sums.sent += (1.0 - r) * slope;
        }
        sums
    }

    /// The state of all bands together.
    pub(super) fn assemble(&self, states: &[BandState]) -> ThermalState {
        let d = self.data;
        let mut out = ThermalState::default();
        for (band, s) in self.bands.iter().zip(states) {
            let [incoming, emitted, escaped, backfaces, _] = d.light.powers(*band);
            out.surroundings += s.incoming - s.escaped + incoming - escaped;
            out.absorbed_backfaces += s.backfaces + backfaces;
            out.emitters += emitted;
        }
        for (i, role) in self.roles.iter().enumerate() {
            let sums = self.sums(states, i);
            let [h, dh, b, reflected] = sums.fluxes;
            let [absorbed, absorbed_error] = sums.absorbed;
            // T and δT, q and δq, δB.
            let (temperature, net, radiosity_error) = match d.conditions[i] {
                ThermalCondition::Temperature(t) => {
                    ([t, 0.0], [sums.emitted[0] - absorbed, absorbed_error], reflected)
                }
                ThermalCondition::Flux(q) | ThermalCondition::Power(q) => {
                    let error = absorbed_error / sums.emitted[1];
                    let (e, sent) = match role {
                        ZoneRole::White => ((absorbed + q) / sums.emitted[1], dh),
                        ZoneRole::Coupled => (self.emissive[i], reflected + times(sums.sent, error)),
                        ZoneRole::Reflector | ZoneRole::Temperature => (f64::NAN, reflected),
                    };
                    (temperature_of(e, error), [q, 0.0], sent)
                }
            };
            out.temperature.push(temperature[0]);
            out.temperature_error.push(temperature[1]);
            out.net.push(net[0]);
            out.net_error.push(net[1]);
            out.incident.push(h);
            out.incident_error.push(dh);
            out.radiosity.push(b);
            out.radiosity_error.push(radiosity_error);
        }
        out
    }

    /// Distributes the residual of the balance beyond the stated errors in proportion to the incident flux; true where there is any.
    pub(super) fn widen_by_balance(&self, state: &ThermalState, states: &mut [BandState]) -> bool {
        let d = self.data;
        let lost: f64 = states.iter().map(|s| s.escaped_error).sum();
        let explained: f64 = state.net_error.iter().zip(&d.sizes).map(|(e, s)| e * s).sum();
        let (mut absorbed, mut exchanged) = (0.0, 0.0);
        for (i, role) in self.roles.iter().enumerate() {
            let own: f64 = states.iter().enumerate().map(|(s, x)| self.weight(s, i) * x.incident[i]).sum();
            exchanged += d.sizes[i] * (own + state.net[i].abs());
            absorbed += if *role == ZoneRole::Temperature { d.sizes[i] * own } else { 0.0 };
        }
        let excess = state.balance(d).abs() - explained - lost;
        // An excess that is not a number gives an unknown error.
        if excess <= ROUNDING_OF_BALANCE * exchanged {
            return false;
        }
        let is_known = absorbed > 0.0 && excess.is_finite();
        let fraction = if is_known { excess / absorbed } else { f64::INFINITY };
        for s in states {
            s.error.iter_mut().zip(&s.incident).for_each(|(e, h)| *e += error_of_fraction(fraction, *h));
        }
        true
    }
}

/// T and its error, K, from E and its error, W/m²; NaN where E is not positive.
fn temperature_of(e: f64, error: f64) -> [f64; 2] {
    if e > 0.0 && e.is_finite() {
        let t = blackbody_temperature(e);
        return [t, 0.25 * t * error / e];
    }
    [f64::NAN; 2]
}
