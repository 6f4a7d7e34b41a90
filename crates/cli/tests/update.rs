//! `zonal exchange` as text, and `zonal update`.

use crate::support;

use std::process::Command;
use support::{Folder, Program, refused, text};

const ROOM: &str = "mode = 'thermal'
[solve]
patch_size = 0.5
residual = 1e-14
discretization_error = false
engine = 'dense'
[[surface]]
name = 'room'
room = { min = [0, 0, 0], max = [1, 1, 1] }
temperature = 500
emissivity = 0.6
faces.z0 = { temperature = 900 }
faces.z1 = { heat_flux = 0 }
";

fn factors(scene: &str, options: &[&str]) -> Folder {
    let f = Folder::new();
    f.put("room.toml", scene);
    f.done(&[&["exchange", "room.toml", "-o", "f.npz"], options].concat());
    f
}

/// The numbers of a column by the first cell of the rows.
fn column(table: &str, name: &str) -> Vec<f64> {
    let at = table.lines().next().unwrap().split(',').position(|c| c == name).unwrap();
    table.lines().skip(1).map(|l| l.split(',').nth(at).unwrap().parse().unwrap()).collect()
}

#[test]
fn updates_equal_fresh_solves() {
    let f = factors(ROOM, &["--tolerance", "1e-11"]);
    f.put("t.csv", "name,T\nroom.z0,1100\nroom.x0,400\n");
    f.put("e.csv", "room,0.3\n");
    f.put("q.csv", "room.z1,150\n");
    let report = f.done(&[
        "update",
        "f.npz",
        "--temperatures",
        "t.csv",
        "--emissivities",
        "e.csv",
        "--powers",
        "q.csv",
        "-o",
        "out.csv",
        "--json",
    ]);
    let json: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert_eq!(json["parts"][0]["name"], "room.x0");
    let changed =
        ROOM.replace("900", "1100").replace("0.6", "0.3").replace("heat_flux = 0", "net_power = 150")
            + "faces.x0 = { temperature = 400 }\n";
    f.put("new.toml", changed);
    let solved: serde_json::Value =
        serde_json::from_str(&f.done(&["solve", "new.toml", "-o", "new.npz", "--json"])).unwrap();
    let rows = solved["heat"]["rows"].as_array().unwrap();
    let table = text(&f.get("out.csv"));
    let (powers, kelvin) = (column(&table, "net_power_W"), column(&table, "temperature_K"));
    assert_eq!(rows.len(), 6);
    for (k, row) in rows.iter().enumerate() {
        let of = |name: &str| row[name].as_f64().unwrap_or_else(|| panic!("{row}"));
        assert!((powers[k] - of("net_power_W")).abs() < 1e-6, "{k}: {} {row}", powers[k]);
        assert!((kelvin[k] - of("temperature_K")).abs() < 1e-7, "{k}: {} {row}", kelvin[k]);
    }
    // By zone, as numbers alone.
    f.put("zones.csv", "450\n".repeat(24));
    f.done(&["update", "f.npz", "--temperatures", "zones.csv", "-o", "zones.npy"]);
    assert_eq!(f.get("zones.npy").len(), 128 + 8 * 24 * 11);
}

#[test]
fn wrong_tables_and_files_are_refused() {
    let f = factors(ROOM, &["--direct-only"]);
    f.put("short.csv", "T\n300\n400\n");
    f.put("cold.csv", "room.z0,-5\n");
    f.put("names.csv", "roof,300\n");
    f.put("twice.csv", "room,300\nroom.z0,400\n");
    f.put("bad.npz", "PK");
    let mut damaged = f.get("f.npz");
    let half = damaged.len() / 2;
    damaged.truncate(half);
    f.put("half.npz", damaged);
    for (args, wanted) in [
        (
            ["f.npz", "--temperatures", "short.csv"],
            "short.csv:3: the file has 2 rows of values, and there are 24 zones",
        ),
        (["f.npz", "--temperatures", "cold.csv"], "cold.csv:1: -5 K is out of range; give kelvin"),
        (["f.npz", "--temperatures", "names.csv"], "names.csv:1: there is no 'roof'; the names are: room.x0"),
        (["f.npz", "--temperatures", "twice.csv"], "twice.csv:2: 'room.z0' has two rows; keep one"),
        (["f.npz", "--emissivities", "none.csv"], "none.csv: there is no such file"),
        (["f.npz", "--surroundings-temperature", "0"], "--surroundings-temperature: 0 K is out of range"),
        (["bad.npz", "--temperatures", "short.csv"], "bad.npz"),
        (["half.npz", "--temperatures", "short.csv"], "half.npz"),
    ] {
        refused(&f, Program, &[&["update", "-o", "out.csv"], &args[..]].concat(), wanted);
    }
    let light = "[[surface]]\nroom = { min = [0, 0, 0], max = [1, 1, 1] }\nemission = 1\n";
    let g = factors(light, &["--direct-only"]);
    refused(&g, Program, &["update", "f.npz", "-o", "out.csv"], "no data of a scene in thermal mode");
}

