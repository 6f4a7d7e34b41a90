//! Section 6: a square between black walls, one of them hot: a box that repeats itself along y, one cell deep.

use crate::validate::box_scene::BoxScene;
use crate::validate::case::{AcceptanceLimit, CaseOutcome, ProfilePlot, ValidationCase};
use crate::validate::case_context::CaseContext;
use crate::validate::data::table;
use crate::validate::measures::{WallMeans, voxel_value};
use crate::validate::richardson::ResolutionSequence;
use zonal_report::Failure;
use zonal_scene::Solution;

/// Odd, so that a zone stands in the middle.
const RESOLUTIONS: [usize; 5] = [21, 41, 81, 161, 321];

/// The cases.
pub(crate) const CASES: [ValidationCase; 1] = [ValidationCase {
    name: "crosbie-schrenker",
    group: "6 Square in radiative equilibrium",
    title: "Crosbie and Schrenker (1984), source function on the centreline",
    about: "Optical thickness 1 × 1, conservative scattering, wall x = 0 hot. Values between the centres of the zones by a cubic through four of them, beyond the first and the last on a line through two. \
        Limit: 2·10⁻³ absolute; in the middle the source function is ¼ by superposition, limit 10⁻⁶. Mean fluxes at 10², 20² and 40² to all printed digits; the mean flux is extrapolated from 21² … 321² zones and held to the bracket 10⁻⁴ of its reference.",
    quick: false,
    needs: None,
    run,
}];

fn room(n: usize) -> BoxScene {
    let mut room = BoxScene::new([1.0; 3], [n, 1, n], 1.0).medium("albedo = 1").wall(0, 0.0, 1.0);
    room.walls[2..4].fill(None);
    room.solve(&format!("engine = \"spectral\"\n{}", super::cube::CONSTANT_BASIS))
}

fn solve(bench: &CaseContext, n: usize) -> Result<Solution, Failure> {
    let name = format!("square-{n}");
    bench.solve(&name, &room(n).text(&name))
}

/// The value at `t` of what has `values` at the centres of equal cells of [0, 1].
pub(crate) fn interpolate(values: &[f64], t: f64) -> f64 {
    let n = values.len();
    let x = t * n as f64 - 0.5;
    let (count, first) = if x < 0.0 {
        (2, 0)
    } else if x > (n - 1) as f64 {
        (2, n - 2)
    } else {
        (4, (x.floor() as usize).saturating_sub(1).min(n - 4))
    };
    (first..first + count)
        .map(|i| {
            let weight = (first..first + count).filter(|&j| j != i);
            values[i] * weight.map(|j| (x - j as f64) / (i as f64 - j as f64)).product::<f64>()
        })
        .sum()
}

/// Compares the source function on the centreline, at equal steps from the hot wall, and plots it.
fn compare_centreline(out: &mut CaseOutcome, line: &[f64]) -> Result<(), Failure> {
    let mut profile = ProfilePlot {
        file: "crosbie-schrenker-line".into(),
        title: "Source function on the centreline of the square".into(),
        x: "optical distance from the hot wall".into(),
        y: "S, of the hot wall's emissive power".into(),
        ours: vec![(
            "ours, 321²".into(),
            (0..=40).map(|k| k as f64 / 40.0).map(|t| (t, interpolate(line, t))).collect(),
        )],
        reference: vec![("Crosbie and Schrenker".into(), Vec::new())],
    };
    for row in table!("square.csv")?.rows() {
        let tau = row.number("tau")?;
        profile.reference[0].1.push((tau, row.number("published")?));
        let ours = interpolate(line, tau);
        out.check(
            format!("τ = {tau}: S, published"),
            row.number("published")?,
            ours,
            AcceptanceLimit::Absolute(2e-3),
        );
        if let Some(p) = row.optional("computed")? {
            out.check(format!("τ = {tau}: S, computed"), p.value, ours, AcceptanceLimit::Absolute(2e-3));
        }
    }
    out.profiles.push(profile);
    Ok(())
}

fn run(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let (mut flux, mut near) = (Vec::new(), Vec::new());
    let mut line = Vec::new();
    for n in RESOLUTIONS {
        let s = solve(bench, n)?;
        flux.push((n as f64, WallMeans::of(&s, "x0").net()));
        line = (0..n).map(|k| voxel_value(&s, &s.fields.radiosity, [k, 0, n / 2])).collect();
        near.push((n as f64, interpolate(&line, 0.25449)));
        if n == RESOLUTIONS[0] || n == RESOLUTIONS[RESOLUTIONS.len() - 1] {
            out.check(format!("{n}²: S in the middle"), 0.25, line[n / 2], AcceptanceLimit::Absolute(1e-6));
        }
    }
    compare_centreline(&mut out, &line)?;
    let flux = ResolutionSequence::new("mean net flux of the hot wall", flux, Some((0.7963, 1e-4)));
    out.check(
        "mean net flux of the hot wall, extrapolated",
        0.7963,
        flux.value(),
        AcceptanceLimit::Absolute(1e-4),
    );
    out.sequences.push(flux);
    out.sequences.push(ResolutionSequence::new("S at τ = 0.25449", near, Some((0.3918, 5e-5))));
    for row in table!("square_flux.csv")?.rows() {
        let n = row.number("n")?;
        let s = solve(bench, n as usize)?;
        let p = row.printed("value")?;
        out.check(
            format!("{n}²: mean net flux"),
            p.value,
            WallMeans::of(&s, "x0").net(),
            AcceptanceLimit::Absolute(p.half),
        );
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::interpolate;

    #[test]
    fn interpolation_is_exact_for_cubics_and_linear_beyond_the_ends() {
        let f = |t: f64| 1.0 + t * (2.0 - t * (3.0 - t));
        let values: Vec<f64> = (0..9).map(|k| f((k as f64 + 0.5) / 9.0)).collect();
        for t in [0.06, 0.3, 0.5, 0.77, 0.94] {
            assert!((interpolate(&values, t) - f(t)).abs() < 1e-13);
        }
        let line: Vec<f64> = (0..9).map(|k| 1.0 - 0.1 * k as f64).collect();
        assert!(
            (interpolate(&line, 0.0) - 1.05).abs() < 1e-13 && (interpolate(&line, 1.0) - 0.15).abs() < 1e-13
        );
    }
}
