//! Wrong scenes with `check` and `solve`: exit code 2, one line that names the scene file, and no output.
//!
//! Texts of messages are tested in `crates/io/tests/read_wrong.rs`.

use crate::support;

use support::{Folder, Parser, Program, ROOM, glb, npy, refused, solution};

const SQUARE: &str = "[[surface]]\nname='s'\nrectangle={origin=[0,0,0],edge1=[1,0,0],edge2=[0,1,0]}\n";
const SPACE: &str = "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\n";

/// Title and text of a scene, and a word that its refusal must contain.
type WrongScene = (&'static str, String, &'static str);

/// A scene with a square.
fn with(more: &str) -> String {
    format!("{SQUARE}{more}")
}

/// A scene with a square and a medium.
fn medium(more: &str) -> String {
    format!("{SQUARE}{SPACE}{more}")
}

fn wrong_scenes() -> Vec<WrongScene> {
    [wrong_texts(), wrong_values(), wrong_files()].concat()
}

fn wrong_texts() -> Vec<WrongScene> {
    let deep = |open: &str, close: &str| format!("a = {}{}", open.repeat(200_000), close.repeat(200_000));
    vec![
        ("empty text", String::new(), "empty"),
        ("only a name", "name='x'".into(), "empty"),
        ("cut short", ROOM[..ROOM.len() / 2].into(), "TOML"),
        ("a NUL byte", "name='a\0b'".into(), ":1:"),
        ("deep lists", deep("[", "]"), ":1:"),
        ("deep tables", deep("{a=", "}"), ":1:"),
        ("deep keys", format!("{}a=1", "a.".repeat(200_000)), ":1:"),
        ("deep header", format!("[{}a]", "a.".repeat(200_000)), ":1:"),
        ("unknown key", with("reflectanse=0.5"), "reflectance"),
        ("unknown table", with("[wibble]\nx=1"), "wibble"),
        ("text for a number", with("reflectance='grey'"), "reflectance"),
        ("number for a text", "name=3".into(), "name"),
        ("table for a list", "[surface]\nname='s'".into(), "surface"),
    ]
}

fn wrong_values() -> Vec<WrongScene> {
    vec![
        ("NaN", with("reflectance=nan"), "reflectance"),
        ("infinite corner", with("").replace("[1,0,0]", "[inf,0,0]"), "edge1"),
        ("huge corner", with("").replace("[1,0,0]", "[1e300,0,0]"), "1"),
        ("reflectance above 1", with("reflectance=1.5"), "reflectance"),
        ("negative emission", with("emission=-1"), "emission"),
        ("two of a name", with(SQUARE), "rename"),
        ("no area", with("").replace("[0,1,0]", "[2,0,0]"), "area"),
        ("too many patches", with("patch_size=1e-9"), "patch"),
        ("negative patch size", with("[solve]\npatch_size=-1"), "patch_size"),
        ("tolerance of 0", with("[solve]\ntolerance=0"), "tolerance"),
        ("negative extinction", medium("cells=[2,2,2]\nextinction=-1"), "extinction"),
        ("albedo above 1", medium("cells=[2,2,2]\nextinction=1\nalbedo=1.1"), "albedo"),
        ("10^12 cells", medium("cells=[10000,10000,10000]\nextinction=1"), "cells"),
        ("cells beyond 64 bits", medium("cells=[4000000000,4000000000,4000000000]\nextinction=1"), "cells"),
        ("cells of no size", medium("cell_size=0\nextinction=1"), "cell_size"),
        ("no cells", medium("extinction=1"), "cell"),
        ("swapped corners", medium("cells=[2,2,2]\nextinction=1").replace("max=[1,", "max=[-1,"), "max"),
        (
            "pane without thickness",
            "[[pane]]\npolygon=[[0,0,0],[1,0,0],[1,1,0]]\nextinction=1".into(),
            "thickness",
        ),
        (
            "negative thickness",
            "[[pane]]\npolygon=[[0,0,0],[1,0,0],[1,1,0]]\nextinction=1\nthickness=-1".into(),
            "thickness",
        ),
        (
            "sun without a direction",
            with("[[light]]\nkind='sun'\ndirection=[0,0,0]\nirradiance=1"),
            "direction",
        ),
        ("emitter unknown", with("[[light]]\nkind='emitter'\nsurface='t'"), "'t'"),
        ("camera in its target", with("[[camera]]\norigin=[0,0,0]\ntarget=[0,0,0]"), "target"),
    ]
}

