//! Temperatures of several bands: Newton's iteration on E, a linear solve of all bands at once in each step.
//!
//! About E⁰ a zone of known power emits w_b(E) ≈ w_b⁰ + ψ_b (E − E⁰), ψ = dw/dE. Its balance gives E from what arrives, so that
//!
//! ```text
//!     B_b = a_b [ w_b⁰ + ψ_b (q − Σ_c m_c a_c w_c⁰)/S ] + r_b h_b + a_b ψ_b Σ_c m_c a_c h_c / S          S = Σ_c m_c a_c ψ_c
//! ```
//!
//! which is linear in what arrives: light of one band is taken up and given back in all, and power is kept. Constant shares are solved by one
//! step. Otherwise E follows and the next step is about it. The residual is the emission that the straight line puts into wrong
//! bands, relative to all that is emitted:
//!
//! ```text
//!     R = Σ_i V_i Σ_b m_b a_b |w_b(E) − w_b⁰ − ψ_b (E − E⁰)| / Σ_i V_i Σ_b m_b a_b |w_b(E)|
//! ```
//!
//! A step changes no temperature by more than half; where weights fall so fast that ψ_b < 0, ψ = a(T) takes its place (Picard), and
//! steps are halved when R no longer falls. The end is a status.

use super::linear;
use super::local::{Local, Locals};
use crate::engine::{Built, Site};
use crate::krylov::Ended;
use crate::operator::Operator;
use crate::surroundings::Escape;
use rayon::prelude::*;
use zonal_exchange::pair::{strength, target};
use zonal_scene::thermal::black;
use zonal_scene::{Bands, Known, Scene, SceneError, Shares, SolveStatus, Zones, bands};

/// Steps of the iteration over temperatures.
const STEPS: usize = 60;
/// Steps without a smaller residual after which they are halved, and after how many more no better one is waited for.
const PATIENCE: usize = 4;
const LAST: usize = 20;
/// The most that E grows or falls in a step, as a factor.
const REACH: f64 = 5.0;
/// The linear solves' residual over that of the temperatures.
const FINER: f64 = 0.1;
/// Bytes a zone: its part in the equations, its turn, and the vectors of the linear solve.
const BYTES: u64 = 400 + 12 * 24;

/// What a zone makes of what arrives, in the linear equations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    own: Bands,
    reflect: Bands,
    /// a ψ/S, and m a: none of them where the temperature is known.
    again: Bands,
    uptake: Bands,
}

impl Turn {
    pub fn of(l: &Local, shares: &Shares, e: f64) -> Turn {
        let [w, mut slope] = shares.emissive(e);
        let uptake = l.uptake();
        let known = Turn {
            own: bands(|b| l.absorb[b] * w[b]),
            reflect: l.reflect,
            again: [0.0; 3],
            uptake: [0.0; 3],
        };
        let q = match l.known {
            Known::Temperature(_) => return known,
            Known::Flux(q) | Known::Power(q) => q,
        };
        if slope.iter().any(|s| *s < 0.0) {
            slope = shares.weights(zonal_scene::thermal::temperature(e.max(0.0)));
        }
        let sum = |v: Bands| v[0] + v[1] + v[2];
        let all = sum(bands(|b| uptake[b] * slope[b]));
        if all <= 0.0 {
            return known;
        }
        let missing = (q - sum(bands(|b| uptake[b] * w[b]))) / all;
        Turn {
            own: bands(|b| l.absorb[b] * (w[b] + slope[b] * missing)),
            again: bands(|b| l.absorb[b] * slope[b] / all),
            uptake,
            ..known
        }
    }
    /// The part of B that comes of what arrives.
    pub fn passed(&self, h: Bands) -> Bands {
        let taken = self.uptake[0] * h[0] + self.uptake[1] * h[1] + self.uptake[2] * h[2];
        bands(|b| self.reflect[b] * h[b] + self.again[b] * taken)
    }
}

