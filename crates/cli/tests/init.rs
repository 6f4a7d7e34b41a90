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
    assert_eq!(report["open_sides"], "file");
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

/// A sphere of radius 0.5 around (2, 1, 2.5) as `2 rings²` faces with normals outward; `first` vertices precede.
fn sphere(rings: usize, first: usize) -> String {
    let (mut out, wide) = (String::new(), 2 * rings);
    for i in 0..=rings {
        let (sine, cosine) = (std::f64::consts::PI * i as f64 / rings as f64).sin_cos();
        for k in 0..wide {
            let (s, c) = (std::f64::consts::TAU * k as f64 / wide as f64).sin_cos();
            out += &format!("v {} {} {}\n", 2.0 + 0.5 * sine * c, 1.0 + 0.5 * cosine, 2.5 + 0.5 * sine * s);
        }
    }
    out += "usemtl ball\n";
    for i in 0..rings {
        for k in 0..wide {
            let at = |i: usize, k: usize| first + 1 + i * wide + k % wide;
            out += &format!("f {} {} {}\n", at(i, k), at(i, k + 1), at(i + 1, k + 1));
            out += &format!("f {} {} {}\n", at(i, k), at(i + 1, k + 1), at(i + 1, k));
        }
    }
    out
}

/// The patch size that a scene file gives.
fn patch_size(f: &Folder, name: &str) -> f64 {
    let text = text(f, name);
    let line = text.lines().find_map(|l| l.strip_prefix("patch_size = ")).unwrap();
    line.split_whitespace().next().unwrap().parse().unwrap()
}

#[test]
fn a_fine_part_does_not_coarsen_the_others() {
    let f = Folder::new();
    f.put("room.obj", room(1.0));
    f.put("fine.obj", room(1.0) + &sphere(24, 16));
    json(&f, &["init", "room.obj", "--patches", "2000"]);
    let report = json(&f, &["init", "fine.obj", "--patches", "2000"]);
    let (without, with) = (patch_size(&f, "room.toml"), patch_size(&f, "fine.toml"));
    assert!(with < 1.1 * without, "{with} {without}");
    // The sizes of both parts are reported.
    let parts = report["patches_of_parts"].as_array().unwrap();
    let edge = |name: &str| {
        let part = parts.iter().find(|p| p["name"].as_str().unwrap().contains(name));
        part.unwrap_or_else(|| panic!("{name}: {parts:?}"))["edge_m"].as_f64().unwrap()
    };
    assert!(edge("ball") < 0.5 * edge("wall"), "{parts:?}");
    let said = f.done(&["init", "fine.obj", "--force"]);
    assert!(said.contains("patches: about") && said.contains("fine/ball"), "{said}");
}

#[test]
fn one_open_part_does_not_change_the_sides_of_others() {
    let f = Folder::new();
    // A sheet beside the block of the room.
    f.put("sheet.obj", room(1.0) + "v 3 0.5 3\nv 3.5 0.5 3\nv 3 0.5 3.5\nusemtl sheet\nf 17 18 19\n");
    let report = json(&f, &["init", "sheet.obj", "--patches", "400"]);
    assert_eq!(report["open_sides"], "both");
    let text = text(&f, "sheet.toml");
    assert!(text.contains("open_sides = \"both\"") && !text.contains("solid = false"), "{text}");
    let scene = zonal_io::input::read_scene(f.path().join("sheet.toml")).unwrap();
    let sides = |name: &str| {
        let part = format!("/{name}");
        scene.surfaces().iter().find(|s| s.name.contains(&part)).unwrap().sides
    };
    use zonal_scene::Sides::{Both, Front};
    assert_eq!(["wall", "block", "sheet"].map(sides), [Front, Front, Both]);
}

#[test]
fn lamps_that_light_little_do_not_replace_other_light() {
    let f = Folder::new();
    let diode = |edge: f64| {
        let (a, b) = (1.0, 1.0 + edge);
        format!(
            "mtllib a.mtl\nv {a} 2 {a}\nv {b} 2 {a}\nv {b} 2 {b}\nv {a} 2 {b}\nusemtl lamp\nf 17 18 19 20\n"
        )
    };
    f.put("a.mtl", "newmtl lamp\nKe 1 1 1\nnewmtl wall\nKd 0.5 0.5 0.5\nnewmtl block\nKd 0.5 0.5 0.5\n");
    f.put("diode.obj", room(1.0) + &diode(0.03));
    f.put("lamp.obj", room(1.0) + &diode(1.0));
    let report = json(&f, &["init", "diode.obj", "--patches", "400"]);
    let light = report["light"].as_str().unwrap();
    assert!(light.contains("that of the model") && light.contains("lamps below the ceiling"), "{light}");
    let said = text(&f, "diode.toml");
    assert!(said.contains("surface = \"diode/lamp\"") && said.contains("zonal-lamp-1"), "{said}");
    assert!(said.contains("# The light of the model"), "{said}");
    let report = json(&f, &["init", "lamp.obj", "--patches", "400"]);
    assert_eq!(report["light"], "that of the model");
    assert!(!text(&f, "lamp.toml").contains("zonal-lamp"));
}

/// A room of 10 × 4 × 10 m with y up, whose wall at x = 10 has a large window.
fn room_with_window() -> String {
    let mut out = String::new();
    let mut count = 0;
    let mut quad = |c: [[f64; 3]; 4]| {
        c.iter().for_each(|[x, y, z]| out.push_str(&format!("v {x} {y} {z}\n")));
        out.push_str(&format!("f {} {} {} {}\n", count + 1, count + 2, count + 3, count + 4));
        count += 4;
    };
    quad([[0.0, 0.0, 0.0], [0.0, 0.0, 10.0], [10.0, 0.0, 10.0], [10.0, 0.0, 0.0]]);
    quad([[0.0, 4.0, 0.0], [10.0, 4.0, 0.0], [10.0, 4.0, 10.0], [0.0, 4.0, 10.0]]);
    quad([[0.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 4.0, 10.0], [0.0, 0.0, 10.0]]);
    quad([[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [10.0, 4.0, 0.0], [0.0, 4.0, 0.0]]);
    quad([[0.0, 0.0, 10.0], [0.0, 4.0, 10.0], [10.0, 4.0, 10.0], [10.0, 0.0, 10.0]]);
    // Beside, below and above the window.
    for [z0, z1, y0, y1] in
        [[0.0, 1.5, 0.0, 4.0], [8.5, 10.0, 0.0, 4.0], [1.5, 8.5, 0.0, 0.3], [1.5, 8.5, 3.7, 4.0]]
    {
        quad([[10.0, y0, z0], [10.0, y0, z1], [10.0, y1, z1], [10.0, y1, z0]]);
    }
    out
}

#[test]
fn cameras_inside_stand_inside_where_walls_have_windows() {
    let f = Folder::new();
    f.put("room.obj", room_with_window());
    let report = json(&f, &["init", "room.obj", "--patches", "400", "--unit", "m", "--up", "y"]);
    assert_eq!(report["inside"], true, "{report}");
    let scene = zonal_io::input::read_scene(f.path().join("room.toml")).unwrap();
    let (low, high) = scene.bounds();
    for c in scene.cameras() {
        let within = (0..3).all(|k| c.origin[k] > low[k] && c.origin[k] < high[k]);
        assert!(within, "{} stands at {:?} in {low:?} to {high:?}", c.name, c.origin);
    }
    assert_eq!(scene.cameras().len(), 3);
}
