//! Temperatures of layers and walls of given net power.
//!
//! The net power P_i of an element is Σ_b Σ_j K^b_ij e_bj with e_bj = a_b(T_j) σT_j⁴. Newton's method in u = σT⁴ solves P_i = given; a step that
//! does not lower the largest scaled residual is halved. Grey media need one step.

use super::band::{BandEmission, BandSolution, BandSweeper};
use super::{STEFAN_BOLTZMANN, Slab, linear};

/// Maximum number of Newton steps, and of halvings of a step.
const MAX_STEPS: usize = 60;
/// Change of u, relative, at which the iteration ends.
const TOLERANCE: f64 = 1e-13;
/// Relative step of the derivative of the emission with respect to u.
const DERIVATIVE_STEP: f64 = 1e-5;

/// What is known of a layer or a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SlabCondition {
    /// Its temperature, K.
    Temperature(f64),
    /// Its net power, the power that it emits less the power that it absorbs: W/m³ of a layer, W/m² of a wall. It must absorb in some band.
    NetPower(f64),
}

/// A slab in radiative equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub struct Equilibrium {
    /// Temperatures of the layers, K.
    pub layer_temperatures: Vec<f64>,
    /// Temperatures of the walls, K.
    pub wall_temperatures: [f64; 2],
    /// The solution of each band.
    pub bands: Vec<BandSolution>,
}

/// The equations of a slab.
struct Balance<'a> {
    /// Net power by unit emission: band, row, column.
    net_power: Vec<Vec<Vec<f64>>>,
    /// Elements of given net power, with it.
    free: Vec<(usize, f64)>,
    weight: &'a dyn Fn(usize, usize, f64) -> f64,
}

impl Slab {
    /// Temperatures and fields for given conditions of the layers and the walls. `weight(i, b, T)` is the weight of band `b` in element `i` at T,
    /// K; elements are the layers, then the two walls. `None` if the iteration fails, as it may where an emission falls with T.
    ///
    /// # Panics
    /// If the lengths of the arrays disagree, or if no element has a temperature.
    pub fn equilibrium(
        &self,
        layers: &[SlabCondition],
        walls: [SlabCondition; 2],
        weight: &dyn Fn(usize, usize, f64) -> f64,
    ) -> Option<Equilibrium> {
        assert_eq!(layers.len(), self.thickness.len(), "one condition a layer");
        let conditions: Vec<SlabCondition> = layers.iter().chain(&walls).copied().collect();
        let emissive_power = |t: f64| STEFAN_BOLTZMANN * t.powi(4);
        let known = conditions.iter().filter_map(|c| match c {
            SlabCondition::Temperature(t) => Some(emissive_power(*t)),
            SlabCondition::NetPower(_) => None,
        });
        let start = known.clone().sum::<f64>() / known.count() as f64;
        assert!(start.is_finite(), "one temperature must be given");
        let (mut free, mut u) = (Vec::new(), vec![start; conditions.len()]);
        for (i, c) in conditions.iter().enumerate() {
            match *c {
                SlabCondition::Temperature(t) => u[i] = emissive_power(t),
                SlabCondition::NetPower(p) => free.push((i, p)),
            }
        }
        let net_power = self.bands.iter().map(|b| BandSweeper::new(b, &self.thickness).net_power()).collect();
        let balance = Balance { net_power, free, weight };
        balance.iterate(&mut u)?;
        Some(self.fields(&balance, &u))
    }

    fn fields(&self, balance: &Balance, u: &[f64]) -> Equilibrium {
        let n = self.thickness.len();
        let emission = |b: usize| {
            let e: Vec<f64> = (0..u.len()).map(|i| balance.emission(b, i, u[i])).collect();
            BandEmission { layers: e[..n].to_vec(), walls: [e[n], e[n + 1]] }
        };
        let emission: Vec<BandEmission> = (0..self.bands.len()).map(emission).collect();
        let temperatures: Vec<f64> = u.iter().map(|u| temperature(*u)).collect();
        Equilibrium {
            layer_temperatures: temperatures[..n].to_vec(),
            wall_temperatures: [temperatures[n], temperatures[n + 1]],
            bands: self.solve(&emission),
        }
    }
}

