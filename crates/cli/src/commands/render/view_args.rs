//! Arguments that choose a camera.

use std::path::PathBuf;
use zonal_app::pictures::ViewOptions;
use zonal_math::{Vec3, vec3};

const VIEW_HEADING: &str = "Camera";

/// Arguments that choose a camera.
#[derive(clap::Args, Debug)]
pub struct ViewArgs {
    /// Name of a camera of the scene [default: the first]. Every scene also has `overview`, which sees the whole scene from an upper corner; it is the
    /// default of a scene without a camera.
    #[arg(long, value_name = "NAME", conflicts_with = "animate", help_heading = VIEW_HEADING)]
    pub camera: Option<String>,
    /// Take the cameras of this file, which has the tables of cameras of a scene, in place of those of the scene.
    #[arg(long, value_name = "CAMERAS.toml", conflicts_with = "animate", help_heading = VIEW_HEADING)]
    pub camera_file: Option<PathBuf>,
    /// Stand at this point, m.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, conflicts_with = "animate", help_heading = VIEW_HEADING)]
    pub from: Option<Vec3>,
    /// Look at this point, m [default with --from: the centre of the scene].
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, conflicts_with = "animate", help_heading = VIEW_HEADING)]
    pub look_at: Option<Vec3>,
    /// Angle of view across the width of the picture, degrees above 0 and below 180.
    #[arg(long, value_name = "DEGREES", conflicts_with = "animate", help_heading = VIEW_HEADING)]
    pub fov: Option<f64>,
    /// Upward direction [default: 0,0,1].
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, conflicts_with = "animate", help_heading = VIEW_HEADING)]
    pub up: Option<Vec3>,
}

impl ViewArgs {
    /// The options of the arguments.
    pub(super) fn options(&self) -> ViewOptions {
        ViewOptions {
            camera: self.camera.clone(),
            camera_file: self.camera_file.clone(),
            from: self.from,
            look_at: self.look_at,
            fov: self.fov,
            up: self.up,
        }
    }
}

fn parse_point(text: &str) -> Result<Vec3, String> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|x| x.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) => Ok(vec3(x, y, z)),
        _ => Err("give three numbers with commas, such as 1.5,-2,1.6".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_read() {
        assert_eq!(parse_point("1,-2, 3.5"), Ok(vec3(1.0, -2.0, 3.5)));
        assert!(parse_point("1,2").is_err() && parse_point("1,2,inf").is_err());
    }
}
