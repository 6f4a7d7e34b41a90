//! The layered engine: an independent code for slabs, the spectral engine, subdivision, reciprocity, closure and refusals.

use crate::common;

use common::{read, solve, unlevels};
use zonal_math::Grade;
use zonal_reference::slab::{BandEmission, BandSolution, Equilibrium, Slab, SlabBand, SlabCondition};
use zonal_scene::{
    Band, Bands, Engine, NoProgress, Scene, SceneError, Solution, ThermalCondition, VoxelGrid,
};
use zonal_solve::engines::layered::{LayerStack, LayeredOperator};
use zonal_solve::operator::ExchangeOperator;
use zonal_transport::{Transport, build_zones};

/// A layer: extinction in each band, albedo, emission.
type Layer = ([f64; 3], f64, f64);

const LAYERS: [Layer; 6] = [
    ([0.0, 0.3, 2.0], 0.3, 2.0),
    ([0.0, 7.0, 1e-9], 0.0, 0.5),
    ([0.0, 0.0, 0.4], 0.9, 1.0),
    ([0.0, 0.0, 0.6], 0.5, 3.0),
    ([0.0, 1e-12, 40.0], 0.2, 0.0),
    ([0.0, 2.5, 1.0], 1.0, 1.0),
];
const REFLECTANCES: [f64; 2] = [0.4, 0.7];
const WALL_EMISSIONS: [f64; 2] = [3.0, 1.0];
/// Relative accuracy of the discrete ordinates behind eight mean free paths.
const ORDINATES_LIMIT: f64 = 1e-10;
/// Edges of a period and thickness of the slab, m.
const SIZE: [f64; 3] = [0.7, 1.1, 1.2];

/// A scene with the cells that `set` changes.
fn with_cells(scene: Scene, set: impl Fn(&mut VoxelGrid, usize)) -> Scene {
    let mut parts = scene.into_parts();
    parts.voxel_grid = parts.voxel_grid.map(|mut map| {
        (0..map.len()).for_each(|i| set(&mut map, i));
        map.seal().unwrap()
    });
    Scene::new(parts).unwrap_or_else(|e| panic!("{e}"))
}

/// A slab across `axis` with these cells along the periodic axes, every layer cut in `parts`, without the walls in `omit`.
fn slab(axis: usize, across: usize, parts: usize, omit: &[usize]) -> Scene {
    let (mut size, mut cells) = ([0.0; 3], [across; 3]);
    for k in 0..3 {
        size[(axis + 1 + k) % 3] = SIZE[k];
    }
    cells[axis] = LAYERS.len() * parts;
    let name = |k: usize| ["x", "y", "z"][k];
    let others = (0..3).filter(|k| *k != axis);
    let periodic: String = others.clone().map(|k| format!("{} = \"periodic\"\n", name(k))).collect();
    let mut without: Vec<String> = others.flat_map(|k| [0, 1].map(|s| format!("{}{s}", name(k)))).collect();
    without.extend(omit.iter().map(|s| format!("{}{s}", name(axis))));
    let faces = |s: usize| {
        let [r, e] = [REFLECTANCES[s], WALL_EMISSIONS[s]];
        format!("faces.{}{s} = {{ reflectance = {r}, emission = {e} }}\n", name(axis))
    };
    let walls: String = [0, 1].into_iter().filter(|s| !omit.contains(s)).map(faces).collect();
    let surface = format!(
        "[[surface]]\nname = \"w\"\nroom = {{ min = [0,0,0], max = {size:?} }}\nomit = {without:?}\nreflectance = 0.5\n{walls}"
    );
    let surface = if omit.len() < 2 { surface } else { String::new() };
    let scene = read(&format!(
        "[solve]\npatch_rule = \"voxels\"\nresidual = 1e-14\n[boundary]\n{periodic}{surface}[medium]\nmin = [0,0,0]\nmax = {size:?}\ncells = {cells:?}\nextinction = 1\nalbedo = 0.5\n"
    ));
    with_cells(scene, |map, i| {
        let (k, albedo, emission) = LAYERS[map.coordinates(i)[axis] / parts];
        map.set(i, Bands::from_rgb(k), Bands::splat(albedo), Bands::splat(emission), Bands::ZERO);
    })
}

