//! `zonal relight`, kept factors and checkpoints through the command.

use crate::support;

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use support::{Folder, Parser, Program, ROOM, refused, solution, text};

/// A room with an emitting wall, a lamp as direct light, emitting smoke, and a tilted shelf that occludes.
const LIT: &str = "name = 'lit'
[solve]
engine = 'dense'
patch_size = 0.34
closure = 'restore'
[[surface]]
name = 'room'
room = { min = [0, 0, 0], max = [1, 1, 1] }
reflectance = 0.8
faces.x0 = { emission = [1, 2, 3] }
[[surface]]
name = 'lamp'
rectangle = { origin = [0.4, 0.4, 0.9], edge1 = [0, 0.2, 0], edge2 = [0.2, 0, 0] }
emission = 50
[[surface]]
name = 'shelf'
rectangle = { origin = [0.2, 0.2, 0.3], edge1 = [0.5, 0, 0.1], edge2 = [0, 0.5, 0] }
sides = 'both'
[medium]
min = [0, 0, 0]
max = [1, 1, 1]
cells = [4, 4, 4]
extinction = [0.3, 0.5, 0.7]
albedo = 0.6
emission = 0.5
[[light]]
kind = 'emitter'
surface = 'lamp'
";

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// Emitted power of each light group, band 1.
fn emitted_power(report: &serde_json::Value) -> Vec<(String, f64)> {
    let groups = report["light_groups"].as_array().unwrap();
    let power = |g: &serde_json::Value, key: &str| g["energy"][key][1].as_f64().unwrap();
    groups
        .iter()
        .map(|g| (g["name"].as_str().unwrap().to_string(), power(g, "emitted") + power(g, "incoming")))
        .collect()
}

// Guards (numbers): a relit solution equals the solution of the relit scene.
#[test]
fn light_groups_are_listed_and_scaled() {
    let f = Folder::new();
    f.put("lit.toml", LIT);
    let first = json(&f.done(&["solve", "lit.toml", "-o", "lit.npz", "--json"]));
    assert_eq!(first["engine"], "dense");
    let listed = f.done(&["relight", "lit.npz"]);
    assert!(["lamp", "room.x0", "medium"].iter().all(|n| listed.contains(n)), "{listed}");
    assert_eq!(json(&f.done(&["relight", "lit.npz", "--json"])), first["light_groups"]);
    let args = ["relight", "lit.npz", "lamp=3", "medium=1,0.5,0", "-o", "out/relit.npz", "--json"];
    let relit = json(&f.done(&args));
    for (((name, now), (_, before)), factor) in
        emitted_power(&relit).iter().zip(emitted_power(&first)).zip([3.0, 1.0, 0.5])
    {
        assert!((now - factor * before).abs() < 1e-12 * before, "{name}: {now} {before}");
    }
    assert!(relit["energy"]["residual"][1].as_f64().unwrap().abs() < 1e-9);
    // The scene of the relit solution is the relit scene: a new solve has the same hash and, except for rounding, the same power.
    f.put("bright.toml", LIT.replace("emission = 50", "emission = 150"));
    let bright = json(&f.done(&["solve", "bright.toml", "-o", "bright.npz", "--json"]));
    let relit = json(&f.done(&["relight", "lit.npz", "lamp=3", "-o", "out/relit_lamp.npz", "--json"]));
    assert_eq!(bright["provenance"]["scene_hash"], relit["provenance"]["scene_hash"]);
    let absorbed = |v: &serde_json::Value| v["energy"]["absorbed_volumes"][0].as_f64().unwrap();
    assert!((absorbed(&bright) / absorbed(&relit) - 1.0).abs() < 1e-9);
    // It is drawn and exported as any other.
    f.done(&["render", "out/relit.npz", "--help"]);
    f.done(&["export", "out/relit.npz", "-o", "out/relit.csv"]);
    let merged = json(&f.done(&["solve", "lit.toml", "-o", "all.npz", "--light-groups", "all", "--json"]));
    assert_eq!(emitted_power(&merged).len(), 1);
}

