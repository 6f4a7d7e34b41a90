//! Thermal states from stored exchange areas against fresh solves of the dense engine.

use std::collections::BTreeMap;
use zonal_scene::{NoProgress, Scene, Solution, ThermalCondition};
use zonal_solve::areas::exchange_areas::{ExchangeAreaContents, ExchangeAreaSettings, ExchangeAreas};
use zonal_solve::state::{ExchangeData, StateSolver, ThermalState};

const HEAD: &str = "mode = 'thermal'\n[solve]\nengine = 'dense'\nresidual = 1e-14\ndiscretization_error = false\npatch_size = 0.5\nzone_basis = 'constant'\n";

/// A closed room with a gas, a wall of known flux and an adiabatic one.
fn furnace(z0: f64, gas: f64, flux: f64, emissivity: f64) -> String {
    format!(
        "{HEAD}[[surface]]\nname = 'room'\nroom = {{ min = [0, 0, 0], max = [1, 1, 1.5] }}\ntemperature = 600\nemissivity = {emissivity}
faces.z0 = {{ temperature = {z0} }}\nfaces.z1 = {{ heat_flux = {flux} }}\nfaces.x0 = {{ heat_flux = 0 }}
[medium]\nmin = [0, 0, 0]\nmax = [1, 1, 1.5]\ncells = [2, 2, 3]\nextinction = 0.8\nalbedo = 0.3\ntemperature = {gas}\n"
    )
}

/// An open plate with a block above it, in warm surroundings.
fn open(floor: f64, block: f64) -> String {
    format!(
        "{HEAD}tolerance = 0.05\n[surroundings]\ntemperature = 290\n[[surface]]\nname = 'floor'\nrectangle = {{ origin = [0, 0, 0], edge1 = [1, 0, 0], edge2 = [0, 1, 0] }}\ntemperature = {floor}\nemissivity = 0.6
[[surface]]\nname = 'block'\nbox = {{ min = [0.3, 0.3, 0.4], max = [0.7, 0.7, 0.6] }}\nheat_flux = {block}\nemissivity = 0.8\n"
    )
}

/// A room of three bands with known temperatures.
fn bands(hot: f64) -> String {
    format!(
        "{HEAD}[thermal]\nweights = [[0.5, -1e-4], [0.2, 1e-4], 'rest']\nrange = [300, 2000]\n[[surface]]\nname = 'room'\nroom = {{ min = [0, 0, 0], max = [1, 1, 1] }}\ntemperature = 500\nemissivity = [0.9, 0.5, 0.2]\nfaces.z0 = {{ temperature = {hot} }}\n"
    )
}

fn scene(text: &str) -> Scene {
    zonal_io::input::parse_scene(text, None, "test.toml").unwrap_or_else(|e| panic!("{e}"))
}

fn solver(text: &str) -> StateSolver {
    let scene = scene(text);
    let settings = ExchangeAreaSettings {
        tolerance: 1e-11,
        contents: ExchangeAreaContents::Direct,
        ..Default::default()
    };
    let areas = ExchangeAreas::compute(&scene, &settings, &NoProgress).unwrap();
    StateSolver::new(ExchangeData::new(&scene, &areas, &NoProgress).unwrap()).unwrap()
}

fn solve(text: &str) -> Solution {
    zonal_solve::solve(scene(text), 1 << 30, &NoProgress).unwrap()
}

/// Sets the condition of every zone of a name.
fn set(s: &mut StateSolver, name: &str, condition: ThermalCondition) {
    let k = s.data().names.iter().position(|n| n == name).unwrap();
    let zones: Vec<usize> = (0..s.data().zone_count()).filter(|&i| s.data().name_of_zone[i] == k).collect();
    zones.into_iter().for_each(|i| s.set_condition(i, condition).unwrap());
}

