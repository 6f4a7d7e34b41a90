//! Bands that zones mix: u = u⁰ + M u in units of power, by stabilised bi-conjugate gradients (van der Vorst).
//!
//! u_i = t_i s_i (W) is the power that zone i sends out and M u what it sends on of what arrives. M is not symmetric where shares differ from
//! zone to zone, but no entry is negative (beside those of weights that fall with temperature) and no column sums to more than 1:
//! power is lost or kept. Where the gradients come to nothing, power is passed on step by step, which never grows. The residual told is Σ|u⁰ + M u − u| / Σ|u⁰|, power that went astray.
//!
//! Its state is a stage that a [`Keeper`] keeps every so often: taken up, it ends with the same bits.

use crate::columns;
use crate::stage::{Pen, Reader};
use rayon::prelude::*;
use zonal_scene::{Bands, Vault, bands};

/// Steps without a new smallest residual after which no better one is waited for.
const PATIENCE: usize = 30;

/// Steps between two states that are kept.
const KEEP_EVERY: usize = 10;

/// Where the state of a solve is kept.
#[derive(Clone, Copy)]
pub(super) struct Keeper<'a> {
    pub vault: &'a dyn Vault,
    /// The name of the stage.
    pub stage: &'a str,
    /// Which of several solves of that name it is.
    pub number: usize,
    /// False where no state of it can be there: none is looked for.
    pub resumes: bool,
}

impl Keeper<'_> {
    fn load(&self, unknowns: usize) -> Option<Way> {
        let bytes = self.resumes.then(|| self.vault.load(self.stage)).flatten()?;
        Way::restored(&bytes, self.number, unknowns)
    }
    /// Keeps the state after `step` steps, if it is its turn.
    fn save(&self, way: &Way, step: usize) {
        if self.vault.keeps() && step.is_multiple_of(KEEP_EVERY) {
            self.vault.save(self.stage, &way.kept(self.number));
        }
    }
}

/// Where an iteration ended.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct End {
    pub u: Vec<Bands>,
    pub residual: f64,
    /// Products taken.
    pub products: usize,
}

fn dot(a: &[Bands], b: &[Bands]) -> f64 {
    columns::sum(a.len(), |i| [a[i][0] * b[i][0] + a[i][1] * b[i][1] + a[i][2] * b[i][2]])[0]
}

/// Σ|a|.
pub(super) fn power(a: &[Bands]) -> f64 {
    columns::sum(a.len(), |i| [a[i][0].abs() + a[i][1].abs() + a[i][2].abs()])[0]
}

fn combined(x: &[Bands], f: impl Fn(usize, usize) -> f64 + Sync) -> Vec<Bands> {
    (0..x.len()).into_par_iter().map(|i| bands(|b| f(i, b))).collect()
}

/// A solve on its way: the best so far, the residual, and what the gradients are about unless power is being passed on.
#[derive(Clone, Debug, PartialEq)]
struct Way {
    end: End,
    r: Vec<Bands>,
    gradients: Option<Gradients>,
}

/// Bi-conjugate gradients between two steps.
#[derive(Clone, Debug, PartialEq)]
struct Gradients {
    shadow: Vec<Bands>,
    p: Vec<Bands>,
    u: Vec<Bands>,
    rho: f64,
    /// Steps since the best.
    since: usize,
    /// Steps taken.
    step: usize,
}

impl Gradients {
    fn from(r: &[Bands], u: &[Bands]) -> Gradients {
        Gradients { shadow: r.to_vec(), p: r.to_vec(), u: u.to_vec(), rho: dot(r, r), since: 0, step: 0 }
    }
}