/// The same slab by discrete ordinates, one solution a band; open ends are black and cold.
fn oracle(parts: usize, omit: &[usize]) -> Vec<BandSolution> {
    let n = LAYERS.len() * parts;
    let layer = |i: usize| LAYERS[i / parts];
    let is_open = |s: &usize| omit.contains(s);
    let emissivity = [0, 1].map(|s| if is_open(&s) { 1.0 } else { 1.0 - REFLECTANCES[s] });
    let band = |b: usize| SlabBand {
        extinction: (0..n).map(|i| layer(i).0[b]).collect(),
        albedo: (0..n).map(|i| layer(i).1).collect(),
        wall_emissivity: emissivity,
    };
    // A patch emits E, the wall of the other code ε times its emission.
    let walls = [0, 1].map(|s| if is_open(&s) { 0.0 } else { WALL_EMISSIONS[s] / emissivity[s] });
    let emission = BandEmission { layers: (0..n).map(|i| layer(i).2).collect(), walls };
    let slab = Slab { thickness: vec![SIZE[2] / n as f64; n], bands: (0..3).map(band).collect() };
    slab.solve(&[emission.clone(), emission.clone(), emission])
}

/// Irradiances of the walls that exist, from the lower one on, then fluences by layer, in a band: first zone of each.
fn by_layer(s: &Solution, axis: usize, b: Band) -> (Vec<f64>, Vec<f64>) {
    let map = s.scene.voxel_grid().unwrap();
    let mut walls: Vec<(f64, f64)> = Vec::new();
    for (i, p) in s.zones.patches.iter().enumerate() {
        let at = p.plate.bounds().0[axis];
        if walls.iter().all(|w| w.0 != at) {
            walls.push((at, s.fields.incident[i][b]));
        }
    }
    walls.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut layers = vec![0.0; map.dims()[axis]];
    for (i, v) in s.zones.voxels.iter().enumerate() {
        layers[map.coordinates(v.cell)[axis]] = s.fields.incident[s.zones.voxel_offset() + i][b];
    }
    (walls.into_iter().map(|w| w.1).collect(), layers)
}

fn assert_close(got: &[f64], want: &[f64], limit: f64, what: &str) {
    assert_eq!(got.len(), want.len(), "{what}");
    for (k, (x, y)) in got.iter().zip(want).enumerate() {
        assert!((x - y).abs() <= limit * y.abs(), "{what}, {k}: {x} {y}");
    }
}

// Guards (numbers): the layered engine agrees with discrete ordinates to 1e-10.
#[test]
fn slabs_of_layers_agree_with_discrete_ordinates() {
    for (axis, across, omit) in [(2, 1, &[][..]), (0, 2, &[1]), (1, 3, &[0]), (2, 1, &[0, 1])] {
        let s = solve(slab(axis, across, 1, omit));
        assert_eq!(s.report.engine, "layered");
        assert_eq!(s.report.reason, "6 layers of different extinction, periodic along two axes");
        let ends: Vec<usize> = [0, 1].into_iter().filter(|k| !omit.contains(k)).collect();
        for (b, want) in Band::all().zip(oracle(1, omit)) {
            let what = format!("axis {axis}, {across} cells, without {omit:?}, {b:?}");
            let (walls, layers) = by_layer(&s, axis, b);
            let irradiance: Vec<f64> = ends.iter().map(|k| want.wall_incident[*k]).collect();
            assert_close(&walls, &irradiance, ORDINATES_LIMIT, &what);
            assert_close(&layers, &want.incident, ORDINATES_LIMIT, &what);
        }
        assert!(s.report.closure.worst.iter().all(|d| *d < 1e-12), "{:?}", s.report.closure);
        assert!(s.report.energy.residual.iter().all(|r| r.abs() < 1e-11), "{:?}", s.report.energy);
    }
}

/// The zones of a layer need not have equal radiosities for a symmetric operator with closed rows.
#[test]
fn layered_operator_is_symmetric_and_closed() {
    let scene = slab(2, 2, 1, &[]);
    let zones = build_zones(&scene, &Transport::new(&scene)).unwrap();
    let stack = LayerStack::find(&scene, &zones).unwrap();
    let operator = LayeredOperator::new(stack, &NoProgress);
    let vector = |seed: usize| -> Vec<Bands> {
        (0..zones.len()).map(|i| Bands::splat(1.0 + ((i * 7 + seed) % 11) as f64)).collect()
    };
    let product = |x: &[Bands], y: &[Bands]| {
        let g = operator.apply(x);
        g.iter().zip(y).fold(Bands::ZERO, |sum, (g, y)| sum + *g * *y)
    };
    let (x, y) = (vector(0), vector(5));
    let (a, b) = (product(&x, &y), product(&y, &x));
    assert!((a / b - 1.0).abs().all(|d| d < 1e-14), "{a:?} {b:?}");
}

