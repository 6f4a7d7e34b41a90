//! The requirements on the benchmark.
//!
//! | requirement | at |
//! |---|---|
//! | a halved tolerance costs at most 6 times as much | each step of a tolerance |
//! | total error at most the tolerance, of the worse kind of zones and weighting | each point |
//! | its upper bound at most the tolerance | each point |
//! | stated over true error between 1 and 4 in the median | each point that the noise of the reference permits |
//! | at least 95 % of zones within twice their stated error, relit too | each point |
//! | at least 95 % of powers absorbed by a surface within their stated error, relit within twice | each point |
//! | `auto` takes at most 1.3 times the time of the best engine, or 0.2 s more | each tolerance |

use super::points::{self, Point};
use crate::harness::statistics::ratio_of_halving;
use std::fmt::Write as _;

/// Largest cost ratio of a halved tolerance.
const MAX_HALVING_RATIO: f64 = 6.0;
/// Cost below which a ratio says nothing: the resolution of processor times, s.
const MIN_COST: f64 = 0.1;
/// Least and largest median of stated over true error.
const RATIO_RANGE: std::ops::RangeInclusive<f64> = 1.0..=4.0;
/// Least share of zones within twice their stated error.
const MIN_COVERED: f64 = 0.95;
/// Largest ratio of the cost of `auto` to that of the best engine.
const MAX_AUTO_RATIO: f64 = 1.3;
/// Cost by which `auto` may exceed that of the best engine, s.
const MAX_AUTO_EXCESS: f64 = 0.2;

/// The share of the zones of a point that meet a requirement.
type Share = fn(&Point) -> Option<f64>;

/// Counts of a requirement.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Verdict {
    /// The requirement.
    pub requirement: &'static str,
    /// Points that meet it.
    pub met: usize,
    /// Points at which it applies.
    pub all: usize,
    /// The points that miss it.
    pub missed: Vec<String>,
}

impl Verdict {
    fn new(requirement: &'static str) -> Verdict {
        Verdict { requirement, ..Verdict::default() }
    }

    fn count(&mut self, good: bool, missed: impl FnOnce() -> String) {
        self.all += 1;
        if good {
            self.met += 1;
        } else {
            self.missed.push(missed());
        }
    }
}

fn at(p: &Point) -> String {
    format!("{} {} {}", p.scene, p.engine, p.tolerance)
}

/// The verdicts on all points.
pub(crate) fn verdicts(all: &[Point]) -> Vec<Verdict> {
    let mut out: Vec<Verdict> = vec![
        halving(all),
        each(all, "total error at most the tolerance", |p| at_most(p.total().error, p.tolerance)),
        each(all, "upper bound of the total error at most the tolerance", |p| {
            at_most(p.total().upper, p.tolerance)
        }),
        each(all, "stated over true error between 1 and 4 in the median", |p| {
            p.measured.ratio.map(|ratio| (RATIO_RANGE.contains(&ratio), ratio))
        }),
    ];
    let shares: [(&str, Share); 4] = [
        ("95 % of zones within twice their stated error", |p| p.measured.within),
        ("95 % of zones within twice their stated error after relighting", |p| p.measured.within_relit),
        ("95 % of powers of surfaces within their stated error", |p| p.measured.names_within),
        ("95 % of powers of surfaces within twice their stated error after relighting", |p| {
            p.measured.names_within_relit
        }),
    ];
    for (name, share) in shares {
        out.push(each(all, name, |p| share(p).map(|s| (s >= MIN_COVERED, s))));
    }
    out.push(automatic(all));
    out
}

fn at_most(error: f64, tolerance: f64) -> Option<(bool, f64)> {
    Some((error <= tolerance, error))
}

fn each(all: &[Point], name: &'static str, rule: impl Fn(&Point) -> Option<(bool, f64)>) -> Verdict {
    let mut verdict = Verdict::new(name);
    for p in all.iter().filter(|p| p.status == points::PointStatus::Measured) {
        if let Some((good, value)) = rule(p) {
            verdict.count(good, || format!("{}: {value:.3}", at(p)));
        }
    }
    verdict
}

fn halving(all: &[Point]) -> Verdict {
    let mut verdict = Verdict::new("a halved tolerance costs at most 6 times as much");
    for scene in points::names(all, |p| &p.scene) {
        for engine in points::names(all, |p| &p.engine) {
            for w in points::series(all, &scene, &engine).windows(2) {
                let cost = |p: &Point| [p.tolerance, p.cost.processor.max(MIN_COST)];
                let ratio = ratio_of_halving(cost(w[0]), cost(w[1]));
                verdict.count(ratio <= MAX_HALVING_RATIO, || format!("{}: {ratio:.1}", at(w[1])));
            }
        }
    }
    verdict
}

fn automatic(all: &[Point]) -> Verdict {
    let mut verdict = Verdict::new("auto takes at most 1.3 times the time of the best engine, or 0.2 s more");
    for scene in points::names(all, |p| &p.scene) {
        for p in points::series(all, &scene, "auto") {
            let others = all.iter().filter(|o| {
                o.scene == scene
                    && o.engine != "auto"
                    && o.tolerance == p.tolerance
                    && o.status == points::PointStatus::Measured
                    && o.total().error <= p.tolerance.max(p.total().error)
            });
            let Some(best) = others.map(|o| o.cost.processor).min_by(f64::total_cmp) else { continue };
            let seconds = p.cost.processor;
            let good = seconds <= (MAX_AUTO_RATIO * best).max(best + MAX_AUTO_EXCESS);
            verdict.count(good, || format!("{}: {seconds:.2} s for {best:.2} s", at(p)));
        }
    }
    verdict
}

/// The verdicts for people, each with the points that miss it.
pub(crate) fn text(verdicts: &[Verdict]) -> String {
    let mut t = String::new();
    for v in verdicts {
        let _ = writeln!(t, "{}: {} of {}", v.requirement, v.met, v.all);
        for missed in &v.missed {
            let _ = writeln!(t, "    missed: {missed}");
        }
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error_against_cost::points::example;

    #[test]
    fn points_that_miss_a_requirement_are_counted() {
        let all = [
            example("auto", 0.2, 1.0, 0.1),
            example("auto", 0.1, 7.0, 0.2),
            example("dense", 0.1, 1.0, 0.01),
        ];
        let v = verdicts(&all);
        let counts: Vec<(usize, usize)> = v.iter().map(|v| (v.met, v.all)).collect();
        assert_eq!(counts, [(0, 1), (2, 3), (2, 3), (3, 3), (3, 3), (0, 0), (3, 3), (0, 0), (0, 1)]);
        assert!(text(&v).contains("missed: room auto 0.1: 7.0"));
    }
}