/// A box of five grey gases of two compositions with a wall without heat.
const GAS: &str = "mode = 'thermal'
[solve]
patch_size = 0.5
zone_basis = 'constant'
residual = 1e-14
discretization_error = false
engine = 'dense'
[[surface]]
name = 'room'
room = { min = [0, 0, 0], max = [1, 1, 1] }
temperature = 700
emissivity = 0.6
faces.z1 = { heat_flux = 0 }
[medium]
min = [0, 0, 0]
max = [1, 1, 1]
cells = [2, 2, 2]
temperature = 1300
gas = { model = 'wsgg-bordbar-2020', h2o = 0.2, co2 = 0.1 }
[[medium.region]]
box = { min = [0, 0, 0], max = [1, 1, 0.5] }
gas = { model = 'wsgg-bordbar-2020', h2o = 0.05, co2 = 0.15 }
";

/// An open box below the sun and a lamp.
const LIT: &str = "mode = 'thermal'
[solve]
patch_size = 0.5
residual = 1e-14
discretization_error = false
engine = 'dense'
[[surface]]
name = 'room'
room = { min = [0, 0, 0], max = [1, 1, 1] }
omit = ['z1']
temperature = 700
emissivity = 0.6
solar_absorptance = 0.3
faces.x0 = { emission = 200 }
faces.x1 = { heat_flux = 0 }
[[light]]
kind = 'sun'
direction = [0.1, 0, -1]
irradiance = 900
[[light]]
kind = 'emitter'
surface = 'room.x0'
[surroundings]
temperature = 290
";

#[test]
fn updates_of_gases_and_lights_equal_fresh_solves() {
    for scene in [GAS, LIT] {
        let f = factors(scene, &["--tolerance", "1e-11", "--direct-only"]);
        f.put("t.csv", "room.z0,1100\n");
        let options = ["update", "f.npz", "--temperatures", "t.csv", "-o", "out.csv", "--json"];
        let json: serde_json::Value = serde_json::from_str(&f.done(&options)).unwrap();
        f.put(
            "new.toml",
            scene
                .replace("faces.z1 =", "faces.z0 = { temperature = 1100 }\nfaces.z1 =")
                .replace("faces.x1 =", "faces.z0 = { temperature = 1100 }\nfaces.x1 ="),
        );
        let solved: serde_json::Value =
            serde_json::from_str(&f.done(&["solve", "new.toml", "-o", "new.npz", "--json"])).unwrap();
        let rows = solved["heat"]["rows"].as_array().unwrap();
        let table = text(&f.get("out.csv"));
        let (powers, kelvin) = (column(&table, "net_power_W"), column(&table, "temperature_K"));
        assert_eq!(rows.len(), powers.len());
        let largest = powers.iter().fold(0.0f64, |m, p| m.max(p.abs()));
        for (k, row) in rows.iter().enumerate() {
            let of = |name: &str| row[name].as_f64().unwrap_or_else(|| panic!("{row}"));
            assert!((powers[k] - of("net_power_W")).abs() < 1e-8 * largest, "{k}: {} {row}", powers[k]);
            assert!((kelvin[k] - of("temperature_K")).abs() < 1e-7, "{k}: {} {row}", kelvin[k]);
        }
        let wanted = solved["heat"]["emitters_W"].as_f64().unwrap_or(0.0);
        assert!((json["emitters"].as_f64().unwrap() - wanted).abs() < 1e-9, "{json} {wanted}");
        assert_eq!(wanted, if scene == LIT { 200.0 } else { 0.0 });
        // What errors of the powers explain of the balance of an open box in light.
        let stated: f64 = column(&table, "net_power_exchange_error_W").iter().sum();
        assert!(json["balance"].as_f64().unwrap().abs() <= stated + 1e-6 * largest, "{json}");
    }
}

