//! Linear solve of scenes whose zones couple the bands: u = u⁰ + M u in units of power, by stabilised bi-conjugate gradients
//! (H. A. van der Vorst, SIAM J. Sci. Stat. Comput. 13, 1992).
//!
//! u_i = t_i s_i (W) is the power that zone i sends out, and M u the power that it reflects or reemits. M is not symmetric if band fractions differ from
//! zone to zone, but no entry is negative (except for fractions that decrease with temperature) and no column sums to more than 1: power is lost or
//! conserved. If the gradients break down, fixed-point iterations u += r follow, which never diverge. The residual is Σ|u⁰ + M u − u| / Σ|u⁰|.
//! Cost: two products an iteration.
//!
//! The state is saved as a stage ([`IterationCheckpoint`]); a resumed solve ends with the same bits.

use crate::distribution::multivector;
use crate::iteration::StoppingCriterion;
use crate::settings::stage_codec::{Decoder, Encoder};
use zonal_math::parallel;
use zonal_scene::{Bands, CheckpointStore, Progress};

/// Iterations without a new smallest residual after which the gradients have stalled.
const MAX_ITERATIONS_WITHOUT_PROGRESS: usize = 30;

/// About the operations of an entry of a vector.
const OPERATIONS_OF_ENTRY: usize = 12;

/// Iterations between two saved states.
const CHECKPOINT_INTERVAL: usize = 10;

/// Where the state of a solve is saved.
#[derive(Clone, Copy)]
pub(super) struct IterationCheckpoint<'a> {
    pub store: &'a dyn CheckpointStore,
    /// The name of the stage.
    pub stage: &'a str,
    /// Number of the solve among several with that name.
    pub number: usize,
    /// True if a saved state of this solve may exist.
    pub resumes: bool,
    /// The observer, which may interrupt the solve.
    pub progress: &'a dyn Progress,
}

impl IterationCheckpoint<'_> {
    fn load(&self, unknowns: usize) -> Option<BicgstabState> {
        let bytes = self.resumes.then(|| self.store.load(self.stage)).flatten()?;
        BicgstabState::decode(&bytes, self.number, unknowns)
    }
    /// Saves the state every [`CHECKPOINT_INTERVAL`] iterations.
    fn save(&self, state: &BicgstabState, step: usize) {
        if self.store.keeps() && step.is_multiple_of(CHECKPOINT_INTERVAL) {
            self.store.save(self.stage, &state.encode(self.number));
        }
    }
}

/// Best iterate of a solve.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BestIterate {
    pub u: Vec<Bands>,
    pub residual: f64,
    /// Number of products.
    pub products: usize,
}

fn dot(a: &[Bands], b: &[Bands]) -> f64 {
    multivector::sum(a.len(), |i| (a[i] * b[i]).sum())
}

/// Σ|a|.
pub(super) fn absolute_sum(a: &[Bands]) -> f64 {
    multivector::sum(a.len(), |i| a[i].abs().sum())
}

/// One entry for each of `n` unknowns.
fn entries(n: usize, f: impl Fn(usize) -> Bands + Sync + Send) -> Vec<Bands> {
    parallel::collect_short(n, OPERATIONS_OF_ENTRY, f)
}

/// State of a solve: the best iterate, the residual vector, and the gradients unless fixed-point iterations are under state.
#[derive(Clone, Debug, PartialEq)]
struct BicgstabState {
    end: BestIterate,
    r: Vec<Bands>,
    gradients: Option<GradientState>,
}

/// Bi-conjugate gradients between two iterations.
#[derive(Clone, Debug, PartialEq)]
struct GradientState {
    shadow: Vec<Bands>,
    p: Vec<Bands>,
    u: Vec<Bands>,
    rho: f64,
    /// Iterations since the best iterate.
    since: usize,
    /// Number of iterations.
    step: usize,
}

impl GradientState {
    fn from(r: &[Bands], u: &[Bands]) -> GradientState {
        GradientState { shadow: r.to_vec(), p: r.to_vec(), u: u.to_vec(), rho: dot(r, r), since: 0, step: 0 }
    }
}

