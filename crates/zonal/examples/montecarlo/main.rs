//! Compares solves of the Monte Carlo cases with their tables and writes `docs/montecarlo.md`.
//!
//! ```text
//! montecarlo [--cases c0,c9] [--sizes 10,20] [--reference FOLDER] [-o docs/montecarlo.md]
//! montecarlo --engine hierarchical|spectral [--tolerances 0.03,0.01] [--cases c0,c8,c9] [--sizes 40] [--pictures FOLDER]
//!            [--thick-zones constant|linear]
//! ```
//!
//! Our zones are averaged down to the tables' 10×10 patches a wall and 10³ voxels, and compared with `*_sym` where it exists. The page,
//! by the dense engine, has the root mean square and the largest of the relative difference over all entries above zero. With
//! `--engine hierarchical` a table is printed of L2 (RMS of the difference over RMS of the table) and pointwise errors (RMS of the
//! relative difference over entries above a tenth of the mean), with what the solve took. `--pictures` draws c0 and c8 from the camera
//! of `image_*`, writes them as EXR into the folder and compares: sqrt(mean d² − mean σ²) over the mean, σ the reference's standard error.

#[path = "../common/process.rs"]
mod process;

use process::Process;
use std::path::{Path, PathBuf};
use std::time::Instant;
use zonal::commands::validate::montecarlo::cubes::{CUBES, Cube};
use zonal::commands::validate::montecarlo::{Compared, Difference, pictures};
use zonal::io::{input, output};
use zonal::scene::{Quiet, Scene, Solution};

/// Any error, in a sentence.
type Any = Box<dyn std::error::Error>;

const MEMORY: u64 = 16 << 30;

const PAGE: &str = "# Against Monte Carlo\n\nWritten by `cargo run --release --example montecarlo`. RMS and largest relative difference of irradiance H and fluence G\nfrom the tables, our zones averaged down to theirs; `s.e.` is the tables' own RMS standard error. Dense engine, closure as measured.\n\n| case | n³ | zones | H rms | H max | G rms | G max | block H rms | block H max | s.e. H | s.e. G | closure rms |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
const TABLE: &str = "| case | n³ | tolerance | zones | processor s | links, rays a zone | H L2 | H pointwise | G L2 | G pointwise | block L2 | block pointwise | estimated H, G | s.e. H, G |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";

fn percent(x: f64) -> String {
    format!("{:.2} %", 100.0 * x)
}

/// A line of the page.
fn page_line(d: &Compared, c: &Cube, n: usize, s: &Solution) -> String {
    let on_block = d.block.as_ref().map_or("– | –".into(), |b| both(b.all));
    format!(
        "| {} | {n} | {} | {} | {} | {on_block} | {} | {} | {:.1e} |\n",
        c.name,
        s.zones.len(),
        both(d.h.all),
        both(d.g.all),
        percent(d.h.noise),
        percent(d.g.noise),
        s.report.closure.rms[0]
    )
}

/// A line of the table of errors and costs.
fn line(d: &Compared, c: &Cube, n: usize, tolerance: f64, s: &Solution, seconds: f64) -> String {
    let zones = s.zones.len();
    let count = |names: &[&str]| {
        let all = s.report.counts.iter().filter(|c| names.contains(&c.0.as_str()));
        all.fold(0.0, |sum, c| sum + c.1 as f64) / zones as f64
    };
    let errors = |e: &Difference| both((e.l2, e.pointwise));
    format!(
        "| {} | {n} | {tolerance} | {zones} | {seconds:.1} | {:.1}, {:.0} | {} | {} | {} | {}, {} | {}, {} |\n",
        c.name,
        count(&["links, each direction"]),
        count(&["rays of views", "rays between clusters"]),
        errors(&d.h),
        errors(&d.g),
        d.block.as_ref().map_or("– | –".into(), errors),
        percent(s.report.estimate.patches[0]),
        percent(s.report.estimate.volumes[0]),
        percent(d.h.noise),
        percent(d.g.noise)
    )
}

fn both((a, b): (f64, f64)) -> String {
    format!("{} | {}", percent(a), percent(b))
}

