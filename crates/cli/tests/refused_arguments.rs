//! Wrong options, outputs, solutions and tables: exit code 2, one line that names the file or the option, and no output, whole or partial.
//!
//! Wrong scenes are in `refused_scenes.rs`.

use crate::support;

use support::{By, COLUMNS, Folder, Parser, Program, ROOM, VOXELS, npy, refused, solution};

fn refuse_all(f: &Folder, cases: &[(By, &[&str], &str)]) {
    for (by, args, named) in cases {
        refused(f, *by, args, named);
    }
}

#[test]
fn wrong_global_and_check_options_are_refused() {
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
    check(&["--closure", "restore"], "--closure");
    check(&["--tolerance=fine"], "--tolerance");
    check(&["--engine=steam"], "--engine");
    for (flag, named) in [("--tolerance=0", "--tolerance"), ("--max-memory=0", "--max-memory")] {
        refused(&f, Program, &["check", "room.toml", flag], named);
    }
    refuse_all(
        &f,
        &[
            (Parser, &["slove", "room.toml"], "slove"),
            (Parser, &["--wibble"], "--wibble"),
            (Parser, &["check", "room.toml", "-x"], "-x"),
        ],
    );
}

#[test]
fn wrong_solve_options_are_refused() {
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
        "--closure=repair",
        "--closure=",
        "--closure=1",
        "--factors=gauss",
        "--factors=",
    ] {
        solve(Parser, flag, flag.split('=').next().unwrap());
    }
    refuse_all(
        &f,
        &[(Parser, &["solve", "room.toml"], "--output"), (Parser, &["solve", "room.toml", "-o"], "--output")],
    );
}

#[test]
fn wrong_exchange_and_reproduce_options_are_refused() {
    let f = Folder::new();
    f.put("room.toml", ROOM);
    let exchange =
        |by, flag: &str, named| refused(&f, by, &["exchange", "room.toml", "-o", "out/x.npz", flag], named);
    for t in ["0", "-0.1", "1", "nan", "inf"] {
        exchange(Program, &format!("--tolerance={t}"), "--tolerance");
    }
    for m in ["0", "-1", "nan"] {
        exchange(Program, &format!("--max-memory={m}"), "--max-memory");
    }
    exchange(Program, "--max-memory=1e-9", "GB");
    f.put("plain", "a file");
    refuse_all(
        &f,
        &[
            (Parser, &["exchange", "room.toml"], "--output"),
            (Program, &["exchange", "none.toml", "-o", "out/x.npz"], "none.toml"),
            (Program, &["reproduce", "-o", "plain/paper"], "plain"),
            (Program, &["reproduce", "-o", "plain"], "plain"),
            (Parser, &["reproduce", "--size", "tiny"], "--size"),
        ],
    );
}

/// Refuses unwritable outputs: missing folder, file in place of a folder, folder in place of a file, wrong extension.
fn refuse_bad_outputs(f: &Folder, command: &[&str], flag: &str, extension: &str) {
    f.put("plain", "a file");
    std::fs::create_dir_all(f.path().join(format!("taken.{extension}"))).unwrap();
    for (output, named) in [
        (format!("missing/x.{extension}"), "missing".to_string()),
        (format!("out/missing/x.{extension}"), "missing".into()),
        (format!("plain/x.{extension}"), "plain".into()),
        (format!("taken.{extension}"), format!("taken.{extension}")),
        ("out/x".into(), "out/x".into()),
        ("out/x.txt".into(), "out/x.txt".into()),
        (format!("out/.{extension}"), format!("out/.{extension}")),
        ("out".into(), "out".into()),
        (format!("out/{}.{extension}", "x".repeat(300)), "xxx".into()),
    ] {
        refused(f, Program, &[command, &[flag, &output]].concat(), &named);
    }
    refused(f, Parser, &[command, &[flag, ""]].concat(), flag);
}

