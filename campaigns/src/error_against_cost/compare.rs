//! Two tables compared: ratios of processor time at equal total error.
//!
//! Each series is reduced to the points that no other point of it beats in cost and error, and interpolated between logarithms. The errors
//! are those of the first table's points, where the second table has them in its range. A series of several engines is the best of them.

use super::points::{self, Point, PointStatus};
use crate::harness::statistics::{CostPoint, cost_at, front, median};
use std::fmt::Write as _;

/// Scene, error, time of ours, time of theirs over ours.
type CostRatio = (String, [f64; 3]);

/// Points of a scene, of one engine, that have no star.
fn costs(all: &[Point], scene: &str, engine: &str) -> Vec<CostPoint> {
    all.iter()
        .filter(|p| {
            p.scene == scene
                && p.engine == engine
                && p.status == PointStatus::Measured
                && !p.total().is_noisy()
        })
        .map(|p| [p.cost.processor, p.total().error])
        .collect()
}

/// The ratios of an engine, scene by scene.
pub(crate) fn ratios(ours: &[Point], theirs: &[Point], engine: &str) -> Vec<CostRatio> {
    let of_scene = |scene: String| -> Vec<CostRatio> {
        let other = costs(theirs, &scene, engine);
        let ratio =
            |[cost, error]: CostPoint| Some((scene.clone(), [error, cost, cost_at(&other, error)? / cost]));
        front(&costs(ours, &scene, engine)).into_iter().filter_map(ratio).collect()
    };
    points::names(ours, |p| &p.scene).into_iter().flat_map(of_scene).collect()
}

/// The comparison for people.
pub(crate) fn text(ratios: &[CostRatio]) -> String {
    let mut t = String::from("scene            error    seconds  times faster\n");
    for (scene, [error, seconds, ratio]) in ratios {
        let _ = writeln!(t, "{scene:<15} {:>6.2} % {seconds:>8.2} s {ratio:>8.2}", 100.0 * error);
    }
    let least = ratios.iter().map(|r| r.1[2]).fold(f64::INFINITY, f64::min);
    t + &match median(ratios.iter().map(|r| r.1[2]).collect()) {
        Some(m) => format!("median {m:.2}, least {least:.2}\n"),
        None => "no error is measured in both tables\n".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error_against_cost::points::example;

    #[test]
    fn ratios_are_at_equal_error() {
        let ours = [example("auto", 0.1, 1.0, 0.01), example("auto", 0.2, 0.5, 0.2)];
        let theirs = [example("auto", 0.1, 1.0, 0.1), example("auto", 0.05, 100.0, 0.001)];
        let r = ratios(&ours, &theirs, "auto");
        assert_eq!(r.len(), 1);
        assert!((r[0].1[2] - 10.0).abs() < 1e-9);
        assert!(text(&r).contains("median 10.00"));
    }
}
