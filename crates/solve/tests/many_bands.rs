//! Scenes of more than three bands: bands of one scene agree with those of scenes of three, alone and coupled by temperature.

use crate::common;

use common::solved;
use zonal_scene::Solution;

/// A box with a medium on the grid; `bands` and the lists give as many bands.
fn lit_box(bands: usize, engine: &str, reflectance: &str, extinction: &str) -> String {
    format!(
        "bands = {bands}\n[solve]\nengine = \"{engine}\"\npatch_rule = \"voxels\"\n[[surface]]\nname = \"room\"\nreflectance = {reflectance}\nroom = {{ min = [0,0,0], max = [1,1,1] }}\nfaces.z1.emission = 5\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [3,3,3]\nalbedo = 0.5\nextinction = {extinction}\n"
    )
}

/// Largest difference of band `a` of one solution from band `b` of another, over the largest radiosity.
fn difference(one: &Solution, a: usize, other: &Solution, b: usize) -> f64 {
    let band = |s: &Solution, i: usize, band: usize| {
        s.blocks().nth(band / 3).unwrap().fields.radiosity[i].as_slice()[band % 3]
    };
    let largest = (0..one.zones.len()).fold(0.0f64, |m, i| m.max(band(one, i, a)));
    let off = (0..one.zones.len()).fold(0.0f64, |m, i| m.max((band(one, i, a) - band(other, i, b)).abs()));
    off / largest
}

// Guards (numbers): a scene of many bands has in each band the solution of a scene of three.
#[test]
fn bands_of_light_are_those_of_scenes_of_three() {
    for engine in ["dense", "spectral", "rays"] {
        let three = solved(&lit_box(3, engine, "[0.5, 0.2, 0.7]", "[0.5, 2.0, 0.0]"));
        let five = solved(&lit_box(5, engine, "[0.5, 0.2, 0.7, 0.2, 0.5]", "[0.5, 2.0, 0.0, 2.0, 0.5]"));
        assert_eq!((five.further_blocks.len(), five.all_bands(|t| t.report.energy.emitted).len()), (1, 5));
        // Rays of a block follow the mean of its bands: other blocks have other rays.
        let tolerance = if engine == "rays" { 0.05 } else { 1e-10 };
        for (own, other) in [(0, 0), (1, 1), (2, 2), (3, 1), (4, 0)] {
            let off = difference(&five, own, &three, other);
            assert!(off < tolerance, "{engine}, band {own}: {off:e}");
        }
    }
}

#[test]
fn one_band_is_the_grey_scene() {
    let one = solved(&lit_box(1, "dense", "0.5", "[1.5]"));
    let three = solved(&lit_box(3, "dense", "0.5", "1.5"));
    assert_eq!(one.fields.radiosity, three.fields.radiosity);
    assert_eq!(one.all_bands(|t| t.fields.radiosity[0]).len(), 1);
}

/// A box of gas with adiabatic walls, a hot one, and sources; the band fractions depend on temperature.
fn furnace(engine: &str, basis: &str, bands: &str) -> String {
    format!(
        "mode = \"thermal\"\n{bands}\nheat_source = 3e4\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [3,3,3]\nalbedo = 0.1\n[solve]\nengine = \"{engine}\"\nzone_basis = \"{basis}\"\npatch_rule = \"voxels\"\nresidual = 1e-12\ndiscretization_error = true\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\nheat_flux = 0\nemissivity = 0.6\nfaces.z0.temperature = 900\nfaces.z0.emissivity = 0.9\nfaces.x1.temperature = 1500\n"
    )
}

// Guards (numbers): bands that are divided in two have the same temperatures.
#[test]
fn bands_split_in_two_have_the_same_temperatures() {
    let thermal = |bands: usize, weights: &str, kappa: &str| {
        format!(
            "bands = {bands}\n[thermal]\nweights = {weights}\nrange = [300, 2500]\n[medium]\nextinction = {kappa}"
        )
    };
    let three = thermal(3, "[[0.2, 1e-4], [0.3, -5e-5], \"rest\"]", "[0.5, 2.0, 0.0]");
    let seven = thermal(
        7,
        "[[0.1, 5e-5], [0.15, -2.5e-5], [0.25, -2.5e-5], [0.1, 5e-5], [0.15, -2.5e-5], [0.125, -1e-5], \"rest\"]",
        "[0.5, 2.0, 0.0, 0.5, 2.0, 0.0, 0.0]",
    );
    // The automatic basis is that of each block of bands, so that the two scenes would have different ones.
    for (engine, basis) in [("dense", "constant"), ("spectral", "constant"), ("spectral", "linear")] {
        let [a, b] = [&three, &seven].map(|bands| solved(&furnace(engine, basis, bands)));
        assert_eq!((b.further_blocks.len(), b.scene.bands().count()), (2, 7));
        let [p, q] = [&a, &b].map(|s| s.fields.heat.as_ref().unwrap());
        for i in 0..a.zones.len() {
            assert!(
                (p.temperature[i] / q.temperature[i] - 1.0).abs() < 1e-9,
                "{engine}, zone {i}: {} {}",
                p.temperature[i],
                q.temperature[i]
            );
        }
        let [r, s] = [&a, &b].map(|s| s.report.heat.as_ref().unwrap());
        assert!(s.balance().abs() < 1e-6, "{engine}: {}", s.balance());
        let [d, e] = [&a, &b].map(|s| s.report.discretization_error.as_ref().unwrap());
        for ((x, y), (d, e)) in r.rows.iter().zip(&s.rows).zip(d.heat.iter().zip(&e.heat)) {
            assert!((x.power - y.power).abs() < 1e-7 * 3e4, "{engine}, {}: {} {}", x.name, x.power, y.power);
            assert!((d[1] - e[1]).abs() <= 1e-5 * d[1].abs(), "{engine}, {}: {d:?} {e:?}", x.name);
        }
    }
}

