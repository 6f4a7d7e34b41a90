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
    let [dense, other] = ["dense", "rays"].map(|engine| solved(&COURT.replace("ENGINE", engine)));
    let heat = dense.report.heat.as_ref().unwrap();
    assert!(heat.balance().abs() < 1e-6, "{}", heat.balance());
    // Sunlight that enters is absorbed or escapes, and its sum over the walls is that of the last band of the energy balance.
    let sunlight: f64 = heat.rows.iter().map(|r| r.absorbed_sunlight.unwrap()).sum();
    let energy = &dense.report.energy;
    let solar = |b: zonal_scene::Bands| b.to_rgb()[1];
    let absorbed: f64 = energy.absorbed_surfaces.iter().map(|x| solar(x.1)).sum();
    assert!((absorbed - sunlight).abs() < 1e-6 * sunlight && solar(energy.residual).abs() < 1e-6);
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

/// View factor between coaxial unit squares at distance 1.
fn coaxial_squares() -> f64 {
    let root = 2f64.sqrt();
    (2.0 / std::f64::consts::PI)
        * ((4.0 / 3f64).sqrt().ln() + 2.0 * root * (1.0 / root).atan() - 0.5 * std::f64::consts::PI)
}

/// A lamp of 1 m² above a body of 1 m² in surroundings of 280 K, with lines at the head of the file, of `[solve]`, and of the body.
fn lamp_above_body(head: &str, solve: &str, body: &str) -> String {
    format!(
        "mode = \"thermal\"\n{head}\n[solve]\npatch_size = 0.25\nresidual = 1e-12\n{solve}\n[[node]]\nname = \"body\"\n[[surface]]\nname = \"lamp\"\nrectangle = {{ origin = [0,0,1], edge1 = [0,1,0], edge2 = [1,0,0] }}\ntemperature = 280\nemissivity = 1\nemission = 5000\n[[surface]]\nname = \"body\"\nrectangle = {{ origin = [0,0,0], edge1 = [1,0,0], edge2 = [0,1,0] }}\nnode = \"body\"\n{body}\n[[light]]\nkind = \"emitter\"\nsurface = \"lamp\"\n[surroundings]\ntemperature = 280\n"
    )
}

#[test]
fn a_body_below_a_lamp_emits_the_light_that_it_absorbs() {
    let absorbed = 0.4 * 5000.0 * coaxial_squares();
    let exact = blackbody_temperature(absorbed / 0.1 + STEFAN_BOLTZMANN * 280f64.powi(4));
    let grey = "emissivity = 0.1\nsolar_absorptance = 0.4";
    for (head, engine, body) in [
        ("", "dense", grey),
        ("", "rays", grey),
        (
            "bands = 4\n[thermal]\nband_fractions = [0.1, 0.2, 0.3, 0.4]",
            "dense",
            "emissivity = [0.1, 0.1, 0.1, 0.1, 0.4]",
        ),
        ("bands = 2\n[thermal]\nweights = [[0.2, 1e-4], \"rest\"]\nrange = [250, 900]", "dense", grey),
    ] {
        let engine_line = format!("engine = \"{engine}\"");
        let s = solved(&lamp_above_body(head, &engine_line, body));
        let (found, error) = temperature(&s, "body");
        let off = (found - exact).abs();
        assert!(off <= error + 1e-6 && error < 0.05 * exact, "{head} {engine}: {found} ± {error}, {exact}");
        let heat = s.report.heat.as_ref().unwrap();
        assert!((heat.emitters - 5000.0).abs() < 1e-6, "{}", heat.emitters);
        // What the lamp sends is absorbed or escapes; the body reflects 0.6 of its share.
        let sunlight: f64 = heat.rows.iter().map(|r| r.absorbed_sunlight.unwrap()).sum();
        assert!(sunlight > absorbed * (1.0 - 0.05) && sunlight < 0.5 * 5000.0, "{sunlight}");
        let stated: f64 = heat.rows.iter().map(|r| r.power_error).sum();
        let escaped = s.blocks().map(|t| t.report.energy_error.escaped.sum()).sum::<f64>();
        assert!(heat.balance().abs() <= stated + escaped, "{head} {engine}: {}", heat.balance());
    }
}

