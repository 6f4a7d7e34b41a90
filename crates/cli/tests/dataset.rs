//! `zonal dataset`: samples equal single solves, larger sets begin with smaller ones, interrupted runs continue, wrong input is refused.

use crate::support;

use std::path::Path;
use support::{Folder, Program, refused};
use zonal_io::output::read_array;

const FURNACE: &str = "mode = \"thermal\"\n[solve]\npatch_rule = \"voxels\"\n[[surface]]\nname = \"wall\"\nroom = { min = [0,0,0], max = [1,1,2] }\ntemperature = 900\nemissivity = 0.7\nfaces.z0 = { temperature = 1200, emissivity = 0.85 }\n[medium]\nmin = [0,0,0]\nmax = [1,1,2]\ncells = [2,2,4]\nextinction = 0.5\nheat_source = 5000\n";

const VARY: [&str; 6] = [
    "--vary",
    "medium.heat_source=0:20000",
    "--vary",
    "surface.wall.faces.z0.temperature=normal:1200:50",
    "--vary",
    "surface.*.emissivity=0.5,0.9",
];

fn dataset(f: &Folder, rest: &[&str]) -> String {
    f.done(&[&["dataset", "furnace.toml"], rest, &VARY].concat())
}

fn array(f: &Folder, file: &str, name: &str) -> (Vec<usize>, Vec<f64>) {
    read_array(&f.path().join(file), name).unwrap()
}

// Guards (numbers): samples of a data set equal single solves.
#[test]
fn samples_equal_single_solves() {
    let f = Folder::new();
    f.put("furnace.toml", FURNACE);
    let text = dataset(&f, &["-n", "3", "-o", "set.npz", "--seed", "5"]);
    assert!(text.contains("3 samples: 3 converged"), "{text}");
    assert!(!f.path().join("set.npz.samples").exists());
    let (shape, inputs) = array(&f, "set.npz", "inputs");
    assert_eq!(shape, [3, 3]);
    let (_, residuals) = array(&f, "set.npz", "energy_residual");
    assert!(residuals.iter().all(|r| *r <= 1e-6), "{residuals:?}");
    let names = ["temperature", "net_flux", "net_flux_error"];
    let all = names.map(|name| array(&f, "set.npz", name));
    for (k, own) in inputs.chunks(3).enumerate() {
        let [source, temperature, emissivity] = [own[0], own[1], own[2]];
        let scene = FURNACE
            .replace("heat_source = 5000", &format!("heat_source = {source:?}"))
            .replace("temperature = 1200", &format!("temperature = {temperature:?}"))
            .replace("emissivity = 0.7", &format!("emissivity = {emissivity:?}"));
        f.put("one.toml", &scene);
        f.done(&[
            "solve",
            "one.toml",
            "-o",
            "one.npz",
            "--engine",
            "spectral",
            "--discretization-error",
            "false",
        ]);
        for (name, (shape, values)) in ["temperature", "net", "net_error"].iter().zip(&all) {
            let n = shape[1];
            assert_eq!(array(&f, "one.npz", name).1, values[k * n..(k + 1) * n], "{name} of sample {k}");
        }
    }
}

