//! Temperatures of zones of known power in scenes of several bands, by Newton's method.
//!
//! With E = σT⁴, m, a and the fractions w_b(E) with slopes ψ_b = dw_b/dE, the zones i of known power q obey
//!
//! ```text
//!     Σ_b m_ib a_ib (w_ib(E_i) − h_ib) = q_i          h_ib = h⁰_ib + Σ_j R_b,ij a_jb w_jb(E_j)          R_b = (1/c_b) (I − F_b D_b)⁻¹ F_b
//!     J_ij = Σ_b m_ib a_ib (ψ_ib δ_ij − R_b,ij a_jb ψ_jb)
//! ```
//!
//! with the sum over j of known power, and h⁰ of all other sources. R is kept as long as the factors and the set of these zones hold. With constant fractions the equations are
//! linear, and one step solves them. **Errors.** δh of fixed sources gives J δE = Σ_b m a δh, no entry of J⁻¹ being negative for ψ ≥ 0, and the zones send out a ψ δE more.
//!
//! Cost for k zones of known power: k solutions with the factor of each band once, k³/3 for each step.

use super::band_state::{BandProblem, BandState};
use super::gaussian_elimination;
use super::zone_fractions::ZoneFractions;
use zonal_math::parallel;
use zonal_scene::SceneError;

/// Maximum number of steps.
const MAX_STEPS: usize = 60;
/// Step, over the largest E, after which one more ends the iteration: each step squares it.
const LAST_STEP: f64 = 1e-9;

/// The zones of known power and their responses.
pub(super) struct PowerResponse {
    pub zones: Vec<usize>,
    /// R of each band, row by row.
    bands: Vec<Vec<f64>>,
}

/// m a and a of the zones of known power in each band, and how they emit.
pub(super) struct Coupling<'a> {
    pub response: &'a PowerResponse,
    pub fractions: &'a ZoneFractions,
    /// The bands that are solved, and the number of all bands.
    pub bands: (&'a [usize], usize),
    /// m a and a of each solved band, by zone of known power.
    pub weights: Vec<Vec<[f64; 2]>>,
}

impl PowerResponse {
    /// The responses of zones.
    pub(super) fn new(problems: &[BandProblem], zones: Vec<usize>) -> PowerResponse {
        let k = zones.len();
        let of_band = |p: &BandProblem| {
            let mut rows = vec![0.0; k * k];
            let columns: Vec<Vec<f64>> = parallel::map(&zones, |&j| {
                let mut unit = vec![0.0; p.sources.len()];
                unit[j] = 1.0;
                let h = p.response(&unit);
                zones.iter().map(|&i| h[i]).collect()
            });
            for (j, column) in columns.iter().enumerate() {
                column.iter().enumerate().for_each(|(i, h)| rows[i * k + j] = *h);
            }
            rows
        };
        let bands = problems.iter().map(of_band).collect();
        PowerResponse { zones, bands }
    }
}

impl Coupling<'_> {
    /// w and ψ of each zone of known power in each solved band for black emissive powers, W/m².
    fn emission(&self, e: &[f64]) -> Vec<Vec<[f64; 2]>> {
        let (solved, count) = self.bands;
        let zones = &self.response.zones;
        let of_zone = |k: usize| self.fractions.emissive_powers(self.fractions.kind(zones[k]), e[k], count);
        let all: Vec<_> = parallel::collect(zones.len(), of_zone);
        solved.iter().map(|b| all.iter().map(|w| w[*b]).collect()).collect()
    }

    /// J for slopes ψ.
    fn jacobian(&self, emission: &[Vec<[f64; 2]>]) -> Vec<f64> {
        let k = self.response.zones.len();
        let mut out = vec![0.0; k * k];
        parallel::chunks(&mut out, k, |i, row| {
            for ((response, weights), own) in self.response.bands.iter().zip(&self.weights).zip(emission) {
                let ma = weights[i][0];
                row[i] += ma * own[i][1];
                for (j, x) in row.iter_mut().enumerate() {
                    *x -= ma * response[i * k + j] * weights[j][1] * own[j][1];
                }
            }
        });
        out
    }

    /// E of the zones, W/m², for net powers q in W/m² and W/m³ and problems without their emission, from a first E.
    ///
    /// # Errors
    /// If the iteration does not converge.
    pub(super) fn solve(
        &self,
        problems: &[BandProblem],
        q: &[f64],
        first: f64,
    ) -> Result<Vec<f64>, SceneError> {
        let zones = &self.response.zones;
        let k = zones.len();
        let constant: Vec<Vec<f64>> = parallel::map(problems, |p| {
            let h = p.reflected_incident();
            zones.iter().map(|&i| h[i] + p.light[0].get(i).copied().unwrap_or(0.0)).collect()
        });
        let mut e = vec![first; k];
        let mut is_last = false;
        for _ in 0..MAX_STEPS {
            let emission = self.emission(&e);
            let missing = |i: usize| {
                let of_band = |s: usize| {
                    let (weights, own, row) =
                        (&self.weights[s], &emission[s], &self.response.bands[s][i * k..(i + 1) * k]);
                    let sent: f64 = row.iter().zip(weights).zip(own).map(|((r, x), w)| r * x[1] * w[0]).sum();
                    weights[i][0] * (own[i][0] - constant[s][i] - sent)
                };
                q[i] - (0..problems.len()).map(of_band).sum::<f64>()
            };
            let missing: Vec<f64> = parallel::collect(k, missing);
            let Some(step) = gaussian_elimination::solve(self.jacobian(&emission), missing) else { break };
            e.iter_mut().zip(&step).for_each(|(e, s)| *e += s);
            let largest = |list: &[f64]| list.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            if is_last {
                return Ok(e);
            }
            is_last = largest(&step) <= LAST_STEP * largest(&e);
        }
        let what = "the temperatures of the zones of known power do not converge; give more zones temperatures, or use zonal solve for this scene";
        Err(SceneError::new("heat_flux", what))
    }

    /// Adds to the errors of all bands what the errors of E of the zones cause.
    pub(super) fn add_reemission(&self, problems: &[BandProblem], e: &[f64], states: &mut [BandState]) {
        let zones = &self.response.zones;
        let mut emission = self.emission(e);
        emission.iter_mut().flatten().for_each(|w| w[1] = w[1].max(0.0));
        let absorbed = |k: usize| {
            let of_band =
                |(weights, state): (&Vec<[f64; 2]>, &BandState)| times(weights[k][0], state.error[zones[k]]);
            self.weights.iter().zip(&*states).map(of_band).sum::<f64>()
        };
        let absorbed: Vec<f64> = (0..zones.len()).map(absorbed).collect();
        let known = absorbed.iter().all(|x| x.is_finite());
        let found = known.then(|| gaussian_elimination::solve(self.jacobian(&emission), absorbed)).flatten();
        let Some(more) = found.filter(|list| list.iter().all(|x| x.is_finite())) else {
            states.iter_mut().for_each(|s| s.error.fill(f64::INFINITY));
            return;
        };
        parallel::for_each(states, |s, state| {
            let mut sent = vec![0.0; state.error.len()];
            for (k, &i) in zones.iter().enumerate() {
                sent[i] = self.weights[s][k][1] * emission[s][k][1] * more[k].abs();
            }
            state.error.iter_mut().zip(problems[s].response(&sent)).for_each(|(e, h)| *e += h.abs());
        });
    }
}

/// w x, 0 for a weight of 0 also where x is infinite.
pub(super) fn times(w: f64, x: f64) -> f64 {
    if w == 0.0 { 0.0 } else { w * x }
}
