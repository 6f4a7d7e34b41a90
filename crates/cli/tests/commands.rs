//! Subcommands from input to output; identical files for any number of threads.

use crate::support;

use support::{COLUMNS, Folder, Program, ROOM, VOXELS, refused, solution, text};

#[test]
fn every_command_has_help() {
    let f = Folder::new();
    for command in [
        "demo",
        "check",
        "solve",
        "relight",
        "render",
        "view",
        "init",
        "export",
        "report",
        "exchange",
        "factors",
        "gas",
        "keys",
        "reproduce",
        "validate",
    ] {
        assert!(f.done(&[command, "--help"]).contains("Usage: zonal"));
        assert!(f.done(&["--help"]).contains(command));
    }
    assert_eq!(f.done(&["--version"]).trim(), concat!("zonal ", env!("CARGO_PKG_VERSION")));
    assert_eq!(f.listing().len(), 1);
}

// Guards (files): `check` refuses what `solve` refuses.
/// A scene that `solve` would refuse is not valid; the exit code is that of `solve`.
#[test]
fn check_refuses_what_solve_refuses() {
    let f = Folder::new();
    f.put("room.toml", ROOM);
    for command in [
        &["check", "room.toml", "--max-memory", "1e-7"][..],
        &["check", "room.toml", "--max-memory", "1e-7", "--json"],
    ] {
        let out = f.zonal(command);
        let (message, error) = (String::from_utf8_lossy(&out.stdout), String::from_utf8_lossy(&out.stderr));
        assert_eq!(out.status.code(), Some(2), "{message}{error}");
        assert!(
            !message.contains(": valid")
                && !message.contains("\"valid\"")
                && error.contains("error:")
                && error.contains("GB"),
            "{message}{error}"
        );
        assert!(message.contains("refuse"), "{message}");
    }
}

/// The power of every light is sampled by rays, even with few zones.
#[test]
fn check_estimates_time_of_many_lights() {
    let f = Folder::new();
    let sun = "[[light]]\nkind = \"sun\"\ndirection = [0,0,-1]\nirradiance = 1\n";
    let floor = "[solve]\npatch_size = 0.5\n[[surface]]\nrectangle = { origin = [0,0,0], edge1 = [1,0,0], edge2 = [0,1,0] }\n";
    f.put("suns.toml", format!("{floor}{}", sun.repeat(800)));
    let json: serde_json::Value = serde_json::from_str(&f.done(&["check", "suns.toml", "--json"])).unwrap();
    // 1e8 rays.
    assert!(json["direct_light_seconds"].as_f64().unwrap() > 0.1, "{json}");
}

#[test]
fn scene_is_checked_solved_drawn_and_exported() {
    let f = Folder::new();
    f.put("room.toml", ROOM);
    assert!(f.done(&["check", "room.toml"]).contains("room.toml: valid"));
    let json: serde_json::Value = serde_json::from_str(&f.done(&["check", "room.toml", "--json"])).unwrap();
    assert_eq!((json["patches"].as_u64(), json["voxel_zones"].as_u64()), (Some(6), Some(8)));
    let report: serde_json::Value = serde_json::from_str(&f.done(&[
        "solve",
        "room.toml",
        "-o",
        "out/room.npz",
        "--json",
        "--closure",
        "restore",
    ]))
    .unwrap();
    assert!(report["energy"]["residual"][0].as_f64().unwrap().abs() < 1e-6, "{report}");
    f.done(&["render", "out/room.npz", "--size", "16x12", "--samples", "1", "-o", "out/room.png"]);
    f.done(&[
        "render",
        "out/room.npz",
        "--camera",
        "door",
        "--size",
        "16x12",
        "--samples",
        "4",
        "-o",
        "out/room.exr",
    ]);
    f.done(&["export", "out/room.npz", "-o", "out/room.csv"]);
    assert!(f.get("out/room.png").starts_with(b"\x89PNG"));
    assert!(f.get("out/room.exr").starts_with(&[0x76, 0x2f, 0x31, 0x01]));
    assert_eq!(text(&f.get("out/room.csv")).lines().count(), 1 + 14);
    // Four outputs and no temporary files.
    assert_eq!(std::fs::read_dir(f.path().join("out")).unwrap().count(), 4);
}

