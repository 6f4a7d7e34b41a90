//! Solves of the scenes with each engine from coarse to fine, each measured against the reference of its scene.

use super::measure::{Measurement, measure};
use super::points::{self, Point, PointStatus};
use super::reference::Reference;
use super::scenes::{SCENES, SceneFolder};
use super::{DEFAULT_TABLE, SceneChoice, page, verdicts};
use crate::harness::process::{Cost, ZonalCommand};
use crate::harness::{Error, ScratchFolder};
use serde_json::Value;
use std::path::{Path, PathBuf};
use zonal_io::output;

/// The tolerances, from coarse to fine, and fewer of them for a quick run.
const TOLERANCES: [f64; 9] = [0.3, 0.2, 0.1, 0.05, 0.03, 0.02, 0.01, 0.005, 0.003];
const QUICK_TOLERANCES: [f64; 3] = [0.3, 0.1, 0.05];
/// Largest number of zones for the dense engine.
const MAX_DENSE_ZONES: usize = 8000;

#[derive(clap::Args)]
pub(crate) struct MeasuredSeries {
    #[command(flatten)]
    choice: SceneChoice,
    #[command(flatten)]
    command: ZonalCommand,
    #[arg(long, default_value = DEFAULT_TABLE)]
    csv: PathBuf,
    #[arg(long, value_delimiter = ',', default_value = "auto,rays,dense")]
    engines: Vec<String>,
    /// Tolerances from coarse to fine
    #[arg(long, value_delimiter = ',')]
    tolerances: Vec<f64>,
    /// Three tolerances
    #[arg(long)]
    quick: bool,
    /// Processor time of a solve after which a finer tolerance is not tried, s
    #[arg(long, default_value_t = 60.0)]
    limit: f64,
}

impl MeasuredSeries {
    /// Measures the scenes and prints the verdicts on the table.
    pub(super) fn run(&self) -> Result<(), Error> {
        let (references, shared) = (&self.choice.references, &self.choice.data.shared);
        let scratch = ScratchFolder::new("error-against-cost")?;
        let mut all = points::read(&self.csv)?;
        for scene in self.choice.chosen()? {
            let file = Reference::file(references, scene.name);
            if !file.exists() {
                println!("{}: skipped, for {} is absent", scene.name, file.display());
                continue;
            }
            let reference = Reference::read(&file)?;
            let Some(path) = scene.write(&SceneFolder { path: &scratch, shared })? else {
                println!("{}: skipped, for {} is absent", scene.name, shared.display());
                continue;
            };
            for engine in
                self.engines.iter().filter(|e| *e != "dense" || reference.zone_count <= MAX_DENSE_ZONES)
            {
                if let Err(e) = self.measure(scene.name, &path, engine, &reference, &mut all) {
                    println!("{}: {engine}: {e}", scene.name);
                }
            }
        }
        print!("{}", verdicts::text(&verdicts::verdicts(&all)));
        Ok(())
    }

    /// Solves and measures one scene with one engine, from coarse to fine until the limit.
    fn measure(
        &self,
        scene: &str,
        path: &Path,
        engine: &str,
        reference: &Reference,
        all: &mut Vec<Point>,
    ) -> Result<(), Error> {
        let names: Vec<&str> = SCENES.iter().map(|s| s.name).collect();
        let tolerances = match self.tolerances.as_slice() {
            [] if self.quick => &QUICK_TOLERANCES,
            [] => TOLERANCES.as_slice(),
            given => given,
        };
        for &tolerance in tolerances {
            let empty = Point {
                scene: scene.into(),
                engine: engine.into(),
                tolerance,
                status: PointStatus::Measured,
                zones: reference.zone_count,
                used: String::new(),
                reason: String::new(),
                cost: Cost::default(),
                estimate: [0.0; 2],
                measured: Measurement::default(),
            };
            let (run, text) = (path.with_extension("npz"), tolerance.to_string());
            let arguments = ["--engine", engine, "--tolerance", &text, "--discretization-error", "false"];
            let arguments = [&arguments[..], &["--max-memory", "8"]].concat();
            let point = match self.command.solve(path, &run, &arguments, self.limit) {
                Err(e) => Point { status: PointStatus::Refused, reason: e.to_string(), ..empty },
                Ok(None) => {
                    let cost = Cost { wall: self.limit, processor: self.limit, memory: 0.0 };
                    Point { status: PointStatus::Limit, cost, ..empty }
                }
                Ok(Some((report, cost))) => measured(Point { cost, ..empty }, &run, &report, reference)?,
            };
            println!("{}  {}", page::row(&point).join("  "), point.reason);
            let ends = point.status != PointStatus::Measured || point.cost.processor > self.limit;
            points::put(all, point);
            points::write(&self.csv, all, &names)?;
            if ends {
                break;
            }
        }
        Ok(())
    }
}

fn measured(empty: Point, run: &Path, report: &Value, reference: &Reference) -> Result<Point, Error> {
    let solution = output::read_solution(run)?;
    let word = |name: &str| report[name].as_str().unwrap_or_default().to_string();
    // An unknown error is no number in JSON.
    let largest = |name: &str| {
        let bands = report["estimate"][name].as_array().into_iter().flatten();
        bands.map(|x| x.as_f64().unwrap_or(f64::INFINITY)).fold(0.0, f64::max)
    };
    Ok(Point {
        zones: solution.zones.len(),
        measured: measure(&solution, reference)?,
        used: word("engine"),
        reason: word("reason"),
        estimate: [largest("patches"), largest("volumes")],
        ..empty
    })
}
