//! Wrong inputs of the command: exit code 2, one line that names the file or the flag, and no output, whole or part.
//!
//! What a message says beyond that is tested where it is written (`crates/io/tests/read_wrong.rs`).

mod support;

use support::{COLUMNS, Folder, ROOM, VOXELS, glb, npy, solution, text};

/// Who refuses: the program, in one line, or the parser of the command line, which adds the usage.
#[derive(Clone, Copy, PartialEq)]
enum By {
    Program,
    Parser,
}
use By::{Parser, Program};

/// Runs a command that must be refused with a message that contains `named`.
fn refused(f: &Folder, by: By, args: &[&str], named: &str) {
    let before = f.listing();
    let o = f.zonal(args);
    let command = format!("zonal {}", args.join(" "));
    let (out, err) = (text(&o.stdout), text(&o.stderr));
    assert_eq!(
        o.status.code(),
        Some(2),
        "{command}: {:?}\n{out}\n{err}",
        o.status
    );
    assert!(err.starts_with("error: "), "{command}: {err}");
    assert!(
        by == Parser || err.lines().count() == 1,
        "{command}: several lines:\n{err}"
    );
    assert!(err.contains(named), "{command}: '{named}' is not named in\n{err}");
    assert!(err.len() < 2000, "{command}: a message of {} bytes", err.len());
    assert!(out.is_empty(), "{command}: on standard output:\n{out}");
    let after = f.listing();
    let touched: Vec<_> = after
        .iter()
        .filter(|(k, v)| before.get(*k) != Some(v))
        .map(|e| e.0)
        .collect();
    assert!(
        touched.is_empty() && before.len() == after.len(),
        "{command}: left behind or changed: {touched:?}"
    );
}

fn table(f: &Folder, cases: &[(By, &[&str], &str)]) {
    for (by, args, named) in cases {
        refused(f, *by, args, named);
    }
}

const SQUARE: &str = "[[surface]]\nname='s'\nrectangle={origin=[0,0,0],edge1=[1,0,0],edge2=[0,1,0]}\n";
const SPACE: &str = "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\n";

/// Scene texts, and what their refusal must name beside the file.
fn wrong_scenes() -> Vec<(&'static str, String, &'static str)> {
    let with = |more: &str| format!("{SQUARE}{more}");
    let medium = |more: &str| format!("{SQUARE}{SPACE}{more}");
    let density = |file: &str| {
        medium(&format!(
            "cells=[2,2,2]\n[[medium.region]]\ndensity={{file='{file}',min=[0,0,0],max=[1,1,1]}}"
        ))
    };
    let mesh = |file: &str| format!("[[surface]]\nname='m'\nmesh={{file='{file}'}}\n");
    let deep = |open: &str, close: &str| format!("a = {}{}", open.repeat(200_000), close.repeat(200_000));
    vec![
        ("nothing", String::new(), "empty"),
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
        ("NaN", with("reflectance=nan"), "reflectance"),
        (
            "infinite corner",
            with("").replace("[1,0,0]", "[inf,0,0]"),
            "edge1",
        ),
        ("huge corner", with("").replace("[1,0,0]", "[1e300,0,0]"), "1"),
        ("reflectance above 1", with("reflectance=1.5"), "reflectance"),
        ("negative emission", with("emission=-1"), "emission"),
        ("two of a name", with(SQUARE), "rename"),
        ("no area", with("").replace("[0,1,0]", "[2,0,0]"), "area"),
        ("too many patches", with("patch_size=1e-9"), "patch"),
        (
            "negative patch size",
            with("[solve]\npatch_size=-1"),
            "patch_size",
        ),
        ("tolerance of 0", with("[solve]\ntolerance=0"), "tolerance"),
        (
            "negative extinction",
            medium("cells=[2,2,2]\nextinction=-1"),
            "extinction",
        ),
        (
            "albedo above 1",
            medium("cells=[2,2,2]\nextinction=1\nalbedo=1.1"),
            "albedo",
        ),
        (
            "10^12 cells",
            medium("cells=[10000,10000,10000]\nextinction=1"),
            "cells",
        ),
        (
            "cells beyond 64 bits",
            medium("cells=[4000000000,4000000000,4000000000]\nextinction=1"),
            "cells",
        ),
        (
            "cells of no size",
            medium("cell_size=0\nextinction=1"),
            "cell_size",
        ),
        ("no cells", medium("extinction=1"), "cell"),
        (
            "space turned round",
            medium("cells=[2,2,2]\nextinction=1").replace("max=[1,", "max=[-1,"),
            "max",
        ),
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
            "sun from nowhere",
            with("[[light]]\nkind='sun'\ndirection=[0,0,0]\nirradiance=1"),
            "direction",
        ),
        (
            "emitter unknown",
            with("[[light]]\nkind='emitter'\nsurface='t'"),
            "'t'",
        ),
        (
            "camera in its target",
            with("[[camera]]\norigin=[0,0,0]\ntarget=[0,0,0]"),
            "target",
        ),
        ("no such mesh", mesh("none.obj"), "none.obj"),
        ("mesh without area", mesh("flat.obj"), "flat.obj"),
        ("mesh of nothing", mesh("empty.obj"), "empty.obj"),
        ("OBJ index", mesh("index.obj"), "index.obj"),
        ("OBJ number", mesh("number.obj"), "number.obj"),
        ("OBJ that is a folder", mesh("out"), "out"),
        ("GLB cut short", mesh("short.glb"), "short.glb"),
        ("GLB of another kind", mesh("magic.glb"), "magic.glb"),
        ("GLB without JSON", mesh("words.glb"), "words.glb"),
        ("GLB with deep JSON", mesh("deep.glb"), "deep.glb"),
        ("glTF nodes in a circle", mesh("circle.gltf"), "circle.gltf"),
        ("mesh of an unknown kind", mesh("mesh.step"), "mesh.step"),
        ("no such array", density("none.npy"), "none.npy"),
        ("array of 8 petabytes", density("huge.npy"), "huge.npy"),
        ("array beyond 64 bits", density("beyond.npy"), "beyond.npy"),
        ("array cut short", density("short.npy"), "short.npy"),
        ("array of objects", density("object.npy"), "object.npy"),
        ("array of NaN", density("nan.npy"), "nan.npy"),
        ("array with a wild header", density("wild.npy"), "wild.npy"),
        ("no such picture", with("texture='none.png'"), "none.png"),
        ("picture that is none", with("texture='index.obj'"), "index.obj"),
        ("picture of 4 gigapixels", with("texture='bomb.png'"), "bomb.png"),
    ]
}

