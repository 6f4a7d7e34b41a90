//! Scenes of more than three bands through the command: files, tables, exports, refusals; slabs of gas against RadLib.

use crate::support;

use support::{Folder, Program, refused};

const SCENE: &str = "bands = 5\n[solve]\nengine = \"dense\"\npatch_rule = \"voxels\"\n[[surface]]\nname = \"room\"\nreflectance = [0.5, 0.6, 0.7, 0.4, 0.3]\nroom = { min = [0,0,0], max = [1,1,1] }\nfaces.z1.emission = [1, 2, 3, 4, 5]\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [2,2,2]\nextinction = [0.5, 1.0, 0.0, 0.2, 0.7]\n";

fn read(f: &Folder, file: &str) -> zonal_scene::Solution {
    zonal_io::output::read_solution(f.path().join(file)).unwrap()
}

// Guards (files): files, tables and exports hold all bands.
#[test]
fn files_tables_and_exports_have_all_bands() {
    let f = Folder::new();
    f.put("scene.toml", SCENE);
    let json: serde_json::Value =
        serde_json::from_str(&f.done(&["solve", "scene.toml", "-o", "a.npz", "--json"])).unwrap();
    assert_eq!(json["energy"]["emitted"].as_array().unwrap().len(), 5);
    assert_eq!(json["bands"]["count"], 5);
    // The file has a column for each band and reads back to the same bytes.
    let (shape, _) = zonal_io::output::read_array(&f.path().join("a.npz"), "radiosity").unwrap();
    assert_eq!(shape, [32, 5]);
    let solution = read(&f, "a.npz");
    assert_eq!(solution.all_bands(|t| t.scene.surfaces()[0].reflectance), [0.5, 0.6, 0.7, 0.4, 0.3]);
    let again = zonal_io::output::solution_bytes(&solution).unwrap();
    assert_eq!(again, std::fs::read(f.path().join("a.npz")).unwrap());
    // Tables.
    let text = f.done(&["solve", "scene.toml", "-o", "b.npz"]);
    assert!(text.contains("solver, band 4") && text.contains("1   2   3   4   5"), "{text}");
    f.done(&["export", "a.npz", "-o", "a.csv"]);
    let table = std::fs::read_to_string(f.path().join("a.csv")).unwrap();
    assert!(table.lines().next().unwrap().contains("radiosity_4") && !table.contains("radiosity_5"));
    for file in ["a.vtu", "a.vti"] {
        f.done(&["export", "a.npz", "-o", file]);
        let bytes = std::fs::read(f.path().join(file)).unwrap();
        assert!(String::from_utf8_lossy(&bytes).contains("ComponentName4=\"band 4\""), "{file}");
    }
    // A factor for all bands.
    f.done(&["relight", "a.npz", "room.z1=2", "-o", "c.npz"]);
    let [once, twice] = ["a.npz", "c.npz"].map(|file| read(&f, file).all_bands(|t| t.fields.radiosity[3]));
    assert!(once.iter().zip(&twice).all(|(a, b)| (2.0 * a - b).abs() < 1e-12 * b), "{once:?} {twice:?}");
    f.done(&["render", "a.npz", "--show", "irradiance", "-o", "a.png"]);
    refused(&f, Program, &["render", "a.npz", "-o", "b.png"], "5 bands");
    // Three bands at a time in the viewer and its models.
    let shown = f.done(&["export", "a.npz", "-o", "a.html", "--first-band", "3"]);
    assert!(shown.contains("of 5 bands, band 3, band 4 stand for red"), "{shown}");
    let [first, last] = ["0", "3"].map(|band| {
        f.done(&["export", "a.npz", "-o", "a.glb", "--first-band", band]);
        f.get("a.glb")
    });
    assert_ne!(first, last);
    for (file, band, words) in
        [("b.html", "4", "a multiple of 3 up to 3"), ("b.glb", "6", "5 bands"), ("b.csv", "0", "all bands")]
    {
        refused(&f, Program, &["export", "a.npz", "-o", file, "--first-band", band], words);
    }
}

