//! Section 7: a cube in radiative equilibrium, wall z = 0 hot.

use super::factors::STEFAN_BOLTZMANN;
use crate::validate::box_scene::{BoxScene, WALL_NAMES};
use crate::validate::case::{AcceptanceLimit, CaseOutcome, ValidationCase};
use crate::validate::case_context::CaseContext;
use crate::validate::data::table;
use crate::validate::measures::{WallMeans, net_flux, voxel_value};
use crate::validate::richardson::ResolutionSequence;
use zonal_report::Failure;
use zonal_scene::Solution;

/// Settings of `[solve]` for zones of one radiosity each.
pub(crate) const CONSTANT_BASIS: &str = "zone_basis = \"constant\"";
/// Settings of `[solve]` for zones in which radiosity varies linearly.
pub(crate) const LINEAR_BASIS: &str = "zone_basis = \"linear\"";

/// The sequences; the thick ones go on.
const RESOLUTIONS: [usize; 6] = [8, 16, 24, 32, 48, 64];
const FINER_RESOLUTIONS: [usize; 2] = [96, 128];

/// The cases.
pub(crate) const CASES: [ValidationCase; 2] = [
    ValidationCase {
        name: "cube",
        group: "7 Cube in radiative equilibrium",
        title: "finite resolutions, to all printed digits",
        about: "Black walls of 1000 K and 500 K and a medium without heat source, thermal mode, n³ zones of one radiosity each; and the same as a medium that scatters all, light mode, which must agree to 10⁻⁹. Values of the discrete system itself, so every printed digit must come out. In the middle the source function is 1/6 for \
            every depth and odd n. The net flux of the hot wall must be what the other walls receive.",
        quick: false,
        needs: None,
        run: finite,
    },
    ValidationCase {
        name: "cube-limit",
        group: "7 Cube in radiative equilibrium",
        title: "extrapolated fluxes",
        about: "The same, scattering all, from 8³ to 64³ voxels, to 128³ for optical depths of 5 and 10, extrapolated. The reference's own bracket is the limit; for the walls opposite and beside, which are printed without \
            one, that of the hot wall or half a unit of the last place, whichever is more.",
        quick: false,
        needs: None,
        run: extrapolated,
    },
];

/// Temperatures of the hot wall and of the others in thermal mode, K.
const HOT_WALL_KELVIN: f64 = 1000.0;
const COLD_WALLS_KELVIN: f64 = 500.0;

/// The cube of n³ voxels in thermal mode: net flux out of the hot wall over σ(T₁⁴ − T₂⁴).
fn warm(bench: &CaseContext, tau: f64, n: usize) -> Result<f64, Failure> {
    let name = format!("warm-cube-{tau}-{n}");
    let room = BoxScene::new([1.0; 3], [n; 3], tau)
        .warm(1.0, COLD_WALLS_KELVIN)
        .wall(4, 1.0, HOT_WALL_KELVIN)
        .medium("heat_source = 0\nalbedo = 0.3")
        .solve(&format!("engine = \"spectral\"\n{CONSTANT_BASIS}"));
    let s = bench.solve(&name, &room.text(&name))?;
    Ok(net_flux(&s, "z0") / (STEFAN_BOLTZMANN * (HOT_WALL_KELVIN.powi(4) - COLD_WALLS_KELVIN.powi(4))))
}

/// The cube of n³ voxels as one that scatters all.
pub(crate) fn solve(bench: &CaseContext, tau: f64, n: usize, settings: &str) -> Result<Solution, Failure> {
    let linear = if settings == LINEAR_BASIS { "-linear" } else { "" };
    let name = format!("cube-{tau}-{n}{linear}");
    let room = BoxScene::new([1.0; 3], [n; 3], tau)
        .medium("albedo = 1")
        .wall(4, 0.0, 1.0)
        .solve(&format!("engine = \"spectral\"\n{settings}"));
    bench.solve(&name, &room.text(&name))
}

/// Net flux of the hot wall, and what the opposite one and one beside it receive.
pub(crate) fn fluxes(s: &Solution) -> [f64; 3] {
    [WallMeans::of(s, "z0").net(), WallMeans::of(s, "z1").incident, WallMeans::of(s, "x0").incident]
}

fn finite(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    for row in table!("cube.csv")?.rows() {
        let tau = row.number("tau")?;
        for n in [5, 9, 13, 17, 21, 40] {
            let Some(p) = row.optional(&format!("n{n}"))? else { continue };
            let s = solve(bench, tau, n, CONSTANT_BASIS)?;
            let [hot, opposite, side] = fluxes(&s);
            let ours = warm(bench, tau, n)?;
            out.check(format!("τ = {tau}, {n}³: q_hot"), p.value, ours, AcceptanceLimit::Absolute(p.half));
            out.error(format!("τ = {tau}, {n}³: q_hot, scattering all less thermal"), hot - ours, 1e-9);
            if n == 21 {
                out.error(
                    format!("τ = {tau}, {n}³: q_hot − q_opp − 4q_side"),
                    hot - opposite - 4.0 * side,
                    1e-9,
                );
            }
            if n % 2 == 1 && n > 5 {
                let middle = voxel_value(&s, &s.fields.radiosity, [n / 2; 3]);
                out.check(
                    format!("τ = {tau}, {n}³: S in the middle"),
                    1.0 / 6.0,
                    middle,
                    AcceptanceLimit::Absolute(1e-9),
                );
            }
        }
    }
    for n in [9, 21] {
        let s = solve(bench, 1.0, n, CONSTANT_BASIS)?;
        for row in table!("cube_line.csv")?.rows().filter(|r| r.number("n").is_ok_and(|m| m == n as f64)) {
            let (k, p) = (row.number("k")? as usize, row.printed("value")?);
            let ours = voxel_value(&s, &s.fields.radiosity, [n / 2, n / 2, k]);
            // Trailing zeros of five places are not printed.
            out.check(format!("τ = 1, {n}³: S of zone {k}"), p.value, ours, AcceptanceLimit::Absolute(5e-6));
        }
    }
    Ok(out)
}

fn extrapolated(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    for row in table!("cube.csv")?.rows() {
        let tau = row.number("tau")?;
        let bracket = row.number("bracket")?;
        let mut steps = [const { Vec::new() }; 3];
        let finer = if tau >= 5.0 { &FINER_RESOLUTIONS[..] } else { &[] };
        for &n in RESOLUTIONS.iter().chain(finer) {
            let found = fluxes(&solve(bench, tau, n, CONSTANT_BASIS)?);
            steps.iter_mut().zip(found).for_each(|(s, q)| s.push((n as f64, q)));
        }
        for (k, (steps, column)) in steps.into_iter().zip(["hot", "opposite", "side"]).enumerate() {
            let p = row.printed(column)?;
            let most = bracket.max(p.half);
            let sequence =
                ResolutionSequence::new(format!("τ = {tau}: q, {column} wall"), steps, Some((p.value, most)));
            out.check(
                format!("τ = {tau}, extrapolated: q, {column} wall"),
                p.value,
                sequence.value(),
                AcceptanceLimit::Absolute(most),
            );
            if k == 0 {
                out.sequences.push(sequence);
            }
        }
    }
    out.note(format!(
        "Walls of the box are named {} in the scenes; z0 is the hot one.",
        WALL_NAMES.join(", ")
    ));
    Ok(out)
}