fn hostile_files(f: &Folder) {
    f.put("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    f.put("empty.obj", "# nothing\n");
    f.put(
        "index.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n",
    );
    f.put("number.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    f.put("mesh.step", "ISO-10303-21;");
    let sound = glb(r#"{"asset":{"version":"2.0"}}"#);
    f.put("short.glb", &sound[..sound.len() - 3]);
    f.put("magic.glb", b"PK\x03\x04 is a zip, not a GLB of any version");
    f.put("words.glb", glb("these are words"));
    f.put(
        "deep.glb",
        glb(&format!(
            r#"{{"asset":{{"version":"2.0"}},"extras":{}}}"#,
            "[".repeat(100_000)
        )),
    );
    f.put(
        "circle.gltf",
        r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"children":[1]},{"children":[0]}]}"#,
    );
    f.put("huge.npy", npy("<f8", "(100000, 100000, 100000)", &[0; 64]));
    f.put(
        "beyond.npy",
        npy("<f8", "(4294967296, 4294967296, 4294967296)", &[0; 64]),
    );
    f.put("short.npy", npy("<f8", "(2, 2, 2)", &[0; 63]));
    f.put("object.npy", npy("|O", "(2, 2, 2)", &[0; 64]));
    f.put(
        "nan.npy",
        npy("<f8", "(2, 2, 2)", &f64::NAN.to_le_bytes().repeat(8)),
    );
    f.put("wild.npy", npy("<f8", "(2, -2, 2", &[0; 64]));
    f.put(
        "bomb.png",
        [
            b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\xff\xff\0\0\xff\xff\x08\x02\0\0\0".as_slice(),
            &[0; 40],
        ]
        .concat(),
    );
}

#[test]
fn scenes_by_check() {
    let f = Folder::new();
    hostile_files(&f);
    for (what, scene, named) in wrong_scenes() {
        println!("{what}");
        f.put("wrong.toml", scene);
        refused(&f, Program, &["check", "wrong.toml"], "wrong.toml");
        refused(&f, Program, &["--json", "check", "wrong.toml"], named);
    }
}

#[test]
fn scenes_by_solve() {
    let f = Folder::new();
    hostile_files(&f);
    f.put("out/kept.npz", "an earlier solution");
    for (what, scene, _) in wrong_scenes() {
        println!("{what}");
        f.put("wrong.toml", scene);
        refused(
            &f,
            Program,
            &["solve", "wrong.toml", "-o", "out/x.npz"],
            "wrong.toml",
        );
        refused(
            &f,
            Program,
            &["solve", "wrong.toml", "-o", "out/kept.npz"],
            "wrong.toml",
        );
    }
}

