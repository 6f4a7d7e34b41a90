//! Camera animations: frames are drawn, kept and redrawn; lights are scaled without a solve; wrong key frames are refused.

use crate::support;

use std::process::Command;
use support::{Folder, Parser, Program, refused, solution, text};

const KEY_FRAMES: &str = "frames_per_second = 2
[[key]]
time = 0
camera = 'door'
[[key]]
time = 1
target = [0, 0.2, 0.5]
lights = { 'room.x0' = 0.5 }
";

fn folder_with_keys() -> Folder {
    let f = Folder::new();
    f.put("room.npz", solution());
    f.put("keys.toml", KEY_FRAMES);
    f
}

const ARGS: [&str; 10] =
    ["render", "room.npz", "--animate", "keys.toml", "--size", "8x6", "--samples", "1", "-o", "out/frames"];

fn report(f: &Folder, more: &[&str]) -> serde_json::Value {
    serde_json::from_str(&f.done(&[ARGS.as_slice(), &["--json"], more].concat())).unwrap()
}

// Guards (pictures): frames of an animation are drawn once.
#[test]
fn frames_are_drawn_only_if_missing_or_changed() {
    let f = folder_with_keys();
    let first = report(&f, &[]);
    assert_eq!((&first["frames"], &first["drawn"]), (&3.into(), &3.into()), "{first}");
    let frames = ["out/frames/frame-00001.png", "out/frames/frame-00002.png", "out/frames/frame-00003.png"];
    let bytes = frames.map(|p| f.get(p));
    assert!(bytes.iter().all(|b| b.starts_with(b"\x89PNG")) && bytes[0] != bytes[2]);
    // All frames exist: none is drawn, on any number of threads.
    assert_eq!(report(&f, &["--threads", "1"])["drawn"], 0);
    // One frame is missing, one is truncated: these two are drawn again, with the same bytes.
    std::fs::remove_file(f.path().join(frames[0])).unwrap();
    f.put(frames[1], &bytes[1][..bytes[1].len() - 20]);
    let second = report(&f, &["--threads", "3"]);
    assert_eq!((&second["drawn"], &second["exposure"]), (&2.into(), &first["exposure"]));
    assert_eq!(frames.map(|p| f.get(p)), bytes);
    let message = f.done(&ARGS);
    assert!(
        message.contains("3 frames of 8×6") && message.contains("3 of them existed already"),
        "{message}"
    );
    // Other options change all frames.
    assert_eq!(report(&f, &["--bloom", "0.3"])["drawn"], 3);
    assert!(frames.iter().zip(&bytes).all(|(p, b)| f.get(p) != *b));
}

// Guards (pictures): lights of an animation scale as in `relight`.
/// A frame has the pixels of the relit solution at the same exposure.
#[test]
fn lights_are_scaled_as_by_relight() {
    let f = folder_with_keys();
    f.put(
        "keys.toml",
        "exposure = 0.05\n[[key]]\ntime = 0\ncamera = 'door'\nlights = { 'room.x0' = [0.5, 1, 2] }\n",
    );
    let frame = report(&f, &[]);
    assert_eq!(
        (&frame["frames"], &frame["exposure"], &frame["video"]),
        (&1.into(), &0.05.into(), &serde_json::Value::Null)
    );
    f.put("plain.toml", "exposure = 0.05\n[[key]]\ntime = 0\ncamera = 'door'\n");
    f.done(&["relight", "room.npz", "room.x0=0.5,1,2", "-o", "relit.npz"]);
    f.done(&[
        "render",
        "relit.npz",
        "--animate",
        "plain.toml",
        "--size",
        "8x6",
        "--samples",
        "1",
        "-o",
        "out/relit",
    ]);
    // The compressed pixels, which follow the text chunks.
    let pixels = |name: &str| {
        let bytes = f.get(name);
        let at = bytes.windows(4).position(|w| w == b"IDAT").unwrap();
        bytes[at..].to_vec()
    };
    assert_eq!(pixels("out/frames/frame-00001.png"), pixels("out/relit/frame-00001.png"));
}

#[test]
fn missing_ffmpeg_gives_the_command() {
    let f = folder_with_keys();
    let o = Command::new(env!("CARGO_BIN_EXE_zonal"))
        .args(ARGS)
        .current_dir(f.path())
        .env("PATH", "")
        .output()
        .unwrap();
    let message = text(&o.stdout);
    assert!(o.status.success(), "{}", text(&o.stderr));
    assert!(
        message.contains("ffmpeg is not installed") && message.contains("run in out/frames: ffmpeg -v error"),
        "{message}"
    );
    assert_eq!(std::fs::read_dir(f.path().join("out/frames")).unwrap().count(), 3);
}

#[test]
fn ffmpeg_encodes_a_video() {
    if Command::new("ffmpeg").arg("-version").output().is_err() {
        eprintln!("skipped: there is no ffmpeg");
        return;
    }
    let f = folder_with_keys();
    // Odd sides are padded.
    let odd = ARGS.map(|a| if a == "8x6" { "17x9" } else { a });
    let report: serde_json::Value =
        serde_json::from_str(&f.done(&[odd.as_slice(), &["--json"]].concat())).unwrap();
    let video = &report["video"];
    assert_eq!(video, "out/frames/animation.mp4");
    assert_eq!(&f.get("out/frames/animation.mp4")[4..8], b"ftyp");
    assert_eq!(std::fs::read_dir(f.path().join("out/frames")).unwrap().count(), 4);
}

#[test]
fn wrong_key_frames_are_refused_before_drawing() {
    let f = folder_with_keys();
    let animate = |path: &str, output: &str, named: &str| {
        refused(&f, Program, &["render", "room.npz", "--animate", path, "-o", output], named);
    };
    animate("none.toml", "out/frames", "none.toml");
    f.put("plain", "a file");
    for (output, named) in [
        ("plain", "plain: is a file"),
        ("missing/fly", "missing"),
        ("plain/fly", "plain"),
        ("out/x.png", "name one without this extension"),
        ("out/x.mp4", "name one without this extension"),
    ] {
        animate("keys.toml", output, named);
    }
    for (text, named) in [
        ("", "no key frames"),
        ("[[key]]\ntime = 0\ncamera = 'window'", "bad.toml:3:10: key[0].camera"),
        ("[[key]]\ntime = 0\ncamera = 'door'\nlights.sun = 1", "bad.toml:4:14: key[0].lights.sun"),
        // Halfway the camera is in its target.
        (
            "[[key]]\ntime = 0\norigin = [0.75, 0.5, 0.5]\ntarget = [0.25, 0.5, 0.5]\n[[key]]\ntime = 1\norigin = [-0.25, 0.5, 0.5]",
            "camera 'frame 13'.target",
        ),
        ("[[key", "TOML"),
    ] {
        f.put("bad.toml", text);
        animate("bad.toml", "out/frames", named);
    }
    f.done(&["relight", "room.npz", "room.x0=0", "-o", "dark.npz"]);
    refused(
        &f,
        Program,
        &["render", "dark.npz", "--animate", "keys.toml", "-o", "out/frames"],
        "scaled to zero",
    );
    for flag in ["--camera=door", "--aperture=0.1", "--focus=2"] {
        refused(&f, Parser, &[ARGS.as_slice(), &[flag]].concat(), flag.split('=').next().unwrap());
    }
}
