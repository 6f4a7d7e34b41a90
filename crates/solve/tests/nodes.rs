//! Bodies at one temperature, convection, conductances and insulation, against closed forms.
//!
//! A convex body of emissivity ε and area A in a black room at T_w radiates ε A σ (T⁴ − T_w⁴), whatever its shape.

use zonal_scene::thermal::{STEFAN_BOLTZMANN, blackbody_emissive_power};
use zonal_scene::{
    BandFractions, Bands, EmissivityTable, Engine, LinkLaw, Mesh, NoProgress, NodeCondition, NodeResult,
    Scene, SceneBuilder, Solution, SolveStatus,
};

const WALL: f64 = 300.0;
/// Area of the body, m².
const AREA: f64 = 2.0 * (0.3 * 0.4 + 0.4 * 0.5 + 0.5 * 0.3);

fn room() -> SceneBuilder {
    Scene::builder().surface(
        Mesh::room([0.0; 3], [1.0; 3]).name("room").emissivity(1.0).temperature(WALL).patch_size(0.25),
    )
}

fn body() -> Mesh {
    Mesh::cuboid([0.3, 0.3, 0.2], [0.6, 0.7, 0.7]).name("body").patch_size(0.5)
}

fn solve(builder: SceneBuilder) -> Solution {
    let scene = builder.build().unwrap();
    let mut options = scene.options().clone();
    options.discretization_error = Some(false);
    options.tolerance = 0.02;
    options.engine = Engine::Dense;
    let solution = zonal_solve::solve(scene.with_options(options).unwrap(), 1 << 30, &NoProgress).unwrap();
    assert!(solution.report.status.iter().all(|s| *s == SolveStatus::Converged));
    let heat = solution.report.heat.as_ref().unwrap();
    let exchanged: f64 = heat.rows.iter().map(|r| r.power.abs()).sum();
    assert!(heat.balance().abs() <= 0.02 * exchanged.max(1e-6), "{}", heat.balance());
    solution
}

fn node<'a>(solution: &'a Solution, name: &str) -> &'a NodeResult {
    solution.report.heat.as_ref().unwrap().nodes.iter().find(|n| n.name == name).unwrap()
}

/// The root of an increasing function.
fn root(f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (1.0, 1e4);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if f(middle) < 0.0 { low = middle } else { high = middle }
    }
    low
}

fn assert_temperature(found: &NodeResult, wanted: f64) {
    let off = (found.temperature - wanted).abs();
    assert!(
        off <= found.temperature_error + 1e-9 * wanted && found.temperature_error < 0.05 * wanted,
        "{}: {} ± {}, not {wanted}",
        found.name,
        found.temperature,
        found.temperature_error
    );
}

// Guards (numbers): bodies at one temperature, convection, conductances and insulation meet closed forms within their stated errors.
#[test]
fn a_body_of_given_power_has_one_temperature() {
    let (emissivity, power) = (0.4, 250.0);
    let s = solve(
        room().surface(body().emissivity(emissivity).node("body")).node("body", NodeCondition::Power(power)),
    );
    let wanted =
        ((blackbody_emissive_power(WALL) + power / (emissivity * AREA)) / STEFAN_BOLTZMANN).powf(0.25);
    let found = node(&s, "body");
    assert_temperature(found, wanted);
    assert!(
        (found.radiated - power).abs() < 1e-6 * power && found.convected == 0.0 && found.conducted == 0.0
    );
    assert!((found.supplied() - power).abs() < 1e-6 * power);
    // All its zones have that temperature, and fluxes of their own.
    let heat = s.fields.heat.as_ref().unwrap();
    let own: Vec<usize> = (0..s.zones.len()).filter(|&i| s.zones.patches[i].surface == 1).collect();
    assert!(own.iter().all(|&i| heat.temperature[i] == found.temperature));
    let flux = (power / AREA) / emissivity * emissivity;
    assert!(own.iter().all(|&i| (heat.net[i] - flux).abs() <= heat.net_error[i] + 1e-6 * flux));
    let row = s.surface("body").unwrap();
    assert!((row.net_power - power).abs() <= row.exchange_error + 1e-6 * power);
}