#[test]
fn walls_take_up_the_power_of_a_lamp() {
    // A lamp of 0.04 m² that emits 100 W, in a closed room; its own heat is 0, so that it absorbs what it radiates by temperature.
    for solar in [1.0, 0.3] {
        let s = solved(&format!(
            "mode = \"thermal\"\n[solve]\npatch_size = 0.25\nresidual = 1e-12\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\ntemperature = 300\nemissivity = 0.8\nsolar_absorptance = {solar}\n[[surface]]\nname = \"lamp\"\nbox = {{ min = [0.4,0.4,0.4], max = [0.6,0.6,0.6] }}\nheat_flux = 0\nemissivity = 0.5\nsolar_absorptance = 0.2\nfaces.z0.emission = 2500\n[[light]]\nkind = \"emitter\"\nsurface = \"lamp.z0\"\n"
        ));
        let heat = s.report.heat.as_ref().unwrap();
        let of_walls = || heat.rows.iter().filter(|r| r.name.starts_with("room"));
        let (power, error) = of_walls().fold((0.0, 0.0), |(q, e), r| (q + r.power, e + r.power_error));
        assert!((power + 100.0).abs() <= error + 1e-6 && error < 10.0, "{solar}: {power} ± {error}");
        assert!(heat.balance().abs() <= error + 1e-6 && (heat.emitters - 100.0).abs() < 1e-6);
        let residual = s.report.energy.residual.iter().fold(0.0f64, |m, r| m.max(r.abs()));
        assert!(residual < 1e-6, "{residual}");
        // All light is absorbed; black walls return none to the lamp, which then has their temperature.
        let absorbed: f64 = heat.rows.iter().map(|r| r.absorbed_sunlight.unwrap()).sum();
        assert!((absorbed - 100.0).abs() <= 0.01 * 100.0, "{absorbed}");
        let lamp = temperature(&s, "lamp");
        let hotter = lamp.0 - 300.0;
        match solar {
            1.0 => assert!(hotter.abs() <= lamp.1 + 1e-6, "{lamp:?}"),
            _ => assert!(hotter > lamp.1, "{lamp:?}"),
        }
    }
}

#[test]
fn a_lamp_of_a_builder_warms_as_one_of_a_file() {
    let lamp = Mesh::rectangle([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]).name("lamp");
    let body = Mesh::rectangle([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]).name("body");
    let front = zonal_scene::Sides::Front;
    let lamp = lamp.sides(front).temperature(280.0).emissivity(1.0).emission(5000.0);
    let body = body.sides(front).node("body").emissivity(0.1).solar_absorptance(0.4);
    let built = |lamp: Mesh| {
        let node = NodeCondition::Power(0.0);
        let scene = Scene::builder().surface(lamp).surface(body.clone()).node("body", node);
        let sun = Sun::new([0.0, 0.0, -1.0]).irradiance(0.0);
        scene.surroundings_temperature(280.0).light(sun).patch_size(0.25).build()
    };
    let s = solve(built(lamp.clone().as_direct_light()).unwrap(), 1 << 30, &NoProgress).unwrap();
    let file = solved(&lamp_above_body("", "", "emissivity = 0.1\nsolar_absorptance = 0.4"));
    let (a, b) = (temperature(&s, "body"), temperature(&file, "body"));
    assert!((a.0 - b.0).abs() <= 1e-6 * b.0, "{a:?} {b:?}");
    // Emission that is not light is refused.
    let error = built(lamp).unwrap_err().to_string();
    assert!(error.contains("lamp") && error.contains("emission"), "{error}");
}

/// All light of the lamp is absorbed once, whatever the engine: a medium in balance gives it off in the infrared.
#[test]
fn engines_agree_on_the_sunlight_that_a_medium_in_balance_absorbs() {
    let room = |engine: &str| {
        solved(&format!(
            "mode = \"thermal\"\n[solve]\nengine = \"{engine}\"\npatch_rule = \"voxels\"\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [2,2,2] }}\ntemperature = 300\nemissivity = 0.8\nsolar_absorptance = 0.4\nfaces.z1 = {{ temperature = 320, emission = 100 }}\n[[light]]\nkind = \"emitter\"\nsurface = \"room.z1\"\n[medium]\nmin = [0,0,0]\nmax = [2,2,2]\ncells = [6,6,6]\nextinction = 0.3\nalbedo = 0.2\nheat_source = 0\n"
        ))
    };
    let dense = room("dense");
    for engine in ["spectral", "rays"] {
        let other = room(engine);
        let mut absorbed = 0.0;
        for own in &other.report.heat.as_ref().unwrap().rows {
            let (ours, exact) =
                (own.absorbed_sunlight.unwrap(), row(&dense, &own.name).absorbed_sunlight.unwrap());
            assert!((ours - exact).abs() < 0.02 * exact, "{engine} {}: {ours} {exact}", own.name);
            absorbed += ours;
        }
        assert!((absorbed - 400.0).abs() < 2.0, "{engine}: {absorbed}");
        let (ours, exact) = (temperature(&other, "medium"), temperature(&dense, "medium"));
        assert!((ours.0 - exact.0).abs() < 0.05 && ours.1 < 3.0, "{engine}: {ours:?} {exact:?}");
    }
}
