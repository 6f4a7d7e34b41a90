//! The same scene through the command, through Python, and as a mesh file through `zonal init`.
//!
//! The command and Python must write solutions of the same bytes, and the same table. A model written as one OBJ file becomes a scene by
//! `zonal init`, which is solved and compared with random walks as the other scenes are.

use super::measure::MAX_MEMORY;
use super::model::{Block, FACES, ModelShape, SceneModel, obj, quad, wall};
use super::quantities::{names, warned, zone_problem, zones};
use super::result::{Quantity, SceneResult};
use crate::harness::Error;
use std::path::{Path, PathBuf};
use std::process::Command;
use zonal_io::input;
use zonal_reference::forward_monte_carlo::{ClosedSurfaces, ForwardProblem, trace_forward};
use zonal_scene::NoProgress;

/// One scene in this number goes through the programs.
const SCENES_PER_TRIAL: u64 = 5;
/// The scene that `zonal init` is asked for.
const INIT: &str = "init model.obj -o proposed.toml --unit m --up z --force --patches 150";
/// Settings of the solve of a proposed scene.
const PROPOSED_SETTINGS: &str = "[solve]\ntolerance = 0.05\ndiscretization_error = true";
/// The name of the engine of proposed scenes.
const PROPOSED: &str = "init, auto";

/// Programs that some of the scenes go through.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct EntryPoints {
    /// Command `zonal` that solves scenes too
    #[arg(long)]
    zonal: Option<PathBuf>,
    /// Python interpreter with the package `zonal`
    #[arg(long, requires = "zonal")]
    python: Option<PathBuf>,
}

/// Python: the solution of a scene file, its bytes and its table.
const PYTHON: &str = "\
import numpy as np
import zonal as zn
solution = zn.load_scene('scene.toml').solve()
solution.save('python.npz')
solution.export('python.csv')
[(w.code, w.severity, w.text, w.part) for w in [*solution.warnings, *solution.notes]]
table = solution.table
assert not any(v.dtype == np.float32 for v in table.values() if isinstance(v, np.ndarray)), 'single precision'
";

impl EntryPoints {
    /// Tries a scene in `folder`, where the files of the model lie.
    pub(super) fn try_scene(&self, model: &SceneModel, walks: usize, folder: &Path, out: &mut SceneResult) {
        let Some(command) = &self.zonal else { return };
        match out.index % SCENES_PER_TRIAL {
            0 => out.failures.extend(self.compare_programs(command, model, folder).err()),
            1 => match try_init(command, model, out.index, walks, folder) {
                Ok(list) if list.is_empty() => {}
                Ok(list) => {
                    out.engines.push(PROPOSED);
                    out.quantities.extend(list);
                }
                Err(e) => out.failures.push(format!("init: {e}")),
            },
            _ => {}
        }
    }

    /// Solves by the command and by Python.
    fn compare_programs(&self, command: &Path, model: &SceneModel, folder: &Path) -> Result<(), String> {
        model.write(folder).map_err(|e| e.to_string())?;
        let solved = run(command, "solve scene.toml -o command.npz --quiet".split(' '), folder);
        if let Some(python) = &self.python {
            let by_python = run(python, ["-c", PYTHON].into_iter(), folder);
            if let (Err(a), Err(b)) = (&solved, &by_python) {
                // A refusal is the same in both.
                let told = a.rsplit("error: ").next().unwrap_or(a).trim();
                return if b.contains(told) { Ok(()) } else { Err(format!("command: {a}; Python: {b}")) };
            }
            by_python.map_err(|e| format!("Python: {e}"))?;
        }
        solved.map_err(|e| format!("command: {e}"))?;
        run(command, "export command.npz -o command.csv --quiet".split(' '), folder)?;
        for extension in ["npz", "csv"].iter().filter(|_| self.python.is_some()) {
            let file =
                |p: &str| std::fs::read(folder.join(format!("{p}.{extension}"))).map_err(|e| e.to_string());
            if file("command")? != file("python")? {
                return Err(format!("command and Python write different {extension} files"));
            }
        }
        Ok(())
    }
}

/// Runs a program; its words on standard error if it fails.
fn run<'a>(program: &Path, words: impl Iterator<Item = &'a str>, folder: &Path) -> Result<(), String> {
    let program = std::path::absolute(program).map_err(|e| e.to_string())?;
    let done = Command::new(program).args(words).current_dir(folder).output().map_err(|e| e.to_string())?;
    if done.status.success() { Ok(()) } else { Err(String::from_utf8_lossy(&done.stderr).trim().to_string()) }
}

/// All faces of a model, or none where a file of faces cannot have its solution.
fn faces(model: &SceneModel) -> Vec<[Block; 4]> {
    let plain = model.medium.is_none()
        && model.panes.is_empty()
        && model.periodic == [false; 3]
        && model.expected_warning.is_none()
        && !model.features.iter().any(|f| ["touching solids", "nested"].contains(f));
    let mut out = Vec::new();
    for s in model.lowered().surfaces.iter().filter(|_| plain) {
        match &s.shape {
            ModelShape::Plate { corner, edges, triangle: false } => out.push(quad(*corner, *edges)),
            ModelShape::Mesh { quads } => out.extend(quads),
            ModelShape::Room { min, max, .. } => out.extend((0..FACES.len()).map(|k| {
                let (corner, edges) = wall(*min, *max, k);
                quad(corner, edges)
            })),
            ModelShape::Plate { .. } | ModelShape::Box { .. } => return Vec::new(),
        }
    }
    out
}

/// Solves the scene that `zonal init` proposes for the faces of a model.
fn try_init(
    command: &Path,
    model: &SceneModel,
    index: u64,
    walks: usize,
    folder: &Path,
) -> Result<Vec<Quantity>, Error> {
    let faces = faces(model);
    if faces.is_empty() {
        return Ok(Vec::new());
    }
    std::fs::write(folder.join("model.obj"), obj(&faces, None))?;
    run(command, INIT.split(' '), folder)?;
    let text = std::fs::read_to_string(folder.join("proposed.toml"))?;
    let lines: Vec<&str> = text.lines().filter(|l| !l.starts_with("tolerance")).collect();
    let text = lines.join("\n").replacen("[solve]", PROPOSED_SETTINGS, 1);
    let scene = input::parse_scene(&text, Some(folder), "proposed.toml")?;
    let s = zonal_solve::solve(scene, MAX_MEMORY, &NoProgress)?;
    let open = ClosedSurfaces::default();
    let mut list = names(&s, &trace_forward(&s.scene, &open, ForwardProblem::Continuous, walks, 2 * index));
    list.extend(zones(&s, &trace_forward(&s.scene, &open, zone_problem(&s), walks, 2 * index + 1)));
    let warned = warned(&s.report);
    Ok(list.into_iter().map(|q| Quantity { engine: PROPOSED, warned, ..q }).collect())
}
