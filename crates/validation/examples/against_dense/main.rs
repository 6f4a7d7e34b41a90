//! Compares the rays engine with the dense or the spectral one on the same zones.
//!
//! ```text
//! against_dense [c0|c8|c9|demo|cornell|randomSEED|SCENE.toml ...] [--size 10] [--tolerances 0.1,0.03,0.01] [--dense 0.01]
//!               [--reference dense|spectral] [--samples 4] [--worst 5] [--shared ../shared] [--csv docs/against_dense.csv] [--plot docs/against_dense.svg]
//! ```
//!
//! Printed for each tolerance: processor time, samples and rays per zone, and for patches (H), voxel zones (G) and panes the L2 error (RMS of
//! the difference over RMS of the dense solution), what the engine estimates it to be, the pointwise error (RMS of the relative
//! difference over zones above a tenth of the mean), the median of estimate over error, and the share of zones within twice their own
//! estimate; a band each where they differ. What misses its mark is named at the line's end. `--csv` puts the figures into a table, in the
//! place of older ones, and `--plot` draws the whole table, without scenes too. `--dense` is the dense engine's own tolerance: that of what
//! it samples, pairs that are seen in part. The reference is the mean of so many `--samples` of it, whose rays have nothing in common with
//! one another or with what is compared; their spread tells how well it is known itself. In a box on the grid of its medium
//! `--reference spectral` gives every exchange area to 1e-12 instead, for as many zones as memory holds. `--size` also sets the cells along
//! each edge of a scene file's medium. `--worst` lists so many zones of the largest
//! differences. c8 and cornell read from `../shared`.

#[path = "../common/process.rs"]
mod process;

mod figures;
mod random;
mod scenes;

use figures::{ComparisonRow, SolveCost};
use process::Process;
use std::path::{Path, PathBuf};
use std::time::Instant;
use zonal_exchange::pair::PairSettings;
use zonal_scene::{Band, Bands, Engine, Fields, LightGrouping, NoProgress, Report, Scene, ZoneBasis, Zones};
use zonal_solve::SolveSettings;
use zonal_solve::solve_zones;
use zonal_transport::{Transport, build_zones};

const MAX_MEMORY: u64 = 12 << 30;

/// A solved scene.
struct SolvedScene {
    fields: Fields,
    report: Report,
    zones: Zones,
    /// Processor time, s; the time that passed where no system tells.
    seconds: f64,
}

/// Solves with rays of one of the samples.
fn solved(
    scene: &Scene,
    engine: Engine,
    tolerance: f64,
    sample: u64,
) -> Result<SolvedScene, Box<dyn std::error::Error>> {
    let mut options = scene.options().clone();
    (options.engine, options.tolerance, options.light_grouping) = (engine, tolerance, LightGrouping::All);
    // As for samples and rays.
    options.zone_basis = ZoneBasis::Constant;
    let scene = scene.clone().with_options(options)?;
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport)?;
    let (start, before) = (Instant::now(), Process::new("self").seconds());
    let job = SolveSettings {
        pair_settings: PairSettings { sample, ..PairSettings::default() },
        ..SolveSettings::new(MAX_MEMORY, &NoProgress)
    };
    let (fields, _, report) = solve_zones(&scene, &zones, &transport, &job)?;
    let used = before.zip(Process::new("self").seconds()).map(|(a, b)| b - a);
    Ok(SolvedScene { fields, report, zones, seconds: used.unwrap_or(start.elapsed().as_secs_f64()) })
}

/// The mean of several samples of the reference engine, and the standard errors of H and G over their root mean squares.
fn reference(
    scene: &Scene,
    request: &ComparisonRequest,
) -> Result<(SolvedScene, [f64; 2]), Box<dyn std::error::Error>> {
    let mut all = Vec::new();
    for sample in 1..=request.samples {
        all.push(solved(scene, request.engine, request.reference, sample)?);
    }
    if all.len() == 1 {
        return Ok((all.swap_remove(0), [0.0; 2]));
    }
    let n = all.len() as f64;
    let count = all[0].zones.len();
    let mean: Vec<Bands> =
        (0..count).map(|i| all.iter().map(|s| s.fields.incident[i]).sum::<Bands>() / n).collect();
    let part = |range: std::ops::Range<usize>| {
        let (mut apart, mut whole) = (0.0, 0.0);
        for i in range {
            for b in Band::all() {
                whole += n * mean[i][b].powi(2);
                apart += all.iter().map(|s| (s.fields.incident[i][b] - mean[i][b]).powi(2)).sum::<f64>();
            }
        }
        if whole > 0.0 { (apart / whole / (n - 1.0)).sqrt() } else { 0.0 }
    };
    let first = all[0].zones.voxel_offset();
    let known = [part(0..first), part(first..count)];
    let mut out = all.swap_remove(0);
    out.fields.incident = mean;
    Ok((out, known))
}

