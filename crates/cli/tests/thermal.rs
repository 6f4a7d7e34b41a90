//! Thermal mode through the command: the furnace of the manual, its exports, total exchange areas, refused commands.

use crate::support;

use support::Folder;

const FURNACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/furnace.toml");

fn array(f: &Folder, file: &str, name: &str) -> (Vec<usize>, Vec<f64>) {
    zonal_io::output::read_array(&f.path().join(file), name).unwrap()
}

#[test]
fn furnace_fluxes_match_the_reference() {
    let f = Folder::new();
    let walls = ["furnace.z0", "furnace.z1", "furnace.x0"];
    // Constant and linear basis; the latter is close to the limit of fine zones.
    for (basis, expected, tolerance) in
        [("constant", [54715.3, -24559.8, -6269.4], 0.051), ("auto", [53900.0, -24256.0, -6205.0], 60.0)]
    {
        let args = ["solve", FURNACE, "-o", "out/a.npz", "--json", "--zone-basis", basis];
        let json: serde_json::Value = serde_json::from_str(&f.done(&args)).unwrap();
        let rows = json["heat"]["rows"].as_array().unwrap();
        let row = |name: &str| rows.iter().find(|r| r["name"] == name).unwrap();
        for (name, expected) in walls.iter().zip(expected) {
            let q = row(name)["net_flux"].as_f64().unwrap();
            assert!((q - expected).abs() < tolerance, "{basis}, {name}: {q}");
            assert_eq!(row(name)["net_flux_unit"], "W/m2");
            // The discretization error covers the difference to the limit of fine zones; the exchange error is separate.
            let limit = [53882.4, -24249.9, -6204.9][walls.iter().position(|w| w == name).unwrap()];
            let error = row(name)["net_flux_discretization_error"].as_f64().unwrap();
            assert!(error > (q - limit).abs() && error < 0.08 * q.abs(), "{basis}, {name}: {error}");
            let exchange = row(name)["net_flux_exchange_error"].as_f64().unwrap();
            assert!(exchange < 1e-3 && row(name)["net_flux_error"].as_f64().unwrap() > error);
        }
        assert!((row("medium")["net_power_W"].as_f64().unwrap() - 80e3).abs() < 1e-6);
    }
    let (shape, kelvin) = array(&f, "out/a.npz", "temperature");
    assert_eq!(shape, [288]);
    assert!(kelvin.iter().all(|t| (400.0..1201.0).contains(t)));
    let without = ["solve", FURNACE, "-o", "out/b.npz", "--json", "--discretization-error", "false"];
    let json: serde_json::Value = serde_json::from_str(&f.done(&without)).unwrap();
    assert!(
        json["discretization_error"].is_null()
            && json["heat"]["rows"][0]["net_flux_discretization_error"].is_null()
    );
    let json: serde_json::Value = serde_json::from_str(&f.done(&["check", FURNACE, "--json"])).unwrap();
    let last = json["phases"].as_array().unwrap().last().unwrap();
    assert!(last["phase"].as_str().unwrap().starts_with("the same on "), "{last}");
}

#[test]
fn furnace_is_exported_and_commands_for_light_are_refused() {
    let f = Folder::new();
    // The text report has the table of the manual.
    let text = f.done(&["solve", FURNACE, "-o", "out/a.npz"]);
    for word in ["net power by part", "furnace.z0", "W/m2", "balance"] {
        assert!(text.contains(word), "{word} is not in\n{text}");
    }
    for (file, words) in [
        ("out/walls.vtu", ["temperature [K]", "net flux [W/m2]"]),
        ("out/gas.vti", ["temperature [K]", "net heat [W/m3]"]),
        ("out/zones.csv", ["temperature_K", "net_error"]),
    ] {
        f.done(&["export", "out/a.npz", "-o", file]);
        let bytes = f.get(file);
        let head = String::from_utf8_lossy(&bytes[..bytes.len().min(6000)]).into_owned();
        assert!(words.iter().all(|w| head.contains(w)), "{file}: {head}");
    }
    // Commands for light are refused with the alternatives.
    for args in [
        vec!["render", "out/a.npz", "-o", "out/x.png"],
        vec!["relight", "out/a.npz", "medium=2", "-o", "out/x.npz"],
        vec!["export", "out/a.npz", "-o", "out/x.glb"],
        vec!["view", "out/a.npz"],
    ] {
        let o = f.zonal(&args);
        let error = support::text(&o.stderr);
        assert_eq!(o.status.code(), Some(2), "{args:?}");
        assert!(error.contains("thermal") && error.contains(".vtu"), "{args:?}: {error}");
    }
}

