//! The pictures of the page: of light and of irradiance, or of temperature and net flux.

use crate::pictures::{FieldPicture, FieldQuantity, select_camera};
use crate::quality::Quality;
use crate::shown_solution::shows_light;
use zonal_io::output::{self, ToneMapping};
use zonal_report::Failure;
use zonal_scene::{Camera, Progress, Solution};

/// A picture of the page.
pub struct Figure {
    /// Camera and quantity.
    pub caption: String,
    /// The file, a PNG.
    pub png: Vec<u8>,
}

/// Contents of the pictures.
#[derive(Clone, Copy, Debug)]
pub struct FigureSettings {
    /// Number of cameras whose pictures are drawn, in the order of the scene; without a camera the scene is seen from an upper corner.
    pub cameras: usize,
    /// Pixels across and down.
    pub size: (usize, usize),
    /// Rays.
    pub quality: Quality,
}

/// Draws the pictures of a solution.
///
/// # Errors
/// If a picture cannot be encoded.
pub fn figures(
    s: &Solution,
    settings: &FigureSettings,
    progress: &dyn Progress,
) -> Result<Vec<Figure>, Failure> {
    let mut cameras: Vec<Camera> = s.scene.cameras().iter().take(settings.cameras).cloned().collect();
    if cameras.is_empty() && settings.cameras > 0 {
        cameras.push(select_camera(s, None, settings.size)?);
    }
    let mut out = Vec::new();
    for camera in &cameras {
        let quantities: &[FieldQuantity] = if s.scene.thermal().is_some() {
            &[FieldQuantity::Temperature, FieldQuantity::NetFlux]
        } else {
            out.extend(light_figure(s, camera, settings, progress)?);
            &[FieldQuantity::Irradiance]
        };
        for quantity in quantities {
            // A camera that sees no zone, and a field without any value, have no picture.
            let picture = FieldPicture::of_quantity(*quantity, settings.size, None);
            let Ok(canvas) = picture.draw(s, camera, progress) else { continue };
            let png = output::encode_png_bytes(canvas.width, canvas.height, &canvas.bytes, &[])?;
            out.push(Figure { caption: format!("{}: {}", camera.name, quantity.name()), png });
        }
    }
    Ok(out)
}

/// The picture of light of a camera; `None` for solutions whose bands have no colours.
fn light_figure(
    s: &Solution,
    camera: &Camera,
    settings: &FigureSettings,
    progress: &dyn Progress,
) -> Result<Option<Figure>, Failure> {
    if !shows_light(s) {
        return Ok(None);
    }
    let image = zonal_render::render(s, camera, &settings.quality.of_picture(settings.size), progress);
    let tone = ToneMapping::filmic(output::auto_exposure(&image.pixels));
    let png = output::encode_picture_png(settings.size.0, settings.size.1, &image.pixels, &tone)?;
    Ok(Some(Figure { caption: format!("{}: light", camera.name), png }))
}