/// Options of the comparison.
struct ComparisonRequest<'a> {
    tolerances: Vec<f64>,
    /// Reference: engine, tolerance and number of samples.
    engine: Engine,
    reference: f64,
    samples: u64,
    /// Number of worst zones listed.
    worst: usize,
    csv: Option<&'a Path>,
}

/// Compares one scene at all tolerances.
fn compare(name: &str, scene: &Scene, request: &ComparisonRequest) -> Result<(), Box<dyn std::error::Error>> {
    let (SolvedScene { fields: dense, report: own, zones, seconds }, known) = reference(scene, request)?;
    let (patches, panes) = (zones.voxel_offset(), zones.pane_offset());
    println!(
        "{name}: {} patches, {} voxel zones, {} panes; {:?} {seconds:.2} s, its own estimate {:.3} % of H, {:.3} % of G; known to {:.3} and {:.3} %",
        patches,
        panes - patches,
        zones.panes.len(),
        request.engine,
        100.0 * own.estimate.patches.into_iter().fold(0.0, f64::max),
        100.0 * own.estimate.volumes.into_iter().fold(0.0, f64::max),
        100.0 * known[0],
        100.0 * known[1]
    );
    for &tolerance in &request.tolerances {
        let SolvedScene { fields: ours, report, seconds, .. } = solved(scene, Engine::Rays, tolerance, 0)?;
        let cost = SolveCost::new(&report, zones.len(), seconds);
        println!(
            "  tolerance {tolerance}: {seconds:.2} s, {:.1} samples and {:.1} rays a zone, energy off by {:.1e}{}",
            cost.samples,
            cost.rays,
            report.energy.residual.first(),
            if cost.met { "" } else { "; the estimate does not meet it" }
        );
        let parts = [
            ("H", 0..patches, report.estimate.patches),
            ("G", patches..panes, report.estimate.volumes),
            ("G pane", panes..zones.len(), report.estimate.volumes),
        ];
        let mut records = String::new();
        for row in
            parts.into_iter().flat_map(|(q, range, of)| ComparisonRow::all(q, range, &ours, &dense, of))
        {
            println!("{}", row.line(tolerance));
            records += &row.record(name, tolerance, &cost);
        }
        figures::list_worst(scene, &zones, &ours, &dense, request.worst);
        if let Some(file) = request.csv {
            figures::write(file, &figures::merged(file, name, tolerance, &records)?)?;
        }
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let option = |name: &str| arguments.iter().position(|a| a == name).and_then(|k| arguments.get(k + 1));
    // Every option has a value.
    let named =
        |k: &usize| !arguments[*k].starts_with("--") && (*k == 0 || !arguments[k - 1].starts_with("--"));
    let names: Vec<&String> = (0..arguments.len()).filter(named).map(|k| &arguments[k]).collect();
    let size = option("--size").map(|s| s.parse()).transpose()?;
    let tolerances = option("--tolerances").map_or("0.1,0.03,0.01", |s| s.as_str());
    let (csv, plot) = (option("--csv").map(Path::new), option("--plot").map(Path::new));
    let spectral = match option("--reference").map_or("dense", |e| e.as_str()) {
        "dense" => false,
        "spectral" => true,
        other => return Err(format!("--reference {other}: give dense or spectral").into()),
    };
    let request = ComparisonRequest {
        tolerances: tolerances.split(',').map(str::parse).collect::<Result<_, _>>()?,
        engine: if spectral { Engine::Spectral } else { Engine::Dense },
        reference: option("--dense").map_or("0.01", |s| s.as_str()).parse()?,
        // Transforms have no rays, and no second opinion.
        samples: if spectral {
            1
        } else {
            option("--samples").map_or("4", |s| s.as_str()).parse::<u64>()?.max(1)
        },
        worst: option("--worst").map_or("0", |s| s.as_str()).parse()?,
        csv,
    };
    let shared = PathBuf::from(option("--shared").map_or("../shared", |s| s.as_str()));
    let shared = std::fs::canonicalize(&shared).unwrap_or(shared);
    if names.is_empty() && plot.is_none() {
        return Err("give c0, c8, c9, demo, cornell, random1, a scene file, or --csv FILE --plot FILE".into());
    }
    for name in names {
        compare(name, &scenes::scene(name, size, &shared)?, &request)?;
    }
    if let Some(plot) = plot {
        figures::draw(csv.ok_or("--plot draws a table: give --csv FILE too")?, plot)?;
    }
    Ok(())
}
