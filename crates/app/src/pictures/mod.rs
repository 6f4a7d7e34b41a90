//! Pictures of a solution in files: of light, in false colours, or the frames of a camera animation.
//!
//! | module | contents |
//! |---|---|
//! | `options` | what is drawn, and which options apply |
//! | `camera_choice` | the camera of a picture |
//! | `picture`, `style` | a picture of light; its tone and bloom |
//! | `field_quantity`, `false_colours`, `colour_scale`, `legend` | a picture of values with its scale |
//! | `animation`, `camera_animation` | frames, and the cameras between key frames |

mod animation;
mod camera_animation;
mod camera_choice;
mod colour_scale;
mod false_colours;
mod field_quantity;
mod legend;
mod options;
mod picture;
mod style;

pub use animation::{AnimationSummary, DrawnFrames};
pub use camera_animation::animation_frames;
pub use camera_choice::{ViewOptions, select_camera};
pub use false_colours::{FieldPicture, FieldPictureSummary, FieldPixels, check_range};
pub use field_quantity::{FieldQuantity, MediumSlice};
pub use legend::srgb_bytes;
pub use options::{DrawOptions, KeySource, MAX_RAYS, check_size};
pub use picture::{LightPictureSummary, SavedPicture, save};
pub use style::PictureStyle;

use crate::shown_solution::check_picture;
use picture::LightPicture;
use zonal_report::Failure;
use zonal_scene::{Progress, Solution};
use zonal_solve::distribution::Communicator;

/// A picture that was drawn and written.
pub enum Drawing {
    /// A picture of light.
    Light(LightPictureSummary),
    /// A picture in false colours, or its values.
    Field(FieldPictureSummary),
    /// Frames, and their video.
    Frames(AnimationSummary),
}

/// Draws a solution and writes the picture or the frames. Processes share frames; a single picture is drawn by each process.
///
/// # Errors
/// For options that are not valid or do not apply, solutions that cannot be shown, and outputs that cannot be written.
pub fn draw(
    options: &DrawOptions,
    solution: &Solution,
    progress: &dyn Progress,
    communicator: &dyn Communicator,
) -> Result<Drawing, Failure> {
    if let Some(quantity) = options.show {
        let picture = FieldPicture::new(options, quantity)?;
        return Ok(Drawing::Field(picture.write(options, solution, progress)?));
    }
    if let Some(keys) = &options.keys {
        let style = animation::check(options)?;
        check_picture(&options.source, solution)?;
        let summary = animation::write(options, keys, style, solution, progress, communicator)?;
        return Ok(Drawing::Frames(summary));
    }
    let picture = LightPicture::new(options)?;
    check_picture(&options.source, solution)?;
    Ok(Drawing::Light(picture.write(options, solution, progress)?))
}

impl DrawOptions {
    /// Refuses options that are not valid or do not apply, and outputs that cannot be written.
    ///
    /// # Errors
    /// The option, and what to do.
    pub fn check(&self) -> Result<(), Failure> {
        match (self.show, &self.keys) {
            (Some(quantity), _) => FieldPicture::new(self, quantity).map(|_| ()),
            (None, Some(_)) => animation::check(self).map(|_| ()),
            (None, None) => LightPicture::new(self).map(|_| ()),
        }
    }
}
