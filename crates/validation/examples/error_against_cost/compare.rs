//! Two tables compared: ratios of processor time at equal measured error.
//!
//! Each series is reduced to the points that no other point of it beats in cost and error, and interpolated between logarithms. The errors
//! are those of the first table's points, where the second table has them in its range. A series of several engines is the best of them.

use crate::points::{self, Point, PointStatus};
use crate::statistics::{CostPoint, cost_at, front, median};
use std::fmt::Write as _;

/// The ratios of a scene.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SceneRatios {
    /// Scene.
    pub scene: String,
    /// Error, time of ours, time of theirs over ours.
    pub points: Vec<[f64; 3]>,
}

/// Points of a scene, of one engine, that the noise of the reference permits.
fn costs(all: &[Point], scene: &str, engine: &str) -> Vec<CostPoint> {
    all.iter()
        .filter(|p| {
            p.scene == scene
                && p.engine == engine
                && p.status == PointStatus::Measured
                && !p.error().is_noisy()
        })
        .map(|p| [p.seconds(), p.error().error])
        .collect()
}

/// The ratios of an engine, scene by scene.
pub(crate) fn ratios(ours: &[Point], theirs: &[Point], engine: &str) -> Vec<SceneRatios> {
    let scenes = points::names(ours, |p| &p.scene);
    let of_scene = |scene: String| {
        let other = costs(theirs, &scene, engine);
        let points = front(&costs(ours, &scene, engine));
        let points = points.into_iter().filter_map(|[c, e]| Some([e, c, cost_at(&other, e)? / c])).collect();
        SceneRatios { scene, points }
    };
    scenes.into_iter().map(of_scene).collect()
}

/// The comparison for people.
pub(crate) fn text(ratios: &[SceneRatios]) -> String {
    let mut t = String::from("scene            error    seconds  times faster\n");
    for s in ratios {
        for [error, seconds, ratio] in &s.points {
            let _ = writeln!(t, "{:<15} {:>6.2} % {seconds:>8.2} s {ratio:>8.2}", s.scene, 100.0 * error);
        }
    }
    let all: Vec<f64> = ratios.iter().flat_map(|s| s.points.iter().map(|p| p[2])).collect();
    let least = all.iter().copied().fold(f64::INFINITY, f64::min);
    match median(all) {
        Some(m) => {
            let _ = writeln!(t, "median {m:.2}, least {least:.2}");
        }
        None => t.push_str("no error is measured in both tables\n"),
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::points::example;

    #[test]
    fn ratios_are_at_equal_error() {
        let ours = [example("auto", 0.1, 1.0, 0.01), example("auto", 0.2, 0.5, 0.2)];
        let theirs = [example("auto", 0.1, 1.0, 0.1), example("auto", 0.05, 100.0, 0.001)];
        let r = ratios(&ours, &theirs, "auto");
        assert_eq!(r[0].points.len(), 1);
        assert!((r[0].points[0][2] - 10.0).abs() < 1e-9);
        assert!(text(&r).contains("median 10.00"));
    }
}
