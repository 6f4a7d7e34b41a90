//! The path of a camera through a scene: key frames in a TOML file. Its users' manual: `docs/how-to/animation.md`.
//!
//! A quantity that a key frame omits keeps its value of the key frame before.

use crate::input::reading::error::InputError;
use crate::input::reading::suggestion::suggest;
use crate::input::reading::text::read_text;
use crate::input::scene::camera::read_view;
use crate::input::toml::camera_keys::{
    CAMERA_PATH, CameraPath as PathKeys, KEY_FRAME, KeyFrame as KeyFrameKeys, VIEW,
};
use crate::input::toml::node::{TomlNode, TomlTable};
use crate::input::toml::source::SourceText;
use std::path::Path;
use zonal_scene::{Bands, Camera, SceneError};

/// Largest text, bytes.
const MAX_PATH_TEXT_BYTES: u64 = 16 << 20;

/// Largest number of frames of a camera path.
pub const MAX_FRAMES: usize = 99_999;

/// Key frames and a frame rate.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPath {
    /// Frames a second.
    pub frames_per_second: f64,
    /// Factor of the radiance in all frames, (m² sr)/W; automatic if none.
    pub exposure: Option<f64>,
    /// At least one key frame, by ascending time.
    pub keys: Vec<KeyFrame>,
}

/// Camera, exposure and light groups at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyFrame {
    /// Time, s.
    pub time: f64,
    /// The camera; its name is the path of the key frame in the file.
    pub camera: Camera,
    /// Exposure, stops above that of all frames.
    pub stops: f64,
    /// Factor of each light group of the solution, in the solution's order.
    pub lights: Vec<Bands>,
}

/// Reads a camera path through a scene with these cameras and light groups.
///
/// # Errors
///
/// The file cannot be read, is not TOML, or has unknown keys or values out of range.
pub fn read_camera_path(path: &Path, cameras: &[Camera], groups: &[&str]) -> Result<CameraPath, InputError> {
    let file = path.display().to_string();
    let text = read_text(path, MAX_PATH_TEXT_BYTES)?;
    parse_camera_path(&text, &file, cameras, groups)
}

/// As [`read_camera_path`], from the text; `name_for_messages` stands for the file in messages.
///
/// # Errors
///
/// As [`read_camera_path`].
///
/// ```
/// let text = "[[key]]\ntime = 0\norigin = [0, 0, 1]\ntarget = [1, 0, 1]\n[[key]]\ntime = 2\norigin = [0, 1, 1]";
/// let path = zonal_io::input::parse_camera_path(text, "path.toml", &[], &[])?;
/// assert_eq!((path.keys.len(), path.frames_per_second), (2, 24.0));
/// # Ok::<(), zonal_io::input::InputError>(())
/// ```
pub fn parse_camera_path(
    text: &str,
    name_for_messages: &str,
    cameras: &[Camera],
    groups: &[&str],
) -> Result<CameraPath, InputError> {
    let source = SourceText::new(name_for_messages, text);
    let document = source.parse()?;
    read_path(TomlTable::root(&source, document.get_ref()), cameras, groups)
}

fn read_path(root: TomlTable<'_>, cameras: &[Camera], groups: &[&str]) -> Result<CameraPath, InputError> {
    root.check(PathKeys::TABLE)?;
    let mut out = CameraPath {
        frames_per_second: root.or_default(&CAMERA_PATH.frames_per_second)?,
        exposure: root.value(&CAMERA_PATH.exposure)?,
        keys: Vec::new(),
    };
    for node in root.list(&CAMERA_PATH.key)? {
        let next = read_key_frame(&node, out.keys.last(), cameras, groups)?;
        out.keys.push(next);
    }
    let (Some(first), Some(last)) = (out.keys.first(), out.keys.last()) else {
        return Err(root.error("there are no key frames; write [[key]] with a time and a camera"));
    };
    let frames = (last.time - first.time) * out.frames_per_second;
    if frames.is_nan() || frames >= MAX_FRAMES as f64 {
        let message =
            format!("{frames:.0} frames are more than {MAX_FRAMES}; give fewer a second or less time");
        return Err(root
            .get(&CAMERA_PATH.frames_per_second)
            .map_or_else(|| root.error(&message), |n| n.error(&message)));
    }
    Ok(out)
}

fn read_key_frame(
    node: &TomlNode<'_>,
    before: Option<&KeyFrame>,
    cameras: &[Camera],
    groups: &[&str],
) -> Result<KeyFrame, InputError> {
    let t = node.table(KeyFrameKeys::TABLE)?;
    let time = t.require(&KEY_FRAME.time)?;
    let seconds = KEY_FRAME.time.read(&time)?;
    if let Some(b) = before.filter(|b| seconds <= b.time) {
        return Err(
            time.error(format!("{seconds} s is not after {} s of the key before; give a later time", b.time))
        );
    }
    let unchanged = || before.map_or_else(|| vec![Bands::ONE; groups.len()], |b| b.lights.clone());
    Ok(KeyFrame {
        time: seconds,
        camera: read_key_camera(&t, before, cameras)?,
        stops: t.value(&KEY_FRAME.stops)?.unwrap_or(before.map_or(0.0, |b| b.stops)),
        lights: match t.get(&KEY_FRAME.lights) {
            Some(n) => read_lights(&n, unchanged(), groups)?,
            None => unchanged(),
        },
    })
}