#[test]
fn surfaces_of_one_node_share_their_power() {
    // A second body of the same node, and bands of different emissivity with constant fractions.
    let fractions = Bands::from_rgb([0.2, 0.3, 0.5]);
    let emissivities = [0.9, 0.5, 0.1];
    let mean = 0.2 * 0.9 + 0.3 * 0.5 + 0.5 * 0.1;
    let power = 300.0;
    let s = solve(
        room()
            .band_fractions(BandFractions::constant(fractions))
            .surface(body().emissivity(emissivities).node("body"))
            .node("body", NodeCondition::Power(power)),
    );
    let wanted = ((blackbody_emissive_power(WALL) + power / (mean * AREA)) / STEFAN_BOLTZMANN).powf(0.25);
    assert_temperature(node(&s, "body"), wanted);
    // Two plates that see each other, with one temperature, radiate as the sum of both.
    let plate = |z: f64, up: f64| Mesh::rectangle([0.3, 0.3, z], [0.4, 0.0, 0.0], [0.0, 0.4 * up, 0.0]);
    let lower = plate(0.3, 1.0).name("lower").emissivity(1.0).node("pair").patch_size(0.2);
    let upper = plate(0.7, 1.0).name("upper").emissivity(1.0).node("pair").patch_size(0.2);
    let s = solve(room().surface(lower).surface(upper).node("pair", NodeCondition::Power(40.0)));
    let pair = node(&s, "pair");
    let sum: f64 = ["lower", "upper"].map(|n| s.surface(n).unwrap().net_power).iter().sum();
    assert!((sum - 40.0).abs() < 1e-6 * 40.0 && (pair.radiated - sum).abs() < 1e-9 * sum, "{sum}");
}

#[test]
fn convection_balances_radiation_in_every_zone() {
    let (emissivity, h, air, q) = (0.7, 12.0, 350.0, 400.0);
    let s = solve(room().surface(body().emissivity(emissivity).heat_flux(q).convection(h, air)));
    let wanted = root(|t| {
        emissivity * (blackbody_emissive_power(t) - blackbody_emissive_power(WALL)) + h * (t - air) - q
    });
    let heat = s.fields.heat.as_ref().unwrap();
    for i in (0..s.zones.len()).filter(|&i| s.zones.patches[i].surface == 1) {
        let (t, dt) = (heat.temperature[i], heat.temperature_error[i]);
        assert!((t - wanted).abs() <= dt + 1e-9 * wanted && dt < 1.0, "{t} ± {dt}, not {wanted}");
        let radiated = q - h * (wanted - air);
        assert!(
            (heat.net[i] - radiated).abs() <= heat.net_error[i] + 1e-6 * radiated.abs(),
            "{}",
            heat.net[i]
        );
    }
    // The same body as a node.
    let mesh = body().emissivity(emissivity).node("body").convection(h, air);
    let s = solve(room().surface(mesh).node("body", NodeCondition::Power(q * AREA)));
    let found = node(&s, "body");
    assert_temperature(found, wanted);
    let convected = h * AREA * (found.temperature - air);
    assert!((found.convected - convected).abs() < 1e-9 * convected.abs());
    assert!((found.supplied() - q * AREA).abs() < 1e-6 * q * AREA, "{}", found.supplied());
}

#[test]
fn heat_flows_through_nodes_without_surfaces() {
    // base (600 K) – 0.5 W/K – joint – 0.25 W/K – body
    let emissivity = 0.8;
    let s = solve(
        room()
            .surface(body().emissivity(emissivity).node("body"))
            .node("base", NodeCondition::Temperature(600.0))
            .node("joint", NodeCondition::Power(0.0))
            .node("body", NodeCondition::Power(0.0))
            .link(["base", "joint"], LinkLaw::Conductance(0.5))
            .link(["joint", "body"], LinkLaw::Conductance(0.25)),
    );
    let series = 1.0 / (1.0 / 0.5 + 1.0 / 0.25);
    let radiated =
        |t: f64| emissivity * AREA * (blackbody_emissive_power(t) - blackbody_emissive_power(WALL));
    let wanted = root(|t| radiated(t) - series * (600.0 - t));
    assert_temperature(node(&s, "body"), wanted);
    let flow = series * (600.0 - wanted);
    assert_temperature(node(&s, "joint"), 600.0 - flow / 0.5);
    let base = node(&s, "base");
    assert!((base.conducted - flow).abs() < 1e-4 * flow && base.radiated == 0.0);
}

