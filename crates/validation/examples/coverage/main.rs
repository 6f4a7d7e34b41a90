//! Random coverage: random valid scenes, each solved by every engine that applies and by the forward Monte Carlo reference; the program's stated
//! errors are compared with the true ones.
//!
//! ```text
//! coverage --random N --seed S [--walks 40000] [--index K] [--small yes] [--keep FOLDER] [--write FOLDER] [--page docs/coverage.md]
//!          [--command target/release/zonal] [--python PATH]
//! ```
//!
//! Sums by name (power absorbed, net power, temperature) are compared with the continuous problem: the stated error is that of the exchange
//! and of the zones' size. Zones are compared with the exact solution of the zonal equations on the same zones: the stated error is that of the
//! exchange. **Covered** means |difference| ≤ stated + 3σ of the reference, of zones 2 stated + 3σ. Each scene is solved once more in an equivalent form
//! (mirrored, turned, scaled …), by one of the engines; both solutions must agree within the errors that they state.
//!
//! A scene of which a sum by name is not covered, or a zone is far off, is walked again, ten times as often: among thousands of sums a few are four or more standard
//! errors off by chance, while true deviations become more significant.
//!
//! `--view-factors N` runs N random meshes through the view factors instead (`view_factors/mod.rs`).
//!
//! With `--command`, one scene in five is solved by that program as well, with `--python` by the Python package too: the bytes of both must be equal. One in five
//! becomes a mesh file, if it is one of surfaces alone, and goes through `zonal init`.
//!
//! `--keep` writes the scenes on which something fails, `--write` writes all and solves none (for another program), `--index` runs one scene, lists all of it and keeps it, `--small yes` makes scenes of few zones, each
//! for one engine. Exit code 1 where a verdict fails.
//!
//! Guards (numbers): in random scenes stated errors cover true errors, for every engine and under invariances of the scene; the reference is random
//!     walks.

mod entry_points;
mod generate;
mod invariance;
mod measure;
mod model;
mod ordinary_kinds;
mod page;
mod rare_kinds;
mod run;
mod stated;
mod summary;
mod view_factors;

use entry_points::EntryPoints;
use model::CampaignSize;
use run::{CampaignPlan, SceneResult};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use summary::CampaignSummary;

const USAGE: &str = "coverage --random N --seed S [--walks 40000] [--index K] [--small yes] [--keep FOLDER] [--write FOLDER] \
[--page FILE.md] [--command ZONAL] [--python PYTHON], or coverage --view-factors N --seed S [--tolerance T]... [--index K] [--page FILE.md]; \
described in crates/validation/examples/coverage/main.rs";

/// Factors of a campaign that are listed, at most.
const MAX_LISTED_FACTORS: usize = 100;
/// Meshes between two lines of progress.
const MESHES_PER_PROGRESS: u64 = 40;
/// Scenes between two lines of progress.
const SCENES_PER_PROGRESS: usize = 20;

struct CampaignOptions {
    plan: CampaignPlan,
    page: Option<PathBuf>,
    /// The folder of all scenes, none of which is solved.
    write: Option<PathBuf>,
    all: bool,
    /// Meshes of a campaign of view factors in place of scenes.
    meshes: Option<u64>,
    tolerances: Vec<f64>,
}

/// The path of a program that runs in other folders.
fn absolute(path: &str) -> Result<PathBuf, String> {
    std::path::absolute(path).map_err(|e| format!("{path}: {e}"))
}

fn options() -> Result<CampaignOptions, String> {
    let mut plan = CampaignPlan {
        scenes: (0..100).collect(),
        seed: 1,
        walks: 40_000,
        size: CampaignSize::Full,
        keep: None,
        entry_points: EntryPoints::default(),
    };
    let (mut page, mut write, mut all, mut meshes, mut tolerances) = (None, None, false, None, Vec::new());
    let mut args = std::env::args().skip(1);
    while let Some(key) = args.next() {
        if key == "--help" || key == "-h" {
            return Err(format!("usage: {USAGE}"));
        }
        let value = args.next().ok_or(format!("{key}: a value is missing"))?;
        let number = || value.parse::<u64>().map_err(|_| format!("{key}: '{value}' is no whole number"));
        match key.as_str() {
            "--random" => plan.scenes = (0..number()?).collect(),
            "--seed" => plan.seed = number()?,
            "--walks" => plan.walks = number()? as usize,
            "--index" => (plan.scenes, all) = (vec![number()?], true),
            "--small" => plan.size = if value == "yes" { CampaignSize::Small } else { CampaignSize::Full },
            "--keep" => plan.keep = Some(value.into()),
            "--view-factors" => meshes = Some(number()?),
            "--tolerance" => {
                let tolerance = value.parse::<f64>().ok().filter(|t| *t > 0.0 && *t < 1.0);
                tolerances.push(tolerance.ok_or(format!("--tolerance: '{value}' is not between 0 and 1"))?);
            }
            "--write" => write = Some(value.into()),
            "--command" => plan.entry_points.command = Some(absolute(&value)?),
            "--python" => plan.entry_points.python = Some(absolute(&value)?),
            "--page" => page = Some(value.into()),
            _ => return Err(format!("{key}: no such option; usage: {USAGE}")),
        }
    }
    Ok(CampaignOptions { plan, page, write, all, meshes, tolerances })
}