/// Layers of equal radiosity, cut in three, change nothing.
#[test]
fn layers_cut_in_three_have_the_same_walls() {
    let uniform = |parts: usize| {
        solve(with_cells(slab(2, 1, parts, &[]), |map, i| {
            let (k, ..) = LAYERS[map.coordinates(i)[2] / parts];
            map.set(i, Bands::from_rgb(k), Bands::ZERO, Bands::ONE, Bands::ZERO);
        }))
    };
    let (whole, parts) = (uniform(1), uniform(3));
    for b in Band::all() {
        let [(walls, layers), (walls_of_parts, layers_of_parts)] =
            [&whole, &parts].map(|s| by_layer(s, 2, b));
        assert_close(&walls_of_parts, &walls, 1e-12, "walls");
        let means: Vec<f64> = layers_of_parts.chunks(3).map(|g| g.iter().sum::<f64>() / 3.0).collect();
        assert_close(&means, &layers, 1e-12, "layers");
    }
}

// Guards (numbers): the layered engine agrees with the spectral engine to 1e-11.
#[test]
fn uniform_layers_agree_with_the_spectral_engine() {
    for (kappa, omit) in [(0.7, &[][..]), (1e-9, &[][..]), (5.0, &[1][..])] {
        let [layered, spectral] = [Engine::Layered, Engine::Spectral].map(|engine| {
            let scene = with_cells(slab(2, 2, 1, omit), |map, i| {
                let (_, albedo, emission) = LAYERS[map.coordinates(i)[2]];
                let [albedo, emission] = [albedo, emission].map(Bands::splat);
                map.set(i, Bands::splat(kappa), albedo, emission, Bands::ZERO);
            });
            let mut scene = scene.into_parts();
            (scene.options.engine, scene.options.zone_basis) = (engine, zonal_scene::ZoneBasis::Constant);
            solve(Scene::new(scene).unwrap())
        });
        assert_eq!(
            (layered.report.engine.as_str(), spectral.report.engine.as_str()),
            ("layered", "spectral")
        );
        for (i, (x, y)) in layered.fields.incident.iter().zip(&spectral.fields.incident).enumerate() {
            assert!((*x / *y - 1.0).abs().all(|d| d < 1e-11), "{kappa} {i}: {x:?} {y:?}");
        }
        assert!((layered.report.energy.escaped - spectral.report.energy.escaped).abs().all(|d| d < 1e-11));
    }
}

#[test]
fn isothermal_layers_are_uniform() {
    let mut scene = slab(1, 2, 2, &[]).into_parts();
    scene.surfaces.iter_mut().for_each(|s| {
        (s.reflectance, s.emission) = (Bands::splat(0.25), Bands::splat(1.5));
    });
    let s = solve(with_cells(Scene::new(scene).unwrap(), |map, i| {
        let (k, albedo, _) = LAYERS[map.coordinates(i)[1] / 2];
        map.set(i, Bands::from_rgb(k), Bands::splat(albedo), Bands::splat(2.0), Bands::ZERO);
    }));
    for (i, off) in unlevels(&s, 2.0).iter().enumerate() {
        assert!(*off < 1e-11, "{i}: {off:e}");
    }
}

/// Black-body fractions of two grey gases and the rest.
fn weight(b: usize, t: f64) -> f64 {
    let first = 0.6508 - 0.0005551 * t + 3.029e-7 * t * t - 5.353e-11 * t.powi(3);
    let second = -0.02504 + 0.0006112 * t - 3.882e-7 * t * t + 6.528e-11 * t.powi(3);
    [first, second, 1.0 - first - second][b]
}