#[test]
fn reflectances_change_with_kept_factors() {
    let f = Folder::new();
    f.put("lit.toml", LIT);
    f.done(&["solve", "lit.toml", "-o", "lit.npz", "--keep-factors"]);
    assert!(
        f.path().join("lit.npz.factors/zonal.key").exists() && !f.path().join("lit.npz.checkpoint").exists()
    );
    let args = ["relight", "lit.npz", "--reflectance", "room=0.2,0.5,0.9", "--albedo", "0.3", "lamp=2"];
    let out = ["-o", "out/again.npz", "--json"];
    let again = json(&f.done(&[&args[..], &out].concat()));
    let fresh = LIT
        .replace("reflectance = 0.8", "reflectance = [0.2, 0.5, 0.9]")
        .replace("albedo = 0.6", "albedo = 0.3")
        .replace("emission = 50", "emission = 100");
    f.put("fresh.toml", fresh);
    let fresh = json(&f.done(&["solve", "fresh.toml", "-o", "fresh.npz", "--json"]));
    assert_eq!(again["provenance"]["scene_hash"], fresh["provenance"]["scene_hash"]);
    for key in ["absorbed_volumes", "emitted", "absorbed_backfaces"] {
        for b in 0..3 {
            let [x, y] = [&again, &fresh].map(|v| v["energy"][key][b].as_f64().unwrap());
            assert!((x - y).abs() <= 1e-9 * y.abs(), "{key}: {x} {y}");
        }
    }
    let refuse = |run: &str, named: &str| {
        refused(&f, Program, &["relight", run, "--albedo", "0.5", "-o", "out/x.npz"], named);
    };
    refuse("fresh.npz", "--keep-factors");
    // Factors of other lights are refused.
    f.done(&["relight", "lit.npz", "lamp=2", "-o", "turned.npz"]);
    std::fs::rename(f.path().join("lit.npz.factors"), f.path().join("turned.npz.factors")).unwrap();
    refuse("turned.npz", "other lights");
}

#[test]
fn wrong_assignments_and_options_are_refused() {
    let f = Folder::new();
    f.put("room.npz", solution());
    f.put("room.toml", ROOM);
    let out = ["-o", "out/x.npz"];
    let refuse =
        |by, args: &[&str], named: &str| refused(&f, by, &[&["relight", "room.npz"], args].concat(), named);
    for (assignment, named) in [
        ("moon=2", "the groups are: room.x0"),
        ("room.x0", "has no value"),
        ("room.x0=much", "neither a number"),
        ("room.x0=1,2", "nor r,g,b"),
        ("room.x0=-1", "from 0"),
        ("room.x0=nan", "from 0"),
        ("=2", "light group ''"),
    ] {
        refuse(Program, &[&[assignment], &out[..]].concat(), named);
    }
    refuse(Program, &["room.x0=2"], "--output");
    refuse(Program, &out, "nothing changes");
    refuse(Program, &["room.x0=2", "-o", "out/x.csv"], ".npz");
    refuse(Program, &["room.x0=2", "room.x0=3", "-o", "out/x.npz"], "two factors");
    refuse(Program, &[&["--albedo", "2"], &out[..]].concat(), "--albedo");
    refuse(Program, &[&["--reflectance", "room=1.5"], &out[..]].concat(), "from 0 to 1");
    refuse(Program, &[&["--reflectance", "room=0.5"], &out[..]].concat(), "--keep-factors");
    let solve = |by, args: &[&str], named: &str| {
        refused(&f, by, &[&["solve", "room.toml", "-o", "out/x.npz"], args].concat(), named);
    };
    solve(Program, &["--scattering-orders", "0"], "--scattering-orders");
    solve(Parser, &["--scattering-orders", "many"], "--scattering-orders");
    solve(Parser, &["--engine", "steam"], "--engine");
    solve(Parser, &["--light-groups", "some"], "--light-groups");
    solve(Program, &["--checkpoint", "room.toml"], "room.toml");
    solve(Program, &["--checkpoint", "--engine", "dense", "--max-memory", "1e-7"], "--max-memory");
}

/// Kills a solve after these fractions of its time and resumes it each time; the file has the bytes of an uninterrupted solve. Returns the report.
/// `scripts/kill_at_random.py` is the campaign of a hundred kills.
fn kill_and_resume(scene: &str, options: &[&str], fractions: &[f64]) -> String {
    let f = Folder::new();
    f.put("lit.toml", scene);
    let start = Instant::now();
    let report = f.done(&[&["solve", "lit.toml", "-o", "straight.npz"], options].concat());
    let length = start.elapsed().as_secs_f64();
    let args = [&["solve", "lit.toml", "-o", "out/killed.npz", "--resume"], options].concat();
    for &fraction in fractions {
        let mut child = Command::new(env!("CARGO_BIN_EXE_zonal"))
            .args(&args)
            .current_dir(f.path())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_secs_f64(fraction * length));
        let _ = child.kill();
        child.wait().unwrap();
        // The solve may have finished.
        let _ = std::fs::remove_file(f.path().join("out/killed.npz"));
    }
    f.done(&args);
    assert!(f.get("out/killed.npz") == f.get("straight.npz"), "resumed work differs");
    assert!(!f.path().join("out/killed.npz.checkpoint").exists());
    report
}

