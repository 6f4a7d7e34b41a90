//! Compares solves of the Monte Carlo cases with their tables and writes `docs/montecarlo.md`.
//!
//! ```text
//! montecarlo [--cases c0,c9] [--sizes 10,20] [--reference FOLDER] [-o docs/montecarlo.md]
//! montecarlo --engine hierarchical|spectral [--command target/release/zonal] [--tolerances 0.03,0.01] [--cases c0,c8,c9] [--sizes 40]
//!            [--thick-zones constant|linear] [--pictures FOLDER]
//! ```
//!
//! Our zones are averaged down to the tables' 10×10 patches a wall and 10³ voxels, and compared with `*_sym` where it exists. The page,
//! by the dense engine, has the root mean square and the largest of the relative difference over all entries above zero; sections that
//! follow its table stay. With `--engine hierarchical` or `spectral` a table is printed of L2 (RMS of the difference over RMS of the table)
//! and pointwise errors (RMS of the relative difference over entries above a tenth of the mean), with the processor time of the solve; with
//! `--command` the solve is a process of its own, and the time all of its: reading, solving, writing. `--pictures` draws c0 and c8 from the
//! camera of `image_*`, writes them as EXR into the folder and compares: sqrt(mean d² − mean σ²) over the mean, σ the reference's standard
//! error.

#[path = "../common/command.rs"]
mod command;

mod binned;
mod cases;
mod pictures;

use cases::{Any, CASES, Case};
use command::watch::process::Process;
use std::path::{Path, PathBuf};
use std::time::Instant;
use zonal::io::{input, output};
use zonal::scene::{Quiet, Solution};

/// Entries below this share of the mean do not count into the pointwise error.
const DARK: f64 = 0.1;
const MEMORY: u64 = 16 << 30;

const PAGE: &str = "# Against Monte Carlo\n\nWritten by `cargo run --release --example montecarlo`. RMS and largest relative difference of irradiance H and fluence G\nfrom the tables, our zones averaged down to theirs; `s.e.` is the tables' own RMS standard error. Dense engine, closure as measured.\n\n| case | n³ | zones | H rms | H max | G rms | G max | block H rms | block H max | s.e. H | s.e. G | closure rms |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
const TABLE: &str = "| case | n³ | tolerance | zones | processor s | links, rays a zone | H L2 | H pointwise | G L2 | G pointwise | block L2 | block pointwise | estimated H, G | s.e. H, G |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (n, sum) = values.fold((0usize, 0.0), |(n, s), x| (n + 1, s + x * x));
    (sum / n.max(1) as f64).sqrt()
}

/// What a field says beside its table.
#[derive(Default)]
struct Difference {
    /// RMS of the difference over RMS of the table.
    l2: f64,
    /// RMS of the relative difference over entries above a tenth of the mean.
    pointwise: f64,
    /// RMS and largest modulus of the relative difference over all entries above zero.
    all: (f64, f64),
    /// The table's own RMS relative standard error.
    noise: f64,
}

impl Difference {
    fn new(ours: &[f64], (table, errors): &(Vec<f64>, Vec<f64>)) -> Difference {
        let mean = table.iter().sum::<f64>() / table.len() as f64;
        let pairs = || ours.iter().zip(table).map(|(o, t)| (o - t, *t));
        let above = |least: f64| pairs().filter(move |p| p.1 > least).map(|(d, t)| d / t);
        let relative = errors.iter().zip(table).filter(|p| *p.1 > 0.0).map(|(e, t)| e / t);
        Difference {
            l2: rms(pairs().map(|p| p.0)) / rms(table.iter().copied()),
            pointwise: rms(above(DARK * mean)),
            all: (rms(above(0.0)), above(0.0).fold(0.0, |m, x| m.max(x.abs()))),
            noise: rms(relative),
        }
    }
}

fn percent(x: f64) -> String {
    format!("{:.2} %", 100.0 * x)
}

/// A solve beside its tables.
struct Compared {
    h: Difference,
    g: Difference,
    block: Option<Difference>,
}

