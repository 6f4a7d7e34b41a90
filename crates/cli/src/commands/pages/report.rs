//! `zonal report`: a solution as one page of HTML.

use crate::commands::context::Context;
use crate::commands::render::args::parse_size;
use std::path::PathBuf;
use zonal_app::pages::html_report::{FigureSettings, figures, page};
use zonal_app::quality::Quality;
use zonal_app::timeline::{READING, WRITING};
use zonal_io::output;
use zonal_report::{Failure, check_output, say};

/// Write a page with pictures, tables with errors, and provenance of a solution.
///
/// The page is one file that loads nothing else: zones and engine, pictures of the cameras, powers and temperatures with their errors, surfaces, light
/// groups, convergence, notes and warnings, settings and the hash of the scene.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  zonal report furnace.npz -o furnace.html\n  zonal report church.npz -o church.html --pictures 1 --size 960x600"
)]
pub struct Args {
    /// Solution (.npz).
    pub run: PathBuf,
    /// Page to write (.html).
    #[arg(long, short, value_name = "PAGE.html")]
    pub output: PathBuf,
    /// Number of cameras whose pictures are drawn, in the order of the scene; without a camera the scene is seen from an upper corner.
    #[arg(long, default_value_t = 2, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=32))]
    pub pictures: u8,
    /// Pixels across and down of a picture.
    #[arg(long, default_value = "640x420", value_name = "WxH")]
    pub size: String,
    /// Rays of the pictures: as of `zonal render`.
    #[arg(long, value_enum, default_value_t)]
    pub quality: Quality,
}

/// Runs the command.
///
/// # Errors
/// For options that are not valid, solutions that cannot be read, and outputs that cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let size = parse_size(&args.size)?;
    check_output(&args.output, &["html"])?;
    let solution = context.in_stage(READING, || output::read_solution(&args.run))?;
    let settings = FigureSettings { cameras: args.pictures.into(), size, quality: args.quality };
    let figures = figures(&solution, &settings, &context.progress())?;
    let name = args.run.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let text = page(&solution, &name, &figures);
    context.in_stage(WRITING, || output::write_bytes(&args.output, text.as_bytes()))?;
    let written = args.output.display();
    if context.json {
        let json = serde_json::json!({ "written": written.to_string(), "pictures": figures.len(), "bytes": text.len() });
        return context.say_json(json);
    }
    say(&format!("{} picture(s), {:.1} MB written: {written}", figures.len(), text.len() as f64 / 1e6))
}