/// Default values of the options give the same picture; other values another one. The report counts clipped pixels.
#[test]
fn picture_options_change_the_picture() {
    let f = Folder::new();
    f.put("room.npz", solution());
    let draw = |more: &[&str]| {
        let args = ["render", "room.npz", "--size", "16x12", "--samples", "4", "-o", "out/x.png", "--json"];
        let report: serde_json::Value = serde_json::from_str(&f.done(&[&args, more].concat())).unwrap();
        (f.get("out/x.png"), report)
    };
    let (plain, report) = draw(&[]);
    assert_eq!(report["clipped"], 0, "{report}");
    assert!(draw(&["--bloom", "0", "--aperture", "0", "--contrast", "1", "--stops", "0"]).0 == plain);
    for option in [["--bloom", "0.2"], ["--aperture", "0.2"], ["--contrast", "1.3"], ["--stops", "1"]] {
        let (other, bloomed) = draw(&option);
        assert!(other != plain, "{option:?}");
        let mean = |r: &serde_json::Value| r["mean"][0].as_f64().unwrap();
        assert!(
            (mean(&bloomed) / mean(&report) - 1.0).abs() < if option[0] == "--aperture" { 0.1 } else { 1e-6 }
        );
    }
    assert_eq!(draw(&["--stops", "20"]).1["clipped"], 16 * 12);
}

// Guards (determinism): files of the command are identical for any number of threads.
#[test]
fn files_are_identical_for_any_number_of_threads() {
    let f = Folder::new();
    f.put("room.toml", ROOM);
    f.put("pairs.csv", format!("{COLUMNS}\n{VOXELS}\n{VOXELS}\n"));
    for n in ["1", "2", "5"] {
        f.done(&["solve", "room.toml", "-o", &format!("{n}.npz"), "--threads", n]);
        f.done(&[
            "render",
            "1.npz",
            "--size",
            "16x12",
            "--samples",
            "2",
            "-o",
            &format!("{n}.png"),
            "--threads",
            n,
        ]);
        f.done(&["factors", "pairs.csv", "-o", &format!("{n}.csv"), "--threads", n]);
    }
    for ending in ["npz", "png", "csv"] {
        let one = f.get(&format!("1.{ending}"));
        assert!(
            one == f.get(&format!("2.{ending}")) && one == f.get(&format!("5.{ending}")),
            "{ending} differs"
        );
    }
    assert!(f.get("1.npz") == solution(), "the default number of threads differs");
}

/// `zonal check scene.toml | head -1` ends quietly.
#[test]
fn closed_pipe_causes_no_panic() {
    let f = Folder::new();
    f.put("room.toml", ROOM);
    for args in [["check", "room.toml"].as_slice(), &["solve", "room.toml", "-o", "out/x.npz"]] {
        let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_zonal"));
        let piped = std::process::Stdio::piped;
        let mut child =
            child.args(args).current_dir(f.path()).stdout(piped()).stderr(piped()).spawn().unwrap();
        drop(child.stdout.take());
        let o = child.wait_with_output().unwrap();
        assert!(!text(&o.stderr).contains("panicked"), "{args:?}:\n{}", text(&o.stderr));
        assert!(matches!(o.status.code(), Some(0 | 2)), "{args:?}: {:?}", o.status);
    }
}

#[test]
fn outputs_are_replaced_as_a_whole() {
    let f = Folder::new();
    f.put("room.npz", solution());
    f.put("out/x.csv", "an earlier table, longer than a line");
    f.done(&["export", "room.npz", "-o", "out/x.csv"]);
    assert!(text(&f.get("out/x.csv")).starts_with("zone,"));
    // A name without a folder goes to the current one.
    f.done(&["export", "room.npz", "-o", "x.csv"]);
    assert_eq!(f.get("x.csv"), f.get("out/x.csv"));
}