#[test]
fn files_that_are_no_scenes() {
    let f = Folder::new();
    f.put("latin.toml", b"name = 'caf\xe9'");
    f.put("room.npz", solution());
    for command in [["check"].as_slice(), &["solve", "-o", "out/x.npz"]] {
        for (file, named) in [
            ("none.toml", "none.toml"),
            ("out", "out"),
            ("latin.toml", "UTF-8"),
            ("room.npz", "room.npz"),
        ] {
            refused(&f, Program, &[command, &[file]].concat(), named);
        }
        refused(&f, Parser, command, "<SCENE>");
        refused(&f, Parser, &[command, &[""]].concat(), "<SCENE>");
        refused(&f, Parser, &[command, &["a.toml", "b.toml"]].concat(), "b.toml");
    }
}

#[test]
fn flags_of_all_commands() {
    let f = Folder::new();
    f.put("room.toml", ROOM);
    let check =
        |flags: &[&str], named: &str| refused(&f, Parser, &[&["check", "room.toml"], flags].concat(), named);
    for n in ["0", "-1", "two", "1.5", "99999", ""] {
        check(&[&format!("--threads={n}")], "--threads");
    }
    check(&["--threads"], "--threads");
    check(&["--json=yes"], "--json");
    check(&["--quiet=3"], "--quiet");
    check(&["--tolerance", "0.1"], "--tolerance");
    table(
        &f,
        &[
            (Parser, &["slove", "room.toml"], "slove"),
            (Parser, &["--wibble"], "--wibble"),
            (Parser, &["check", "room.toml", "-x"], "-x"),
        ],
    );
}

#[test]
fn flags_of_solve() {
    let f = Folder::new();
    f.put("room.toml", ROOM);
    let solve =
        |by, flag: &str, named| refused(&f, by, &["solve", "room.toml", "-o", "out/x.npz", flag], named);
    for t in ["0", "-0.1", "1", "2", "nan", "inf", "1e400"] {
        solve(Program, &format!("--tolerance={t}"), "--tolerance");
    }
    for m in ["0", "-1", "nan", "inf"] {
        solve(Program, &format!("--max-memory={m}"), "--max-memory");
    }
    solve(Program, "--max-memory=1e-9", "GB");
    for flag in [
        "--tolerance=fine",
        "--tolerance=",
        "--max-memory=8GB",
        "--max-memory=",
        "--closure=mend",
        "--closure=",
        "--closure=1",
    ] {
        solve(Parser, flag, flag.split('=').next().unwrap());
    }
    table(
        &f,
        &[
            (Parser, &["solve", "room.toml"], "--output"),
            (Parser, &["solve", "room.toml", "-o"], "--output"),
        ],
    );
}

/// Outputs that no command can write: missing folder, a file for a folder, a folder for a file, other endings.
fn bad_outputs(f: &Folder, command: &[&str], flag: &str, ending: &str) {
    f.put("plain", "a file");
    std::fs::create_dir_all(f.path().join(format!("taken.{ending}"))).unwrap();
    for (output, named) in [
        (format!("missing/x.{ending}"), "missing".to_string()),
        (format!("out/missing/x.{ending}"), "missing".into()),
        (format!("plain/x.{ending}"), "plain".into()),
        (format!("taken.{ending}"), format!("taken.{ending}")),
        ("out/x".into(), "out/x".into()),
        ("out/x.txt".into(), "out/x.txt".into()),
        (format!("out/.{ending}"), format!("out/.{ending}")),
        ("out".into(), "out".into()),
        (format!("out/{}.{ending}", "x".repeat(300)), "xxx".into()),
    ] {
        refused(f, Program, &[command, &[flag, &output]].concat(), &named);
    }
    refused(f, Parser, &[command, &[flag, ""]].concat(), flag);
}

#[test]
fn outputs() {
    let f = Folder::new();
    f.put("room.toml", ROOM);
    f.put("room.npz", solution());
    f.put("pairs.csv", format!("{COLUMNS}\n{VOXELS}\n"));
    bad_outputs(&f, &["solve", "room.toml"], "-o", "npz");
    bad_outputs(
        &f,
        &["render", "room.npz", "--size", "8x6", "--samples", "1"],
        "-o",
        "png",
    );
    bad_outputs(
        &f,
        &["render", "room.npz", "--size", "8x6", "--samples", "1"],
        "--output",
        "exr",
    );
    bad_outputs(&f, &["export", "room.npz"], "-o", "csv");
    bad_outputs(&f, &["factors", "pairs.csv"], "-o", "csv");
    bad_outputs(&f, &["demo"], "--write", "toml");
}