fn assert_equal(state: &ThermalState, fresh: &Solution, tolerance: f64) {
    let heat = fresh.fields.heat.as_ref().unwrap();
    let grey = fresh.scene.thermal().unwrap().band_fractions.is_grey();
    let largest = |list: &[f64]| list.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let (net, kelvin) = (largest(&heat.net), largest(&heat.temperature));
    for i in 0..fresh.zones.len() {
        assert!(
            (state.net[i] - heat.net[i]).abs() <= tolerance * net,
            "{i}: {} {}",
            state.net[i],
            heat.net[i]
        );
        let (t, wanted) = (state.temperature[i], heat.temperature[i]);
        assert!((t - wanted).abs() <= tolerance * kelvin, "{i}: {t} {wanted}");
        let all: Vec<f64> = fresh.blocks().flat_map(|t| t.fields.radiosity[i].to_rgb()).collect();
        // A block that is not full repeats its last band.
        let bands = if grey { 1 } else { fresh.scene.bands().count() };
        let b: f64 = all.iter().take(bands).sum();
        assert!((state.radiosity[i] / b - 1.0).abs() < tolerance, "{i}: {} {b}", state.radiosity[i]);
        // The errors of a solve have radii of one byte and an iteration to 0.1; what is reflected of direct light has two standard errors there, and is reflected once
        // more. Errors below the rounding of the values are not compared.
        // A solve keeps the largest radius of a pair over the bands, a state that of each band: they are apart where the extinctions of bands vary in space.
        let varied = fresh.scene.voxel_grid().is_some_and(|g| g.uniform_extinction().is_none());
        let most = if fresh.scene.lights().is_empty() && !varied { 2.0 } else { 4.0 };
        for (own, other, rounding) in [
            (state.net_error[i], heat.net_error[i], 1e-11 * net),
            (state.temperature_error[i], heat.temperature_error[i], 1e-11 * kelvin),
        ] {
            assert!(own <= 2.0 * other + rounding && other <= most * own + rounding, "{i}: {own} {other}");
        }
    }
    let report = fresh.report.heat.as_ref().unwrap();
    let scale = net * state.net.len() as f64;
    assert!((state.surroundings - report.surroundings).abs() <= tolerance * scale);
    assert!((state.absorbed_backfaces - report.absorbed_backfaces).abs() <= tolerance * scale);
    assert!((state.emitters - report.emitters).abs() <= tolerance * scale);
}

// Guards (numbers): states from stored exchange areas equal fresh solves to 1e-9.
#[test]
fn states_equal_fresh_solves() {
    let mut s = solver(&furnace(800.0, 1200.0, 500.0, 0.7));
    assert_equal(&s.solve().unwrap(), &solve(&furnace(800.0, 1200.0, 500.0, 0.7)), 1e-9);
    // Other temperatures and powers.
    set(&mut s, "room.z0", ThermalCondition::Temperature(950.0));
    set(&mut s, "medium", ThermalCondition::Temperature(1000.0));
    set(&mut s, "room.z1", ThermalCondition::Flux(-2000.0));
    assert_equal(&s.solve().unwrap(), &solve(&furnace(950.0, 1000.0, -2000.0, 0.7)), 1e-9);
    // Another emissivity.
    (0..s.data().patches).for_each(|i| s.set_reflectance(i, &[1.0 - 0.35]).unwrap());
    assert_equal(&s.solve().unwrap(), &solve(&furnace(950.0, 1000.0, -2000.0, 0.35)), 1e-9);
    // A wall of known flux becomes one of known temperature: the factor is another.
    let mut fixed =
        solver(&furnace(950.0, 1000.0, -2000.0, 0.35).replace("heat_flux = 0 ", "temperature = 700 "));
    set(&mut s, "room.x0", ThermalCondition::Temperature(700.0));
    assert_eq!(s.solve().unwrap(), fixed.solve().unwrap());
}

#[test]
fn states_of_open_scenes_equal_fresh_solves() {
    let mut s = solver(&open(400.0, 300.0));
    assert_equal(&s.solve().unwrap(), &solve(&open(400.0, 300.0)), 1e-9);
    set(&mut s, "floor", ThermalCondition::Temperature(700.0));
    set(&mut s, "block", ThermalCondition::Flux(0.0));
    let state = s.solve().unwrap();
    assert_equal(&state, &solve(&open(700.0, 0.0)), 1e-9);
    let parts = state.by_name(s.data());
    assert!(state.balance(s.data()).abs() < 1e-9 * parts[0].power[0] && parts[1].power[0] == 0.0);
}