#[test]
fn written_demo_scene_is_valid() {
    let f = Folder::new();
    f.done(&["demo", "chapel", "--size", "small", "--write", "chapel.toml"]);
    assert!(f.done(&["check", "chapel.toml"]).contains("cameras: nave, aisle"));
}

// Guards (numbers): methods take a tolerance and return value, radius and grade; a proved radius contains the true value and meets the tolerance.
/// The reference table of `crates/exchange` through the command: proved bounds hold and meet the tolerance.
#[test]
fn factors_meet_the_reference_table() {
    const TOLERANCE: f64 = 1e-12;
    // Relative error of the reference table.
    const TABLE_ERROR: f64 = 2e-14;
    let f = Folder::new();
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../exchange/tests/data/direct_exchange.csv");
    f.put("pairs.csv", std::fs::read(path).unwrap());
    f.done(&["factors", "pairs.csv", "--tolerance", &TOLERANCE.to_string(), "-o", "factors.csv"]);
    let table = text(&f.get("factors.csv"));
    let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    assert_eq!(header[17..], ["value", "error_bound", "grade", "method"]);
    let want = header.iter().position(|h| *h == "geometric_factor").unwrap();
    let mut rows = 0;
    for line in table.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let [reference, value, bound] = [want, 17, 18].map(|k| cells[k].parse::<f64>().unwrap());
        assert!((value - reference).abs() <= bound + TABLE_ERROR * reference.abs(), "{line}");
        assert!(bound <= TOLERANCE * value.abs(), "{line}");
        assert_eq!(cells[19], "proved", "{line}");
        assert!(!cells[20].is_empty(), "{line}");
        rows += 1;
    }
    assert_eq!(rows, 190);
}

/// With --timings the report has the times of all phases: a table, or a key of the JSON object. The solution has the same bytes.
#[test]
fn timings_are_part_of_every_report() {
    let f = Folder::new();
    f.put(
        "room.toml",
        "[[surface]]\nname = 'r'\nroom = { min = [0,0,0], max = [1,1,1] }\nreflectance = 0.5\nfaces.x0 = { emission = 1 }\n",
    );
    f.done(&["solve", "room.toml", "-o", "plain.npz"]);
    let text = f.done(&["solve", "room.toml", "-o", "timed.npz", "--timings"]);
    let table = &text[text.find("timings").unwrap()..];
    assert!(
        ["reading", "engine", "writing", "other", "total"].iter().all(|phase| table.contains(phase)),
        "{text}"
    );
    assert_eq!(f.get("timed.npz"), f.get("plain.npz"));
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\n";
    f.put("mesh.obj", mesh);
    let picture = [
        "render",
        "plain.npz",
        "--size",
        "8x8",
        "--from",
        "0.5,0.5,0.5",
        "--look-at",
        "1,1,1",
        "-o",
        "a.png",
    ];
    let factors = ["view-factors", "mesh.obj", "-o", "f.npz"];
    for (args, phase) in [(&picture[..], "render"), (&factors, "view factors")] {
        let json: serde_json::Value =
            serde_json::from_str(&f.done(&[args, &["--json", "--timings"]].concat())).unwrap();
        let phases = json["timings"]["phases"].as_array().unwrap();
        let sum: f64 = phases.iter().map(|p| p["wall_s"].as_f64().unwrap()).sum();
        assert!(phases.iter().any(|p| p["name"] == phase), "{json}");
        assert!((sum - json["timings"]["wall_s"].as_f64().unwrap()).abs() < 1e-6, "{json}");
    }
}

