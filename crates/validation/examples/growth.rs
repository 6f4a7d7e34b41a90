//! Cost of a solve as one scene is refined: runs `zonal solve` for each size and writes a table and a plot.
//!
//! ```text
//! growth SCENE.toml [--factors 0.05,0.1,0.2,0.4,0.8,1.6] [--tolerance T] [--command target/release/zonal]
//!        [--csv docs/growth-sponza.csv] [--plot docs/growth-sponza.svg]
//! ```
//!
//! A factor f stands for f times as many zones: the scene's `patch_size` is divided by √f and each of its `cells` multiplied by ∛f. Processor
//! time and peak memory are those of the command as a whole, reading and writing included, from Linux's `/proc`. Printed at last
//! is by how much each grows when the zones double: 2 to the power of the slope of a straight line through all sizes, logarithms on both
//! axes.

#[path = "common/command.rs"]
mod command;
#[path = "common/sized.rs"]
mod sized;

use std::path::{Path, PathBuf};
use zonal_io::output;
use zonal_report::plot::{LOG_LOG, LegendPlacement, Plot, SeriesMark};

/// Largest growth of time and memory when the zones double.
const MAX_GROWTH_PER_DOUBLING: f64 = 2.1;
/// Unit of the memory in the plot, MB, which brings it among the other curves.
const PLOTTED_MEMORY_UNIT: f64 = 10.0;
const CSV_HEADER: &str = "zones,patches,voxels,panes,wall_s,processor_s,peak_MB,samples_a_zone,rays_a_zone,estimate_H,estimate_G\n";

/// Cost of a size.
struct GrowthRow {
    zones: [f64; 3],
    /// Wall time and processor time, s; peak memory, MB.
    took: [f64; 3],
    samples: f64,
    rays: f64,
    estimate: [f64; 2],
}

impl GrowthRow {
    fn all(&self) -> f64 {
        self.zones.iter().sum()
    }
    fn record(&self) -> String {
        let ([patches, voxels, panes], [wall, processor, peak]) = (self.zones, self.took);
        format!(
            "{},{patches},{voxels},{panes},{wall:.1},{processor:.1},{peak:.0},{:.2},{:.1},{:.4},{:.4}\n",
            self.all(),
            self.samples,
            self.rays,
            self.estimate[0],
            self.estimate[1]
        )
    }
}

/// The scene `f` times as fine, its files named from the root.
fn refined(text: &str, folder: &Path, f: f64) -> Result<String, Box<dyn std::error::Error>> {
    let text = sized::with(text, "patch_size", |v| Ok((v.parse::<f64>()? / f.sqrt()).to_string()))?;
    let text = sized::with(&text, "cells", |v| {
        let cells = v.trim_matches(['[', ']']).split(',').map(|c| c.trim().parse::<f64>());
        let finer = cells.map(|c| Ok((c? * f.cbrt()).round().max(1.0) as usize));
        Ok(format!("{:?}", finer.collect::<Result<Vec<_>, Box<dyn std::error::Error>>>()?))
    })?;
    let mut out = String::new();
    for line in text.lines() {
        out += &match line.split_once("file = \"") {
            Some((before, rest)) => {
                let (name, after) = rest.split_once('"').ok_or("a file's name does not end on its line")?;
                let path = std::fs::canonicalize(folder.join(name))?.display().to_string();
                format!("{before}file = {path:?}{after}\n")
            }
            None => format!("{line}\n"),
        };
    }
    Ok(out)
}

fn solve(
    command: &Path,
    text: &str,
    tolerance: Option<&String>,
) -> Result<GrowthRow, Box<dyn std::error::Error>> {
    let mut more = vec!["--max-memory", "20"];
    more.extend(tolerance.iter().flat_map(|t| ["--tolerance", t.as_str()]));
    let (report, took, ()) = command::solve(command, text, &more, |_| Ok(()))?;
    let zones = ["patches", "voxels", "panes"].map(|k| report["zones"][k].as_f64().unwrap_or(0.0));
    let all: f64 = zones.iter().sum();
    let counts = report["counts"].as_array().cloned().unwrap_or_default();
    let count = |names: &[&str]| {
        let wanted = counts.iter().filter(|c| c["name"].as_str().is_some_and(|n| names.contains(&n)));
        wanted.filter_map(|c| c["count"].as_f64()).fold(0.0, |s, c| s + c) / all
    };
    let estimate = ["patches", "volumes"].map(|k| report["estimate"][k][0].as_f64().unwrap_or(f64::NAN));
    let samples = count(&["samples of the final gather"]);
    let rays = count(&["rays between clusters", "transport_rays"]);
    Ok(GrowthRow { zones, took, samples, rays, estimate })
}