#[test]
fn states_of_several_bands_equal_fresh_solves() {
    let mut s = solver(&bands(900.0));
    set(&mut s, "room.z0", ThermalCondition::Temperature(1500.0));
    assert_equal(&s.solve().unwrap(), &solve(&bands(1500.0)), 1e-9);
    // Known powers couple the bands.
    set(&mut s, "room.x0", ThermalCondition::Flux(0.0));
    set(&mut s, "room.y1", ThermalCondition::Flux(1500.0));
    let powers = bands(1500.0) + "faces.x0 = { heat_flux = 0 }\nfaces.y1 = { heat_flux = 1500 }\n";
    assert_equal(&s.solve().unwrap(), &solve(&powers), 1e-9);
    // Back to temperatures, and an emissivity of one band.
    for name in ["room.x0", "room.y1"] {
        set(&mut s, name, ThermalCondition::Temperature(500.0));
    }
    (0..s.data().patches).for_each(|i| s.set_reflectance(i, &[0.1, 0.5, 0.3]).unwrap());
    let other = bands(1500.0).replace("[0.9, 0.5, 0.2]", "[0.9, 0.5, 0.7]");
    assert_equal(&s.solve().unwrap(), &solve(&other), 1e-9);
}

/// A box of gas with walls of known temperature and a wall and a gas of known or unknown ones.
fn gas_box(gas: &str, hot: f64, medium: &str, wall: &str) -> String {
    format!(
        "{HEAD}[[surface]]\nname = 'room'\nroom = {{ min = [0, 0, 0], max = [1, 1, 1] }}\ntemperature = 600\nemissivity = 0.7\nfaces.z0 = {{ temperature = {hot} }}\nfaces.z1 = {{ {wall} }}
[medium]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\ncells = [2, 2, 2]\n{medium}\n{gas}\n"
    )
}

const FIVE: &str = "gas = { model = 'wsgg-bordbar-2020', h2o = 0.2, co2 = 0.1 }";

#[test]
fn states_of_gases_equal_fresh_solves() {
    for (gas, bands) in [(FIVE, 5), ("gas = { model = 'wsgg-cassol-2014', h2o = 0.2, co2 = 0.1 }", 25)] {
        let mut s = solver(&gas_box(gas, 900.0, "temperature = 1200", "temperature = 700"));
        assert_eq!(s.data().bands, bands);
        set(&mut s, "room.z0", ThermalCondition::Temperature(1300.0));
        set(&mut s, "medium", ThermalCondition::Temperature(1600.0));
        let state = s.solve().unwrap();
        let fresh = solve(&gas_box(gas, 1300.0, "temperature = 1600", "temperature = 700"));
        assert_equal(&state, &fresh, 1e-9);
        assert!(state.balance(s.data()).abs() < 1e-9 * state.by_name(s.data())[6].power[0]);
        // The gas has a known heat, and a wall is adiabatic.
        set(&mut s, "medium", ThermalCondition::Flux(3e4));
        set(&mut s, "room.z1", ThermalCondition::Flux(0.0));
        let state = s.solve().unwrap();
        let powers = gas_box(gas, 1300.0, "heat_source = 3e4", "heat_flux = 0");
        assert_equal(&state, &solve(&powers), 1e-9);
        assert!(state.balance(s.data()).abs() < 1e-9 * 3e4);
        // Other values of the same kind use the same response.
        set(&mut s, "medium", ThermalCondition::Flux(1e4));
        assert_equal(&s.solve().unwrap(), &solve(&powers.replace("3e4", "1e4")), 1e-9);
    }
}

