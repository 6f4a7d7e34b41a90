//! Temperatures: closed forms, published set-ups, laws, and bands that are coupled.

mod common;

use common::{add, mean, patches_of, read, solve, solved, surface, tetrahedron};
use zonal_math::{Vec3, vec3};
use zonal_scene::thermal::{STEFAN_BOLTZMANN, black, temperature};
use zonal_scene::{
    Engine, HeatRow, Known, Plate, Quiet, Scene, SceneParts, Shares, Solution, SolveStatus, Thermal, Voxmap,
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
        "mode = \"thermal\"\n[solve]\npatch_rule = \"voxels\"\nengine = \"{engine}\"\nthick_zones = \"constant\"\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [2,2,4] }}\ntemperature = 900\nemissivity = 0.7\nfaces.z0 = {{ temperature = 1200, emissivity = 0.85 }}\nfaces.z1 = {{ temperature = 400 }}\n[medium]\nmin = [0,0,0]\nmax = [2,2,4]\ncells = [{}, {}, {}]\nextinction = 0.5\nalbedo = {albedo}\nheat_source = 5000\n",
        2 * m,
        2 * m,
        4 * m
    )
}

#[test]
fn the_furnace_to_all_printed_digits() {
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
                assert_eq!(s.report.status, [SolveStatus::Converged; 3]);
            }
        }
    }
}

/// The zone of the cell that holds a point.
fn zone_at(s: &Solution, p: Vec3) -> usize {
    let map = s.scene.voxmap().unwrap();
    let cell = map.index(map.cell_at(p).unwrap());
    s.zones.voxel_offset() + s.zones.of_cell(cell).start
}

#[test]
fn temperatures_and_fluxes_along_the_furnace() {
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
    // Albedo 0.7: the same source function, other temperatures.
    let other = solved(&furnace(6, 0.7, "spectral"));
    let t =
        |s: &Solution, z: f64| s.fields.heat.as_ref().unwrap().temperature[zone_at(s, vec3(0.95, 0.95, z))];
    for (z, want) in [(0.4, [1057.0, 1079.0]), (2.0, [951.0, 980.0]), (3.6, [871.0, 908.0])] {
        // A zone is 17 cm high, and the table is for the point.
        assert!((t(&s, z) - want[0]).abs() < 4.0 && (t(&other, z) - want[1]).abs() < 4.0, "z = {z}");
    }
    let shift = 5000.0 / (4.0 * 0.5) * (1.0 / 0.3 - 1.0);
    let i = zone_at(&s, vec3(0.3, 1.1, 2.2));
    let of = |s: &Solution| black(s.fields.heat.as_ref().unwrap().temperature[i]);
    assert!((of(&other) - of(&s) - shift).abs() < 1e-6 * shift);
}