/// The scene of a cube; an extinction that varies lies in a file while it is read.
fn scene(c: &Cube, n: usize, solve: &str, folder: &Path) -> Result<Scene, Any> {
    let base = std::env::temp_dir();
    if !c.varies() {
        return Ok(input::parse_scene(&c.text(n, solve, ""), Some(&base), c.name)?);
    }
    let density = base.join(format!("zonal-montecarlo-{}-{}.npy", c.name, std::process::id()));
    let (shape, values) = c.extinction(folder)?;
    output::write_array(&density, &shape, &values)?;
    let scene = input::parse_scene(&c.text(n, solve, &density.display().to_string()), Some(&base), c.name);
    std::fs::remove_file(&density)?;
    Ok(scene?)
}

/// Draws, writes `NAME.exr` and `NAME.png`, and says how the picture compares.
fn picture(s: &Solution, c: &Cube, folder: &Path, (out, name): (&Path, &str)) -> Result<String, Any> {
    let p = pictures::compare(s, c.file, folder, &Quiet)?;
    output::write_exr(&out.join(format!("{name}.exr")), p.image.width, p.image.height, &p.image.pixels)?;
    p.write(&out.join(format!("{name}.png")))?;
    Ok(format!(
        "  picture: sqrt(mean d² − mean σ²) = {:.2} % of the mean (σ: {:.2} %), mean {:+.2} %, blocks of 8×8: {:.2} % RMS",
        100.0 * p.difference,
        100.0 * p.noise,
        100.0 * p.mean,
        100.0 * p.blocks
    ))
}

fn main() -> Result<(), Any> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let option =
        |name: &str| arguments.iter().position(|a| a == name).and_then(|k| arguments.get(k + 1).cloned());
    let reference = PathBuf::from(option("--reference").unwrap_or("../shared/reference/montecarlo".into()));
    let chosen = option("--cases");
    let engine = option("--engine").unwrap_or("dense".into());
    let dense = engine == "dense";
    let sizes = option("--sizes").unwrap_or(if dense { "10,20" } else { "40" }.into());
    let sizes: Vec<usize> = sizes.split(',').map(str::parse).collect::<Result<_, _>>()?;
    let tolerances = option("--tolerances").unwrap_or("0.01".into());
    let tolerances: Vec<f64> = tolerances.split(',').map(str::parse).collect::<Result<_, _>>()?;
    let thick = option("--thick-zones").unwrap_or("auto".into());
    let pictures = option("--pictures").map(PathBuf::from);
    let mut page = if dense { PAGE } else { TABLE }.to_string();
    print!("{page}");
    for c in CUBES.iter().filter(|c| chosen.as_ref().is_none_or(|l| l.split(',').any(|n| n == c.name))) {
        for (&n, &tolerance) in sizes.iter().flat_map(|n| tolerances.iter().map(move |t| (n, t))) {
            let residual = if dense { "residual = 1e-12\n" } else { "" };
            let solve = format!(
                "{residual}engine = \"{engine}\"\ntolerance = {tolerance}\nthick_zones = \"{thick}\""
            );
            let scene = scene(c, n, &solve, &reference)?;
            let (start, before) = (Instant::now(), Process::new("self").seconds());
            let s = zonal::solve::solve(scene, MEMORY, &Quiet)?;
            let used = before.zip(Process::new("self").seconds()).map(|(a, b)| b - a);
            let seconds = used.unwrap_or(start.elapsed().as_secs_f64());
            let compared = Compared::new(&s, c, &reference)?;
            let line = if dense {
                page_line(&compared, c, n, &s)
            } else {
                line(&compared, c, n, tolerance, &s, seconds)
            };
            print!("{line}");
            page.push_str(&line);
            if let Some(folder) = pictures.as_ref().filter(|_| c.picture) {
                let name = format!("image_{}_{n}_{tolerance}", c.name);
                println!("{}", picture(&s, c, &reference, (folder, &name))?);
            }
        }
    }
    if let Some(out) = option("-o") {
        output::write_bytes(Path::new(&out), page.as_bytes())?;
    }
    Ok(())
}