#[test]
fn nodes_are_refused_with_the_command_that_knows_them() {
    let node = "mode = 'thermal'\n[[node]]\nname = 'body'\n[[surface]]\nroom = { min = [0, 0, 0], max = [1, 1, 1] }\nnode = 'body'\nemissivity = 1\nfaces.z0 = { temperature = 300 }\n";
    let f = factors(node, &["--direct-only"]);
    refused(
        &f,
        Program,
        &["update", "f.npz", "-o", "out.csv"],
        "without nodes and convection, which only zonal solve knows",
    );
}

#[test]
fn matrices_as_text_hold_the_entries_of_the_arrays() {
    let f = factors(ROOM, &[]);
    f.done(&["exchange", "room.toml", "-o", "t.mtx"]);
    f.done(&["exchange", "room.toml", "-o", "d.mtx", "--direct-only"]);
    f.done(&["exchange", "room.toml", "-o", "t.csv"]);
    let read = |name: &str| {
        let file = text(&f.get(name));
        assert!(file.starts_with("%%MatrixMarket matrix coordinate real symmetric\n% "), "{file}");
        assert!(file.contains("Unit: m2") && file.contains("1 to 4: room.x0"), "{file}");
        let mut lines = file.lines().filter(|l| !l.starts_with('%'));
        let mut numbers = |l: &str| l.split(' ').map(|x| x.parse::<f64>().unwrap()).collect::<Vec<f64>>();
        let size = numbers(lines.next().unwrap());
        let mut m = vec![0.0; 24 * 24];
        let mut count = 0;
        for e in lines.map(&mut numbers) {
            let (i, j) = (e[0] as usize - 1, e[1] as usize - 1);
            assert!(j <= i && e[2] != 0.0);
            (m[i * 24 + j], m[j * 24 + i]) = (e[2], e[2]);
            count += 1;
        }
        assert_eq!(size, [24.0, 24.0, count as f64]);
        m
    };
    let (total, direct, error) = (read("t.mtx"), read("d.mtx"), read("t.error.mtx"));
    // Rows of a closed room: εA and A; patches of one wall do not exchange directly.
    for i in 0..24 {
        let sum = |m: &[f64]| m[i * 24..(i + 1) * 24].iter().sum::<f64>();
        assert!((sum(&total) - 0.6 * 0.25).abs() < 1e-9 && (sum(&direct) - 0.25).abs() < 1e-9);
        assert_eq!(direct[i * 24 + i], 0.0);
    }
    assert!(error.iter().all(|e| *e >= 0.0 && *e < 1e-8));
    let table = text(&f.get("t.csv"));
    let [i, j, t] = ["zone_i", "zone_j", "total_m2"].map(|c| column(&table, c));
    assert_eq!(i.len(), 24 * 25 / 2);
    assert!((0..t.len()).all(|k| t[k] == total[i[k] as usize * 24 + j[k] as usize]));
}

#[test]
fn example_scripts_run() {
    let numpy = Command::new("python3").args(["-c", "import numpy"]).output();
    if !numpy.is_ok_and(|o| o.status.success()) {
        eprintln!("skipped: python3 with numpy is missing");
        return;
    }
    for script in ["fin.py", "transient_box.py"] {
        let path = format!("{}/../../examples/{script}", env!("CARGO_MANIFEST_DIR"));
        let o = Command::new("python3").args([&path, env!("CARGO_BIN_EXE_zonal")]).output().unwrap();
        assert!(o.status.success(), "{script}: {}\n{}", text(&o.stdout), text(&o.stderr));
    }
}
