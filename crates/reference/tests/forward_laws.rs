//! Walks from the sources against laws of the textbooks.

use std::path::Path;
use zonal_reference::Estimate;
use zonal_reference::forward::{Answer, Closed, answer};
use zonal_scene::thermal::black;
use zonal_scene::{Patch, Scene, VoxelZone, Zones};

const WALKS: usize = 100_000;
/// E₃(1).
const E3_OF_1: f64 = 0.109_691_967_0;
/// Flux between black walls about a grey layer of optical depth 1 in radiative equilibrium, over the difference of their emissive powers
/// (Heaslet and Warming 1965).
const LAYER: f64 = 0.5534;

/// A layer between black walls of 1000 and 500 K, endless along x and y.
fn layer(cells: usize, lines: &str, shares: &str) -> Scene {
    let text = format!(
        "mode = \"thermal\"\n{shares}\n[boundary]\nx = \"periodic\"\ny = \"periodic\"\n[solve]\npatch_rule = \"voxels\"\n\
         [[surface]]\nname = \"w\"\nroom = {{ min = [0, 0, 0], max = [1, 1, 1] }}\nomit = [\"x0\", \"x1\", \"y0\", \"y1\"]\nemissivity = 1\n\
         faces.z0 = {{ temperature = 1000 }}\nfaces.z1 = {{ temperature = 500 }}\n\
         [medium]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\ncells = [1, 1, {cells}]\n{lines}\n"
    );
    scene(&text)
}

fn scene(text: &str) -> Scene {
    zonal_io::input::parse_scene(text, None::<&Path>, "law.toml").unwrap_or_else(|e| panic!("{e}"))
}

fn near(what: &str, e: Estimate, exact: f64) {
    let far = (e.value - exact).abs() / (4.0 * e.error + 1e-6 * exact.abs());
    assert!(far <= 1.0, "{what}: {} ± {}, not {exact}", e.value, e.error);
}

fn ask(scene: &Scene, zones: Option<&Zones>) -> Answer {
    answer(scene, &Closed::default(), zones, WALKS, 7)
}

#[test]
fn next_to_nothing_between_endless_walls_takes_nothing() {
    for kappa in ["1e-12", "1e-9"] {
        let found = ask(&layer(3, &format!("extinction = {kappa}\nheat_source = 0"), ""), None);
        near("z0", found.heat[0].power, black(1000.0) - black(500.0));
        near("z1", found.heat[1].power, black(500.0) - black(1000.0));
    }
}

#[test]
fn a_layer_in_radiative_equilibrium_in_one_band_and_in_two_that_are_alike() {
    let gap = black(1000.0) - black(500.0);
    for shares in ["", "[thermal]\nshares = [0.3, 0.7, 0]"] {
        let found = ask(&layer(2, "extinction = 1\nheat_source = 0", shares), None);
        let flux = found.heat[0].power;
        assert!((flux.value / gap - LAYER).abs() < 4.0 * flux.error / gap + 5e-5, "{flux:?}");
        let mean = found.heat[2].emissive.expect("the medium has a temperature");
        near("mean emissive power", mean, 0.5 * (black(1000.0) + black(500.0)));
    }
}

#[test]
fn the_equations_of_one_zone_are_solved_exactly() {
    // Of one zone all is even: half of what it takes goes either way.
    let s = layer(1, "extinction = 1\nheat_source = 0", "");
    let found = ask(&s, Some(&three_zones(&s)));
    near("z0", found.heat[0].power, (0.5 + E3_OF_1) * (black(1000.0) - black(500.0)));
}

/// The zones of a layer of one cell: two walls and the cell.
fn three_zones(s: &Scene) -> Zones {
    let patch = |k: usize| {
        let plate = s.facets()[k].plate;
        let (surface, normal, area) = (s.facets()[k].surface, plate.normal(), plate.area());
        Patch { facet: k, surface, plate, normal, area, reflectance: [0.0; 3], emission: [0.0; 3] }
    };
    let voxel = VoxelZone {
        cell: 0,
        centre: zonal_math::vec3(0.5, 0.5, 0.5),
        volume: 1.0,
        part: Default::default(),
        extinction: [1.0; 3],
        albedo: [0.0; 3],
        emission: [0.0; 3],
        source: [0.0; 3],
    };
    Zones { patches: vec![patch(0), patch(1)], voxels: vec![voxel], panes: Vec::new(), first: vec![0, 1] }
}

#[test]
fn where_all_is_equally_warm_nothing_flows_whatever_stands_in_it() {
    let s = scene(
        "mode = \"thermal\"\nsurroundings.temperature = 800\n\
         [[surface]]\nname = \"floor\"\nrectangle = { origin = [0, 0, 0], edge1 = [2, 0, 0], edge2 = [0, 2, 0] }\nemissivity = 0.6\ntemperature = 800\nsides = \"both\"\n\
         [[surface]]\nname = \"block\"\nbox = { min = [0.5, 0.5, 0.2], max = [1, 1.2, 0.8], rotate_z_degrees = 20 }\nemissivity = 0.3\nheat_flux = 0\n\
         [[pane]]\nname = \"glass\"\npolygon = [[1.5, 0, 0.1], [1.5, 2, 0.1], [1.6, 2, 1], [1.6, 0, 1]]\nthickness = 0.01\nextinction = 70\nalbedo = 0.4\n\
         [medium]\nmin = [0, 0, 0]\nmax = [2, 2, 1]\ncells = [3, 2, 2]\nextinction = 0.7\nalbedo = 0.2\ntemperature = 800\n",
    );
    let found = ask(&s, None);
    near("floor", found.heat[0].power, 0.0);
    near("block", found.heat[1].emissive.expect("the block has a temperature"), black(800.0));
    near("glass", found.heat[3].emissive.expect("the pane has a temperature"), black(800.0));
    let gas = found.heat[2].power;
    assert!(gas.value.abs() < 4.0 * gas.error + 0.01 * black(800.0), "{gas:?}");
}

#[test]
fn what_is_not_sampled_of_a_thin_layer_that_shines_is_in_its_error() {
    const EULER: f64 = 0.577_215_664_901_532_9;
    for (kappa, sampled) in [(1e-3, true), (1e-7, false), (1e-11, false)] {
        let s = layer(1, &format!("extinction = {kappa:e}\nheat_source = 1e5"), "");
        let mut zones = three_zones(&s);
        zones.voxels[0].extinction = [kappa; 3];
        let g = ask(&s, Some(&zones)).zones[2][0];
        // Mean of 1e5/2 ∫ E1(κ|z − z'|) dz' over the layer, thin, and what the walls send through it.
        let exact = 0.5e5 * (1.5 - EULER - kappa.ln()) + 2.0 * (black(1000.0) + black(500.0));
        assert!(
            (g.value - exact).abs() <= 4.0 * g.error + 2.0 * kappa * exact,
            "{kappa:e}: {g:?}, not {exact}"
        );
        assert_eq!(g.error < 0.03 * exact, sampled, "{kappa:e}: {g:?}, not {exact}");
    }
}
