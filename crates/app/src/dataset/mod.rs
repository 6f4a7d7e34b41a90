//! Data sets: many solves of one scene with sampled numbers, for surrogate models.
//!
//! Samples are solved side by side and stored in blocks; an interrupted run continues where it stopped. Sample i depends on the template, the varied
//! numbers, the seed and i only, so that a larger data set begins with the samples of a smaller one.
//!
//! | module | contents |
//! |---|---|
//! | `distribution` | distributions of the varied numbers |
//! | `sample` | the numbers of one sample |
//! | `store` | finished samples in a folder |

mod distribution;
mod sample;
mod store;

use crate::solving::{path_beside, solve_and_hash};
use distribution::Distribution;
use rayon::prelude::*;
use sample::{Layout, Sample, SampleStatus, zone_geometry};
use serde_json::json;
use std::path::{Path, PathBuf};
use store::SampleStore;
use zonal_io::input::SceneTemplate;
use zonal_io::output::{self, CheckpointFolder, CheckpointKeys, NamedArray};
use zonal_report::{Failure, check_output};
use zonal_scene::{Engine, Progress, Scene, Solution};
use zonal_solve::SolveSettings;

/// Samples of a block, which are stored together.
const SAMPLES_PER_BLOCK: usize = 32;
/// Number of samples unless another is given.
const DEFAULT_SAMPLES: usize = 100;
/// Largest number of samples.
const MAX_SAMPLES: usize = 10_000_000;
/// Refused samples that are listed one by one.
const MAX_LISTED_FAILURES: usize = 5;

/// A data set to make.
#[derive(Clone, Debug)]
pub struct DatasetOptions {
    /// Scene file with a number for every varied key (.toml).
    pub template: PathBuf,
    /// The varied numbers.
    pub inputs: DatasetInputs,
    /// Number of samples; if `None`, 100, or all rows of a table.
    pub count: Option<usize>,
    /// Seed of the samples.
    pub seed: u64,
    /// Data set to write (.npz).
    pub output: PathBuf,
    /// Memory limit of all solves that run at a time, bytes.
    pub memory_limit: u64,
    /// The engine, if it is not that of the template.
    pub engine: Option<Engine>,
    /// Estimates the discretization error of every sample by a second solve.
    pub discretization_error: bool,
}

/// Where the varied numbers come from.
#[derive(Clone, Debug)]
pub enum DatasetInputs {
    /// Sampled from their distributions.
    Sampled(Vec<VariedNumber>),
    /// A table (.csv): a column for each key, a row for each sample.
    Table(PathBuf),
}

/// A number of a scene and its distribution.
#[derive(Clone, Debug)]
pub struct VariedNumber {
    key: String,
    distribution: Distribution,
}

impl VariedNumber {
    /// The number at `key` with the distribution of a text: `LOW:HIGH`, `log:LOW:HIGH`, `normal:MEAN:DEVIATION`, or numbers with commas.
    ///
    /// # Errors
    /// If the text is no distribution.
    pub fn new(key: &str, text: &str) -> Result<VariedNumber, Failure> {
        let distribution =
            Distribution::parse(text).map_err(|e| Failure::new(format!("--vary {key}={text}: {e}")))?;
        Ok(VariedNumber { key: key.trim().to_string(), distribution })
    }
}

/// Where the inputs of the samples come from.
enum Inputs {
    Sampled(Vec<Distribution>, u64),
    Table(Vec<Vec<f64>>),
}

impl Inputs {
    /// The inputs of a sample, one for each key.
    fn of(&self, sample: usize) -> Vec<f64> {
        match self {
            Inputs::Sampled(all, seed) => {
                all.iter().enumerate().map(|(k, d)| d.sample(*seed, sample, k)).collect()
            }
            Inputs::Table(rows) => rows[sample].clone(),
        }
    }
}

/// Receivers of the progress of a run and of notes on its samples and files.
pub struct DatasetObserver<'a> {
    /// Progress over the samples.
    pub progress: &'a dyn Progress,
    /// Is called with each note.
    pub note: &'a (dyn Fn(&str) + Sync),
}

