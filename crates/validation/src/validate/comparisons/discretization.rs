//! Discretization error: estimates against errors known from far finer zones.

use crate::validate::box_scene::BoxScene;
use crate::validate::case::{CaseOutcome, ValidationCase};
use crate::validate::case_context::CaseContext;
use crate::validate::exact::cube::{CONSTANT_BASIS, LINEAR_BASIS};
use crate::validate::gas::furnace;
use crate::validate::measures::net_flux;
use zonal_report::Failure;
use zonal_scene::{Bands, DiscretizationError, EnergyBalance, Solution};

/// Line of `[solve]` that requests the estimate.
const WITH_DISCRETIZATION_ERROR: &str = "discretization_error = true";

/// The cases.
pub(crate) const CASES: [ValidationCase; 1] = [ValidationCase {
    name: "errors-of-zones",
    group: "Errors of zones",
    title: "discretization error, estimated and known",
    about: "The furnace of section 9 (net wall powers) and a lit cube (κL = 2, albedo 0.9, power absorbed by the walls), zones of one radiosity and with slopes. Error: the distance to the answer of zones of a tenth of a metre (furnace) and a \
        twenty-fourth (cube), with slopes. Limit: the error of zones that the report of the coarse solve gives.",
    quick: true,
    needs: None,
    run,
}];

fn run(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let exact = furnace::solve_with(bench, 10, 0.0, LINEAR_BASIS)?;
    for (m, settings, word) in [
        (2, CONSTANT_BASIS, "none"),
        (4, CONSTANT_BASIS, "none"),
        (6, CONSTANT_BASIS, "none"),
        (2, LINEAR_BASIS, "slopes"),
        (4, LINEAR_BASIS, "slopes"),
    ] {
        let s = furnace::solve_with(bench, m, 0.0, &format!("{settings}\n{WITH_DISCRETIZATION_ERROR}"))?;
        let (stated, heat) = (discretization_error(&s)?, s.report.heat.as_ref().map_or(&[][..], |h| &h.rows));
        for face in ["z0", "z1", "x0"] {
            let row = heat.iter().position(|r| r.name.ends_with(face));
            let row = row.ok_or_else(|| Failure::new(format!("there is no wall {face}")))?;
            let error = (net_flux(&s, face) - net_flux(&exact, face)).abs() * heat[row].size;
            out.error(format!("furnace, m = {m}, {word}: {face}, W"), error, stated.heat[row][1]);
        }
    }
    let exact = lit_cube(bench, 24, LINEAR_BASIS)?;
    for (n, settings, word) in
        [(5, CONSTANT_BASIS, "none"), (10, CONSTANT_BASIS, "none"), (6, LINEAR_BASIS, "slopes")]
    {
        let s = lit_cube(bench, n, &format!("{settings}\n{WITH_DISCRETIZATION_ERROR}"))?;
        let stated = discretization_error(&s)?;
        for face in ["x0", "x1", "y0"] {
            let limit = absorbed(&stated.energy, face)?.first();
            let [own, other] = [&s, &exact].map(|s| absorbed(&s.report.energy, face));
            out.error(format!("cube, {n}³, {word}: {face}, W"), (own? - other?).first().abs(), limit);
        }
    }
    Ok(out)
}

/// The lit cube.
fn lit_cube(bench: &CaseContext, n: usize, settings: &str) -> Result<Solution, Failure> {
    let name = format!("zones-cube-{n}-{}", if settings.contains(LINEAR_BASIS) { "slopes" } else { "none" });
    let mut room = BoxScene::new([1.0; 3], [n; 3], 2.0)
        .medium("albedo = 0.9")
        .solve(&format!("engine = \"spectral\"\n{settings}"));
    for face in 0..6 {
        room = room.wall(face, 0.5, if face == 0 { 1.0 } else { 0.0 });
    }
    bench.solve(&name, &room.text(&name))
}

fn discretization_error(s: &Solution) -> Result<&DiscretizationError, Failure> {
    s.report
        .discretization_error
        .as_ref()
        .ok_or_else(|| Failure::new("the report has no discretization error"))
}

/// Power that a wall absorbs, W per band.
fn absorbed(e: &EnergyBalance, face: &str) -> Result<Bands, Failure> {
    let own = e.absorbed_surfaces.iter().find(|x| x.0.ends_with(face));
    own.map(|x| x.1).ok_or_else(|| Failure::new(format!("there is no wall {face}")))
}