fn temperature(u: f64) -> f64 {
    (u / STEFAN_BOLTZMANN).powf(0.25)
}

impl Balance<'_> {
    /// Emission of band `b` in element `i`, W/m².
    fn emission(&self, b: usize, i: usize, u: f64) -> f64 {
        (self.weight)(i, b, temperature(u)) * u
    }

    /// Derivative of the emission with respect to u.
    fn slope(&self, b: usize, i: usize, u: f64) -> f64 {
        let h = DERIVATIVE_STEP * u;
        (self.emission(b, i, u + h) - self.emission(b, i, u - h)) / (2.0 * h)
    }

    /// Net power less the given one for each free element.
    fn residual(&self, u: &[f64]) -> Vec<f64> {
        let emission: Vec<Vec<f64>> = (0..self.net_power.len())
            .map(|b| (0..u.len()).map(|j| self.emission(b, j, u[j])).collect())
            .collect();
        let of = |&(i, given): &(usize, f64)| {
            let band =
                |(k, e): (&Vec<Vec<f64>>, &Vec<f64>)| k[i].iter().zip(e).map(|(k, e)| k * e).sum::<f64>();
            self.net_power.iter().zip(&emission).map(band).sum::<f64>() - given
        };
        self.free.iter().map(of).collect()
    }

    /// The Newton step of the free elements.
    fn step(&self, u: &[f64], residual: &[f64]) -> Option<Vec<f64>> {
        let slopes: Vec<Vec<f64>> = (0..self.net_power.len())
            .map(|b| self.free.iter().map(|&(j, _)| self.slope(b, j, u[j])).collect())
            .collect();
        let entry = |i: usize, c: usize| {
            self.net_power.iter().zip(&slopes).map(|(k, s)| k[i][self.free[c].0] * s[c]).sum::<f64>()
        };
        let matrix =
            self.free.iter().map(|&(i, _)| (0..self.free.len()).map(|c| entry(i, c)).collect()).collect();
        let right = residual.iter().map(|r| vec![-r]).collect();
        Some(linear::solve(matrix, right)?.into_iter().map(|r| r[0]).collect())
    }

    /// Largest residual over the power that the element would emit alone.
    fn norm(&self, u: &[f64], residual: &[f64]) -> f64 {
        let scaled = |(r, &(i, _)): (&f64, &(usize, f64))| {
            let alone: f64 = self.net_power.iter().map(|k| k[i][i].abs()).sum();
            (r / (alone * u[i])).abs()
        };
        residual.iter().zip(&self.free).map(scaled).fold(0.0, f64::max)
    }

    fn iterate(&self, u: &mut Vec<f64>) -> Option<()> {
        let mut residual = self.residual(u);
        let mut norm = self.norm(u, &residual);
        for _ in 0..MAX_STEPS {
            let step = self.step(u, &residual)?;
            let change = step.iter().zip(&self.free).map(|(d, &(i, _))| (d / u[i]).abs()).fold(0.0, f64::max);
            if change <= TOLERANCE || norm == 0.0 {
                return Some(());
            }
            let mut damping = 1.0;
            let accepted = (0..MAX_STEPS).find_map(|_| {
                let mut next = u.clone();
                for (d, &(i, _)) in step.iter().zip(&self.free) {
                    next[i] += damping * d;
                }
                damping *= 0.5;
                let positive = self.free.iter().all(|&(i, _)| next[i] > 0.0);
                let r = self.residual(&next);
                let m = self.norm(&next, &r);
                (positive && m < norm).then_some((next, r, m))
            });
            match accepted {
                Some((next, r, m)) => (*u, residual, norm) = (next, r, m),
                // Rounding is all that is left.
                None => return (change <= TOLERANCE.sqrt()).then_some(()),
            }
        }
        None
    }
}
