//! The camera of a picture: one of the scene or of a file by name, or a view of its own.
//!
//! A view replaces parts of the chosen camera. Every scene has the camera `overview`.

use std::path::PathBuf;
use zonal_io::input::{CameraPath, KeyFrame, read_cameras};
use zonal_math::{Vec3, vec3};
use zonal_report::Failure;
use zonal_scene::{Bands, Camera, Solution};

/// The choice of a camera, and parts in place of its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ViewOptions {
    /// Name of a camera; the first if `None`. Every scene also has `overview`.
    pub camera: Option<String>,
    /// File whose cameras replace the cameras of the scene.
    pub camera_file: Option<PathBuf>,
    /// Where the camera stands, m.
    pub from: Option<Vec3>,
    /// The point that it looks at, m; with `from` the centre of the scene if `None`.
    pub look_at: Option<Vec3>,
    /// Angle of view across the width of the picture, degrees.
    pub fov: Option<f64>,
    /// Upward direction.
    pub up: Option<Vec3>,
}

impl ViewOptions {
    /// True if nothing is chosen.
    pub(super) fn is_default(&self) -> bool {
        *self == ViewOptions::default()
    }

    /// The camera for a picture of this size.
    ///
    /// # Errors
    /// If there is no camera of this name, the file of cameras cannot be read, or the view is not valid.
    pub(super) fn select(&self, s: &Solution, size: (usize, usize)) -> Result<Camera, Failure> {
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
    size: (usize, usize),
) -> Result<Camera, Failure> {
    let (low, high) = s.scene.bounds();
    let overview = || Camera::overview(low, high, size.0 as f64 / size.1 as f64);
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
    use crate::pictures::camera_animation::animation_frames;

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
}