#[test]
fn cells_of_other_gas_have_their_own_fractions() {
    let region = "[[medium.region]]\nbox = { min = [0, 0, 0], max = [1, 1, 0.5] }\ngas = { model = 'wsgg-bordbar-2020', h2o = 0.05, co2 = 0.15 }\n";
    let text = |medium: &str, wall: &str| gas_box(&format!("{FIVE}\n{region}"), 1300.0, medium, wall);
    let mut s = solver(&text("temperature = 1200", "temperature = 700"));
    assert!(s.data().band_fractions.kinds.len() > 1);
    set(&mut s, "medium", ThermalCondition::Temperature(1500.0));
    assert_equal(&s.solve().unwrap(), &solve(&text("temperature = 1500", "temperature = 700")), 1e-9);
    set(&mut s, "room.z1", ThermalCondition::Flux(-500.0));
    assert_equal(&s.solve().unwrap(), &solve(&text("temperature = 1500", "heat_flux = -500")), 1e-9);
}

#[test]
fn a_gas_and_walls_of_one_temperature_exchange_nothing() {
    let mut s = solver(&gas_box(FIVE, 900.0, "temperature = 1200", "temperature = 700"));
    s.set_temperatures(&vec![1100.0; s.data().zone_count()]).unwrap();
    let black = 5.670374419184429e-8 * 1100f64.powi(4);
    let state = s.solve().unwrap();
    assert!(state.net.iter().zip(&s.data().sizes).all(|(q, size)| (q * size).abs() < 1e-9 * black));
    // The gas has no exchange areas in the band in which it is clear.
    assert!(state.incident[..s.data().patches].iter().all(|h| (h / black - 1.0).abs() < 1e-9));
}

/// A room with an open top below a sky and an inclined sun.
fn court(floor: &str, walls: &str, emissivity: f64) -> String {
    format!(
        "{HEAD}[[surface]]\nname = 'court'\nroom = {{ min = [0, 0, 0], max = [1, 1, 1] }}\nomit = ['z1']\n{walls}\nemissivity = {emissivity}\nsolar_absorptance = 0.2\nfaces.z0 = {{ solar_absorptance = 1, {floor} }}
[[light]]\nkind = 'sun'\ndirection = [0.2, 0, -1]\nirradiance = 700\n[[light]]\nkind = 'sky'\nradiance = 30\n[surroundings]\ntemperature = 270\n"
    )
}

#[test]
fn states_in_sunlight_equal_fresh_solves() {
    let mut s = solver(&court("temperature = 300", "temperature = 310", 0.9));
    assert!(s.data().has_solar_band && s.data().bands == 2);
    set(&mut s, "court.z0", ThermalCondition::Temperature(350.0));
    let state = s.solve().unwrap();
    assert_equal(&state, &solve(&court("temperature = 350", "temperature = 310", 0.9)), 1e-9);
    assert!(state.balance(s.data()).abs() < 1e-9 * 700.0);
    // Surfaces heated by the sun.
    set(&mut s, "court.z0", ThermalCondition::Flux(0.0));
    set(&mut s, "court.x1", ThermalCondition::Flux(0.0));
    let text = court("heat_flux = 0", "temperature = 310\nfaces.x1 = { heat_flux = 0 }", 0.9);
    assert_equal(&s.solve().unwrap(), &solve(&text), 1e-9);
    // Another emissivity leaves the absorptance for sunlight.
    (0..s.data().patches).for_each(|i| s.set_reflectance(i, &[1.0 - 0.4]).unwrap());
    assert_equal(&s.solve().unwrap(), &solve(&text.replace("emissivity = 0.9", "emissivity = 0.4")), 1e-9);
    // A zone that absorbs sunlight and cannot emit has no temperature.
    s.set_reflectance(s.data().patches - 1, &[1.0]).unwrap();
    let last = s.data().patches - 1;
    s.set_condition(last, ThermalCondition::Flux(0.0)).unwrap();
    assert!(s.solve().unwrap_err().to_string().contains("absorbs sunlight and emits nothing"));
}