/// The camera of a key frame: the named one, or that of the key frame before, with the keys that are given.
fn read_key_camera(
    t: &TomlTable<'_>,
    before: Option<&KeyFrame>,
    cameras: &[Camera],
) -> Result<Camera, InputError> {
    let named = |n: TomlNode<'_>| {
        let wanted = n.text()?;
        let names: Vec<&str> = cameras.iter().map(|c| c.name.as_str()).collect();
        cameras.iter().find(|c| c.name == wanted).cloned().ok_or_else(|| {
            n.error(format!("the scene has no camera '{wanted}'; {}", suggest(wanted, &names)))
        })
    };
    let base = t.get(&KEY_FRAME.camera).map(named).transpose()?.or_else(|| before.map(|b| b.camera.clone()));
    if base.is_none() && t.get(&VIEW.origin).is_none() {
        return Err(t.missing("origin", "origin = [x, y, z], or camera = \"NAME\""));
    }
    let camera = read_view(t, base)?.name(t.key.as_str());
    camera.check().map_err(|e| camera_error(t, &e))?;
    Ok(camera)
}

/// The error of an invalid camera, at the key that it names.
fn camera_error(t: &TomlTable<'_>, e: &SceneError) -> InputError {
    let key = e.key().rsplit('.').next().unwrap_or("");
    let message = format!("{}; change this value", e.message());
    t.get(key).map_or_else(|| t.error(&message), |n| n.error(&message))
}

/// The factors of the light groups: the old ones, replaced by those that the table gives.
fn read_lights(node: &TomlNode<'_>, mut all: Vec<Bands>, groups: &[&str]) -> Result<Vec<Bands>, InputError> {
    for (name, factor) in node.any_table()?.entries() {
        let Some(k) = groups.iter().position(|g| *g == name) else {
            let hint = if groups.is_empty() {
                "it keeps none; solve the scene again".to_string()
            } else {
                suggest(name, groups)
            };
            return Err(factor.error(format!("the solution has no light group '{name}'; {hint}")));
        };
        all[k] = factor.bands(f64::INFINITY)?;
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;
    use zonal_scene::Lens;

    fn read(text: &str) -> Result<CameraPath, InputError> {
        let camera = Camera {
            fov: 50.0,
            lens: Lens { aperture: 0.1, focus: Some(4.0) },
            ..Camera::look_at([1.0, 2.0, 3.0], [0.0, 9.0, 3.0]).name("door")
        };
        parse_camera_path(text, "f.toml", &[camera], &["sun", "lamp"])
    }

    #[test]
    fn omitted_quantities_keep_their_value_of_the_key_frame_before() {
        let f = read(
            "exposure = 0.5
            key = [
                { time = 0, camera = 'door', lights = { sun = 0.5 } },
                { time = 1.5, origin = [0, 0, 1], stops = -1, lights = { lamp = [1, 2, 3] } },
                { time = 2, fov = 20, focus = 7 },
            ]",
        )
        .unwrap();
        assert_eq!((f.frames_per_second, f.exposure, f.keys.len()), (24.0, Some(0.5), 3));
        let last = &f.keys[2];
        assert_eq!((last.time, last.stops, last.camera.fov), (2.0, -1.0, 20.0));
        assert_eq!((last.camera.origin, last.camera.target), (vec3(0.0, 0.0, 1.0), vec3(0.0, 9.0, 3.0)));
        assert_eq!(last.camera.lens, Lens { aperture: 0.1, focus: Some(7.0) });
        assert_eq!(last.lights, [Bands::splat(0.5), Bands::from_rgb([1.0, 2.0, 3.0])]);
    }

    #[test]
    fn invalid_camera_paths_are_refused_with_place_and_key() {
        let view = "origin = [0, 0, 0]\ntarget = [1, 0, 0]";
        let key = |more: &str| format!("[[key]]\ntime = 0\n{more}");
        for (text, place, named) in [
            (String::new(), "f.toml:1:1", "no key frames"),
            ("fps = 3".into(), "f.toml:1:1: fps", "known here"),
            ("frames_per_second = 0".into(), "f.toml:1:21", "out of range"),
            ("exposure = -1".into(), "f.toml:1:12: exposure", "above 0"),
            ("[[key]]\ncamera = 'door'".into(), "key[0].time", "missing"),
            (key("camera = 'dor'"), "f.toml:3:10: key[0].camera", "did you mean 'door'"),
            (key("target = [0, 0, 0]"), "key[0].origin", "camera = \"NAME\""),
            (key("origin = [0, 0, 0]"), "key[0].target", "missing"),
            (key("origin = [0, 0, 0]\ntarget = [0, 0, 0]"), "f.toml:4:10: key[0].target", "apart"),
            (key("origin = [0, 0, 0]\ntarget = [0, 0, 1]"), "key[0]", "line of sight"),
            (key(&format!("{view}\nfov = 180")), "f.toml:5:7: key[0].fov", "below 180"),
            (key(&format!("{view}\naperture = -1")), "key[0].aperture", "from 0"),
            (key(&format!("{view}\nfocus = 0")), "key[0].focus", "above 0"),
            (key(&format!("{view}\nstops = 31")), "key[0].stops", "-30 to 30"),
            (key(&format!("{view}\nlights.sum = 1")), "key[0].lights.sum", "did you mean 'sun'"),
            (key(&format!("{view}\nlights.sun = -1")), "key[0].lights.sun", "negative"),
            (key(&format!("{view}\n[[key]]\ntime = 0")), "f.toml:6:8: key[1].time", "later"),
            (key(&format!("{view}\n[[key]]\ntime = 1e9")), "f.toml:1:1", "more than 99999"),
            (key("time = 1"), "f.toml:3:1", "TOML"),
        ] {
            let e = read(&text).unwrap_err().to_string();
            assert!(e.contains(place) && e.contains(named) && e.contains(';'), "{text:?}: {e}");
        }
    }
}
