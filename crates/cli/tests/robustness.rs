//! Special files as inputs and outputs, numbers at the ends of their range, control characters in names: a correct result or a one-line error, never a panic,
//! a hang, a partial file or NaN.
#![cfg(unix)]

use crate::support;

use std::os::unix::fs::symlink;
use std::process::{Command, Output};
use support::{COLUMNS, Folder, Program, ROOM, VOXELS, refused, solution, text};

/// Runs `zonal` in a shell with a resource limit.
fn limited(f: &Folder, limit: &str, args: &str) -> Output {
    let line = format!("ulimit {limit}; exec '{}' {args}", env!("CARGO_BIN_EXE_zonal"));
    Command::new("sh").args(["-c", &line]).current_dir(f.path()).output().unwrap()
}

// Guards (files): only regular files are read.
#[test]
fn pipes_and_devices_are_refused_as_inputs() {
    let f = Folder::new();
    for name in ["f.npz", "f.toml", "f.csv", "f.obj", "f.npy"] {
        assert!(Command::new("mkfifo").arg(f.path().join(name)).status().unwrap().success());
    }
    f.put("mesh.toml", "[[surface]]\nname = 'm'\nmesh = { file = 'f.obj' }\n");
    symlink("/dev/zero", f.path().join("z.npz")).unwrap();
    // `refused` lists the folder and would block on the pipes.
    let refuse = |args: &[&str]| {
        let o = f.zonal(args);
        let err = text(&o.stderr);
        assert_eq!(o.status.code(), Some(2), "{args:?}: {err}");
        assert!(err.lines().count() == 1 && err.contains("this is not a file"), "{args:?}: {err}");
    };
    for run in ["f.npz", "z.npz"] {
        refuse(&["render", run, "-o", "out/x.png"]);
        refuse(&["export", run, "-o", "out/x.csv"]);
        refuse(&["relight", run]);
    }
    refuse(&["check", "f.toml"]);
    refuse(&["check", "mesh.toml"]);
    refuse(&["factors", "f.csv", "-o", "out/x.csv"]);
    refuse(&["factors", "/dev/zero", "-o", "out/x.csv"]);
}

#[test]
fn overlong_line_is_refused() {
    let f = Folder::new();
    f.put("long.csv", vec![b'a'; 1 << 20]);
    refused(&f, Program, &["factors", "long.csv", "-o", "out/x.csv"], "a line is longer than");
}

#[test]
fn links_are_kept_and_devices_are_written_directly() {
    let f = Folder::new();
    f.put("run.npz", solution());
    symlink("out/real.csv", f.path().join("link.csv")).unwrap();
    f.done(&["export", "run.npz", "-o", "link.csv"]);
    assert!(std::fs::symlink_metadata(f.path().join("link.csv")).unwrap().is_symlink());
    assert!(text(&f.get("out/real.csv")).starts_with("zone,kind,of"));
    f.put("pairs.csv", format!("{COLUMNS}\n{VOXELS}\n"));
    let out = f.done(&["--json", "factors", "pairs.csv", "-o", "/dev/stdout"]);
    assert!(out.starts_with("kind,a_x0") && out.contains("proved"), "{out}");
    f.put("room.toml", ROOM);
    f.done(&["solve", "room.toml", "-o", "/dev/null"]);
    assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
}

// Guards (files): a full disk leaves no file and one line of error.
#[test]
fn file_size_limit_leaves_no_file_and_one_line() {
    let f = Folder::new();
    f.put("room.toml", ROOM);
    f.put("run.npz", solution());
    let before = f.listing();
    for args in
        ["solve room.toml -o out/x.npz", "export run.npz -o out/x.html", "export run.npz -o out/x.csv"]
    {
        let o = limited(&f, "-f 1", args);
        let err = text(&o.stderr);
        assert_eq!(o.status.code(), Some(2), "{args}: {:?} {err}", o.status);
        assert!(err.lines().count() == 1 && err.contains("cannot be written"), "{args}: {err}");
        assert!(f.listing() == before, "{args}: a file remains");
    }
}

#[test]
fn temporary_files_of_killed_runs_are_removed() {
    let f = Folder::new();
    f.put("room.toml", ROOM);
    f.put("out/.x.npz.999999-000000.partial", "torn");
    f.put("out/.y.npz.999999-000000.partial", "another's");
    f.done(&["solve", "room.toml", "-o", "out/x.npz"]);
    assert!(!f.path().join("out/.x.npz.999999-000000.partial").exists());
    assert!(f.path().join("out/.y.npz.999999-000000.partial").exists());
}