#[test]
fn rays_meet_the_furnace_within_their_errors() {
    let exact = solved(&furnace(2, 0.3, "dense"));
    let text = furnace(2, 0.3, "hierarchical").replace("[solve]", "[solve]\nclosure = \"restore\"");
    let s = solved(&text);
    for name in ["room.z0", "room.z1", "room.x0", "room.y1"] {
        let ([q, e], want) = (row(&s, name).flux(), flux(&exact, name));
        assert!((q - want).abs() <= e, "{name}: {q} ± {e}, exact {want}");
        // An error that says something: two per cent of what is exchanged.
        assert!(e < 0.1 * black(1200.0), "{name}: ± {e}");
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
fn slabs_in_radiative_equilibrium() {
    let plain = |text: String| text.replace("[solve]", "[solve]\nthick_zones = \"constant\"");
    let psi = |tau: f64, eps: [f64; 2]| {
        // The error falls with the square of the cells.
        let [a, b] = [24, 48].map(|n| flux(&solved(&plain(slab(tau, n, eps))), "slab.z0"));
        (b + (b - a) / 3.0) / (black(1000.0) - black(500.0))
    };
    for (tau, want) in [(0.2, 0.84917879), (1.0, 0.55340599), (3.0, 0.30164472)] {
        let black = psi(tau, [1.0, 1.0]);
        assert!((black - want).abs() < 1e-5, "τ = {tau}: {black}");
        let [e1, e2] = [0.8, 0.35];
        let grey = want / (1.0 + want * (1.0 / e1 + 1.0 / e2 - 2.0));
        assert!((psi(tau, [e1, e2]) - grey).abs() < 1e-5, "τ = {tau}");
    }
    // Slopes inside the cells do as well with few of them, grey or in bands that are coupled.
    for shares in [Shares::Grey, Shares::constant([0.5, 0.3, 0.2])] {
        let text = slab(1.0, 12, [1.0, 1.0]).replace("[solve]", "[solve]\nthick_zones = \"linear\"");
        let mut parts = read(&text).into_parts();
        parts.thermal.as_mut().unwrap().shares = shares;
        let s = solve(Scene::new(parts).unwrap());
        let psi = flux(&s, "slab.z0") / (black(1000.0) - black(500.0));
        assert!((psi - 0.55340599).abs() < 1e-5, "{psi}");
    }
    // Hardly a medium: two plates.
    let s = solved(&slab(1e-9, 1, [0.8, 0.35]));
    let want = (black(1000.0) - black(500.0)) / (1.0 / 0.8 + 1.0 / 0.35 - 1.0);
    assert!((flux(&s, "slab.z0") / want - 1.0).abs() < 1e-8);
}

#[test]
fn the_cube_in_equilibrium_is_its_scattering_analogue() {
    let cube = |mode: &str, walls: &str, rest: &str| {
        format!(
            "{mode}[solve]\npatch_rule = \"voxels\"\nengine = \"dense\"\nresidual = 1e-14\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\n{walls}\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [5, 5, 5]\nextinction = 1\n{rest}\n"
        )
    };
    let hot = temperature(1.0);
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

/// A room with a tetrahedron in it and a medium whose extinction varies, every look of chance, one temperature everywhere; what `skip`
/// picks is in equilibrium instead.
fn isothermal(seed: u64, t: f64, shares: Shares, skip: impl Fn(usize) -> bool) -> Scene {
    let mut dice = Dice(seed);
    let grey = shares.grey();
    let look = |dice: &mut Dice| {
        let r = [0; 3].map(|_| 0.95 * dice.next());
        if grey { [r[0]; 3] } else { r }
    };
    let mut parts = SceneParts::default();
    let (mut surfaces, mut k) = (Vec::new(), 0);
    let mut known = || {
        k += 1;
        if skip(k) { Known::Flux(0.0) } else { Known::Temperature(t) }
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
    let mut map = Voxmap::new(Vec3::ZERO, vec3(0.5, 0.5, 0.5), [4, 3, 2]).unwrap();
    for i in 0..map.len() {
        let kappa = [0; 3].map(|_| 2.0 * dice.next());
        let kappa = if grey { [kappa[0]; 3] } else { kappa };
        map.set(i, kappa, look(&mut dice), [0.0; 3], [0.0; 3]);
        map.set_heat(i, known(), Known::Flux(0.0));
    }
    parts.voxmap = Some(map.seal().unwrap());
    parts.options.patch_size = Some(0.5);
    parts.options.engine = Engine::Dense;
    parts.options.restore_closure = Some(true);
    parts.thermal = Some(Thermal { shares, surfaces, ..Thermal::default() });
    Scene::new(parts).unwrap()
}

fn falling() -> Shares {
    Shares::Weights {
        coefficients: [vec![0.5, -1e-4], vec![0.3, 2e-4, -3e-8], vec![0.2, -1e-4, 3e-8]],
        range: [300.0, 2500.0],
        left_out: false,
    }
}

#[test]
fn nothing_flows_where_all_is_equally_warm() {
    let t = 873.0;
    let every_third: fn(usize) -> bool = |k| k % 3 == 0;
    for (seed, shares) in
        [(1, Shares::Grey), (2, Shares::Grey), (3, Shares::constant([0.2, 0.3, 0.5])), (4, falling())]
    {
        for skip in [(|_| false) as fn(usize) -> bool, every_third, |k| k != 5] {
            let scene = isothermal(seed, t, shares.clone(), skip);
            let s = zonal_solve::solve(scene, 4 << 30, &Quiet).unwrap();
            let heat = s.fields.heat.as_ref().unwrap();
            // Closure is restored to a part in 1e13; a level that hangs on one wall is as good as the solver.
            for (i, (q, t1)) in heat.net.iter().zip(&heat.temperature).enumerate() {
                assert!(q.abs() < 1e-6 * black(t), "seed {seed}, zone {i}: {q} W/m²");
                assert!((t1 - t).abs() < 1e-5 * t, "seed {seed}, zone {i}: {t1} K");
            }
            assert_eq!(s.report.status, [SolveStatus::Converged; 3], "seed {seed}");
        }
    }
}

#[test]
fn net_powers_sum_to_zero() {
    for (seed, shares) in [(5, Shares::Grey), (6, Shares::constant([0.6, 0.4, 0.0])), (7, falling())] {
        let mut parts = isothermal(seed, 700.0, shares, |k| k % 4 == 0).into_parts();
        let t = parts.thermal.as_mut().unwrap();
        t.surfaces[0] = Known::Temperature(1400.0);
        t.surfaces[1] = Known::Power(5e3);
        t.surfaces[2] = Known::Flux(-2e3);
        let s = zonal_solve::solve(Scene::new(parts).unwrap(), 4 << 30, &Quiet).unwrap();
        assert!(balance(&s).abs() < 1e-8, "seed {seed}: {:e}", balance(&s));
        assert!((row(&s, "wall 1").power - 5e3).abs() < 1e-9);
        assert!((flux(&s, "wall 2") + 2e3).abs() < 1e-9);
        // The energy balance of the solution is that of the zones as they were found.
        for b in 0..3 {
            assert!(s.report.energy.residual[b].abs() < 1e-7, "{:?}", s.report.energy.residual);
        }
        // And B is what the zones emit and reflect.
        for i in 0..s.zones.len() {
            let (e, (r, _), h) = (s.zones.emission(i), s.zones.response(i), s.fields.incident[i]);
            for b in 0..3 {
                let x = s.fields.radiosity[i][b];
                assert!((e[b] + r[b] * h[b] - x).abs() < 1e-9 * x.abs().max(1.0), "zone {i}");
            }
        }
    }
}

#[test]
fn fluxes_and_temperatures_are_each_other_s_inverse() {
    let mut parts = isothermal(11, 600.0, falling(), |_| false).into_parts();
    parts.thermal.as_mut().unwrap().surfaces[3] = Known::Temperature(1500.0);
    let first = solve(Scene::new(parts.clone()).unwrap());
    // Patches of a wall give different fluxes, so cells are what can be turned round.
    let heat = first.fields.heat.clone().unwrap();
    let mut map = parts.voxmap.take().unwrap();
    for (k, v) in first.zones.voxels.iter().enumerate() {
        if first.zones.of_cell(v.cell).len() == 1 {
            map.set_heat(v.cell, Known::Flux(heat.net[first.zones.voxel_offset() + k]), Known::Flux(0.0));
        }
    }
    parts.voxmap = Some(map.seal().unwrap());
    parts.options.residual = 1e-12;
    let second = solve(Scene::new(parts).unwrap());
    let again = second.fields.heat.as_ref().unwrap();
    for (i, (t, u)) in heat.temperature.iter().zip(&again.temperature).enumerate() {
        assert!((t - u).abs() < 1e-6 * t, "zone {i}: {t} {u}");
    }
}

#[test]
fn a_convex_body_in_a_black_room() {
    // Whatever a convex body looks like, a black room around it sends σT⁴ to all of it.
    let mut parts = SceneParts::default();
    let room = isothermal(3, 400.0, Shares::Grey, |_| false);
    parts.surfaces = room.surfaces().to_vec();
    parts.facets = room.facets().to_vec();
    parts.surfaces.iter_mut().for_each(|s| s.reflectance = [0.0; 3]);
    parts.surfaces[6].reflectance = [0.37; 3];
    parts.options.patch_size = Some(0.25);
    parts.options.restore_closure = Some(true);
    let mut known = vec![Known::Temperature(400.0); 7];
    known[6] = Known::Temperature(900.0);
    parts.thermal = Some(Thermal { surfaces: known, ..Thermal::default() });
    let s = solve(Scene::new(parts).unwrap());
    let want = 0.63 * STEFAN_BOLTZMANN * (900.0f64.powi(4) - 400.0f64.powi(4));
    let [q, e] = row(&s, "body").flux();
    assert!((q / want - 1.0).abs() < 1e-9, "{q} ± {e}, {want}");
    assert!((q - want).abs() <= e.max(1e-9 * want));
}

#[test]
fn a_cavity_that_hardly_takes_heat_up_ends_at_the_temperature_of_what_warms_it() {
    // A step passes on nearly all that is there: what a single one brings is small long before the end.
    let text = "mode = \"thermal\"\n[solve]\nengine = \"hierarchical\"\ntolerance = 0.05\npatch_size = 0.5\n[[surface]]\nname = \"room\"\nroom = { min = [0,0,0], max = [1,1,1] }\nemissivity = 0.4\nheat_flux = 0\n[[surface]]\nname = \"core\"\nbox = { min = [0.4,0.4,0.4], max = [0.55,0.6,0.6] }\nemissivity = 0.1\ntemperature = 1100\n";
    let s = solved(text);
    let rows = &s.report.heat.as_ref().unwrap().rows;
    for row in rows.iter().filter(|r| r.name.starts_with("room")) {
        let (t, error) = (row.temperature.unwrap(), row.temperature_error.unwrap());
        assert!((t - 1100.0).abs() <= error && error < 200.0, "{}: {t} ± {error}", row.name);
        assert!((t - 1100.0).abs() < 1.0, "{}: {t}", row.name);
    }
}

#[test]
fn a_source_in_the_open_reaches_the_surroundings() {
    // A warm medium before surroundings of 300 K; the hierarchical engine and all pairs.
    let text = |engine: &str| {
        format!(
            "mode = \"thermal\"\nsurroundings.temperature = 300\n[solve]\nengine = \"{engine}\"\npatch_size = 0.25\n[[surface]]\nname = \"floor\"\nrectangle = {{ origin = [0,0,0], edge1 = [1,0,0], edge2 = [0,1,0] }}\nheat_flux = 0\nemissivity = 0.6\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [4, 4, 4]\nabsorption = 0.7\nheat_source = 2000\n"
        )
    };
    let dense = solved(&text("dense"));
    let heat = dense.report.heat.as_ref().unwrap();
    // All that the medium gives leaves.
    assert!((heat.surroundings + 2000.0).abs() < 20.0, "{}", heat.surroundings);
    let cold = black(300.0);
    assert!(row(&dense, "floor").temperature.is_some_and(|t| black(t) > cold));
    let rays = solved(&text("hierarchical"));
    let [a, b] = [&dense, &rays].map(|s| row(s, "medium").temperature.unwrap());
    assert!((a / b - 1.0).abs() < 0.01, "{a} {b}");
}

/// Three bands of water vapour and carbon dioxide, in part: polynomials after Smith, Shen and Friedman, the third band the rest.
fn gas() -> Shares {
    let a = vec![6.508e-1, -5.551e-4, 3.029e-7, -5.353e-11];
    let b = vec![-0.2504e-1, 6.112e-4, -3.882e-7, 6.528e-11];
    let mut rest: Vec<f64> = a.iter().zip(&b).map(|(a, b)| -a - b).collect();
    rest[0] += 1.0;
    Shares::Weights { coefficients: [a, b, rest], range: [600.0, 2400.0], left_out: false }
}

/// A cube with one hot wall, a cold one, an adiabatic one and a gas with sources; a wall is one patch.
fn gas_room(shares: Shares) -> SceneParts {
    let mut parts = read(
        "mode = \"thermal\"\n[solve]\npatch_size = 1.0\nengine = \"dense\"\nresidual = 1e-12\n[[surface]]\nname = \"room\"\nroom = { min = [0,0,0], max = [1,1,1] }\ntemperature = 700\nemissivity = 0.8\nfaces.z0.temperature = 1800\nfaces.x1.heat_flux = 0\nfaces.y0.heat_flux = 3000\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [3, 3, 3]\nextinction = 1\nheat_source = 2000\n",
    )
    .into_parts();
    for (k, s) in parts.surfaces.iter_mut().enumerate() {
        s.reflectance = [0.2, 0.1 + 0.05 * k as f64, 0.4];
    }
    let mut map = Voxmap::new(Vec3::ZERO, vec3(1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0), [3, 3, 3]).unwrap();
    for i in 0..map.len() {
        map.set(i, [0.4, 2.5, 0.0], [0.1, 0.3, 0.0], [0.0; 3], [0.0; 3]);
        map.set_heat(i, Known::Flux(if i % 2 == 0 { 2000.0 } else { 0.0 }), Known::Flux(0.0));
    }
    parts.voxmap = Some(map.seal().unwrap());
    parts.thermal.as_mut().unwrap().shares = shares;
    parts
}

/// Temperatures of the same room by light mode and a slow iteration: emit, solve each band, warm or cool every zone, again.
fn slowly(parts: &SceneParts) -> Vec<f64> {
    let thermal = parts.thermal.clone().unwrap();
    let shares = &thermal.shares;
    let map = parts.voxmap.clone().unwrap();
    let mut walls: Vec<f64> = vec![1200.0; 6];
    let mut cells: Vec<f64> = vec![1200.0; map.len()];
    for _ in 0..2000 {
        let mut light = parts.clone();
        light.thermal = None;
        for (k, s) in light.surfaces.iter_mut().enumerate() {
            if let Known::Temperature(t) = thermal.surfaces[k] {
                walls[k] = t;
            }
            let a = shares.weights(walls[k]);
            s.emission = [0, 1, 2].map(|b| (1.0 - s.reflectance[b]) * a[b] * black(walls[k]));
        }
        let mut shining = Voxmap::new(map.min(), map.cell(), map.dims()).unwrap();
        for i in 0..map.len() {
            let e = shares.weights(cells[i]).map(|a| a * black(cells[i]));
            shining.set(i, map.extinction(i), map.albedo(i), e, [0.0; 3]);
        }
        light.voxmap = Some(shining.seal().unwrap());
        let s = solve(Scene::new(light).unwrap());
        let mut moved: f64 = 0.0;
        // Bisection on the balance of a zone: Σ m a (a_b σT⁴ − h) = q.
        let warmed = |take: [f64; 3], h: [f64; 3], q: f64| {
            let (mut low, mut high) = (1.0f64, 5000.0f64);
            for _ in 0..100 {
                let t = 0.5 * (low + high);
                let a = shares.weights(t);
                let net: f64 = (0..3).map(|b| take[b] * (a[b] * black(t) - h[b])).sum();
                if net < q { low = t } else { high = t }
            }
            0.5 * (low + high)
        };
        for (i, p) in s.zones.patches.iter().enumerate() {
            if let Known::Flux(q) = thermal.surfaces[p.surface] {
                let t = warmed(p.reflectance.map(|r| 1.0 - r), s.fields.incident[i], q);
                moved = moved.max((t - walls[p.surface]).abs());
                walls[p.surface] = t;
            }
        }
        for (k, v) in s.zones.voxels.iter().enumerate() {
            let g = s.fields.incident[s.zones.voxel_offset() + k];
            let take = [0, 1, 2].map(|b| 4.0 * v.extinction[b] * (1.0 - v.albedo[b]));
            let Some(Known::Flux(q)) = map.heat(v.cell) else { unreachable!() };
            let t = warmed(take, g.map(|g| 0.25 * g), q);
            moved = moved.max((t - cells[v.cell]).abs());
            cells[v.cell] = t;
        }
        if moved < 1e-8 {
            walls.extend(cells);
            return walls;
        }
    }
    panic!("the slow iteration did not end");
}

#[test]
fn coupled_bands_end_where_a_slow_iteration_ends() {
    for shares in [gas(), Shares::constant([0.25, 0.35, 0.4])] {
        let parts = gas_room(shares.clone());
        let want = slowly(&parts);
        let s = solve(Scene::new(parts).unwrap());
        let kelvin = &s.fields.heat.as_ref().unwrap().temperature;
        assert_eq!(s.zones.patches.len(), 6);
        for (i, (t, w)) in kelvin.iter().zip(&want).enumerate() {
            assert!((t - w).abs() < 1e-6, "zone {i}: {t} K, slowly {w} K");
        }
        assert_eq!(s.report.status, [SolveStatus::Converged; 3]);
        let steps = s.report.residuals[0].len();
        assert!(steps <= if shares.is_constant() { 1 } else { 8 }, "{steps} steps");
        assert!(balance(&s).abs() < 1e-10, "{:e}", balance(&s));
    }
}

#[test]
fn bands_that_are_alike_are_the_grey_scene() {
    // The same optics in each band: how they share the emission is all one, constant or not.
    let text = furnace(2, 0.4, "dense");
    let grey = solved(&text);
    for shares in [Shares::constant([0.2, 0.5, 0.3]), falling(), gas()] {
        for engine in [Engine::Dense, Engine::Spectral, Engine::Hierarchical] {
            let mut parts = read(&text).into_parts();
            parts.thermal.as_mut().unwrap().shares = shares.clone();
            parts.options.engine = engine;
            let s = solve(Scene::new(parts).unwrap());
            let close = if engine == Engine::Hierarchical { 0.03 } else { 1e-8 };
            for name in ["room.z0", "room.z1", "room.y1"] {
                let (a, b) = (flux(&s, name), flux(&grey, name));
                assert!((a - b).abs() < close * 54e3, "{engine:?} {name}: {a} {b}");
            }
            assert_eq!(s.report.status, [SolveStatus::Converged; 3], "{engine:?} {shares:?}");
        }
    }
}

#[test]
fn what_has_no_temperature_is_said() {
    let room = |look: &str, rest: &str| {
        format!(
            "mode = \"thermal\"\n[solve]\npatch_size = 0.5\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\n{look}\n{rest}"
        )
    };
    // Nothing fixes the level.
    let e =
        zonal_solve::solve(read(&room("heat_flux = 0\nemissivity = 0.5", "")), 4 << 30, &Quiet).unwrap_err();
    assert!(e.to_string().contains("nothing fixes the level"), "{e}");
    // A perfect mirror passes on what it gets and has no temperature.
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
    // Heat that is not there.
    let s = solved(&room(
        "temperature = 300\nemissivity = 1\nfaces.x0 = { heat_flux = -5000, emissivity = 1 }",
        "",
    ));
    assert!(s.report.warnings.iter().any(|w| w.contains("more heat is taken")), "{:?}", s.report.warnings);
    assert!(s.fields.heat.as_ref().unwrap().temperature.iter().any(|t| t.is_nan()));
    // What absorbs only where nothing is emitted; no word of powers, of which none is negative.
    let s = solved(&room(
        "temperature = 600\nemissivity = [0.2, 0.5, 0.9]",
        "[thermal]\nshares = [0, 0, 1]\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [2,2,2]\nextinction = [1, 4, 0]\nheat_source = 0",
    ));
    let notes = &s.report.warnings;
    assert!(notes.iter().any(|w| w.contains("8 zones emit in no band")), "{notes:?}");
    assert!(!notes.iter().any(|w| w.contains("negative")), "{notes:?}");
}

#[test]
fn panes_are_warm_or_in_equilibrium() {
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
fn a_slab_of_gases_emits_by_their_weights() {
    // Three gases at 1500 K between cold black plates: Σ a_b(T) (1 − 2 E₃(τ_b)) σT⁴.
    let smith = "weights = [[6.508e-1,-5.551e-4,3.029e-7,-5.353e-11], [-0.2504e-1,6.112e-4,-3.882e-7,6.528e-11], [2.718e-1,-3.118e-4,1.221e-7,-1.612e-11]]\nrange = [600, 2400]\nleft_out = true";
    let text = slab(1.0, 4, [1.0, 1.0])
        .replace("extinction = 1", "extinction = [0.1, 1, 2]")
        .replace("heat_source = 0", "temperature = 1500")
        .replace("temperature = 1000", "temperature = 1e-2")
        .replace("temperature = 500", "temperature = 1e-2");
    let scene = read(&format!("{text}[thermal]\n{smith}\n"));
    let a = scene.thermal().unwrap().shares.weights(1500.0);
    let s = solve(scene);
    let want: f64 =
        a.iter().zip([0.16741708, 0.78061607, 0.93973324]).map(|(a, e)| a * e).sum::<f64>() * black(1500.0);
    for name in ["slab.z0", "slab.z1"] {
        let [q, e] = row(&s, name).flux();
        assert!((q + want).abs() < 1e-7 * want, "{q} ± {e}, {want}");
    }
    assert!((row(&s, "medium").power - 2.0 * want).abs() < 1e-7 * want);
}

#[test]
fn threads_do_not_change_a_bit() {
    let heat = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solve(Scene::new(gas_room(gas())).unwrap()).fields.heat.unwrap())
    };
    assert_eq!(heat(1), heat(3));
}