#[test]
fn discretization_errors_are_those_of_single_solves() {
    let f = Folder::new();
    f.put("furnace.toml", FURNACE);
    dataset(&f, &["-n", "2", "-o", "set.npz", "--discretization-error"]);
    let (shape, errors) = array(&f, "set.npz", "named_power_discretization_error");
    assert_eq!(shape[0], 2);
    assert!(errors.iter().any(|e| *e > 0.0) && errors.iter().all(|e| e.is_finite()), "{errors:?}");
    let is_sum = |file: &str, name: &str| {
        let [whole, exchange, zones] = ["_error", "_exchange_error", "_discretization_error"]
            .map(|part| array(&f, file, &format!("{name}{part}")).1);
        let parts = exchange.iter().zip(&zones);
        whole.iter().zip(parts).all(|(e, (x, z))| *e == x + z || e.is_nan())
    };
    assert!(is_sum("set.npz", "named_power") && is_sum("set.npz", "named_temperature"));
    // In light mode, powers by surface, medium and panes.
    f.put("room.toml", "[solve]\npatch_size = 0.5\n[[surface]]\nname = \"room\"\nroom = { min = [0,0,0], max = [1,1,1] }\nreflectance = 0.5\nfaces.z1 = { emission = 1 }\n");
    let vary = ["--vary", "surface.room.reflectance=0.5:0.5"];
    f.done(
        &[&["dataset", "room.toml", "-n", "1", "-o", "room.npz", "--discretization-error"], &vary[..]]
            .concat(),
    );
    let (shape, absorbed) = array(&f, "room.npz", "absorbed_power");
    assert_eq!(shape, [1, 8, 3]);
    assert!((absorbed.iter().sum::<f64>() - 3.0).abs() < 1e-6, "{absorbed:?}");
    let report = f.done(&["solve", "room.toml", "-o", "one.npz", "--discretization-error", "true", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let one = report["discretization_error"]["energy"]["absorbed_surfaces"][0]["power"][0].as_f64().unwrap();
    let set = array(&f, "room.npz", "absorbed_power_discretization_error").1;
    assert!(one > 0.0 && (set[0] - one).abs() <= 1e-12 * one, "{one} {set:?}");
    assert!(is_sum("room.npz", "absorbed_power"));
}

// Guards (determinism): an interrupted data set ends with the same bytes, and a larger set begins with the smaller one.
#[test]
fn larger_sets_begin_with_smaller_ones_and_interrupted_runs_continue() {
    let f = Folder::new();
    f.put("furnace.toml", FURNACE);
    dataset(&f, &["-n", "40", "-o", "large.npz"]);
    dataset(&f, &["-n", "5", "-o", "small.npz", "--threads", "1"]);
    let [large, small] = ["large.npz", "small.npz"].map(|file| array(&f, file, "temperature").1);
    assert_eq!(large[..small.len()], small);
    // A run that was killed after its first block leaves its samples; the same command ends with the same bytes.
    let folder = f.path().join("again.npz.samples");
    let arguments = [&["dataset", "furnace.toml", "-n", "40", "-o", "again.npz"], &VARY[..]].concat();
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_zonal"))
        .args(&arguments)
        .current_dir(f.path())
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let has_stage = |p: &Path| {
        let entries = std::fs::read_dir(p).into_iter().flatten().flatten();
        entries.into_iter().any(|e| e.file_name() == "samples-000000.stage")
    };
    while !has_stage(&folder) && child.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let _ = child.kill();
    child.wait().unwrap();
    dataset(&f, &["-n", "40", "-o", "again.npz"]);
    let [a, b] = ["large.npz", "again.npz"].map(|file| std::fs::read(f.path().join(file)).unwrap());
    assert!(a == b);
    assert!(!folder.exists());
}

#[test]
fn tables_of_inputs_and_refused_samples() {
    let f = Folder::new();
    f.put("furnace.toml", FURNACE);
    f.put("inputs.csv", "medium.heat_source,surface.wall.emissivity\n1000,0.5\n2000,1.5\n3000,0.9\n");
    let output = f.zonal(&["dataset", "furnace.toml", "--inputs", "inputs.csv", "-o", "set.npz"]);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    // The file is written, the refused sample is named, and the command ends with 1.
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains("sample 1:") && errors.contains("1 samples were refused"), "{errors}");
    let status = zonal_io::output::read_array(&f.path().join("set.npz"), "status").unwrap().1;
    assert_eq!(status, [0.0, 2.0, 0.0]);
}

#[test]
fn wrong_arguments_are_refused() {
    let f = Folder::new();
    f.put("furnace.toml", FURNACE);
    f.put("inputs.csv", "medium.heat_source\nhot\n");
    let with = |rest: &[&'static str]| [&["dataset", "furnace.toml", "-o", "set.npz"], rest].concat();
    for (arguments, message) in [
        (with(&["--vary", "medium.heat=1:2"]), "furnace.toml:13:1: medium.heat: there is no 'heat' here"),
        (with(&["--vary", "medium.heat_source=2:1"]), "give the lower number first"),
        (with(&["--vary", "medium.heat_source"]), "write KEY=LOW:HIGH"),
        (with(&["--vary", "surface.wall.emissivity=2:3"]), "sample 0: furnace.toml:"),
        (with(&["--vary", "medium.heat_source=1:2", "-n", "0"]), "from 1 to"),
        (with(&["--inputs", "inputs.csv"]), "inputs.csv:2: 'hot' is no number"),
        (with(&["--inputs", "none.csv"]), "none.csv"),
    ] {
        refused(&f, Program, &arguments, message);
    }
}