impl Compared {
    fn new(s: &Solution, c: &Case, folder: &Path) -> Result<Compared, Any> {
        let (walls, block, gas) = binned::averaged(s);
        let of = |ours: &[f64], q: &str| Ok::<_, Any>(Difference::new(ours, &c.read(folder, q)?));
        Ok(Compared {
            h: of(&walls, "H")?,
            g: of(&gas, "G")?,
            block: if c.block { Some(of(&block, "Hocc")?) } else { None },
        })
    }

    /// A line of the page.
    fn page(&self, c: &Case, n: usize, s: &Solution) -> String {
        let on_block = self.block.as_ref().map_or("– | –".into(), |b| both(b.all));
        format!(
            "| {} | {n} | {} | {} | {} | {on_block} | {} | {} | {:.1e} |\n",
            c.name,
            s.zones.len(),
            both(self.h.all),
            both(self.g.all),
            percent(self.h.noise),
            percent(self.g.noise),
            s.report.closure.rms[0]
        )
    }

    /// A line of the table of errors and costs.
    fn line(&self, c: &Case, n: usize, tolerance: f64, s: &Solution, seconds: f64) -> String {
        let zones = s.zones.len();
        let count = |names: &[&str]| {
            let all = s.report.counts.iter().filter(|c| names.contains(&c.0.as_str()));
            all.fold(0.0, |sum, c| sum + c.1 as f64) / zones as f64
        };
        let errors = |d: &Difference| both((d.l2, d.pointwise));
        format!(
            "| {} | {n} | {tolerance} | {zones} | {seconds:.2} | {:.1}, {:.0} | {} | {} | {} | {}, {} | {}, {} |\n",
            c.name,
            count(&["links, each direction"]),
            count(&["rays of views", "rays between clusters"]),
            errors(&self.h),
            errors(&self.g),
            self.block.as_ref().map_or("– | –".into(), errors),
            percent(s.report.estimate.patches[0]),
            percent(s.report.estimate.volumes[0]),
            percent(self.h.noise),
            percent(self.g.noise)
        )
    }
}

fn both((a, b): (f64, f64)) -> String {
    format!("{} | {}", percent(a), percent(b))
}

/// A solution and its processor time, s; the time that passed where no system tells.
fn here(text: &str, name: &str) -> Result<(Solution, f64), Any> {
    let scene = input::parse_scene(text, Some(&std::env::temp_dir()), name)?;
    let (start, before) = (Instant::now(), Process::new("self").seconds());
    let s = zonal::solve::solve(scene, MEMORY, &Quiet)?;
    let used = before.zip(Process::new("self").seconds()).map(|(a, b)| b - a);
    Ok((s, used.unwrap_or(start.elapsed().as_secs_f64())))
}

/// The same by the command, with all that its process took.
fn by_command(command: &Path, text: &str) -> Result<(Solution, f64), Any> {
    let (_, [_, seconds, _], s) = command::solve(command, text, &[], |run| Ok(output::read_solution(run)?))?;
    Ok((s, seconds))
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
    let command = option("--command").map(PathBuf::from);
    let pictures = option("--pictures").map(PathBuf::from);
    let mut page = if dense { PAGE } else { TABLE }.to_string();
    print!("{page}");
    for c in CASES.iter().filter(|c| chosen.as_ref().is_none_or(|l| l.split(',').any(|n| n == c.name))) {
        for (&n, &tolerance) in sizes.iter().flat_map(|n| tolerances.iter().map(move |t| (n, t))) {
            let residual = if dense { "residual = 1e-12\n" } else { "" };
            let solve = format!(
                "{residual}engine = \"{engine}\"\ntolerance = {tolerance}\nthick_zones = \"{thick}\""
            );
            let (text, file) = c.written(n, &solve, &reference)?;
            let solved = match &command {
                Some(command) => by_command(command, &text),
                None => here(&text, c.name),
            };
            file.map_or(Ok(()), std::fs::remove_file)?;
            let (s, seconds) = solved?;
            let compared = Compared::new(&s, c, &reference)?;
            let line =
                if dense { compared.page(c, n, &s) } else { compared.line(c, n, tolerance, &s, seconds) };
            print!("{line}");
            page.push_str(&line);
            if let Some(folder) = pictures.as_ref().filter(|_| c.picture) {
                let name = format!("image_{}_{n}_{tolerance}", c.name);
                println!("{}", pictures::compare(&s, c.file, &reference, (folder, &name))?);
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