/// Exchange areas of a room: symmetric to the bit, closed within their radii.
#[test]
fn exchange_areas_obey_reciprocity_and_closure() {
    let f = Folder::new();
    let medium = "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[2,2,2]\nextinction=[0,1,2]\n";
    let room = "[solve]\npatch_size=0.5\n[[surface]]\nname=\"room\"\nroom={min=[0,0,0],max=[1,1,1]}\n";
    f.put("room.toml", format!("{room}{medium}"));
    let json: serde_json::Value =
        serde_json::from_str(&f.done(&["exchange", "room.toml", "-o", "out/f.npz", "--json"])).unwrap();
    assert_eq!((json["zones"].as_u64(), json["matrices"].as_u64()), (Some(32), Some(3)));
    assert_eq!(json["grade"], "proved");
    let array = |name: &str| zonal_io::output::read_array(&f.path().join("out/f.npz"), name).unwrap();
    let ((shape, areas), (_, radii), (_, closure)) =
        (array("exchange_areas"), array("error_radius"), array("closure"));
    assert_eq!(shape, [3, 32, 32]);
    for (k, row) in areas.chunks(32).enumerate() {
        let (b, i) = (k / 32, k % 32);
        let radius: f64 = radii[k * 32..(k + 1) * 32].iter().sum();
        let sum: f64 = row.iter().sum();
        assert!((sum - closure[k]).abs() <= radius + 1e-14 * closure[k], "band {b}, zone {i}: {sum}");
        assert!(radius <= 1.1e-9 * closure[k]);
        assert!((0..32).all(|j| row[j] == areas[(b * 32 + j) * 32 + i]));
        // The first band has no extinction: its volumes exchange nothing.
        assert_eq!(closure[k] == 0.0, b == 0 && i >= 24);
    }
}

/// A solve with the formulas of the paper is close to the exact one, and its report names the formula.
#[test]
fn paper_formulas_are_close_to_exact_factors() {
    let f = Folder::new();
    let medium = "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[5,4,4]\nextinction=1\nalbedo=0.9\n";
    let room = "[solve]\npatch_size=0.5\n[[surface]]\nname=\"room\"\nroom={min=[0,0,0],max=[1,1,1]}\nfaces.x0={emission=1}\n";
    f.put("room.toml", format!("{room}{medium}"));
    let mut mean = Vec::new();
    for factors in ["exact", "series", "prop1", "point"] {
        let out = format!("out/{factors}.npz");
        let report = f.done(&["solve", "room.toml", "-o", &out, "--factors", factors]);
        assert_eq!(report.contains("formula of the paper"), factors != "exact");
        let (_, b) = zonal_io::output::read_array(&f.path().join(&out), "radiosity").unwrap();
        mean.push(b.iter().sum::<f64>() / b.len() as f64);
    }
    let off: Vec<f64> = mean[1..].iter().map(|m| (m / mean[0] - 1.0).abs()).collect();
    assert!(off[0] > 1e-5 && off[0] < 0.03, "{off:?}");
    assert!((off[0] - off[1]).abs() < 1e-6, "{off:?}");
    assert!(off[2] > 1e-3 && off[2] < 0.1, "{off:?}");
}

/// All links of the page of a small reproduction exist.
#[test]
fn reproduction_page_has_valid_links() {
    let f = Folder::new();
    f.done(&["reproduce", "--size", "small", "-o", "out/paper", "--quiet"]);
    let page = text(&f.get("out/paper/README.md"));
    let mut links = 0;
    for link in page.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
        if !link.contains('/') {
            assert!(f.path().join("out/paper").join(link).is_file(), "{link}");
            links += 1;
        }
    }
    assert!(links >= 15, "{links} links");
    assert!(page.contains("-0.179395297") && page.contains("-0.001666635"));
}

