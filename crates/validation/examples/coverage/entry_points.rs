//! The same scene through the command, through Python, and as a mesh file through `zonal init`.
//!
//! The command and Python must write solutions of the same bytes, and the same table. A model written as one OBJ file becomes a scene by
//! `zonal init`, which is solved and compared with random walks as the other scenes are.

use super::measure::{Quantity, names, zone_problem, zones};
use super::model::{Block, FACES, ModelShape, SceneModel, add, obj, wall};
use std::path::{Path, PathBuf};
use std::process::Command;
use zonal_io::input;
use zonal_reference::forward_monte_carlo::{ClosedSurfaces, ForwardProblem, trace_forward};
use zonal_scene::NoProgress;

/// One scene in this number goes through the programs.
const SCENES_PER_TRIAL: u64 = 5;
/// Patches that `zonal init` is asked for.
const PROPOSED_PATCHES: &str = "150";
/// Tolerance of the solve of a proposed scene.
const PROPOSED_TOLERANCE: f64 = 0.05;
/// The largest memory of a solve of a proposed scene, bytes.
const MAX_MEMORY: u64 = 2 << 30;

/// Programs of a campaign.
#[derive(Clone, Debug, Default)]
pub(crate) struct EntryPoints {
    /// The command `zonal`.
    pub command: Option<PathBuf>,
    /// A Python interpreter that has the package `zonal`.
    pub python: Option<PathBuf>,
}

/// Results of the programs for a scene.
#[derive(Default)]
pub(crate) struct TrialResult {
    /// Quantities of the scene that `zonal init` proposed.
    pub quantities: Vec<Quantity>,
    /// Differences and failures.
    pub failures: Vec<String>,
}

/// Python: the solution of a scene file, its bytes and its table.
const PYTHON: &str = "\
import json, sys
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
    /// Tries scene number `index` in `folder`, where the files of the model lie.
    pub(crate) fn try_scene(
        &self,
        model: &SceneModel,
        index: u64,
        walks: usize,
        folder: &Path,
    ) -> TrialResult {
        let mut out = TrialResult::default();
        let Some(command) = &self.command else { return out };
        match index % SCENES_PER_TRIAL {
            0 => out.failures.extend(self.compare_programs(command, model, folder).err()),
            1 => match try_init(command, model, index, walks, folder) {
                Ok(list) => out.quantities = list,
                Err(e) => out.failures.push(format!("init: {e}")),
            },
            _ => {}
        }
        out
    }

    /// Solves by the command and by Python.
    fn compare_programs(&self, command: &Path, model: &SceneModel, folder: &Path) -> Result<(), String> {
        super::run::write(model, folder).map_err(|e| e.to_string())?;
        let words = ["solve", "scene.toml", "-o", "command.npz", "--quiet"];
        let solved = run(command, &words, folder);
        if let Some(python) = &self.python {
            let by_python = run(python, &["-c", PYTHON], folder);
            if let (Err(a), Err(b)) = (&solved, &by_python) {
                // A refusal is the same in both.
                let told = a.rsplit("error: ").next().unwrap_or(a).trim();
                return if b.contains(told) { Ok(()) } else { Err(format!("command: {a}; Python: {b}")) };
            }
            by_python.map_err(|e| format!("Python: {e}"))?;
        }
        solved.map_err(|e| format!("command: {e}"))?;
        run(command, &["export", "command.npz", "-o", "command.csv", "--quiet"], folder)?;
        if self.python.is_some() {
            for extension in ["npz", "csv"] {
                let [a, b] =
                    ["command", "python"].map(|p| std::fs::read(folder.join(format!("{p}.{extension}"))));
                if a.map_err(|e| e.to_string())? != b.map_err(|e| e.to_string())? {
                    return Err(format!("command and Python write different {extension} files"));
                }
            }
        }
        Ok(())
    }
}

/// Runs a program; its words on standard error if it fails.
fn run(program: &Path, words: &[&str], folder: &Path) -> Result<(), String> {
    let done = Command::new(program).args(words).current_dir(folder).output().map_err(|e| e.to_string())?;
    match done.status.success() {
        true => Ok(()),
        false => Err(String::from_utf8_lossy(&done.stderr).trim().to_string()),
    }
}

/// All faces of a model, or none where a file of faces cannot have its solution.
fn faces(model: &SceneModel) -> Option<Vec<[Block; 4]>> {
    let plain = model.medium.is_none()
        && model.panes.is_empty()
        && model.periodic == [false; 3]
        && model.expected_warning.is_none()
        && !model.features.iter().any(|f| ["touching solids", "nested"].contains(f));
    if !plain {
        return None;
    }
    let mut out = Vec::new();
    for s in &model.lowered().surfaces {
        match &s.shape {
            ModelShape::Plate { corner, edges: [a, b], triangle: false } => {
                out.push([*corner, add(*corner, *a), add(add(*corner, *a), *b), add(*corner, *b)]);
            }
            ModelShape::Mesh { quads } => out.extend(quads),
            ModelShape::Room { min, max, .. } => out.extend((0..FACES.len()).map(|k| {
                let (corner, [a, b]) = wall(*min, *max, k);
                [corner, add(corner, a), add(add(corner, a), b), add(corner, b)]
            })),
            ModelShape::Plate { .. } | ModelShape::Box { .. } => return None,
        }
    }
    (!out.is_empty()).then_some(out)
}

/// Solves the scene that `zonal init` proposes for the faces of a model.
fn try_init(
    command: &Path,
    model: &SceneModel,
    index: u64,
    walks: usize,
    folder: &Path,
) -> Result<Vec<Quantity>, String> {
    let Some(faces) = faces(model) else { return Ok(Vec::new()) };
    std::fs::write(folder.join("model.obj"), obj(&faces, None)).map_err(|e| e.to_string())?;
    let words = [
        "init",
        "model.obj",
        "-o",
        "proposed.toml",
        "--unit",
        "m",
        "--up",
        "z",
        "--force",
        "--patches",
        PROPOSED_PATCHES,
    ];
    run(command, &words, folder)?;
    let text = std::fs::read_to_string(folder.join("proposed.toml")).map_err(|e| e.to_string())?;
    let lines: Vec<&str> = text.lines().filter(|l| !l.starts_with("tolerance")).collect();
    let settings = format!("[solve]\ntolerance = {PROPOSED_TOLERANCE}\ndiscretization_error = true");
    let text = lines.join("\n").replacen("[solve]", &settings, 1);
    let scene = input::parse_scene(&text, Some(folder), "proposed.toml").map_err(|e| e.to_string())?;
    let s = zonal_solve::solve(scene, MAX_MEMORY, &NoProgress).map_err(|e| e.to_string())?;
    let open = ClosedSurfaces::default();
    let mut list = names(&s, &trace_forward(&s.scene, &open, ForwardProblem::Continuous, walks, 2 * index));
    list.extend(zones(&s, &trace_forward(&s.scene, &open, zone_problem(&s), walks, 2 * index + 1)));
    let warned = super::stated::warned(&s.report);
    Ok(list.into_iter().map(|q| Quantity { scene: index, engine: "init, auto", warned, ..q }).collect())
}