impl BicgstabState {
    fn encode(&self, number: usize) -> Vec<u8> {
        let mut encoder = Encoder::default();
        encoder.int(number);
        encoder.bands(&self.end.u);
        encoder.reals(&[self.end.residual]);
        encoder.int(self.end.products);
        encoder.bands(&self.r);
        encoder.int(usize::from(self.gradients.is_some()));
        if let Some(g) = &self.gradients {
            [&g.shadow, &g.p, &g.u].into_iter().for_each(|v| encoder.bands(v));
            encoder.reals(&[g.rho]);
            encoder.int(g.since);
            encoder.int(g.step);
        }
        encoder.bytes()
    }
    /// Decodes a state of solve `number` for a number of unknowns.
    fn decode(bytes: &[u8], number: usize, unknowns: usize) -> Option<BicgstabState> {
        let mut decoder = Decoder::new(bytes);
        if decoder.int()? != number {
            return None;
        }
        let field = |decoder: &mut Decoder| decoder.bands().filter(|v| v.len() == unknowns);
        let one = |decoder: &mut Decoder| decoder.reals()?.first().copied();
        let end =
            BestIterate { u: field(&mut decoder)?, residual: one(&mut decoder)?, products: decoder.int()? };
        let rest = field(&mut decoder)?;
        let gradients = match decoder.int()? {
            0 => None,
            _ => Some(GradientState {
                shadow: field(&mut decoder)?,
                p: field(&mut decoder)?,
                u: field(&mut decoder)?,
                rho: one(&mut decoder)?,
                since: decoder.int()?,
                step: decoder.int()?,
            }),
        };
        decoder.at_end().then_some(BicgstabState { end, r: rest, gradients })
    }
}

/// Solves u = `source` + `reflect`(u) from `start`, with at most `stop.max_iterations` iterations of two products, fewer if the
/// observer interrupts it.
pub(super) fn solve(
    reflect: impl Fn(&[Bands]) -> Vec<Bands>,
    source: &[Bands],
    start: Vec<Bands>,
    stop: StoppingCriterion,
    checkpoint: &IterationCheckpoint,
) -> BestIterate {
    let given = absolute_sum(source);
    let mut state = checkpoint.load(source.len()).unwrap_or_else(|| {
        let mut end = BestIterate { residual: 0.0, products: 0, u: start };
        let r = residual(&reflect, source, &mut end, given);
        let gradients = (end.residual > stop.residual).then(|| GradientState::from(&r, &end.u));
        BicgstabState { end, r, gradients }
    });
    if state.gradients.is_some() {
        run_gradients(&reflect, &mut state, given, stop, checkpoint);
        state.gradients = None;
        if state.end.residual > stop.residual {
            state.r = residual(&reflect, source, &mut state.end, given);
        }
    }
    // Fixed-point iterations: r is the change of u by the next one.
    while state.end.residual > stop.residual
        && state.end.products < 2 * stop.max_iterations
        && !checkpoint.progress.is_interrupted()
    {
        let BicgstabState { end, r, .. } = &mut state;
        end.u = entries(r.len(), |i| end.u[i] + r[i]);
        *r = reflect(r);
        end.products += 1;
        end.residual = absolute_sum(r) / given;
        checkpoint.save(&state, state.end.products);
    }
    state.end
}

/// source + M u − u, and its sum over the sum `given` of the source.
fn residual(
    reflect: &impl Fn(&[Bands]) -> Vec<Bands>,
    source: &[Bands],
    end: &mut BestIterate,
    given: f64,
) -> Vec<Bands> {
    let m = reflect(&end.u);
    end.products += 1;
    let r = entries(m.len(), |i| source[i] + m[i] - end.u[i]);
    end.residual = if given > 0.0 { absolute_sum(&r) / given } else { 0.0 };
    r
}

