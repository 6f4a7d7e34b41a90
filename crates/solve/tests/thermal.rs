//! Temperatures: closed forms, published problems, physical laws.

use crate::common;

use common::{add, gas, mean, patches_of, read, solve, solved, surface, tetrahedron};
use zonal_math::{Vec3, vec3};
use zonal_reference::test_cases::sampled_cases;
use zonal_scene::thermal::{STEFAN_BOLTZMANN, blackbody_emissive_power, blackbody_temperature};
use zonal_scene::{
    BandFractions, Bands, Engine, HeatRow, NoProgress, PerBand, Plate, Scene, SceneParts, Solution,
    SolveStatus, Thermal, ThermalCondition, VoxelGrid,
};

fn row<'a>(s: &'a Solution, name: &str) -> &'a HeatRow {
    let rows = &s.report.heat.as_ref().expect("a thermal solution").rows;
    rows.iter().find(|r| r.name == name).unwrap_or_else(|| panic!("no row {name}"))
}

fn flux(s: &Solution, name: &str) -> f64 {
    row(s, name).flux()[0]
}

/// Σ of the absolute net powers, W.
fn turnover(s: &Solution) -> f64 {
    s.report.heat.as_ref().unwrap().rows.iter().map(|r| r.power.abs()).sum()
}

fn balance(s: &Solution) -> f64 {
    s.report.heat.as_ref().unwrap().balance() / turnover(s)
}

/// The furnace of 2 × 2 × 4 m: source 5 kW/m³, extinction 0.5 1/m, m cells a metre.
fn furnace(m: usize, albedo: f64, engine: &str) -> String {
    format!(
        "mode = \"thermal\"\n[solve]\npatch_rule = \"voxels\"\nengine = \"{engine}\"\nzone_basis = \"constant\"\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [2,2,4] }}\ntemperature = 900\nemissivity = 0.7\nfaces.z0 = {{ temperature = 1200, emissivity = 0.85 }}\nfaces.z1 = {{ temperature = 400 }}\n[medium]\nmin = [0,0,0]\nmax = [2,2,4]\ncells = [{}, {}, {}]\nextinction = 0.5\nalbedo = {albedo}\nheat_source = 5000\n",
        2 * m,
        2 * m,
        4 * m
    )
}

#[test]
fn furnace_matches_all_printed_digits() {
    // m, kW/m² into z = 0, z = 4 and the sides; published to four decimals.
    for (m, want) in [(2, [-54.7153, 24.5598, 6.2694]), (4, [-54.1440, 24.3445, 6.2249])] {
        for albedo in [0.0, 0.7] {
            for engine in ["dense", "spectral"] {
                if m > 2 && engine == "dense" {
                    continue;
                }
                let s = solved(&furnace(m, albedo, engine));
                for (name, want) in ["room.z0", "room.z1", "room.x0"].iter().zip(want) {
                    let q = -1e-3 * flux(&s, name);
                    assert!((q - want).abs() < 5.1e-5, "m = {m}, Ω = {albedo}, {engine}: {name} {q}");
                }
                assert!((row(&s, "medium").power - 80e3).abs() < 1e-6);
                assert!(balance(&s).abs() < 1e-11, "{:e}", balance(&s));
                assert_eq!(s.report.status, PerBand::splat(SolveStatus::Converged));
            }
        }
    }
}

/// The zone of the cell that holds a point.
fn zone_at(s: &Solution, p: Vec3) -> usize {
    let map = s.scene.voxel_grid().unwrap();
    let cell = map.index(map.cell_at(p).unwrap());
    s.zones.voxel_offset() + s.zones.voxel_zones_of_cell(cell).start
}

