//! The benchmark of error against cost: furnished and difficult scenes, each solved with each engine from coarse to fine tolerances.
//!
//! ```text
//! error_against_cost scenes DIR
//! error_against_cost references --references DIR [--method walks|continued|dense] [--patches 200] [--voxels 200] [--error 0.01] [--max-paths N]
//!                    [--samples 4] [--tolerance 0.003] [--seed 1] [--groups NAME,…]
//! error_against_cost measure --references DIR [--csv TABLE.csv] [--engines auto,rays,dense] [--tolerances 0.3,…] [--quick]
//!                    [--limit 60] [--zonal PATH]
//! error_against_cost page [--csv TABLE.csv] [--page docs/error-against-cost.md]
//! error_against_cost compare --csv TABLE.csv --compare OTHER.csv [--engines auto]
//! error_against_cost discretization --references DIR
//! ```
//!
//! `--scenes a,b` chooses scenes, `--slow` adds those that take long, `--shared` is the folder of data that are not part of the project.
//! Solves run in a process of their own (`solve`, as `zonal solve`), or of `--zonal PATH`, so that an older binary has the same references.
//!
//! `references` picks patches and volume zones at random and measures them by walks on zones, whose mean is the solution of the zonal
//! equations, for every light group (or for those of `--groups`), and by path tracing without zones (`walks`); by walks that go on from the points that they meet, as the rays of the
//! rays engine do (`continued`); or it solves by the dense engine several times. `measure` compares each engine with the reference of its equations,
//! the dense one before that of walks. The measured error is relative L2 of indirect light, of the worst band; the noise of the reference
//! is subtracted, and points where it is more than a third of the error have a star.

#[path = "../common/watch.rs"]
mod watch;
#[path = "../common/zone_sampling.rs"]
mod zone_sampling;

mod arguments;
mod campaign;
mod compare;
mod make_references;
mod measure;
mod page;
mod points;
mod reference;
mod scenes;
mod solved;
mod solving;
mod statistics;
mod verdicts;
mod zones;

use arguments::Arguments;
use points::Point;
use reference::Reference;
use scenes::{BenchmarkScene, Error, SCENES, SceneFolder};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The table where none is named.
const DEFAULT_TABLE: &str = "docs/error-against-cost.csv";

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(e) => {
            eprintln!("error_against_cost: {e}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<bool, Error> {
    let arguments = Arguments::new(std::env::args().skip(1).collect());
    match arguments.word(0) {
        Some("scenes") => write_scenes(&arguments),
        Some("solve") => solving::solve(&arguments),
        Some("references") => make_references::run(&arguments, &chosen(&arguments)?),
        Some("measure") => {
            Ok(campaign::run(&arguments, &chosen(&arguments)?)? && print_verdicts(&arguments)?)
        }
        Some("page") => write_page(&arguments),
        Some("compare") => print_comparison(&arguments),
        Some("discretization") => print_discretization(&arguments),
        _ => Err("give scenes, references, measure, page, compare or discretization".into()),
    }
}

/// The scenes that `--scenes` names, or all that are not slow; with `--slow` all.
fn chosen(arguments: &Arguments) -> Result<Vec<&'static BenchmarkScene>, Error> {
    match arguments.list("--scenes") {
        Some(names) => names.into_iter().map(BenchmarkScene::named).collect(),
        None => Ok(SCENES.iter().filter(|s| !s.slow || arguments.flag("--slow")).collect()),
    }
}

fn table_of(arguments: &Arguments) -> Result<Vec<Point>, Error> {
    points::read(Path::new(arguments.text("--csv").unwrap_or(DEFAULT_TABLE)))
}

/// Prints the verdicts on the table; the process succeeds whatever they are.
fn print_verdicts(arguments: &Arguments) -> Result<bool, Error> {
    print!("{}", verdicts::text(&verdicts::verdicts(&table_of(arguments)?)));
    Ok(true)
}

fn write_page(arguments: &Arguments) -> Result<bool, Error> {
    let all = table_of(arguments)?;
    let page = arguments.text("--page").unwrap_or("docs/error-against-cost.md");
    page::write(Path::new(page), &all, &verdicts::verdicts(&all))?;
    Ok(true)
}

fn print_comparison(arguments: &Arguments) -> Result<bool, Error> {
    let other = points::read(Path::new(arguments.text("--compare").ok_or("give --compare OTHER.csv")?))?;
    let ours = table_of(arguments)?;
    for engine in arguments.list("--engines").unwrap_or(vec!["auto"]) {
        println!("{engine}");
        print!("{}", compare::text(&compare::ratios(&ours, &other, engine)));
    }
    Ok(true)
}

/// Prints the discretization error of every scene that has a reference.
fn print_discretization(arguments: &Arguments) -> Result<bool, Error> {
    let folder = Path::new(arguments.text("--references").ok_or("give --references DIR")?);
    for scene in chosen(arguments)? {
        let file = Reference::file(folder, scene.name, "walks");
        if !file.exists() {
            continue;
        }
        let reference = Reference::read(&file)?;
        if let Some(e) = measure::discretization(&reference) {
            println!(
                "{:<15} {:.2} %, noise {:.2} %  ({})",
                scene.name,
                100.0 * e.error,
                100.0 * e.noise,
                reference.method
            );
        }
    }
    Ok(true)
}

/// Writes all scenes, also those that walks take.
fn write_scenes(arguments: &Arguments) -> Result<bool, Error> {
    let path = PathBuf::from(arguments.word(1).ok_or("give the folder: error_against_cost scenes DIR")?);
    let folder =
        SceneFolder { path: &path, shared: Path::new(arguments.text("--shared").unwrap_or("../shared")) };
    for scene in &SCENES {
        match scene.write(&folder)? {
            Some(file) => println!("{}", file.display()),
            None => println!("{}: skipped, for {} is absent", scene.name, folder.shared.display()),
        }
        scene.write_for_walks(&folder)?;
    }
    Ok(true)
}