/// Bi-conjugate gradients from a residual, until the criterion is met, they break down or the observer interrupts the solve.
fn run_gradients(
    reflect: &impl Fn(&[Bands]) -> Vec<Bands>,
    state: &mut BicgstabState,
    given: f64,
    stop: StoppingCriterion,
    checkpoint: &IterationCheckpoint,
) {
    let apply_system = |p: &[Bands]| {
        let m = reflect(p);
        entries(p.len(), |i| p[i] - m[i])
    };
    while let BicgstabState { end, r, gradients: Some(g) } = &mut *state
        && g.step < stop.max_iterations
        && !checkpoint.progress.is_interrupted()
    {
        let v = apply_system(&g.p);
        let along = dot(&g.shadow, &v);
        if along == 0.0 || !along.is_finite() {
            return;
        }
        let alpha = g.rho / along;
        let s = entries(r.len(), |i| r[i] - alpha * v[i]);
        let t = apply_system(&s);
        end.products += 2;
        let tt = dot(&t, &t);
        let omega = if tt > 0.0 { dot(&t, &s) / tt } else { 0.0 };
        g.u = entries(g.u.len(), |i| g.u[i] + alpha * g.p[i] + omega * s[i]);
        *r = entries(s.len(), |i| s[i] - omega * t[i]);
        let residual = absolute_sum(r) / given;
        g.since += 1;
        if residual < end.residual {
            (end.u, end.residual, g.since) = (g.u.clone(), residual, 0);
        }
        if end.residual <= stop.residual
            || g.since > MAX_ITERATIONS_WITHOUT_PROGRESS
            || !residual.is_finite()
            || omega == 0.0
        {
            return;
        }
        let next = dot(&g.shadow, r);
        let beta = next / g.rho * (alpha / omega);
        g.rho = next;
        g.p = entries(g.p.len(), |i| r[i] + beta * (g.p[i] - omega * v[i]));
        g.step += 1;
        let step = g.step;
        checkpoint.save(state, step);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_scene::{Band, NoCheckpoints, NoProgress};

    const NO_CHECKPOINT: IterationCheckpoint<'static> = IterationCheckpoint {
        store: &NoCheckpoints,
        stage: "",
        number: 0,
        resumes: false,
        progress: &NoProgress,
    };

    /// Each band of the result is the following band of `x`.
    fn to_next_band(x: Bands) -> Bands {
        let next = |b: Band| Band::new(b.index() + 1).unwrap_or(Band::first());
        Bands::from_fn(|b| x[next(b)])
    }

    #[test]
    fn power_circulating_in_a_ring_is_conserved() {
        // Zone i sends 0.9 of its power to zone i + 1, into the next band.
        let n = 50;
        let reflect =
            |u: &[Bands]| -> Vec<Bands> { (0..n).map(|i| 0.9 * to_next_band(u[(i + n - 1) % n])).collect() };
        let mut source = vec![Bands::ZERO; n];
        source[3] = Bands::from_rgb([1.0, 2.0, 4.0]);
        let end = solve(
            reflect,
            &source,
            source.clone(),
            StoppingCriterion { residual: 1e-12, max_iterations: 500 },
            &NO_CHECKPOINT,
        );
        assert!(end.residual <= 1e-12, "{:e}", end.residual);
        assert!((absolute_sum(&end.u) - 70.0).abs() < 1e-8);
    }

    /// A store that keeps the `n`-th saved stage.
    struct NthSaveStore(SavedStage);
    type SavedStage = std::sync::Mutex<(usize, Option<Vec<u8>>)>;
    impl CheckpointStore for NthSaveStore {
        fn load(&self, _: &str) -> Option<Vec<u8>> {
            self.0.lock().unwrap().1.clone()
        }
        fn save(&self, _: &str, bytes: &[u8]) {
            let mut held = self.0.lock().unwrap();
            held.0 = held.0.wrapping_sub(1);
            if held.0 == 0 {
                held.1 = Some(bytes.to_vec());
            }
        }
    }

    /// A ring with exchange in both directions, and one in one direction, where the gradients break down and fixed-point iterations follow.
    #[test]
    fn resumed_solve_is_bit_identical() {
        let n = 60;
        let mut source = vec![Bands::ZERO; n];
        source[3] = Bands::from_rgb([1.0, 2.0, 4.0]);
        let mut phases = [0; 2];
        for turn in [false, true] {
            let reflect = |u: &[Bands]| -> Vec<Bands> {
                let of = |i: usize| {
                    if turn {
                        0.9 * to_next_band(u[(i + n - 1) % n])
                    } else {
                        0.4995 * (to_next_band(u[(i + n - 1) % n]) + u[(i + 1) % n])
                    }
                };
                (0..n).map(of).collect()
            };
            let run = |checkpoint: &IterationCheckpoint| {
                solve(
                    reflect,
                    &source,
                    source.clone(),
                    StoppingCriterion { residual: 1e-12, max_iterations: 400 },
                    checkpoint,
                )
            };
            let straight = run(&NO_CHECKPOINT);
            for k in 1.. {
                let store = NthSaveStore(SavedStage::new((k, None)));
                let checkpoint = IterationCheckpoint {
                    store: &store,
                    stage: "s",
                    number: 4,
                    resumes: true,
                    progress: &NoProgress,
                };
                run(&checkpoint);
                let Some(bytes) = store.load("s") else { break };
                phases[usize::from(BicgstabState::decode(&bytes, 4, n).unwrap().gradients.is_none())] += 1;
                assert_eq!(run(&checkpoint), straight, "{turn} {k}");
                // A state of another solve, of another size or a truncated one is not used.
                assert!(
                    BicgstabState::decode(&bytes, 5, n).is_none()
                        && BicgstabState::decode(&bytes, 4, n + 1).is_none()
                );
                assert!(BicgstabState::decode(&bytes[..bytes.len() - 1], 4, n).is_none());
            }
        }
        assert!(phases[0] > 0 && phases[1] > 0, "{phases:?}");
    }
}
