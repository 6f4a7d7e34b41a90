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
//! steps are halved when R no longer falls. The end is a status. Every step is a stage that a vault may keep, and so is the linear solve in it.

use super::linear::{self, Keeper};
use super::local::{Local, Locals};
use crate::engine::{Built, Site};
use crate::krylov::Ended;
use crate::operator::{Operator, extend_to_slopes};
use crate::stage::{Pen, Reader};
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
/// Bytes a zone: its part in the equations, its turn, the vectors of the linear solve, and those of them that are kept as a stage.
const BYTES: u64 = 400 + 12 * 24 + 5 * 24;
/// The stages: temperatures after each step, and the linear solve in one.
const STAGE: &str = "state-temperatures";
const LINEAR: &str = "state-temperatures-linear";

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
    pub(super) fn of(l: &Local, shares: &Shares, e: f64) -> Turn {
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
    pub(super) fn passed(&self, h: Bands) -> Bands {
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
    /// The zone of every unknown beyond the zones.
    slopes: Vec<u32>,
    zones: usize,
    /// The three bands are one in everything: the engine is asked for one.
    one: bool,
}

impl Powers {
    /// Of zones whose bands are all alike where `grey`, and of these zones' slopes.
    pub(super) fn new(
        operator: &dyn Operator,
        zones: &Zones,
        locals: &[Local],
        grey: bool,
        slopes: &[u32],
    ) -> Powers {
        let mut scale: Vec<(f64, Bands)> =
            (0..zones.len()).into_par_iter().map(|i| (target(zones, i), strength(zones, i))).collect();
        let mut over: Vec<f64> = locals.iter().map(|l| l.part / l.measure).collect();
        extend_to_slopes(&mut scale, slopes);
        extend_to_slopes(&mut over, slopes);
        let (slopes, zones) = (slopes.to_vec(), zones.len());
        // Where slopes are left out only all bands together are asked for.
        let one = grey && operator.one_band() && operator.len() == scale.len();
        Powers { scale, over, slopes, zones, one }
    }
    /// The zone of an unknown.
    pub(super) fn zone(&self, k: usize) -> usize {
        if k < self.zones { k } else { self.slopes[k - self.zones] as usize }
    }
    /// The power of an unknown's radiosity.
    pub(super) fn of(&self, i: usize, radiosity: Bands) -> Bands {
        let (t, c) = self.scale[i];
        bands(|b| t * c[b] * radiosity[b])
    }
    pub(super) fn strengths(&self, u: &[Bands]) -> Vec<Bands> {
        u.par_iter().zip(&self.scale).map(|(u, (t, _))| u.map(|x| x / t)).collect()
    }
    /// h of every zone, without what comes from the surroundings.
    pub(super) fn arriving(&self, operator: &dyn Operator, u: &[Bands]) -> Vec<Bands> {
        let s = self.strengths(u);
        let mut p: Vec<Bands> = match self.one {
            true => {
                let first: Vec<[f64; 1]> = s.par_iter().map(|s| [s[0]]).collect();
                operator.apply_band(&first).par_iter().map(|p| [p[0]; 3]).collect()
            }
            false => operator.apply(&s),
        };
        p.par_iter_mut().zip(&self.over).for_each(|(p, o)| *p = p.map(|x| x * o));
        p
    }
    /// M u.
    pub(super) fn passed(
        &self,
        operator: &dyn Operator,
        u: &[Bands],
        turn: impl Fn(usize, Bands) -> Bands + Sync,
    ) -> Vec<Bands> {
        let h = self.arriving(operator, u);
        (0..u.len()).into_par_iter().map(|k| self.of(k, turn(self.zone(k), h[k]))).collect()
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
    let (scene, operator) = (site.scene, built.operator.as_ref());
    check_memory(site, operator.len())?;
    let table = Locals::new(scene, site.zones);
    let (shares, locals) = (&table.thermal.shares, table.all(site.zones));
    let powers = Powers::new(operator, site.zones, &locals, false, &operator.slopes());
    let outside = outside(site, escape, &powers);
    let (wanted, steps) = (scene.options().residual, scene.options().max_iterations);
    let begin = black(table.level());
    let start = || -> Vec<f64> {
        locals.iter().map(|l| if let Known::Temperature(t) = l.known { black(t) } else { begin }).collect()
    };
    let kept = site.vault.load(STAGE).and_then(|b| State::restored(&b, locals.len(), outside.len(), wanted));
    let State { mut e, mut u, mut products, mut course } =
        kept.unwrap_or_else(|| State { e: start(), u: Vec::new(), products: 0, course: Course::new(wanted) });
    let first = course.residuals.len();
    site.progress.begin("temperatures", STEPS as u64);
    site.progress.advance(first as u64);
    while course.status.is_none() {
        let turns: Vec<Turn> = locals.par_iter().zip(&e).map(|(l, e)| Turn::of(l, shares, *e)).collect();
        // What zones give of themselves, and of the surroundings; slopes have none of their own.
        let source = |k: usize| {
            let turn = &turns[powers.zone(k)];
            let (own, sky) = (if k < locals.len() { turn.own } else { [0.0; 3] }, turn.passed(outside[k]));
            powers.of(k, bands(|b| own[b] + sky[b]))
        };
        let source: Vec<Bands> = (0..outside.len()).into_par_iter().map(source).collect();
        let passed = |u: &[Bands]| powers.passed(operator, u, |i, h| turns[i].passed(h));
        let start = if u.is_empty() { source.clone() } else { u };
        let number = course.residuals.len();
        let keeper = Keeper { vault: site.vault, stage: LINEAR, number, resumes: number == first };
        let end = linear::solve(passed, &source, start, (FINER * wanted, steps), &keeper);
        let h = powers.arriving(operator, &end.u);
        let arriving = |i: usize| bands(|b| h[i][b] + outside[i][b]);
        let (next, off) = stepped(&locals, shares, &e, arriving, course.pace());
        (e, products) = (next, products + end.products + 1);
        course.step(off, end.residual);
        u = end.u;
        if site.vault.keeps() {
            site.vault.save(STAGE, &kept_state(&e, &u, products, &course));
        }
        site.progress.advance(1);
    }
    site.progress.end();
    let mut zones = site.zones.clone();
    let emissive: Vec<Bands> = e.iter().map(|e| shares.emissive(*e)[0]).collect();
    super::physical(scene, &mut zones, &emissive);
    let ended = Ended {
        strengths: powers.strengths(&u),
        status: [course.status.unwrap_or(SolveStatus::Budget); 3],
        residuals: [0, 1, 2].map(|_| course.residuals.clone()),
        power: [linear::power(&u); 3],
    };
    Ok(Coupled { zones, ended, products })
}

/// Refuses what would not fit.
fn check_memory(site: &Site, unknowns: usize) -> Result<(), SceneError> {
    let bytes = BYTES * unknowns as u64;
    if bytes <= site.memory {
        return Ok(());
    }
    let what = format!(
        "the iteration over temperatures of {} zones needs {:.3} GB, more than the {:.3} GB allowed; use larger patches or fewer cells, or allow more (--max-memory)",
        site.zones.len(),
        bytes as f64 / 1e9,
        site.memory as f64 / 1e9
    );
    Err(SceneError::new("solve.patch_size", what))
}

/// h of every unknown that comes from the surroundings.
fn outside(site: &Site, escape: &Escape, powers: &Powers) -> Vec<Bands> {
    let sky = site.scene.surroundings().radiosity();
    let one = |k: usize| escape.incoming(k, sky)[0].map(|x| x * powers.over[k]);
    (0..powers.over.len()).into_par_iter().map(one).collect()
}

/// The iteration between two steps.
struct State {
    /// E of every zone, W/m².
    e: Vec<f64>,
    /// Powers of all unknowns, W.
    u: Vec<Bands>,
    products: usize,
    course: Course,
}

/// A [`State`] as a stage.
fn kept_state(e: &[f64], u: &[Bands], products: usize, course: &Course) -> Vec<u8> {
    let mut pen = Pen::default();
    pen.reals(e);
    pen.triples(u);
    pen.reals(&course.residuals);
    pen.reals(&[course.best]);
    let status = course.status.and_then(|s| SolveStatus::ALL.iter().position(|x| *x == s));
    [products, course.since, usize::from(course.halved), status.map_or(0, |k| k + 1)]
        .into_iter()
        .for_each(|n| pen.int(n));
    pen.bytes()
}

impl State {
    /// The state that [`kept_state`] wrote, of so many zones and unknowns.
    fn restored(bytes: &[u8], zones: usize, unknowns: usize, wanted: f64) -> Option<State> {
        let mut r = Reader::new(bytes);
        let (e, u, residuals) = (r.reals()?, r.triples()?, r.reals()?);
        let best = *r.reals()?.first()?;
        let [products, since, halved, status] = [r.int()?, r.int()?, r.int()?, r.int()?];
        let status = if status == 0 { None } else { Some(*SolveStatus::ALL.get(status - 1)?) };
        let course = Course { wanted, residuals, best, since, halved: halved > 0, status };
        let fits = r.at_end() && e.len() == zones && u.len() == unknowns;
        fits.then_some(State { e, u, products, course })
    }
}

/// How the iteration goes.
struct Course {
    wanted: f64,
    residuals: Vec<f64>,
    best: f64,
    /// Steps since the best.
    since: usize,
    halved: bool,
    status: Option<SolveStatus>,
}

impl Course {
    fn new(wanted: f64) -> Course {
        Course { wanted, residuals: Vec::new(), best: f64::INFINITY, since: 0, halved: false, status: None }
    }
    /// The share of a step that is taken.
    fn pace(&self) -> f64 {
        if self.halved { 0.5 } else { 1.0 }
    }
    /// Notes R of a step, and the residual of its linear solve.
    fn step(&mut self, off: f64, linear: f64) {
        self.residuals.push(off.max(linear));
        self.since = if off < self.best { 0 } else { self.since + 1 };
        self.best = self.best.min(off);
        self.halved |= self.since >= PATIENCE;
        self.status = if off <= self.wanted {
            Some(if linear <= self.wanted { SolveStatus::Converged } else { SolveStatus::Stalled })
        } else if self.since >= LAST || !off.is_finite() {
            Some(SolveStatus::Stalled)
        } else {
            (self.residuals.len() >= STEPS).then_some(SolveStatus::Budget)
        };
    }
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
                let (low, high) = if shares.is_constant() || found.is_nan() || found <= 0.0 {
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
