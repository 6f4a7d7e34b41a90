//! What the size of the zones costs: estimates beside errors that are known from far finer zones.

use super::bench::{Bench, Room, net};
use super::case::{Case, Outcome};
use super::cube::{LINEAR, PLAIN};
use super::furnace;
use crate::Failure;
use zonal_scene::solution::Energy;
use zonal_scene::{Bands, Solution, Zoning};

/// Told on request.
const TOLD: &str = "zoning_error = true";

/// The cases.
pub(super) const CASES: [Case; 1] = [Case {
    name: "errors-of-zones",
    group: "Errors of zones",
    title: "what the size of the zones costs, estimated and known",
    about: "The furnace of section 9 (net wall powers) and a lit cube (κL = 2, albedo 0.9, power absorbed by the walls), zones of one radiosity and with slopes. Error: the distance to the answer of zones of a tenth of a metre (furnace) and a \
        twenty-fourth (cube), with slopes. Limit: the error of zones that the report of the coarse solve gives.",
    quick: true,
    needs: None,
    run,
}];

fn run(bench: &Bench) -> Result<Outcome, Failure> {
    let mut out = Outcome::default();
    let exact = furnace::solve_with(bench, 10, 0.0, LINEAR)?;
    for (m, settings, word) in [
        (2, PLAIN, "none"),
        (4, PLAIN, "none"),
        (6, PLAIN, "none"),
        (2, LINEAR, "slopes"),
        (4, LINEAR, "slopes"),
    ] {
        let s = furnace::solve_with(bench, m, 0.0, &format!("{settings}\n{TOLD}"))?;
        let (zoning, heat) = (told(&s)?, s.report.heat.as_ref().map_or(&[][..], |h| &h.rows));
        for face in ["z0", "z1", "x0"] {
            let row = heat.iter().position(|r| r.name.ends_with(face));
            let row = row.ok_or_else(|| Failure::new(format!("there is no wall {face}")))?;
            let error = (net(&s, face) - net(&exact, face)).abs() * heat[row].size;
            out.error(format!("furnace, m = {m}, {word}: {face}, W"), error, zoning.heat[row][1]);
        }
    }
    let exact = lit(bench, 24, LINEAR)?;
    for (n, settings, word) in [(5, PLAIN, "none"), (10, PLAIN, "none"), (6, LINEAR, "slopes")] {
        let s = lit(bench, n, &format!("{settings}\n{TOLD}"))?;
        let zoning = told(&s)?;
        for face in ["x0", "x1", "y0"] {
            let limit = absorbed(&zoning.energy, face)?[0];
            let [own, other] = [&s, &exact].map(|s| absorbed(&s.report.energy, face));
            out.error(format!("cube, {n}³, {word}: {face}, W"), (own?[0] - other?[0]).abs(), limit);
        }
    }
    Ok(out)
}

/// The lit cube.
fn lit(bench: &Bench, n: usize, settings: &str) -> Result<Solution, Failure> {
    let name = format!("zones-cube-{n}-{}", if settings.contains(LINEAR) { "slopes" } else { "none" });
    let mut room = Room::new([1.0; 3], [n; 3], 2.0)
        .medium("albedo = 0.9")
        .solve(&format!("engine = \"spectral\"\n{settings}"));
    for face in 0..6 {
        room = room.wall(face, 0.5, if face == 0 { 1.0 } else { 0.0 });
    }
    bench.solve(&name, &room.text(&name))
}

fn told(s: &Solution) -> Result<&Zoning, Failure> {
    s.report.zoning.as_ref().ok_or_else(|| Failure::new("the report does not say what its zones cost"))
}

/// Power that a wall absorbs, W a band.
fn absorbed<'a>(e: &'a Energy, face: &str) -> Result<&'a Bands, Failure> {
    let own = e.absorbed_surfaces.iter().find(|x| x.0.ends_with(face));
    own.map(|x| &x.1).ok_or_else(|| Failure::new(format!("there is no wall {face}")))
}
