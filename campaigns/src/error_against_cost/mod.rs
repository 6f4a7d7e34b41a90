//! The benchmark of error against cost: furnished and difficult scenes, each solved with each engine from coarse to fine tolerances.
//!
//! `references` picks patches and volume zones at random and measures them by walks on zones, whose mean is the solution of the zonal
//! equations, for every light group (or for those of `--groups`), and by path tracing without zones (`walks`); by walks that go on from the points that they meet, as the rays of the
//! rays engine do (`continued`); or it solves by the dense engine several times. `measure` compares each engine with the reference of its equations,
//! the dense one before that of walks. The measured error is relative L2 of indirect light, of the worst band; the noise of the reference
//! is subtracted, and points where it is more than a third of the error have a star.

mod compare;
mod make_references;
mod measure;
mod page;
mod points;
mod reference;
mod scenes;
mod series;
mod verdicts;
mod zones;

use crate::harness::{Error, Outcome, SharedData};
use scenes::{BenchmarkScene, SCENES, SceneFolder};
use std::path::PathBuf;

/// The table where none is named.
const DEFAULT_TABLE: &str = "docs/error-against-cost.csv";

#[derive(clap::Args)]
pub(crate) struct SceneChoice {
    /// Names of scenes
    #[arg(long, value_delimiter = ',')]
    scenes: Vec<String>,
    /// With the scenes that take long
    #[arg(long)]
    slow: bool,
    #[command(flatten)]
    data: SharedData,
    /// Folder of references
    #[arg(long)]
    references: PathBuf,
}

#[derive(clap::Subcommand)]
pub(crate) enum BenchmarkStep {
    /// Writes all scenes, also those that walks take
    Scenes {
        folder: PathBuf,
        #[command(flatten)]
        data: SharedData,
    },
    /// Makes the references that are not there
    References(make_references::ReferenceRequest),
    /// Solves and measures the scenes; the table keeps what is not measured again
    Measure(series::MeasuredSeries),
    /// Writes the page and its plots from the table
    Page {
        #[arg(long, default_value = DEFAULT_TABLE)]
        csv: PathBuf,
        #[arg(long, default_value = "docs/error-against-cost.md")]
        page: PathBuf,
    },
    /// Ratios of processor time of two tables at equal error
    Compare {
        #[arg(long, default_value = DEFAULT_TABLE)]
        csv: PathBuf,
        #[arg(long)]
        compare: PathBuf,
        #[arg(long, value_delimiter = ',', default_value = "auto")]
        engines: Vec<String>,
    },
}

impl SceneChoice {
    /// The scenes that are named, or all that are not slow; with `--slow` all.
    fn chosen(&self) -> Result<Vec<&'static BenchmarkScene>, Error> {
        match self.scenes.as_slice() {
            [] => Ok(SCENES.iter().filter(|s| !s.slow || self.slow).collect()),
            names => names.iter().map(|name| BenchmarkScene::named(name)).collect(),
        }
    }
}

impl BenchmarkStep {
    pub(crate) fn run(&self) -> Outcome {
        match self {
            BenchmarkStep::Scenes { folder, data } => {
                write_scenes(&SceneFolder { path: folder, shared: &data.shared })?
            }
            BenchmarkStep::References(request) => request.run()?,
            BenchmarkStep::Measure(series) => series.run()?,
            BenchmarkStep::Page { csv, page } => {
                let all = points::read(csv)?;
                page::write(page, &all, &verdicts::verdicts(&all))?;
            }
            BenchmarkStep::Compare { csv, compare: other, engines } => {
                let (ours, theirs) = (points::read(csv)?, points::read(other)?);
                for engine in engines {
                    print!("{engine}\n{}", compare::text(&compare::ratios(&ours, &theirs, engine)));
                }
            }
        }
        Ok(true)
    }
}

fn write_scenes(folder: &SceneFolder) -> Result<(), Error> {
    for scene in &SCENES {
        match scene.write(folder)? {
            Some(file) => println!("{}", file.display()),
            None => println!("{}: skipped, for {} is absent", scene.name, folder.shared.display()),
        }
        scene.write_for_walks(folder)?;
    }
    Ok(())
}