#[test]
fn insulation_has_an_effective_emissivity() {
    let (skin, effective, power) = (0.6, 0.02, 5.0);
    let s = solve(
        room()
            .surface(body().emissivity(skin).node("skin"))
            .node("skin", NodeCondition::Power(0.0))
            .node("tank", NodeCondition::Power(power))
            .link(["skin", "tank"], LinkLaw::EffectiveEmissivity(effective)),
    );
    let e_skin = blackbody_emissive_power(WALL) + power / (skin * AREA);
    let kelvin = |e: f64| (e / STEFAN_BOLTZMANN).powf(0.25);
    assert_temperature(node(&s, "skin"), kelvin(e_skin));
    assert_temperature(node(&s, "tank"), kelvin(e_skin + power / (effective * AREA)));
    // The same by a conductance over the area.
    let conductance = 0.1;
    let s = solve(
        room()
            .surface(body().emissivity(skin).node("skin"))
            .node("skin", NodeCondition::Power(0.0))
            .node("tank", NodeCondition::Power(power))
            .link(["skin", "tank"], LinkLaw::ConductancePerArea(conductance)),
    );
    assert_temperature(node(&s, "tank"), kelvin(e_skin) + power / (conductance * AREA));
}

// Guards (numbers): bodies at one temperature, convection, conductances and insulation meet closed forms within their stated errors.
/// A fin of n cells between x = 0 and L, whose root has a given temperature and whose tip is adiabatic, with convection alone: the temperature of cell k is
/// T∞ + θ₀ c cosh(β (n − k − ½)), 2 (cosh β − 1) = h P Δ/C for the conductance C between cells and their cooled area PΔ; at the root half a cell.
#[test]
fn fins_with_convection_have_the_profile_of_the_difference_equation() {
    let (n, h, air, root_temperature, conductance) = (20usize, 25.0, 300.0, 400.0, 0.2);
    let (length, width) = (0.8, 0.1);
    let cell = length / n as f64;
    let mut builder = room().node("root", NodeCondition::Temperature(root_temperature));
    for k in 0..n {
        let name = format!("fin{k}");
        let strip = Mesh::rectangle([0.1 + k as f64 * cell, 0.4, 0.5], [cell, 0.0, 0.0], [0.0, width, 0.0]);
        builder = builder
            .surface(strip.name(name.clone()).emissivity(0.0).node(name.clone()).convection(h, air))
            .node(name, NodeCondition::Power(0.0));
    }
    builder = builder.link(["root", "fin0"], LinkLaw::Conductance(2.0 * conductance));
    for k in 1..n {
        let names = [format!("fin{}", k - 1), format!("fin{k}")];
        builder = builder.link([&names[0], &names[1]], LinkLaw::Conductance(conductance));
    }
    let s = solve(builder);
    // Both sides of the strips are cooled.
    let cooled = h * 2.0 * cell * width;
    let beta = (1.0 + 0.5 * cooled / conductance).acosh();
    let shape = |k: f64| (beta * (n as f64 - k - 0.5)).cosh();
    // Root: 2 C (θ_root − θ_0) = C (θ_0 − θ_1) + h A θ_0.
    let amplitude = 2.0 * (root_temperature - air)
        / (2.0 * shape(0.0) + (shape(0.0) - shape(1.0)) + cooled / conductance * shape(0.0));
    for k in 0..n {
        let found = node(&s, &format!("fin{k}")).temperature;
        let wanted = air + amplitude * shape(k as f64);
        assert!((found - wanted).abs() < 1e-9 * wanted, "{k}: {found}, not {wanted}");
    }
}

// Guards (numbers): each side of a sheet has its own emissivity.
#[test]
fn sides_of_a_sheet_have_emissivities_of_their_own() {
    let (emissivities, power) = ([0.8, 0.1], 60.0);
    let sheet =
        Mesh::rectangle([0.3, 0.3, 0.5], [0.4, 0.0, 0.0], [0.0, 0.4, 0.0]).name("sheet").patch_size(0.2);
    let sheet = sheet.emissivity(emissivities[0]).back_emissivity(emissivities[1]).node("sheet");
    let s = solve(room().surface(sheet).node("sheet", NodeCondition::Power(power)));
    let flux = power / ((emissivities[0] + emissivities[1]) * 0.16);
    let wanted = ((blackbody_emissive_power(WALL) + flux) / STEFAN_BOLTZMANN).powf(0.25);
    assert_temperature(node(&s, "sheet"), wanted);
    let heat = s.fields.heat.as_ref().unwrap();
    for (i, p) in s.zones.patches.iter().enumerate().filter(|(_, p)| p.surface == 1) {
        let emissivity = if p.normal.z > 0.0 { emissivities[0] } else { emissivities[1] };
        assert!((p.reflectance - (1.0 - emissivity)).abs().all(|d| d < 1e-12));
        let off = (heat.net[i] - emissivity * flux).abs();
        assert!(off <= heat.net_error[i] + 1e-6 * flux, "{i}: {} ± {}", heat.net[i], heat.net_error[i]);
    }
}