impl Way {
    fn kept(&self, number: usize) -> Vec<u8> {
        let mut pen = Pen::default();
        pen.int(number);
        pen.triples(&self.end.u);
        pen.reals(&[self.end.residual]);
        pen.int(self.end.products);
        pen.triples(&self.r);
        pen.int(usize::from(self.gradients.is_some()));
        if let Some(g) = &self.gradients {
            [&g.shadow, &g.p, &g.u].into_iter().for_each(|v| pen.triples(v));
            pen.reals(&[g.rho]);
            pen.int(g.since);
            pen.int(g.step);
        }
        pen.bytes()
    }
    /// The state of this solve, for so many unknowns.
    fn restored(bytes: &[u8], number: usize, unknowns: usize) -> Option<Way> {
        let mut r = Reader::new(bytes);
        if r.int()? != number {
            return None;
        }
        let field = |r: &mut Reader| r.triples().filter(|v| v.len() == unknowns);
        let one = |r: &mut Reader| r.reals()?.first().copied();
        let end = End { u: field(&mut r)?, residual: one(&mut r)?, products: r.int()? };
        let rest = field(&mut r)?;
        let gradients = match r.int()? {
            0 => None,
            _ => Some(Gradients {
                shadow: field(&mut r)?,
                p: field(&mut r)?,
                u: field(&mut r)?,
                rho: one(&mut r)?,
                since: r.int()?,
                step: r.int()?,
            }),
        };
        r.at_end().then_some(Way { end, r: rest, gradients })
    }
}

/// Solves u = `source` + `passed`(u) from `start` to the residual `wanted`, in at most `steps` steps of two products; its state is kept, and
/// taken up where it is there.
pub(super) fn solve(
    passed: impl Fn(&[Bands]) -> Vec<Bands>,
    source: &[Bands],
    start: Vec<Bands>,
    (wanted, steps): (f64, usize),
    keeper: &Keeper,
) -> End {
    let given = power(source);
    let mut way = keeper.load(source.len()).unwrap_or_else(|| {
        let mut end = End { residual: 0.0, products: 0, u: start };
        let r = rest(&passed, source, &mut end, given);
        let gradients = (end.residual > wanted).then(|| Gradients::from(&r, &end.u));
        Way { end, r, gradients }
    });
    if way.gradients.is_some() {
        gradients(&passed, &mut way, given, (wanted, steps), keeper);
        way.gradients = None;
        if way.end.residual > wanted {
            way.r = rest(&passed, source, &mut way.end, given);
        }
    }
    // What is left, passed on: r is what one more pass brings.
    while way.end.residual > wanted && way.end.products < 2 * steps {
        let Way { end, r, .. } = &mut way;
        end.u = combined(r, |i, b| end.u[i][b] + r[i][b]);
        *r = passed(r);
        end.products += 1;
        end.residual = power(r) / given;
        keeper.save(&way, way.end.products);
    }
    way.end
}

/// source + M u − u, and its share of what is given.
fn rest(passed: &impl Fn(&[Bands]) -> Vec<Bands>, source: &[Bands], end: &mut End, given: f64) -> Vec<Bands> {
    let m = passed(&end.u);
    end.products += 1;
    let r = combined(&m, |i, b| source[i][b] + m[i][b] - end.u[i][b]);
    end.residual = if given > 0.0 { power(&r) / given } else { 0.0 };
    r
}

