//! The path of a camera through a scene: key frames in a TOML file. Its users' page: `docs/animation.md`.
//!
//! What a key leaves out stays as it was at the key before.

use super::build::{VIEW, aperture, fov};
use super::error::InputError;
use super::node::{Node, Table, suggestion};
use super::{read_text, source::Source};
use std::path::Path;
use zonal_math::vec3;
use zonal_scene::{Bands, Camera, Lens, SceneError};

/// The largest text, bytes.
const MAX_TEXT: u64 = 16 << 20;

/// The most frames of a flight.
pub const MAX_FRAMES: usize = 99_999;

/// Key frames, and how often a second the camera looks in between.
#[derive(Clone, Debug, PartialEq)]
pub struct Flight {
    /// Frames a second.
    pub frames_per_second: f64,
    /// Factor on the radiance in all frames, (m² sr)/W; none: an automatic one.
    pub exposure: Option<f64>,
    /// At least one, by ascending time.
    pub keys: Vec<Key>,
}

/// Where the camera is at a time, and how the lights shine.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// s.
    pub time: f64,
    /// The camera; its name says which key it is.
    pub camera: Camera,
    /// Exposure, stops above that of all frames.
    pub stops: f64,
    /// Factor of each light group of the solution, in its order.
    pub lights: Vec<Bands>,
}

/// Reads a flight through a scene with these cameras and light groups.
pub fn read_flight(path: &Path, cameras: &[Camera], groups: &[&str]) -> Result<Flight, InputError> {
    let file = path.display().to_string();
    let text = read_text(path, MAX_TEXT)?;
    parse_flight(&text, &file, cameras, groups)
}

/// As [`read_flight`], from its text; `name_for_messages` stands for the file in messages.
pub fn parse_flight(
    text: &str,
    name_for_messages: &str,
    cameras: &[Camera],
    groups: &[&str],
) -> Result<Flight, InputError> {
    let source = Source::new(name_for_messages, text);
    let document = source.parse()?;
    flight(&Table::root(&source, document.get_ref()), cameras, groups)
}

fn flight(root: &Table<'_>, cameras: &[Camera], groups: &[&str]) -> Result<Flight, InputError> {
    root.check(&["frames_per_second", "exposure", "key"])?;
    let rate = |n: Node<'_>| match n.number()? {
        x if x > 0.0 && x <= 1000.0 => Ok(x),
        x => Err(n.error(format!("{x} is out of range; give frames a second above 0 and up to 1000"))),
    };
    let mut out = Flight {
        frames_per_second: root.read("frames_per_second", rate)?.unwrap_or(24.0),
        exposure: root.read("exposure", |n| n.positive())?,
        keys: Vec::new(),
    };
    for node in root.list("key")? {
        let next = key(&node, out.keys.last(), cameras, groups)?;
        out.keys.push(next);
    }
    let (Some(first), Some(last)) = (out.keys.first(), out.keys.last()) else {
        return Err(root.error("there are no key frames; write [[key]] with a time and a camera"));
    };
    let frames = (last.time - first.time) * out.frames_per_second;
    if frames.is_nan() || frames >= MAX_FRAMES as f64 {
        let what = format!("{frames:.0} frames are more than {MAX_FRAMES}; give fewer a second or less time");
        return Err(root.get("frames_per_second").map_or_else(|| root.error(&what), |n| n.error(&what)));
    }
    Ok(out)
}

