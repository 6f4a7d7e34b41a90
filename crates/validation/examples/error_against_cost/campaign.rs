//! The sub-command `measure`: solves of the scenes with each engine from coarse to fine, each measured against the references.

use crate::arguments::Arguments;
use crate::measure::{Measurement, measure};
use crate::points::{self, Point, PointStatus};
use crate::reference::Reference;
use crate::scenes::{BenchmarkScene, Error, SCENES, SceneFolder};
use crate::solved::{ReportSummary, SolvedScene};
use crate::solving::SolveRequest;
use std::path::{Path, PathBuf};

/// The tolerances, from coarse to fine.
pub(crate) const TOLERANCES: [f64; 9] = [0.3, 0.2, 0.1, 0.05, 0.03, 0.02, 0.01, 0.005, 0.003];
/// The tolerances of `--quick`.
const QUICK_TOLERANCES: [f64; 3] = [0.3, 0.1, 0.05];
/// The engines.
const ENGINES: [&str; 3] = ["auto", "rays", "dense"];
/// Largest number of zones for the dense engine.
const MAX_DENSE_ZONES: usize = 8000;
/// Processor time of a solve after which a finer tolerance is not tried, s.
const DEFAULT_LIMIT: f64 = 60.0;

/// The references of a scene.
struct SceneReferences {
    /// The zonal equations.
    zonal: Reference,
    /// The equations of the rays engine, whose rays go on within patches.
    continued: Option<Reference>,
    /// Path-traced means.
    traced: Option<Reference>,
}

impl SceneReferences {
    /// The dense reference before that of walks; `None` where there is none.
    fn read(folder: &Path, scene: &str) -> Result<Option<SceneReferences>, Error> {
        let file = |method: &str| Some(Reference::file(folder, scene, method)).filter(|f| f.exists());
        let (dense, walks, continued) = (file("dense"), file("walks"), file("continued"));
        let Some(first) = dense.as_ref().or(walks.as_ref()) else { return Ok(None) };
        let [traced, continued] = [walks.as_ref(), continued.as_ref()].map(|f| f.map(|f| Reference::read(f)));
        Ok(Some(SceneReferences {
            zonal: Reference::read(first)?,
            continued: continued.transpose()?,
            traced: traced.transpose()?,
        }))
    }

    /// The reference with the equations of an engine.
    fn of_engine(&self, engine: &str) -> &Reference {
        self.continued.as_ref().filter(|_| engine == "rays").unwrap_or(&self.zonal)
    }
}

/// What is solved, and where its files are.
struct Campaign<'a> {
    arguments: &'a Arguments,
    references: PathBuf,
    folder: PathBuf,
    csv: PathBuf,
    limit: f64,
    tolerances: Vec<f64>,
    engines: Vec<&'a str>,
}