#[cfg(unix)]
#[test]
fn a_folder_that_cannot_be_written() {
    use std::os::unix::fs::PermissionsExt;
    let f = Folder::new();
    f.put("room.toml", ROOM);
    let shut = f.path().join("shut");
    std::fs::create_dir(&shut).unwrap();
    std::fs::set_permissions(&shut, std::fs::Permissions::from_mode(0o555)).unwrap();
    if std::fs::write(shut.join("x"), "").is_ok() {
        println!("skipped: this user may write everywhere");
        return;
    }
    refused(&f, Program, &["solve", "room.toml", "-o", "shut/x.npz"], "shut");
    refused(&f, Program, &["demo", "--size", "small", "-o", "shut"], "shut");
    refused(&f, Program, &["demo", "--write", "shut/x.toml"], "shut");
}

#[test]
fn demos() {
    let f = Folder::new();
    f.put("plain", "a file");
    for (folder, taken) in [("solution", "chapel.npz"), ("picture", "nave.png")] {
        std::fs::create_dir_all(f.path().join(folder).join(taken)).unwrap();
    }
    let small = ["demo", "--size", "small", "-o"];
    for (folder, named) in [
        ("plain", "plain"),
        ("plain/below", "plain"),
        ("solution", "chapel.npz"),
        ("picture", "nave.png"),
    ] {
        refused(&f, Program, &[&small, [folder].as_slice()].concat(), named);
    }
    refused(&f, Parser, &[&small, [""].as_slice()].concat(), "--output");
    for size in ["--size=huge", "--size=", "--size=3"] {
        refused(&f, Parser, &["demo", "-o", "out", size], "--size");
    }
    refused(&f, Parser, &["demo", "scene.toml"], "scene.toml");
}

#[test]
fn solutions_that_are_none() {
    let f = Folder::new();
    let sound = solution();
    f.put("words.npz", "these are words");
    f.put("empty.npz", "");
    f.put("array.npz", npy("<f8", "(2, 2, 2)", &[0; 64]));
    f.put("short.npz", &sound[..sound.len() / 2]);
    f.put("shorter.npz", &sound[..sound.len() - 1]);
    let mut altered = sound.to_vec();
    // Somewhere in the first entry, the header: the check sum no longer fits.
    altered[200] ^= 0x10;
    f.put("altered.npz", altered);
    for command in [["render", "-o", "out/x.png"], ["export", "-o", "out/x.csv"]] {
        for run in [
            "none.npz",
            "out",
            "words.npz",
            "empty.npz",
            "array.npz",
            "short.npz",
            "shorter.npz",
            "altered.npz",
        ] {
            refused(&f, Program, &[command.as_slice(), &[run]].concat(), run);
        }
        refused(&f, Parser, &command, "<RUN>");
    }
}

#[test]
fn flags_of_render_and_export() {
    let f = Folder::new();
    f.put("room.npz", solution());
    let render =
        |by, flag: &str, named| refused(&f, by, &["render", "room.npz", "-o", "out/x.png", flag], named);
    for camera in ["window", "Door", ""] {
        render(Program, &format!("--camera={camera}"), "--camera");
    }
    for size in [
        "0x5",
        "5x0",
        "5",
        "",
        "x",
        "5x",
        "axb",
        "-5x5",
        "1.5x2",
        "1e9x1e9",
        "5x5x5",
        "1000000000x1000000000",
        "99999999999999999999x1",
    ] {
        render(Program, &format!("--size={size}"), "--size");
    }
    for stops in ["nan", "inf", "31", "-1e9"] {
        render(Program, &format!("--stops={stops}"), "--stops");
    }
    for flag in [
        "--samples=0",
        "--samples=-1",
        "--samples=many",
        "--samples=5000",
        "--samples=1.5",
        "--stops=bright",
        "--stops=",
    ] {
        render(Parser, flag, flag.split('=').next().unwrap());
    }
    for command in ["render", "export"] {
        refused(&f, Parser, &[command, "room.npz"], "--output");
    }
    refused(
        &f,
        Parser,
        &["export", "room.npz", "-o", "out/x.csv", "--camera=door"],
        "--camera",
    );
    let blind = ROOM.split("[[camera]]").next().unwrap();
    f.put("blind.toml", blind);
    f.done(&["solve", "blind.toml", "-o", "blind.npz"]);
    refused(&f, Program, &["render", "blind.npz", "-o", "out/x.png"], "camera");
}