/// Bi-conjugate gradients from a residual; the end of `way` is the best found.
fn gradients(
    passed: &impl Fn(&[Bands]) -> Vec<Bands>,
    way: &mut Way,
    given: f64,
    (wanted, steps): (f64, usize),
    keeper: &Keeper,
) {
    let taken = |p: &[Bands]| {
        let m = passed(p);
        combined(p, |i, b| p[i][b] - m[i][b])
    };
    while let Way { end, r, gradients: Some(g) } = &mut *way
        && g.step < steps
    {
        let v = taken(&g.p);
        let along = dot(&g.shadow, &v);
        if along == 0.0 || !along.is_finite() {
            return;
        }
        let alpha = g.rho / along;
        let s = combined(r, |i, b| r[i][b] - alpha * v[i][b]);
        let t = taken(&s);
        end.products += 2;
        let tt = dot(&t, &t);
        let omega = if tt > 0.0 { dot(&t, &s) / tt } else { 0.0 };
        g.u = combined(&g.u, |i, b| g.u[i][b] + alpha * g.p[i][b] + omega * s[i][b]);
        *r = combined(&s, |i, b| s[i][b] - omega * t[i][b]);
        let residual = power(r) / given;
        g.since += 1;
        if residual < end.residual {
            (end.u, end.residual, g.since) = (g.u.clone(), residual, 0);
        }
        if end.residual <= wanted || g.since > PATIENCE || !residual.is_finite() || omega == 0.0 {
            return;
        }
        let next = dot(&g.shadow, r);
        let beta = next / g.rho * (alpha / omega);
        g.rho = next;
        g.p = combined(&g.p, |i, b| r[i][b] + beta * (g.p[i][b] - omega * v[i][b]));
        g.step += 1;
        let step = g.step;
        keeper.save(way, step);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_scene::NoVault;

    const NONE: Keeper<'static> = Keeper { vault: &NoVault, stage: "", number: 0, resumes: false };

    #[test]
    fn power_passed_on_in_a_ring_adds_up() {
        // Zone i sends 0.9 of what it has to zone i + 1, bands in turn.
        let n = 50;
        let passed = |u: &[Bands]| -> Vec<Bands> {
            (0..n).map(|i| bands(|b| 0.9 * u[(i + n - 1) % n][(b + 1) % 3])).collect()
        };
        let mut source = vec![[0.0; 3]; n];
        source[3] = [1.0, 2.0, 4.0];
        let end = solve(passed, &source, source.clone(), (1e-12, 500), &NONE);
        assert!(end.residual <= 1e-12, "{:e}", end.residual);
        assert!((power(&end.u) - 70.0).abs() < 1e-8);
    }

    /// Keeps the stage saved as number `wanted`.
    struct Nth(Cell);
    type Cell = std::sync::Mutex<(usize, Option<Vec<u8>>)>;
    impl Vault for Nth {
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

    /// A ring whose neighbours share, and one that turns, where the gradients come to nothing and power is passed on.
    #[test]
    fn a_state_taken_up_ends_with_the_same_bits() {
        let n = 60;
        let mut source = vec![[0.0; 3]; n];
        source[3] = [1.0, 2.0, 4.0];
        let mut phases = [0; 2];
        for turn in [false, true] {
            let passed = |u: &[Bands]| -> Vec<Bands> {
                let of = |i: usize, b: usize| match turn {
                    true => 0.9 * u[(i + n - 1) % n][(b + 1) % 3],
                    false => 0.4995 * (u[(i + n - 1) % n][(b + 1) % 3] + u[(i + 1) % n][b]),
                };
                (0..n).map(|i| bands(|b| of(i, b))).collect()
            };
            let run = |keeper: &Keeper| solve(passed, &source, source.clone(), (1e-12, 400), keeper);
            let straight = run(&NONE);
            for k in 1.. {
                let vault = Nth(Cell::new((k, None)));
                let keeper = Keeper { vault: &vault, stage: "s", number: 4, resumes: true };
                run(&keeper);
                let Some(bytes) = vault.load("s") else { break };
                phases[usize::from(Way::restored(&bytes, 4, n).unwrap().gradients.is_none())] += 1;
                assert_eq!(run(&keeper), straight, "{turn} {k}");
                // Another solve, another number of unknowns, a torn stage: begun afresh.
                assert!(Way::restored(&bytes, 5, n).is_none() && Way::restored(&bytes, 4, n + 1).is_none());
                assert!(Way::restored(&bytes[..bytes.len() - 1], 4, n).is_none());
            }
        }
        assert!(phases[0] > 0 && phases[1] > 0, "{phases:?}");
    }
}