#[test]
fn furnace_has_the_published_profiles() {
    let s = solved(&furnace(6, 0.0, "spectral"));
    let kelvin = &s.fields.heat.as_ref().unwrap().temperature;
    for (z, want) in [
        (0.083, 1096.4),
        (0.417, 1055.4),
        (1.083, 996.0),
        (1.917, 954.2),
        (2.917, 916.0),
        (3.583, 873.1),
        (3.917, 835.4),
    ] {
        let t = kelvin[zone_at(&s, vec3(0.95, 0.95, z))];
        assert!((t - want).abs() < 0.051, "z = {z}: {t} K");
    }
    // The middle line of a side wall, kW/m² into it.
    let net = &s.fields.heat.as_ref().unwrap().net;
    for (z, want) in
        [(0.083, 29.696), (0.417, 21.567), (1.083, 11.739), (1.917, 5.468), (2.917, 0.325), (3.917, -8.395)]
    {
        let near = |i: &&usize| {
            let c = s.zones.patches[**i].plate.centre();
            (c.y - 0.95).abs() < 0.1 && (c.z - z).abs() < 0.05
        };
        let list = patches_of(&s, "room.x0");
        let i = list.iter().find(near).unwrap();
        assert!((-1e-3 * net[*i] - want).abs() < 5.1e-4, "z = {z}: {}", -1e-3 * net[*i]);
    }
    // With albedo 0.7 the source function is the same and the temperatures differ.
    let other = solved(&furnace(6, 0.7, "spectral"));
    let t =
        |s: &Solution, z: f64| s.fields.heat.as_ref().unwrap().temperature[zone_at(s, vec3(0.95, 0.95, z))];
    for (z, want) in [(0.4, [1057.0, 1079.0]), (2.0, [951.0, 980.0]), (3.6, [871.0, 908.0])] {
        // A zone is 17 cm high; the table holds point values.
        assert!((t(&s, z) - want[0]).abs() < 4.0 && (t(&other, z) - want[1]).abs() < 4.0, "z = {z}");
    }
    let shift = 5000.0 / (4.0 * 0.5) * (1.0 / 0.3 - 1.0);
    let i = zone_at(&s, vec3(0.3, 1.1, 2.2));
    let of = |s: &Solution| blackbody_emissive_power(s.fields.heat.as_ref().unwrap().temperature[i]);
    assert!((of(&other) - of(&s) - shift).abs() < 1e-6 * shift);
}

#[test]
fn rays_match_the_furnace_within_their_errors() {
    let exact = solved(&furnace(2, 0.3, "dense"));
    let text = furnace(2, 0.3, "rays").replace("[solve]", "[solve]\nclosure = \"restore\"");
    let s = solved(&text);
    for name in ["room.z0", "room.z1", "room.x0", "room.y1"] {
        let ([q, e], want) = (row(&s, name).flux(), flux(&exact, name));
        assert!((q - want).abs() <= e, "{name}: {q} ± {e}, exact {want}");
        // The stated error is at most two per cent of the exchanged power.
        assert!(e < 0.1 * blackbody_emissive_power(1200.0), "{name}: ± {e}");
    }
    let warm = |s: &Solution| row(s, "medium").temperature.unwrap();
    assert!((warm(&s) - warm(&exact)).abs() <= row(&s, "medium").temperature_error.unwrap().max(1e-6));
}

/// A slab one cell wide between plates, τ thick, its medium in radiative equilibrium.
fn slab(tau: f64, cells: usize, [hot, cold]: [f64; 2]) -> String {
    format!(
        "mode = \"thermal\"\n[boundary]\nx = \"periodic\"\ny = \"periodic\"\n[solve]\npatch_rule = \"voxels\"\n[[surface]]\nname = \"slab\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\nomit = [\"x0\", \"x1\", \"y0\", \"y1\"]\nfaces.z0 = {{ temperature = 1000, emissivity = {hot} }}\nfaces.z1 = {{ temperature = 500, emissivity = {cold} }}\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [1, 1, {cells}]\nextinction = {tau}\nheat_source = 0\n"
    )
}