/// Numbers of samples of a data set that was written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DatasetSummary {
    /// All samples.
    pub samples: usize,
    /// Samples of which all iterations converged.
    pub converged: usize,
    /// Samples of which an iteration ended early.
    pub not_converged: usize,
    /// Samples without results.
    pub refused: usize,
    /// Largest power that a balance misses over the power exchanged.
    pub energy_residual: f64,
}

/// Solves all samples and writes their inputs and results.
///
/// # Errors
/// For options, templates and tables that are not valid, a first sample that is refused, and outputs that cannot be written.
pub fn write_dataset(
    options: &DatasetOptions,
    observer: &DatasetObserver<'_>,
) -> Result<DatasetSummary, Failure> {
    // Read the template and the inputs.
    check_output(&options.output, &["npz"])?;
    let (keys, inputs, count) = read_inputs(options)?;
    let template = SceneTemplate::read(&options.template, &keys)?;
    let parallel = rayon::current_num_threads().min(count).max(1);
    let mut run = DatasetRun {
        options,
        template: &template,
        inputs: &inputs,
        memory: options.memory_limit / parallel as u64,
        engine: options.engine,
        observer,
    };
    // The first sample gives the layout, and must be valid.
    let first = run.first_sample()?;
    let (_, layout) = Sample::of(&first);
    let key =
        format!("zonal {} {} {keys:?} {:?}", env!("CARGO_PKG_VERSION"), first.scene_hash, run.identity());
    let folder = path_beside(&options.output, "samples");
    let keys_of_folder = CheckpointKeys { whole: key.clone(), factors: key };
    let (store, is_other) = SampleStore::begin(CheckpointFolder::new(&folder, keys_of_folder))?;
    if is_other {
        (observer.note)(&format!(
            "{}: these samples are of another data set; starting from the beginning",
            folder.display()
        ));
    }
    // Solve the others in blocks.
    let samples = run.solve_all(count, &layout, &store);
    if let Some(e) = store.failure() {
        (observer.note)(&format!("finished samples could not be stored: {e}"));
    }
    // Write the arrays.
    let set = Dataset { keys: &keys, inputs: &inputs, layout: &layout, samples: &samples, first: &first };
    set.write(options)?;
    store.remove();
    Ok(summary(&samples))
}

/// Keys, inputs and number of samples.
fn read_inputs(options: &DatasetOptions) -> Result<(Vec<String>, Inputs, usize), Failure> {
    let numbers = match &options.inputs {
        DatasetInputs::Sampled(numbers) => numbers,
        DatasetInputs::Table(path) => {
            let (keys, rows) = read_table(path)?;
            let count = options.count.unwrap_or(rows.len());
            if count == 0 || count > rows.len() {
                let what = format!(
                    "there are {} rows of inputs and {count} samples; give -n from 1 to {0}",
                    rows.len()
                );
                return Err(Failure::in_file(path, what));
            }
            return Ok((keys, Inputs::Table(rows), count));
        }
    };
    let count = options.count.unwrap_or(DEFAULT_SAMPLES);
    if !(1..=MAX_SAMPLES).contains(&count) {
        return Err(Failure::new(format!("-n {count}: give a number of samples from 1 to {MAX_SAMPLES}")));
    }
    let (keys, all) = numbers.iter().map(|v| (v.key.clone(), v.distribution.clone())).unzip();
    Ok((keys, Inputs::Sampled(all, options.seed), count))
}

/// Column names and rows of a table of inputs.
fn read_table(path: &Path) -> Result<(Vec<String>, Vec<Vec<f64>>), Failure> {
    const MAX_TABLE_BYTES: u64 = 1 << 30;
    let file = zonal_io::input::open_file(path, MAX_TABLE_BYTES)?;
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(file);
    let broken =
        |e: csv::Error| Failure::in_file(path, format!("{e}; write a header of keys and rows of numbers"));
    let keys: Vec<String> = reader.headers().map_err(broken)?.iter().map(String::from).collect();
    let mut rows = Vec::new();
    for row in reader.records() {
        let row = row.map_err(broken)?;
        let line = row.position().map_or(0, csv::Position::line);
        let wrong = |x: &str| {
            Failure::new(format!("{}:{line}: '{x}' is no number; give finite numbers", path.display()))
        };
        let finite = |x: &str| x.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| wrong(x));
        rows.push(row.iter().map(finite).collect::<Result<Vec<f64>, _>>()?);
    }
    Ok((keys, rows))
}

