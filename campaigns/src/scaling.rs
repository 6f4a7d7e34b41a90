//! Time and memory of one scene at several sizes: runs `zonal solve` for each and writes a table and a plot.
//!
//! A factor f stands for f times as many zones: the scene's `patch_size` is divided by √f and each of its `cells` multiplied by ∛f. Printed at last
//! is by how much time and memory grow when the zones double: 2 to the power of the slope of a straight line through all sizes, logarithms
//! on both axes. `--cells` sets the cells along each edge of a cube instead; of the spectral engine the floor is beside it, that no engine of
//! this kind goes below, with P products of n³ voxels padded to N = 2n and h = N/2 + 1:
//!
//! ```text
//!     operations   2P [2.5 n² N + 5 n h N + 5 N h N] log₂N        lines of zeros left out, at the rate of transforms in the cache, of the power of two above N
//!     bytes        16 n h N + the solution as written             one spectrum, and the requested output
//! ```

use crate::harness::process::{Cost, ZonalCommand};
use crate::harness::{Error, Outcome, ScratchFolder};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;
use zonal_fourier::{Complex64, Planner};
use zonal_io::output;
use zonal_report::plot::{LOG_LOG, LegendPlacement, Plot, SeriesMark};

/// Largest growth of time and memory when the zones double.
const MAX_GROWTH_PER_DOUBLING: f64 = 2.1;
/// Columns of a table, and of a table with floors.
const COLUMNS: &str = "size,zones,wall_s,processor_s,peak_MB";
const FLOOR_COLUMNS: &str = ",products,floor_s,floor_MB,time_over_floor,memory_over_floor";

#[derive(clap::Args)]
pub(crate) struct ScalingCampaign {
    /// Scene with one line `cells = …`, and one line `patch_size = …` for factors
    #[arg(default_value = "scenes/cube.toml")]
    scene: PathBuf,
    /// Numbers of zones relative to the scene
    #[arg(long, value_delimiter = ',', default_value = "0.05,0.1,0.2,0.4,0.8,1.6")]
    factors: Vec<f64>,
    /// Numbers of cells along an edge, in place of factors
    #[arg(long, value_delimiter = ',')]
    cells: Vec<f64>,
    #[arg(long, default_value = "auto")]
    engine: String,
    #[arg(long)]
    tolerance: Option<String>,
    #[command(flatten)]
    command: ZonalCommand,
    /// Table (.csv)
    #[arg(long)]
    csv: Option<PathBuf>,
    /// Plot (.svg)
    #[arg(long)]
    plot: Option<PathBuf>,
}

/// A solve of one size.
struct SizedSolve {
    zones: f64,
    cost: Cost,
    /// Number of products, floors of time, s, and memory, MB.
    floor: Option<[f64; 3]>,
}

impl ScalingCampaign {
    pub(crate) fn run(&self) -> Outcome {
        let folder = self.scene.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let text = with_absolute_files(&std::fs::read_to_string(&self.scene)?, folder)?;
        let by_cells = !self.cells.is_empty();
        let more = if by_cells && self.engine == "spectral" { FLOOR_COLUMNS } else { "" };
        let mut table = format!("{COLUMNS}{more}\n");
        print!("{table}");
        let mut rows = Vec::new();
        for size in if by_cells { self.cells.clone() } else { self.factors.clone() } {
            let text = if by_cells {
                with_value(&text, "cells", |_| Ok(format!("{:?}", [size as usize; 3])))?
            } else {
                refined(&text, size)?
            };
            let row = self.solve(&text, size, !more.is_empty())?;
            let (zones, Cost { wall, processor, memory }) = (row.zones, row.cost);
            let mut line = format!("{size},{zones},{wall:.2},{processor:.2},{memory:.0}");
            if let Some([products, seconds, megabytes]) = row.floor {
                let (times, size) = (wall / seconds, memory / megabytes);
                line += &format!(",{products},{seconds:.3},{megabytes:.0},{times:.1},{size:.1}");
            }
            println!("{line}");
            table += &(line + "\n");
            if let Some(csv) = &self.csv {
                output::write_bytes(csv, table.as_bytes())?;
            }
            rows.push(row);
        }
        let growth = |of: fn(&SizedSolve) -> f64| doubled(&curve(&rows, |r| Some(of(r))));
        println!(
            "where zones double: processor time ×{:.2}, memory ×{:.2}, ×{MAX_GROWTH_PER_DOUBLING} at most",
            growth(|r| r.cost.processor),
            growth(|r| r.cost.memory)
        );
        if let Some(path) = &self.plot {
            let name = self.scene.file_stem().and_then(|s| s.to_str()).unwrap_or("scene");
            plot(&rows, name).write(path)?;
        }
        Ok(true)
    }

    fn solve(&self, text: &str, size: f64, has_floor: bool) -> Result<SizedSolve, Error> {
        let folder = ScratchFolder::new("scaling")?;
        let mut arguments = vec!["--max-memory", "20", "--engine", &self.engine];
        arguments.extend(self.tolerance.iter().flat_map(|t| ["--tolerance", t]));
        let (report, cost, run) = self.command.solve_text(&folder, text, &arguments)?;
        let zones = ["patches", "voxels", "panes"].iter().filter_map(|k| report["zones"][k].as_f64()).sum();
        // One product a step and one to begin with, and closure.
        let products = (report["residuals"][0].as_array().map_or(0, Vec::len) + 1) as f64;
        let written = std::fs::metadata(&run)?.len() as f64;
        let floor = if has_floor { Some(floor(size, products, written)?) } else { None };
        Ok(SizedSolve { zones, cost, floor })
    }
}