/// Zones in units of power, for the linear solve.
pub(super) struct Powers {
    /// t and c.
    scale: Vec<(f64, Bands)>,
    /// What h is of P: 1/A or 1/(4V).
    over: Vec<f64>,
}

impl Powers {
    pub fn new(zones: &Zones, locals: &[Local]) -> Powers {
        let scale =
            (0..zones.len()).into_par_iter().map(|i| (target(zones, i), strength(zones, i))).collect();
        Powers { scale, over: locals.iter().map(|l| l.part / l.measure).collect() }
    }
    /// The power of a zone's radiosity.
    pub fn of(&self, i: usize, radiosity: Bands) -> Bands {
        let (t, c) = self.scale[i];
        bands(|b| t * c[b] * radiosity[b])
    }
    pub fn strengths(&self, u: &[Bands]) -> Vec<Bands> {
        u.par_iter().zip(&self.scale).map(|(u, (t, _))| u.map(|x| x / t)).collect()
    }
    /// h of every zone, without what comes from the surroundings.
    pub fn arriving(&self, operator: &dyn Operator, u: &[Bands]) -> Vec<Bands> {
        let mut p = operator.apply(&self.strengths(u));
        p.par_iter_mut().zip(&self.over).for_each(|(p, o)| *p = p.map(|x| x * o));
        p
    }
    /// M u.
    pub fn passed(
        &self,
        operator: &dyn Operator,
        u: &[Bands],
        turn: impl Fn(usize, Bands) -> Bands + Sync,
    ) -> Vec<Bands> {
        let h = self.arriving(operator, u);
        (0..u.len()).into_par_iter().map(|i| self.of(i, turn(i, h[i]))).collect()
    }
}

/// The solution of a scene whose bands are coupled.
pub struct Coupled {
    /// Zones that emit what they were found to emit.
    pub zones: Zones,
    /// Strengths, and how the iteration over temperatures ended, in every band alike.
    pub ended: Ended,
    /// Products with the operator.
    pub products: usize,
}

/// True where some net power is known and the scene is not grey.
pub fn needed(scene: &Scene) -> bool {
    let Some(thermal) = scene.thermal() else { return false };
    let open = |k: &Known| !matches!(k, Known::Temperature(_));
    let cells = || scene.voxmap().is_some_and(|m| (0..m.len()).any(|i| m.heat(i).as_ref().is_some_and(open)));
    !thermal.shares.grey() && (thermal.surfaces.iter().any(open) || thermal.panes.iter().any(open) || cells())
}