/// Growth of y where x doubles: by a straight line through the logarithms.
fn doubled(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|p| (p.0.ln(), p.1.ln())).collect();
    let n = logs.len() as f64;
    let (mx, my) = logs.iter().fold((0.0, 0.0), |m, p| (m.0 + p.0 / n, m.1 + p.1 / n));
    let (xy, xx) =
        logs.iter().fold((0.0, 0.0), |s, p| (s.0 + (p.0 - mx) * (p.1 - my), s.1 + (p.0 - mx) * (p.0 - mx)));
    (xy / xx).exp2()
}

/// One number of a row against the zones, over a unit.
fn curve(rows: &[GrowthRow], of: fn(&GrowthRow) -> f64, unit: f64) -> Vec<(f64, f64)> {
    rows.iter().map(|r| (r.all(), of(r) / unit)).collect()
}

fn draw(rows: &[GrowthRow], name: &str, path: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let title = format!("Growth at a fixed tolerance: {name}");
    let mut p = Plot::new(&title, "zones", "processor s, 10 MB, a zone", LOG_LOG);
    p.legend = LegendPlacement::LowerRight;
    let (time, memory) = (curve(rows, |r| r.took[1], 1.0), curve(rows, |r| r.took[2], PLOTTED_MEMORY_UNIT));
    let bound = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
        let (x, y) = points.first().copied().unwrap_or((1.0, 1.0));
        points.iter().map(|p| (p.0, y * (p.0 / x).powf(MAX_GROWTH_PER_DOUBLING.log2()))).collect()
    };
    p.add("processor time, s", SeriesMark::LineWithPoints, 0, time.clone())
        .add("peak memory, 10 MB", SeriesMark::LineWithPoints, 1, memory.clone())
        .add("rays a zone", SeriesMark::LineWithPoints, 2, curve(rows, |r| r.rays, 1.0))
        .add("samples a zone", SeriesMark::LineWithPoints, 3, curve(rows, |r| r.samples, 1.0))
        .add("×2.1 where zones double", SeriesMark::Dashed, 7, bound(&time))
        .add("", SeriesMark::Dashed, 7, bound(&memory));
    Ok(p.write(path).map_err(|e| e.to_string())?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let option = |name: &str| arguments.iter().position(|a| a == name).and_then(|k| arguments.get(k + 1));
    let file = PathBuf::from(arguments.first().filter(|a| !a.starts_with("--")).ok_or("which scene?")?);
    let command = PathBuf::from(option("--command").map_or("target/release/zonal", |c| c.as_str()));
    let factors = option("--factors").map_or("0.05,0.1,0.2,0.4,0.8,1.6", |f| f.as_str());
    let folder = file.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let text = std::fs::read_to_string(&file)?;
    let mut rows = Vec::new();
    let mut table = CSV_HEADER.to_string();
    print!("{CSV_HEADER}");
    for factor in factors.split(',') {
        let row = solve(&command, &refined(&text, folder, factor.parse()?)?, option("--tolerance"))?;
        print!("{}", row.record());
        table += &row.record();
        if let Some(csv) = option("--csv") {
            output::write_bytes(Path::new(csv), table.as_bytes())?;
        }
        rows.push(row);
    }
    let (time, memory) =
        (doubled(&curve(&rows, |r| r.took[1], 1.0)), doubled(&curve(&rows, |r| r.took[2], 1.0)));
    println!(
        "where zones double: processor time ×{time:.2}, memory ×{memory:.2}, ×{MAX_GROWTH_PER_DOUBLING} at most"
    );
    let name = file.file_stem().and_then(|s| s.to_str()).unwrap_or("scene");
    option("--plot").map_or(Ok(()), |p| draw(&rows, name, Path::new(p)))
}