// Guards (numbers): emissivities follow the temperatures found, and the stated errors contain their response.
#[test]
fn emissivities_follow_the_temperatures_found() {
    let table = EmissivityTable::new(&[[250.0, 0.1], [400.0, 0.3], [800.0, 0.7]]).unwrap();
    let wall = blackbody_emissive_power(WALL);
    let radiated = |t: f64| table.at(t) * AREA * (blackbody_emissive_power(t) - wall);
    let own = || body().emissivity_by_temperature(table.clone());
    for power in [40.0, 400.0, 4000.0] {
        // One temperature of a node, and a temperature in each zone.
        let of_node = solve(room().surface(own().node("body")).node("body", NodeCondition::Power(power)));
        let wanted = root(|t| radiated(t) - power);
        assert_temperature(node(&of_node, "body"), wanted);
        let s = solve(room().surface(own().net_power(power)));
        let row = s.surface("body").unwrap();
        let (t, error) = (row.temperature.unwrap(), row.temperature_exchange_error.unwrap());
        assert!((t - wanted).abs() <= error && error < 0.03 * wanted, "{t} ± {error}, not {wanted}");
        assert!((row.net_power - power).abs() <= row.exchange_error + 1e-6 * power);
        let emissivity = table.at(t);
        let of_body = s.zones.patches.iter().filter(|p| p.surface == 1);
        of_body.for_each(|p| assert!((p.reflectance - (1.0 - emissivity)).abs().all(|d| d < 1e-2)));
        assert!(s.report.counts.iter().any(|(name, n)| name.contains("emissivities") && *n > 2));
    }
    // A given temperature needs no iteration.
    let s = solve(room().surface(own().temperature(500.0)));
    let row = s.surface("body").unwrap();
    assert!((row.net_power - radiated(500.0)).abs() <= row.exchange_error + 1e-6 * row.net_power);
    assert!(s.report.counts.iter().all(|(name, n)| !name.contains("emissivities") || *n == 1));
}

// Guards (numbers): emissivities follow the temperatures found, and the stated errors contain their response.
#[test]
fn errors_cover_the_response_of_emissivities_to_altered_temperatures() {
    // Emissivity falls with temperature, which amplifies errors: two thirds of the fourth power are undone.
    let points: Vec<[f64; 2]> =
        (0..60).map(|k| 300.0 + 10.0 * k as f64).map(|t| [t, 0.9 * (300.0 / t).powf(2.5)]).collect();
    let table = EmissivityTable::new(&points).unwrap();
    let wall = blackbody_emissive_power(WALL);
    for power in [200.0, 800.0] {
        let wanted = root(|t| table.at(t) * AREA * (blackbody_emissive_power(t) - wall) - power);
        let own = body().emissivity_by_temperature(table.clone()).node("body");
        let s = solve(room().surface(own).node("body", NodeCondition::Power(power)));
        let found = node(&s, "body");
        let off = (found.temperature - wanted).abs();
        assert!(
            off <= found.temperature_error,
            "{} ± {}, not {wanted}",
            found.temperature,
            found.temperature_error
        );
    }
    // An emissivity that grows steeply: without damping, the iteration alternates between its ends.
    let steep = EmissivityTable::new(&[[300.0, 0.1], [400.0, 0.1], [402.0, 0.9]]).unwrap();
    let wanted = root(|t| steep.at(t) * AREA * (blackbody_emissive_power(t) - wall) - 500.0);
    assert!((400.0..402.0).contains(&wanted));
    let own = body().emissivity_by_temperature(steep.clone()).node("body");
    let s = solve(room().surface(own).node("body", NodeCondition::Power(500.0)));
    assert_temperature(node(&s, "body"), wanted);
}