/// Iterates over the temperatures of a scene that needs it.
pub fn solve(site: &Site, built: &Built, escape: &Escape) -> Result<Coupled, SceneError> {
    let (scene, n) = (site.scene, site.zones.len());
    let bytes = BYTES * n as u64;
    if bytes > site.memory {
        let what = format!(
            "the iteration over temperatures of {n} zones needs {:.3} GB, more than the {:.3} GB allowed; use larger patches or fewer cells, or allow more (--max-memory)",
            bytes as f64 / 1e9,
            site.memory as f64 / 1e9
        );
        return Err(SceneError::new("solve.patch_size", what));
    }
    let table = Locals::new(scene, site.zones);
    let shares = &table.thermal.shares;
    let locals = table.all(site.zones);
    let operator = built.operator.as_ref();
    let powers = Powers::new(site.zones, &locals);
    let sky = scene.surroundings().radiosity();
    // h that comes from the surroundings.
    let outside: Vec<Bands> =
        (0..n).into_par_iter().map(|i| escape.incoming(i, sky)[0].map(|x| x * powers.over[i])).collect();
    let options = scene.options();
    let wanted = options.residual;
    let begin = black(table.level());
    let mut e: Vec<f64> =
        locals.iter().map(|l| if let Known::Temperature(t) = l.known { black(t) } else { begin }).collect();
    let mut u: Option<Vec<Bands>> = None;
    let (mut residuals, mut status) = (Vec::new(), SolveStatus::Budget);
    let (mut best, mut since, mut pace, mut products) = (f64::INFINITY, 0, 1.0, 0);
    site.progress.begin("temperatures", STEPS as u64);
    for step in 0..STEPS {
        let turns: Vec<Turn> = locals.par_iter().zip(&e).map(|(l, e)| Turn::of(l, shares, *e)).collect();
        let source: Vec<Bands> = (0..n)
            .into_par_iter()
            .map(|i| {
                let sky = turns[i].passed(outside[i]);
                powers.of(i, bands(|b| turns[i].own[b] + sky[b]))
            })
            .collect();
        let passed = |u: &[Bands]| powers.passed(operator, u, |i, h| turns[i].passed(h));
        let start = u.take().unwrap_or_else(|| source.clone());
        let end = linear::solve(passed, &source, start, FINER * wanted, options.max_iterations);
        products += end.products + 1;
        let h = powers.arriving(operator, &end.u);
        u = Some(end.u);
        let (next, off) = stepped(&locals, shares, &e, |i| bands(|b| h[i][b] + outside[i][b]), pace);
        e = next;
        residuals.push(off.max(end.residual));
        site.progress.advance(1);
        if off <= wanted {
            status = if end.residual <= wanted { SolveStatus::Converged } else { SolveStatus::Stalled };
            break;
        }
        since = if off < best { 0 } else { since + 1 };
        best = best.min(off);
        if since >= PATIENCE {
            pace = 0.5;
        }
        if since >= LAST || !off.is_finite() || step + 1 == STEPS {
            status =
                if since >= LAST || !off.is_finite() { SolveStatus::Stalled } else { SolveStatus::Budget };
            break;
        }
    }
    site.progress.end();
    let mut zones = site.zones.clone();
    let emissive: Vec<Bands> = e.iter().map(|e| shares.emissive(*e)[0]).collect();
    super::physical(scene, &mut zones, &emissive);
    let u = u.unwrap_or_default();
    let given = linear::power(&u);
    let ended = Ended {
        strengths: powers.strengths(&u),
        status: [status; 3],
        residuals: [0, 1, 2].map(|_| residuals.clone()),
        power: [given; 3],
    };
    Ok(Coupled { zones, ended, products })
}

/// E after a step, and R.
fn stepped(
    locals: &[Local],
    shares: &Shares,
    old: &[f64],
    h: impl Fn(usize) -> Bands + Sync,
    pace: f64,
) -> (Vec<f64>, f64) {
    let one = |i: usize| {
        let l = &locals[i];
        let (turn, uptake) = (Turn::of(l, shares, old[i]), l.uptake());
        let taken: f64 = turn.uptake.iter().zip(h(i)).map(|(m, h)| m * h).sum();
        // What the straight line emits in each band.
        let line = bands(|b| turn.own[b] + turn.again[b] * taken);
        let e = match l.known {
            Known::Temperature(_) => old[i],
            Known::Flux(q) | Known::Power(q) => {
                let found = l.balanced(shares, q, h(i)).unwrap_or(old[i]);
                // Constant shares are a straight line already.
                let (low, high) = if shares.is_constant() || found <= 0.0 {
                    (f64::NEG_INFINITY, f64::INFINITY)
                } else {
                    (old[i].max(0.0) / REACH, old[i].max(1e-3 * found) * REACH)
                };
                (old[i] + pace * (found - old[i])).clamp(low, high)
            }
        };
        let w = shares.emissive(e)[0];
        let off = (0..3).map(|b| l.weight[b] * (l.absorb[b] * w[b] - line[b]).abs()).sum::<f64>();
        let all = (0..3).map(|b| uptake[b] * w[b].abs()).sum::<f64>();
        let moves = !matches!(l.known, Known::Temperature(_));
        (e, [if moves { off * l.measure } else { 0.0 }, all * l.measure])
    };
    let all: Vec<(f64, [f64; 2])> = (0..locals.len()).into_par_iter().map(one).collect();
    let [off, given] = crate::columns::sum(all.len(), |i| all[i].1);
    (all.into_iter().map(|x| x.0).collect(), if given > 0.0 { off / given } else { 0.0 })
}