fn key(
    node: &Node<'_>,
    before: Option<&Key>,
    cameras: &[Camera],
    groups: &[&str],
) -> Result<Key, InputError> {
    let t = node.table(&[["time", "camera", "stops", "lights"].as_slice(), &VIEW].concat())?;
    let time = t.need("time", "time = 2.5, in seconds")?;
    let seconds = time.number()?;
    if let Some(b) = before.filter(|b| seconds <= b.time) {
        return Err(
            time.error(format!("{seconds} s is not after {} s of the key before; give a later time", b.time))
        );
    }
    let stops = |n: Node<'_>| match n.number()? {
        x if x.abs() <= 30.0 => Ok(x),
        x => Err(n.error(format!("{x} is out of range; give stops from -30 to 30"))),
    };
    let kept = || before.map_or_else(|| vec![[1.0; 3]; groups.len()], |b| b.lights.clone());
    Ok(Key {
        time: seconds,
        camera: camera(&t, before, cameras)?,
        stops: t.read("stops", stops)?.unwrap_or(before.map_or(0.0, |b| b.stops)),
        lights: t.read("lights", |n| lights(&n, kept(), groups))?.unwrap_or_else(kept),
    })
}

fn camera(t: &Table<'_>, before: Option<&Key>, cameras: &[Camera]) -> Result<Camera, InputError> {
    let named = |n: Node<'_>| {
        let wanted = n.text()?;
        let names: Vec<&str> = cameras.iter().map(|c| c.name.as_str()).collect();
        cameras.iter().find(|c| c.name == wanted).cloned().ok_or_else(|| {
            n.error(format!("the scene has no camera '{wanted}'; {}", suggestion(wanted, &names)))
        })
    };
    let base = t.read("camera", named)?.or_else(|| before.map(|b| b.camera.clone()));
    let place = |key: &str, example: &str, known: Option<zonal_math::Vec3>| match (t.get(key), known) {
        (Some(n), _) => n.vector(),
        (None, Some(p)) => Ok(p),
        (None, None) => t.need(key, example)?.vector(),
    };
    let old = base.as_ref();
    let lens = old.map_or(Lens::default(), |c| c.lens);
    let camera = Camera {
        name: t.key.clone(),
        origin: place("origin", "origin = [x, y, z], or camera = \"NAME\"", old.map(|c| c.origin))?,
        target: place("target", "target = [x, y, z]", old.map(|c| c.target))?,
        up: t.read("up", |n| n.vector())?.or(old.map(|c| c.up)).unwrap_or(vec3(0.0, 0.0, 1.0)),
        fov: t.read("fov", fov)?.or(old.map(|c| c.fov)).unwrap_or(60.0),
        lens: Lens {
            aperture: t.read("aperture", aperture)?.unwrap_or(lens.aperture),
            focus: t.read("focus", |n| n.positive())?.or(lens.focus),
        },
    };
    camera.check().map_err(|e| wrong(t, &e))?;
    Ok(camera)
}

/// A camera that is none, at the key that its error names.
fn wrong(t: &Table<'_>, e: &SceneError) -> InputError {
    let key = e.key().rsplit('.').next().unwrap_or("");
    let what = format!("{}; change this value", e.what());
    t.get(key).map_or_else(|| t.error(&what), |n| n.error(&what))
}

fn lights(node: &Node<'_>, mut all: Vec<Bands>, groups: &[&str]) -> Result<Vec<Bands>, InputError> {
    for (name, factor) in node.any_table()?.entries() {
        let Some(k) = groups.iter().position(|g| *g == name) else {
            let hint = match groups.is_empty() {
                true => "it keeps none; solve the scene again".to_string(),
                false => suggestion(name, groups),
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

    fn read(text: &str) -> Result<Flight, InputError> {
        let camera = Camera {
            name: "door".into(),
            origin: vec3(1.0, 2.0, 3.0),
            target: vec3(0.0, 9.0, 3.0),
            up: vec3(0.0, 0.0, 1.0),
            fov: 50.0,
            lens: Lens { aperture: 0.1, focus: Some(4.0) },
        };
        let source = Source::new("f.toml", text);
        let document = source.parse()?;
        flight(&Table::root(&source, document.get_ref()), &[camera], &["sun", "lamp"])
    }

    #[test]
    fn what_a_key_leaves_out_stays() {
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
        assert_eq!(last.lights, [[0.5; 3], [1.0, 2.0, 3.0]]);
    }

    #[test]
    fn wrong_flights_are_refused_by_place_and_key() {
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
