//! The camera of a picture: one of the scene or of a file by name, or a view from the command line.
//!
//! The view from the command line replaces parts of the chosen camera. Every scene has the camera `overview`.

use std::path::PathBuf;
use zonal_io::input::{CameraPath, KeyFrame, read_cameras};
use zonal_math::{Vec3, vec3};
use zonal_report::Failure;
use zonal_scene::{Bands, Camera, Solution};

const VIEW_HEADING: &str = "Camera";

/// Arguments that choose a camera.
#[derive(clap::Args, Clone, Debug, Default)]
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

fn parse_point(text: &str) -> Result<Vec3, String> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|x| x.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) => Ok(vec3(x, y, z)),
        _ => Err("give three numbers with commas, such as 1.5,-2,1.6".into()),
    }
}

impl ViewArgs {
    /// The camera for a picture of this size.
    ///
    /// # Errors
    /// If there is no camera of this name, the file of cameras cannot be read, or the view is not valid.
    pub fn select(&self, s: &Solution, size: (usize, usize)) -> Result<Camera, Failure> {
        let of_file = self.camera_file.as_ref().map(|path| read_cameras(path)).transpose()?;
        let cameras = of_file.as_deref().unwrap_or(s.scene.cameras());
        let mut camera = select_among(s, cameras, self.camera.as_deref(), size)?;
        let (low, high) = s.scene.bounds();
        if let Some(from) = self.from {
            (camera.origin, camera.target) = (from, (low + high) * 0.5);
            camera.name = "view".into();
        }
        camera.target = self.look_at.unwrap_or(camera.target);
        camera.up = self.up.unwrap_or(camera.up);
        camera.fov = self.fov.unwrap_or(camera.fov);
        camera.check().map_err(|e| {
            let flag = match e.key().rsplit('.').next() {
                Some("target") => "--from and --look-at",
                Some("up") => "--up",
                _ => "--fov",
            };
            Failure::new(format!("{flag}: {}", e.message()))
        })?;
        Ok(camera)
    }
}

/// The camera of a name, or the first, for a picture of this size. Every scene has the camera `overview`; it is the first of a scene without a camera.
///
/// # Errors
/// If there is no camera of this name.
pub fn select_camera(s: &Solution, name: Option<&str>, size: (usize, usize)) -> Result<Camera, Failure> {
    select_among(s, s.scene.cameras(), name, size)
}

fn select_among(
    s: &Solution,
    cameras: &[Camera],
    name: Option<&str>,
    (width, height): (usize, usize),
) -> Result<Camera, Failure> {
    let overview = || Camera::overview(s.scene.bounds(), width as f64 / height as f64);
    let Some(name) = name else { return Ok(cameras.first().cloned().unwrap_or_else(overview)) };
    let found = cameras.iter().find(|c| c.name == name).cloned();
    found.or_else(|| (name == "overview").then(overview)).ok_or_else(|| {
        let names: Vec<&str> = cameras.iter().map(|c| c.name.as_str()).chain(["overview"]).collect();
        Failure::new(format!(
            "--camera: there is no camera '{name}'; there are {}, or give --from and --look-at",
            names.join(", ")
        ))
    })
}

/// Frames a second of a turntable.
const TURNTABLE_FRAMES_PER_SECOND: f64 = 24.0;

/// The path of a camera once around the vertical through its target, in `count` frames.
pub(super) fn turntable(camera: &Camera, count: u32, groups: usize) -> CameraPath {
    let key = |k: u32| {
        let (sine, cosine) = (std::f64::consts::TAU * f64::from(k) / f64::from(count)).sin_cos();
        let turned = |v: Vec3| vec3(cosine * v.x - sine * v.y, sine * v.x + cosine * v.y, v.z);
        let origin = camera.target + turned(camera.origin - camera.target);
        let camera = Camera { origin, up: turned(camera.up), ..camera.clone() };
        let time = f64::from(k) / TURNTABLE_FRAMES_PER_SECOND;
        KeyFrame { time, camera, stops: 0.0, lights: vec![Bands::ONE; groups] }
    };
    CameraPath {
        frames_per_second: TURNTABLE_FRAMES_PER_SECOND,
        exposure: None,
        keys: (0..count).map(key).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera_animation::animation_frames;

    #[test]
    fn a_turntable_goes_once_around_the_target() {
        let camera = Camera::look_at([3.0, 0.0, 1.0], [1.0, 0.0, 0.5]);
        let frames = animation_frames(&turntable(&camera, 8, 0));
        assert_eq!(frames.len(), 8);
        for (k, f) in frames.iter().enumerate() {
            let (s, c) = (std::f64::consts::TAU * k as f64 / 8.0).sin_cos();
            let expected = vec3(1.0 + 2.0 * c, 2.0 * s, 1.0);
            assert!((f.camera.origin - expected).length() < 1e-6, "{k}: {:?}", f.camera.origin);
            assert!((f.camera.target - camera.target).length() < 1e-9);
        }
    }

    #[test]
    fn points_are_read() {
        assert_eq!(parse_point("1,-2, 3.5"), Ok(vec3(1.0, -2.0, 3.5)));
        assert!(parse_point("1,2").is_err() && parse_point("1,2,inf").is_err());
    }
}
