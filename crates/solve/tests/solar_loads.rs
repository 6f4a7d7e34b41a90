//! Sunlight, planets and skies in thermal mode against closed forms and balances.

use crate::common;

use common::solved;
use zonal_scene::thermal::{STEFAN_BOLTZMANN, blackbody_temperature};
use zonal_scene::{
    GlassPane, HeatRow, Medium, Mesh, NoProgress, NodeCondition, Planet, Scene, Solution, Sun,
};
use zonal_solve::solve;

fn row<'a>(s: &'a Solution, name: &str) -> &'a HeatRow {
    s.report.heat.as_ref().unwrap().rows.iter().find(|r| r.name == name).unwrap()
}

/// Temperature with its exchange error, K.
fn temperature(s: &Solution, name: &str) -> (f64, f64) {
    let r = row(s, name);
    (r.temperature.unwrap(), r.temperature_error.unwrap())
}

/// A horizontal plate below the sun at the zenith, with the lines of its properties.
fn collector(head: &str, properties: &str) -> String {
    format!(
        "mode = \"thermal\"\n{head}\n[solve]\npatch_size = 0.5\n[[surface]]\nname = \"plate\"\nrectangle = {{ origin = [0,0,0], edge1 = [1,0,0], edge2 = [0,1,0] }}\n{properties}\n[[light]]\nkind = \"sun\"\ndirection = [0,0,-1]\nirradiance = 800\nangular_diameter = 0\n[surroundings]\ntemperature = 280\n"
    )
}

#[test]
fn a_selective_collector_stagnates_where_emission_equals_sunlight() {
    let exact = blackbody_temperature(0.95 * 800.0 / 0.1 + STEFAN_BOLTZMANN * 280f64.powi(4));
    for (head, properties) in [
        ("", "emissivity = 0.1\nsolar_absorptance = 0.95"),
        (
            "bands = 4\n[thermal]\nband_fractions = [0.1, 0.2, 0.3, 0.4]",
            "emissivity = [0.1, 0.1, 0.1, 0.1, 0.95]",
        ),
        (
            "bands = 2\n[thermal]\nweights = [[0.2, 1e-4], \"rest\"]\nrange = [250, 900]",
            "emissivity = [0.1, 0.1]\nsolar_absorptance = 0.95",
        ),
    ] {
        let s = solved(&collector(head, &format!("heat_flux = 0\n{properties}")));
        let (found, error) = temperature(&s, "plate");
        assert!((found - exact).abs() < 1e-6 && error < 1.0, "{head}: {found} ± {error}, {exact}");
        assert!((row(&s, "plate").absorbed_sunlight.unwrap() - 760.0).abs() < 1e-9);
        assert!(s.report.heat.as_ref().unwrap().balance().abs() < 1e-6);
    }
    // At a given temperature the useful heat is what the plate does not emit.
    let s = solved(&collector("", "temperature = 350\nemissivity = 0.1\nsolar_absorptance = 0.95"));
    let useful = 760.0 - 0.1 * STEFAN_BOLTZMANN * (350f64.powi(4) - 280f64.powi(4));
    assert!((row(&s, "plate").power + useful).abs() < 1e-9 * useful, "{}", row(&s, "plate").power);
    // Without a solar absorptance a grey surface is grey in sunlight too.
    let s = solved(&collector("", "heat_flux = 0\nemissivity = 0.4"));
    let grey = blackbody_temperature(800.0 + STEFAN_BOLTZMANN * 280f64.powi(4));
    assert!((temperature(&s, "plate").0 - grey).abs() < 1e-6);
}

#[test]
fn a_plate_in_low_orbit_has_the_temperature_of_its_balance() {
    let plate = Mesh::rectangle([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]).name("plate");
    let planet = Planet::new([0.0, 0.0, 1.0], 140.0).reflected_flux(400.0).temperature(255.0);
    let scene = Scene::builder()
        .surface(plate.node("plate").emissivity(0.85).solar_absorptance(0.2))
        .node("plate", NodeCondition::Power(0.0))
        .light(Sun::new([0.0, 0.0, -1.0]).irradiance(1361.0))
        .light(planet)
        .patch_size(0.5)
        .build()
        .unwrap();
    let s = solve(scene, 1 << 30, &NoProgress).unwrap();
    let seen = 70f64.to_radians().sin().powi(2);
    let infrared = 0.85 * STEFAN_BOLTZMANN * 255f64.powi(4) * seen;
    let absorbed = 0.2 * (1361.0 + 400.0 * seen) + infrared;
    let exact = blackbody_temperature(absorbed / (2.0 * 0.85));
    let (found, error) = temperature(&s, "plate");
    assert!((found - exact).abs() <= error && error < 1.0, "{found} ± {error}, {exact}");
    // Both sides have that temperature.
    let all = &s.fields.heat.as_ref().unwrap().temperature;
    assert!(all.iter().all(|t| *t == all[0]));
}

#[test]
fn a_body_at_one_temperature_balances_the_sunlight_on_three_of_its_faces() {
    let s = solved(
        "mode = \"thermal\"\n[solve]\npatch_size = 0.25\n[[node]]\nname = \"box\"\n[[surface]]\nname = \"box\"\nbox = { min = [0,0,0], max = [1,1,1] }\nnode = \"box\"\nemissivity = 0.5\nsolar_absorptance = 0.9\n[[light]]\nkind = \"sun\"\ndirection = [-1,-2,-2]\nirradiance = 1000\n",
    );
    let exact = blackbody_temperature(0.9 * 1000.0 * (5.0 / 3.0) / (6.0 * 0.5));
    let node = &s.report.heat.as_ref().unwrap().nodes[0];
    let off = (node.temperature - exact).abs();
    assert!(
        off <= node.temperature_error && node.temperature_error < 1.0,
        "{off} {}",
        node.temperature_error
    );
}