#[test]
fn pairs_and_flags_of_factors() {
    let f = Folder::new();
    let rows = [
        ("kind", "sv,0,1,0,1,0,1,,1,2,0,1,0,1,,0.5"),
        ("kind", "xx,0,1,0,1,0,1,,1,2,0,1,0,1,,0.5"),
        ("a_x0", "vv,zero,1,0,1,0,1,,1,2,0,1,0,1,,0.5"),
        ("a_y1", "vv,0,1,0,nan,0,1,,1,2,0,1,0,1,,0.5"),
        ("b_z1", "vv,0,1,0,1,0,1,,1,2,0,1,0,inf,,0.5"),
        ("a_x1", "vv,0,1e999,0,1,0,1,,1,2,0,1,0,1,,0.5"),
        ("a_x1", "vv,0,,0,1,0,1,,1,2,0,1,0,1,,0.5"),
        ("a_x0", "vv,1,0,0,1,0,1,,1,2,0,1,0,1,,0.5"),
        ("b_x0", "vv,0,1,0,1,0,1,,1,2,1,0,0,1,,0.5"),
        ("b_x0", "vv,0,1,0,1,0,1,,1,2,0,0,0,1,,0.5"),
        ("a_normal", "sv,0,0,0,1,0,1,x,1,2,0,1,0,1,,0.5"),
        ("a_normal", "sv,0,0,0,1,0,1,+w,1,2,0,1,0,1,,0.5"),
        ("a_normal", "sv,0,0,0,1,0,1,é,1,2,0,1,0,1,,0.5"),
        ("a_x0", "sv,0,0,0,1,0,1,+y,1,2,0,1,0,1,,0.5"),
        ("kappa", "vv,0,1,0,1,0,1,,1,2,0,1,0,1,,-0.5"),
        ("kappa", "vv,0,1,0,1,0,1,,1,2,0,1,0,1,,nan"),
        ("kappa", "vv,0,1,0,1,0,1,,1,2,0,1,0,1,,"),
        ("line", "vv,0,1,0,1"),
        ("line", "vv,0,1,0,1,0,1,,1,2,0,1,0,1,,0.5,7"),
    ];
    let factors = ["factors", "pairs.csv", "-o", "out/x.csv"];
    for (named, row) in rows {
        f.put("pairs.csv", format!("{COLUMNS}\n{VOXELS}\n{row}\n"));
        refused(&f, Program, &factors, "pairs.csv");
        refused(&f, Program, &factors, "line");
        refused(&f, Program, &factors, named);
    }
    for (what, table) in [
        (
            "kappa",
            COLUMNS.replace(",kappa", "") + "\nvv,0,1,0,1,0,1,,1,2,0,1,0,1,\n",
        ),
        ("a_x0", COLUMNS.replace("a_x0", "ax0") + "\n" + VOXELS),
        ("rows", COLUMNS.to_string()),
        ("column", String::new()),
        ("pairs.csv", format!("{COLUMNS}\n\u{0}\n")),
    ] {
        f.put("pairs.csv", table);
        refused(&f, Program, &factors, what);
    }
    f.put(
        "pairs.csv",
        [COLUMNS.as_bytes(), b"\nvv,\xff\xfe,1,0,1,0,1,,1,2,0,1,0,1,,0.5\n"].concat(),
    );
    refused(&f, Program, &factors, "pairs.csv");
    f.put("room.npz", solution());
    for file in ["none.csv", "out", "room.npz"] {
        refused(&f, Program, &["factors", file, "-o", "out/x.csv"], file);
    }
    f.put("pairs.csv", format!("{COLUMNS}\n{VOXELS}\n"));
    for t in ["0", "1", "-1e-3", "nan", "inf"] {
        refused(
            &f,
            Program,
            &[factors.as_slice(), &[&format!("--tolerance={t}")]].concat(),
            "--tolerance",
        );
    }
    refused(
        &f,
        Parser,
        &[factors.as_slice(), &["--tolerance=tight"]].concat(),
        "--tolerance",
    );
    refused(&f, Parser, &factors[..2], "--output");
    refused(&f, Parser, &["factors", "-o", "out/x.csv"], "<PAIRS>");
}