#[test]
fn stated_errors_cover_those_of_sampled_sunlight() {
    let fine = solver(
        &court("temperature = 300", "temperature = 310", 0.9)
            .replace("[[surface]]", "tolerance = 1e-3\n[[surface]]"),
    );
    let coarse = solver(
        &court("temperature = 300", "temperature = 310", 0.9)
            .replace("[[surface]]", "tolerance = 0.1\n[[surface]]"),
    );
    let [fine, coarse] = [fine, coarse].map(|mut s| s.solve().unwrap());
    let off = |i: usize| (fine.net[i] - coarse.net[i]).abs();
    assert!((0..fine.net.len()).any(|i| off(i) > 1e-3));
    for i in 0..fine.net.len() {
        assert!(off(i) <= coarse.net_error[i] + fine.net_error[i], "{i}: {} {}", off(i), coarse.net_error[i]);
    }
}

#[test]
fn states_below_a_lamp_equal_fresh_solves() {
    let text = |kelvin: f64| {
        format!(
            "{HEAD}[[surface]]\nname = 'lamp'\nrectangle = {{ origin = [0, 0, 1], edge1 = [0, 1, 0], edge2 = [1, 0, 0] }}\ntemperature = 280\nemissivity = 1\nemission = 5000\n[[surface]]\nname = 'body'\nrectangle = {{ origin = [0, 0, 0], edge1 = [1, 0, 0], edge2 = [0, 1, 0] }}\ntemperature = {kelvin}\nemissivity = 0.1\nsolar_absorptance = 0.4\n[[light]]\nkind = 'emitter'\nsurface = 'lamp'\n[surroundings]\ntemperature = 280\n"
        )
    };
    let mut s = solver(&text(300.0));
    set(&mut s, "body", ThermalCondition::Temperature(420.0));
    let state = s.solve().unwrap();
    assert_equal(&state, &solve(&text(420.0)), 1e-9);
    assert!((state.emitters - 5000.0).abs() < 1e-6);
    let explained: f64 = state.net_error.iter().zip(&s.data().sizes).map(|(e, size)| e * size).sum();
    assert!(state.balance(s.data()).abs() <= explained + 1e-6, "{}", state.balance(s.data()));
}

#[test]
fn states_of_mirrored_scenes_equal_fresh_solves() {
    // Half of a court, whose other half is its mirror image.
    let text = |kelvin: f64| {
        format!(
            "{HEAD}[boundary]\nx0 = 'symmetry'\nmin = [0, 0, 0]\nmax = [0.5, 1, 1]\n[[surface]]\nname = 'court'\nroom = {{ min = [0, 0, 0], max = [0.5, 1, 1] }}\nomit = ['x0', 'z1']\ntemperature = 310\nemissivity = 0.9\nsolar_absorptance = 0.2\nfaces.z0 = {{ temperature = {kelvin} }}\n[[light]]\nkind = 'sun'\ndirection = [-0.2, 0, -1]\nirradiance = 700\n[surroundings]\ntemperature = 270\n"
        )
    };
    let mut s = solver(&text(300.0));
    set(&mut s, "court.z0", ThermalCondition::Temperature(350.0));
    assert_equal(&s.solve().unwrap(), &solve(&text(350.0)), 1e-9);
}

// Guards (numbers): errors of states from stored exchange areas cover altered areas.
#[test]
fn stated_errors_cover_the_effect_of_altered_areas() {
    let text = furnace(800.0, 1200.0, 500.0, 0.7);
    let mut exact = solver(&text);
    let wanted = exact.solve().unwrap();
    let mut data = exact.data().clone();
    let n = data.zone_count();
    // Errors of a part in ten thousand of each area, within radii of that size, that no closure reveals.
    for i in 0..n {
        for j in 0..=i {
            let sign = if (i * 31 + j * 17) % 3 == 0 { 1.0 } else { -1.0 };
            for k in [i * n + j, j * n + i] {
                let f = data.direct.areas[k];
                (data.direct.areas[k], data.direct.radii[k]) = (f * (1.0 + 1e-4 * sign), 1e-4 * f);
            }
        }
    }
    // Rows that do not close any more are a part of the error.
    for i in 0..n {
        let row: f64 = (0..n).map(|j| data.direct.areas[i * n + j]).sum();
        data.surroundings.closure_error[i] = (row / data.direct.closure[i] - 1.0).abs();
    }
    let found = StateSolver::new(data).unwrap().solve().unwrap();
    let largest = (0..n).fold(0.0f64, |m, i| m.max((found.net[i] - wanted.net[i]).abs()));
    assert!(largest > 1e-3);
    for i in 0..n {
        assert!((found.net[i] - wanted.net[i]).abs() <= found.net_error[i] + 1e-9, "{i}");
        assert!(
            (found.temperature[i] - wanted.temperature[i]).abs() <= found.temperature_error[i] + 1e-9,
            "{i}"
        );
        assert!((found.incident[i] - wanted.incident[i]).abs() <= found.incident_error[i], "{i}");
    }
}

