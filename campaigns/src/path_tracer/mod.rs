//! The independent path tracer: solutions, tables and pictures against paths of light.
//!
//! ```text
//! path-tracer [SCENE.toml] --solution RUN.npz [--patches 200] [--voxels 200] [--panes 0] [--error 0.01] [--seed 1]
//!       [--max-paths N] [--json] [--table FILE.csv]
//! path-tracer SCENE.toml --picture CAMERA [--size WxH] [--samples N] [--seed 1] -o OUT.exr
//! path-tracer [--cases c0,c8,image_c0,cbox_smoke,…] [--quick] [--shared ../shared] [--seed 1]
//! ```
//!
//! The first form picks zones of a solution at random, measures H and G on them without any zones, and reports the difference of the solution:
//! L2 = RMS of the difference / RMS of the reference; pointwise = RMS of the relative difference over zones above a tenth of the
//! mean; and how many zones lie within twice their own estimate. The second draws a camera's picture with its standard error
//! (`OUT.exr`, `OUT_stderr.exr`). The third compares the path tracer itself with Monte Carlo tables and Mitsuba's pictures; it fails where they
//! disagree.

mod cases;
mod scenes;
mod solution;
#[cfg(test)]
mod tests;

use crate::harness::{Outcome, SharedData};
use std::path::{Path, PathBuf};
use zonal_io::{input, output};
use zonal_reference::path_tracer::PathTracer;
use zonal_scene::Bands;

#[derive(clap::Args)]
pub(crate) struct PathTracerOptions {
    /// Scene; that of the solution by default
    scene: Option<PathBuf>,
    /// Solution whose zones are measured
    #[arg(long)]
    solution: Option<PathBuf>,
    /// Number of patches
    #[arg(long, default_value_t = 200)]
    patches: usize,
    /// Number of voxel zones
    #[arg(long, default_value_t = 200)]
    voxels: usize,
    /// Number of pane zones
    #[arg(long, default_value_t = 0)]
    panes: usize,
    /// Relative standard error: 0.01 of zones, 0.005 of tables
    #[arg(long)]
    error: Option<f64>,
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Most paths of a zone
    #[arg(long)]
    max_paths: Option<u64>,
    #[arg(long)]
    json: bool,
    /// Table of the measured zones (.csv)
    #[arg(long)]
    table: Option<PathBuf>,
    /// Camera to draw
    #[arg(long, requires = "scene", requires = "output")]
    picture: Option<String>,
    /// Pixels of the picture
    #[arg(long, default_value = "320x240")]
    size: String,
    /// Paths a pixel: 64 of a picture, 512 of the cases
    #[arg(long)]
    samples: Option<usize>,
    /// The picture (.exr)
    #[arg(short)]
    output: Option<PathBuf>,
    /// Names of cases; all by default
    #[arg(long, value_delimiter = ',')]
    cases: Vec<String>,
    /// Fewer entries of tables and paths of pictures
    #[arg(long)]
    quick: bool,
    #[command(flatten)]
    data: SharedData,
}

impl PathTracerOptions {
    pub(crate) fn run(&self) -> Outcome {
        match (&self.solution, &self.picture, &self.scene, &self.output) {
            (Some(file), ..) => self.measure_solution(file),
            (None, Some(camera), Some(scene), Some(output)) => self.draw(camera, scene, output),
            _ => self.run_cases(),
        }
    }

    /// Draws a camera's picture with its standard error.
    fn draw(&self, camera: &str, scene: &Path, output: &Path) -> Outcome {
        let scene = input::read_scene(scene)?;
        let camera = scene.cameras().iter().find(|c| c.name == camera);
        let camera = camera.ok_or("the scene has no such camera")?;
        let size = self.size.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
        let sizes = 1..=1 << 14;
        let [width, height] = size
            .filter(|size: &[usize; 2]| size.iter().all(|n| sizes.contains(n)))
            .ok_or("--size: give WIDTHxHEIGHT")?;
        let samples = self.samples.unwrap_or(64);
        let picture = PathTracer::new(&scene).picture(camera, width, height, samples, self.seed);
        let narrow = |p: &[Bands]| p.iter().map(|c| c.to_rgb().map(|x| x as f32)).collect::<Vec<_>>();
        output::write_exr(output, width, height, &narrow(&picture.mean))?;
        let stem = output.file_stem().and_then(|s| s.to_str()).unwrap_or("picture");
        let errors = output.with_file_name(format!("{stem}_stderr.exr"));
        output::write_exr(&errors, width, height, &narrow(&picture.error))?;
        let mean = |p: &[Bands]| (p.iter().sum::<Bands>() / p.len() as f64).to_rgb();
        let (m, e) = (mean(&picture.mean), mean(&picture.error));
        println!("mean {m:.6?}, mean standard error {e:.6?} W/(m² sr)");
        Ok(true)
    }
}