/// Layers of gas without net power, of given net power and of given temperature, between plates, one of them adiabatic.
#[test]
fn temperatures_of_layers_agree_with_discrete_ordinates() {
    let absorption = [[0.2, 3.0, 0.0], [0.5, 1.0, 0.0], [1.5, 0.0, 0.0], [0.1, 6.0, 0.0], [0.8, 0.8, 0.0]];
    let n = absorption.len();
    let text = format!(
        "mode = \"thermal\"\n[solve]\npatch_rule = \"voxels\"\nresidual = 1e-12\n[thermal]\nweights = [[0.6508, -0.0005551, 3.029e-07, -5.353e-11], [-0.02504, 0.0006112, -3.882e-07, 6.528e-11], \"rest\"]\nrange = [600, 2400]\n[boundary]\nx = \"periodic\"\ny = \"periodic\"\n[[surface]]\nname = \"d\"\nroom = {{ min = [0,0,0], max = [1,1,2] }}\nomit = [\"x0\", \"x1\", \"y0\", \"y1\"]\nheat_flux = 0\nemissivity = 0.6\nfaces.z0 = {{ temperature = 1500, emissivity = 0.9 }}\n[medium]\nmin = [0,0,0]\nmax = [1,1,2]\ncells = [1, 1, {n}]\nabsorption = [1, 1, 1]\nheat_source = 0\n"
    );
    let conditions = [
        SlabCondition::NetPower(0.0),
        SlabCondition::Temperature(900.0),
        SlabCondition::NetPower(2e4),
        SlabCondition::NetPower(0.0),
        SlabCondition::NetPower(-1e4),
    ];
    let s = solve(with_cells(read(&text), |map, i| {
        map.set(i, Bands::from_rgb(absorption[i]), Bands::ZERO, Bands::ZERO, Bands::ZERO);
        let heat = match conditions[i] {
            SlabCondition::Temperature(t) => ThermalCondition::Temperature(t),
            SlabCondition::NetPower(p) => ThermalCondition::Flux(p),
        };
        map.set_heat(i, heat, ThermalCondition::Flux(0.0));
    }));
    assert_eq!(s.report.engine, "layered");
    let band = |b: usize| SlabBand {
        extinction: absorption.iter().map(|k| k[b]).collect(),
        albedo: vec![0.0; n],
        wall_emissivity: [0.9, 0.6],
    };
    let slab = Slab { thickness: vec![2.0 / n as f64; n], bands: (0..3).map(band).collect() };
    let walls = [SlabCondition::Temperature(1500.0), SlabCondition::NetPower(0.0)];
    let want: Equilibrium = slab.equilibrium(&conditions, walls, &|_, b, t| weight(b, t)).unwrap();
    let got = &s.fields.heat.as_ref().unwrap().temperature;
    for (i, v) in s.zones.voxels.iter().enumerate() {
        let [x, y] = [got[s.zones.voxel_offset() + i], want.layer_temperatures[v.cell]];
        assert!((x - y).abs() < 1e-6, "{i}: {x} {y}");
    }
}

#[test]
fn scenes_that_are_no_layers_are_refused_with_a_reason() {
    let error = |change: &dyn Fn(&mut zonal_scene::SceneParts)| -> String {
        let mut scene = slab(2, 2, 1, &[]).into_parts();
        change(&mut scene);
        let refused = |e: SceneError| e.to_string();
        let scene = match Scene::new(scene) {
            Ok(scene) => scene,
            Err(e) => return refused(e),
        };
        zonal_solve::solve(scene, 4 << 30, &NoProgress).map(|_| String::new()).unwrap_or_else(refused)
    };
    assert_eq!(error(&|_| ()), "");
    let one_cell = |s: &mut zonal_scene::SceneParts, k: [f64; 3], emission: f64| {
        let map = s.voxel_grid.as_mut().unwrap();
        map.set(0, Bands::from_rgb(k), Bands::splat(0.3), Bands::splat(emission), Bands::ZERO);
    };
    let varied = error(&|s| one_cell(s, [1.0; 3], 2.0));
    assert!(
        varied.contains("one extinction everywhere or, with two periodic axes, in each layer"),
        "{varied}"
    );
    let hot = error(&|s| one_cell(s, LAYERS[0].0, 5.0));
    assert!(hot.contains("the medium varies within layer 0, along a periodic axis"), "{hot}");
    for engine in [Engine::Dense, Engine::Spectral, Engine::Rays] {
        let other = error(&|s| s.options.engine = engine);
        assert!(other.contains("use \"layered\", or \"auto\""), "{other}");
    }
    let basis = error(&|s| s.options.zone_basis = zonal_scene::ZoneBasis::Linear);
    assert!(basis.contains("use \"constant\" and more layers"), "{basis}");
    let room = "[solve]\nengine = \"layered\"\n[[surface]]\nname = \"r\"\nroom = { min = [0,0,0], max = [1,1,1] }\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [2,2,2]\nextinction = 1\n";
    let closed = zonal_solve::solve(read(room), 4 << 30, &NoProgress).map(|_| ()).unwrap_err().to_string();
    assert!(closed.contains("the scene is not periodic along two axes"), "{closed}");
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let incident = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solve(slab(2, 2, 3, &[1])).fields.incident)
    };
    assert_eq!(incident(1), incident(3));
}