#[test]
fn exchange_areas_of_many_bands_are_those_of_their_blocks() {
    let f = Folder::new();
    f.put("all.toml", SCENE);
    f.put(
        "first.toml",
        SCENE
            .replace("bands = 5\n", "")
            .replace(", 0.4, 0.3]", "]")
            .replace(", 4, 5]", "]")
            .replace(", 0.2, 0.7]", "]"),
    );
    for scene in ["all", "first"] {
        f.done(&["exchange", &format!("{scene}.toml"), "-o", &format!("{scene}.npz")]);
    }
    let read = |file: &str, name: &str| zonal_io::output::read_array(&f.path().join(file), name).unwrap();
    for name in ["exchange_areas", "total_exchange_areas", "total_error_radius"] {
        let [(shape, all), (_, first)] = ["all.npz", "first.npz"].map(|file| read(file, name));
        assert_eq!(shape, [5, 32, 32]);
        assert_eq!(all[..3 * 32 * 32], first);
    }
    // Band 2 has no extinction: the wall has all its exchange with walls.
    let (_, closure) = read("all.npz", "closure");
    assert!(closure[2 * 32 + 31] == 0.0 && closure[4 * 32 + 31] > closure[3 * 32 + 31]);
    f.done(&["exchange", "all.toml", "-o", "all.mtx", "--direct-only"]);
    assert!(f.path().join("all.band4.mtx").exists());
}

/// A room of which one wall is hot, in bands with wavelengths.
const ROOM_OF_WAVELENGTHS: &str = "mode = \"thermal\"\nbands = [[200, 3000], [3000, 8000], [8000, 20000], [20000, 100000]]\n[solve]\npatch_size = 1\ndiscretization_error = false\n[[surface]]\nname = \"r\"\nroom = { min=[0,0,0], max=[1,1,1] }\nemissivity = 1\ntemperature = 300\nfaces.z0 = { temperature = 1500 }\nfaces.z1 = { heat_flux = 0, emissivity = [0.9, 0.1, 0.1, 0.1] }\n";

#[test]
fn bands_with_wavelengths_have_the_emission_of_the_black_body() {
    let f = Folder::new();
    f.put("scene.toml", ROOM_OF_WAVELENGTHS);
    f.done(&["solve", "scene.toml", "-o", "a.npz"]);
    let s = read(&f, "a.npz");
    // F(0 to 4500 µm K), F(0 to 12 000 µm K), F(0 to 30 000 µm K) of the tables.
    let hot = s.all_bands(|t| t.fields.radiosity[4]);
    let total: f64 = hot.iter().sum();
    for (band, wanted) in [(0, 0.5643), (1, 0.9451 - 0.5643), (2, 0.9953 - 0.9451)] {
        assert!((hot[band] / total - wanted).abs() < 2e-4, "{hot:?}");
    }
    assert!((total / (5.670374419184429e-8 * 1500f64.powi(4)) - 1.0).abs() < 1e-12);
    // The wall without heat that absorbs the short waves alone is warmer than one that is black: it cannot emit them.
    let kelvin = |s: &zonal_scene::Solution| s.fields.heat.as_ref().unwrap().temperature[5];
    f.put("grey.toml", ROOM_OF_WAVELENGTHS.replace("[0.9, 0.1, 0.1, 0.1]", "0.9"));
    f.done(&["solve", "grey.toml", "-o", "b.npz"]);
    assert!(kelvin(&s) > kelvin(&read(&f, "b.npz")) + 50.0);
    f.put("gap.toml", ROOM_OF_WAVELENGTHS.replace("[3000, 8000]", "[3500, 8000]"));
    refused(&f, Program, &["solve", "gap.toml", "-o", "c.npz"], "leave out 3000 to 3500 nm");
}

/// A plate in sunlight above a planet: two bands, of which the last is sunlight.
const SUNLIT: &str = "mode = \"thermal\"\n[solve]\npatch_size = 0.5\n[[surface]]\nname = \"plate\"\nrectangle = { origin = [0,0,0], edge1 = [1,0,0], edge2 = [0,1,0] }\nsides = \"both\"\nheat_flux = 0\nemissivity = 0.8\nsolar_absorptance = 0.3\n[[light]]\nkind = \"sun\"\ndirection = [0,0,-1]\nirradiance = 1000\n[[light]]\nkind = \"planet\"\ndirection = [0,0,1]\nangular_diameter = 120\ntemperature = 250\n[surroundings]\ntemperature = 20\n";