fn wrong_files() -> Vec<WrongScene> {
    let density = |file: &str| {
        medium(&format!(
            "cells=[2,2,2]\n[[medium.region]]\ndensity={{file='{file}',min=[0,0,0],max=[1,1,1]}}"
        ))
    };
    let mesh = |file: &str| format!("[[surface]]\nname='m'\nmesh={{file='{file}'}}\n");
    vec![
        ("missing mesh", mesh("none.obj"), "none.obj"),
        ("mesh without area", mesh("flat.obj"), "flat.obj"),
        ("empty mesh", mesh("empty.obj"), "empty.obj"),
        ("OBJ index", mesh("index.obj"), "index.obj"),
        ("OBJ number", mesh("number.obj"), "number.obj"),
        ("folder as OBJ", mesh("out"), "out"),
        ("GLB cut short", mesh("short.glb"), "short.glb"),
        ("GLB of another kind", mesh("magic.glb"), "magic.glb"),
        ("GLB without JSON", mesh("words.glb"), "words.glb"),
        ("GLB with deep JSON", mesh("deep.glb"), "deep.glb"),
        ("cycle of glTF nodes", mesh("circle.gltf"), "circle.gltf"),
        ("mesh of an unknown kind", mesh("mesh.step"), "mesh.step"),
        ("missing array", density("none.npy"), "none.npy"),
        ("array of 8 petabytes", density("huge.npy"), "huge.npy"),
        ("array beyond 64 bits", density("beyond.npy"), "beyond.npy"),
        ("array cut short", density("short.npy"), "short.npy"),
        ("array of objects", density("object.npy"), "object.npy"),
        ("array of NaN", density("nan.npy"), "nan.npy"),
        ("array with a wild header", density("wild.npy"), "wild.npy"),
        ("missing picture", with("texture='none.png'"), "none.png"),
        ("other file as picture", with("texture='index.obj'"), "index.obj"),
        ("picture of 4 gigapixels", with("texture='bomb.png'"), "bomb.png"),
    ]
}

fn put_hostile_files(f: &Folder) {
    f.put("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    f.put("empty.obj", "# nothing\n");
    f.put("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n");
    f.put("number.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    f.put("mesh.step", "ISO-10303-21;");
    let valid = glb(r#"{"asset":{"version":"2.0"}}"#);
    f.put("short.glb", &valid[..valid.len() - 3]);
    f.put("magic.glb", b"PK\x03\x04 is a zip, not a GLB of any version");
    f.put("words.glb", glb("these are words"));
    f.put("deep.glb", glb(&format!(r#"{{"asset":{{"version":"2.0"}},"extras":{}}}"#, "[".repeat(100_000))));
    f.put(
        "circle.gltf",
        r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"children":[1]},{"children":[0]}]}"#,
    );
    f.put("huge.npy", npy("<f8", "(100000, 100000, 100000)", &[0; 64]));
    f.put("beyond.npy", npy("<f8", "(4294967296, 4294967296, 4294967296)", &[0; 64]));
    f.put("short.npy", npy("<f8", "(2, 2, 2)", &[0; 63]));
    f.put("object.npy", npy("|O", "(2, 2, 2)", &[0; 64]));
    f.put("nan.npy", npy("<f8", "(2, 2, 2)", &f64::NAN.to_le_bytes().repeat(8)));
    f.put("wild.npy", npy("<f8", "(2, -2, 2", &[0; 64]));
    f.put(
        "bomb.png",
        [b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\xff\xff\0\0\xff\xff\x08\x02\0\0\0".as_slice(), &[0; 40]]
            .concat(),
    );
}

// Guards (files): bad input is an `Err` that names file, place and remedy in one line; the command ends with 2.
#[test]
fn check_refuses_wrong_scenes() {
    let f = Folder::new();
    put_hostile_files(&f);
    for (title, scene, named) in wrong_scenes() {
        println!("{title}");
        f.put("wrong.toml", scene);
        refused(&f, Program, &["check", "wrong.toml"], "wrong.toml");
        refused(&f, Program, &["--json", "check", "wrong.toml"], named);
    }
}

// Guards (files): every file is written beside its target and renamed when complete; a failure leaves the old file and nothing else.
#[test]
fn solve_refuses_wrong_scenes() {
    let f = Folder::new();
    put_hostile_files(&f);
    f.put("out/kept.npz", "an earlier solution");
    for (title, scene, _) in wrong_scenes() {
        println!("{title}");
        f.put("wrong.toml", scene);
        refused(&f, Program, &["solve", "wrong.toml", "-o", "out/x.npz"], "wrong.toml");
        refused(&f, Program, &["solve", "wrong.toml", "-o", "out/kept.npz"], "wrong.toml");
    }
}

#[test]
fn files_other_than_scenes_are_refused() {
    let f = Folder::new();
    f.put("latin.toml", b"name = 'caf\xe9'");
    f.put("room.npz", solution());
    for command in [["check"].as_slice(), &["solve", "-o", "out/x.npz"]] {
        for (file, named) in
            [("none.toml", "none.toml"), ("out", "out"), ("latin.toml", "UTF-8"), ("room.npz", "room.npz")]
        {
            refused(&f, Program, &[command, &[file]].concat(), named);
        }
        refused(&f, Parser, command, "<SCENE>");
        refused(&f, Parser, &[command, &[""]].concat(), "<SCENE>");
        refused(&f, Parser, &[command, &["a.toml", "b.toml"]].concat(), "b.toml");
    }
}

/// Finite numbers whose squares or cubes overflow.
#[test]
fn scene_values_out_of_range_are_refused() {
    let f = Folder::new();
    for (from, to, named) in [
        ("extinction = 0.5", "extinction = 1e300", "extinction"),
        ("emission = 100", "emission = 1e308", "emission"),
        ("[1, 1, 1]", "[1e150, 1e150, 1e150]", "max"),
    ] {
        f.put("wrong.toml", ROOM.replace(from, to).replace("patch_size = 1.0", "patch_size = 1e150"));
        refused(&f, Program, &["check", "wrong.toml"], named);
        refused(&f, Program, &["solve", "wrong.toml", "-o", "out/x.npz"], named);
    }
}
