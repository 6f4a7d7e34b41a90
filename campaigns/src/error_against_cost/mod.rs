//! The benchmark of error against cost: furnished and difficult scenes, each solved with each engine from coarse to fine tolerances.
//!
//! `references` picks patches, volume zones and surfaces at random and traces their means by paths that know no zones, in two independent halves, for each
//! light group. `measure` compares solutions with them: the error is the total one, that of sampling, of direct light and of the zoning together. Its square is the
//! mean product of the differences to the two halves, free of their noise; its upper bound, two standard errors above, has the noise of the halves and of the
//! choice of zones.

mod compare;
mod halves;
mod make_references;
mod measure;
mod page;
mod points;
mod reference;
mod scenes;
mod series;
mod verdicts;

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
    /// Writes all scenes, also those that paths take
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
    /// Ratios of processor time of two tables at equal total error
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
        scene.write_for_paths(folder)?;
    }
    Ok(())
}
