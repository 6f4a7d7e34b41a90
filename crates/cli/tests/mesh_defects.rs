//! Defects of meshes through the command: repeated faces, rooms inside out, needles, hostile repetitions.

use crate::support;

use support::Folder;

const VERTICES: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n";
/// The faces of a room, normals inward.
const ROOM: &str = "f 2 4 3 1\nf 7 8 6 5\nf 3 7 5 1\nf 6 8 4 2\nf 5 6 2 1\nf 4 8 7 3\n";

fn json(f: &Folder, args: &[&str]) -> serde_json::Value {
    serde_json::from_str(&f.done(&[args, &["--json"]].concat())).unwrap()
}

fn codes(report: &serde_json::Value) -> Vec<&str> {
    report["warnings"].as_array().unwrap().iter().map(|w| w["code"].as_str().unwrap()).collect()
}

#[test]
fn a_room_with_a_face_twice_is_the_closed_room() {
    let f = Folder::new();
    f.put("once.obj", format!("{VERTICES}{ROOM}"));
    f.put("twice.obj", format!("{VERTICES}{ROOM}f 7 8 6 5\n"));
    let power = |mesh: &str| {
        f.put(
            "s.toml",
            format!(
                "mode = 'thermal'\n[solve]\npatch_size = 0.5\n[[surface]]\nname = 'room'\nmesh = {{ file = '{mesh}' }}\nemissivity = 0.8\ntemperature = 300\n[[surface]]\nname = 'ball'\nbox = {{ min = [0.4, 0.4, 0.4], max = [0.6, 0.6, 0.6] }}\nemissivity = 0.7\ntemperature = 500\n"
            ),
        );
        let report = json(&f, &["solve", "s.toml", "-o", "out/s.npz", "--discretization-error", "false"]);
        let rows = report["heat"]["rows"].as_array().unwrap().clone();
        let room = rows.iter().find(|r| r["name"] == "room").expect("the room");
        let has_note = codes(&report).contains(&"repeated-faces");
        (room["net_power_W"].as_f64().unwrap(), has_note)
    };
    let (once, twice) = (power("once.obj"), power("twice.obj"));
    assert_eq!(once.0, twice.0);
    assert!((once.0 + 514.6).abs() < 10.0 && twice.1 && !once.1, "{once:?} {twice:?}");
    let check = json(&f, &["check", "s.toml"]);
    assert!(codes(&check).contains(&"repeated-faces"), "{check}");
    let init = json(&f, &["init", "twice.obj"]);
    let defects = init["topology"].as_array().unwrap();
    assert!(defects.iter().any(|d| d["defect"] == "repeated faces" && d["count"] == 1), "{init}");
    assert_eq!((init["parts"]["rooms"].as_u64(), init["parts"]["open"].as_u64()), (Some(1), Some(0)));
}

// Guards (numbers): solids, cavities and rooms are classified as by brute force; no emitting surface and no medium is dropped silently; medium
//     outside closed rooms has no zones; coincident surfaces and rooms inside out are reported.
#[test]
fn a_room_inside_out_is_reported_with_its_medium() {
    let f = Folder::new();
    let outward: String = ROOM
        .lines()
        .map(|l| {
            let k: Vec<&str> = l.split(' ').collect();
            format!("f {} {} {} {}\n", k[4], k[3], k[2], k[1])
        })
        .collect();
    f.put("room.obj", format!("{VERTICES}{outward}"));
    f.put("s.toml", "mode = 'thermal'\n[solve]\npatch_size = 0.5\n[[surface]]\nname = 'room'\nmesh = { file = 'room.obj' }\nemissivity = 0.8\ntemperature = 400\n[medium]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\ncells = [2, 2, 2]\nextinction = 0.5\ntemperature = 900\n");
    assert!(codes(&json(&f, &["check", "s.toml"])).contains(&"inverted-room"));
    let solve = ["solve", "s.toml", "-o", "out/s.npz", "--discretization-error", "false"];
    let report = json(&f, &solve);
    let warnings = report["warnings"].as_array().unwrap();
    let found = warnings.iter().find(|w| w["code"] == "inverted-room").expect("a warning");
    assert_eq!(found["severity"], "warning");
    assert_eq!(f.zonal(&[&solve[..], &["--strict"]].concat()).status.code(), Some(1));
}

#[test]
fn needles_are_checked_or_refused() {
    let f = Folder::new();
    let scene = |length: &str, size: &str| {
        f.put("s.toml", format!("[solve]\npatch_size = {size}\n[[surface]]\nname = 'needle'\ntriangle = {{ corners = [[0, 0, 1], [1, 0, 1], [1, {length}, 1]] }}\n[[light]]\nkind = 'sky'\nradiance = 1\n"));
    };
    scene("3e3", "1");
    let patches = json(&f, &["check", "s.toml"])["patches"].as_u64().unwrap();
    // Both sides of about two pieces a metre.
    assert!((6_000..14_000).contains(&patches), "{patches}");
    scene("1e7", "1e-3");
    for args in [&["check", "s.toml"][..], &["solve", "s.toml", "-o", "out/s.npz"]] {
        let o = f.zonal(args);
        let message = support::text(&o.stderr);
        assert_eq!(o.status.code(), Some(2), "{message}");
        assert!(message.contains("surface 'needle'") && message.contains("larger patch_size"), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}