/// An error with the number of the sample in front.
fn of_sample(sample: usize, e: &impl std::fmt::Display) -> Failure {
    Failure::new(format!("sample {sample}: {e}"))
}

/// The samples of a data set.
struct DatasetRun<'a> {
    options: &'a DatasetOptions,
    template: &'a SceneTemplate,
    inputs: &'a Inputs,
    /// Memory limit of one solve, bytes.
    memory: u64,
    /// The engine, if it is not that of the template.
    engine: Option<Engine>,
    observer: &'a DatasetObserver<'a>,
}

/// Tells solves of an interruption; their steps are no steps of the run.
struct Interruption<'a>(&'a dyn Progress);

impl Progress for Interruption<'_> {
    fn begin(&self, _: &str, _: u64) {}
    fn advance(&self, _: u64) {}
    fn end(&self) {}
    fn is_interrupted(&self) -> bool {
        self.0.is_interrupted()
    }
}

impl DatasetRun<'_> {
    /// What the samples depend on beside the scene of the first one.
    fn identity(&self) -> String {
        let of_inputs = match self.inputs {
            Inputs::Sampled(all, seed) => format!("{all:?} {seed}"),
            Inputs::Table(rows) => format!("{rows:?}"),
        };
        format!("{of_inputs} {} {:?}", self.memory, self.engine)
    }
    /// The scene of a sample.
    fn scene(&self, sample: usize) -> Result<Scene, Failure> {
        let scene = self.template.scene(&self.inputs.of(sample)).map_err(|e| of_sample(sample, &e))?;
        let mut options = scene.options().clone();
        let own = options.discretization_error.unwrap_or(false);
        options.engine = self.engine.unwrap_or(options.engine);
        options.discretization_error = Some(self.options.discretization_error || own);
        scene.with_options(options).map_err(|e| of_sample(sample, &e))
    }
    /// Solves the first sample, and chooses the engine: small boxes take a twentieth of the time by the spectral engine.
    fn first_sample(&mut self) -> Result<Solution, Failure> {
        if self.engine.is_none() && self.scene(0)?.options().engine == Engine::Auto {
            self.engine = Some(Engine::Spectral);
            if let Ok(found) = self.solve(0) {
                return Ok(found);
            }
            self.engine = None;
        }
        self.solve(0)
    }
    /// Solves a sample.
    fn solve(&self, sample: usize) -> Result<Solution, Failure> {
        let scene = self.scene(sample)?;
        let interruption = Interruption(self.observer.progress);
        solve_and_hash(scene, &SolveSettings::new(self.memory, &interruption))
            .map_err(|e| of_sample(sample, &Failure::in_file(&self.options.template, e)))
    }
    /// The numbers of a sample; refused with its message if it cannot be solved or has another layout than the first.
    fn sample(&self, sample: usize, layout: &Layout) -> (Sample, Option<String>) {
        match self.solve(sample) {
            Err(e) => (Sample::refused(), Some(e.to_string())),
            Ok(solution) => match Sample::of(&solution) {
                (own, found) if found == *layout => (own, None),
                _ => {
                    let what = "it has other zones than sample 0; vary numbers that leave the zones";
                    (Sample::refused(), Some(format!("sample {sample}: {what}")))
                }
            },
        }
    }
    /// All samples, block by block; those in the store are not solved again.
    fn solve_all(&self, count: usize, layout: &Layout, store: &SampleStore) -> Vec<Sample> {
        let progress = self.observer.progress;
        let length = layout.arrays.iter().map(|a| a.shape.iter().product::<usize>()).sum();
        let (mut all, mut failures) = (Vec::with_capacity(count), 0);
        progress.begin("samples", count as u64);
        for block in 0..count.div_ceil(SAMPLES_PER_BLOCK) {
            let range = block * SAMPLES_PER_BLOCK..((block + 1) * SAMPLES_PER_BLOCK).min(count);
            if let Some(kept) = store.load(block, range.len(), length) {
                progress.advance(range.len() as u64);
                all.extend(kept);
                continue;
            }
            let solved: Vec<(Sample, Option<String>)> = range
                .into_par_iter()
                .map(|i| {
                    let sample = self.sample(i, layout);
                    progress.advance(1);
                    sample
                })
                .collect();
            for message in solved.iter().filter_map(|s| s.1.as_ref()) {
                failures += 1;
                if failures <= MAX_LISTED_FAILURES {
                    (self.observer.note)(message);
                }
            }
            let samples: Vec<Sample> = solved.into_iter().map(|s| s.0).collect();
            store.save(block, &samples);
            all.extend(samples);
        }
        progress.end();
        all
    }
}

