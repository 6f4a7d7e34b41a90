//! Compares solves of the Monte Carlo cases with their tables and writes `docs/montecarlo.md`.
//!
//! ```text
//! montecarlo [--cases c0,c9] [--sizes 10,20] [--reference FOLDER] [-o docs/montecarlo.md]
//! montecarlo --engine rays|spectral [--command target/release/zonal] [--tolerances 0.03,0.01] [--cases c0,c8,c9] [--sizes 40]
//!            [--zone-basis constant|linear] [--pictures FOLDER]
//! ```
//!
//! Our zones are averaged down to the tables' 10×10 patches a wall and 10³ voxels, and compared with `*_sym` where it exists. The page,
//! by the dense engine, has the root mean square and the largest of the relative difference over all entries above zero; sections that
//! follow its table stay. With `--engine rays` or `spectral` a table is printed of L2 (RMS of the difference over RMS of the table)
//! and pointwise errors (RMS of the relative difference over entries above a tenth of the mean), with the processor time of the solve; with
//! `--command` the solve is a process of its own, and the time all of its: reading, solving, writing. `--pictures` draws c0 and c8 from the
//! camera of `image_*`, writes them as EXR into the folder and compares: sqrt(mean d² − mean σ²) over the mean, σ the reference's standard
//! error.

#[path = "../common/command.rs"]
mod command;

use command::watch::process::Process;
use std::path::{Path, PathBuf};
use std::time::Instant;
use zonal_io::{input, output};
use zonal_scene::{NoProgress, Solution};
use zonal_validation::validate::comparisons::montecarlo::cubes::{CUBES, MonteCarloCube};
use zonal_validation::validate::comparisons::montecarlo::pictures::{self, PictureComparison};
use zonal_validation::validate::comparisons::montecarlo::{TableComparison, TableDifference};

const MAX_MEMORY: u64 = 16 << 30;

const PAGE_HEAD: &str = "# Against Monte Carlo\n\nWritten by `cargo run --release --example montecarlo`. RMS and largest relative difference of irradiance H and fluence G\nfrom the tables, our zones averaged down to theirs; `s.e.` is the tables' own RMS standard error. Dense engine, closure as measured.\n\n| case | n³ | zones | H rms | H max | G rms | G max | block H rms | block H max | s.e. H | s.e. G | closure rms |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
const TABLE_HEAD: &str = "| case | n³ | tolerance | zones | processor s | samples, rays a zone | H L2 | H pointwise | G L2 | G pointwise | block L2 | block pointwise | estimated H, G | s.e. H, G |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";

fn percent(x: f64) -> String {
    format!("{:.2} %", 100.0 * x)
}

/// A line of the page.
fn page_line(d: &TableComparison, c: &MonteCarloCube, n: usize, s: &Solution) -> String {
    let on_block = d.block.as_ref().map_or("– | –".into(), |b| both(b.all));
    format!(
        "| {} | {n} | {} | {} | {} | {on_block} | {} | {} | {:.1e} |\n",
        c.name,
        s.zones.len(),
        both(d.h.all),
        both(d.g.all),
        percent(d.h.noise),
        percent(d.g.noise),
        s.report.closure.rms.first()
    )
}

/// A line of the table of errors and costs.
fn line(
    d: &TableComparison,
    c: &MonteCarloCube,
    n: usize,
    tolerance: f64,
    s: &Solution,
    seconds: f64,
) -> String {
    let zones = s.zones.len();
    let count = |names: &[&str]| {
        let all = s.report.counts.iter().filter(|c| names.contains(&c.0.as_str()));
        all.fold(0.0, |sum, c| sum + c.1 as f64) / zones as f64
    };
    let errors = |e: &TableDifference| both((e.l2, e.pointwise));
    format!(
        "| {} | {n} | {tolerance} | {zones} | {seconds:.2} | {:.1}, {:.0} | {} | {} | {} | {}, {} | {}, {} |\n",
        c.name,
        count(&["samples of the final gather"]),
        count(&["transport_rays"]),
        errors(&d.h),
        errors(&d.g),
        d.block.as_ref().map_or("– | –".into(), errors),
        percent(s.report.estimate.patches.first()),
        percent(s.report.estimate.volumes.first()),
        percent(d.h.noise),
        percent(d.g.noise)
    )
}