#[test]
fn slabs_reach_radiative_equilibrium() {
    let plain = |text: String| text.replace("[solve]", "[solve]\nzone_basis = \"constant\"");
    let psi = |tau: f64, eps: [f64; 2]| {
        // The error falls with the square of the cells.
        let [a, b] = [24, 48].map(|n| flux(&solved(&plain(slab(tau, n, eps))), "slab.z0"));
        (b + (b - a) / 3.0) / (blackbody_emissive_power(1000.0) - blackbody_emissive_power(500.0))
    };
    for (tau, want) in [(0.2, 0.84917879), (1.0, 0.55340599), (3.0, 0.30164472)] {
        let black = psi(tau, [1.0, 1.0]);
        assert!((black - want).abs() < 1e-5, "τ = {tau}: {black}");
        let [e1, e2] = [0.8, 0.35];
        let grey = want / (1.0 + want * (1.0 / e1 + 1.0 / e2 - 2.0));
        assert!((psi(tau, [e1, e2]) - grey).abs() < 1e-5, "τ = {tau}");
    }
    // A linear basis needs few cells, for grey and coupled bands.
    for shares in [BandFractions::Grey, BandFractions::constant(Bands::from_rgb([0.5, 0.3, 0.2]))] {
        let text = slab(1.0, 12, [1.0, 1.0]).replace("[solve]", "[solve]\nzone_basis = \"linear\"");
        let mut parts = read(&text).into_parts();
        parts.thermal.as_mut().unwrap().band_fractions = shares;
        let s = solve(Scene::new(parts).unwrap());
        let psi = flux(&s, "slab.z0") / (blackbody_emissive_power(1000.0) - blackbody_emissive_power(500.0));
        assert!((psi - 0.55340599).abs() < 1e-5, "{psi}");
    }
    // Almost no medium: two plates.
    let s = solved(&slab(1e-9, 1, [0.8, 0.35]));
    let want =
        (blackbody_emissive_power(1000.0) - blackbody_emissive_power(500.0)) / (1.0 / 0.8 + 1.0 / 0.35 - 1.0);
    assert!((flux(&s, "slab.z0") / want - 1.0).abs() < 1e-8);
}

#[test]
fn cube_in_equilibrium_equals_its_scattering_analogue() {
    let cube = |mode: &str, walls: &str, rest: &str| {
        format!(
            "{mode}[solve]\npatch_rule = \"voxels\"\nengine = \"dense\"\nresidual = 1e-14\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\n{walls}\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [5, 5, 5]\nextinction = 1\n{rest}\n"
        )
    };
    let hot = blackbody_temperature(1.0);
    let warm = solved(&cube(
        "mode = \"thermal\"\n",
        &format!("temperature = 1e-3\nemissivity = 1\nfaces.z0.temperature = {hot}"),
        "albedo = 0.3\nheat_source = 0",
    ));
    let light = solved(&cube("", "reflectance = 0\nfaces.z0.emission = 1", "albedo = 1"));
    for (x, y) in warm.fields.radiosity.iter().flatten().zip(light.fields.radiosity.iter().flatten()) {
        assert!((x - y).abs() < 1e-10, "{x} {y}");
    }
    assert!((flux(&warm, "room.z0") - 0.876007).abs() < 5.1e-7);
    let h = mean(&light, &light.fields.incident, &patches_of(&light, "z1"));
    assert!((flux(&warm, "room.z1") + h).abs() < 1e-10);
    // (1/6)^¼ of the hot wall in the middle.
    let t = warm.fields.heat.as_ref().unwrap().temperature[zone_at(&warm, vec3(0.5, 0.5, 0.5))];
    assert!((t / hot - (1.0f64 / 6.0).powf(0.25)).abs() < 1e-9);
}

struct Dice(u64);