/// A linear basis in optically thick voxels can have negative radiosity.
#[test]
fn thick_voxels_are_drawn_and_exported() {
    let f = Folder::new();
    for (cells, extinction) in [(2, 20), (3, 200), (4, 20), (6, 1000)] {
        let scene = format!(
            "[solve]\npatch_rule='voxels'\n[[surface]]\nname='r'\nroom={{min=[0,0,0],max=[1,1,1]}}\nfaces.z1={{emission=1}}\n\
             [medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[{cells},{cells},{cells}]\nextinction={extinction}\nalbedo=0.5\n\
             [[camera]]\nname='c'\norigin=[0.3,0.3,0.5]\ntarget=[0.9,0.8,0.4]\n"
        );
        f.put("thick.toml", scene);
        f.done(&["solve", "thick.toml", "-o", "thick.npz"]);
        f.done(&["render", "thick.npz", "--size", "16x12", "-o", "out/x.png"]);
        for ending in ["html", "glb", "vtu", "vti", "csv"] {
            f.done(&["export", "thick.npz", "-o", &format!("out/x.{ending}")]);
        }
    }
}

#[test]
fn very_weak_light_is_drawn() {
    let f = Folder::new();
    f.put("dim.toml", ROOM.replace("emission = 100", "emission = 1e-300"));
    f.done(&["solve", "dim.toml", "-o", "dim.npz"]);
    f.done(&["render", "dim.npz", "--size", "16x12", "-o", "out/x.png"]);
}

/// The offset of ray origins exceeds the height of the room.
#[test]
fn room_too_thin_for_rays_is_refused() {
    let f = Folder::new();
    let scene = "[solve]\npatch_rule='voxels'\n[[surface]]\nname='room'\nroom={min=[0,0,0.999999],max=[1,1e6,1]}\nreflectance=0.5\n\
        faces.z0={emission=1}\n[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[4,4,4]\nextinction=2\nalbedo=0.9\n";
    f.put("thin.toml", scene);
    refused(&f, Program, &["solve", "thin.toml", "-o", "out/x.npz"], "too narrow for a scene of");
}

/// Squares of these lengths underflow.
#[test]
fn factors_of_negligible_lengths_equal_those_of_zero() {
    let f = Folder::new();
    let rows = |z: &str| {
        format!("{COLUMNS}\nsv,0,1,0,1,0,0,+z,1,2,0,1,{z},1,,0\nvv,0,1,0,1,0,1,,{z},2,1,2,{z},1,,0.1\n")
    };
    let values = |z: &str| {
        f.put("pairs.csv", rows(z));
        f.done(&["factors", "pairs.csv", "-o", "out/x.csv"]);
        let table = text(&f.get("out/x.csv"));
        let of = |l: &str| l.split(',').skip(16).map(String::from).collect::<Vec<_>>();
        table.lines().skip(1).map(of).collect::<Vec<_>>()
    };
    let exact = values("0");
    for z in ["1e-308", "1e-150", "1e-100"] {
        assert_eq!(values(z), exact, "{z}");
    }
    f.put("pairs.csv", format!("{COLUMNS}\nss,0,1,0,1,0,0,+z,0,1,0,1,1e-150,1e-150,-z,1\n"));
    std::fs::remove_file(f.path().join("out/x.csv")).unwrap();
    refused(&f, Program, &["factors", "pairs.csv", "-o", "out/x.csv"], "line 2: the lengths of this pair");
}

// Guards (files): names cannot control a terminal and are no spreadsheet formulas.
#[test]
fn names_cannot_control_terminals_or_spreadsheets() {
    let f = Folder::new();
    let scene = ROOM.replace("name = 'room'\nroom", "name = \"=cmd|\\u001b]0;x\\u0007\\n\\u202e\"\nroom");
    f.put("inj.toml", scene.replace("name = 'door'", "name = \"\\u001b[2J\""));
    let out = f.done(&["solve", "inj.toml", "-o", "inj.npz"]);
    let has_control_characters =
        |s: &str| s.chars().any(|c| c != '\n' && (c.is_control() || c == '\u{202e}'));
    assert!(!has_control_characters(&out) && out.contains("=cmd|\\u001b]0;x\\u0007\\u000a\\u202e"), "{out}");
    f.done(&["export", "inj.npz", "-o", "out/x.csv"]);
    let table = text(&f.get("out/x.csv"));
    assert!(
        !has_control_characters(&table) && table.contains(",'=cmd|") && !table.contains(",=cmd|"),
        "{table}"
    );
    let o = f.zonal(&["render", "inj.npz", "--camera", "\u{1b}[31m", "-o", "out/x.png"]);
    assert!(!o.status.success() && !has_control_characters(&text(&o.stderr)), "{}", text(&o.stderr));
    assert_eq!(text(&o.stderr).lines().count(), 1);
}

/// A file that exceeds the memory is refused in one line.
#[test]
fn exhausted_memory_is_reported() {
    let f = Folder::new();
    let big = std::fs::File::create(f.path().join("big.toml")).unwrap();
    // A sparse file.
    big.set_len(60 << 20).unwrap();
    let o = limited(&f, "-v 60000", "--threads 1 check big.toml");
    let err = text(&o.stderr);
    assert_eq!(o.status.code(), Some(2), "{:?} {err}", o.status);
    assert!(err.starts_with("error: ") && err.lines().count() == 1, "{err}");
}