#[test]
fn a_gas_of_four_grey_gases_and_a_clear_one_closes_its_balance() {
    let text = "mode = \"thermal\"\n[solve]\nengine = \"spectral\"\npatch_rule = \"voxels\"\n[[surface]]\nname = \"walls\"\nroom = { min = [0,0,0], max = [1,1,2] }\nemissivity = 0.8\ntemperature = 700\nfaces.z1.heat_flux = 0\n[medium]\nmin = [0,0,0]\nmax = [1,1,2]\ncells = [3,3,6]\ngas = { model = \"wsgg-bordbar-2020\", h2o = 0.2, co2 = 0.1 }\nheat_source = 5e4\n";
    let s = solved(text);
    assert_eq!(s.scene.bands().count(), 5);
    let heat = s.report.heat.as_ref().unwrap();
    let medium = heat.rows.iter().find(|r| r.name == "medium").unwrap();
    assert!((medium.power - 1e5).abs() < 1e-6 && heat.balance().abs() < 1e-5, "{}", heat.balance());
    assert!(medium.temperature.unwrap() > 900.0);
    assert!(s.scene.notes().iter().any(|n| n.code == "gas-model"));
}

/// Counts the stages of a solve by name.
#[derive(Default)]
struct StageCounts(std::sync::Mutex<std::collections::BTreeMap<String, usize>>);

impl zonal_scene::Progress for StageCounts {
    fn begin(&self, stage: &str, _: u64) {
        *self.0.lock().unwrap().entry(stage.into()).or_default() += 1;
    }
    fn advance(&self, _: u64) {}
    fn end(&self) {}
}

// Guards (structure): A scene of many bands is cut into zones once, each of its files is opened once, and so is its solution.
#[test]
fn files_zones_and_solutions_of_many_bands_are_read_once() {
    use zonal_io::input::FileRecord;
    let dir = std::env::temp_dir().join(format!("zonal-many-bands-{}", std::process::id()));
    std::fs::create_dir_all(&dir).unwrap();
    let write = |name: &str, text: &str| std::fs::write(dir.join(name), text).unwrap();
    write("sheet.obj", "v 0.2 0.2 0.5\nv 0.8 0.2 0.5\nv 0.8 0.8 0.5\nv 0.2 0.8 0.5\nf 1 2 3 4\n");
    write("paint.csv", "nm,rho\n380,0.1\n900,0.8\n");
    write("faces.csv", "face,rho\n0,0.3\n");
    let limits: Vec<String> = (0..25).map(|b| format!("[{}, {}]", 400 + 10 * b, 410 + 10 * b)).collect();
    write(
        "scene.toml",
        &format!(
            "bands = [{}]\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\nreflectance = {{ spectrum = \"paint.csv\" }}\nfaces.z1.emission = 5\n[[surface]]\nname = \"sheet\"\nmesh = {{ file = \"sheet.obj\" }}\nsides = \"both\"\nreflectance = {{ file = \"faces.csv\", column = \"rho\" }}\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [2,2,2]\nextinction = 0.5\nalbedo = 0.5\n[solve]\nengine = \"dense\"\npatch_size = 0.5\n",
            limits.join(", ")
        ),
    );
    let record = FileRecord::default();
    let scene = record.read_scene(&dir.join("scene.toml")).unwrap();
    let files = record.into_files();
    let openings: Vec<usize> = files.openings().map(|(_, n)| n).filter(|n| *n > 0).collect();
    assert_eq!((scene.bands().count(), openings), (25, vec![1; 4]));
    let stages = StageCounts::default();
    let solution = zonal_solve::solve(scene, 1 << 30, &stages).unwrap();
    assert_eq!(stages.0.lock().unwrap()["zones"], 1);
    // The blocks share the facets.
    let facets: Vec<_> = solution.blocks().map(|b| b.scene.facets().as_ptr()).collect();
    assert!(facets.len() == 9 && facets.iter().all(|f| *f == facets[0]));
    // A solution that is read shares them too.
    let path = dir.join("run.npz");
    zonal_io::output::write_solution(&path, &solution).unwrap();
    let back = zonal_io::output::read_solution(&path).unwrap();
    let facets: Vec<_> = back.blocks().map(|b| b.scene.facets().as_ptr()).collect();
    assert!(facets.len() == 9 && facets.iter().all(|f| *f == facets[0]));
    assert_eq!(back.all_bands(|b| b.fields.radiosity[3]), solution.all_bands(|b| b.fields.radiosity[3]));
    std::fs::remove_dir_all(&dir).unwrap();
}
