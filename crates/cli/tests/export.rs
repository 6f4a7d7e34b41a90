//! Files of `zonal export`.

use crate::support;

use support::{Folder, Parser, Program, ROOM, refused, solution, text};

// Guards (determinism): files of the command are identical for any number of threads.
#[test]
fn every_format_is_identical_for_any_number_of_threads() {
    let f = Folder::new();
    f.put("room.npz", solution());
    for n in ["1", "3"] {
        for ending in ["glb", "vtu", "vti"] {
            f.done(&["export", "room.npz", "-o", &format!("out/{n}.{ending}"), "--threads", n]);
        }
    }
    for ending in ["glb", "vtu", "vti", "medium.npz"] {
        assert!(f.get(&format!("out/1.{ending}")) == f.get(&format!("out/3.{ending}")), "{ending} differs");
    }
    assert_eq!(std::fs::read_dir(f.path().join("out")).unwrap().count(), 8);
    let message = f.done(&["export", "room.npz", "-o", "out/1.glb", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&message).unwrap();
    assert_eq!(json["beside"][0], "out/1.medium.npz");
    assert!(json["triangles"].as_u64().unwrap() >= 12);
}

/// The values of an array of a VTK file with appended data.
fn array(file: &[u8], name: &str) -> Vec<f64> {
    let words = text(file);
    let line =
        words.lines().find(|l| l.contains(&format!("Name=\"{name}\""))).expect("the array is declared");
    let offset: usize = line.split("offset=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
    let start = file.windows(3).position(|w| w == b">\n_").unwrap() + 3 + offset;
    let word = |at: usize| <[u8; 8]>::try_from(&file[at..at + 8]).unwrap();
    let bytes = u64::from_le_bytes(word(start)) as usize;
    (0..bytes / 8).map(|i| f64::from_le_bytes(word(start + 8 * (i + 1)))).collect()
}

#[test]
fn vtk_cell_sums_equal_zone_sums() {
    let f = Folder::new();
    f.put("room.npz", solution());
    for ending in ["csv", "vtu", "vti"] {
        f.done(&["export", "room.npz", "-o", &format!("room.{ending}")]);
    }
    let table = text(&f.get("room.csv"));
    let surfaces = f.get("room.vtu");
    let (areas, b) = (array(&surfaces, "area [m2]"), array(&surfaces, "radiosity [W/m2]"));
    assert_eq!((areas.len(), b.len()), (6, 18));
    let power: f64 = areas.iter().enumerate().map(|(i, a)| a * b[3 * i]).sum();
    let wanted = over_patches(&table, |of| of("size") * of("radiosity_0"));
    assert!((power / wanted - 1.0).abs() < 1e-12, "{power} {wanted}");
    let medium = f.get("room.vti");
    let volume = array(&medium, "volume [m3]");
    assert!((volume.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    // The wall at x = 0 emits and x varies fastest: even cells are brighter.
    let g = array(&medium, "fluence [W/m2]");
    assert!((0..8).step_by(2).all(|i| g[3 * i] > g[3 * (i + 1)]), "{g:?}");
}

#[test]
fn illuminances_are_mean_irradiances_times_the_efficacy() {
    let f = Folder::new();
    f.put("room.npz", solution());
    f.done(&["export", "room.npz", "-o", "room.csv"]);
    let printed = f.done(&["export", "room.npz", "-o", "lux.csv", "--photometric", "100"]);
    assert!(printed.contains("uniformity") && printed.contains("flux, lm"), "{printed}");
    let lux = over_patches(&text(&f.get("lux.csv")), |of| of("size") * of("illuminance_lx"));
    let watts = over_patches(&text(&f.get("room.csv")), |of| {
        let of_band = |b: usize| of(&format!("incident_{b}")) + of(&format!("direct_{b}"));
        of("size") * (0..3).map(of_band).sum::<f64>() / 3.0
    });
    assert!((lux / (100.0 * watts) - 1.0).abs() < 1e-12, "{lux} {watts}");
    let json = f.done(&["export", "room.npz", "-o", "lux.csv", "--photometric", "--json"]);
    assert!(json.contains("mean_lx"), "{json}");
    refused(&f, Program, &["export", "room.npz", "-o", "lux.vtu", "--photometric"], "--photometric");
}

/// Σ of a column of the table of zones over its patches.
fn over_patches(table: &str, value: impl Fn(&dyn Fn(&str) -> f64) -> f64) -> f64 {
    let mut lines = table.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows = lines.map(|l| l.split(',').collect::<Vec<_>>()).filter(|r| r[1] == "patch");
    rows.map(|r| value(&|name| r[names.iter().position(|n| *n == name).unwrap()].parse().unwrap())).sum()
}

// Guards (files): a GLB contains the walls of the scene and is valid (glTF validator in CI).
#[test]
fn glb_reads_back_as_the_same_walls() {
    let f = Folder::new();
    f.put("room.npz", solution());
    f.done(&["export", "room.npz", "-o", "room.glb"]);
    f.put(
        "read_back.toml",
        "[solve]\npatch_size = 2.0\n[[surface]]\nname = 'read_back'\nmesh = { file = 'room.glb', rotate_degrees = [90, 0, 0] }\n",
    );
    f.done(&["solve", "read_back.toml", "-o", "read_back.npz"]);
    f.done(&["export", "read_back.npz", "-o", "read_back.csv"]);
    let table = text(&f.get("read_back.csv"));
    let area = over_patches(&table, |of| of("size"));
    assert!((area - 6.0).abs() < 1e-5, "{area}");
    // The centre of the walls is unchanged, so z is up.
    for axis in ["x", "y", "z"] {
        let centre = over_patches(&table, |of| of("size") * of(axis)) / area;
        assert!((centre - 0.5).abs() < 1e-5, "{axis}: {centre}");
    }
}

#[test]
fn glb_has_settings_and_light_groups() {
    let f = Folder::new();
    f.put("room.npz", solution());
    let json = |flags: &[&str]| -> serde_json::Value {
        f.done(&[&["export", "room.npz", "-o", "out/a.glb"], flags].concat());
        let bytes = f.get("out/a.glb");
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        serde_json::from_slice(&bytes[20..20 + length]).unwrap()
    };
    let plain = json(&[]);
    let about = &plain["scenes"][0]["extras"];
    assert_eq!((about["curve"].as_str(), about["length"].as_str()), (Some("filmic"), Some("m")));
    assert_eq!(plain["cameras"][0]["name"], "door");
    assert!(plain["materials"][0]["extensions"]["KHR_materials_unlit"].is_object());
    let brighter = json(&["--stops", "1", "--curve", "linear", "--colours", "irradiance", "--light-groups"]);
    let about = &brighter["scenes"][0]["extras"];
    assert_eq!(about["curve"], "linear");
    assert_eq!(about["light groups"][0]["attribute"], "_IRRADIANCE_0");
    let attributes = &brighter["meshes"][0]["primitives"][0]["attributes"];
    assert!(attributes["_IRRADIANCE_0"].is_number() && attributes["COLOR_0"].is_number());
}

/// The JSON of a GLB.
fn glb_json(bytes: &[u8]) -> serde_json::Value {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

#[test]
fn lightmap_has_the_irradiance_of_the_walls() {
    let f = Folder::new();
    f.put("room.npz", solution());
    f.done(&["export", "room.npz", "-o", "room.csv"]);
    for n in ["1", "3"] {
        let output = format!("out/{n}.glb");
        f.done(&["export", "room.npz", "-o", &output, "--lightmap", "--texel", "0.1", "--threads", n]);
    }
    assert!(f.get("out/1.lightmap.exr") == f.get("out/3.lightmap.exr"), "threads matter");
    let json = glb_json(&f.get("out/1.glb"));
    let about = &json["scenes"][0]["extras"]["lightmap"];
    assert_eq!((&about["file"], &about["unit"]), (&"1.lightmap.exr".into(), &"W/m2".into()));
    assert_eq!((about["charts"].as_u64(), about["texel"].as_f64()), (Some(6), Some(0.1)));
    for mesh in json["meshes"].as_array().unwrap() {
        let attributes = &mesh["primitives"][0]["attributes"];
        assert!(attributes["TEXCOORD_0"].is_number() && attributes["TEXCOORD_1"].is_number(), "{mesh}");
    }
    // The only emitting wall shows its radiance.
    let emits = |m: &&serde_json::Value| m["emissiveFactor"].is_array();
    assert_eq!(json["materials"].as_array().unwrap().iter().filter(emits).count(), 1);
    // Six charts of 10 × 10 texels with margins; the margins repeat the light, so that the mean of all texels is about that of the walls.
    let map = zonal_io::output::read_exr(&f.path().join("out/1.lightmap.exr")).unwrap();
    let lit: Vec<f64> = map.pixels.iter().map(|p| f64::from(p[0])).filter(|x| *x > 0.0).collect();
    assert_eq!(lit.len(), 6 * 14 * 14);
    let mean = lit.iter().sum::<f64>() / lit.len() as f64;
    let wanted = over_patches(&text(&f.get("room.csv")), |of| of("size") * of("incident_0")) / 6.0;
    assert!((mean / wanted - 1.0).abs() < 0.02, "{mean} {wanted}");
    let json = f.done(&["export", "room.npz", "-o", "out/1.glb", "--lightmap", "--atlas", "64", "--json"]);
    assert!(json.contains("\"texel\":") && json.contains("out/1.lightmap.exr"), "{json}");
}

#[test]
fn irradiance_volume_is_an_array_and_a_texture() {
    let f = Folder::new();
    f.put("room.npz", solution());
    let volume = ["export", "room.npz", "--irradiance-volume", "--grid", "3,2,2", "--rays", "64", "-o"];
    for n in ["1", "3"] {
        f.done(&[&volume[..], &[&format!("out/{n}.json"), "--threads", n]].concat());
    }
    assert!(f.get("out/1.bin") == f.get("out/3.bin"), "threads matter");
    let about: serde_json::Value = serde_json::from_slice(&f.get("out/1.json")).unwrap();
    assert_eq!((&about["file"], &about["dims"]), (&"1.bin".into(), &serde_json::json!([3, 2, 2])));
    assert!(about["scale"].as_f64().unwrap() > 0.0 && about["points outside"] == 0);
    // Three blocks of four 16-bit floats a point; the first wall emits, so that light comes from low x.
    let bytes = f.get("out/1.bin");
    assert_eq!(bytes.len(), 3 * 12 * 8);
    f.done(&[&volume[..], &["out/v.npz"]].concat());
    let (shape, c) = zonal_io::output::read_array(&f.path().join("out/v.npz"), "coefficients").unwrap();
    assert_eq!(shape, [3, 2, 2, 4, 3]);
    assert!((0..12).all(|i| c[12 * i] > 0.0 && c[12 * i + 9] < 0.0), "{c:?}");
    let scale = about["scale"].as_f64().unwrap();
    for (point, k) in [(0, 0), (5, 3), (11, 1)] {
        // x fastest in the texture, z in the array.
        let [x, y, z] = [point / 4, point / 2 % 2, point % 2];
        let at = 2 * (4 * (x + 3 * (y + 2 * z)) + k);
        let (value, wanted) = (scale * half_float([bytes[at], bytes[at + 1]]), c[12 * point + 3 * k]);
        assert!((value - wanted).abs() < 1e-3 * wanted.abs() + 1e-6, "{point} {k}: {value} {wanted}");
    }
}

/// The value of a 16-bit float.
fn half_float(bytes: [u8; 2]) -> f64 {
    let bits = u16::from_le_bytes(bytes);
    let (exponent, mantissa) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023) / 1024.0);
    let size = match exponent {
        0 => mantissa * 2f64.powi(-14),
        _ => (1.0 + mantissa) * 2f64.powi(exponent - 15),
    };
    if bits >> 15 == 1 { -size } else { size }
}

#[test]
fn invalid_irradiance_volumes_are_refused() {
    let f = Folder::new();
    f.put("room.npz", solution());
    refused(
        &f,
        Program,
        &["export", "room.npz", "-o", "room.npz", "--irradiance-volume"],
        "replace the solution",
    );
    refused(&f, Program, &["export", "room.npz", "-o", "out/v.glb", "--irradiance-volume"], ".json");
    refused(
        &f,
        Program,
        &["export", "room.npz", "-o", "out/w.npz", "--irradiance-volume", "--grid", "2,2"],
        "--grid",
    );
    refused(
        &f,
        Program,
        &["export", "room.npz", "-o", "out/w.npz", "--irradiance-volume", "--curve", "linear"],
        "--curve",
    );
    refused(&f, Parser, &["export", "room.npz", "-o", "out/w.npz", "--grid", "2,2,2"], "--irradiance-volume");
}

#[test]
fn vtu_has_point_data_on_request() {
    let f = Folder::new();
    f.put("room.npz", solution());
    f.done(&["export", "room.npz", "-o", "room.vtu"]);
    assert!(!text(&f.get("room.vtu")).contains("PointData"));
    f.done(&["export", "room.npz", "-o", "points.vtu", "--points"]);
    let file = f.get("points.vtu");
    let (h, cells) = (array(&file, "total irradiance [W/m2]"), array(&file, "irradiance [W/m2]"));
    assert_eq!((h.len(), cells.len()), (6 * 4 * 3, 6 * 3));
    // One patch a wall: its corners have its value.
    for (i, value) in h.iter().enumerate() {
        let mean = cells[3 * (i / 12) + i % 3];
        assert!((value / mean - 1.0).abs() < 1e-6, "{i}: {value} {mean}");
    }
    refused(&f, Program, &["export", "room.npz", "-o", "out/x.csv", "--points"], "--points");
    refused(&f, Program, &["export", "room.npz", "-o", "out/x.csv", "--lightmap"], "--lightmap");
    let glb = ["export", "room.npz", "-o", "out/x.glb"];
    refused(&f, Parser, &[&glb[..], &["--texel", "0.1"]].concat(), "--lightmap");
    refused(&f, Program, &[&glb[..], &["--lightmap", "--texel=0"]].concat(), "--texel");
    refused(&f, Program, &[&glb[..], &["--lightmap", "--light-groups"]].concat(), "--light-groups");
    refused(&f, Program, &[&glb[..], &["--lightmap", "--texel=1e-9"]].concat(), "--atlas");
}

#[test]
fn invalid_exports_are_refused() {
    let f = Folder::new();
    f.put("room.npz", solution());
    let empty =
        ROOM.replace("[medium]", "#").replace("cells = ", "#").replace("extinction = 0.5\nalbedo = 0.5", "");
    let empty: String = empty
        .split('\n')
        .filter(|l| !(l.starts_with("min") || l.starts_with("max")))
        .collect::<Vec<_>>()
        .join("\n");
    f.put("empty.toml", empty);
    f.done(&["solve", "empty.toml", "-o", "empty.npz"]);
    refused(&f, Program, &["export", "empty.npz", "-o", "out/x.vti"], "no medium");
    f.done(&["export", "empty.npz", "-o", "out/x.glb"]);
    assert_eq!(std::fs::read_dir(f.path().join("out")).unwrap().count(), 1, "no medium, no second file");
    for flag in [
        "--light-groups",
        "--vertices=9",
        "--finest=1",
        "--stops=1",
        "--curve=linear",
        "--colours=irradiance",
    ] {
        for ending in ["csv", "vtu", "vti"] {
            refused(
                &f,
                Program,
                &["export", "room.npz", "-o", &format!("out/x.{ending}"), flag],
                "--light-groups",
            );
        }
    }
    let glb = ["export", "room.npz", "-o", "out/y.glb"];
    for flag in ["--stops=inf", "--stops=99", "--finest=0", "--finest=-1", "--finest=nan"] {
        refused(&f, Program, &[&glb, [flag].as_slice()].concat(), flag.split('=').next().unwrap());
    }
    for flag in ["--vertices=0", "--vertices=many", "--curve=round", "--colours=red"] {
        refused(&f, Parser, &[&glb, [flag].as_slice()].concat(), flag.split('=').next().unwrap());
    }
    refused(&f, Program, &["export", "room.npz", "-o", "out/x.ply"], ".vti");
    std::fs::create_dir(f.path().join("out/y.medium.npz")).unwrap();
    refused(&f, Program, &glb, "y.medium.npz");
}