#[test]
fn total_exchange_areas_of_the_furnace_close() {
    let f = Folder::new();
    let json: serde_json::Value =
        serde_json::from_str(&f.done(&["exchange", FURNACE, "-o", "out/t.npz", "--json"])).unwrap();
    assert_eq!((json["zones"].as_u64(), json["matrices"].as_u64()), (Some(288), Some(1)));
    assert!(json["largest_total_row_defect"].as_f64().unwrap() < 1e-9);
    let n = 288;
    let (shape, t) = array(&f, "out/t.npz", "total_exchange_areas");
    let (_, radii) = array(&f, "out/t.npz", "total_error_radius");
    let (_, closure) = array(&f, "out/t.npz", "total_closure");
    assert_eq!(shape, [1, n, n]);
    for i in 0..n {
        let (row, radius) = (&t[i * n..(i + 1) * n], &radii[i * n..(i + 1) * n]);
        let (sum, error): (f64, f64) = (row.iter().sum(), radius.iter().sum());
        assert!((sum - closure[i]).abs() <= error + 1e-13 * closure[i], "row {i}");
        assert!(error < 1e-7 * closure[i] && row.iter().all(|x| *x >= 0.0));
        assert!((0..n).all(|j| row[j] == t[j * n + i]));
    }
    let (shape, named) = array(&f, "out/t.npz", "named_exchange_areas");
    assert_eq!(shape, [1, 7, 7]);
    // ε A of the bottom, 4 κ V of the gas.
    let sum = |k: usize| named[7 * k..7 * k + 7].iter().sum::<f64>();
    assert!((sum(4) - 0.85 * 4.0).abs() < 1e-8 && (sum(6) - 4.0 * 0.5 * 16.0).abs() < 1e-7);
    // Direct areas only: the same.
    f.done(&["exchange", FURNACE, "-o", "out/d.npz", "--direct-only"]);
    assert_eq!(array(&f, "out/d.npz", "exchange_areas"), array(&f, "out/t.npz", "exchange_areas"));
    assert!(zonal_io::output::read_array(&f.path().join("out/d.npz"), "total_exchange_areas").is_err());
}

// Guards (numbers): an unknown error is infinite and never printed as a number.
/// An unknown error is printed as such, and is null in JSON, also in sums. An error that was not requested is absent, and the heading says so.
#[test]
fn unknown_errors_are_printed_as_unknown() {
    let f = Folder::new();
    let scene = "mode = \"thermal\"\n[solve]\npatch_size = 0.09\n[[surface]]\nname = \"room\"\nroom = { min = [0,0,0], max = [1,1,1] }\ntemperature = 300\nemissivity = 0.8\nfaces.z0 = { temperature = 1000 }\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [1,1,1]\nextinction = 0.2\nheat_source = 0\n";
    f.put("a.toml", scene);
    let text = f.done(&["solve", "a.toml", "-o", "a.npz"]);
    // The known error of the exchange stands beside it, for net flux and net power of six walls.
    let walls: Vec<&str> = text.lines().filter(|l| l.contains("room.") && l.contains(" m2 ")).collect();
    assert_eq!(walls.len(), 6, "{text}");
    assert!(walls.iter().all(|l| l.matches(" ± unknown (exchange ").count() == 2), "{text}");
    let json: serde_json::Value =
        serde_json::from_str(&f.done(&["solve", "a.toml", "-o", "a.npz", "--json"])).unwrap();
    let wall = &json["heat"]["rows"][0];
    for key in ["net_power_discretization_error_W", "net_power_error_W", "net_flux_error"] {
        assert!(wall.as_object().unwrap().contains_key(key) && wall[key].is_null(), "{wall}");
    }
    // The known part stands beside.
    assert!(
        wall["net_power_exchange_error_W"].is_number() && wall["net_flux_exchange_error"].is_number(),
        "{wall}"
    );
    let medium = &json["heat"]["rows"][6];
    assert!(medium["temperature_error_K"].is_null() && medium["net_power_error_W"] == 0.0, "{medium}");
    // The solution file keeps unknown errors.
    f.done(&["export", "a.npz", "-o", "a.csv"]);
    let text = f.done(&["solve", "a.toml", "-o", "a.npz", "--discretization-error", "false"]);
    assert!(text.contains("± of the exchange only") && !text.contains("unknown"), "{text}");
}

#[test]
fn nodes_are_printed_and_survive_their_file() {
    let f = Folder::new();
    f.put(
        "scene.toml",
        "mode = \"thermal\"\n[solve]\ndiscretization_error = false\n[[node]]\nname = \"skin\"\nlinks = [{ to = \"tank\", effective_emissivity = 0.02 }]\n[[node]]\nname = \"tank\"\nnet_power = 5\n[[surface]]\nname = \"room\"\nroom = { min = [0,0,0], max = [1,1,1] }\nemissivity = 1\nheat_transfer_coefficient = 4\nambient_temperature = 290\n[[surface]]\nname = \"body\"\nbox = { min = [0.4,0.4,0.4], max = [0.6,0.6,0.6] }\nemissivity = 0.5\nnode = \"skin\"\n",
    );
    let text = f.done(&["solve", "scene.toml", "-o", "a.npz"]);
    assert!(text.contains("radiated, W") && text.contains("  tank"), "{text}");
    let json: serde_json::Value =
        serde_json::from_str(&f.done(&["solve", "scene.toml", "-o", "a.npz", "--json"])).unwrap();
    let supplied = json["heat"]["nodes"][1]["supplied_W"].as_f64().unwrap();
    assert!((supplied - 5.0).abs() < 1e-6, "{json}");
    let path = f.path().join("a.npz");
    let solution = zonal_io::output::read_solution(&path).unwrap();
    assert_eq!(solution.report.heat.as_ref().unwrap().nodes.len(), 2);
    assert_eq!(zonal_io::output::solution_bytes(&solution).unwrap(), std::fs::read(&path).unwrap());
    // Their exchange areas have no states.
    f.done(&["exchange", "scene.toml", "-o", "areas.npz", "--direct-only"]);
    let refused = f.zonal(&["update", "areas.npz", "-o", "q.csv"]);
    assert_eq!(refused.status.code(), Some(2));
}
