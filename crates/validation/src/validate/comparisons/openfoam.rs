//! OpenFOAM: the walls of a cavity, grey and diffuse, by its model viewFactor.

use crate::validate::box_scene::BoxScene;
use crate::validate::case::{AcceptanceLimit, CaseOutcome, ValidationCase};
use crate::validate::case_context::CaseContext;
use crate::validate::data::table;
use crate::validate::measures::net_flux;
use zonal_report::Failure;
use zonal_scene::Solution;

/// Emissivity of all walls.
const EMISSIVITY: f64 = 0.95;
/// Temperatures of x0, x1, y0, y1, K.
const WALL_TEMPERATURES: [(&str, f64); 4] = [("x0", 298.5), ("x1", 288.5), ("y0", 288.5), ("y1", 288.5)];
/// Faces along a wall, those of OpenFOAM after it puts them together in pairs.
const FACES_PER_WALL: usize = 40;
/// Extinction that stands for a vacuum, 1/m: scenes that repeat themselves have a medium.
const VACUUM_EXTINCTION: f64 = 1e-9;

/// The cases.
pub(crate) const CASES: [ValidationCase; 1] = [ValidationCase {
    name: "openfoam",
    group: "Other solvers",
    title: "OpenFOAM, grey diffuse square cavity, model viewFactor",
    about: "The case of `../shared/data/thermal-openfoam` comes without results: its numbers here are OpenFOAM's own, from a run of version 1912 (`peers/openfoam_cavity.sh`) with the case's mesh, emissivity \
        0.95 and the temperatures of its start (x = 0 at 298.5 K, all else at 288.5 K): the radiative part alone, the flow at rest. Ours: walls cut as finely around next to nothing (κ = 10⁻⁹ 1/m), endless along the third axis. By symmetry top \
        and bottom are alike; OpenFOAM's differ by 1.1 %, which is the error of its view factors at 40 faces a wall, smoothed to close. Hence the limits: 0.5 % for the warm wall, 1.5 % for the others.",
    quick: true,
    needs: None,
    run,
}];

fn room() -> BoxScene {
    let mut room = BoxScene::new([1.0; 3], [FACES_PER_WALL, FACES_PER_WALL, 1], VACUUM_EXTINCTION)
        .solve("engine = \"spectral\"");
    room.walls[4..].fill(None);
    room = room.warm(EMISSIVITY, WALL_TEMPERATURES[1].1).medium("heat_source = 0");
    for (face, (_, kelvin)) in WALL_TEMPERATURES.into_iter().enumerate() {
        room = room.wall(face, EMISSIVITY, kelvin);
    }
    room
}

/// Net flux into each patch of a wall, in the order along it, W/m².
fn profile(s: &Solution, wall: &str) -> Vec<f64> {
    let mut all: Vec<(f64, f64)> = (s.zones.patches.iter().enumerate())
        .filter(|(_, p)| s.scene.surfaces()[p.surface].name.ends_with(wall))
        .map(|(i, p)| {
            let c = p.plate.centre();
            let along = if wall.starts_with('x') { c.y } else { c.x };
            (along, (s.fields.incident[i] - s.fields.radiosity[i]).first())
        })
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.into_iter().map(|a| a.1).collect()
}

fn run(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let s = bench.solve("openfoam", &room().text("openfoam"))?;
    let table = table!("openfoam.csv")?;
    let mut pointwise = Vec::new();
    for (wall, _) in WALL_TEMPERATURES {
        let mut theirs = Vec::new();
        for row in table.rows() {
            if row.text("wall")? == wall {
                theirs.push(row.number("value")?);
            }
        }
        let mean = theirs.iter().sum::<f64>() / theirs.len() as f64;
        let net = -net_flux(&s, wall);
        let most = if wall == "x0" { 0.5e-2 } else { 1.5e-2 };
        out.check(format!("mean net flux into {wall}, W/m²"), mean, net, AcceptanceLimit::Relative(most));
        let ours = profile(&s, wall);
        pointwise.extend(ours.iter().zip(&theirs).map(|(o, t)| (o - t) / mean));
    }
    out.informational(
        "all faces: RMS difference over the mean of the wall",
        0.0,
        crate::validate::measures::rms(pointwise.into_iter()),
    );
    Ok(out)
}