/// A data set before it is written.
struct Dataset<'a> {
    keys: &'a [String],
    inputs: &'a Inputs,
    layout: &'a Layout,
    samples: &'a [Sample],
    first: &'a Solution,
}

impl Dataset<'_> {
    /// Writes the arrays.
    fn write(&self, options: &DatasetOptions) -> Result<(), Failure> {
        let (n, k) = (self.samples.len(), self.keys.len());
        let inputs: Vec<f64> = (0..n).flat_map(|i| self.inputs.of(i)).collect();
        let status: Vec<f64> = self.samples.iter().map(|s| f64::from(s.status as u8)).collect();
        let residuals: Vec<f64> = self.samples.iter().map(|s| s.energy_residual).collect();
        let [centres, sizes] = zone_geometry(&self.first.zones);
        let zones = sizes.len();
        let fields: Vec<Vec<f64>> = self.fields();
        let named = |name, shape, values| NamedArray { name, shape, values };
        let mut arrays = vec![
            named("inputs", vec![n, k], &inputs[..]),
            named("status", vec![n], &status),
            named("energy_residual", vec![n], &residuals),
            named("zone_centre", vec![zones, 3], &centres),
            named("zone_size", vec![zones], &sizes),
        ];
        for (layout, values) in self.layout.arrays.iter().zip(&fields) {
            let shape = [&[n], &layout.shape[..]].concat();
            arrays.push(named(layout.name, shape, values));
        }
        let units: serde_json::Map<String, serde_json::Value> =
            self.layout.arrays.iter().map(|a| (a.name.to_string(), json!(a.unit))).collect();
        let about = json!({
            "keys": self.keys, "names": self.layout.names, "units": units, "seed": options.seed,
            "status": { "0": "converged", "1": "not converged", "2": "refused" },
            "patches": self.first.zones.patches.len(), "voxel_zones": self.first.zones.voxels.len(),
            "order_of_zones": "patches, then voxel zones, then pane zones",
            "cells": self.first.scene.voxel_grid().map(|g| g.dims()),
            "version": env!("CARGO_PKG_VERSION"),
        });
        Ok(output::write_arrays(&options.output, Some(&about.to_string()), &arrays)?)
    }

    /// The values of each array over all samples; NaN for refused ones.
    fn fields(&self) -> Vec<Vec<f64>> {
        let mut first = 0;
        let of_array = |a: &sample::ArrayLayout| {
            let length: usize = a.shape.iter().product();
            let range = first..first + length;
            first += length;
            let own = |s: &Sample| match s.numbers.get(range.clone()) {
                Some(values) => values.to_vec(),
                None => vec![f64::NAN; length],
            };
            self.samples.iter().flat_map(own).collect()
        };
        self.layout.arrays.iter().map(of_array).collect()
    }
}

/// The number of samples by status and the largest residual.
fn summary(samples: &[Sample]) -> DatasetSummary {
    let count = |status| samples.iter().filter(|s| s.status == status).count();
    let [converged, not_converged, refused] =
        [SampleStatus::Converged, SampleStatus::NotConverged, SampleStatus::Refused].map(count);
    let residuals = samples.iter().map(|s| s.energy_residual).filter(|r| !r.is_nan());
    let energy_residual = residuals.fold(0.0, f64::max);
    DatasetSummary { samples: samples.len(), converged, not_converged, refused, energy_residual }
}