/// A room with an open top below a sky and an inclined sun. Its white walls pass sunlight on to its black floor.
const COURT: &str = "mode = \"thermal\"\n[solve]\npatch_size = 0.34\nengine = \"ENGINE\"\nresidual = 1e-12\n[[surface]]\nname = \"court\"\nroom = { min = [0,0,0], max = [1,1,1] }\nomit = [\"z1\"]\nheat_flux = 0\nemissivity = 0.9\nsolar_absorptance = 0.2\nfaces.z0 = { solar_absorptance = 1, temperature = 300 }\n[[light]]\nkind = \"sun\"\ndirection = [0.2,0,-1]\nirradiance = 700\n[[light]]\nkind = \"sky\"\nradiance = 30\n[surroundings]\ntemperature = 270\n";

#[test]
fn reflected_sunlight_is_part_of_the_balance() {
    let [dense, other] = ["dense", "hierarchical"].map(|engine| solved(&COURT.replace("ENGINE", engine)));
    let heat = dense.report.heat.as_ref().unwrap();
    assert!(heat.balance().abs() < 1e-6, "{}", heat.balance());
    // Sunlight that enters is absorbed or escapes, and its sum over the walls is that of the last band of the energy balance.
    let sunlight: f64 = heat.rows.iter().map(|r| r.absorbed_sunlight.unwrap()).sum();
    let energy = &dense.report.energy;
    let solar = |b: zonal_scene::Bands| b.to_rgb()[1];
    assert!((solar(energy.incoming) - solar(energy.escaped) - sunlight).abs() < 1e-6 * sunlight);
    assert!((row(&dense, "court.x1").absorbed_sunlight.unwrap()) > 20.0);
    for r in &heat.rows {
        let (a, b) = (r.temperature.unwrap(), temperature(&other, &r.name));
        assert!((a - b.0).abs() <= b.1 + r.temperature_error.unwrap(), "{}: {a} {b:?}", r.name);
    }
}

#[test]
fn glass_passes_sunlight_and_stops_the_infrared() {
    let of = |glass: &str| {
        let s = solved(&format!(
            "mode = \"thermal\"\n[solve]\npatch_size = 5\n[[surface]]\nname = \"plate\"\nrectangle = {{ origin = [0,0,0], edge1 = [20,0,0], edge2 = [0,20,0] }}\nheat_flux = 0\nemissivity = 1\n[[pane]]\nname = \"glass\"\npolygon = [[0,0,0.01],[20,0,0.01],[20,20,0.01],[0,20,0.01]]\nthickness = 0.004\nextinction = 1e4\n{glass}\n[[light]]\nkind = \"sun\"\ndirection = [0,0,-1]\nirradiance = 500\nangular_diameter = 0\n"
        ));
        temperature(&s, "plate")
    };
    // The glass emits as much upward as downward: the plate emits twice the sunlight.
    let (found, error) = of("solar_extinction = 0");
    let exact = blackbody_temperature(1000.0);
    assert!((found - exact).abs() <= error + 0.01 * exact, "{found} ± {error}, {exact}");
    // Glass that stops sunlight leaves the plate the half of it.
    let (found, error) = of("solar_extinction = 1e4");
    let exact = blackbody_temperature(500.0);
    assert!((found - exact).abs() <= error + 0.01 * exact, "{found} ± {error}, {exact}");
}

#[test]
fn a_cloud_absorbs_sunlight_by_its_own_properties() {
    let s = solved(
        "mode = \"thermal\"\n[solve]\nresidual = 1e-12\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [3,3,3]\nextinction = 0.5\nsolar_extinction = 2\nsolar_albedo = 0.75\nheat_source = 0\n[[light]]\nkind = \"sun\"\ndirection = [0,0,-1]\nirradiance = 1000\nangular_diameter = 0\n",
    );
    let heat = s.report.heat.as_ref().unwrap();
    assert!(heat.balance().abs() < 1e-6);
    // Of the 1000 (1 − e^−2) W that meet the cloud, a quarter is absorbed at once, and a part of the scattered rest later.
    let sunlight = heat.rows[0].absorbed_sunlight.unwrap();
    let met = 1000.0 * (1.0 - (-2f64).exp());
    assert!(sunlight > 0.25 * met && sunlight < 0.5 * met, "{sunlight}");
    let tops: Vec<f64> = (0..27).map(|i| s.fields.heat.as_ref().unwrap().temperature[i]).collect();
    assert!(tops[2] > tops[0], "the top is the warmest: {tops:?}");
}

#[test]
fn builders_give_properties_for_sunlight() {
    let wall = Mesh::room([0.0; 3], [1.0; 3]).heat_flux(0.0).emissivity(0.9);
    let glass = GlassPane::new([[0.0, 0.0, 0.5], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], 0.01, 500.0)
        .solar_extinction(10.0);
    let cloud = Medium::grid([0.0; 3], [1.0; 3], [2; 3]).extinction(0.5).heat_source(0.0).solar(2.0, 0.75);
    let builder = || Scene::builder().surface(wall.clone()).medium(cloud.clone()).pane(glass.clone());
    let scene = builder().light(Sun::new([0.0, 0.0, -1.0]).irradiance(700.0)).build().unwrap();
    let grid = scene.voxel_grid().unwrap();
    assert_eq!(scene.panes()[0].extinction.to_rgb(), [500.0, 10.0, 10.0]);
    assert_eq!((grid.extinction(3).to_rgb(), grid.albedo(3).to_rgb()), ([0.5, 2.0, 2.0], [0.0, 0.75, 0.75]));
    assert!(builder().build().unwrap_err().to_string().contains("no effect without a light"));
}