// Guards (files): an output that cannot be written is refused before any work.
#[test]
fn unwritable_outputs_are_refused() {
    let f = Folder::new();
    f.put("room.toml", ROOM);
    f.put("room.npz", solution());
    f.put("pairs.csv", format!("{COLUMNS}\n{VOXELS}\n"));
    refuse_bad_outputs(&f, &["solve", "room.toml"], "-o", "npz");
    refuse_bad_outputs(&f, &["render", "room.npz", "--size", "8x6", "--samples", "1"], "-o", "png");
    refuse_bad_outputs(&f, &["render", "room.npz", "--size", "8x6", "--samples", "1"], "--output", "exr");
    for extension in ["csv", "glb", "vtu", "vti"] {
        refuse_bad_outputs(&f, &["export", "room.npz"], "-o", extension);
    }
    refuse_bad_outputs(&f, &["factors", "pairs.csv"], "-o", "csv");
    refuse_bad_outputs(&f, &["exchange", "room.toml"], "-o", "npz");
    refuse_bad_outputs(&f, &["demo"], "--write", "toml");
}

#[cfg(unix)]
#[test]
fn unwritable_folders_are_refused() {
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
fn wrong_demo_arguments_are_refused() {
    let f = Folder::new();
    f.put("plain", "a file");
    std::fs::create_dir_all(f.path().join("solution/chapel.npz")).unwrap();
    let small = ["demo", "chapel", "--size", "small", "-o"];
    for (folder, named) in [("plain", "plain"), ("plain/below", "plain"), ("solution", "chapel.npz")] {
        refused(&f, Program, &[&small, [folder].as_slice()].concat(), named);
    }
    refused(&f, Parser, &[&small, [""].as_slice()].concat(), "--output");
    for size in ["--size=huge", "--size=", "--size=3"] {
        refused(&f, Parser, &["demo", "-o", "out", size], "--size");
    }
    refused(&f, Parser, &["demo", "scene.toml"], "scene.toml");
}

#[test]
fn unwritable_demo_picture_is_refused_before_the_solve() {
    let f = Folder::new();
    std::fs::create_dir_all(f.path().join("out/nave.png")).unwrap();
    refused(&f, Program, &["demo", "chapel", "--size", "small", "-o", "out"], "nave.png");
}

// Guards (files): no file makes the program panic.
#[test]
fn damaged_solutions_are_refused() {
    let f = Folder::new();
    let valid = solution();
    f.put("words.npz", "these are words");
    f.put("empty.npz", "");
    f.put("array.npz", npy("<f8", "(2, 2, 2)", &[0; 64]));
    f.put("short.npz", &valid[..valid.len() / 2]);
    f.put("shorter.npz", &valid[..valid.len() - 1]);
    let mut altered = valid.to_vec();
    // A bit in the first entry, the header: its checksum fails.
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
fn wrong_cameras_and_sizes_are_refused() {
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
}

#[test]
fn wrong_tone_and_lens_options_are_refused() {
    let f = Folder::new();
    f.put("room.npz", solution());
    let render =
        |by, flag: &str, named| refused(&f, by, &["render", "room.npz", "-o", "out/x.png", flag], named);
    for stops in ["nan", "inf", "31", "-1e9"] {
        render(Program, &format!("--stops={stops}"), "--stops");
    }
    for (flag, values) in [
        ("--contrast", ["nan", "0", "-1", "11"]),
        ("--bloom", ["nan", "-0.1", "1.1", "inf"]),
        ("--aperture", ["nan", "-1", "inf", "-inf"]),
        ("--focus", ["nan", "0", "-1", "inf"]),
    ] {
        values.iter().for_each(|v| render(Program, &format!("{flag}={v}"), flag));
    }
    render(Program, "--focus=2", "--aperture");
    for flag in ["--stops=1", "--contrast=1.2"] {
        let args = ["render", "room.npz", "-o", "out/x.exr", flag];
        refused(&f, Program, &args, "write a .png");
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
}

#[test]
fn render_without_output_or_with_an_unknown_camera_is_refused() {
    let f = Folder::new();
    f.put("room.npz", solution());
    for command in ["render", "export"] {
        refused(&f, Parser, &[command, "room.npz"], "--output");
    }
    refused(&f, Parser, &["export", "room.npz", "-o", "out/x.csv", "--camera=door"], "--camera");
    let blind = ROOM.split("[[camera]]").next().unwrap();
    f.put("blind.toml", blind);
    f.done(&["solve", "blind.toml", "-o", "blind.npz"]);
    refused(&f, Program, &["render", "blind.npz", "-o", "out/x.png", "--camera=door"], "overview");
}

const FACTORS: [&str; 4] = ["factors", "pairs.csv", "-o", "out/x.csv"];

#[test]
fn wrong_rows_of_pairs_are_refused() {
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
    for (named, row) in rows {
        f.put("pairs.csv", format!("{COLUMNS}\n{VOXELS}\n{row}\n"));
        refused(&f, Program, &FACTORS, "pairs.csv");
        refused(&f, Program, &FACTORS, "line");
        refused(&f, Program, &FACTORS, named);
    }
}

#[test]
fn wrong_tables_of_pairs_and_options_are_refused() {
    let f = Folder::new();
    for (named, table) in [
        ("kappa", COLUMNS.replace(",kappa", "") + "\nvv,0,1,0,1,0,1,,1,2,0,1,0,1,\n"),
        ("a_x0", COLUMNS.replace("a_x0", "ax0") + "\n" + VOXELS),
        ("rows", COLUMNS.to_string()),
        ("column", String::new()),
        ("pairs.csv", format!("{COLUMNS}\n\u{0}\n")),
    ] {
        f.put("pairs.csv", table);
        refused(&f, Program, &FACTORS, named);
    }
    f.put("pairs.csv", [COLUMNS.as_bytes(), b"\nvv,\xff\xfe,1,0,1,0,1,,1,2,0,1,0,1,,0.5\n"].concat());
    refused(&f, Program, &FACTORS, "pairs.csv");
    f.put("room.npz", solution());
    for file in ["none.csv", "out", "room.npz"] {
        refused(&f, Program, &["factors", file, "-o", "out/x.csv"], file);
    }
    f.put("pairs.csv", format!("{COLUMNS}\n{VOXELS}\n"));
    for t in ["0", "1", "-1e-3", "nan", "inf"] {
        refused(&f, Program, &[FACTORS.as_slice(), &[&format!("--tolerance={t}")]].concat(), "--tolerance");
    }
    refused(&f, Parser, &[FACTORS.as_slice(), &["--tolerance=tight"]].concat(), "--tolerance");
    refused(&f, Parser, &FACTORS[..2], "--output");
    refused(&f, Parser, &["factors", "-o", "out/x.csv"], "<PAIRS>");
}

/// Finite numbers whose areas, volumes or optical depths overflow or underflow.
#[test]
fn pairs_out_of_range_are_refused() {
    let f = Folder::new();
    for row in [
        "vv,0,1,0,1,0,1,,1,2,0,1,0,1,,1e300",
        "vv,0,1,0,1,0,1,,1,2,0,1,0,1,,1e100",
        "vv,0,1e300,0,1e300,0,1e300,,0,1e300,0,1e300,0,1e300,,0",
        "vv,0,1e160,0,1,0,1,,1,2,0,1,0,1,,0",
        "vv,-1e308,1e308,0,1,0,1,,1,2,0,1,0,1,,0",
        "vv,0,1e-160,0,1e-160,0,1e-160,,0,1e-160,0,1e-160,0,1e-160,,0",
    ] {
        f.put("pairs.csv", format!("{COLUMNS}\n{VOXELS}\n{row}\n"));
        refused(&f, Program, &["factors", "pairs.csv", "-o", "out/x.csv"], "line 3");
    }
}