#[test]
fn sunlit_scenes_survive_their_file_and_state_sunlight() {
    let f = Folder::new();
    f.put("scene.toml", SUNLIT);
    let json: serde_json::Value =
        serde_json::from_str(&f.done(&["solve", "scene.toml", "-o", "a.npz", "--json"])).unwrap();
    assert_eq!(json["bands"]["names"], serde_json::json!(["infrared", "solar"]));
    let row = &json["heat"]["rows"][0];
    assert!((row["absorbed_sunlight_W"].as_f64().unwrap() - 300.0).abs() < 0.1, "{row}");
    let solution = read(&f, "a.npz");
    assert!(solution.scene.bands().has_solar_band() && solution.scene.lights().len() == 2);
    let again = zonal_io::output::solution_bytes(&solution).unwrap();
    assert_eq!(again, std::fs::read(f.path().join("a.npz")).unwrap());
    assert!(f.done(&["solve", "scene.toml", "-o", "b.npz"]).contains("sunlight, W"));
    f.done(&["render", "a.npz", "--show", "temperature", "-o", "a.png"]);
    f.done(&["exchange", "scene.toml", "-o", "areas.npz"]);
    let updated: serde_json::Value =
        serde_json::from_str(&f.done(&["update", "areas.npz", "-o", "q.csv", "--json"])).unwrap();
    let of = |json: &serde_json::Value, key: &str| json[key].as_f64().unwrap();
    let (found, wanted) = (of(&updated["parts"][0], "temperature"), of(row, "temperature_K"));
    assert!((found / wanted - 1.0).abs() < 1e-9, "{found} {wanted}");
    assert!(of(&updated, "balance").abs() < 1e-6 * of(&updated, "surroundings").abs().max(1.0));
}

/// A white wall, a red one and a blue one in light of a spectrum.
const SPECTRAL: &str = "bands = [[400, 500], [500, 580], [580, 640], [640, 700]]\n[solve]\npatch_size = 1\n[[surface]]\nname = \"white\"\nrectangle = { origin = [0,0,0], edge1 = [1,0,0], edge2 = [0,1,0] }\nreflectance = 0.9\n[[surface]]\nname = \"red\"\nrectangle = { origin = [1,0,0], edge1 = [1,0,0], edge2 = [0,1,0] }\nreflectance = { spectrum = \"paint.csv\", column = \"red\" }\n[[surface]]\nname = \"blue\"\nrectangle = { origin = [2,0,0], edge1 = [1,0,0], edge2 = [0,1,0] }\nreflectance = { spectrum = \"paint.csv\", column = \"blue\" }\n[[light]]\nkind = \"sun\"\ndirection = [0,0,-1]\nirradiance = { illuminant = \"D65\", total = 1000 }\nangular_diameter = 0\n[[camera]]\nname = \"above\"\norigin = [1.5,0.5,3]\ntarget = [1.5,0.5,0]\nup = [0,1,0]\nfov = 50\n";

#[test]
fn pictures_of_wavelengths_have_the_colours_of_their_spectra() {
    let f = Folder::new();
    f.put("paint.csv", "nm,red,blue\n400,0.05,0.6\n520,0.05,0.3\n560,0.1,0.05\n620,0.8,0.05\n700,0.9,0.05\n");
    f.put("scene.toml", SPECTRAL);
    f.done(&["solve", "scene.toml", "-o", "a.npz"]);
    f.done(&["render", "a.npz", "-o", "a.png", "--size", "30x10"]);
    f.done(&["render", "a.npz", "-o", "a.exr", "--size", "30x10"]);
    let mut reader = png::Decoder::new(std::io::Cursor::new(f.get("a.png"))).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height, info.color_type), (30, 10, png::ColorType::Rgb));
    let at = |x: usize| [0, 1, 2].map(|c| i32::from(pixels[3 * (30 * 5 + x) + c]));
    let [white, red, blue] = [at(5), at(15), at(25)];
    assert!((white[0] - white[1]).abs() < 12 && (white[2] - white[1]).abs() < 12, "{white:?}");
    assert!(red[0] > 2 * red[1] && red[0] > 2 * red[2], "{red:?}");
    assert!(blue[2] > blue[1] && blue[1] > blue[0], "{blue:?}");
    let shown = f.done(&["export", "a.npz", "-o", "a.glb"]);
    assert!(shown.contains("400-500 nm, 500-580 nm, 580-640 nm stand for red, green and blue"), "{shown}");
}