impl Dice {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// An isothermal room with a tetrahedron, a heterogeneous medium and random optical properties; parts selected by `skip` are in equilibrium
/// instead.
fn isothermal(seed: u64, t: f64, shares: BandFractions, skip: impl Fn(usize) -> bool) -> Scene {
    let mut dice = Dice(seed);
    let grey = shares.is_grey();
    let look = |dice: &mut Dice| {
        let r = Bands::from_fn(|_| 0.95 * dice.next());
        if grey { Bands::splat(r.first()) } else { r }
    };
    let mut parts = SceneParts::default();
    let (mut surfaces, mut k) = (Vec::new(), 0);
    let mut known = || {
        k += 1;
        if skip(k) { ThermalCondition::Flux(0.0) } else { ThermalCondition::Temperature(t) }
    };
    let plates = |lo: Vec3, s: Vec3| {
        let (x, y, z) = (vec3(s.x, 0.0, 0.0), vec3(0.0, s.y, 0.0), vec3(0.0, 0.0, s.z));
        [
            Plate::parallelogram(lo, x, y),
            Plate::parallelogram(lo + z, y, x),
            Plate::parallelogram(lo, y, z),
            Plate::parallelogram(lo + x, z, y),
            Plate::parallelogram(lo, z, x),
            Plate::parallelogram(lo + y, x, z),
        ]
    };
    for (i, p) in plates(Vec3::ZERO, vec3(2.0, 1.5, 1.0)).into_iter().enumerate() {
        let mut s = surface(&format!("wall {i}"), 0.0, 0.0, false);
        s.reflectance = look(&mut dice);
        add(&mut parts, s, &[p]);
        surfaces.push(known());
    }
    let mut s = surface("body", 0.0, 0.0, true);
    s.reflectance = look(&mut dice);
    add(&mut parts, s, &tetrahedron(vec3(1.1, 0.7, 0.5), 0.3));
    surfaces.push(known());
    let mut map = VoxelGrid::new(Vec3::ZERO, vec3(0.5, 0.5, 0.5), [4, 3, 2]).unwrap();
    for i in 0..map.len() {
        let kappa = Bands::from_fn(|_| 2.0 * dice.next());
        let kappa = if grey { Bands::splat(kappa.first()) } else { kappa };
        map.set(i, kappa, look(&mut dice), Bands::ZERO, Bands::ZERO);
        map.set_heat(i, known(), ThermalCondition::Flux(0.0));
    }
    parts.voxel_grid = Some(map.seal().unwrap());
    parts.options.patch_size = Some(0.5);
    parts.options.engine = Engine::Dense;
    parts.options.restore_closure = Some(true);
    parts.options.tolerance = 0.03;
    parts.thermal = Some(Thermal { band_fractions: shares, surfaces, ..Thermal::default() });
    Scene::new(parts).unwrap()
}

fn falling() -> BandFractions {
    BandFractions::GreyGases {
        all_bands: None,
        coefficients: PerBand::from_rgb([vec![0.5, -1e-4], vec![0.3, 2e-4, -3e-8], vec![0.2, -1e-4, 3e-8]]),
        range: [300.0, 2500.0],
        allow_partial: false,
    }
}

// Guards (numbers): an isothermal scene has no net power.
#[test]
fn isothermal_scene_has_no_net_power() {
    let t = 873.0;
    let every_third: fn(usize) -> bool = |k| k % 3 == 0;
    let scenes = [
        (1, BandFractions::Grey),
        (2, BandFractions::Grey),
        (3, BandFractions::constant(Bands::from_rgb([0.2, 0.3, 0.5]))),
        (4, falling()),
    ];
    let skipped_parts = [(|_| false) as fn(usize) -> bool, every_third, |k| k != 5];
    let cases = scenes.iter().flat_map(|scene| skipped_parts.map(|skip| (scene, skip)));
    for ((seed, shares), skip) in sampled_cases(cases, &[1, 11]) {
        let scene = isothermal(*seed, t, shares.clone(), skip);
        let s = zonal_solve::solve(scene, 4 << 30, &NoProgress).unwrap();
        let heat = s.fields.heat.as_ref().unwrap();
        // Closure is restored to 1e-13; a level fixed by one wall has the accuracy of the solver.
        for (i, (q, t1)) in heat.net.iter().zip(&heat.temperature).enumerate() {
            assert!(q.abs() < 1e-6 * blackbody_emissive_power(t), "seed {seed}, zone {i}: {q} W/m²");
            assert!((t1 - t).abs() < 1e-5 * t, "seed {seed}, zone {i}: {t1} K");
        }
        assert_eq!(s.report.status, PerBand::splat(SolveStatus::Converged), "seed {seed}");
    }
}

// Guards (numbers): net powers sum to zero.
#[test]
fn net_powers_sum_to_zero() {
    let cases = [
        (5, BandFractions::Grey),
        (6, BandFractions::constant(Bands::from_rgb([0.6, 0.4, 0.0]))),
        (7, falling()),
    ];
    for (seed, shares) in sampled_cases(cases, &[1, 2]) {
        let mut parts = isothermal(seed, 700.0, shares, |k| k % 4 == 0).into_parts();
        let t = parts.thermal.as_mut().unwrap();
        t.surfaces[0] = ThermalCondition::Temperature(1400.0);
        t.surfaces[1] = ThermalCondition::Power(5e3);
        t.surfaces[2] = ThermalCondition::Flux(-2e3);
        let s = zonal_solve::solve(Scene::new(parts).unwrap(), 4 << 30, &NoProgress).unwrap();
        assert!(balance(&s).abs() < 1e-8, "seed {seed}: {:e}", balance(&s));
        assert!((row(&s, "wall 1").power - 5e3).abs() < 1e-9);
        assert!((flux(&s, "wall 2") + 2e3).abs() < 1e-9);
        // The energy balance is that of the zones with the temperatures found.
        assert!(s.report.energy.residual.abs().all(|r| r < 1e-7), "{:?}", s.report.energy.residual);
        // The radiosity is the sum of emission and reflection.
        for i in 0..s.zones.len() {
            let (e, (r, _), h) = (s.zones.emission(i), s.zones.response(i), s.fields.incident[i]);
            let x = s.fields.radiosity[i];
            let difference = (e + r * h - x).abs() / x.abs().max(Bands::ONE);
            assert!(difference.all(|d| d < 1e-9), "zone {i}");
        }
    }
}

#[test]
fn flux_and_temperature_problems_are_inverse() {
    let mut parts = isothermal(11, 600.0, falling(), |_| false).into_parts();
    parts.thermal.as_mut().unwrap().surfaces[3] = ThermalCondition::Temperature(1500.0);
    let first = solve(Scene::new(parts.clone()).unwrap());
    // The fluxes of the patches of a wall differ, so the cells are inverted.
    let heat = first.fields.heat.clone().unwrap();
    let mut map = parts.voxel_grid.take().unwrap();
    for (k, v) in first.zones.voxels.iter().enumerate() {
        if first.zones.voxel_zones_of_cell(v.cell).len() == 1 {
            map.set_heat(
                v.cell,
                ThermalCondition::Flux(heat.net[first.zones.voxel_offset() + k]),
                ThermalCondition::Flux(0.0),
            );
        }
    }
    parts.voxel_grid = Some(map.seal().unwrap());
    parts.options.residual = 1e-12;
    let second = solve(Scene::new(parts).unwrap());
    let again = second.fields.heat.as_ref().unwrap();
    for (i, (t, u)) in heat.temperature.iter().zip(&again.temperature).enumerate() {
        assert!((t - u).abs() < 1e-6 * t, "zone {i}: {t} {u}");
    }
}

#[test]
fn convex_body_in_a_black_room_has_its_net_power() {
    // A black room sends σT⁴ to all of a convex body.
    let mut parts = SceneParts::default();
    let room = isothermal(3, 400.0, BandFractions::Grey, |_| false);
    parts.surfaces = room.surfaces().to_vec();
    parts.facets = room.facets().to_vec();
    parts.surfaces.iter_mut().for_each(|s| s.reflectance = Bands::ZERO);
    parts.surfaces[6].reflectance = Bands::splat(0.37);
    parts.options.patch_size = Some(0.25);
    parts.options.restore_closure = Some(true);
    let mut known = vec![ThermalCondition::Temperature(400.0); 7];
    known[6] = ThermalCondition::Temperature(900.0);
    parts.thermal = Some(Thermal { surfaces: known, ..Thermal::default() });
    let s = solve(Scene::new(parts).unwrap());
    let want = 0.63 * STEFAN_BOLTZMANN * (900.0f64.powi(4) - 400.0f64.powi(4));
    let [q, e] = row(&s, "body").flux();
    assert!((q / want - 1.0).abs() < 1e-9, "{q} ± {e}, {want}");
    assert!((q - want).abs() <= e.max(1e-9 * want));
}

#[test]
fn weakly_absorbing_cavity_reaches_the_wall_temperature() {
    // A step reflects almost all power: the change of a single step is small long before convergence.
    let text = "mode = \"thermal\"\n[solve]\nengine = \"rays\"\ntolerance = 0.05\npatch_size = 0.5\n[[surface]]\nname = \"room\"\nroom = { min = [0,0,0], max = [1,1,1] }\nemissivity = 0.4\nheat_flux = 0\n[[surface]]\nname = \"core\"\nbox = { min = [0.4,0.4,0.4], max = [0.55,0.6,0.6] }\nemissivity = 0.1\ntemperature = 1100\n";
    let s = solved(text);
    let rows = &s.report.heat.as_ref().unwrap().rows;
    for row in rows.iter().filter(|r| r.name.starts_with("room")) {
        let (t, error) = (row.temperature.unwrap(), row.temperature_error.unwrap());
        assert!((t - 1100.0).abs() <= error && error < 200.0, "{}: {t} ± {error}", row.name);
        assert!((t - 1100.0).abs() < 1.0, "{}: {t}", row.name);
    }
}

#[test]
fn source_without_walls_heats_the_surroundings() {
    // A warm medium in surroundings of 300 K, by the rays and the dense engine.
    let text = |engine: &str| {
        format!(
            "mode = \"thermal\"\nsurroundings.temperature = 300\n[solve]\nengine = \"{engine}\"\npatch_size = 0.25\n[[surface]]\nname = \"floor\"\nrectangle = {{ origin = [0,0,0], edge1 = [1,0,0], edge2 = [0,1,0] }}\nheat_flux = 0\nemissivity = 0.6\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [4, 4, 4]\nabsorption = 0.7\nheat_source = 2000\n"
        )
    };
    let dense = solved(&text("dense"));
    let heat = dense.report.heat.as_ref().unwrap();
    // The whole power of the medium escapes.
    assert!((heat.surroundings + 2000.0).abs() < 20.0, "{}", heat.surroundings);
    let cold = blackbody_emissive_power(300.0);
    assert!(row(&dense, "floor").temperature.is_some_and(|t| blackbody_emissive_power(t) > cold));
    let rays = solved(&text("rays"));
    let [a, b] = [&dense, &rays].map(|s| row(s, "medium").temperature.unwrap());
    assert!((a / b - 1.0).abs() < 0.01, "{a} {b}");
}

#[test]
fn equal_bands_match_the_grey_scene() {
    // With equal optical properties in all bands the band fractions do not matter.
    let text = furnace(2, 0.4, "dense");
    let grey = solved(&text);
    let constant = BandFractions::constant(Bands::from_rgb([0.2, 0.5, 0.3]));
    let cases = [
        (Engine::Dense, constant.clone()),
        (Engine::Spectral, constant.clone()),
        (Engine::Rays, constant),
        (Engine::Dense, falling()),
        (Engine::Spectral, falling()),
        (Engine::Dense, gas()),
        (Engine::Spectral, gas()),
    ];
    for (engine, shares) in sampled_cases(cases, &[0, 2, 4, 6]) {
        let mut parts = read(&text).into_parts();
        parts.thermal.as_mut().unwrap().band_fractions = shares.clone();
        parts.options.engine = engine;
        let s = solve(Scene::new(parts).unwrap());
        let close = if engine == Engine::Rays { 0.03 } else { 1e-8 };
        for name in ["room.z0", "room.z1", "room.y1"] {
            let (a, b) = (flux(&s, name), flux(&grey, name));
            assert!((a - b).abs() < close * 54e3, "{engine:?} {name}: {a} {b}");
        }
        assert_eq!(s.report.status, PerBand::splat(SolveStatus::Converged), "{engine:?} {shares:?}");
    }
}

#[test]
fn undefined_temperatures_are_reported() {
    let room = |look: &str, rest: &str| {
        format!(
            "mode = \"thermal\"\n[solve]\npatch_size = 0.5\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\n{look}\n{rest}"
        )
    };
    // The level of the temperatures is undetermined.
    let e = zonal_solve::solve(read(&room("heat_flux = 0\nemissivity = 0.5", "")), 4 << 30, &NoProgress)
        .unwrap_err();
    assert!(e.to_string().contains("level of the temperatures is undetermined"), "{e}");
    // A perfect mirror has no temperature.
    let s = solved(&room(
        "temperature = 500\nemissivity = 0.5\nfaces.x0 = { heat_flux = 0, emissivity = 0 }",
        "",
    ));
    assert_eq!(row(&s, "room.x0").temperature, None);
    assert!(
        s.report.warnings.iter().any(|w| w.contains("temperature is undefined")),
        "{:?}",
        s.report.warnings
    );
    assert!(balance(&s).is_nan() || turnover(&s) < 1e-6);
    // More heat is extracted than arrives.
    let s = solved(&room(
        "temperature = 300\nemissivity = 1\nfaces.x0 = { heat_flux = -5000, emissivity = 1 }",
        "",
    ));
    assert!(
        s.report.warnings.iter().any(|w| w.contains("more heat is extracted")),
        "{:?}",
        s.report.warnings
    );
    assert!(s.fields.heat.as_ref().unwrap().temperature.iter().any(|t| t.is_nan()));
    // Absorption only in bands without emission; no negative powers are reported.
    let s = solved(&room(
        "temperature = 600\nemissivity = [0.2, 0.5, 0.9]",
        "[thermal]\nband_fractions = [0, 0, 1]\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [2,2,2]\nextinction = [1, 4, 0]\nheat_source = 0",
    ));
    let notes = &s.report.warnings;
    assert!(notes.iter().any(|w| w.contains("8 zones emit in no band")), "{notes:?}");
    assert!(!notes.iter().any(|w| w.contains("negative")), "{notes:?}");
}

#[test]
fn panes_have_prescribed_or_equilibrium_temperatures() {
    let text = |pane: &str| {
        format!(
            "mode = \"thermal\"\n[solve]\npatch_size = 0.25\nclosure = \"restore\"\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\ntemperature = 400\nemissivity = 0.7\nfaces.z0.temperature = 900\n[[pane]]\nname = \"screen\"\npolygon = [[0,0,0.5],[1,0,0.5],[1,1,0.5],[0,1,0.5]]\nthickness = 0.01\nextinction = 150\nalbedo = 0.2\n{pane}\n"
        )
    };
    let calm = solved(&text("heat_source = 0"));
    assert_eq!(row(&calm, "screen").power, 0.0);
    let t = row(&calm, "screen").temperature.unwrap();
    assert!(t > 400.0 && t < 900.0, "{t}");
    assert!(balance(&calm).abs() < 1e-3);
    let warm = solved(&text("temperature = 900"));
    assert!(row(&warm, "screen").power > 0.0 && balance(&warm).abs() < 1e-3);
}

#[test]
fn slab_of_gases_emits_by_band_fractions() {
    // Three gases at 1500 K between cold black plates: Σ a_b(T) (1 − 2 E₃(τ_b)) σT⁴.
    let smith = "weights = [[6.508e-1,-5.551e-4,3.029e-7,-5.353e-11], [-0.2504e-1,6.112e-4,-3.882e-7,6.528e-11], [2.718e-1,-3.118e-4,1.221e-7,-1.612e-11]]\nrange = [600, 2400]\nallow_partial = true";
    let text = slab(1.0, 4, [1.0, 1.0])
        .replace("extinction = 1", "extinction = [0.1, 1, 2]")
        .replace("heat_source = 0", "temperature = 1500")
        .replace("temperature = 1000", "temperature = 1e-2")
        .replace("temperature = 500", "temperature = 1e-2");
    let scene = read(&format!("{text}[thermal]\n{smith}\n"));
    let a = scene.thermal().unwrap().band_fractions.grey_gas_weights(1500.0);
    let s = solve(scene);
    let want: f64 = a.iter().zip([0.16741708, 0.78061607, 0.93973324]).map(|(a, e)| a * e).sum::<f64>()
        * blackbody_emissive_power(1500.0);
    for name in ["slab.z0", "slab.z1"] {
        let [q, e] = row(&s, name).flux();
        assert!((q + want).abs() < 1e-7 * want, "{q} ± {e}, {want}");
    }
    assert!((row(&s, "medium").power - 2.0 * want).abs() < 1e-7 * want);
}