#[test]
fn stated_errors_of_layers_are_those_of_rounding() {
    let s = solve(slab(2, 1, 1, &[]));
    assert_eq!(s.report.grade, Grade::Proved);
    for (i, (h, e)) in s.fields.incident.iter().zip(&s.fields.error).enumerate() {
        assert!(Band::all().all(|b| e[b] > 0.0 && e[b] < 1e-11 * h[b]), "{i}: {h:?} ± {e:?}");
    }
}

/// Two endless plates with panes between them: symmetry planes, periods, several panes, a pane that divides a cell, and the same panes as cells.
fn glass(sides: &str, cells: usize, panes: &[(f64, f64)], medium: &str) -> String {
    let pane = |(k, (z, extinction)): (usize, &(f64, f64))| {
        format!(
            "[[pane]]\nname = \"glass {k}\"\npolygon = [[0,0,{z}], [1,0,{z}], [1,1,{z}], [0,1,{z}]]\nthickness = 0.008\nextinction = {extinction}\ntemperature = 300\n"
        )
    };
    let panes: String = panes.iter().enumerate().map(pane).collect();
    format!(
        "mode = \"thermal\"\n[solve]\npatch_rule = \"voxels\"\n[boundary]\nx = \"{sides}\"\ny = \"{sides}\"\n[[surface]]\nname = \"wall\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\nomit = [\"x0\", \"x1\", \"y0\", \"y1\"]\nemissivity = 1\ntemperature = 300\nfaces.z1.temperature = 900\n{panes}[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [1, 1, {cells}]\n{medium}\n"
    )
}

#[test]
fn panes_between_endless_plates_are_layers() {
    let rows = |text: &str| {
        let s = solve(common::read(text));
        assert_eq!(s.report.engine, "layered");
        s.report.heat.unwrap().rows
    };
    for sides in ["symmetry", "periodic"] {
        // At a boundary of cells, and in the middle of one.
        for (cells, position) in [(10, 0.3), (10, 0.35), (3, 0.3)] {
            let found = rows(&glass(sides, cells, &[(position, 60.0)], "extinction = 0"));
            assert!((found[0].power + 16773.7096).abs() < 1e-3, "{sides} {cells} {position}: {found:?}");
            let pane = found.last().unwrap();
            assert!((pane.power + 19970.3167).abs() < 1e-3 && pane.power_error.is_finite(), "{pane:?}");
        }
        // Two panes in a gas: cells of their thickness, beside which the gas keeps its depth.
        let two =
            rows(&glass(sides, 10, &[(0.3, 60.0), (0.72, 15.0)], "extinction = 1e-9\ntemperature = 300"));
        let as_one = rows(&glass(sides, 10, &[(0.5, 75.0)], "extinction = 1e-9\ntemperature = 300"));
        assert!((two[0].power / as_one[0].power - 1.0).abs() < 1e-6, "{two:?} {as_one:?}");
    }
    // A pane that fills the period in part, and panes along one endless axis, have a remedy.
    let refused =
        |text: &str| zonal_solve::solve(common::read(text), 1 << 30, &NoProgress).unwrap_err().to_string();
    let part = glass("symmetry", 10, &[(0.3, 60.0)], "extinction = 0")
        .replace("[1,1,0.3], [0,1,0.3]", "[1,0.5,0.3], [0,0.5,0.3]");
    assert!(refused(&part).contains("extend it over the whole period"), "{}", refused(&part));
    let one_axis = glass("symmetry", 10, &[(0.3, 60.0)], "extinction = 0")
        .replace("y = \"symmetry\"", "")
        .replace(", \"y0\", \"y1\"]", "]");
    assert!(refused(&one_axis).contains("give one end a symmetry plane"), "{}", refused(&one_axis));
}