// Guards (determinism): interrupted and resumed solves have the bits of uninterrupted ones.
#[test]
fn killed_and_resumed_solve_has_identical_bytes() {
    let finer = LIT.replace("0.34", "0.26").replace("[4, 4, 4]", "[5, 5, 5]");
    let dense = kill_and_resume(&finer, &["--engine", "dense", "--tolerance", "0.03"], &[0.6]);
    assert!(dense.contains("rays between zones"), "{dense}");
    let rays = kill_and_resume(&finer, &["--engine", "rays", "--tolerance", "0.05"], &[0.3]);
    assert!(rays.contains("transport_rays") && rays.contains("samples of the final gather"), "{rays}");
    kill_and_resume(LIT, &["--engine", "rays", "--tolerance", "0.02"], &[0.8]);
}

/// Kills a solve as soon as each of these stages exists, then resumes it; the file has the bytes of an uninterrupted solve.
fn kill_in_stages(scene: &str, stages: &[&str]) {
    const MAX_ATTEMPTS: usize = 5;
    let f = Folder::new();
    f.put("duct.toml", scene);
    f.done(&["solve", "duct.toml", "-o", "straight.npz"]);
    let args = ["solve", "duct.toml", "-o", "out/killed.npz", "--resume"];
    for stage in stages {
        let kept = f.path().join(format!("out/killed.npz.checkpoint/{stage}.stage"));
        let killed = (0..MAX_ATTEMPTS).any(|_| {
            let mut child = Command::new(env!("CARGO_BIN_EXE_zonal"))
                .args(args)
                .current_dir(f.path())
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            while child.try_wait().unwrap().is_none() {
                if kept.exists() {
                    let _ = child.kill();
                    break;
                }
                std::thread::sleep(Duration::from_micros(200));
            }
            child.wait().unwrap();
            // A solve that ended before it was killed has removed its stages.
            kept.exists()
        });
        assert!(killed, "never killed in {stage}");
    }
    f.done(&args);
    assert!(f.get("out/killed.npz") == f.get("straight.npz"), "resumed work differs");
    assert!(!f.path().join("out/killed.npz.checkpoint").exists());
}

// Guards (determinism): interrupted and resumed solves have the bits of uninterrupted ones.
/// Weak absorption makes the iteration long in these ducts: in one band, and in bands that temperatures couple.
#[test]
fn solve_killed_during_iteration_has_identical_bytes() {
    let grey = "[solve]
patch_rule = 'voxels'
engine = 'spectral'
residual = 1e-12
[[surface]]
name = 'duct'
room = { min = [0,0,0], max = [1,1,8] }
reflectance = 0.98
faces.z0 = { emission = 1 }
[medium]
min = [0,0,0]
max = [1,1,8]
cells = [16,16,128]
extinction = 0.1
albedo = 0.5
";
    kill_in_stages(grey, &["state-gradients"]);
    let gases = "mode = 'thermal'
[solve]
patch_size = 0.3333334
engine = 'dense'
residual = 1e-12
[thermal]
weights = [[0.65, -5.5e-4, 3e-7, -5.3e-11], [-0.025, 6.1e-4, -3.9e-7, 6.5e-11], 'rest']
range = [600, 2400]
[[surface]]
name = 'duct'
room = { min = [0,0,0], max = [1,1,8] }
temperature = 700
emissivity = [0.02, 0.01, 0.03]
faces.z0 = { temperature = 1800, emissivity = [0.8, 0.3, 0.1] }
faces.x1.heat_flux = 0
[medium]
min = [0,0,0]
max = [1,1,8]
cells = [3,3,24]
extinction = [0.4, 2.5, 0]
albedo = [0.1, 0.3, 0]
heat_source = 2000
";
    kill_in_stages(gases, &["state-temperatures-linear", "state-temperatures"]);
}

#[test]
fn checkpoint_of_another_scene_is_discarded() {
    let f = Folder::new();
    f.put("room.toml", ROOM);
    std::fs::create_dir(f.path().join("kept")).unwrap();
    f.put("kept/notes.txt", "mine");
    // The checkpoint of another scene, as a killed solve would leave it.
    f.put("kept/zonal.key", "zonal 0.0.0 another scene\n");
    f.put("kept/light-0.stage", "torn");
    let args = ["solve", "room.toml", "-o", "room.npz", "--checkpoint", "kept"];
    let o = f.zonal(&[&args[..], &["--resume"]].concat());
    assert!(
        o.status.success() && text(&o.stderr).contains("starting from the beginning"),
        "{}",
        text(&o.stderr)
    );
    assert!(f.get("room.npz") == solution());
    // Without --resume there is no note. Foreign files stay.
    f.put("kept/zonal.key", "zonal 0.0.0 another scene\n");
    let o = f.zonal(&args);
    assert!(o.status.success() && o.stderr.is_empty(), "{}", text(&o.stderr));
    assert_eq!(std::fs::read_dir(f.path().join("kept")).unwrap().count(), 1);
    assert_eq!(f.get("kept/notes.txt"), b"mine");
}
