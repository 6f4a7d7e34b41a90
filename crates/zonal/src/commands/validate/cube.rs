//! Section 7: a cube in radiative equilibrium, wall z = 0 hot.

use super::bench::{Bench, FACES, Room, Wall, net, voxel};
use super::case::{Case, Limit, Outcome};
use super::data::table;
use super::factors::SIGMA;
use super::richardson::Sequence;
use crate::Failure;
use zonal_scene::Solution;

/// Settings of `[solve]` for zones of one radiosity each.
pub(super) const PLAIN: &str = "thick_zones = \"constant\"";
/// Settings of `[solve]` for zones in which radiosity varies linearly.
pub(super) const LINEAR: &str = "thick_zones = \"linear\"";

/// The sequences; the thick ones go on.
const SIZES: [usize; 6] = [8, 16, 24, 32, 48, 64];
const FINER: [usize; 2] = [96, 128];

/// The cases.
pub(super) const CASES: [Case; 2] = [
    Case {
        name: "cube",
        group: "7 Cube in radiative equilibrium",
        title: "finite resolutions, to all printed digits",
        about: "Black walls of 1000 K and 500 K and a medium without heat source, thermal mode, n³ zones of one radiosity each; and the same as a medium that scatters all, light mode, which must agree to 10⁻⁹. Values of the discrete system itself, so every printed digit must come out. In the middle the source function is 1/6 for \
            every depth and odd n. The net flux of the hot wall must be what the other walls receive.",
        quick: false,
        needs: None,
        run: finite,
    },
    Case {
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
const HOT: f64 = 1000.0;
const COLD: f64 = 500.0;

/// The cube of n³ voxels in thermal mode: net flux out of the hot wall over σ(T₁⁴ − T₂⁴).
fn warm(bench: &Bench, tau: f64, n: usize) -> Result<f64, Failure> {
    let name = format!("warm-cube-{tau}-{n}");
    let room = Room::new([1.0; 3], [n; 3], tau)
        .warm(1.0, COLD)
        .wall(4, 1.0, HOT)
        .medium("heat_source = 0\nalbedo = 0.3")
        .solve(&format!("engine = \"spectral\"\n{PLAIN}"));
    let s = bench.solve(&name, &room.text(&name))?;
    Ok(net(&s, "z0") / (SIGMA * (HOT.powi(4) - COLD.powi(4))))
}

/// The cube of n³ voxels as one that scatters all.
pub(super) fn solve(bench: &Bench, tau: f64, n: usize, settings: &str) -> Result<Solution, Failure> {
    let linear = if settings == LINEAR { "-linear" } else { "" };
    let name = format!("cube-{tau}-{n}{linear}");
    let room = Room::new([1.0; 3], [n; 3], tau)
        .medium("albedo = 1")
        .wall(4, 0.0, 1.0)
        .solve(&format!("engine = \"spectral\"\n{settings}"));
    bench.solve(&name, &room.text(&name))
}

/// Net flux of the hot wall, and what the opposite one and one beside it receive.
pub(super) fn fluxes(s: &Solution) -> [f64; 3] {
    [Wall::of(s, "z0").net(), Wall::of(s, "z1").incident, Wall::of(s, "x0").incident]
}

fn finite(bench: &Bench) -> Result<Outcome, Failure> {
    let mut out = Outcome::default();
    for row in table!("cube.csv")?.rows() {
        let tau = row.number("tau")?;
        for n in [5, 9, 13, 17, 21, 40] {
            let Some(p) = row.maybe(&format!("n{n}"))? else { continue };
            let s = solve(bench, tau, n, PLAIN)?;
            let [hot, opposite, side] = fluxes(&s);
            let ours = warm(bench, tau, n)?;
            out.check(format!("τ = {tau}, {n}³: q_hot"), p.value, ours, Limit::Absolute(p.half));
            out.error(format!("τ = {tau}, {n}³: q_hot, scattering all less thermal"), hot - ours, 1e-9);
            if n == 21 {
                out.error(
                    format!("τ = {tau}, {n}³: q_hot − q_opp − 4q_side"),
                    hot - opposite - 4.0 * side,
                    1e-9,
                );
            }
            if n % 2 == 1 && n > 5 {
                let middle = voxel(&s, &s.fields.radiosity, [n / 2; 3]);
                out.check(
                    format!("τ = {tau}, {n}³: S in the middle"),
                    1.0 / 6.0,
                    middle,
                    Limit::Absolute(1e-9),
                );
            }
        }
    }
    for n in [9, 21] {
        let s = solve(bench, 1.0, n, PLAIN)?;
        for row in table!("cube_line.csv")?.rows().filter(|r| r.number("n").is_ok_and(|m| m == n as f64)) {
            let (k, p) = (row.number("k")? as usize, row.printed("value")?);
            let ours = voxel(&s, &s.fields.radiosity, [n / 2, n / 2, k]);
            // Trailing zeros of five places are not printed.
            out.check(format!("τ = 1, {n}³: S of zone {k}"), p.value, ours, Limit::Absolute(5e-6));
        }
    }
    Ok(out)
}

fn extrapolated(bench: &Bench) -> Result<Outcome, Failure> {
    let mut out = Outcome::default();
    for row in table!("cube.csv")?.rows() {
        let tau = row.number("tau")?;
        let bracket = row.number("bracket")?;
        let mut steps = [const { Vec::new() }; 3];
        let finer = if tau >= 5.0 { &FINER[..] } else { &[] };
        for &n in SIZES.iter().chain(finer) {
            let found = fluxes(&solve(bench, tau, n, PLAIN)?);
            steps.iter_mut().zip(found).for_each(|(s, q)| s.push((n as f64, q)));
        }
        for (k, (steps, column)) in steps.into_iter().zip(["hot", "opposite", "side"]).enumerate() {
            let p = row.printed(column)?;
            let most = bracket.max(p.half);
            let sequence =
                Sequence::new(format!("τ = {tau}: q, {column} wall"), steps, Some((p.value, most)));
            out.check(
                format!("τ = {tau}, extrapolated: q, {column} wall"),
                p.value,
                sequence.value(),
                Limit::Absolute(most),
            );
            if k == 0 {
                out.sequences.push(sequence);
            }
        }
    }
    out.note(format!("Walls of the box are named {} in the scenes; z0 is the hot one.", FACES.join(", ")));
    Ok(out)
}