#[test]
fn undetermined_and_damaged_data_are_refused() {
    let mut s = solver(&furnace(800.0, 1200.0, 0.0, 0.7));
    for name in ["room.x0", "room.x1", "room.y0", "room.y1", "room.z0", "room.z1", "medium"] {
        set(&mut s, name, ThermalCondition::Flux(0.0));
    }
    assert!(s.solve().unwrap_err().to_string().contains("level of the temperatures is undetermined"));
    assert!(s.set_condition(0, ThermalCondition::Temperature(-1.0)).is_err());
    assert!(s.set_reflectance(0, &[1.5]).is_err() && s.set_reflectance(0, &[0.5, 0.5]).is_err());
    set(&mut s, "room.x1", ThermalCondition::Temperature(400.0));
    s.set_condition(0, ThermalCondition::Flux(5.0)).unwrap();
    s.set_reflectance(0, &[1.0]).unwrap();
    assert!(s.solve().unwrap_err().to_string().contains("can give no power"));
    let data = s.data();
    type Damage = fn(&mut ExchangeData);
    let damages: BTreeMap<&str, Damage> = BTreeMap::from([
        ("exchange_areas", (|d| d.direct.areas.truncate(3)) as Damage),
        ("closure_scaling", |d| d.surroundings.scaling[0] = f64::NAN),
        ("reflectance", |d| d.reflectances[0] = -1.0),
        ("light_error", |d| d.light.error.push(0.0)),
        ("band_fractions", |d| d.band_fractions.kinds.clear()),
        ("zone_fractions", |d| d.band_fractions.kind_of_zone = vec![3; d.sizes.len()]),
        ("condition", |d| d.conditions[0] = ThermalCondition::Temperature(0.0)),
        ("name_of_zone", |d| d.name_of_zone[0] = 99),
        ("zone_face", |d| d.face_of_zone[0] = Some(0)),
        ("zone_size", |d| d.sizes.clear()),
    ]);
    for (name, damage) in damages {
        let mut copy = data.clone();
        damage(&mut copy);
        assert_eq!(StateSolver::new(copy).err().map(|e| e.key().to_string()).as_deref(), Some(name));
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solver(&furnace(800.0, 1200.0, 500.0, 0.7)).solve().unwrap())
    };
    let [one, three] = [1, 3].map(run);
    assert!((0..one.net.len()).all(|i| one.net[i].to_bits() == three.net[i].to_bits()));
}

#[test]
fn scenes_whose_properties_follow_the_temperature_have_no_states() {
    let text = |emissivity: &str| {
        format!(
            "mode = \"thermal\"\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\ntemperature = 400\nemissivity = {emissivity}\n"
        )
    };
    let refusal = |text: &str| ExchangeData::refusal(&scene(text)).map(|e| e.to_string());
    assert_eq!(refusal(&text("0.5")), None);
    let table = refusal(&text("{ temperatures = [300, 600], values = [0.2, 0.5] }")).unwrap();
    assert!(table.contains("constant emissivities") && table.contains("zonal solve"), "{table}");
    let light = refusal(
        &text("0.5")
            .replace("mode = \"thermal\"\n", "")
            .replace("temperature = 400\nemissivity = 0.5", "reflectance = 0.5"),
    );
    assert!(light.unwrap().contains("thermal"));
}
