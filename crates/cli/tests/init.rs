//! `zonal init`: scenes for mesh files that solve at once; cameras, turntables and quality.

use crate::support;

use support::{Folder, Parser, Program, refused};

/// A closed room of 4 × 5 × 3 in metres with normals inward and y up, and a block in it with normals outward.
fn room(unit: f64) -> String {
    let mut out = String::new();
    let mut corners = |low: [f64; 3], high: [f64; 3]| {
        for k in 0..8 {
            let at = |a: usize| unit * if k >> a & 1 == 0 { low[a] } else { high[a] };
            out.push_str(&format!("v {} {} {}\n", at(0), at(1), at(2)));
        }
    };
    corners([0.0; 3], [4.0, 3.0, 5.0]);
    corners([1.5, 0.0, 2.0], [2.0, 1.0, 2.5]);
    // Outward faces of a box with the corners 1 to 8.
    let faces = [[1, 5, 7, 3], [2, 4, 8, 6], [1, 2, 6, 5], [3, 7, 8, 4], [1, 3, 4, 2], [5, 6, 8, 7]];
    out.push_str("usemtl wall\n");
    for f in faces {
        out.push_str(&format!("f {} {} {} {}\n", f[3], f[2], f[1], f[0]));
    }
    out.push_str("usemtl block\n");
    for f in faces {
        out.push_str(&format!("f {} {} {} {}\n", f[0] + 8, f[1] + 8, f[2] + 8, f[3] + 8));
    }
    out
}

fn json(f: &Folder, args: &[&str]) -> serde_json::Value {
    serde_json::from_str(&f.done(&[args, &["--json"]].concat())).unwrap()
}

#[test]
fn a_closed_room_gets_lamps_cameras_inside_and_solves() {
    let f = Folder::new();
    f.put("room.obj", room(1.0));
    let report = json(&f, &["init", "room.obj", "--patches", "400"]);
    assert_eq!((report["up"].as_str(), report["unit_m"].as_f64()), (Some("y"), Some(1.0)));
    assert_eq!((report["parts"]["rooms"].as_u64(), report["parts"]["solids"].as_u64()), (Some(1), Some(1)));
    assert_eq!(report["both_sides"], false);
    assert_eq!(report["light"], "lamps below the ceiling");
    assert_eq!(report["cameras"], serde_json::json!(["along", "across", "above"]));
    let bounds = &report["bounds_m"];
    let [low, high] = [0, 1].map(|k| bounds[k][2].as_f64().unwrap());
    assert!(low.abs() < 1e-12 && (high - 3.0).abs() < 1e-12, "{low} {high}");
    f.done(&["solve", "room.toml", "-o", "room.npz", "--quality", "draft"]);
    for camera in ["along", "across", "above"] {
        let png = format!("{camera}.png");
        f.done(&[
            "render",
            "room.npz",
            "--camera",
            camera,
            "--size",
            "32x24",
            "-o",
            &png,
            "--quality",
            "draft",
        ]);
        // From inside, every pixel shows a wall.
        let exr = format!("{camera}.exr");
        f.done(&["render", "room.npz", "--camera", camera, "--size", "32x24", "-o", &exr]);
        let picture = zonal_io::output::read_exr(&f.path().join(&exr)).unwrap();
        assert!(picture.pixels.iter().all(|p| p[0] > 0.0), "{camera}");
    }
}

#[test]
fn units_and_axes_are_guessed_or_given() {
    let f = Folder::new();
    f.put("room.obj", room(1000.0));
    let report = json(&f, &["init", "room.obj", "-o", "a.toml"]);
    assert_eq!(report["unit_m"].as_f64(), Some(0.01));
    let report = json(&f, &["init", "room.obj", "-o", "b.toml", "--unit", "mm", "--up", "z"]);
    let high = |k: usize| report["bounds_m"][1][k].as_f64().unwrap();
    assert!((high(0) - 4.0).abs() < 1e-9 && (high(1) - 3.0).abs() < 1e-9 && (high(2) - 5.0).abs() < 1e-9);
    assert!(text(&f, "b.toml").contains("scale = 0.001"));
}