fn both((a, b): (f64, f64)) -> String {
    format!("{} | {}", percent(a), percent(b))
}

/// The scene of a cube. With it the file that it reads, if any: the medium's densities, to be removed when the scene has been read.
fn written(
    c: &MonteCarloCube,
    n: usize,
    solve: &str,
    folder: &Path,
) -> Result<(String, Option<PathBuf>), Box<dyn std::error::Error>> {
    if !c.varies() {
        return Ok((c.text(n, solve, ""), None));
    }
    let density =
        std::env::temp_dir().join(format!("zonal-montecarlo-{}-{}.npy", c.name, std::process::id()));
    let (shape, values) = c.extinction(folder)?;
    output::write_array(&density, &shape, &values)?;
    Ok((c.text(n, solve, &density.display().to_string()), Some(density)))
}

/// Draws, writes `NAME.exr` and `NAME.png`, and returns its difference from the reference.
fn picture(
    s: &Solution,
    c: &MonteCarloCube,
    folder: &Path,
    (out, name): (&Path, &str),
) -> Result<String, Box<dyn std::error::Error>> {
    let p: PictureComparison = pictures::compare(s, c.file, folder, &NoProgress)?;
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

/// A solution and its processor time, s; the time that passed where no system tells.
fn here(text: &str, name: &str) -> Result<(Solution, f64), Box<dyn std::error::Error>> {
    let scene = input::parse_scene(text, Some(&std::env::temp_dir()), name)?;
    let (start, before) = (Instant::now(), Process::new("self").seconds());
    let s = zonal_solve::solve(scene, MAX_MEMORY, &NoProgress)?;
    let used = before.zip(Process::new("self").seconds()).map(|(a, b)| b - a);
    Ok((s, used.unwrap_or(start.elapsed().as_secs_f64())))
}

/// The same by the command, with all that its process took.
fn by_command(command: &Path, text: &str) -> Result<(Solution, f64), Box<dyn std::error::Error>> {
    let (_, [_, seconds, _], s) = command::solve(command, text, &[], |run| Ok(output::read_solution(run)?))?;
    Ok((s, seconds))
}

/// Solves a cube of n³ voxels with the lines `settings` of `[solve]`, in this process or by `command`: the solution and its seconds.
fn solve_cube(
    c: &MonteCarloCube,
    n: usize,
    settings: &str,
    folder: &Path,
    command: Option<&Path>,
) -> Result<(Solution, f64), Box<dyn std::error::Error>> {
    let (text, file) = written(c, n, settings, folder)?;
    let solved = match command {
        Some(command) => by_command(command, &text),
        None => here(&text, c.name),
    };
    file.map_or(Ok(()), std::fs::remove_file)?;
    solved
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
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
    let zone_basis = option("--zone-basis").unwrap_or("auto".into());
    let command = option("--command").map(PathBuf::from);
    let pictures = option("--pictures").map(PathBuf::from);
    let mut page = if dense { PAGE_HEAD } else { TABLE_HEAD }.to_string();
    print!("{page}");
    for c in CUBES.iter().filter(|c| chosen.as_ref().is_none_or(|l| l.split(',').any(|n| n == c.name))) {
        for (&n, &tolerance) in sizes.iter().flat_map(|n| tolerances.iter().map(move |t| (n, t))) {
            let residual = if dense { "residual = 1e-12\n" } else { "" };
            let solve = format!(
                "{residual}engine = \"{engine}\"\ntolerance = {tolerance}\nzone_basis = \"{zone_basis}\""
            );
            let (s, seconds) = solve_cube(c, n, &solve, &reference, command.as_deref())?;
            let compared = TableComparison::new(&s, c, &reference)?;
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
        let old = std::fs::read_to_string(&out).unwrap_or_default();
        page += old.find("\n## ").map_or("", |at| &old[at..]);
        output::write_bytes(Path::new(&out), page.as_bytes())?;
    }
    Ok(())
}
