//! Thermal states from stored exchange areas against fresh solves of the dense engine.

use std::collections::BTreeMap;
use zonal_scene::{Bands, NoProgress, Scene, Solution, ThermalCondition};
use zonal_solve::exchange_areas::{ExchangeAreaContents, ExchangeAreaSettings, ExchangeAreas};
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
    let fractions = &fresh.scene.thermal().unwrap().band_fractions;
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
        let b = fractions.total(fresh.fields.radiosity[i]);
        assert!((state.radiosity[i] / b - 1.0).abs() < tolerance, "{i}: {} {b}", state.radiosity[i]);
        // The errors of a solve have radii of one byte and an iteration to 0.1.
        for (own, other) in
            [(state.net_error[i], heat.net_error[i]), (state.temperature_error[i], heat.temperature_error[i])]
        {
            assert!(own <= 2.0 * other + 1e-9 && other <= 2.0 * own + 1e-9, "{i}: {own} {other}");
        }
    }
    let report = fresh.report.heat.as_ref().unwrap();
    let scale = net * state.net.len() as f64;
    assert!((state.surroundings - report.surroundings).abs() <= tolerance * scale);
    assert!((state.absorbed_backfaces - report.absorbed_backfaces).abs() <= tolerance * scale);
}

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
    (0..s.data().patches).for_each(|i| s.set_reflectance(i, Bands::splat(1.0 - 0.35)).unwrap());
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
    set(&mut s, "room.x0", ThermalCondition::Flux(0.0));
    assert!(s.solve().unwrap_err().to_string().contains("couples the bands"));
}

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
    assert!(s.set_reflectance(0, Bands::splat(1.5)).is_err());
    set(&mut s, "room.x1", ThermalCondition::Temperature(400.0));
    s.set_condition(0, ThermalCondition::Flux(5.0)).unwrap();
    s.set_reflectance(0, Bands::ONE).unwrap();
    assert!(s.solve().unwrap_err().to_string().contains("can give no power"));
    let data = s.data();
    type Damage = fn(&mut ExchangeData);
    let damages: BTreeMap<&str, Damage> = BTreeMap::from([
        ("exchange_areas", (|d| d.direct.areas.truncate(3)) as Damage),
        ("closure_scaling", |d| d.surroundings.scaling[0] = f64::NAN),
        ("reflectance", |d| d.reflectances[0] = Bands::splat(-1.0)),
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