fn text(f: &Folder, name: &str) -> String {
    String::from_utf8(f.get(name)).unwrap()
}

#[test]
fn a_body_is_seen_from_outside_in_sunlight() {
    let f = Folder::new();
    let block: String =
        room(1.0).lines().filter(|l| l.starts_with('v')).skip(8).map(|l| format!("{l}\n")).collect();
    f.put("block.obj", format!("{block}f 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\nf 1 3 4 2\nf 5 6 8 7\n"));
    let report = json(&f, &["init", "block.obj", "--patches", "100"]);
    assert_eq!(report["light"], "sun and sky");
    assert_eq!(report["cameras"], serde_json::json!(["corner", "front", "side"]));
    f.done(&["solve", "block.toml", "-o", "block.npz"]);
    f.done(&["render", "block.npz", "-o", "block.png", "--size", "24x18"]);
}

#[test]
fn the_scene_names_the_model_relative_to_its_folder() {
    let f = Folder::new();
    f.put("out/my \"room\".obj", room(1.0));
    f.done(&["init", "out/my \"room\".obj", "-o", "scene.toml"]);
    assert!(text(&f, "scene.toml").contains("file = \"out/my \\\"room\\\".obj\""));
    f.done(&["check", "scene.toml"]);
    refused(&f, Program, &["init", "out/my \"room\".obj", "-o", "scene.toml"], "--force");
    f.done(&["init", "out/my \"room\".obj", "-o", "scene.toml", "--force"]);
    refused(&f, Program, &["init", "missing.obj"], "missing.obj");
    refused(&f, Parser, &["init", "a.obj", "--unit", "mile"], "inch");
}

#[test]
fn pictures_from_any_view() {
    let f = Folder::new();
    f.put("room.npz", support::solution());
    let view = ["render", "room.npz", "--size", "16x12", "--samples", "1"];
    let with = |more: &[&str]| f.done(&[&view, more].concat());
    with(&["--from", "0.2,0.2,0.4", "--look-at", "0.9,0.9,0.3", "--fov", "80", "-o", "a.png"]);
    with(&["--camera", "overview", "-o", "b.png"]);
    f.put(
        "views.toml",
        "[[camera]]\nname = \"door\"\norigin = [0.2, 0.2, 0.4]\ntarget = [0.9, 0.9, 0.3]\nfov = 80\n",
    );
    with(&["--camera-file", "views.toml", "--camera", "door", "-o", "c.png"]);
    // The same view has the same picture, whether by numbers or from a file.
    assert_eq!(f.get("a.png"), f.get("c.png"));
    assert_ne!(f.get("a.png"), f.get("b.png"));
    with(&["--from", "0.2,0.2,0.4", "--look-at", "0.5,0.5,0.4", "--turntable", "3", "-o", "turn"]);
    let frames = f.listing().into_keys().filter(|p| p.starts_with(f.path().join("turn")));
    assert_eq!(frames.filter(|p| p.extension().is_some_and(|e| e == "png")).count(), 3);
    let refused_view = |more: &[&str], named: &str| {
        refused(&f, Program, &[&view, more, &["-o", "x.png"]].concat(), named);
    };
    refused_view(&["--camera", "nave"], "overview");
    refused_view(&["--from", "1,1,1", "--look-at", "1,1,1"], "--look-at");
    refused_view(&["--from", "1,1,1", "--look-at", "1,1,0"], "--up");
    refused_view(&["--fov", "190"], "--fov");
    refused_view(&["--camera-file", "none.toml"], "none.toml");
    refused(&f, Parser, &[&view[..], &["--from", "1,2", "-o", "x.png"]].concat(), "three numbers");
}
