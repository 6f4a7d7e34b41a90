//! `zonal report`: a solution as one page of HTML.

use crate::commands::context::{Context, check_picture};
use crate::commands::quality::Quality;
use crate::commands::render::args::{FieldQuantity, parse_size};
use crate::commands::render::camera_choice::select_camera;
use crate::commands::render::false_colours;
use crate::html_report::{Figure, page};
use std::path::PathBuf;
use zonal_io::output::{self, ToneMapping};
use zonal_report::{Failure, check_output, say};
use zonal_scene::{Camera, Progress, Solution};

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
    let solution = output::read_solution(&args.run)?;
    let figures = draw(args, &solution, size, &context.progress())?;
    let name = args.run.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let text = page(&solution, &name, &figures);
    output::write_bytes(&args.output, text.as_bytes())?;
    let written = args.output.display();
    if context.json {
        let json = serde_json::json!({ "written": written.to_string(), "pictures": figures.len(), "bytes": text.len() });
        return say(&json.to_string());
    }
    say(&format!("{} picture(s), {:.1} MB written: {written}", figures.len(), text.len() as f64 / 1e6))
}

/// The pictures: of light and of irradiance, or of temperature and net flux.
fn draw(
    args: &Args,
    s: &Solution,
    size: (usize, usize),
    progress: &dyn Progress,
) -> Result<Vec<Figure>, Failure> {
    let own = s.scene.cameras().iter().take(args.pictures.into()).cloned();
    let mut cameras: Vec<Camera> = own.collect();
    if cameras.is_empty() && args.pictures > 0 {
        cameras.push(select_camera(s, None, size)?);
    }
    let mut out = Vec::new();
    for camera in &cameras {
        let quantities: &[FieldQuantity] = if s.scene.thermal().is_some() {
            &[FieldQuantity::Temperature, FieldQuantity::NetFlux]
        } else {
            out.extend(light_figure(args, s, (camera, size), progress)?);
            &[FieldQuantity::Irradiance]
        };
        for quantity in quantities {
            // A camera that sees no zone, and a field without any value, have no picture.
            let Ok(canvas) = false_colours::draw(s, *quantity, (camera, size), progress) else { continue };
            let png = output::encode_png_bytes((canvas.width, canvas.height), &canvas.bytes, &[])?;
            out.push(Figure { caption: format!("{}: {}", camera.name, quantity.name()), png });
        }
    }
    Ok(out)
}

/// The picture of light of a camera; `None` for solutions whose bands have no colours.
fn light_figure(
    args: &Args,
    s: &Solution,
    (camera, size): (&Camera, (usize, usize)),
    progress: &dyn Progress,
) -> Result<Option<Figure>, Failure> {
    if check_picture(&args.run, s).is_err() {
        return Ok(None);
    }
    let image = zonal_render::render(s, camera, &args.quality.of_picture(size), progress);
    let tone = ToneMapping::filmic(output::auto_exposure(&image.pixels));
    let png = output::encode_picture_png(size, &image.pixels, &tone)?;
    Ok(Some(Figure { caption: format!("{}: light", camera.name), png }))
}
