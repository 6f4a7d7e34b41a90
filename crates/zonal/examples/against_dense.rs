//! Compares the hierarchical engine with the dense one on the same zones.
//!
//! `cargo run --release --example against_dense -- c0|c8|c9|demo|SCENE.toml [--size 10] [--tolerances 0.1,0.03,0.01]`
//!
//! Printed for each tolerance: time, links and rays a zone, and for patches (H), voxel zones (G) and panes the L2 error (RMS of the
//! difference over RMS of the dense solution), what the engine estimates it to be, the pointwise error (RMS of the relative difference
//! over zones above a tenth of the mean), the median of estimate over error, and the share of zones within twice their own estimate.
//! c8 reads its density from `../shared/reference`.

use std::ops::Range;
use std::path::Path;
use std::time::Instant;
use zonal::io::{input, output};
use zonal::scene::{Engine, Fields, Groups, Quiet, Report, Scene, Zones};
use zonal::solve::pipeline::{Job, solve_zones};
use zonal::transport::{Transport, build_zones};

const MEMORY: u64 = 12 << 30;
const DENSITY: &str = "../shared/reference/montecarlo/c8_het_a0.90_r0.5.npz";
const BLOCK: &str =
    "[[surface]]\nname = \"block\"\nbox = { min = [0.4,0.3,0.2], max = [0.7,0.6,0.6] }\nreflectance = 0.5\n";

fn room(n: usize, kappa: f64, albedo: f64, extra: &str) -> String {
    format!(
        "name = \"room\"\n[solve]\npatch_size = {}\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\nreflectance = 0.5\nfaces.x0 = {{ emission = 1 }}\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [{n},{n},{n}]\nextinction = {kappa}\nalbedo = {albedo}\n{extra}",
        1.0 / n as f64
    )
}

fn scene(name: &str, n: usize) -> Result<Scene, Box<dyn std::error::Error>> {
    let text = match name {
        "c0" => room(n, 1.0, 0.9, ""),
        "c9" => room(n, 1.0, 0.5, BLOCK),
        "c8" => {
            let file = std::env::temp_dir().join(format!("zonal-c8-{}.npy", std::process::id()));
            let (shape, values) = output::read_array(Path::new(DENSITY), "sigma_t")?;
            output::write_array(&file, &shape, &values)?;
            let place = format!(
                "[[medium.region]]\ndensity = {{ file = {:?}, min = [0,0,0], max = [1,1,1], scale = 1.0 }}\nalbedo = 0.9\n",
                file.display().to_string()
            );
            let scene = input::parse_scene(&room(n, 0.0, 0.9, &place), Some(&std::env::temp_dir()), name);
            std::fs::remove_file(&file)?;
            return Ok(scene?);
        }
        "demo" => {
            include_str!("../src/demo/chapel.toml.in").replace("PATCH", "0.9").replace("CELLS", "[7, 12, 5]")
        }
        file => return Ok(input::read_scene(Path::new(file))?),
    };
    Ok(input::parse_scene(&text, None, name)?)
}

fn solved(
    scene: &Scene,
    engine: Engine,
    tolerance: f64,
) -> Result<(Fields, Report, Zones, f64), Box<dyn std::error::Error>> {
    let mut options = scene.options().clone();
    (options.engine, options.tolerance, options.groups) = (engine, tolerance, Groups::All);
    let scene = scene.clone().with_options(options)?;
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport)?;
    let start = Instant::now();
    let (fields, _, report) = solve_zones(&scene, &zones, &transport, &Job::new(MEMORY, &Quiet))?;
    Ok((fields, report, zones, start.elapsed().as_secs_f64()))
}

fn compare(name: &str, range: Range<usize>, ours: &Fields, dense: &Fields, estimate: f64) {
    if range.is_empty() {
        return;
    }
    let (h, t) = (|i: usize| ours.incident[i][0], |i: usize| dense.incident[i][0]);
    let n = range.len() as f64;
    let mean = range.clone().map(t).sum::<f64>() / n;
    let squares = |f: &dyn Fn(usize) -> f64| range.clone().map(|i| f(i) * f(i)).sum::<f64>();
    let l2 = (squares(&|i| h(i) - t(i)) / squares(&t)).sqrt();
    let lit: Vec<usize> = range.clone().filter(|&i| t(i) > 0.1 * mean).collect();
    let pointwise =
        (lit.iter().map(|&i| (h(i) / t(i) - 1.0).powi(2)).sum::<f64>() / lit.len().max(1) as f64).sqrt();
    let mut ratio: Vec<f64> =
        range.clone().map(|i| ours.error[i][0] / (h(i) - t(i)).abs().max(1e-300)).collect();
    ratio.sort_by(f64::total_cmp);
    let within = ratio.iter().filter(|r| **r >= 0.5).count() as f64 / n;
    println!(
        "    {name}: L2 {:.3} % (estimated {:.3} %), pointwise {:.3} %; estimate/error {:.1} in the median, {:.1} % within twice",
        100.0 * l2,
        100.0 * estimate,
        100.0 * pointwise,
        ratio[ratio.len() / 2],
        100.0 * within
    );
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let option = |name: &str| arguments.iter().position(|a| a == name).and_then(|k| arguments.get(k + 1));
    let name = arguments.first().ok_or("give c0, c8, c9, demo or a scene file")?;
    let size: usize = option("--size").map_or(Ok(10), |s| s.parse())?;
    let tolerances = option("--tolerances").map_or("0.1,0.03,0.01", |s| s.as_str());
    let scene = scene(name, size)?;
    let (dense, _, zones, seconds) = solved(&scene, Engine::Dense, 0.01)?;
    let (patches, panes) = (zones.voxel_offset(), zones.pane_offset());
    println!(
        "{name}: {} patches, {} voxel zones, {} panes; dense {seconds:.2} s",
        patches,
        panes - patches,
        zones.panes.len()
    );
    for tolerance in tolerances.split(',') {
        let (ours, report, _, seconds) = solved(&scene, Engine::Hierarchical, tolerance.parse()?)?;
        let count = |key: &str| report.counts.iter().find(|c| c.0 == key).map_or(0, |c| c.1) as f64;
        println!(
            "  tolerance {tolerance}: {seconds:.2} s, {:.1} links and {:.1} rays a zone, energy off by {:.1e}",
            count("links, each direction") / zones.len() as f64,
            count("rays between clusters") / zones.len() as f64,
            report.energy.residual[0]
        );
        compare("H", 0..patches, &ours, &dense, report.estimate.patches[0]);
        compare("G", patches..panes, &ours, &dense, report.estimate.volumes[0]);
        compare("G in panes", panes..zones.len(), &ours, &dense, report.estimate.volumes[0]);
    }
    Ok(())
}