/// The text with `value(v)` in place of v on every line `key = v`; an error where there is none.
fn with_value(text: &str, key: &str, value: impl Fn(&str) -> Result<String, Error>) -> Result<String, Error> {
    let (mut found, mut out) = (false, String::new());
    for line in text.lines() {
        match line.split_once('=').filter(|(k, _)| k.trim() == key) {
            Some((_, old)) => {
                found = true;
                let _ = writeln!(out, "{key} = {}", value(old.split('#').next().unwrap_or("").trim())?);
            }
            None => _ = writeln!(out, "{line}"),
        }
    }
    if found { Ok(out) } else { Err(format!("the scene needs a line '{key} = …' to be sized by").into()) }
}

/// The scene with f times as many zones.
fn refined(text: &str, f: f64) -> Result<String, Error> {
    let text = with_value(text, "patch_size", |v| Ok((v.parse::<f64>()? / f.sqrt()).to_string()))?;
    with_value(&text, "cells", |v| {
        let cells = v.trim_matches(['[', ']']).split(',').map(|c| c.trim().parse::<f64>());
        let finer = cells.map(|c| Ok((c? * f.cbrt()).round().max(1.0) as usize));
        Ok(format!("{:?}", finer.collect::<Result<Vec<_>, Error>>()?))
    })
}

/// The text with the files of a folder named from the root.
fn with_absolute_files(text: &str, folder: &Path) -> Result<String, Error> {
    let mut parts = text.split("file = \"");
    let mut out = parts.next().unwrap_or("").to_string();
    for part in parts {
        let (name, after) = part.split_once('"').ok_or("a file's name does not end")?;
        let path = std::fs::canonicalize(folder.join(name))?.display().to_string();
        let _ = write!(out, "file = {path:?}{after}");
    }
    Ok(out)
}

/// Products with n³ voxels, and their floors of time, s, and memory, MB.
fn floor(n: f64, products: f64, written: f64) -> Result<[f64; 3], Error> {
    let (long, half) = (2.0 * n, n + 1.0);
    let operations =
        2.0 * (2.5 * n * n * long + 5.0 * n * half * long + 5.0 * long * half * long) * long.log2();
    let threads = std::thread::available_parallelism()?.get() as f64;
    let rate = transform_rate((long as usize).next_power_of_two());
    Ok([products, products * operations / (rate * threads), (16.0 * n * half * long + written) / 1e6])
}

/// Operations a second of one thread: complex transforms of this length, sixteen lines at a time, 5 N log₂N each.
fn transform_rate(length: usize) -> f64 {
    const LINES_AT_A_TIME: usize = 16;
    let plan = Planner::default().forward(length);
    let mut lines = vec![Complex64::default(); LINES_AT_A_TIME * length];
    let mut scratch = vec![Default::default(); plan.get_inplace_scratch_len()];
    let (mut best, mut done) = (f64::INFINITY, 0.0);
    while done < 0.2 {
        let start = Instant::now();
        plan.process_with_scratch(&mut lines, &mut scratch);
        let seconds = start.elapsed().as_secs_f64();
        (best, done) = (best.min(seconds), done + seconds);
    }
    (LINES_AT_A_TIME * length) as f64 * 5.0 * (length as f64).log2() / best
}

/// Growth of y where x doubles: by a straight line through the logarithms.
fn doubled(points: &[(f64, f64)]) -> f64 {
    let logs = || points.iter().map(|p| (p.0.ln(), p.1.ln()));
    let n = points.len() as f64;
    let (mx, my) = logs().fold((0.0, 0.0), |m, p| (m.0 + p.0 / n, m.1 + p.1 / n));
    let products = logs().map(|p| [(p.0 - mx) * (p.1 - my), (p.0 - mx).powi(2)]);
    let [xy, xx] = products.fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]);
    (xy / xx).exp2()
}

/// A number of each solve against its zones.
fn curve(rows: &[SizedSolve], of: impl Fn(&SizedSolve) -> Option<f64>) -> Vec<(f64, f64)> {
    rows.iter().filter_map(|r| Some((r.zones, of(r)?))).collect()
}

fn plot(rows: &[SizedSolve], name: &str) -> Plot {
    let mut p = Plot::new(&format!("Time and memory by size: {name}"), "zones", "s, 10 MB", LOG_LOG);
    p.legend = LegendPlacement::LowerRight;
    p.add("processor time, s", SeriesMark::LineWithPoints, 0, curve(rows, |r| Some(r.cost.processor)))
        .add("wall time, s", SeriesMark::LineWithPoints, 2, curve(rows, |r| Some(r.cost.wall)))
        .add("peak memory, 10 MB", SeriesMark::LineWithPoints, 1, curve(rows, |r| Some(0.1 * r.cost.memory)));
    if rows.iter().any(|r| r.floor.is_some()) {
        p.add(
            "floor of wall time: transforms alone",
            SeriesMark::Dashed,
            2,
            curve(rows, |r| Some(r.floor?[1])),
        )
        .add(
            "floor of memory: one spectrum, the solution",
            SeriesMark::Dashed,
            1,
            curve(rows, |r| Some(0.1 * r.floor?[2])),
        );
    }
    p
}