#[test]
fn wrong_bands_and_gases_are_refused() {
    let f = Folder::new();
    let gas = |keys: &str| {
        format!(
            "mode = \"thermal\"\n{keys}\n[[surface]]\nname = \"w\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\nemissivity = 1\ntemperature = 900\n"
        )
    };
    let medium = "[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [2,2,2]\nheat_source = 0";
    for (text, words) in [
        (SCENE.replace("bands = 5", "bands = 500"), "128"),
        (SCENE.replace("bands = 5", "bands = 4"), "a list of 4 values"),
        (SCENE.replace("bands = 5", "bands = [[400, 500], [450, 600]]"), "overlap"),
        (gas(&format!("{medium}\ngas = {{ model = \"wsgg-bordbar\" }}")), "wsgg-bordbar-2014"),
        (gas(&format!("{medium}\ngas = {{ model = \"wsgg-bordbar-2020\", h2o = 1.2 }}")), "from 0 to 1"),
        (
            gas(&format!("{medium}\nextinction = 1\ngas = {{ model = \"wsgg-bordbar-2020\" }}")),
            "gives the absorption",
        ),
        (gas(&format!("bands = 4\n{medium}\ngas = {{ model = \"wsgg-bordbar-2020\" }}")), "5 grey gases"),
        (gas(&format!("{medium}\ngas = {{ model = \"grey-soot\", soot = 1e-6 }}")), "temperature"),
        (gas(&format!("bands = 4\n{medium}\nextinction = [1, 2, 3, 4]")), "fractions"),
    ] {
        f.put("bad.toml", &text);
        refused(&f, Program, &["solve", "bad.toml", "-o", "bad.npz"], words);
        refused(&f, Program, &["solve", "bad.toml", "-o", "bad.npz"], "bad.toml");
    }
}

// Guards (numbers): gas models in slabs give RadLib's wall fluxes within 0.1 %.
/// Slabs of layers of different absorption, and one of constant absorption and varying temperature: wall fluxes of RadLib, kW/m² (`crates/validation/src/validate/data/radlib_walls.csv`).
#[test]
fn slabs_of_gas_have_the_fluxes_of_radlib() {
    use std::fmt::Write as _;
    let f = Folder::new();
    let slab = |t: &dyn Fn(f64) -> f64, h2o: &dyn Fn(f64) -> f64, length: f64| {
        const LAYERS: usize = 80;
        let step = length / LAYERS as f64;
        let mut text = String::from(
            "mode = \"thermal\"\nboundary = { x = \"periodic\", y = \"periodic\" }\n[solve]\npatch_rule = \"voxels\"\ndiscretization_error = false\n",
        );
        for (name, z, edges) in [
            ("low", 0.0, "edge1 = [1,0,0], edge2 = [0,1,0]"),
            ("high", length, "edge1 = [0,1,0], edge2 = [1,0,0]"),
        ] {
            let _ = write!(
                text,
                "[[surface]]\nname = \"{name}\"\nemissivity = 1\ntemperature = {}\nrectangle = {{ origin = [0,0,{z}], {edges} }}\n",
                t(z)
            );
        }
        let _ = write!(text, "[medium]\nmin = [0,0,0]\nmax = [1,1,{length}]\ncells = [1,1,{LAYERS}]\n");
        for k in 0..LAYERS {
            let (low, x) = (k as f64 * step, (k as f64 + 0.5) * step);
            let _ = write!(
                text,
                "[[medium.region]]\nbox = {{ min = [0,0,{low}], max = [1,1,{}] }}\ntemperature = {}\ngas = {{ model = \"wsgg-bordbar-2020\", h2o = {}, co2 = 0 }}\n",
                low + step,
                t(x),
                h2o(x)
            );
        }
        text
    };
    let s3 = slab(&|x| 800.0 + 4000.0 * x * (1.0 - x), &|x| 0.12 + 0.8 * x * (1.0 - x), 1.0);
    let s5 = slab(&|x| 1000.0 + 500.0 * (0.5 * std::f64::consts::PI * x).cos(), &|_| 0.1, 2.0);
    for (text, expected) in [(s3, [-80.0756, -80.0756]), (s5, [243.2911, -226.0974])] {
        f.put("slab.toml", &text);
        let json: serde_json::Value =
            serde_json::from_str(&f.done(&["solve", "slab.toml", "-o", "slab.npz", "--json"])).unwrap();
        for (k, expected) in expected.iter().enumerate() {
            let q = json["heat"]["rows"][k]["net_flux"].as_f64().unwrap() / 1e3;
            assert!((q / expected - 1.0).abs() < 2e-3, "{q} instead of {expected} kW/m2");
        }
    }
}