// Guards (files): warnings fail a strict run.
/// With --strict a warning ends with exit code 1; outputs are written all the same, and the JSON report names the warning.
#[test]
fn strict_ends_with_1_on_warnings() {
    let f = Folder::new();
    let room = |steps: usize| {
        format!(
            "[solve]\npatch_size = 0.5\ntolerance = 0.05\nmax_iterations = {steps}\n[[surface]]\nname = 'r'\nroom = {{ min = [0,0,0], max = [1,1,1] }}\nreflectance = 0.9\nfaces.x0 = {{ emission = 1 }}\n"
        )
    };
    f.put("good.toml", room(500));
    f.put("short.toml", room(1));
    f.done(&["solve", "good.toml", "-o", "good.npz", "--strict"]);
    f.done(&["solve", "short.toml", "-o", "short.npz"]);
    let out = f.zonal(&["solve", "short.toml", "-o", "strict.npz", "--strict", "--json"]);
    assert_eq!(out.status.code(), Some(1));
    assert_eq!(f.get("strict.npz"), f.get("short.npz"));
    let json: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    let note = &json["warnings"][0];
    assert_eq!((note["severity"].as_str(), note["code"].as_str()), (Some("warning"), Some("not-converged")));
    assert!(note["text"].as_str().unwrap().contains("max_iterations") && note["location"].is_null());
    // Exchange areas report parts that are left out.
    let cube = |name: &str, lo: f64, hi: f64| {
        format!("[[surface]]\nname = '{name}'\nbox = {{ min = [{lo},{lo},{lo}], max = [{hi},{hi},{hi}] }}\n")
    };
    f.put("hidden.toml", room(500) + &cube("outer", 0.2, 0.7) + &cube("hidden", 0.3, 0.5));
    let message = f.done(&["exchange", "hidden.toml", "-o", "hidden.npz"]);
    assert!(message.contains("warning") && message.contains("hidden"), "{message}");
    let out = f.zonal(&["exchange", "hidden.toml", "-o", "hidden2.npz", "--strict", "--json"]);
    assert_eq!(out.status.code(), Some(1));
    assert_eq!(f.get("hidden.npz"), f.get("hidden2.npz"));
    let json: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    assert!(json["warnings"].as_array().unwrap().iter().any(|w| w["severity"] == "warning"), "{json}");
}

#[test]
fn gas_models_are_listed_evaluated_and_plotted() {
    let f = Folder::new();
    let list: serde_json::Value = serde_json::from_str(&f.done(&["gas", "--json"])).unwrap();
    let names: Vec<&str> = list.as_array().unwrap().iter().map(|m| m["name"].as_str().unwrap()).collect();
    assert_eq!(names.len(), 7);
    let flue_gas = ["--h2o", "0.2", "--co2", "0.1", "--temperature", "1200"];
    for name in &names {
        let arguments = [&["gas", name, "--length", "1", "--length", "2", "--json"][..], &flue_gas].concat();
        let found: serde_json::Value = serde_json::from_str(&f.done(&arguments)).unwrap();
        let [one, two] = [0, 1].map(|i| found["emissivity"][i]["emissivity"].as_f64().unwrap());
        assert!(*name == "grey-soot" || 0.2 < one && one < two && two < 0.5, "{name}: {one} {two}");
        assert!(found["model_error"].is_null() && found["gases"][0]["weight"].is_number());
    }
    let text = f.done(&[&["gas", "wsgg-bordbar-2020", "-o", "out/plot.svg"][..], &flue_gas].concat());
    assert!(text.contains("0.311102") && text.contains("not known"), "{text}");
    assert!(String::from_utf8_lossy(&f.get("out/plot.svg")).contains("total emissivity"));
}

#[test]
fn wrong_gas_states_are_refused() {
    let f = Folder::new();
    refused(&f, Program, &["gas", "wsgg-bordbar"], "wsgg-bordbar-2020");
    refused(&f, Program, &["gas", "grey-soot", "--soot", "2"], "--soot");
    refused(&f, Program, &["gas", "wsgg-smith-1982", "--h2o", "0.7", "--co2", "0.5"], "--h2o");
    refused(&f, Program, &["gas", "wsgg-smith-1982", "--length=-1"], "--length");
    refused(&f, Program, &["gas", "wsgg-smith-1982", "-o", "plot.png"], "plot.png");
    let cold = f.zonal(&["gas", "wsgg-smith-1982", "--temperature", "300", "--co2", "0.1", "--strict"]);
    assert_eq!(cold.status.code(), Some(1), "{}", text(&cold.stderr));
}