/// Failures of a scene, a line each.
fn complaints(d: &SceneResult) -> Vec<String> {
    let missed = d.missed().map(|q| {
        let (d, s) = (q.difference(), q.stated);
        format!(
            "scene {}, {}: {} = {:.6e} ± {s:.1e}, reference {:.6e}, σ {:.1e}, off by {d:.1e}{}",
            q.scene,
            q.engine,
            q.what,
            q.value,
            q.truth,
            q.sigma,
            if q.warned { " (warned)" } else { "" }
        )
    });
    let mut out: Vec<String> = missed.take(12).collect();
    let unknown: Vec<&measure::Quantity> = d.quantities.iter().filter(|q| q.is_unknown()).collect();
    if let Some(q) = unknown.first() {
        let more = unknown.len() - 1;
        out.push(format!("scene {}, {}: {} and {more} more are unknown", q.scene, q.engine, q.what));
    }
    out.extend(d.failures.iter().map(|f| format!("scene {}: {f}", d.index)));
    if let Some((name, o)) = &d.invariance {
        out.extend(o.failure.iter().map(|f| format!("scene {}, {name}: {f}", d.index)));
        for b in o.broken.iter().take(6) {
            let [x, y] = b.values;
            out.push(format!(
                "scene {}, {}, {}: {} = {x:.6e}, otherwise {y:.6e}, stated {:.1e}",
                b.scene, b.invariance, b.engine, b.what, b.stated
            ));
        }
    }
    out
}

/// Runs random meshes through the view factors.
fn view_factor_campaign(options: &CampaignOptions, meshes: u64) -> ExitCode {
    let tolerances = match options.tolerances.as_slice() {
        [] => view_factors::TOLERANCES.to_vec(),
        some => some.to_vec(),
    };
    let only = if options.all { options.plan.scenes.first().copied() } else { None };
    let campaign = view_factors::FactorCampaign { meshes, seed: options.plan.seed, tolerances, only };
    let mut checks = campaign.run(|count| {
        if (count as u64).is_multiple_of(MESHES_PER_PROGRESS) {
            eprintln!("progress: {count} of {meshes} meshes");
        }
    });
    checks.sort_by(|a, b| b.ratio().total_cmp(&a.ratio()));
    for c in checks.iter().filter(|c| options.all || c.ratio() > 1.0).take(MAX_LISTED_FACTORS) {
        eprintln!("{:.2} radii: {c}", c.ratio());
    }
    let summary = view_factors::Summary::new(&checks);
    let tables = summary.tables();
    print!("{tables}");
    if let Some(path) = &options.page
        && let Err(e) = std::fs::write(path, view_factors::page(&campaign, &tables))
    {
        eprintln!("error: {}: {e}", path.display());
        return ExitCode::from(2);
    }
    if summary.holds() { ExitCode::SUCCESS } else { ExitCode::from(1) }
}

fn main() -> ExitCode {
    let options = match options() {
        Ok(o) => o,
        Err(e) => {
            eprintln!("error: {e}");
            return ExitCode::from(2);
        }
    };
    if let Some(meshes) = options.meshes {
        return view_factor_campaign(&options, meshes);
    }
    if let Some(folder) = &options.write {
        return match run::write_scenes(&options.plan, folder) {
            Ok(()) => ExitCode::SUCCESS,
            Err(e) => {
                eprintln!("error: {}: {e}", folder.display());
                ExitCode::from(2)
            }
        };
    }
    let finished = AtomicUsize::new(0);
    let done = run::run(&options.plan, |d| {
        for line in complaints(d) {
            eprintln!("{line}");
        }
        let count = finished.fetch_add(1, Ordering::Relaxed) + 1;
        if count.is_multiple_of(SCENES_PER_PROGRESS) {
            eprintln!("progress: {count} of {} scenes", options.plan.scenes.len());
        }
    });
    if options.all {
        for q in done.iter().flat_map(|d| &d.quantities) {
            println!("{q:?}");
        }
    }
    let summary = CampaignSummary::new(&done);
    print!("{}", page::tables(&summary));
    if let Some(path) = &options.page
        && let Err(e) = page::write(path, &options.plan, &done, &summary)
    {
        eprintln!("error: {e}");
        return ExitCode::from(2);
    }
    if summary.verdicts().iter().all(|v| v.2) { ExitCode::SUCCESS } else { ExitCode::from(1) }
}