impl<'a> Campaign<'a> {
    fn new(arguments: &'a Arguments) -> Result<Campaign<'a>, Error> {
        let quick = arguments.flag("--quick");
        let tolerances = match arguments.list("--tolerances") {
            Some(list) => list
                .iter()
                .map(|t| t.parse().map_err(|_| format!("--tolerances: '{t}' is no number")))
                .collect::<Result<Vec<f64>, _>>()?,
            None if quick => QUICK_TOLERANCES.to_vec(),
            None => TOLERANCES.to_vec(),
        };
        let scratch = std::env::temp_dir().join(format!("zonal-error-against-cost-{}", std::process::id()));
        Ok(Campaign {
            references: arguments.text("--references").ok_or("give --references DIR")?.into(),
            folder: scratch,
            csv: arguments.text("--csv").unwrap_or(crate::DEFAULT_TABLE).into(),
            limit: arguments.number("--limit", DEFAULT_LIMIT)?,
            tolerances,
            engines: arguments.list("--engines").unwrap_or(ENGINES.to_vec()),
            arguments,
        })
    }

    /// Solves and measures one scene with one engine, from coarse to fine until the limit.
    fn series(
        &self,
        scene: &str,
        path: &Path,
        engine: &str,
        references: &SceneReferences,
        all: &mut Vec<Point>,
    ) -> Result<(), Error> {
        for &tolerance in &self.tolerances {
            let run = self.folder.join("run.npz");
            let request = SolveRequest {
                command: self.arguments.text("--zonal").map(Path::new),
                scene: path,
                run: &run,
                engine,
                tolerance,
                limit: self.limit,
            };
            let names: Vec<&str> = SCENES.iter().map(|s| s.name).collect();
            let empty = empty_point(scene, engine, tolerance, references.zonal.zone_count);
            let point = match request.run() {
                Err(e) => Point { status: PointStatus::Refused, reason: e.to_string(), ..empty },
                Ok(None) => {
                    Point { status: PointStatus::Limit, cost: [self.limit, self.limit, 0.0], ..empty }
                }
                Ok(Some((report, cost))) => measured(Point { cost, ..empty }, &run, report, references)?,
            };
            println!("{}", line(&point));
            let ends = point.status != PointStatus::Measured || point.seconds() > self.limit;
            points::put(all, point);
            points::write(&self.csv, all, &names)?;
            if ends {
                break;
            }
        }
        Ok(())
    }
}

fn empty_point(scene: &str, engine: &str, tolerance: f64, zones: usize) -> Point {
    Point {
        scene: scene.into(),
        engine: engine.into(),
        tolerance,
        status: PointStatus::Measured,
        zones,
        used: String::new(),
        reason: String::new(),
        cost: [0.0; 3],
        estimate: [0.0; 2],
        measured: Measurement::default(),
    }
}

fn measured(
    empty: Point,
    run: &Path,
    report: ReportSummary,
    references: &SceneReferences,
) -> Result<Point, Error> {
    let solved = SolvedScene::read(run)?;
    Ok(Point {
        zones: solved.places.len(),
        measured: measure(&solved, references.of_engine(&report.engine), references.traced.as_ref())?,
        used: report.engine,
        reason: report.reason,
        estimate: report.estimate,
        ..empty
    })
}

/// A point for people.
fn line(p: &Point) -> String {
    let head = format!("{:<15} {:<12} {:<6}", p.scene, p.engine, p.tolerance);
    if p.status != PointStatus::Measured {
        let what = if p.status == PointStatus::Limit { "ended at the limit" } else { "refused" };
        return format!("{head} {what} {}", p.reason);
    }
    let (m, e) = (&p.measured, p.error());
    let percent = |x: Option<f64>| x.map_or("–".into(), |x| format!("{:.0} %", 100.0 * x));
    format!(
        "{head} {:>7.2} s {:>6.0} MB  L2 {:.2} %{} (H {:.2}, G {:.2}; estimated {:.2}, {:.2}; noise {:.2})  total {}  est/err {}  within {} contacts {} relit {}  {}",
        p.seconds(),
        p.cost[2],
        100.0 * e.error,
        if e.is_noisy() { "*" } else { "" },
        100.0 * m.patches.error,
        100.0 * m.volumes.error,
        100.0 * p.estimate[0],
        100.0 * p.estimate[1],
        100.0 * e.noise,
        percent(m.total.map(|t| t.error)),
        m.ratio.map_or("–".into(), |x| format!("{x:.2}")),
        percent(m.within),
        percent(m.within_at_contacts),
        percent(m.within_relit),
        p.used
    )
}

/// Measures the scenes; the table keeps what is not measured again.
pub(crate) fn run(arguments: &Arguments, scenes: &[&'static BenchmarkScene]) -> Result<bool, Error> {
    let campaign = Campaign::new(arguments)?;
    let shared = Path::new(arguments.text("--shared").unwrap_or("../shared"));
    let mut all = points::read(&campaign.csv)?;
    for scene in scenes {
        let Some(references) = SceneReferences::read(&campaign.references, scene.name)? else {
            println!("{}: skipped, without a reference in {}", scene.name, campaign.references.display());
            continue;
        };
        let folder = SceneFolder { path: &campaign.folder, shared };
        let Some(path) = scene.write(&folder)? else {
            println!("{}: skipped, for {} is absent", scene.name, shared.display());
            continue;
        };
        for engine in &campaign.engines {
            if *engine == "dense" && references.zonal.zone_count > MAX_DENSE_ZONES {
                continue;
            }
            let outcome = campaign.series(scene.name, &path, engine, &references, &mut all);
            if let Err(e) = outcome {
                println!("{}: {engine}: {e}", scene.name);
            }
        }
    }
    std::fs::remove_dir_all(&campaign.folder)?;
    Ok(true)
}
