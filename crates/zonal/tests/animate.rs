//! Flights: frames are drawn, kept and drawn again where they must be; lights turn without a solve; wrong flights are refused.

mod support;

use std::process::Command;
use support::{Folder, Parser, Program, refused, solution, text};

const FLIGHT: &str = "frames_per_second = 2
[[key]]
time = 0
camera = 'door'
[[key]]
time = 1
target = [0, 0.2, 0.5]
lights = { 'room.x0' = 0.5 }
";

fn folder() -> Folder {
    let f = Folder::new();
    f.put("room.npz", solution());
    f.put("flight.toml", FLIGHT);
    f
}

const ARGS: [&str; 10] =
    ["render", "room.npz", "--animate", "flight.toml", "--size", "8x6", "--samples", "1", "-o", "out/fly"];

fn report(f: &Folder, more: &[&str]) -> serde_json::Value {
    serde_json::from_str(&f.done(&[ARGS.as_slice(), &["--json"], more].concat())).unwrap()
}

#[test]
fn frames_are_drawn_once_and_again_where_they_must_be() {
    let f = folder();
    let first = report(&f, &[]);
    assert_eq!((&first["frames"], &first["drawn"]), (&3.into(), &3.into()), "{first}");
    let frames = ["out/fly/frame-00001.png", "out/fly/frame-00002.png", "out/fly/frame-00003.png"];
    let bytes = frames.map(|p| f.get(p));
    assert!(bytes.iter().all(|b| b.starts_with(b"\x89PNG")) && bytes[0] != bytes[2]);
    // All there: nothing is drawn, on any number of threads.
    assert_eq!(report(&f, &["--threads", "1"])["drawn"], 0);
    // One is gone, one is torn: these two, to the same bytes.
    std::fs::remove_file(f.path().join(frames[0])).unwrap();
    f.put(frames[1], &bytes[1][..bytes[1].len() - 20]);
    let again = report(&f, &["--threads", "3"]);
    assert_eq!((&again["drawn"], &again["exposure"]), (&2.into(), &first["exposure"]));
    assert_eq!(frames.map(|p| f.get(p)), bytes);
    let said = f.done(&ARGS);
    assert!(said.contains("3 frames of 8×6") && said.contains("3 of them were there already"), "{said}");
    // Another look is another animation.
    assert_eq!(report(&f, &["--bloom", "0.3"])["drawn"], 3);
    assert!(frames.iter().zip(&bytes).all(|(p, b)| f.get(p) != *b));
}

/// The last frame is the picture of the relit solution at the same exposure, but for what a file says of itself.
#[test]
fn lights_turn_as_in_relight() {
    let f = folder();
    f.put(
        "flight.toml",
        "exposure = 0.05\n[[key]]\ntime = 0\ncamera = 'door'\nlights = { 'room.x0' = [0.5, 1, 2] }\n",
    );
    let fly = report(&f, &[]);
    assert_eq!(
        (&fly["frames"], &fly["exposure"], &fly["video"]),
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
    // The compressed pixels, which stand behind all that a file says of itself.
    let pixels = |name: &str| {
        let bytes = f.get(name);
        let at = bytes.windows(4).position(|w| w == b"IDAT").unwrap();
        bytes[at..].to_vec()
    };
    assert_eq!(pixels("out/fly/frame-00001.png"), pixels("out/relit/frame-00001.png"));
}

#[test]
fn without_ffmpeg_it_says_what_to_run() {
    let f = folder();
    let o = Command::new(env!("CARGO_BIN_EXE_zonal"))
        .args(ARGS)
        .current_dir(f.path())
        .env("PATH", "")
        .output()
        .unwrap();
    let said = text(&o.stdout);
    assert!(o.status.success(), "{}", text(&o.stderr));
    assert!(
        said.contains("ffmpeg is not at hand") && said.contains("run in out/fly: ffmpeg -v error"),
        "{said}"
    );
    assert_eq!(std::fs::read_dir(f.path().join("out/fly")).unwrap().count(), 3);
}

#[test]
fn with_ffmpeg_there_is_a_video() {
    if Command::new("ffmpeg").arg("-version").output().is_err() {
        eprintln!("skipped: there is no ffmpeg");
        return;
    }
    let f = folder();
    // Odd sides too.
    let odd = ARGS.map(|a| if a == "8x6" { "17x9" } else { a });
    let report: serde_json::Value =
        serde_json::from_str(&f.done(&[odd.as_slice(), &["--json"]].concat())).unwrap();
    let video = &report["video"];
    assert_eq!(video, "out/fly/animation.mp4");
    assert_eq!(&f.get("out/fly/animation.mp4")[4..8], b"ftyp");
    assert_eq!(std::fs::read_dir(f.path().join("out/fly")).unwrap().count(), 4);
}

#[test]
fn wrong_flights_are_refused_before_the_work() {
    let f = folder();
    let animate = |path: &str, output: &str, named: &str| {
        refused(&f, Program, &["render", "room.npz", "--animate", path, "-o", output], named);
    };
    animate("none.toml", "out/fly", "none.toml");
    f.put("plain", "a file");
    for (output, named) in [
        ("plain", "plain: is a file"),
        ("missing/fly", "missing"),
        ("plain/fly", "plain"),
        ("out/x.png", "name one without this ending"),
        ("out/x.mp4", "name one without this ending"),
    ] {
        animate("flight.toml", output, named);
    }
    for (text, named) in [
        ("", "no key frames"),
        ("[[key]]\ntime = 0\ncamera = 'window'", "bad.toml:3:10: key[0].camera"),
        ("[[key]]\ntime = 0\ncamera = 'door'\nlights.sun = 1", "bad.toml:4:14: key[0].lights.sun"),
        // Half-way the camera stands where it looks.
        (
            "[[key]]\ntime = 0\norigin = [0.75, 0.5, 0.5]\ntarget = [0.25, 0.5, 0.5]\n[[key]]\ntime = 1\norigin = [-0.25, 0.5, 0.5]",
            "camera 'frame 13'.target",
        ),
        ("[[key", "TOML"),
    ] {
        f.put("bad.toml", text);
        animate("bad.toml", "out/fly", named);
    }
    f.done(&["relight", "room.npz", "room.x0=0", "-o", "dark.npz"]);
    refused(&f, Program, &["render", "dark.npz", "--animate", "flight.toml", "-o", "out/fly"], "put out");
    for flag in ["--camera=door", "--aperture=0.1", "--focus=2"] {
        refused(&f, Parser, &[ARGS.as_slice(), &[flag]].concat(), flag.split('=').next().unwrap());
    }
}
